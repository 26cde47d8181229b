// The driver: passes over the picture, tile by tile, in threads.
//
// A pass brings every pixel to the same number of samples: 1, 4, 16 and SAMPLE_BLOCK, then one
// block more each time, so that a first picture comes soon. A pixel's sums depend on its samples
// only (see film.h), and its samples on its place and their numbers only (sampler.h).
#include "render/render.h"

#include "base/mem.h"
#include "base/thread.h"
#include "render/camera.h"
#include "render/filter.h"
#include "render/tiles.h"
#include "render/world.h"

#include <time.h>

static const double report_interval = 0.05; // seconds
static const int64_t max_pixels = INT64_C(1) << 30;
static const int64_t max_sample = INT64_C(1) << 31;

struct Renderer {
    const Scene *scene;
    RenderOptions options;
    FilmParams film_params;
    RenderParams params;
    const IntegratorClass *integrator;
    World *world;
    Camera camera;
    PixelFilter filter;
    TileList tiles;
    Film film;
    uint32_t seed, samples; // samples: of this renderer, from film.first_sample on
    double build_seconds, render_seconds;
    // of the pass under way
    uint32_t target; // samples that each pixel shall have
    double began;    // when this run did
    uint64_t samples_before;
    // counted tile by tile
    atomic_uint_least64_t samples_done, rays, shadow_rays, bad_samples;
    // of the reports
    atomic_flag reporting;
    double last_report;
};

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool stopped(const Renderer *r)
{
    return r->options.stop && atomic_load_explicit(r->options.stop, memory_order_relaxed) != 0;
}

// --- Making ready --------------------------------------------------------------------------------

static bool resolve_settings(Renderer *r, DiagSink *sink)
{
    const RenderOptions *options = &r->options;
    r->film_params = scene_film(r->scene);
    r->params = scene_render(r->scene);
    if (options->width > 0 && options->height > 0) {
        r->film_params.width = options->width;
        r->film_params.height = options->height;
    }
    if (options->samples > 0) {
        r->params.samples = options->samples;
    }
    if (options->seed >= 0) {
        r->params.seed = options->seed;
    }
    const int64_t width = r->film_params.width, height = r->film_params.height;
    if (width < 1 || height < 1 || width > max_pixels / height) {
        diag_report(sink, E0927, (Span){0}, "a picture of %lld x %lld pixels can't be rendered",
                    (long long)width, (long long)height);
        return false;
    }
    if (options->first_sample < 0 || options->first_sample % SAMPLE_BLOCK != 0 ||
        options->first_sample > max_sample || r->params.samples < 1 ||
        r->params.samples > max_sample - options->first_sample) {
        diag_report(sink, E0928, (Span){0}, "samples %lld to %lld can't be rendered",
                    (long long)options->first_sample,
                    (long long)(options->first_sample + r->params.samples));
        return false;
    }
    r->seed = (uint32_t)r->params.seed ^ (uint32_t)((uint64_t)r->params.seed >> 32);
    r->samples = (uint32_t)r->params.samples;
    r->integrator =
        options->integrator ? options->integrator : integrator_classes[r->params.integrator];
    return true;
}

static void choose_camera(Renderer *r, DiagSink *sink)
{
    const int width = (int)r->film_params.width, height = (int)r->film_params.height;
    const SceneNodeArray *cameras = &r->scene->nodes[CATEGORY_CAMERA];
    if (r->options.camera) {
        const Affine identity = affine_identity();
        camera_setup(&r->camera, r->options.camera, &identity, width, height);
        return;
    }
    if (r->scene->camera < cameras->count) {
        camera_prepare(&r->camera, r->scene, r->scene->camera, width, height);
        return;
    }
    if (cameras->count > 0) {
        if (cameras->count > 1) {
            diag_report(sink, W0922, cameras->items[0].at,
                        "the scene has %zu cameras; this one, the first, is used", cameras->count);
        }
        camera_prepare(&r->camera, r->scene, 0, width, height);
        return;
    }
    diag_report(sink, W0921, (Span){0}, "the scene has no camera: one that sees all of it is used");
    camera_default(&r->camera, accel_bounds(r->world->accel), width, height);
}

static bool prepare(Renderer *r, DiagSink *sink)
{
    if (!resolve_settings(r, sink)) {
        return false;
    }
    const uint32_t width = (uint32_t)r->film_params.width, height = (uint32_t)r->film_params.height;
    if (!film_init(&r->film, width, height, (uint32_t)r->options.first_sample, r->samples,
                   r->options.aovs) ||
        !tiles_init(&r->tiles, width, height)) {
        diag_report(sink, E0001, (Span){0}, "not enough memory for a picture of %u x %u pixels",
                    width, height);
        return false;
    }
    r->world =
        r->options.world ? r->options.world : world_build(r->scene, r->options.threads, sink);
    if (!r->world) {
        return false;
    }
    choose_camera(r, sink);
    world_set_camera(r->world, &r->camera);
    if (r->integrator->check) {
        r->integrator->check(r->world, sink);
    }
    filter_init(&r->filter, (FilterKind)r->film_params.filter, r->film_params.filter_width);
    return true;
}

