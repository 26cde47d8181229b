#include "render/caustics.h"

#include "base/mem.h"
#include "base/thread.h"
#include "render/renderer.h"

enum { CHUNK = 4096, MOST_CHUNKS = 128 };
// Seeds as far from the pixels' as another picture's.
enum { PHOTON_STREAM = 0x6a09e667 };

// --- Making ready --------------------------------------------------------------------------------

static bool out_of_memory(DiagSink *sink)
{
    diag_report(sink, E0001, (Span){0}, "not enough memory to trace caustics");
    return false;
}

bool caustics_begin(Renderer *r, DiagSink *sink)
{
    CausticFilm *film = &r->caustics;
    r->world->photon_lights = NULL;
    if (r->params.caustics != CAUSTICS_TRACED || !r->integrator->photons) {
        return true;
    }
    if (r->filter.kind == FILTER_CENTER) {
        diag_report(sink, W0963, scene_setting_at(r->scene, "render"),
                    "caustics can't be traced to the centers of pixels: paths find them by luck");
        return true;
    }
    if (!photons_new(r->world, &r->photons)) {
        return out_of_memory(sink);
    }
    if (!r->photons) {
        return true;
    }
    const size_t pixels = film_pixel_count(&r->film);
    const size_t wanted = pixels * SAMPLE_BLOCK / CHUNK + 1;
    film->chunk_count = wanted < MOST_CHUNKS ? (uint32_t)wanted : MOST_CHUNKS;
    film->chunks = mem_alloc_zeroed(film->chunk_count, sizeof *film->chunks);
    film->splats = mem_alloc((size_t)film->chunk_count * CHUNK, sizeof *film->splats);
    film->pixels[0] = mem_alloc_zeroed(pixels, sizeof *film->pixels[0]);
    film->pixels[1] = r->rule ? mem_alloc_zeroed(pixels, sizeof *film->pixels[1]) : NULL;
    if (!film->chunks || !film->splats || !film->pixels[0] || (r->rule && !film->pixels[1])) {
        return out_of_memory(sink);
    }
    for (uint32_t i = 0; i < film->chunk_count; ++i) {
        film->chunks[i].splats = film->splats + (size_t)i * CHUNK;
    }
    r->world->photon_lights = photons_of_lights(r->photons);
    return true;
}

void caustics_end(Renderer *r)
{
    if (r->photons) {
        r->world->photon_lights = NULL;
    }
    photons_free(r->photons);
    mem_free(r->caustics.chunks);
    mem_free(r->caustics.splats);
    mem_free(r->caustics.pixels[0]);
    mem_free(r->caustics.pixels[1]);
}

// --- Following photons ---------------------------------------------------------------------------

// Photons [begin, begin + count) of a run, in chunks.
typedef struct Round {
    Renderer *r;
    PhotonFilm film;
    CausticPixel *pixels;
    uint32_t seed, run;
    uint64_t begin, count;
    // Where bands of rows begin, each for one thread, and where the last ends.
    int64_t borders[CAUSTIC_STRIPS + 1];
    uint32_t bands;
} Round;

static uint32_t strip_of(const PhotonSplat *splat)
{
    const double strip = splat->y * CAUSTIC_STRIPS; // a little beyond the film, too
    return strip > 0 ? (uint32_t)fmin(strip, CAUSTIC_STRIPS - 1) : 0;
}

static void trace_chunk(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    const Round *round = context;
    Renderer *r = round->r;
    PhotonChunk *chunk = &r->caustics.chunks[item];
    const uint64_t first = item * CHUNK;
    const uint64_t end = round->count - first < CHUNK ? round->count : first + CHUNK;
    // Counted here: neighbouring chunks lie so near that threads would wait for one another.
    IntegratorStats stats = {0};
    uint32_t count = 0;
    memset(chunk->in_strip, 0, sizeof chunk->in_strip);
    for (uint64_t i = first; i < end && !renderer_stopped(r); ++i) {
        const uint64_t number = round->begin + i;
        Sampler sampler;
        sampler_start(&sampler, round->seed, round->run, (uint32_t)(number >> 32),
                      (uint32_t)number);
        PhotonSplat *splat = &chunk->splats[count];
        if (photon_trace(r->photons, &round->film, &sampler, &stats, splat)) {
            ++chunk->in_strip[strip_of(splat)];
            ++count;
        }
    }
    chunk->count = count;
    chunk->stats = stats;
    renderer_tick(r);
}

