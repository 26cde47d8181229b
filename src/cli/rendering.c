#include "cli/rendering.h"

#include "base/thread.h"
#include "cli/keep.h"
#include "cli/picture.h"
#include "cli/progress.h"
#include "image/image.h"
#include "render/light_report.h"
#include "render/material_report.h"
#include "render/render.h"
#include "render/resume.h"
#include "watch/pose.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

// When a long picture is put on the disk before it is done.
static const double FIRST_REFRESH_SECONDS = 10, REFRESH_SECONDS = 15;
static const double WRITER_CHECK_SECONDS = 1; // by then the module is loaded

// Values of the renderer's stop flag beside the numbers of signals.
enum { GO_ON = 0, STOP_FAILED = -1, STOP_TO_KEEP = -2 };

// --- What the options change ---------------------------------------------------------------------

static int choose_named_camera(Scene *scene, const char *name)
{
    const SceneNodeArray *cameras = &scene->nodes[CATEGORY_CAMERA];
    for (uint32_t i = 0; i < cameras->count; ++i) {
        if (strcmp(scene->names.items[cameras->items[i].name], name) == 0) {
            scene->camera = i;
            return EXIT_OK;
        }
    }
    fprintf(stderr, "scnrender: the scene has no camera called `%s`", name);
    const char *before = "; it has";
    for (uint32_t i = 0; i < cameras->count; ++i) {
        const char *other = scene->names.items[cameras->items[i].name];
        if (*other) {
            fprintf(stderr, "%s `%s`", before, other);
            before = ",";
        }
    }
    fputc('\n', stderr);
    return EXIT_USAGE;
}

static int check_pixels(const Loading *loading)
{
    const Options *options = loading->options;
    FilmParams film = scene_film(&loading->scene);
    uint64_t width = options->width ? (uint64_t)options->width : (uint64_t)film.width;
    uint64_t height = options->height ? (uint64_t)options->height : (uint64_t)film.height;
    if (width * height <= options->limits.pixels) {
        return EXIT_OK;
    }
    return complain(
        options->width ? EXIT_USAGE : EXIT_DIAGNOSTICS,
        "%llu x %llu pixels are more than the limit of %llu; --limit pixels=N raises it",
        (unsigned long long)width, (unsigned long long)height,
        (unsigned long long)options->limits.pixels);
}

// --- Rendering -----------------------------------------------------------------------------------

typedef struct Rendering {
    const RenderTask *task;
    Loading loading;
    bool has_camera;     // `--camera "camera { … }"`
    CameraParams camera; // is what it says
    Interrupt *interrupt;
    Picture picture; // its path is NULL where a part is rendered for its checkpoint alone
    Bar bar;
    double refresh_at, checkpoint_at; // seconds of rendering; INFINITY: never
    bool writer_checked;
    char failure[600]; // why rendering was given up; "": it wasn't
    Renderer *renderer;
    RenderStats stats;
} Rendering;

// Nobody should render for an hour to learn that the library that writes the picture is missing.
static void check_writer(Rendering *rendering, const RenderProgress *progress)
{
    if (rendering->writer_checked || !rendering->picture.path ||
        progress->seconds < WRITER_CHECK_SECONDS) {
        return;
    }
    rendering->writer_checked = true;
    if (!image_available(rendering->picture.path, rendering->failure, sizeof rendering->failure)) {
        atomic_store(&rendering->interrupt->signal, STOP_FAILED);
    }
}

// Called by the renderer. A pass may take minutes, and while it lasts the film can't be read: so
// the renderer is stopped, to go on after the picture or the checkpoint is written.
static void on_progress(void *context, const RenderProgress *progress)
{
    Rendering *rendering = context;
    bar_draw(&rendering->bar, progress);
    check_writer(rendering, progress);
    bool due =
        progress->seconds >= rendering->refresh_at || progress->seconds >= rendering->checkpoint_at;
    if (due && progress->fraction < 1) {
        int expected = GO_ON;
        atomic_compare_exchange_strong(&rendering->interrupt->signal, &expected, STOP_TO_KEEP);
    }
}

