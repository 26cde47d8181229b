// The samples of one pixel: drawn in order, summed in blocks (see film.h).
#include "base/hot.h"
#include "render/renderer.h"

enum { TICK_SAMPLES = 16 }; // samples from one look at the clock to the next

typedef struct PixelSums {
    FilmPixel color;
    AovPixel aov;
} PixelSums;

// Light that is negative or not finite would spoil the pixel for good: counted, and taken as black.
static Rgb checked(Rgb radiance, IntegratorStats *stats)
{
    if (!rgb_is_finite(radiance) || radiance.r < 0 || radiance.g < 0 || radiance.b < 0) {
        ++stats->bad_samples;
        return rgb_gray(0);
    }
    return radiance;
}

// Where samples are taken, and for which sums.
typedef struct Site {
    const PixelStream *stream;
    uint32_t x, y;
    size_t at;
} Site;

// A ray, and where it goes through the pixel's filter: from the pixel's centre, in pixels.
typedef struct FilmRay {
    Ray ray;
    double offset[2];
} FilmRay;

// The ray through a place in the pixel's filter, by numbers in [0, 1). False: the camera has none.
static bool filter_ray(const Renderer *r, const Site *site, float u, float v, Sampler *sampler,
                       FilmRay *out)
{
    float lens_u = 0.5F, lens_v = 0.5F;
    if (r->camera.params.aperture > 0) {
        sampler_2d(sampler, &lens_u, &lens_v);
    } else {
        sampler_skip_2d(sampler);
    }
    out->offset[0] = filter_sample(&r->filter, u);
    out->offset[1] = filter_sample(&r->filter, v);
    const double film_x = (site->x + 0.5 + out->offset[0]) * r->pixel_width;
    const double film_y = (site->y + 0.5 + out->offset[1]) * r->pixel_height;
    return camera_ray(&r->camera, film_x, film_y, lens_u, lens_v, &out->ray);
}

HOT static bool sample_ray(const Renderer *r, const Site *site, Sampler *sampler, FilmRay *out)
{
    float u = 0.5F, v = 0.5F;
    if (r->filter.width > 0) {
        sampler_2d(sampler, &u, &v);
    } else {
        sampler_skip_2d(sampler);
    }
    return filter_ray(r, site, u, v, sampler, out);
}

// --- Edges of lamps (lamps.h) --------------------------------------------------------------------

// Seeds as far from the samples' own as another picture's.
enum { TRIAL_STREAM = 0x1b873593, LAMP_STREAM = 0x4cf5ad43 };

static Rgb lamps_along(const Renderer *r, const Ray *ray, Sampler *sampler, IntegratorStats *stats)
{
    return checked(r->integrator->lamps(r->world, ray, sampler, stats), stats);
}

// Tries places about the pixel's rim and in its middle: where a lamp is wider than a pixel, its
// edge doesn't pass between them.
static bool edge_is_seen(const Renderer *r, const Site *site, IntegratorStats *stats)
{
    static const float places[] = {0.0001F, 0.333F, 0.667F, 0.9999F};
    enum { SIDE = sizeof places / sizeof *places };
    float least = INFINITY, most = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; ++i) {
        Sampler sampler;
        sampler_start(&sampler, r->seed ^ TRIAL_STREAM, site->x, site->y, i);
        FilmRay film;
        float seen = 0;
        if (filter_ray(r, site, places[i % SIDE], places[i / SIDE], &sampler, &film)) {
            seen = luminance(lamps_along(r, &film.ray, &sampler, stats));
        }
        least = fminf(least, seen);
        most = fmaxf(most, seen);
    }
    return most - least > 0.25F * most;
}

// The trials depend on the picture's seed and the pixel alone.
static bool lamps_apart(const Renderer *r, const Site *site, IntegratorStats *stats)
{
    if (!r->lamp_marks) {
        return false;
    }
    uint8_t *mark = &r->lamp_marks[site->at];
    if (*mark == LAMP_MAYBE) {
        *mark = edge_is_seen(r, site, stats) ? LAMP_EDGE : LAMP_NONE;
    }
    return *mark == LAMP_EDGE;
}

