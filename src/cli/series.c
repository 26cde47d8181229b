#include "cli/series.h"

#include "cli/rendering.h"
#include "image/image.h"
#include "render/film.h"
#include "render/picture_cache.h"
#include "scene/mesh_cache.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char records[] = ".records"; // the folder in the folder

// --- Names ---------------------------------------------------------------------------------------

const char *series_default_name(const Options *options, Arena *arena, const char *ending)
{
    const char *scene = options->operand;
    const char *name = arena_printf(arena, "%.*s%s", (int)stem_length(scene), scene, ending);
    if (!name) {
        complain_no_memory();
    }
    return name;
}

const char *series_path(Series *series, const char *stem, const char *type)
{
    return arena_printf(&series->arena, "%s/%s.%s", series->folder, stem, type);
}

static int make_folder(const char *path)
{
    struct stat info;
    if (mkdir(path, 0777) == 0 ||
        (errno == EEXIST && stat(path, &info) == 0 && S_ISDIR(info.st_mode))) {
        return EXIT_OK;
    }
    return complain(EXIT_FILES, "can't make the folder `%s`: %s", path, strerror(errno));
}

static int make_folders(Series *series, const char *name)
{
    const size_t length = stem_length(name);
    series->folder =
        arena_printf(&series->arena, "%.*s%s", (int)length, name, name[length] ? "" : ".pictures");
    const char *below =
        series->folder ? arena_printf(&series->arena, "%s/%s", series->folder, records) : NULL;
    if (!below) {
        return complain_no_memory();
    }
    const int code = make_folder(series->folder);
    return code == EXIT_OK ? make_folder(below) : code;
}

// --- Begin and end -------------------------------------------------------------------------------

int series_begin(Series *series, const Options *options, const char *name, size_t count)
{
    *series = (Series){.options = options, .count = count};
    int code = loading_begin(&series->loading, options);
    if (code == EXIT_OK && series->loading.is_text) {
        code =
            complain(EXIT_USAGE, "many pictures want a scene that can be read many times: a file");
    }
    if (code == EXIT_OK) {
        code = make_folders(series, name);
    }
    if (code != EXIT_OK) {
        return code;
    }
    const char *path = series->loading.path;
    series->checker.sandbox = &series->loading.sandbox;
    series->checker.base =
        arena_copy_string(&series->arena, path, (size_t)(strrchr(path, '/') + 1 - path));
    series->pictures = picture_cache_new();
    series->meshes = mesh_cache_new();
    if (!series->checker.base || !series->pictures || !series->meshes) {
        return complain_no_memory();
    }
    interrupt_begin(&series->interrupt);
    interrupt_heed(&series->interrupt);
    return EXIT_OK;
}

void series_end(Series *series)
{
    interrupt_end(&series->interrupt);
    loading_free(&series->loading);
    picture_cache_free(series->pictures);
    mesh_cache_free(series->meshes);
    record_checker_free(&series->checker);
    told_free(&series->told);
    arena_free(&series->arena);
}

int series_interrupted(const Series *series)
{
    const int number = atomic_load(&series->interrupt.signal);
    return number > 0 ? EXIT_SIGNAL + number : 0;
}

// --- What a picture follows from -----------------------------------------------------------------

static void add_settings(FILE *out, const ParamSetting *settings, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        fprintf(out, " --set %.*s=%.*s", (int)settings[i].name.length, settings[i].name.at,
                (int)settings[i].value.length, settings[i].value.at);
    }
}

