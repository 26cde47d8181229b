#include "cli/picture.h"

#include "base/mem.h"
#include "base/number.h"
#include "image/image.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

// --- The name ------------------------------------------------------------------------------------

static bool begins_with(const char *text, const char *start)
{
    return strncmp(text, start, strlen(start)) == 0;
}

// A scene may name its picture, but not reach out of its folder: it can write nothing else.
static bool stays_below(const char *file)
{
    if (!*file || file[0] == '/') {
        return false;
    }
    for (const char *at = file; at; at = strchr(at, '/')) {
        at += *at == '/';
        if (begins_with(at, "../") || strcmp(at, "..") == 0) {
            return false;
        }
    }
    return true;
}

// Nor may a link among the folders of `file` lead out. `base` is the scene's folder.
static bool folder_is_inside(const char *path, const char *base, Arena *arena)
{
    char real[PATH_MAX], real_base[PATH_MAX];
    const char *folder = arena_printf(arena, "%.*s", (int)(strrchr(path, '/') - path), path);
    if (!folder || !realpath(base, real_base)) {
        return false;
    }
    if (!realpath(*folder ? folder : "/", real)) {
        return true; // it isn't there; whoever opens the file will say so
    }
    size_t length = strlen(real_base);
    return strncmp(real, real_base, length) == 0 &&
           (real[length] == '/' || real[length] == '\0' || length == 1);
}

static int named_by_scene(Picture *picture, Loading *loading, const char *file)
{
    Arena *arena = &loading->scene.arena;
    const char *shown = loading->is_text ? "" : loading->shown;
    const char *slash = strrchr(shown, '/');
    const char *base = slash ? arena_printf(arena, "%.*s", (int)(slash - shown) + 1, shown) : "./";
    picture->path = base ? arena_printf(arena, "%s%s", base, file) : NULL;
    if (!picture->path) {
        return complain_no_memory();
    }
    if (!stays_below(file) || !folder_is_inside(picture->path, base, arena)) {
        return complain(EXIT_DIAGNOSTICS,
                        "the scene's picture `%s` would lie outside the scene's folder; say -o %s "
                        "if you want it there",
                        file, file);
    }
    return EXIT_OK;
}

// scene.scn -> scene.png
static int named_after_scene(Picture *picture, Loading *loading)
{
    const char *shown = loading->shown;
    picture->path = arena_printf(&loading->scene.arena, "%.*s.png", (int)stem_length(shown), shown);
    return picture->path ? EXIT_OK : complain_no_memory();
}

static int find_name(Picture *picture, Loading *loading, const char *file)
{
    const char *output = loading->options->output;
    if (output) {
        picture->path = output;
        return EXIT_OK;
    }
    if (file) {
        return named_by_scene(picture, loading, file);
    }
    if (loading->is_text) {
        return complain(EXIT_USAGE,
                        "a scene from a pipe has no name: say -o where its picture goes");
    }
    return named_after_scene(picture, loading);
}

// --- Layers --------------------------------------------------------------------------------------

static const char *aov_name(size_t i)
{
    return i < AOV_COUNT ? film_aovs[i].name : NULL;
}

static int choose_layer(Picture *picture, const char *name)
{
    int aov = film_find_aov(str_from(name));
    if (aov >= 0) {
        picture->aovs[aov] = true;
        return EXIT_OK;
    }
    const char *near = nearest_name(name, aov_name);
    if (near) {
        return complain(EXIT_USAGE, "`%s` is not a layer; did you mean `%s`?", name, near);
    }
    fprintf(stderr, "scnrender: `%s` is not a layer; there are", name);
    for (int i = 0; i < AOV_COUNT; ++i) {
        fprintf(stderr, "%s %s", i ? "," : "", film_aovs[i].name);
    }
    fputc('\n', stderr);
    return EXIT_USAGE;
}

static int choose_layers(Picture *picture, const Options *options, const StringList *of_scene)
{
    int code = EXIT_OK;
    for (size_t i = 0; code == EXIT_OK && i < options->aov_count; ++i) {
        code = choose_layer(picture, options->aovs[i]);
    }
    for (uint32_t i = 0; code == EXIT_OK && i < of_scene->count; ++i) {
        code = choose_layer(picture, of_scene->items[i]);
    }
    if (code == EXIT_OK && picture->path && picture_has_layers(picture) &&
        !image_has_layers(picture->path)) {
        if (options->aov_count > 0) {
            return complain(EXIT_USAGE, "only an EXR holds further layers, not `%s`",
                            picture->path);
        }
        if (!options->quiet) {
            complain(EXIT_OK, "the scene's further layers are left out: only an EXR holds them");
        }
        memset(picture->aovs, 0, sizeof picture->aovs);
    }
    return code;
}