static void plan_keeping(Rendering *rendering)
{
    const Options *options = rendering->loading.options;
    double now = rendering->stats.render_seconds;
    if (rendering->picture.path && now >= rendering->refresh_at) {
        rendering->refresh_at = now + REFRESH_SECONDS;
    }
    if (options->checkpoint && now >= rendering->checkpoint_at) {
        rendering->checkpoint_at = now + options->checkpoint_interval;
    }
}

static int save(const Rendering *rendering, char *message, size_t size)
{
    return keep_save(rendering->loading.options, rendering->renderer, rendering->picture.facts,
                     message, size);
}

// Puts on the disk what is done so far: the checkpoint first, which is worth more.
static void keep(Rendering *rendering)
{
    char message[1024];
    bool good = true;
    double now = rendering->stats.render_seconds;
    if (now >= rendering->checkpoint_at) {
        good = save(rendering, message, sizeof message) == EXIT_OK;
    }
    if (good && now >= rendering->refresh_at) {
        good = picture_write(&rendering->picture, renderer_film(rendering->renderer), message,
                             sizeof message) == EXIT_OK;
    }
    if (!good) {
        bar_end(&rendering->bar);
        complain(EXIT_OK, "%s; will try again", message);
    }
    plan_keeping(rendering);
}

// Renders to the end, or to a stop that isn't for keeping. False if nothing could be rendered.
static bool run_and_keep(Rendering *rendering)
{
    for (;;) {
        if (!renderer_run(rendering->renderer, &rendering->stats)) {
            return false;
        }
        int expected = STOP_TO_KEEP;
        if (atomic_load(&rendering->interrupt->signal) != expected || !rendering->stats.stopped) {
            return true;
        }
        keep(rendering);
        atomic_compare_exchange_strong(&rendering->interrupt->signal, &expected, GO_ON);
    }
}

static int64_t whole_samples(const Loading *loading)
{
    return loading->options->samples > 0 ? loading->options->samples
                                         : scene_render(&loading->scene).samples;
}

static RenderOptions render_options(Rendering *rendering)
{
    const Options *options = rendering->loading.options;
    RenderOptions out = {.threads = options->threads,
                         .width = options->width,
                         .height = options->height,
                         .samples = options->samples,
                         .seed = options->seed,
                         .tile_width = options->tile_width,
                         .tile_height = options->tile_height,
                         .time_limit = options->time_limit,
                         .aovs = picture_has_layers(&rendering->picture),
                         .camera = rendering->has_camera ? &rendering->camera : NULL,
                         .stop = &rendering->interrupt->signal,
                         .progress = on_progress,
                         .context = rendering};
    if (options->range_last >= 0) {
        out.first_sample = options->range_first;
        out.samples = options->range_last - options->range_first + 1;
        out.whole_samples = whole_samples(&rendering->loading);
    }
    return out;
}

// By a name, or by the text of a camera.
static int choose_camera(Rendering *rendering, const char *named)
{
    if (!strchr(named, '{')) {
        return choose_named_camera(&rendering->loading.scene, named);
    }
    char message[300];
    const Schema *schema = rendering->loading.scene.schema;
    if (!camera_from_text(schema, named, &rendering->camera, message, sizeof message)) {
        return complain(EXIT_USAGE, "`--camera`: %s", message);
    }
    rendering->has_camera = true;
    return EXIT_OK;
}

// "64 samples", or "32 to 1024 samples (187.3 on average)"
static void samples_text(const Film *film, char *text, size_t size)
{
    uint32_t least = UINT32_MAX, most = 0;
    double sum = 0;
    for (size_t p = 0; p < film_pixel_count(film); ++p) {
        uint32_t samples = film->pixels[p].samples;
        least = samples < least ? samples : least;
        most = samples > most ? samples : most;
        sum += samples;
    }
    if (least == most) {
        snprintf(text, size, "%u sample%s", (unsigned)most, most == 1 ? "" : "s");
    } else {
        snprintf(text, size, "%u to %u samples (%.1f on average)", (unsigned)least, (unsigned)most,
                 sum / (double)film_pixel_count(film));
    }
}