Renderer *renderer_new(const Scene *scene, const RenderOptions *options, DiagSink *sink)
{
    Renderer *r = mem_alloc_zeroed(1, sizeof *r);
    if (!r) {
        diag_report(sink, E0001, (Span){0}, "not enough memory to render");
        return NULL;
    }
    const double began = now();
    r->scene = scene;
    r->options = *options;
    if (r->options.threads == 0) {
        r->options.threads = thread_processor_count();
    }
    atomic_init(&r->samples_done, 0);
    atomic_init(&r->rays, 0);
    atomic_init(&r->shadow_rays, 0);
    atomic_init(&r->bad_samples, 0);
    atomic_flag_clear(&r->reporting);
    if (!prepare(r, sink)) {
        renderer_free(r);
        return NULL;
    }
    r->build_seconds = now() - began;
    return r;
}

void renderer_free(Renderer *r)
{
    if (r) {
        if (!r->options.world) {
            world_free(r->world);
        }
        tiles_free(&r->tiles);
        film_free(&r->film);
        mem_free(r);
    }
}

const Film *renderer_film(const Renderer *r)
{
    return &r->film;
}

const FilmParams *renderer_film_params(const Renderer *r)
{
    return &r->film_params;
}

const RenderParams *renderer_params(const Renderer *r)
{
    return &r->params;
}

const Camera *renderer_camera(const Renderer *r)
{
    return &r->camera;
}

// --- Pixels --------------------------------------------------------------------------------------

typedef struct PixelSums {
    FilmPixel color;
    AovPixel aov;
} PixelSums;

// What a tile counts, to be added to the renderer's totals once.
typedef struct TileCount {
    IntegratorStats rays;
    uint64_t samples;
} TileCount;

// Light that is negative or not finite would spoil the pixel for good: counted, and taken as black.
static Rgb checked(Rgb radiance, IntegratorStats *stats)
{
    if (!rgb_is_finite(radiance) || radiance.r < 0 || radiance.g < 0 || radiance.b < 0) {
        ++stats->bad_samples;
        return rgb_gray(0);
    }
    return radiance;
}

static Rgb take_sample(const Renderer *r, uint32_t x, uint32_t y, uint32_t number, AovSample *aov,
                       IntegratorStats *stats)
{
    Sampler sampler;
    sampler_start(&sampler, r->seed, x, y, number);
    float u, v, lens_u, lens_v;
    sampler_2d(&sampler, &u, &v);
    sampler_2d(&sampler, &lens_u, &lens_v);
    const double film_x = (x + 0.5 + filter_sample(&r->filter, u)) / r->film.width;
    const double film_y = (y + 0.5 + filter_sample(&r->filter, v)) / r->film.height;
    Ray ray;
    if (!camera_ray(&r->camera, film_x, film_y, lens_u, lens_v, &ray)) {
        return rgb_gray(0);
    }
    const Rgb radiance = r->integrator->radiance(r->world, &ray, &sampler, aov, stats);
    if (aov && aov->object != 0) {
        aov->depth = camera_depth(&r->camera, aov->position);
    }
    return checked(radiance, stats);
}

// Adds samples [from, to) of this renderer to *sums; returns where it got before a stop.
static uint32_t take_samples(const Renderer *r, uint32_t x, uint32_t y, uint32_t from, uint32_t to,
                             PixelSums *sums, IntegratorStats *stats)
{
    for (; from < to && !stopped(r); ++from) {
        AovSample aov = {.object = 0};
        const Rgb radiance =
            take_sample(r, x, y, r->film.first_sample + from, r->film.aovs ? &aov : NULL, stats);
        film_pixel_add(&sums->color, radiance);
        if (r->film.aovs) {
            film_aov_add(&sums->aov, &aov);
        }
    }
    return from;
}

static void keep_block(Film *film, size_t pixel, uint32_t block, const PixelSums *sums)
{
    const size_t at = block * film_pixel_count(film) + pixel;
    if (film->blocks) {
        film->blocks[at] = sums->color;
    }
    if (film->aov_blocks) {
        film->aov_blocks[at] = sums->aov;
    }
}

// The first block grows in the pixel itself, pass by pass.
static bool extend_first_block(Renderer *r, uint32_t x, uint32_t y, size_t at, uint32_t end,
                               IntegratorStats *stats)
{
    Film *film = &r->film;
    PixelSums sums = {.color = film->pixels[at]};
    if (film->aovs) {
        sums.aov = film->aovs[at];
    }
    const bool whole = take_samples(r, x, y, sums.color.samples, end, &sums, stats) == end;
    film->pixels[at] = sums.color;
    if (film->aovs) {
        film->aovs[at] = sums.aov;
    }
    keep_block(film, at, 0, &sums);
    return whole;
}

