// What a session says: as JSON for a page, and as text.
#include "watch/session_internal.h"

#include "base/diag_write.h"
#include "base/mem.h"
#include "render/render.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <string.h>

// The JSON's text; frees it. A failed Text without memory.
static Text print_json(cJSON *json)
{
    Text text = {0};
    char *printed = json ? cJSON_PrintUnformatted(json) : NULL;
    if (printed) {
        text_write(&text, printed, strlen(printed));
        cJSON_free(printed);
    } else {
        text.failed = true;
    }
    cJSON_Delete(json);
    return text;
}

// --- Params --------------------------------------------------------------------------------------

bool session_params_are_whole(const Text *params)
{
    return !params->failed && params->length >= 2 && params->bytes[params->length - 2] == ']';
}

bool session_param_is_good(const Loaded *loaded, Str name)
{
    cJSON *params = session_params_are_whole(&loaded->params)
                        ? cJSON_ParseWithLength(loaded->params.bytes, loaded->params.length)
                        : NULL;
    bool good = !params; // unknown: not to be blamed
    const cJSON *param;
    cJSON_ArrayForEach(param, params)
    {
        const char *own = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(param, "name"));
        if (own && str_equal(str_from(own), name)) {
            good = !cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(param, "value"));
        }
    }
    cJSON_Delete(params);
    return good;
}

// --- Diagnostics ---------------------------------------------------------------------------------

static const char *severity_name(Severity severity)
{
    return severity == SEVERITY_ERROR ? "error" : severity == SEVERITY_WARNING ? "warning" : "note";
}

// One diagnostic's text with its carets.
static void write_diagnostic(Loaded *loaded, uint32_t index, Text *text)
{
    DiagSink one = loaded->lang.sink;
    one.items += index;
    one.count = 1;
    one.dropped = 0;
    one.out_of_memory = false;
    FILE *stream = text_stream(text);
    if (stream) {
        pthread_mutex_lock(&loaded->lock);
        diag_write_text(&one, &loaded->lang.sources, stream, DIAG_PLAIN);
        pthread_mutex_unlock(&loaded->lock);
        fclose(stream);
    }
}

static cJSON *diagnostic_json(Loaded *loaded, uint32_t index)
{
    const Diag *diag = &loaded->lang.sink.items[index];
    Text text = {0};
    write_diagnostic(loaded, index, &text);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "severity", severity_name(diag->severity));
    cJSON_AddStringToObject(json, "code", diag_info(diag->code)->name);
    cJSON_AddStringToObject(json, "message", diag->message);
    cJSON_AddStringToObject(json, "text", text.bytes ? text.bytes : "");
    const Source *source = source_get(&loaded->lang.sources, diag->at.file);
    if (source) {
        pthread_mutex_lock(&loaded->lock);
        Place place = source_place(&loaded->lang.sources, diag->at.file, diag->at.begin);
        pthread_mutex_unlock(&loaded->lock);
        cJSON_AddStringToObject(json, "file", source->path);
        cJSON_AddNumberToObject(json, "line", place.line);
        cJSON_AddNumberToObject(json, "column", place.column);
    }
    text_free(&text);
    return json;
}

static cJSON *diagnostics_json(Loaded *loaded)
{
    cJSON *list = cJSON_CreateArray();
    const DiagSink *sink = &loaded->lang.sink;
    uint32_t *order = diag_sorted(sink);
    for (uint32_t i = 0; i < sink->count; ++i) {
        cJSON_AddItemToArray(list, diagnostic_json(loaded, order ? order[i] : i));
    }
    mem_free(order);
    return list;
}

Text session_diagnostics(Session *session)
{
    Text text = {0};
    pthread_mutex_lock(&session->lock);
    Loaded *loaded = session->loaded ? loaded_keep(session->loaded) : NULL;
    pthread_mutex_unlock(&session->lock);
    FILE *stream = loaded ? text_stream(&text) : NULL;
    if (stream) {
        pthread_mutex_lock(&loaded->lock);
        diag_write_text(&loaded->lang.sink, &loaded->lang.sources, stream, DIAG_PLAIN);
        pthread_mutex_unlock(&loaded->lock);
        fclose(stream);
    }
    loaded_release(loaded);
    return text;
}

// --- The scene -----------------------------------------------------------------------------------

static cJSON *cameras_json(Loaded *shown)
{
    cJSON *list = cJSON_CreateArray();
    const Scene *scene = &shown->scene;
    const SceneNodeArray *cameras = &scene->nodes[CATEGORY_CAMERA];
    for (size_t i = 0; i < cameras->count && i < 1000; ++i) {
        char place[300];
        loaded_place(shown, cameras->items[i].at, place, sizeof place);
        cJSON *json = cJSON_CreateObject();
        cJSON_AddStringToObject(json, "name", scene->names.items[cameras->items[i].name]);
        cJSON_AddStringToObject(json, "place", place);
        cJSON_AddItemToArray(list, json);
    }
    return list;
}

