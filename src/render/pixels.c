// The samples of one pixel: drawn in order, summed in blocks (see film.h).
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

static Rgb take_sample(const Renderer *r, const Site *site, uint32_t number, AovSample *aov,
                       IntegratorStats *stats)
{
    const uint32_t x = site->x, y = site->y;
    Sampler sampler;
    sampler_start(&sampler, site->stream->seed, x, y, number);
    float u, v, lens_u, lens_v;
    sampler_2d(&sampler, &u, &v);
    sampler_2d(&sampler, &lens_u, &lens_v);
    const double film_x = (x + 0.5 + filter_sample(&r->filter, u)) * r->pixel_width;
    const double film_y = (y + 0.5 + filter_sample(&r->filter, v)) * r->pixel_height;
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
static uint32_t take_samples(Renderer *r, const Site *site, uint32_t from, uint32_t to,
                             PixelSums *sums, IntegratorStats *stats)
{
    const bool aovs = site->stream->aovs != NULL;
    for (; from < to && !renderer_stopped(r); ++from) {
        const uint32_t number = r->film.first_sample + from;
        if (aovs) {
            AovSample aov = {.object = 0};
            film_pixel_add(&sums->color, take_sample(r, site, number, &aov, stats));
            film_aov_add(&sums->aov, &aov);
        } else {
            film_pixel_add(&sums->color, take_sample(r, site, number, NULL, stats));
        }
        if (from % TICK_SAMPLES == 0) {
            renderer_tick(r);
        }
    }
    return from;
}

static void keep_block(Film *film, const Site *site, uint32_t block, const PixelSums *sums)
{
    const size_t at = block * film_pixel_count(film) + site->at;
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
static bool extend_first_block(Renderer *r, const Site *site, uint32_t end, IntegratorStats *stats)
{
    const PixelStream *stream = site->stream;
    PixelSums sums = {.color = stream->pixels[site->at]};
    if (stream->aovs) {
        sums.aov = stream->aovs[site->at];
    }
    const bool whole = take_samples(r, site, sums.color.samples, end, &sums, stats) == end;
    stream->pixels[site->at] = sums.color;
    if (stream->aovs) {
        stream->aovs[site->at] = sums.aov;
    }
    keep_block(&r->film, site, 0, &sums);
    return whole;
}

// Further blocks are summed apart and then added; one that a stop cuts short is dropped, to be
// rendered again.
static bool add_block(Renderer *r, const Site *site, uint32_t end, IntegratorStats *stats)
{
    const PixelStream *stream = site->stream;
    PixelSums sums = {.color = {.samples = 0}};
    const uint32_t begin = stream->pixels[site->at].samples;
    if (take_samples(r, site, begin, end, &sums, stats) != end) {
        return false;
    }
    film_pixel_join(&stream->pixels[site->at], &sums.color);
    if (stream->aovs) {
        film_aov_join(&stream->aovs[site->at], &sums.aov);
    }
    keep_block(&r->film, site, begin / SAMPLE_BLOCK, &sums);
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
        whole = before < SAMPLE_BLOCK ? extend_first_block(r, &site, end, &count->rays)
                                      : add_block(r, &site, end, &count->rays);
        count->samples += pixel->samples - before;
    }
    return whole;
}
