// The thread that evaluates and renders.
//
// What a change asks for is done again, and no more: a setting or a file has the scene evaluated
// and its world built, a camera has rays traced in the world that is there, exposure and tone curve
// have nothing rendered at all (session_set_look never comes here).
//
// After a change the first picture is a coarse one, of so few pixels that it takes about
// COARSE_SECONDS, and it is always finished: a camera that is dragged is followed however fast the
// moves come. Then the film's own size is rendered; while its first pass lasts, what is missing is
// shown from the coarse picture.
#include "watch/session_internal.h"

#include "base/clock.h"
#include "base/mem.h"
#include "image/image.h"
#include "render/render.h"

#include <math.h>
#include <string.h>

static const double COARSE_SECONDS = 0.04;
static const double GUESSED_SPEED = 5e5; // samples a second, before anything was measured
static const double STATUS_SECONDS = 0.2;
enum { COARSEST = 16, LEAST_COARSE_SIDE = 16 };

typedef struct Worker {
    Session *session;
    Loaded *loaded; // what is rendered; NULL: nothing was sound yet
    Renderer *renderer;
    bool done;
    Text command;    // the command line of what is rendered, but for exposure and tone
    Snapshot *under; // the coarse picture
    double speed;    // samples a second, as last measured; 0: not yet
    double restarted_at, slice_ends, status_at, picture_seconds;
    double asked_at; // when the change came that no picture answers yet; NAN: none
    bool preloaded;
    uint64_t text_hash; // of the version that was evaluated last
} Worker;

typedef struct Job {
    Change change;
    bool files_changed, paused;
    Arena arena;
    ParamSetting *settings; // in the arena
    size_t setting_count;
} Job;

// --- Jobs ----------------------------------------------------------------------------------------

static bool take_settings(Session *session, Job *job)
{
    size_t count = session->overrides.count;
    job->settings = arena_array(&job->arena, count + 1, sizeof *job->settings);
    for (size_t i = 0; job->settings && i < count; ++i) {
        const Override *override = &session->overrides.items[i];
        Str name = str_from(override->name), value = str_from(override->value);
        name.at = arena_copy_string(&job->arena, name.at, name.length);
        value.at = arena_copy_string(&job->arena, value.at, value.length);
        if (!name.at || !value.at) {
            return false;
        }
        job->settings[job->setting_count++] = (ParamSetting){name, value};
    }
    return job->settings != NULL;
}

static SessionPhase phase_of(const Worker *w, bool paused)
{
    return !w->renderer ? PHASE_FAILED
           : w->done    ? PHASE_DONE
           : paused     ? PHASE_PAUSED
                        : PHASE_RENDERING;
}

static void set_phase(Session *session, SessionPhase phase)
{
    if (session->status.phase != phase) {
        session->status.phase = phase;
        ++session->news.status;
        pthread_cond_broadcast(&session->changed);
    }
}

// Waits until there is something to do. False when the session is closed.
static bool next_job(Worker *w, Job *job)
{
    Session *session = w->session;
    pthread_mutex_lock(&session->lock);
    while (!atomic_load(&session->closing) && session->change == CHANGE_NOTHING &&
           (!w->renderer || w->done || session->paused)) {
        set_phase(session, phase_of(w, session->paused));
        pthread_cond_wait(&session->changed, &session->lock);
    }
    *job = (Job){.change = session->change,
                 .files_changed = session->files_changed,
                 .paused = session->paused};
    if (job->change != CHANGE_NOTHING) {
        w->asked_at = session->asked_at;
    }
    bool good = job->change != CHANGE_SCENE || take_settings(session, job);
    session->change = CHANGE_NOTHING;
    session->files_changed = false;
    atomic_store(&session->stop, GO_ON);
    atomic_store(&session->outdated, atomic_load(&session->closing));
    bool open = !atomic_load(&session->closing);
    SessionPhase asked = job->change == CHANGE_SCENE    ? PHASE_EVALUATING
                         : job->change == CHANGE_CAMERA ? PHASE_RENDERING
                                                        : phase_of(w, session->paused);
    set_phase(session, asked);
    pthread_mutex_unlock(&session->lock);
    if (!good) {
        job->change = CHANGE_NOTHING; // without memory: the next request tries again
    }
    return open;
}