// ", error 1.9 % (in 97 % of the picture at most 2 %)"; "" where it can't be told.
static void error_text(const Picture *picture, const Film *film, char *text, size_t size)
{
    FilmError error = film_error(film, picture->confidence, picture->wanted_error);
    text[0] = '\0';
    if (isnan(error.mean)) {
        return;
    }
    int length = snprintf(text, size, ", error %.2g %%", 100 * error.mean);
    if (picture->wanted_error > 0 && length > 0 && (size_t)length < size) {
        snprintf(text + length, size - (size_t)length,
                 " (at most %.3g %% in %.4g %% of the picture)", 100 * picture->wanted_error,
                 100 * error.met);
    }
}

// "a.png: 640 x 400, 64 samples, error 2.1 %, 3.1 s (and 0.1 s to build), 5.1 M rays/s"
static void print_statistics(const Rendering *rendering, const Film *film)
{
    const RenderStats *stats = &rendering->stats;
    uint64_t rays = stats->rays + stats->shadow_rays;
    char build[32], seconds[32], rate[32], samples[96], error[96];
    samples_text(film, samples, sizeof samples);
    error_text(&rendering->picture, film, error, sizeof error);
    duration_text(stats->build_seconds, build, sizeof build);
    duration_text(stats->render_seconds, seconds, sizeof seconds);
    count_text(stats->render_seconds > 0 ? (double)rays / stats->render_seconds : 0, rate,
               sizeof rate);
    fprintf(stderr, "%s%s: %u x %u, %s%s, %s%s (and %s to build), %s%srays/s\n",
            rendering->task->label ? rendering->task->label : "",
            rendering->picture.path ? rendering->picture.path
                                    : rendering->loading.options->checkpoint,
            (unsigned)film->width, (unsigned)film->height, samples, error,
            stats->out_of_time ? "the time limit of " : "", seconds, build, rate,
            strchr(rate, ' ') ? "" : " ");
    if (stats->bad_samples > 0) {
        fprintf(stderr, "scnrender: %llu samples were not finite or negative, and left out\n",
                (unsigned long long)stats->bad_samples);
    }
}

static int write_checkpoint(const Rendering *rendering)
{
    char message[1024];
    const int code = save(rendering, message, sizeof message);
    return code == EXIT_OK ? EXIT_OK : complain(code, "%s", message);
}

static int write_picture(const Rendering *rendering)
{
    char message[1024];
    const Film *film = renderer_film(rendering->renderer);
    int code = picture_write(&rendering->picture, film, message, sizeof message);
    if (code == EXIT_OK && rendering->task->also) {
        Picture also = picture_copy(&rendering->picture, rendering->task->also);
        code = picture_write(&also, film, message, sizeof message);
    }
    return code == EXIT_OK ? EXIT_OK : complain(code, "%s", message);
}

// Writes what is done. An ExitCode, after a message if it isn't EXIT_OK.
static int write_results(const Rendering *rendering, bool interrupted)
{
    const bool in_series = rendering->task->in_series;
    int kept = EXIT_OK, code = EXIT_OK;
    if (rendering->loading.options->checkpoint && (interrupted || !in_series)) {
        kept = write_checkpoint(rendering);
    }
    if (rendering->picture.path && !(interrupted && in_series)) {
        code = write_picture(rendering);
    }
    return code != EXIT_OK ? code : kept;
}