// The rays of all samples together are stratified over the pixel.
static Rgb lamps_seen(const Renderer *r, const Site *site, uint32_t number, IntegratorStats *stats)
{
    Rgb sum = rgb_gray(0);
    for (uint32_t i = 0; i < LAMP_RAYS; ++i) {
        Sampler sampler;
        sampler_start_neighbour(&sampler, site->stream->seed ^ LAMP_STREAM, site->x, site->y,
                                number * LAMP_RAYS + i);
        FilmRay film;
        if (sample_ray(r, site, &sampler, &film)) {
            sum = rgb_add(sum, lamps_along(r, &film.ray, &sampler, stats));
        }
    }
    return rgb_scale(sum, 1.0F / LAMP_RAYS);
}

// --- Samples -------------------------------------------------------------------------------------

// The radiance along the ray, or what remains of it without that of lamps.
static Rgb radiance_along(const Renderer *r, const Site *site, const FilmRay *film,
                          bool lamps_apart, Sampler *sampler, AovSample *aov,
                          IntegratorStats *stats)
{
    const IntegratorClass *integrator = r->integrator;
    if (!integrator->for_film) {
        return checked(integrator->radiance(r->world, &film->ray, sampler, aov, stats), stats);
    }
    Rgb indirect;
    const Rgb radiance =
        integrator->for_film(r->world, &film->ray, sampler, lamps_apart, aov, &indirect, stats);
    if (site->stream->window) {
        share_add(r, site->stream->window, site->x, site->y, film->offset, indirect);
    }
    return checked(radiance, stats);
}

// What a sample begins with.
typedef struct Start {
    Sampler sampler;
    FilmRay film;
    bool seen; // the camera has such a ray
} Start;

// Samples are started several at a time, their numbers before their rays: none of them waits for
// another, where within one each step waits for the one before, and where a path ends is a
// surprise, after which there would be nothing else to do meanwhile.
enum { STARTS = 4 };

static void start_numbers(const Renderer *r, const Site *site, uint32_t sample, Start *starts)
{
    Sampler *sampler = &starts[sample % STARTS].sampler;
    const uint32_t number = r->film.first_sample + sample;
    sampler_start_neighbour(sampler, site->stream->seed, site->x, site->y, number);
    if (r->filter.width > 0) {
        sampler_fill(sampler, 0);
    }
}

static void start_ray(const Renderer *r, const Site *site, uint32_t sample, Start *starts)
{
    Start *start = &starts[sample % STARTS];
    start->seen = sample_ray(r, site, &start->sampler, &start->film);
}

static void start_samples(const Renderer *r, const Site *site, uint32_t from, uint32_t to,
                          Start *starts)
{
    for (uint32_t i = from; i < to; ++i) {
        start_numbers(r, site, i, starts);
    }
    for (uint32_t i = from; i < to; ++i) {
        start_ray(r, site, i, starts);
    }
}

HOT static Rgb take_sample(const Renderer *r, const Site *site, uint32_t number, Start *start,
                           AovSample *aov, IntegratorStats *stats)
{
    const bool apart = lamps_apart(r, site, stats);
    const Rgb lamps = apart ? lamps_seen(r, site, number, stats) : rgb_gray(0);
    if (!start->seen) {
        return lamps;
    }
    const Rgb radiance = radiance_along(r, site, &start->film, apart, &start->sampler, aov, stats);
    if (aov && aov->object != 0) {
        aov->depth = camera_depth(&r->camera, aov->position);
    }
    return rgb_add(lamps, radiance);
}

static void add_sample(FilmPixel *pixel, const Site *site, Rgb radiance)
{
    if (!site->stream->caustics) {
        film_pixel_add(pixel, radiance);
        return;
    }
    const CausticPixel *caustic = &site->stream->caustics[site->at];
    const double *sum = caustic->sum;
    const Rgb light = rgb((float)sum[0], (float)sum[1], (float)sum[2]);
    film_pixel_add_varying(pixel, rgb_add(radiance, light), caustic->square);
}

