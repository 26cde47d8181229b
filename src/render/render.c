// The driver: passes over the picture, tile by tile, in threads.
//
// A pass brings every pixel to the same number of samples: 1, 4, 16 and SAMPLE_BLOCK, then one
// block more each time, so that a first picture comes soon. A pixel's sums depend on its samples
// only (see film.h), and its samples on its place and their numbers only (sampler.h).
#include "render/renderer.h"

#include "base/clock.h"
#include "base/mem.h"
#include "base/thread.h"

static const double report_interval = 0.05; // seconds
static const int64_t max_pixels = INT64_C(1) << 30;
static const int64_t max_sample = INT64_C(1) << 31;

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
    r->rule = options->even ? NULL : scene_stop_rule(r->scene, &r->params);
    if (options->time_limit > 0) {
        r->params.time_limit = options->time_limit;
    }
    if (options->samples > 0) {
        r->params.samples = options->samples;
    } else if (!r->params.samples_given && (r->rule || r->params.time_limit > 0)) {
        r->params.samples = OPEN_SAMPLES;
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
    if (r->rule && (options->first_sample > 0 || options->whole_samples > 0)) {
        diag_report(sink, E0928, scene_node(r->scene, CATEGORY_RULE, r->params.stop)->at,
                    "a picture that stops where it is good enough can't be rendered in parts");
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

static uint32_t tile_side(int wanted)
{
    return wanted > 0 ? (uint32_t)wanted : TILE_SIZE;
}

static bool no_memory(const Renderer *r, DiagSink *sink)
{
    diag_report(sink, E0001, (Span){0}, "not enough memory for a picture of %lld x %lld pixels",
                (long long)r->film_params.width, (long long)r->film_params.height);
    return false;
}

static bool prepare(Renderer *r, DiagSink *sink)
{
    if (!resolve_settings(r, sink)) {
        return false;
    }
    const uint32_t width = (uint32_t)r->film_params.width, height = (uint32_t)r->film_params.height;
    if (!film_init(&r->film, width, height, (uint32_t)r->options.first_sample, r->samples,
                   r->options.aovs) ||
        !tiles_init(&r->tiles, width, height, tile_side(r->options.tile_width),
                    tile_side(r->options.tile_height)) ||
        (r->rule && !adaptive_init(&r->adaptive, width, height, *r->rule, r->samples))) {
        return no_memory(r, sink);
    }
    film_populate(&r->film, r->options.threads);
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
    r->pixel_width = 1 / (double)r->film.width;
    r->pixel_height = 1 / (double)r->film.height;
    if (r->integrator->lamps &&
        !lamp_marks(r->world, &r->camera, width, height, r->filter.width / 2, &r->lamp_marks)) {
        return no_memory(r, sink);
    }
    return share_begin(r) ? caustics_begin(r, sink) : no_memory(r, sink);
}

Renderer *renderer_new(const Scene *scene, const RenderOptions *options, DiagSink *sink)
{
    Renderer *r = mem_alloc_zeroed(1, sizeof *r);
    if (!r) {
        diag_report(sink, E0001, (Span){0}, "not enough memory to render");
        return NULL;
    }
    const double began = clock_seconds();
    r->scene = scene;
    r->options = *options;
    if (r->options.threads == 0) {
        r->options.threads = thread_processor_count();
    }
    atomic_init(&r->samples_done, 0);
    atomic_init(&r->rays, 0);
    atomic_init(&r->shadow_rays, 0);
    atomic_init(&r->bad_samples, 0);
    atomic_init(&r->out_of_time, false);
    atomic_init(&r->last_report, 0);
    atomic_flag_clear(&r->reporting);
    if (!prepare(r, sink)) {
        renderer_free(r);
        return NULL;
    }
    r->build_seconds = clock_seconds() - began;
    return r;
}

void renderer_free(Renderer *r)
{
    if (r) {
        caustics_end(r);
        share_end(r);
        if (!r->options.world) {
            world_free(r->world);
        }
        tiles_free(&r->tiles);
        adaptive_free(&r->adaptive);
        film_free(&r->film);
        mem_free(r->lamp_marks);
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

const StopRule *renderer_stop_rule(const Renderer *r)
{
    return r->rule;
}

const Camera *renderer_camera(const Renderer *r)
{
    return &r->camera;
}

// --- Passes --------------------------------------------------------------------------------------

// How much of the work is done: of the samples, or of the time.
static double fraction_done(const Renderer *r, double done, double all)
{
    const double passed = r->render_seconds + clock_seconds() - r->began;
    const double of_time = r->params.time_limit > 0 ? passed / r->params.time_limit : 0;
    return fmin(fmax(done / all, of_time), 1);
}

static void report(Renderer *r, bool pass_done)
{
    const double all =
        r->rule ? r->adaptive.expected : (double)r->samples * (double)film_pixel_count(&r->film);
    const uint64_t done = atomic_load_explicit(&r->samples_done, memory_order_relaxed);
    const double run = clock_seconds() - r->began;
    // What was done in earlier runs says nothing about this one's speed.
    const double speed = run > 0 ? (double)(done - r->samples_before) / run : 0;
    const double left = speed > 0 ? fmax(all - (double)done, 0) / speed : INFINITY;
    const RenderProgress progress = {
        .film = &r->film,
        .fraction = fraction_done(r, (double)done, all),
        .seconds = r->render_seconds + run,
        .seconds_left = fmin(left, fmax(r->deadline - clock_seconds(), 0)),
        .rays = atomic_load_explicit(&r->rays, memory_order_relaxed) +
                atomic_load_explicit(&r->shadow_rays, memory_order_relaxed),
        .samples = done,
        .pass_done = pass_done,
    };
    r->options.progress(r->options.context, &progress);
}

void renderer_tick(Renderer *r)
{
    const double time = clock_seconds();
    if (time >= r->deadline) {
        atomic_store_explicit(&r->out_of_time, true, memory_order_relaxed);
    }
    if (!r->options.progress ||
        time - atomic_load_explicit(&r->last_report, memory_order_relaxed) < report_interval ||
        atomic_flag_test_and_set(&r->reporting)) {
        return;
    }
    // Perhaps another thread reported in between.
    if (time - atomic_load_explicit(&r->last_report, memory_order_relaxed) >= report_interval) {
        report(r, false);
        atomic_store_explicit(&r->last_report, clock_seconds(), memory_order_relaxed);
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

static bool render_streams(Renderer *r, uint32_t x, uint32_t y, TileCount *count)
{
    const AdaptiveCell *cell = adaptive_cell(&r->adaptive, x, y);
    bool go_on = true;
    for (uint32_t s = 0; go_on && adaptive_at_work(cell) && s < 2; ++s) {
        const PixelStream stream = {.pixels = r->adaptive.streams[s],
                                    .aovs = cell->enough[s] ? NULL : r->film.aovs,
                                    .seed = renderer_seed(r, s),
                                    .caustics = r->caustics.pixels[s]};
        go_on = pixel_render(r, &stream, x, y, count);
    }
    return go_on;
}

static bool render_pixel(Renderer *r, uint32_t x, uint32_t y, ShareWindow *window, TileCount *count)
{
    if (r->rule) {
        return render_streams(r, x, y, count);
    }
    const PixelStream stream = {.pixels = r->film.pixels,
                                .aovs = r->film.aovs,
                                .seed = r->seed,
                                .keeps_blocks = true,
                                .caustics = r->caustics.pixels[0],
                                .window = window};
    return pixel_render(r, &stream, x, y, count);
}

static void render_tile(void *context, uint64_t item, unsigned worker)
{
    Renderer *r = context;
    const Tile tile = tile_at(&r->tiles, item);
    ShareWindow *window = share_open(r, worker, &tile);
    TileCount count = {.samples = 0};
    bool go_on = true;
    for (uint32_t y = tile.y0; go_on && y < tile.y1; ++y) {
        for (uint32_t x = tile.x0; go_on && x < tile.x1; ++x) {
            go_on = render_pixel(r, x, y, window, &count);
        }
    }
    share_close(r, window);
    add_count(r, &count);
    renderer_tick(r);
}

static bool finished(const Renderer *r)
{
    return r->rule ? adaptive_finished(&r->adaptive) : r->film.samples_done >= r->samples;
}

static uint32_t next_target(const Renderer *r)
{
    if (r->rule) {
        return adaptive_next_target(&r->adaptive);
    }
    const uint32_t done = r->film.samples_done;
    uint32_t target = done < SAMPLE_BLOCK ? 1 : (done / SAMPLE_BLOCK + 1) * SAMPLE_BLOCK;
    while (target <= done) {
        target *= r->photons ? 2 : 4; // so that no pass is of two runs
    }
    return target < r->samples ? target : r->samples;
}

void renderer_stats(const Renderer *r, RenderStats *stats)
{
    *stats = (RenderStats){
        .build_seconds = r->build_seconds,
        .render_seconds = r->render_seconds,
        .rays = atomic_load(&r->rays),
        .shadow_rays = atomic_load(&r->shadow_rays),
        .samples = atomic_load(&r->samples_done),
        .bad_samples = atomic_load(&r->bad_samples),
        .stopped = !finished(r),
        .out_of_time = atomic_load(&r->out_of_time),
    };
}

static void end_pass(Renderer *r)
{
    if (r->rule) {
        adaptive_decide(&r->adaptive, r->target, &r->film);
        adaptive_show(&r->adaptive, &r->film);
    } else {
        r->film.samples_done = r->target;
    }
}

bool renderer_run(Renderer *r, RenderStats *stats)
{
    r->began = clock_seconds();
    r->deadline = r->params.time_limit > 0
                      ? r->began + fmax(r->params.time_limit - r->render_seconds, 0)
                      : INFINITY;
    atomic_store(&r->out_of_time, false);
    atomic_store(&r->last_report, r->began);
    r->samples_before = atomic_load(&r->samples_done);
    while (!finished(r) && !renderer_stopped(r)) {
        r->target = next_target(r);
        if (!caustics_trace(r)) {
            break;
        }
        parallel_for(r->tiles.count, r->options.threads, render_tile, r, r->options.stop);
        if (renderer_stopped(r)) {
            break; // maybe between pixels; the next run finds what is missing
        }
        end_pass(r);
        if (r->options.progress) {
            report(r, true);
        }
    }
    if (r->rule) {
        adaptive_show(&r->adaptive, &r->film);
    }
    r->render_seconds += clock_seconds() - r->began;
    if (stats) {
        renderer_stats(r, stats);
    }
    return true;
}