static void say_interrupted(const Rendering *rendering)
{
    const char *picture = rendering->picture.path;
    const char *checkpoint = rendering->loading.options->checkpoint;
    double pixels = (double)film_pixel_count(renderer_film(rendering->renderer));
    double samples = (double)rendering->stats.samples / pixels;
    complain(EXIT_OK, "interrupted; `%s` has what was done, %.1f samples a pixel%s%s%s",
             picture ? picture : checkpoint, samples, checkpoint ? "; --checkpoint " : "",
             checkpoint ? checkpoint : "", checkpoint ? " --resume goes on" : "");
}

// Writes what is done and says so.
static int finish(Rendering *rendering, bool rendered, int signal_number)
{
    const Options *options = rendering->loading.options;
    if (*rendering->failure) {
        return complain(EXIT_FILES, "can't write `%s`: %s", rendering->picture.path,
                        rendering->failure);
    }
    int interrupted = signal_number ? EXIT_SIGNAL + signal_number : EXIT_OK;
    if (signal_number && rendering->stats.samples == 0) {
        return rendering->task->in_series
                   ? interrupted
                   : complain(interrupted,
                              "interrupted before the first sample; nothing is written");
    }
    if (!rendered) {
        return complain(EXIT_NO_MEMORY, "not enough memory to render");
    }
    int code = write_results(rendering, signal_number != 0);
    if (code != EXIT_OK) {
        return code;
    }
    if (signal_number) {
        if (!rendering->task->in_series) {
            say_interrupted(rendering);
        }
    } else if (!options->quiet && !options->json) {
        print_statistics(rendering, renderer_film(rendering->renderer));
    }
    return interrupted;
}

static bool make_renderer(Rendering *rendering)
{
    Loading *loading = &rendering->loading;
    const RenderOptions options = render_options(rendering);
    rendering->renderer = renderer_new(&loading->scene, &options, &loading->lang.sink);
    return rendering->renderer != NULL;
}

// What a series left of a picture is of use, or it isn't: nobody named the file.
static int take_up_of_series(Rendering *rendering)
{
    char message[1024];
    const char *path = rendering->loading.options->checkpoint;
    const CheckpointResult result =
        renderer_load(rendering->renderer, path, message, sizeof message);
    if (result == CHECKPOINT_SOUND || result == CHECKPOINT_MISSING) {
        return EXIT_OK;
    }
    unlink(path);
    renderer_free(rendering->renderer); // its sums may be spoilt
    return make_renderer(rendering) ? EXIT_OK
                                    : complain(EXIT_NO_MEMORY, "not enough memory to render");
}

static int take_up_checkpoint(Rendering *rendering)
{
    bool resumed;
    return rendering->task->in_series && rendering->loading.options->checkpoint
               ? take_up_of_series(rendering)
               : keep_resume(rendering->loading.options, rendering->renderer, &resumed);
}

// The renderer is ready: takes up the checkpoint, renders, writes.
static int run(Rendering *rendering)
{
    const Options *options = rendering->loading.options;
    int code = take_up_checkpoint(rendering);
    if (code != EXIT_OK) {
        return code;
    }
    renderer_stats(rendering->renderer, &rendering->stats);
    rendering->refresh_at = rendering->checkpoint_at = INFINITY;
    if (rendering->picture.path) {
        // Not earlier: Embree's own loading would have to wait for it.
        image_preload(rendering->picture.path);
    }
    if (rendering->picture.path && !rendering->task->in_series) {
        rendering->refresh_at = rendering->stats.render_seconds + FIRST_REFRESH_SECONDS;
    }
    if (options->checkpoint) {
        rendering->checkpoint_at = rendering->stats.render_seconds + options->checkpoint_interval;
    }
    interrupt_heed(rendering->interrupt);
    bar_begin(&rendering->bar, !options->quiet, rendering->task->label);
    bool rendered = run_and_keep(rendering);
    bar_end(&rendering->bar);
    int stop = rendering->stats.stopped ? atomic_load(&rendering->interrupt->signal) : GO_ON;
    return finish(rendering, rendered, stop > 0 ? stop : 0);
}

