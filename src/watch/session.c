// Requests and answers. All of it holds the lock for as long as it takes to copy a few values.
#include "watch/session_internal.h"

#include "base/clock.h"
#include "base/mem.h"
#include "render/picture_cache.h"
#include "scene/mesh_cache.h"
#include "watch/inspect.h"

#include <math.h>
#include <signal.h>
#include <string.h>
#include <time.h>

// --- Beginning and end ---------------------------------------------------------------------------

static void files_changed(void *context)
{
    session_reload(context);
}

static void make_condition(pthread_cond_t *condition)
{
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(condition, &attributes);
    pthread_condattr_destroy(&attributes);
}

static bool start_thread(Session *session)
{
    sigset_t all, before; // signals are for those who can end the program
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    session->files = file_watch_new(files_changed, session, session->options.polling);
    session->started =
        session->files && pthread_create(&session->thread, NULL, session_work, session) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return session->started;
}

Session *session_new(const SessionOptions *options, char *message, size_t message_size)
{
    Session *session = mem_alloc_zeroed(1, sizeof *session);
    if (!session) {
        snprintf(message, message_size, "not enough memory");
        return NULL;
    }
    session->options = *options;
    atomic_init(&session->stop, GO_ON);
    atomic_init(&session->closing, 0);
    atomic_init(&session->outdated, 0);
    session->options.scene.stop = &session->outdated;
    session->options.scene.pictures = picture_cache_new();
    session->options.scene.meshes = mesh_cache_new();
    pthread_mutex_init(&session->lock, NULL);
    make_condition(&session->changed);
    session->camera = NONE_ID;
    session->exposure = NAN;
    session->tone = -1;
    session->change = CHANGE_SCENE;
    session->asked_at = clock_seconds();
    session->news = (SessionNews){1, 1, 1, 0};
    session->status = (SessionStatus){
        .phase = PHASE_EVALUATING, .seconds_left = INFINITY, .error = NAN, .first_picture = NAN};
    if (!start_thread(session)) {
        snprintf(message, message_size, "no thread can be started");
        session_free(session);
        return NULL;
    }
    return session;
}

void session_close(Session *session)
{
    pthread_mutex_lock(&session->lock);
    atomic_store(&session->closing, 1);
    atomic_store(&session->outdated, 1);
    atomic_store(&session->stop, STOP_FOR_REQUEST);
    pthread_cond_broadcast(&session->changed);
    pthread_mutex_unlock(&session->lock);
}

static void free_overrides(OverrideArray *overrides)
{
    for (size_t i = 0; i < overrides->count; ++i) {
        mem_free(overrides->items[i].name);
        mem_free(overrides->items[i].value);
    }
    array_free(overrides);
}

void session_free(Session *session)
{
    if (!session) {
        return;
    }
    session_close(session);
    if (session->started) {
        pthread_join(session->thread, NULL);
    }
    file_watch_free(session->files);
    snapshot_release(session->picture);
    loaded_release(session->loaded);
    loaded_release(session->shown);
    free_overrides(&session->overrides);
    text_free(&session->params);
    picture_cache_free(session->options.scene.pictures);
    mesh_cache_free(session->options.scene.meshes);
    pthread_cond_destroy(&session->changed);
    pthread_mutex_destroy(&session->lock);
    mem_free(session);
}

// --- News ----------------------------------------------------------------------------------------

static bool is_newer(const SessionNews *news, const SessionNews *seen)
{
    return news->scene != seen->scene || news->view != seen->view || news->status != seen->status ||
           news->picture != seen->picture;
}

bool session_wait(Session *session, SessionNews *seen, int milliseconds)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += milliseconds / 1000;
    until.tv_nsec += (long)(milliseconds % 1000) * 1000000;
    if (until.tv_nsec >= 1000000000) {
        ++until.tv_sec;
        until.tv_nsec -= 1000000000;
    }
    pthread_mutex_lock(&session->lock);
    int over = 0;
    while (!over && !atomic_load(&session->closing) && !is_newer(&session->news, seen)) {
        over = pthread_cond_timedwait(&session->changed, &session->lock, &until);
    }
    *seen = session->news;
    bool open = !atomic_load(&session->closing);
    pthread_mutex_unlock(&session->lock);
    return open;
}

SessionStatus session_status(Session *session)
{
    pthread_mutex_lock(&session->lock);
    SessionStatus status = session->status;
    pthread_mutex_unlock(&session->lock);
    return status;
}