static cJSON *tones_json(void)
{
    cJSON *list = cJSON_CreateArray();
    for (int i = 0; tone_names[i]; ++i) {
        cJSON_AddItemToArray(list, cJSON_CreateString(tone_names[i]));
    }
    return list;
}

// The params, on one line.
static cJSON *params_json(const Text *params)
{
    cJSON *json = params->bytes ? cJSON_ParseWithLength(params->bytes, params->length) : NULL;
    return json ? json : cJSON_CreateArray();
}

Text session_scene_json(Session *session)
{
    pthread_mutex_lock(&session->lock);
    Loaded *loaded = session->loaded ? loaded_keep(session->loaded) : NULL;
    Loaded *shown = session->shown ? loaded_keep(session->shown) : NULL;
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "file", session->options.scene.file);
    cJSON_AddBoolToObject(json, "loaded", loaded != NULL);
    cJSON_AddItemToObject(json, "tones", tones_json());
    cJSON_AddItemToObject(json, "params", params_json(&session->params));
    pthread_mutex_unlock(&session->lock);
    if (loaded) {
        cJSON_AddItemToObject(json, "diagnostics", diagnostics_json(loaded));
        cJSON_AddNumberToObject(json, "errors", loaded->lang.sink.errors);
        cJSON_AddNumberToObject(json, "warnings", loaded->lang.sink.warnings);
        cJSON_AddNumberToObject(json, "dropped", loaded->lang.sink.dropped);
    }
    if (shown) {
        cJSON_AddItemToObject(json, "cameras", cameras_json(shown));
    }
    loaded_release(loaded);
    loaded_release(shown);
    return print_json(json);
}

// --- The view ------------------------------------------------------------------------------------

static void write_camera(const Session *session, Text *text)
{
    if (session->moved && session->shown) {
        pose_text(&session->pose, session->shown->scene.schema, text);
    }
}