// --- Pictures ------------------------------------------------------------------------------------

static void publish(Worker *w, Snapshot *picture)
{
    Session *session = w->session;
    pthread_mutex_lock(&session->lock);
    Snapshot *old = session->picture;
    picture->number = old ? old->number + 1 : 1;
    session->picture = picture;
    session->status.error = picture->error;
    if (!isnan(w->asked_at)) {
        session->status.first_picture = clock_seconds() - w->asked_at;
        w->asked_at = NAN;
    }
    ++session->news.picture;
    ++session->news.status;
    pthread_cond_broadcast(&session->changed);
    pthread_mutex_unlock(&session->lock);
    snapshot_release(old);
}

static Snapshot *take_picture(Worker *w, Renderer *renderer, const Snapshot *under)
{
    Snapshot *picture = snapshot_new(renderer_film(renderer), renderer_film_params(renderer),
                                     renderer_camera(renderer), w->loaded, under);
    const size_t size = w->command.length + 1;
    if (picture && w->command.bytes && !w->command.failed) {
        picture->command = mem_alloc(size, 1);
    }
    if (picture && picture->command) {
        memcpy(picture->command, w->command.bytes, size);
    }
    return picture;
}

// --- Starting anew -------------------------------------------------------------------------------

typedef struct View { // of one start
    uint32_t camera;
    bool moved;
    CameraParams params; // where moved
    int width, height;
} View;

static View take_view(Worker *w)
{
    Session *session = w->session;
    FilmParams film = scene_film(&w->loaded->scene);
    View view = {.width = (int)film.width, .height = (int)film.height};
    if (session->options.width > 0) {
        view.width = session->options.width;
        view.height = session->options.height;
    }
    pthread_mutex_lock(&session->lock);
    view.camera = session_camera(session, &w->loaded->scene);
    view.moved = session->moved;
    CameraPose pose = session->pose;
    pthread_mutex_unlock(&session->lock);
    Text text = {0};
    if (view.moved) {
        char message[200];
        const Schema *schema = w->loaded->scene.schema;
        pose_text(&pose, schema, &text);
        view.moved = !text.failed &&
                     camera_from_text(schema, text.bytes, &view.params, message, sizeof message);
    }
    text_free(&w->command);
    w->command =
        session_command_of(&session->options, w->loaded, view.camera, view.moved ? text.bytes : "");
    text_free(&text);
    return view;
}

static void on_progress(void *context, const RenderProgress *progress);

static RenderOptions options_for(const Worker *w, const View *view)
{
    const SessionOptions *options = &w->session->options;
    return (RenderOptions){.threads = options->scene.threads,
                           .width = view->width,
                           .height = view->height,
                           .samples = options->samples,
                           .seed = options->seed,
                           .stop = &w->session->stop,
                           .progress = on_progress,
                           .context = (void *)w,
                           .world = w->loaded->world,
                           .camera = view->moved ? &view->params : NULL};
}

// How many pixels of the film's side go into one of the coarse picture's.
static int coarseness(const Worker *w, const View *view)
{
    double pixels = (double)view->width * view->height;
    double seconds = pixels / (w->speed > 0 ? w->speed : GUESSED_SPEED);
    int factor = (int)ceil(sqrt(seconds / COARSE_SECONDS));
    int smaller_side = view->width < view->height ? view->width : view->height;
    while (factor > 1 && smaller_side / factor < LEAST_COARSE_SIDE) {
        --factor;
    }
    return factor < COARSEST ? factor : COARSEST;
}

static void measure_speed(Worker *w, const RenderStats *stats)
{
    if (stats->samples > 1000 && stats->render_seconds > 1e-4) {
        w->speed = (double)stats->samples / stats->render_seconds;
    }
}