// Adds samples [from, to) of this renderer to *sums; returns where it got before a stop.
HOT static uint32_t take_samples(Renderer *r, const Site *site, uint32_t from, uint32_t to,
                                 PixelSums *sums, TileCount *count)
{
    IntegratorStats *stats = &count->rays;
    const bool aovs = site->stream->aovs != NULL;
    Start starts[STARTS];
    uint32_t started = from;
    for (; from < to && !renderer_stopped(r); ++from) {
        const uint32_t number = r->film.first_sample + from;
        if (from == started) {
            started = to - from < STARTS ? to : from + STARTS;
            start_samples(r, site, from, started, starts);
        }
        Start *start = &starts[from % STARTS];
        if (aovs) {
            AovSample aov = {.object = 0};
            add_sample(&sums->color, site, take_sample(r, site, number, start, &aov, stats));
            film_aov_add(&sums->aov, &aov);
        } else {
            add_sample(&sums->color, site, take_sample(r, site, number, start, NULL, stats));
        }
        if (++count->unseen == TICK_SAMPLES) {
            count->unseen = 0;
            renderer_tick(r);
        }
    }
    return from;
}

static void keep_block(Renderer *r, const Site *site, uint32_t block, const PixelSums *sums)
{
    Film *film = &r->film;
    const size_t at = block * film_pixel_count(film) + site->at;
    if (site->stream->window) {
        share_keep(r, site->stream->window, site->x, site->y);
    }
    if (!site->stream->keeps_blocks) {
        return;
    }
    if (film->blocks) {
        film->blocks[at] = sums->color;
    }
    if (film->aov_blocks) {
        film->aov_blocks[at] = sums->aov;
    }
}

// The first block grows in the pixel itself, pass by pass.
static bool extend_first_block(Renderer *r, const Site *site, uint32_t end, TileCount *count)
{
    const PixelStream *stream = site->stream;
    PixelSums sums = {.color = stream->pixels[site->at]};
    if (stream->aovs) {
        sums.aov = stream->aovs[site->at];
    }
    const bool whole = take_samples(r, site, sums.color.samples, end, &sums, count) == end;
    stream->pixels[site->at] = sums.color;
    if (stream->aovs) {
        stream->aovs[site->at] = sums.aov;
    }
    keep_block(r, site, 0, &sums);
    return whole;
}

// Further blocks are summed apart and then added; one that a stop cuts short is dropped, to be
// rendered again.
static bool add_block(Renderer *r, const Site *site, uint32_t end, TileCount *count)
{
    const PixelStream *stream = site->stream;
    PixelSums sums = {.color = {.samples = 0}};
    const uint32_t begin = stream->pixels[site->at].samples;
    if (take_samples(r, site, begin, end, &sums, count) != end) {
        if (stream->window) {
            share_drop(stream->window);
        }
        return false;
    }
    film_pixel_join(&stream->pixels[site->at], &sums.color);
    if (stream->aovs) {
        film_aov_join(&stream->aovs[site->at], &sums.aov);
    }
    keep_block(r, site, begin / SAMPLE_BLOCK, &sums);
    return true;
}

bool pixel_render(Renderer *r, const PixelStream *stream, uint32_t x, uint32_t y, TileCount *count)
{
    const Site site = {stream, x, y, (size_t)y * r->film.width + x};
    const FilmPixel *pixel = &stream->pixels[site.at];
    bool whole = true;
    while (whole && pixel->samples < r->target) {
        const uint32_t before = pixel->samples;
        const uint32_t block_end = (before / SAMPLE_BLOCK + 1) * SAMPLE_BLOCK;
        const uint32_t end = block_end < r->target ? block_end : r->target;
        whole = before < SAMPLE_BLOCK ? extend_first_block(r, &site, end, count)
                                      : add_block(r, &site, end, count);
        count->samples += pixel->samples - before;
    }
    return whole;
}
