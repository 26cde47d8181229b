// One evaluated version of the scene: its sources and diagnostics, the flat scene and the world.
//
// The thread that renders makes it; the threads that answer questions about a picture keep it alive
// for as long as they look at it, and change nothing.
#ifndef WATCH_LOADED_H
#define WATCH_LOADED_H

#include "lang/lang.h"
#include "render/world.h"
#include "watch/files.h"
#include "watch/text.h"

#include <pthread.h>
#include <stdatomic.h>

// What the command line says of the scene. Strings and lists are the caller's.
typedef struct SceneRequest {
    const char *file; // as the user named it
    const ParamSetting *settings;
    size_t setting_count;
    const char *const *folders; // further ones that it may read from
    size_t folder_count;
    Limits limits;
    unsigned threads;              // 0: one a processor
    FILE *print_to;                // where print() writes; NULL: nowhere
    struct PictureCache *pictures; // between versions; may be NULL
    struct MeshCache *meshes;      // the same
    const atomic_int *stop;        // not zero: evaluation is to be given up; may be NULL
} SceneRequest;

typedef struct Loaded {
    unsigned references;  // guarded by `lock`
    pthread_mutex_t lock; // also of lang.sources, whose tables of lines are made on first need
    Arena arena;
    ParamSetting *settings; // of this version
    Sandbox sandbox;
    Lang lang;
    Scene scene;
    World *world; // NULL: the scene has errors, which lang.sink tells
    Text params;  // the scene's params as JSON, as far as they could be evaluated; maybe empty
    bool has_lang, has_scene;
    bool stopped;       // evaluation was given up: there is no scene, and maybe no diagnostic
    uint64_t text_hash; // of the scene's file and its imports, as far as they were read
    bool bad_setting;   // an error lies in a setting, or a setting is of no param
} Loaded;

// Evaluates the file as it is now, with `settings` after those of the request, and builds the
// world. Every file that is opened for it is added to `files`. NULL without memory.
Loaded *loaded_new(const SceneRequest *request, const ParamSetting *settings, size_t setting_count,
                   FileWatch *files);
Loaded *loaded_keep(Loaded *loaded);
void loaded_release(Loaded *loaded); // NULL is fine

// The scene's file and line of a span: "scene.scn:12" in text; "" for nowhere.
void loaded_place(Loaded *loaded, Span at, char *text, size_t size);

#endif