static void render_coarse(Worker *w, const View *view, DiagSink *sink)
{
    View small = *view;
    int factor = coarseness(w, view);
    if (factor <= 1) {
        return;
    }
    small.width = view->width / factor;
    small.height = view->height / factor;
    RenderOptions options = options_for(w, &small);
    options.samples = 1;
    options.progress = NULL;
    options.stop = &w->session->closing;
    Renderer *renderer = renderer_new(&w->loaded->scene, &options, sink);
    RenderStats stats;
    if (renderer && renderer_run(renderer, &stats) && !stats.stopped) {
        measure_speed(w, &stats);
        w->under = take_picture(w, renderer, NULL);
        if (w->under) {
            w->under->coarse = true;
            publish(w, snapshot_keep(w->under));
        }
    }
    renderer_free(renderer);
}

static void drop_renderer(Worker *w)
{
    renderer_free(w->renderer);
    snapshot_release(w->under);
    w->renderer = NULL;
    w->under = NULL;
    w->done = false;
}

// Makes a renderer for the film, after a coarse picture. `sink` hears what it has to say.
static void restart(Worker *w, DiagSink *sink)
{
    Session *session = w->session;
    drop_renderer(w);
    View view = take_view(w);
    w->loaded->scene.camera = view.camera;
    render_coarse(w, &view, sink);
    RenderOptions options = options_for(w, &view);
    w->renderer = renderer_new(&w->loaded->scene, &options, sink);
    w->restarted_at = clock_seconds();
    pthread_mutex_lock(&session->lock);
    SessionStatus *status = &session->status;
    status->width = (uint32_t)view.width;
    status->height = (uint32_t)view.height;
    status->samples = status->fraction = status->seconds = status->rays_per_second = 0;
    status->wanted = w->renderer ? renderer_params(w->renderer)->samples : 0;
    status->seconds_left = INFINITY;
    ++session->news.view;
    ++session->news.status;
    pthread_cond_broadcast(&session->changed);
    pthread_mutex_unlock(&session->lock);
}

static void restart_quietly(Worker *w)
{
    Arena arena = {0};
    DiagSink sink;
    diag_sink_init(&sink, &arena);
    restart(w, &sink);
    diag_sink_free(&sink);
    arena_free(&arena);
}

// --- Loading -------------------------------------------------------------------------------------

// Drops what the scene doesn't take any more. True if anything was dropped.
static bool drop_bad_settings(Session *session, const Loaded *loaded, Job *job)
{
    size_t kept = 0;
    for (size_t i = 0; i < job->setting_count; ++i) {
        if (session_param_is_good(loaded, job->settings[i].name)) {
            job->settings[kept++] = job->settings[i];
        }
    }
    if (kept == job->setting_count) {
        return false;
    }
    pthread_mutex_lock(&session->lock);
    session_keep_overrides(session, job->settings, kept);
    pthread_mutex_unlock(&session->lock);
    job->setting_count = kept;
    return true;
}

static void announce(Worker *w, Loaded *loaded, bool sound)
{
    Session *session = w->session;
    pthread_mutex_lock(&session->lock);
    Loaded *old = session->loaded, *old_shown = NULL;
    session->loaded = loaded;
    if (sound) {
        old_shown = session->shown;
        session->shown = loaded_keep(loaded);
    }
    if (session_params_are_whole(&loaded->params)) {
        text_free(&session->params);
        text_write(&session->params, loaded->params.bytes, loaded->params.length);
    }
    session->status.worlds += loaded->world != NULL;
    session->status.errors = loaded->lang.sink.errors;
    session->status.warnings = loaded->lang.sink.warnings;
    ++session->news.scene;
    ++session->news.view;
    ++session->news.status;
    pthread_cond_broadcast(&session->changed);
    pthread_mutex_unlock(&session->lock);
    loaded_release(old);
    loaded_release(old_shown);
}