// --- Adding --------------------------------------------------------------------------------------

// Rows [y0, y1) of the film.
typedef struct Band {
    const PixelFilter *filter;
    CausticPixel *pixels;
    int64_t width, y0, y1;
} Band;

// Adds light at a place, in pixels; `light` is over pixels, too.
static void add_light(const Band *band, double x, double y, Rgb light)
{
    const double half = band->filter->width / 2;
    const double top = fmax(ceil(y - half - 0.5), (double)band->y0);
    const double bottom = fmin(floor(y + half - 0.5), (double)(band->y1 - 1));
    const double left = fmax(ceil(x - half - 0.5), 0);
    const double right = fmin(floor(x + half - 0.5), (double)(band->width - 1));
    for (double row = top; row <= bottom; ++row) {
        const double f = filter_density(band->filter, y - row - 0.5);
        for (double column = left; column <= right; ++column) {
            const Rgb part =
                rgb_scale(light, (float)(f * filter_density(band->filter, x - column - 0.5)));
            const double l = (double)luminance(part);
            CausticPixel *pixel = &band->pixels[(int64_t)row * band->width + (int64_t)column];
            pixel->sum[0] += (double)part.r;
            pixel->sum[1] += (double)part.g;
            pixel->sum[2] += (double)part.b;
            pixel->square += l * l;
        }
    }
}

// Bands with as much to add each: a caustic is often a small part of the picture. Which rows they
// have changes no pixel's sum, nor its order.
static void share_out(Round *round, unsigned threads)
{
    const CausticFilm *film = &round->r->caustics;
    const int64_t height = round->r->film.height;
    const uint64_t chunks = (round->count - 1) / CHUNK + 1;
    uint64_t in_strip[CAUSTIC_STRIPS] = {0}, all = 0, before = 0;
    for (uint64_t c = 0; c < chunks; ++c) {
        for (int i = 0; i < CAUSTIC_STRIPS; ++i) {
            in_strip[i] += film->chunks[c].in_strip[i];
        }
        all += film->chunks[c].count;
    }
    round->bands = threads < CAUSTIC_STRIPS ? threads : CAUSTIC_STRIPS;
    uint32_t band = 0;
    for (int i = 0; i < CAUSTIC_STRIPS; ++i) {
        while (band < round->bands && before >= band * all / round->bands) {
            round->borders[band++] = i * height / CAUSTIC_STRIPS;
        }
        before += in_strip[i];
    }
    while (band <= round->bands) {
        round->borders[band++] = height;
    }
    round->borders[0] = 0;
}

static void add_band(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    const Round *round = context;
    const Renderer *r = round->r;
    const int64_t width = r->film.width, height = r->film.height;
    const Band band = {&r->filter, round->pixels, width, round->borders[item],
                       round->borders[item + 1]};
    const double around = r->camera.params.projection == CAMERA_PANORAMA ? (double)width : 0;
    const float area = (float)((double)width * (double)height); // of the film, in pixels
    for (uint64_t c = 0; c * CHUNK < round->count; ++c) {
        const PhotonChunk *chunk = &r->caustics.chunks[c];
        for (uint32_t i = 0; i < chunk->count; ++i) {
            const PhotonSplat *splat = &chunk->splats[i];
            const double x = splat->x * (double)width, y = splat->y * (double)height;
            const Rgb light = rgb_scale(splat->light, area);
            add_light(&band, x, y, light);
            if (around > 0) { // the left edge goes on at the right one
                add_light(&band, x - around, y, light);
                add_light(&band, x + around, y, light);
            }
        }
    }
}