Snapshot *session_picture(Session *session, SessionLook *look)
{
    pthread_mutex_lock(&session->lock);
    Snapshot *picture = session->picture ? snapshot_keep(session->picture) : NULL;
    if (picture) {
        *look = (SessionLook){isnan(session->exposure) ? picture->film.exposure : session->exposure,
                              session->tone < 0 ? (ToneCurve)picture->film.tone
                                                : (ToneCurve)session->tone};
    }
    pthread_mutex_unlock(&session->lock);
    return picture;
}

// --- Requests ------------------------------------------------------------------------------------

// With the lock held: something is to be done again, and something is to be said of it.
static void ask(Session *session, Change change)
{
    if (session->change == CHANGE_NOTHING) {
        session->asked_at = clock_seconds();
    }
    if (change > session->change) {
        session->change = change;
    }
    atomic_store(&session->stop, STOP_FOR_REQUEST);
    session->status.phase = change == CHANGE_SCENE ? PHASE_EVALUATING : PHASE_RENDERING;
    ++session->news.status;
    ++session->news.view;
    pthread_cond_broadcast(&session->changed);
}

void session_reload(Session *session)
{
    pthread_mutex_lock(&session->lock);
    session->files_changed = true;
    atomic_store(&session->outdated, 1); // by settings alone it isn't: a slider would never end
    ask(session, CHANGE_SCENE);
    pthread_mutex_unlock(&session->lock);
}

static Override *find_override(Session *session, const char *name)
{
    for (size_t i = 0; i < session->overrides.count; ++i) {
        if (strcmp(session->overrides.items[i].name, name) == 0) {
            return &session->overrides.items[i];
        }
    }
    return NULL;
}

static char *copy_text(const char *text)
{
    size_t size = strlen(text) + 1;
    char *copy = mem_alloc(size, 1);
    return copy ? memcpy(copy, text, size) : NULL;
}

// A name, or those of a namespace and of a param of its file.
static bool is_name(const char *name)
{
    size_t length = strlen(name);
    for (size_t i = 0; i < length; ++i) {
        unsigned char c = (unsigned char)name[i];
        if (c < 128 && c != '_' && c != '.' && !(c >= '0' && c <= '9') && !(c >= 'a' && c <= 'z') &&
            !(c >= 'A' && c <= 'Z')) {
            return false;
        }
    }
    return length > 0 && length <= 200;
}

static void remove_override(Session *session, Override *override)
{
    mem_free(override->name);
    mem_free(override->value);
    size_t at = (size_t)(override - session->overrides.items);
    memmove(override, override + 1, (--session->overrides.count - at) * sizeof *override);
}

// With the lock held; takes over the value. False without memory.
static bool put_override(Session *session, const char *name, char *value)
{
    Override *override = find_override(session, name);
    if (override) {
        mem_free(override->value);
        override->value = value;
        return true;
    }
    char *own_name = copy_text(name);
    bool put = own_name && array_push(&session->overrides, (Override){own_name, value});
    if (!put) {
        mem_free(own_name);
        mem_free(value);
    }
    return put;
}

void session_keep_overrides(Session *session, const ParamSetting *settings, size_t count)
{
    for (size_t i = session->overrides.count; i-- > 0;) {
        bool kept = false;
        for (size_t k = 0; k < count; ++k) {
            kept |= str_equal(settings[k].name, str_from(session->overrides.items[i].name));
        }
        if (!kept) {
            remove_override(session, &session->overrides.items[i]);
        }
    }
}

bool session_set(Session *session, const char *name, const char *value, char *message,
                 size_t message_size)
{
    if (!is_name(name) || (value && strlen(value) > 4000)) {
        snprintf(message, message_size, "that is not the name and value of a param");
        return false;
    }
    char *copy = value ? copy_text(value) : NULL;
    bool good = copy || !value;
    pthread_mutex_lock(&session->lock);
    Override *old = find_override(session, name);
    if (!value && old) {
        remove_override(session, old);
        ask(session, CHANGE_SCENE);
    } else if (copy) {
        good = put_override(session, name, copy);
        ask(session, CHANGE_SCENE);
    }
    pthread_mutex_unlock(&session->lock);
    if (!good) {
        snprintf(message, message_size, "not enough memory");
    }
    return good;
}

void session_reset(Session *session)
{
    pthread_mutex_lock(&session->lock);
    if (session->overrides.count > 0) {
        free_overrides(&session->overrides);
        ask(session, CHANGE_SCENE);
    }
    pthread_mutex_unlock(&session->lock);
}

uint32_t session_camera(const Session *session, const Scene *scene)
{
    size_t count = scene->nodes[CATEGORY_CAMERA].count;
    if (session->camera < count) {
        return session->camera;
    }
    uint32_t named = session->options.camera
                         ? scene_find_camera(scene, str_from(session->options.camera))
                         : NONE_ID;
    return named != NONE_ID ? named : count > 0 ? 0 : NONE_ID;
}

