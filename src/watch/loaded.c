#include "watch/loaded.h"

#include "base/mem.h"
#include "render/light_report.h"
#include "render/material_report.h"
#include "render/picture_cache.h"
#include "render/render.h"
#include "scene/mesh_cache.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

// --- Files -------------------------------------------------------------------------------------

static void note_file(void *context, const char *path)
{
    file_watch_add(context, path);
}

static bool fail(Loaded *loaded, const char *format, const char *name, const char *why)
{
    diag_report(&loaded->lang.sink, E0601, (Span){0}, format, name, why);
    return false;
}

static bool allow(Loaded *loaded, const char *folder)
{
    IoError error = sandbox_allow(&loaded->sandbox, folder);
    return error == IO_OK ||
           fail(loaded, "the folder `%s` can't be read: %s", folder, io_error_text(error));
}

// The scene's absolute path, after allowing its folder and those of the request.
static const char *find_scene(Loaded *loaded, const SceneRequest *request, FileWatch *files)
{
    char real[PATH_MAX];
    if (!realpath(request->file, real)) {
        file_watch_add(files, request->file);
        fail(loaded, "`%s` can't be read: %s", request->file, strerror(errno));
        return NULL;
    }
    const char *path = arena_copy_string(&loaded->arena, real, strlen(real));
    const char *slash = strrchr(real, '/');
    const char *folder =
        arena_copy_string(&loaded->arena, real, slash > real ? (size_t)(slash - real) : 1);
    if (!path || !folder || !allow(loaded, folder)) {
        return NULL;
    }
    for (size_t i = 0; i < request->folder_count; ++i) {
        if (!allow(loaded, request->folders[i])) {
            return NULL;
        }
    }
    IoError error = lang_use_library(&loaded->lang);
    if (error != IO_OK) {
        fail(loaded, "the %s can't be read: %s", "standard library", io_error_text(error));
        return NULL;
    }
    return path;
}

// --- Evaluation ----------------------------------------------------------------------------------

static bool take_settings(Loaded *loaded, const SceneRequest *request, const ParamSetting *settings,
                          size_t count)
{
    size_t all = request->setting_count + count;
    loaded->settings = arena_array(&loaded->arena, all + 1, sizeof *loaded->settings);
    for (size_t i = 0; loaded->settings && i < all; ++i) {
        const ParamSetting *from = i < request->setting_count
                                       ? &request->settings[i]
                                       : &settings[i - request->setting_count];
        const char *name = arena_copy_string(&loaded->arena, from->name.at, from->name.length);
        const char *value = arena_copy_string(&loaded->arena, from->value.at, from->value.length);
        if (!name || !value) {
            return false;
        }
        loaded->settings[i] =
            (ParamSetting){{name, from->name.length}, {value, from->value.length}};
    }
    loaded->lang.settings = loaded->settings;
    loaded->lang.setting_count = all;
    return loaded->settings != NULL;
}

// A setting that the scene doesn't take (any more): E0309 is of no place, and other errors lie in
// the setting's text, a source that is no file.
static bool has_bad_setting(const Loaded *loaded)
{
    const DiagSink *sink = &loaded->lang.sink;
    for (uint32_t i = 0; i < sink->count; ++i) {
        const Source *source = source_get(&loaded->lang.sources, sink->items[i].at.file);
        if (sink->items[i].severity == SEVERITY_ERROR &&
            (sink->items[i].code == E0309 || (source && strcmp(source->path, "--set") == 0))) {
            return true;
        }
    }
    return false;
}

static uint64_t hash_texts(const Sources *sources)
{
    uint64_t hash = 0;
    for (uint32_t file = 1; file <= sources->count; ++file) {
        const Source *source = source_get(sources, file);
        if (source && source->real) { // else a setting
            hash = XXH3_64bits_withSeed(source->text.at, source->text.length, hash);
        }
    }
    return hash;
}