bool picture_has_layers(const Picture *picture)
{
    bool any = false;
    for (int i = 0; i < AOV_COUNT; ++i) {
        any |= picture->aovs[i];
    }
    return any;
}

// --- Before rendering ----------------------------------------------------------------------------

// Whoever waits an hour for a picture wants to know at once that it can't be kept.
static int check_writable(const Picture *picture, Arena *arena)
{
    char message[512];
    char *temporary = atomic_temporary_name(arena, picture->path, message, sizeof message);
    if (!temporary) {
        return complain(EXIT_FILES, "%s", message);
    }
    atomic_discard(temporary);
    return EXIT_OK;
}

static int check_type(const Picture *picture, const Options *options)
{
    if (!image_can_write(picture->path)) {
        int wrong = options->output ? EXIT_USAGE : EXIT_DIAGNOSTICS;
        return complain(wrong, "`%s` is not of a type that can be written: %s", picture->path,
                        image_extensions());
    }
    if (!image_has_bits(picture->path, picture->bits)) {
        return complain(EXIT_USAGE, "`%s` can't have %d bits a channel", picture->path,
                        picture->bits);
    }
    return EXIT_OK;
}

int picture_begin(Picture *picture, Loading *loading)
{
    const Options *options = loading->options;
    *picture = (Picture){.bits = options->bits, .threads = loading->lang.threads};
    FilmParams film = scene_film(&loading->scene);
    if (options->range_last >= 0 && !options->output) {
        return choose_layers(picture, options, &film.aovs);
    }
    int code = find_name(picture, loading, film.file);
    if (code == EXIT_OK) {
        code = check_type(picture, options);
    }
    if (code == EXIT_OK) {
        code = choose_layers(picture, options, &film.aovs);
    }
    return code == EXIT_OK ? check_writable(picture, &loading->scene.arena) : code;
}

// --- Where it comes from -------------------------------------------------------------------------

// Facts whose names begin so are attributes of the picture.
static const char attribute_prefix[] = "scnrender:";
// Others say how a picture is developed.
static const char exposure_note[] = "exposure", tone_note[] = "tone", layers_note[] = "layers";

enum { MOST_FACTS = 16 };

typedef struct Facts {
    CheckpointText *items;
    uint32_t count;
    bool complete;
} Facts;

static void add_fact(Facts *facts, const char *name, const char *value)
{
    facts->complete &= value != NULL && facts->count < MOST_FACTS;
    if (facts->complete) {
        facts->items[facts->count++] = (CheckpointText){CHECKPOINT_NOTE, name, value};
    }
}

// "count=9, wide=true"
static const char *parameters_text(const Scene *scene, Arena *arena)
{
    const char *text = "";
    for (size_t i = 0; text && i < scene->params.count; ++i) {
        const SceneParam *param = &scene->params.items[i];
        text =
            arena_printf(arena, "%s%s%s=%s", text, i ? ", " : "", param->name, param->value_text);
    }
    return text;
}

static const char *layers_text(const Picture *picture, Arena *arena)
{
    const char *text = "";
    for (int i = 0; text && i < AOV_COUNT; ++i) {
        if (picture->aovs[i]) {
            text = arena_printf(arena, "%s%s%s", text, *text ? "," : "", film_aovs[i].name);
        }
    }
    return text;
}

static const char *camera_name(const Scene *scene)
{
    if (scene->camera >= scene->nodes[CATEGORY_CAMERA].count) {
        return "";
    }
    return scene->names.items[scene_node(scene, CATEGORY_CAMERA, scene->camera)->name];
}