bool session_choose_camera(Session *session, uint32_t number, char *message, size_t message_size)
{
    pthread_mutex_lock(&session->lock);
    const Scene *scene = session->shown ? &session->shown->scene : NULL;
    bool good = scene && (number < scene->nodes[CATEGORY_CAMERA].count || number == NONE_ID);
    if (good) {
        session->camera = number;
        session->moved = false;
        ask(session, CHANGE_CAMERA);
    } else {
        snprintf(message, message_size, "the scene has no such camera");
    }
    pthread_mutex_unlock(&session->lock);
    return good;
}

// --- Moving the camera ---------------------------------------------------------------------------

// The moved camera, or one that is about to be. With the lock held; there is a picture.
static CameraPose current_pose(Session *session)
{
    if (session->moved) {
        return session->pose;
    }
    const Camera *camera = &session->picture->camera;
    double distance = pose_own_distance(camera);
    return pose_from_camera(camera, distance > 0 ? distance : inspect_pivot(session->picture));
}

static bool is_sane(const CameraPose *pose)
{
    double distance = length(sub(pose->target, pose->position));
    return vec3_is_finite(pose->position) && vec3_is_finite(pose->target) && distance > 1e-9 &&
           distance < 1e12 && pose->height < 1e12 && pose->aperture < 1e6 &&
           length(pose->position) < 1e12;
}

static bool move(CameraPose *pose, CameraMove by)
{
    switch (by.kind) {
    case MOVE_ORBIT:
        pose_orbit(pose, by.x, by.y);
        return true;
    case MOVE_PAN:
        pose_pan(pose, by.x, by.y);
        return true;
    case MOVE_DOLLY:
        pose_dolly(pose, by.x);
        return by.x > 0;
    case MOVE_FOV:
        pose->fov = by.x;
        return by.x > 0 && by.x < (pose->projection == CAMERA_PERSPECTIVE ? PI : 2 * PI);
    case MOVE_APERTURE:
        pose->aperture = by.x;
        return by.x >= 0;
    }
    return false;
}

bool session_move_camera(Session *session, CameraMove by, char *message, size_t message_size)
{
    bool good = isfinite(by.x) && isfinite(by.y);
    pthread_mutex_lock(&session->lock);
    if (good && session->picture) {
        CameraPose pose = current_pose(session);
        good = move(&pose, by) && is_sane(&pose);
        if (good) {
            session->pose = pose;
            session->moved = true;
            ask(session, CHANGE_CAMERA);
        }
    }
    pthread_mutex_unlock(&session->lock);
    if (!good) {
        snprintf(message, message_size, "the camera can't be moved there");
    }
    return good;
}

bool session_focus(Session *session, double x, double y, char *message, size_t message_size)
{
    SessionLook look;
    Snapshot *picture = session_picture(session, &look);
    double depth = picture ? inspect_depth(picture, x, y) : NAN;
    bool lens = picture && (picture->camera.params.projection == CAMERA_PERSPECTIVE ||
                            picture->camera.params.projection == CAMERA_ORTHOGRAPHIC);
    snapshot_release(picture);
    if (!lens || !isfinite(depth)) {
        snprintf(message, message_size,
                 lens ? "there is nothing to focus on" : "this camera has no lens to be focused");
        return false;
    }
    pthread_mutex_lock(&session->lock);
    session->pose = current_pose(session);
    session->pose.focus_distance = depth;
    session->moved = true;
    ask(session, CHANGE_CAMERA);
    pthread_mutex_unlock(&session->lock);
    return true;
}

bool session_set_look(Session *session, double exposure, int tone, char *message,
                      size_t message_size)
{
    if (isinf(exposure) || exposure < -30 || exposure > 30 || tone > (int)TONE_FILMIC) {
        snprintf(message, message_size, "the exposure lies between -30 and 30 stops");
        return false;
    }
    pthread_mutex_lock(&session->lock);
    session->exposure = exposure;
    session->tone = tone;
    ++session->news.view;
    ++session->news.picture;
    pthread_cond_broadcast(&session->changed);
    pthread_mutex_unlock(&session->lock);
    return true;
}

void session_pause(Session *session, bool paused)
{
    pthread_mutex_lock(&session->lock);
    session->paused = paused;
    atomic_store(&session->stop, STOP_FOR_REQUEST);
    pthread_cond_broadcast(&session->changed);
    pthread_mutex_unlock(&session->lock);
}
