// Rendering: from a flat scene to a film, and the film's figures.
#ifndef RENDER_RENDER_H
#define RENDER_RENDER_H

#include "base/diag.h"
#include "render/integrator.h"
#include "scene/scene.h"

#include <stdatomic.h>

// The kinds of all folders below render/ and of scene/: the program's schema.
const Schema *render_schema(void);

// Samples are summed in double in blocks of this many, the blocks in order, so that ranges of
// samples rendered apart and then joined give the same bytes.
enum { SAMPLE_BLOCK = 64 };

typedef struct FilmParams { // the `film` kind
    int64_t width, height;
    int32_t filter;      // "box", "tent", "gaussian", "blackman_harris"
    double filter_width; // pixels, whole width; 0: the filter's own
    double exposure;     // stops
    int32_t tone;        // "srgb", "linear", "aces", "filmic"
    const char *file;
    StringList aovs;
} FilmParams;

typedef struct RenderParams { // the `render` kind
    int32_t integrator;       // index into integrator_classes
    int64_t samples, bounces, seed;
    int32_t sampling; // "mis", "light", "bsdf"
    bool shadows, russian_roulette;
    double clamp; // largest radiance of an indirect sample; 0: none
} RenderParams;

// One pixel's sums. Layout of Film: rows from the top.
typedef struct FilmPixel {
    double sum[3];     // of radiance
    double square_sum; // of the samples' luminance squared, for the variance
    double luminance_sum;
    double alpha; // samples that hit something
} FilmPixel;

typedef struct AovPixel {
    float albedo[3], normal[3], position[3], depth; // means over the samples that hit
    uint32_t object, material;                      // of the first sample that hit; id + 1, 0 none
    double weight;
} AovPixel;

typedef struct Film {
    uint32_t width, height;
    uint32_t samples_done; // of every pixel
    FilmPixel *pixels;
    AovPixel *aovs; // NULL unless asked for
} Film;

struct RenderProgress;

typedef struct RenderOptions {
    unsigned threads;  // 0: all processors
    int width, height; // 0: the film's
    int64_t samples;   // 0: the scene's
    int64_t seed;      // -1: the scene's
    bool aovs;
    const atomic_int *stop; // non-zero: stop soon, keep what is done; may be NULL
    // Called from the rendering thread that finished a tile (one at a time), at most every 50 ms,
    // and at the end of each pass over the picture with pass_done = true, when no thread writes to
    // the film.
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
    bool stopped;
} RenderStats;

typedef struct Renderer Renderer;

// Builds what rendering needs (accelerator, lights, textures). NULL after reporting to `sink`.
Renderer *renderer_new(const Scene *scene, const RenderOptions *options, DiagSink *sink);
// Renders until all samples are done or *stop; the film is the renderer's own. Returns false only
// if nothing at all could be rendered (no memory).
bool renderer_run(Renderer *renderer, RenderStats *stats);
const Film *renderer_film(const Renderer *renderer);
void renderer_free(Renderer *renderer);

// Resolved film and render settings of a scene: its own, or the defaults.
FilmParams scene_film(const Scene *scene);
RenderParams scene_render(const Scene *scene);

#endif