// Further blocks are summed apart and then added; one that a stop cuts short is dropped, to be
// rendered again.
static bool add_block(Renderer *r, uint32_t x, uint32_t y, size_t at, uint32_t end,
                      IntegratorStats *stats)
{
    Film *film = &r->film;
    PixelSums sums = {.color = {.samples = 0}};
    const uint32_t begin = film->pixels[at].samples;
    if (take_samples(r, x, y, begin, end, &sums, stats) != end) {
        return false;
    }
    film_pixel_join(&film->pixels[at], &sums.color);
    if (film->aovs) {
        film_aov_join(&film->aovs[at], &sums.aov);
    }
    keep_block(film, at, begin / SAMPLE_BLOCK, &sums);
    return true;
}

// Brings one pixel to the pass's target. False after a stop.
static bool render_pixel(Renderer *r, uint32_t x, uint32_t y, TileCount *count)
{
    const size_t at = (size_t)y * r->film.width + x;
    const FilmPixel *pixel = &r->film.pixels[at];
    bool whole = true;
    while (whole && pixel->samples < r->target) {
        const uint32_t before = pixel->samples;
        const uint32_t block_end = (before / SAMPLE_BLOCK + 1) * SAMPLE_BLOCK;
        const uint32_t end = block_end < r->target ? block_end : r->target;
        whole = before < SAMPLE_BLOCK ? extend_first_block(r, x, y, at, end, &count->rays)
                                      : add_block(r, x, y, at, end, &count->rays);
        count->samples += pixel->samples - before;
    }
    return whole;
}

// --- Passes --------------------------------------------------------------------------------------

static void report(Renderer *r, bool pass_done)
{
    const uint64_t all = (uint64_t)r->samples * film_pixel_count(&r->film);
    const uint64_t done = atomic_load_explicit(&r->samples_done, memory_order_relaxed);
    const double run = now() - r->began;
    // What was done in earlier runs says nothing about this one's speed.
    const double speed = run > 0 ? (double)(done - r->samples_before) / run : 0;
    const RenderProgress progress = {
        .film = &r->film,
        .fraction = (double)done / (double)all,
        .seconds = r->render_seconds + run,
        .seconds_left = speed > 0 ? (double)(all - done) / speed : INFINITY,
        .rays = atomic_load_explicit(&r->rays, memory_order_relaxed) +
                atomic_load_explicit(&r->shadow_rays, memory_order_relaxed),
        .samples = done,
        .pass_done = pass_done,
    };
    r->options.progress(r->options.context, &progress);
}

// Reports if it is time and no other thread is at it.
static void report_now_and_then(Renderer *r)
{
    if (!r->options.progress || atomic_flag_test_and_set(&r->reporting)) {
        return;
    }
    const double time = now();
    if (time - r->last_report >= report_interval) {
        report(r, false);
        r->last_report = now();
    }
    atomic_flag_clear(&r->reporting);
}

static void add_count(Renderer *r, const TileCount *count)
{
    atomic_fetch_add_explicit(&r->samples_done, count->samples, memory_order_relaxed);
    atomic_fetch_add_explicit(&r->rays, count->rays.rays, memory_order_relaxed);
    atomic_fetch_add_explicit(&r->shadow_rays, count->rays.shadow_rays, memory_order_relaxed);
    atomic_fetch_add_explicit(&r->bad_samples, count->rays.bad_samples, memory_order_relaxed);
}

static void render_tile(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    Renderer *r = context;
    const Tile tile = tile_at(&r->tiles, item);
    TileCount count = {.samples = 0};
    bool go_on = true;
    for (uint32_t y = tile.y0; go_on && y < tile.y1; ++y) {
        for (uint32_t x = tile.x0; go_on && x < tile.x1; ++x) {
            go_on = render_pixel(r, x, y, &count);
        }
    }
    add_count(r, &count);
    report_now_and_then(r);
}

static uint32_t next_target(const Renderer *r)
{
    const uint32_t done = r->film.samples_done;
    uint32_t target = done < SAMPLE_BLOCK ? 1 : (done / SAMPLE_BLOCK + 1) * SAMPLE_BLOCK;
    while (target <= done) {
        target *= 4;
    }
    return target < r->samples ? target : r->samples;
}

static void fill_stats(const Renderer *r, RenderStats *stats)
{
    *stats = (RenderStats){
        .build_seconds = r->build_seconds,
        .render_seconds = r->render_seconds,
        .rays = atomic_load(&r->rays),
        .shadow_rays = atomic_load(&r->shadow_rays),
        .samples = atomic_load(&r->samples_done),
        .bad_samples = atomic_load(&r->bad_samples),
        .stopped = r->film.samples_done < r->samples,
    };
}

bool renderer_run(Renderer *r, RenderStats *stats)
{
    r->began = now();
    r->last_report = r->began;
    r->samples_before = atomic_load(&r->samples_done);
    while (r->film.samples_done < r->samples && !stopped(r)) {
        r->target = next_target(r);
        parallel_for(r->tiles.count, r->options.threads, render_tile, r, r->options.stop);
        if (stopped(r)) {
            break; // maybe between pixels; the next run finds what is missing
        }
        r->film.samples_done = r->target;
        if (r->options.progress) {
            report(r, true);
        }
    }
    r->render_seconds += now() - r->began;
    if (stats) {
        fill_stats(r, stats);
    }
    return true;
}
