// The renderer's inside, shared by the files that make it up: render.c (settings and passes),
// pixels.c (the samples of one pixel), resume.c (checkpoints).
#ifndef RENDER_RENDERER_H
#define RENDER_RENDERER_H

#include "render/adaptive.h"
#include "render/camera.h"
#include "render/caustics.h"
#include "render/filter.h"
#include "render/lamps.h"
#include "render/render.h"
#include "render/share.h"
#include "render/tiles.h"
#include "render/world.h"

struct Renderer {
    const Scene *scene;
    RenderOptions options;
    FilmParams film_params;
    RenderParams params;
    const IntegratorClass *integrator;
    World *world;
    Camera camera;
    PixelFilter filter;
    double pixel_width, pixel_height; // of the film's sides
    uint8_t *lamp_marks;              // LampMark, by pixel; a pixel's is its tile's to settle; NULL
    Photons *photons;                 // that are traced for this picture; NULL: none
    CausticFilm caustics;             // of the streams, for the samples of the present pass
    Sharing sharing;                  // of light among pixels
    TileList tiles;
    Film film;
    const StopRule *rule;   // or NULL
    Adaptive adaptive;      // where there is a rule
    uint32_t seed, samples; // samples: of this renderer, from film.first_sample on
    double build_seconds, render_seconds;
    // of the pass under way
    uint32_t target;         // samples that each pixel shall have
    double began;            // when this run did
    double deadline;         // when it has to end; INFINITY: no limit
    atomic_bool out_of_time; // the deadline has passed
    uint64_t samples_before;
    // counted tile by tile
    atomic_uint_least64_t samples_done, rays, shadow_rays, bad_samples;
    // of the reports
    atomic_flag reporting;
    _Atomic double last_report;
};

// True once rendering shall end: asked for, or out of time.
static inline bool renderer_stopped(const Renderer *r)
{
    return (r->options.stop && atomic_load_explicit(r->options.stop, memory_order_relaxed) != 0) ||
           atomic_load_explicit(&r->out_of_time, memory_order_relaxed);
}

// The seed of a stream: the second's is as far from the first's as another picture's.
static inline uint32_t renderer_seed(const Renderer *r, uint32_t stream)
{
    return r->seed ^ stream * UINT32_C(0x2545f491);
}

// Looks at the clock: ends the run at its deadline, and reports if it is time and no other thread
// is at it. Called every few samples.
void renderer_tick(Renderer *r);

// What a tile counts, to be added to the renderer's totals once.
typedef struct TileCount {
    IntegratorStats rays;
    uint64_t samples;
    uint32_t unseen; // samples since the last look at the clock
} TileCount;

// Sums that grow by samples of one seed: the film's own, or a stream of adaptive sampling.
typedef struct PixelStream {
    FilmPixel *pixels; // of the whole picture
    AovPixel *aovs;    // the same; NULL: layers aren't counted
    uint32_t seed;
    bool keeps_blocks;            // the film's blocks are kept apart, too (film.h)
    const CausticPixel *caustics; // that each sample adds; NULL: nothing
    ShareWindow *window;          // of the present tile; NULL: pixels share nothing
} PixelStream;

// Brings one pixel of a stream to r->target samples. False after a stop.
bool pixel_render(Renderer *r, const PixelStream *stream, uint32_t x, uint32_t y, TileCount *count);

#endif