// --- Runs ----------------------------------------------------------------------------------------

// Runs are 0, 1, 2 and 3, 4 to 7, ... and then blocks, whatever the passes.
static SampleRun run_of(uint32_t sample)
{
    if (sample >= SAMPLE_BLOCK) {
        const uint32_t first = sample / SAMPLE_BLOCK * SAMPLE_BLOCK;
        return (SampleRun){first, first + SAMPLE_BLOCK};
    }
    uint32_t end = 1;
    while (end <= sample) {
        end *= 2;
    }
    return (SampleRun){end / 2, end};
}

// The run to which the samples of the pass belong. With a stopping rule passes are always the same
// ones, and each is a run.
static SampleRun run_of_pass(const Renderer *r)
{
    return r->rule ? (SampleRun){r->adaptive.state.done, r->target}
                   : run_of(r->film.first_sample + r->film.samples_done);
}

static void finish(CausticPixel *pixels, size_t count, double photons, double samples)
{
    for (size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 3; ++c) {
            pixels[i].sum[c] /= photons;
        }
        // Of the mean of all photons, and that over a run's samples as if each had its own.
        pixels[i].square *= samples / (photons * photons);
    }
}

static void add_counts(Renderer *r)
{
    for (uint32_t i = 0; i < r->caustics.chunk_count; ++i) {
        const IntegratorStats *stats = &r->caustics.chunks[i].stats;
        atomic_fetch_add_explicit(&r->rays, stats->rays, memory_order_relaxed);
        atomic_fetch_add_explicit(&r->shadow_rays, stats->shadow_rays, memory_order_relaxed);
        atomic_fetch_add_explicit(&r->bad_samples, stats->bad_samples, memory_order_relaxed);
    }
}

static bool trace_stream(Renderer *r, CausticPixel *pixels, uint32_t seed, SampleRun run)
{
    const size_t count = film_pixel_count(&r->film);
    const uint64_t photons = (uint64_t)count * (run.end - run.first);
    const uint64_t most = (uint64_t)r->caustics.chunk_count * CHUNK;
    const double margin = r->filter.width / 2;
    Round round = {.r = r,
                   .film = {&r->camera, margin * r->pixel_width, margin * r->pixel_height},
                   .pixels = pixels,
                   .seed = seed ^ PHOTON_STREAM,
                   .run = run.first};
    memset(pixels, 0, count * sizeof *pixels);
    for (; round.begin < photons; round.begin += round.count) {
        round.count = photons - round.begin < most ? photons - round.begin : most;
        const uint64_t chunks = (round.count - 1) / CHUNK + 1;
        for (uint32_t i = 0; i < r->caustics.chunk_count; ++i) {
            r->caustics.chunks[i].stats = (IntegratorStats){0};
        }
        parallel_for(chunks, r->options.threads, trace_chunk, &round, r->options.stop);
        add_counts(r);
        if (renderer_stopped(r)) {
            return false;
        }
        share_out(&round, r->options.threads);
        parallel_for(round.bands, r->options.threads, add_band, &round, NULL);
    }
    finish(pixels, count, (double)photons, run.end - run.first);
    return true;
}

bool caustics_trace(Renderer *r)
{
    if (!r->photons) {
        return true;
    }
    const SampleRun run = run_of_pass(r);
    SampleRun *ready = &r->caustics.run;
    if (ready->first == run.first && ready->end == run.end) {
        return true;
    }
    ready->end = 0;
    if (!trace_stream(r, r->caustics.pixels[0], renderer_seed(r, 0), run) ||
        (r->rule && !trace_stream(r, r->caustics.pixels[1], renderer_seed(r, 1), run))) {
        return false;
    }
    *ready = run;
    return true;
}