// Nothing that differs between two runs that make the same picture.
bool picture_describe(Picture *picture, Loading *loading, const Renderer *renderer)
{
    Scene *scene = &loading->scene;
    Arena *arena = &scene->arena;
    const RenderParams *render = renderer_params(renderer);
    const FilmParams *film = renderer_film_params(renderer);
    const char *slash = strrchr(loading->shown, '/');
    Facts facts = {.items = arena_array(arena, MOST_FACTS, sizeof(CheckpointText))};
    facts.complete = facts.items != NULL;
    const Options *options = loading->options;
    picture->exposure = isnan(options->exposure) ? film->exposure : options->exposure;
    picture->tone = options->tone < 0 ? film->tone : options->tone;
    add_fact(&facts, "scnrender:version", SCN_VERSION);
    add_fact(&facts, "scnrender:scene", slash ? slash + 1 : loading->shown);
    add_fact(&facts, "scnrender:scene_hash",
             arena_printf(arena, "%016llx", (unsigned long long)scene->hash));
    add_fact(&facts, "scnrender:parameters", parameters_text(scene, arena));
    add_fact(&facts, "scnrender:seed", arena_printf(arena, "%lld", (long long)render->seed));
    add_fact(&facts, "scnrender:integrator", integrator_classes[render->integrator]->name);
    add_fact(&facts, "scnrender:camera", picture->camera ? picture->camera : camera_name(scene));
    const StopRule *rule = renderer_stop_rule(renderer);
    if (rule) {
        add_fact(&facts, "scnrender:stop",
                 arena_printf(arena, "error %.6g, confidence %.6g", rule->error, rule->confidence));
    }
    picture->confidence = rule ? rule->confidence : ERROR_CONFIDENCE;
    picture->wanted_error = rule ? rule->error : 0;
    add_fact(&facts, exposure_note, arena_printf(arena, "%.17g", picture->exposure));
    add_fact(&facts, tone_note, arena_printf(arena, "%d", (int)picture->tone));
    add_fact(&facts, layers_note, layers_text(picture, arena));
    picture->facts = (CheckpointTexts){facts.items, facts.count};
    return facts.complete;
}

Picture picture_copy(const Picture *picture, const char *path)
{
    Picture copy = *picture;
    copy.path = path;
    copy.bits = image_has_bits(path, picture->bits) ? picture->bits : 0;
    memset(copy.aovs, 0, sizeof copy.aovs);
    return copy;
}

// A number that was written by picture_describe.
static double noted_number(CheckpointTexts notes, const char *name)
{
    const char *text = checkpoint_text(notes, name);
    double number = 0;
    const char *end = text ? number_parse(text, text + strlen(text), &number) : NULL;
    return end && *end == '\0' && isfinite(number) ? number : 0;
}

static void recall_layers(Picture *picture, const char *names)
{
    while (names && *names) {
        size_t length = strcspn(names, ",");
        int aov = film_find_aov((Str){names, length});
        if (aov >= 0) {
            picture->aovs[aov] = true;
        }
        names += length + (names[length] == ',');
    }
}

int picture_recall(Picture *picture, const Options *options, CheckpointTexts notes, bool has_layers,
                   Arena *arena)
{
    *picture = (Picture){.path = options->output, .bits = options->bits, .facts = notes};
    picture->exposure =
        isnan(options->exposure) ? noted_number(notes, exposure_note) : options->exposure;
    double tone = options->tone < 0 ? noted_number(notes, tone_note) : options->tone;
    picture->tone = tone >= TONE_SRGB && tone <= TONE_FILMIC ? (int32_t)tone : TONE_SRGB;
    picture->confidence = ERROR_CONFIDENCE;
    int code = check_type(picture, options);
    if (code == EXIT_OK) {
        code = choose_layers(picture, options, &(StringList){0});
    }
    if (code == EXIT_OK && picture_has_layers(picture) && !has_layers) {
        return complain(EXIT_USAGE, "the parts were rendered without further layers: they want "
                                    "--aov, too");
    }
    if (code == EXIT_OK && !picture_has_layers(picture) && has_layers &&
        image_has_layers(picture->path)) {
        recall_layers(picture, checkpoint_text(notes, layers_note));
    }
    return code == EXIT_OK ? check_writable(picture, arena) : code;
}

// --- Content -------------------------------------------------------------------------------------

enum { MOST_ATTRIBUTES = MOST_FACTS + 8 };

typedef struct Attributes {
    ImageAttribute items[MOST_ATTRIBUTES];
    int count;
    bool complete;
} Attributes;

static void add_attribute(Attributes *attributes, const char *name, const char *text)
{
    attributes->complete &= text != NULL;
    if (text && attributes->count < MOST_ATTRIBUTES) {
        attributes->items[attributes->count++] = (ImageAttribute){name, text};
    }
}

// How far the picture may be from the truth (adaptive.h).
static void add_error(Attributes *attributes, const Picture *picture, const Film *film,
                      Arena *arena)
{
    const FilmError error = film_error(film, picture->confidence, picture->wanted_error);
    if (isnan(error.mean)) {
        return;
    }
    add_attribute(attributes, "scnrender:error", arena_printf(arena, "%.4g", error.mean));
    add_attribute(attributes, "scnrender:error_worst", arena_printf(arena, "%.4g", error.worst));
    add_attribute(attributes, "scnrender:error_confidence",
                  arena_printf(arena, "%.6g", picture->confidence));
    if (picture->wanted_error > 0) {
        add_attribute(attributes, "scnrender:error_met", arena_printf(arena, "%.4f", error.met));
    }
}