// All that changes a byte of it, but for the files.
static char *settings_text(const Options *options, const SeriesPicture *picture)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out) {
        return NULL;
    }
    fprintf(out, "scnrender %s", SCN_VERSION);
    add_settings(out, options->settings, options->setting_count);
    add_settings(out, picture->settings, picture->setting_count);
    fprintf(out, " frame=%.0f time=%.17g size=%dx%d samples=%lld seed=%lld bits=%d time-limit=%g",
            picture->moment.frame, picture->moment.time, options->width, options->height,
            (long long)options->samples, (long long)options->seed, options->bits,
            options->time_limit);
    if (!isnan(options->exposure)) {
        fprintf(out, " exposure=%.17g", options->exposure);
    }
    fprintf(out, " tone=%d", options->tone);
    for (size_t i = 0; i < options->aov_count; ++i) {
        fprintf(out, " aov=%s", options->aovs[i]);
    }
    fprintf(out, " camera=%s", options->camera ? options->camera : "");
    if (fclose(out) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

// A file that was read for the picture.
typedef struct Reads {
    RecordedFiles files;
    Arena arena;
    const char *base; // the scene's folder
} Reads;

static void note_read(void *context, const char *path, uint64_t hash)
{
    Reads *reads = context;
    const size_t length = strlen(reads->base);
    const char *name = strncmp(path, reads->base, length) == 0 ? path + length : path;
    name = arena_copy_string(&reads->arena, name, strlen(name));
    reads->files.incomplete |=
        !name || !array_push(&reads->files.items, (RecordedFile){name, hash});
}

// --- Making --------------------------------------------------------------------------------------

// The files of one picture.
typedef struct Names {
    const char *picture, *also, *record, *checkpoint;
    const char *files[2]; // without the folder
    size_t file_count;
} Names;

static bool name_files(Series *series, const SeriesPicture *p, Names *names)
{
    Arena *arena = &series->arena;
    *names = (Names){
        .picture = series_path(series, p->stem, p->type),
        .also = p->also ? series_path(series, p->stem, p->also) : NULL,
        .record = arena_printf(arena, "%s/%s/%s.json", series->folder, records, p->stem),
        .checkpoint = arena_printf(arena, "%s/%s/%s.part", series->folder, records, p->stem),
        .files = {arena_printf(arena, "%s.%s", p->stem, p->type),
                  arena_printf(arena, "%s.%s", p->stem, p->also ? p->also : "")},
        .file_count = p->also ? 2 : 1};
    return names->picture && (names->also || !p->also) && names->record && names->checkpoint &&
           names->files[0] && names->files[1];
}

static Options options_of(Series *series, const SeriesPicture *p, const Names *names)
{
    const Options *given = series->options;
    const size_t count = given->setting_count + p->setting_count;
    ParamSetting *settings = arena_array(&series->arena, count + 1, sizeof *settings);
    Options options = *given;
    options.settings = settings;
    for (size_t i = 0; settings && i < count; ++i) {
        settings[i] =
            i < given->setting_count ? given->settings[i] : p->settings[i - given->setting_count];
    }
    options.setting_count = count;
    options.output = names->picture;
    options.bits = image_has_bits(names->picture, given->bits) ? given->bits : 0;
    options.checkpoint = names->checkpoint;
    return options;
}

static int render(Series *series, const SeriesPicture *p, const Names *names, Reads *reads)
{
    const Options options = options_of(series, p, names);
    if (!options.settings) {
        return complain_no_memory();
    }
    char label[48];
    snprintf(label, sizeof label, "[%zu/%zu] ", series->number, series->count);
    picture_cache_turn(series->pictures);
    mesh_cache_turn(series->meshes);
    const RenderTask task = {.options = &options,
                             .moment = p->moment,
                             .moves = p->moves,
                             .no_such_param = p->no_such_param,
                             .in_series = true,
                             .also = names->also,
                             .label = label,
                             .told = &series->told,
                             .on_read = note_read,
                             .on_read_context = reads,
                             .pictures = series->pictures,
                             .meshes = series->meshes};
    return render_picture(&task, &series->interrupt);
}

// The picture is not there, or not as it should be.
static int render_and_record(Series *series, const SeriesPicture *p, const Names *names,
                             Record *record)
{
    Reads reads = {.base = series->checker.base};
    record->read = &reads.files;
    unlink(names->record); // while the picture is made it holds for nothing
    int code = render(series, p, names, &reads);
    if (code == EXIT_OK) {
        char message[1024];
        unlink(names->checkpoint);
        ++series->rendered;
        if (!record_write(names->record, record, message, sizeof message)) {
            code = complain(EXIT_FILES, "%s", message);
        }
    }
    array_free(&reads.files.items);
    arena_free(&reads.arena);
    return code;
}

static int make(Series *series, const SeriesPicture *p, const char *settings)
{
    Names names;
    if (!name_files(series, p, &names)) {
        return complain_no_memory();
    }
    Record record = {.settings = settings,
                     .pictures = names.files,
                     .picture_count = names.file_count,
                     .folder = series->folder};
    if (!series->options->again && record_fits(&series->checker, names.record, &record)) {
        ++series->kept;
        return EXIT_OK;
    }
    return render_and_record(series, p, &names, &record);
}

int series_make(Series *series, const SeriesPicture *picture)
{
    ++series->number;
    int code = series_interrupted(series);
    if (code) {
        return code;
    }
    const ArenaMark mark = arena_mark(&series->arena);
    char *settings = settings_text(series->options, picture);
    code = settings ? make(series, picture, settings) : complain_no_memory();
    free(settings);
    arena_rewind(&series->arena, mark);
    return code;
}
