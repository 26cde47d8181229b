// Rendering: from a flat scene to a film, and the film's figures.
#ifndef RENDER_RENDER_H
#define RENDER_RENDER_H

#include "base/diag.h"
#include "render/adaptive.h"
#include "render/camera.h"
#include "render/film.h"
#include "render/integrator.h"
#include "scene/scene.h"

#include <stdatomic.h>

// The kinds of all folders below render/ and of scene/: the program's schema.
const Schema *render_schema(void);

typedef struct RenderParams { // the `render` kind
    int32_t integrator;       // index into integrator_classes
    int64_t samples, bounces, seed;
    int32_t sampling; // SAMPLING_MIS, … (world.h)
    bool shadows, russian_roulette;
    int32_t caustics;   // CAUSTICS_PLAIN, … (world.h)
    double ao_distance; // how far "ambient_occlusion" looks, m; 0: any distance
    double clamp;       // largest radiance of an indirect sample; 0: none
    double time_limit;  // seconds; 0: none
    uint32_t stop;      // a node of category `rule`: when it is good enough; or NONE_ID
    bool samples_given; // derived: `samples` isn't the default
} RenderParams;

struct RenderProgress;

// Of zero bytes, but for seed = -1, all is as the scene says.
typedef struct RenderOptions {
    unsigned threads;  // 0: all processors
    int width, height; // 0: the film's
    int64_t samples;   // 0: the scene's
    int64_t seed;      // -1: the scene's
    // For a part of a picture: the number of its first sample, a multiple of SAMPLE_BLOCK;
    // `samples` is how many from there on. Parts are joined by film_merge.
    int64_t first_sample;
    int64_t whole_samples;       // of the whole picture, where this is a part; 0: it isn't
    double time_limit;           // seconds of rendering, after which what is done is kept; 0: none
    int tile_width, tile_height; // pixels; 0: TILE_SIZE. They change no byte
    bool aovs;
    bool even;                         // the same number of samples for all: without `stop`
    const IntegratorClass *integrator; // NULL: the scene's
    // A world that was built of the same scene before, so that only the camera or the size changes;
    // it is not owned, and no two renderers use it at once. NULL: the renderer builds its own.
    World *world;
    const CameraParams *camera; // in world space, instead of the scene's; NULL: the scene's
    const atomic_int *stop;     // non-zero: stop soon, keep what is done; may be NULL
    // Called from one of the rendering threads (one at a time), at most every 50 ms,
    // and at the end of each pass over the picture with pass_done = true, when no thread writes to
    // the film. The passes end after 1, 4, 16, 64 and then every 64 samples a pixel.
    void (*progress)(void *context, const struct RenderProgress *progress);
    void *context;
} RenderOptions;

typedef struct RenderProgress {
    const Film *film;
    double fraction; // of all samples
    double seconds, seconds_left;
    uint64_t rays, samples; // so far, over all pixels
    bool pass_done;
} RenderProgress;

typedef struct RenderStats {
    double build_seconds, render_seconds;
    uint64_t rays, shadow_rays, samples, bad_samples;
    bool stopped;     // before all was done
    bool out_of_time; // because the time limit was reached
} RenderStats;

typedef struct Renderer Renderer;

// Builds what rendering needs (accelerator, lights, textures), with the scene's chosen camera
// (scene->camera), else its first, else one that sees all its shapes; the latter two are warned of.
// NULL after reporting to `sink`. scene and options->stop must outlive the renderer.
Renderer *renderer_new(const Scene *scene, const RenderOptions *options, DiagSink *sink);
// Renders until all samples are done or *stop; the film is the renderer's own. After a stop it can
// be called again to go on, and the bytes are those of a run that wasn't stopped. *stats (may be
// NULL) counts all runs together. Returns false only if nothing at all could be rendered.
bool renderer_run(Renderer *renderer, RenderStats *stats);
const Film *renderer_film(const Renderer *renderer);
// What was counted so far; not while it runs.
void renderer_stats(const Renderer *renderer, RenderStats *stats);
// What was in force, the options counted in: for the picture's metadata.
const FilmParams *renderer_film_params(const Renderer *renderer);
const RenderParams *renderer_params(const Renderer *renderer);
// NULL: all pixels get the same number of samples.
const StopRule *renderer_stop_rule(const Renderer *renderer);
// What the picture is seen with.
const Camera *renderer_camera(const Renderer *renderer);
void renderer_free(Renderer *renderer);

// Resolved film and render settings of a scene: its own, or the defaults.
FilmParams scene_film(const Scene *scene);
RenderParams scene_render(const Scene *scene);
// The rule of `stop`; NULL: all pixels get the same number of samples.
const StopRule *scene_stop_rule(const Scene *scene, const RenderParams *render);

// The most samples of a pixel where `stop` or a time limit sets the end, and `samples` isn't given.
enum { OPEN_SAMPLES = 1 << 16 };

#endif