// The scene is sound: builds the renderer, shows all diagnostics together, renders.
static int render(Rendering *rendering)
{
    Loading *loading = &rendering->loading;
    light_warn_enclosed(&loading->scene, loading->lang.threads, &loading->lang.sink);
    material_warn_open_glass(&loading->scene, &loading->lang.sink);
    const bool made = make_renderer(rendering);
    int code = loading_report(loading);
    if (!made) {
        return code != EXIT_OK ? code : complain(EXIT_NO_MEMORY, "not enough memory to render");
    }
    rendering->picture.camera = rendering->has_camera ? loading->options->camera : NULL;
    if (!picture_describe(&rendering->picture, loading, rendering->renderer)) {
        return complain_no_memory();
    }
    return run(rendering);
}

// What whoever makes a series wants to know of the scene.
static void tell_task(const RenderTask *task, const Lang *lang)
{
    if (task->moves) {
        *task->moves = lang->moves;
    }
    for (uint32_t i = 0; task->no_such_param && i < lang->sink.count; ++i) {
        *task->no_such_param |= lang->sink.items[i].code == E0309;
    }
}

static int prepare(Rendering *rendering)
{
    Loading *loading = &rendering->loading;
    const Options *options = loading->options;
    const bool good = loading_evaluate(loading);
    tell_task(rendering->task, &loading->lang);
    const int stop = loading->lang.stop ? atomic_load(loading->lang.stop) : 0;
    if (stop > 0) {
        return EXIT_SIGNAL + stop;
    }
    if (!good) {
        int code = loading_report(loading);
        return code != EXIT_OK ? code : EXIT_DIAGNOSTICS;
    }
    int code = options->camera ? choose_camera(rendering, options->camera) : EXIT_OK;
    if (code == EXIT_OK) {
        code = check_pixels(loading);
    }
    if (code == EXIT_OK) {
        code = keep_check_range(options, whole_samples(loading));
    }
    if (code == EXIT_OK) {
        code = picture_begin(&rendering->picture, loading);
    }
    return code == EXIT_OK && !rendering->task->in_series ? keep_check(options) : code;
}

// What the task says of the loading.
static void take_task(Loading *loading, const RenderTask *task, const Interrupt *interrupt)
{
    loading->told = task->told;
    loading->lang.moment = task->moment;
    loading->lang.stop = task->in_series ? &interrupt->signal : NULL;
    loading->scene.pictures = task->pictures;
    loading->scene.mesh_cache = task->meshes;
    loading->sandbox.on_read = task->on_read;
    loading->sandbox.on_read_context = task->on_read_context;
}

static void give_back_part(void *context, uint64_t part, unsigned worker)
{
    (void)worker;
    Rendering *rendering = context;
    if (part < LOADING_PARTS) {
        loading_free_part(&rendering->loading, (unsigned)part);
    } else {
        renderer_free(rendering->renderer);
    }
}

// The memory of a million shapes goes back in half of the time by threads.
static void give_back(Rendering *rendering)
{
    enum { WORTH_THREADS = 1 << 16 };
    const Scene *scene = &rendering->loading.scene;
    const size_t parts = scene->nodes[CATEGORY_SHAPE].count + scene->instances.count;
    const unsigned threads = parts < WORTH_THREADS ? 1 : rendering->loading.lang.threads;
    if (threads <= 1) {
        renderer_free(rendering->renderer);
        loading_free(&rendering->loading);
        return;
    }
    parallel_for(LOADING_PARTS + 1, threads, give_back_part, rendering, NULL);
}

int render_picture(const RenderTask *task, Interrupt *interrupt)
{
    Rendering rendering = {.task = task, .interrupt = interrupt};
    int code = loading_begin(&rendering.loading, task->options);
    if (code == EXIT_OK) {
        take_task(&rendering.loading, task, interrupt);
        code = prepare(&rendering);
    }
    if (code == EXIT_OK) {
        if (!task->in_series) {
            interrupt_begin(interrupt);
        }
        code = render(&rendering);
    }
    give_back(&rendering);
    return code;
}