// Evaluates the scene. With errors, what was rendered before goes on.
static void load(Worker *w, Job *job)
{
    Session *session = w->session;
    file_watch_begin(session->files);
    Loaded *loaded =
        loaded_new(&session->options.scene, job->settings, job->setting_count, session->files);
    // The file may have been saved after the job was taken.
    bool changed = loaded && (job->files_changed || loaded->text_hash != w->text_hash);
    if (changed && loaded->bad_setting && drop_bad_settings(session, loaded, job)) {
        loaded_release(loaded);
        loaded =
            loaded_new(&session->options.scene, job->settings, job->setting_count, session->files);
    }
    if (!loaded || loaded->stopped) {
        loaded_release(loaded);
        return; // without memory until the next request; or there is one already
    }
    w->text_hash = loaded->text_hash;
    if (loaded->world) {
        drop_renderer(w);
        loaded_release(w->loaded);
        w->loaded = loaded_keep(loaded);
        restart(w, &loaded->lang.sink);
    }
    announce(w, loaded, w->renderer && w->loaded == loaded);
}

// --- Refining ------------------------------------------------------------------------------------

static double slice_seconds(const Worker *w, double now)
{
    double since = now - w->restarted_at;
    double seconds = since < 1 ? 0.1 : since < 5 ? 0.25 : 1;
    return fmax(seconds, 8 * w->picture_seconds);
}

// From a thread that renders: says how far it is, and ends the slice when it is over.
static void on_progress(void *context, const RenderProgress *progress)
{
    Worker *w = context;
    Session *session = w->session;
    double now = clock_seconds();
    if (now > w->slice_ends) {
        int expected = GO_ON;
        atomic_compare_exchange_strong(&session->stop, &expected, STOP_FOR_PICTURE);
    }
    if (now < w->status_at + STATUS_SECONDS && !progress->pass_done) {
        return;
    }
    w->status_at = now;
    pthread_mutex_lock(&session->lock);
    SessionStatus *status = &session->status;
    status->fraction = progress->fraction;
    status->samples = (double)progress->samples / (double)film_pixel_count(progress->film);
    status->seconds = progress->seconds;
    status->seconds_left = progress->seconds_left;
    status->rays_per_second =
        progress->seconds > 0 ? (double)progress->rays / progress->seconds : 0;
    ++session->news.status;
    pthread_cond_broadcast(&session->changed);
    pthread_mutex_unlock(&session->lock);
}

// Renders for a while and shows what there is then.
static void refine(Worker *w)
{
    Session *session = w->session;
    double now = clock_seconds();
    w->slice_ends = now + slice_seconds(w, now);
    RenderStats stats;
    bool rendered = renderer_run(w->renderer, &stats);
    measure_speed(w, &stats);
    w->done = !rendered || !stats.stopped;
    int expected = STOP_FOR_PICTURE;
    atomic_compare_exchange_strong(&session->stop, &expected, GO_ON);
    if (!rendered || expected == STOP_FOR_REQUEST) {
        return; // it would be out of date
    }
    double began = clock_seconds();
    Snapshot *picture = take_picture(w, w->renderer, w->under);
    if (picture) {
        publish(w, picture);
    }
    w->picture_seconds = clock_seconds() - began;
    if (!w->preloaded) {
        image_preload(""); // for textures to come, and for saving pictures
        w->preloaded = true;
    }
}

void *session_work(void *context)
{
    Worker w = {.session = context, .asked_at = NAN};
    Job job;
    while (next_job(&w, &job)) {
        if (job.change == CHANGE_SCENE) {
            load(&w, &job);
        } else if (job.change == CHANGE_CAMERA && w.loaded) {
            restart_quietly(&w);
        }
        if (w.renderer && !w.done && !job.paused) {
            refine(&w);
        }
        arena_free(&job.arena);
    }
    arena_free(&job.arena);
    drop_renderer(&w);
    loaded_release(w.loaded);
    text_free(&w.command);
    return NULL;
}