static void command_option(Text *text, const char *option, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static void command_option(Text *text, const char *option, const char *format, ...)
{
    char value[100];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(value, sizeof value, format, arguments);
    va_end(arguments);
    text_shell_word(text, option);
    text_shell_word(text, value);
}

static void command_setting(Text *text, Str name, Str value)
{
    Text setting = {0};
    text_print(&setting, "%.*s=%.*s", (int)name.length, name.at, (int)value.length, value.at);
    if (!setting.failed) {
        text_shell_word(text, "--set");
        text_shell_word(text, setting.bytes);
    }
    text_free(&setting);
}

static void command_camera(Text *text, const Scene *scene, uint32_t number, const char *pose)
{
    const char *name = scene && number != NONE_ID
                           ? scene->names.items[scene_node(scene, CATEGORY_CAMERA, number)->name]
                           : "";
    if (*pose || (number > 0 && *name)) {
        text_shell_word(text, "--camera");
        text_shell_word(text, *pose ? pose : name);
    }
}

// Those that aren't what they are without being named.
static void command_limits(Text *text, const Limits *limits)
{
    const Limits standard = limits_default();
#define LIMIT(id, value, explanation)                                                              \
    if (limits->id != standard.id) {                                                               \
        command_option(text, "--limit", #id "=%" PRIu64, limits->id);                              \
    }
    LIMITS(LIMIT)
#undef LIMIT
}

static void command_scene(Text *text, const SessionOptions *options)
{
    text_shell_word(text, "scnrender");
    text_shell_word(text, "render");
    text_shell_word(text, options->scene.file);
}

// What stands behind the settings and the camera.
static void command_rest(Text *text, const SessionOptions *options)
{
    if (options->width > 0) {
        command_option(text, "--size", "%dx%d", options->width, options->height);
    }
    if (options->samples > 0) {
        command_option(text, "--samples", "%lld", (long long)options->samples);
    }
    if (options->seed >= 0) {
        command_option(text, "--seed", "%lld", (long long)options->seed);
    }
    for (size_t i = 0; i < options->scene.folder_count; ++i) {
        text_shell_word(text, "--allow-path");
        text_shell_word(text, options->scene.folders[i]);
    }
    command_limits(text, &options->scene.limits);
}

void session_command_look(Text *text, const FilmParams *film, double exposure, int tone)
{
    if (!isnan(exposure) && exposure != film->exposure) {
        command_option(text, "--exposure", "%.6g", exposure);
    }
    if (tone >= 0 && tone != film->tone) {
        command_option(text, "--tone", "%s", tone_names[tone]);
    }
}

Text session_command_of(const SessionOptions *options, const Loaded *loaded, uint32_t camera,
                        const char *pose)
{
    Text text = {0};
    command_scene(&text, options);
    for (size_t i = 0; i < loaded->lang.setting_count; ++i) {
        command_setting(&text, loaded->settings[i].name, loaded->settings[i].value);
    }
    command_camera(&text, &loaded->scene, camera, pose);
    command_rest(&text, options);
    return text;
}

static void write_command(const Session *session, Text *text)
{
    const SessionOptions *options = &session->options;
    const Scene *scene = session->shown ? &session->shown->scene : NULL;
    command_scene(text, options);
    for (size_t i = 0; i < options->scene.setting_count; ++i) {
        command_setting(text, options->scene.settings[i].name, options->scene.settings[i].value);
    }
    for (size_t i = 0; i < session->overrides.count; ++i) {
        command_setting(text, str_from(session->overrides.items[i].name),
                        str_from(session->overrides.items[i].value));
    }
    Text pose = {0};
    write_camera(session, &pose);
    command_camera(text, scene, scene ? session_camera(session, scene) : NONE_ID,
                   pose.bytes ? pose.bytes : "");
    text_free(&pose);
    command_rest(text, options);
    if (session->shown) {
        const FilmParams film = scene_film(&session->shown->scene);
        session_command_look(text, &film, session->exposure, session->tone);
    }
}

Text session_command(Session *session)
{
    Text text = {0};
    pthread_mutex_lock(&session->lock);
    write_command(session, &text);
    pthread_mutex_unlock(&session->lock);
    return text;
}

Text session_camera_text(Session *session)
{
    Text text = {0};
    pthread_mutex_lock(&session->lock);
    write_camera(session, &text);
    pthread_mutex_unlock(&session->lock);
    return text;
}

static void add_optional(cJSON *json, const char *name, double value)
{
    if (isfinite(value)) {
        cJSON_AddNumberToObject(json, name, value);
    } else {
        cJSON_AddNullToObject(json, name);
    }
}

static void add_camera(const Session *session, cJSON *json)
{
    const Scene *scene = session->shown ? &session->shown->scene : NULL;
    uint32_t number = scene ? session_camera(session, scene) : NONE_ID;
    add_optional(json, "camera", number == NONE_ID ? (double)NAN : (double)number);
    cJSON_AddBoolToObject(json, "moved", session->moved);
    Text camera = {0};
    write_camera(session, &camera);
    cJSON_AddStringToObject(json, "camera_text", camera.bytes ? camera.bytes : "");
    text_free(&camera);
    if (session->picture) {
        const CameraParams *params = &session->picture->camera.params;
        cJSON_AddNumberToObject(json, "projection", params->projection);
        cJSON_AddNumberToObject(json, "fov", session->moved ? session->pose.fov : params->fov);
        cJSON_AddNumberToObject(json, "aperture",
                                session->moved ? session->pose.aperture : params->aperture);
    }
}

static void add_look(const Session *session, cJSON *json)
{
    if (session->shown) {
        FilmParams film = scene_film(&session->shown->scene);
        cJSON_AddNumberToObject(json, "exposure",
                                isnan(session->exposure) ? film.exposure : session->exposure);
        cJSON_AddNumberToObject(json, "scene_exposure", film.exposure);
        cJSON_AddNumberToObject(json, "tone", session->tone < 0 ? film.tone : session->tone);
        cJSON_AddNumberToObject(json, "scene_tone", film.tone);
    }
}

Text session_view_json(Session *session)
{
    cJSON *json = cJSON_CreateObject();
    pthread_mutex_lock(&session->lock);
    add_camera(session, json);
    add_look(session, json);
    cJSON *settings = cJSON_AddObjectToObject(json, "settings");
    for (size_t i = 0; i < session->overrides.count; ++i) {
        cJSON_AddStringToObject(settings, session->overrides.items[i].name,
                                session->overrides.items[i].value);
    }
    Text command = {0};
    write_command(session, &command);
    cJSON_AddStringToObject(json, "command", command.bytes ? command.bytes : "");
    cJSON_AddBoolToObject(json, "paused", session->paused);
    pthread_mutex_unlock(&session->lock);
    text_free(&command);
    return print_json(json);
}

// --- The status ----------------------------------------------------------------------------------

Text session_status_json(Session *session)
{
    static const char *const phases[] = {[PHASE_EVALUATING] = "evaluating",
                                         [PHASE_RENDERING] = "rendering",
                                         [PHASE_DONE] = "done",
                                         [PHASE_PAUSED] = "paused",
                                         [PHASE_FAILED] = "failed"};
    SessionStatus status = session_status(session);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "phase", phases[status.phase]);
    cJSON_AddNumberToObject(json, "width", status.width);
    cJSON_AddNumberToObject(json, "height", status.height);
    cJSON_AddNumberToObject(json, "samples", status.samples);
    cJSON_AddNumberToObject(json, "wanted", (double)status.wanted);
    cJSON_AddNumberToObject(json, "fraction", status.fraction);
    cJSON_AddNumberToObject(json, "seconds", status.seconds);
    add_optional(json, "seconds_left", status.seconds_left);
    cJSON_AddNumberToObject(json, "rays_per_second", status.rays_per_second);
    add_optional(json, "error", status.error);
    add_optional(json, "first_picture", status.first_picture);
    cJSON_AddNumberToObject(json, "worlds", (double)status.worlds);
    return print_json(json);
}