static Attributes make_attributes(const Picture *picture, const Film *film, Arena *arena)
{
    Attributes attributes = {.complete = true};
    add_attribute(&attributes, "Software", "scnrender " SCN_VERSION);
    for (uint32_t i = 0; i < picture->facts.count && i < CHECKPOINT_MOST_TEXTS; ++i) {
        const CheckpointText *fact = &picture->facts.items[i];
        if (begins_with(fact->name, attribute_prefix)) {
            add_attribute(&attributes, fact->name, fact->value);
        }
    }
    add_attribute(&attributes, "scnrender:samples",
                  arena_printf(arena, "%u", (unsigned)film->samples_done));
    add_error(&attributes, picture, film, arena);
    return attributes;
}

static bool add_ids(const Film *film, int aov, Arena *arena, ImageLayer *layer)
{
    size_t count = film_pixel_count(film);
    uint32_t *ids = arena_array(arena, count, sizeof *ids);
    for (size_t i = 0; ids && i < count; ++i) {
        ids[i] = aov == AOV_OBJECT_ID ? film->aovs[i].object : film->aovs[i].material;
    }
    layer->ids = ids;
    return ids != NULL;
}

static bool add_values(const Film *film, int aov, Arena *arena, ImageLayer *layer)
{
    size_t channels = (size_t)film_aovs[aov].channels;
    float *values = arena_array(arena, film_pixel_count(film), channels * sizeof *values);
    layer->pixels = values;
    return values && film_aov(film, aov, values);
}

// The picture first, then the further layers; alpha is the picture's fourth channel. How many
// layers, or 0 without memory.
static int make_layers(const Picture *picture, const Film *film, Arena *arena, ImageLayer *layers)
{
    static const char *const rgba[] = {"R", "G", "B", "A"};
    int channels = picture->aovs[AOV_ALPHA] ? 4 : 3, count = 1;
    float *pixels = arena_array(arena, film_pixel_count(film), (size_t)channels * sizeof *pixels);
    if (!pixels) {
        return 0;
    }
    FilmParams development = {.exposure = picture->exposure, .tone = picture->tone};
    film_develop(film, &development, channels, image_is_linear(picture->path, picture->bits),
                 picture->threads, pixels);
    layers[0] = (ImageLayer){"", channels, rgba, pixels, NULL};
    for (int aov = 0; aov < AOV_COUNT; ++aov) {
        if (!picture->aovs[aov] || aov == AOV_ALPHA) {
            continue;
        }
        const FilmAov *info = &film_aovs[aov];
        layers[count] = (ImageLayer){info->name, info->channels, info->suffixes, NULL, NULL};
        if (!(info->uint32_ids ? add_ids(film, aov, arena, &layers[count])
                               : add_values(film, aov, arena, &layers[count]))) {
            return 0;
        }
        ++count;
    }
    return count;
}

int picture_replace(const char *path, const ImageFile *file, Arena *arena, char *message,
                    size_t message_size)
{
    char why[400];
    if (!image_available(path, why, sizeof why)) { // before anything lies beside it
        snprintf(message, message_size, "can't write `%s`: %s", path, why);
        return EXIT_FILES;
    }
    char *temporary = atomic_temporary_name(arena, path, message, message_size);
    if (!temporary) {
        return EXIT_FILES;
    }
    if (!image_write(temporary, path, file, why, sizeof why)) {
        atomic_discard(temporary);
        snprintf(message, message_size, "can't write `%s`: %s", path, why);
        return EXIT_FILES;
    }
    return atomic_rename(temporary, path, message, message_size) ? EXIT_OK : EXIT_FILES;
}

static int write_layers(const Picture *picture, const Film *film, Arena *arena, char *message,
                        size_t message_size)
{
    ImageLayer layers[AOV_COUNT + 1];
    int layer_count = make_layers(picture, film, arena, layers);
    Attributes attributes = make_attributes(picture, film, arena);
    if (layer_count == 0 || !attributes.complete) {
        snprintf(message, message_size, "not enough memory to write `%s`", picture->path);
        return EXIT_NO_MEMORY;
    }
    ImageFile file = {(int)film->width, (int)film->height, picture->bits,    layers,
                      layer_count,      attributes.items,  attributes.count, picture->threads};
    return picture_replace(picture->path, &file, arena, message, message_size);
}

int picture_write(const Picture *picture, const Film *film, char *message, size_t message_size)
{
    Arena arena = {0};
    int code = write_layers(picture, film, &arena, message, message_size);
    arena_free(&arena);
    return code;
}