static void evaluate(Loaded *loaded, const SceneRequest *request, FileWatch *files)
{
    Lang *lang = &loaded->lang;
    const char *path = find_scene(loaded, request, files);
    FILE *params = path ? text_stream(&loaded->params) : NULL;
    if (!path) {
        return;
    }
    loaded->scene.mesh_cache = request->meshes;
    lang->params_to = params;
    bool good = lang_load(lang, path, request->file, &loaded->scene);
    lang->params_to = NULL;
    loaded->scene.mesh_cache = NULL;
    loaded->stopped = request->stop && atomic_load(request->stop) != 0;
    if (params) {
        fclose(params);
    }
    loaded->bad_setting = has_bad_setting(loaded);
    loaded->text_hash = hash_texts(&lang->sources);
    if (good && !loaded->stopped) {
        light_warn_enclosed(&loaded->scene, lang->threads, &lang->sink);
        material_warn_open_glass(&loaded->scene, &lang->sink);
        mesh_cache_turn(request->meshes);
        picture_cache_turn(request->pictures);
        loaded->scene.pictures = request->pictures;
        loaded->world = world_build(&loaded->scene, request->threads, &lang->sink);
    }
}

Loaded *loaded_new(const SceneRequest *request, const ParamSetting *settings, size_t setting_count,
                   FileWatch *files)
{
    Loaded *loaded = mem_alloc_zeroed(1, sizeof *loaded);
    if (!loaded) {
        return NULL;
    }
    loaded->references = 1;
    pthread_mutex_init(&loaded->lock, NULL);
    sandbox_init(&loaded->sandbox);
    loaded->sandbox.on_open = note_file;
    loaded->sandbox.on_open_context = files;
    const Schema *schema = render_schema();
    loaded->has_lang = lang_init(&loaded->lang, schema, &loaded->sandbox);
    loaded->has_scene = loaded->has_lang && scene_init(&loaded->scene, schema, &loaded->sandbox);
    if (!loaded->has_scene || !take_settings(loaded, request, settings, setting_count)) {
        loaded_release(loaded);
        return NULL;
    }
    loaded->lang.limits = request->limits;
    loaded->lang.print_to = request->print_to;
    loaded->lang.stop = request->stop;
    loaded->lang.sink.limit = request->limits.diagnostics < UINT32_MAX
                                  ? (uint32_t)request->limits.diagnostics
                                  : UINT32_MAX;
    evaluate(loaded, request, files);
    return loaded;
}

// --- Sharing -------------------------------------------------------------------------------------

Loaded *loaded_keep(Loaded *loaded)
{
    pthread_mutex_lock(&loaded->lock);
    ++loaded->references;
    pthread_mutex_unlock(&loaded->lock);
    return loaded;
}

void loaded_release(Loaded *loaded)
{
    if (!loaded) {
        return;
    }
    pthread_mutex_lock(&loaded->lock);
    bool last = --loaded->references == 0;
    pthread_mutex_unlock(&loaded->lock);
    if (!last) {
        return;
    }
    world_free(loaded->world);
    if (loaded->has_scene) {
        scene_free(&loaded->scene);
    }
    if (loaded->has_lang) {
        lang_free(&loaded->lang);
    }
    sandbox_free(&loaded->sandbox);
    text_free(&loaded->params);
    arena_free(&loaded->arena);
    pthread_mutex_destroy(&loaded->lock);
    mem_free(loaded);
}

void loaded_place(Loaded *loaded, Span at, char *text, size_t size)
{
    const Source *source = source_get(&loaded->lang.sources, at.file);
    if (!source) {
        snprintf(text, size, "%s", "");
        return;
    }
    pthread_mutex_lock(&loaded->lock);
    Place place = source_place(&loaded->lang.sources, at.file, at.begin);
    pthread_mutex_unlock(&loaded->lock);
    snprintf(text, size, "%s:%u", source->path, (unsigned)place.line);
}
