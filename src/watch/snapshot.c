#include "watch/snapshot.h"

#include "base/mem.h"
#include "base/thread.h"

#include <math.h>
#include <string.h>

// The place of pixel `at` of `to` in a picture of `from` pixels a side.
static uint32_t stretched(uint32_t at, uint32_t to, uint32_t from)
{
    return (uint32_t)(((uint64_t)at * 2 + 1) * from / ((uint64_t)to * 2));
}

typedef struct ErrorSums {
    double variance, luminance;
    uint64_t count; // of pixels with a known variance
} ErrorSums;

static void take_pixel(Snapshot *to, const Film *film, size_t p, bool even, ErrorSums *sums)
{
    const FilmPixel *pixel = &film->pixels[p];
    Rgb mean = film_color(film, p, even);
    to->radiance[3 * p] = mean.r;
    to->radiance[3 * p + 1] = mean.g;
    to->radiance[3 * p + 2] = mean.b;
    if (pixel->samples >= 2) {
        double variance = film_variance(pixel);
        to->variance[p] = (float)variance;
        sums->variance += variance;
        sums->luminance += (double)luminance(mean);
        ++sums->count;
    } else {
        to->variance[p] = NAN;
    }
}

static void take_from_under(Snapshot *to, uint32_t x, uint32_t y, const Snapshot *under)
{
    size_t p = (size_t)y * to->width + x;
    size_t q = (size_t)stretched(y, to->height, under->height) * under->width +
               stretched(x, to->width, under->width);
    for (int i = 0; i < 3; ++i) {
        to->radiance[3 * p + (size_t)i] = under->radiance[3 * q + (size_t)i];
    }
    to->variance[p] = NAN;
}

static void take_film(Snapshot *to, const Film *film, const Snapshot *under)
{
    ErrorSums sums = {0};
    const bool even = film_is_even(film);
    for (uint32_t y = 0; y < film->height; ++y) {
        for (uint32_t x = 0; x < film->width; ++x) {
            size_t p = (size_t)y * film->width + x;
            if (film->pixels[p].samples == 0 && under) {
                take_from_under(to, x, y, under);
            } else {
                take_pixel(to, film, p, even, &sums);
            }
        }
    }
    to->error = NAN;
    if (sums.count == film_pixel_count(film) && sums.luminance > 0) {
        double n = (double)sums.count;
        to->error = sqrt(sums.variance / n) / (sums.luminance / n);
    }
}

Snapshot *snapshot_new(const Film *film, const FilmParams *params, const Camera *camera,
                       Loaded *loaded, const Snapshot *under)
{
    size_t count = film_pixel_count(film);
    Snapshot *snapshot = mem_alloc_zeroed(1, sizeof *snapshot);
    if (!snapshot) {
        return NULL;
    }
    atomic_init(&snapshot->references, 1);
    snapshot->width = film->width;
    snapshot->height = film->height;
    snapshot->samples = film->samples_done;
    snapshot->film = *params;
    snapshot->camera = *camera;
    snapshot->loaded = loaded_keep(loaded);
    snapshot->radiance = mem_alloc(count, 3 * sizeof(float));
    snapshot->variance = mem_alloc(count, sizeof(float));
    if (!snapshot->radiance || !snapshot->variance) {
        snapshot_release(snapshot);
        return NULL;
    }
    take_film(snapshot, film, under);
    snapshot->relative = film_error(film, SNAPSHOT_CONFIDENCE, 0);
    return snapshot;
}

Snapshot *snapshot_keep(Snapshot *snapshot)
{
    atomic_fetch_add(&snapshot->references, 1);
    return snapshot;
}

void snapshot_release(Snapshot *snapshot)
{
    if (snapshot && atomic_fetch_sub(&snapshot->references, 1) == 1) {
        loaded_release(snapshot->loaded);
        mem_free(snapshot->radiance);
        mem_free(snapshot->variance);
        mem_free(snapshot->command);
        mem_free(snapshot);
    }
}

// --- Development ---------------------------------------------------------------------------------

enum { GUESSES = 4096 };

// Encoding a channel costs a power; there are only 256 results, so that its place among the least
// values of each is found instead. The result is the same for every value (see snapshot_test.c).
typedef struct Encoder {
    float least[257]; // that a byte stands for; beyond the last, above 1
    unsigned char guess[GUESSES + 1];
} Encoder;

static int encoded(ToneCurve tone, float shown)
{
    return (int)(tone_encode(tone, shown) * 255.0f + 0.5f);
}

static float float_of(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// By bisection over the floats from 0 to 1, whose bits are in their order.
static float least_of(ToneCurve tone, int byte)
{
    uint32_t low = 0, high = 0x3f800000;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (encoded(tone, float_of(middle)) >= byte) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return float_of(low);
}

static void make_encoder(Encoder *encoder, ToneCurve tone)
{
    for (int byte = 0; byte < 256; ++byte) {
        encoder->least[byte] = least_of(tone, byte);
    }
    encoder->least[256] = 2;
    int byte = 0;
    for (int i = 0; i <= GUESSES; ++i) {
        while (encoder->least[byte + 1] <= (float)i / GUESSES) {
            ++byte;
        }
        encoder->guess[i] = (unsigned char)byte;
    }
}

static unsigned char encode(const Encoder *encoder, float shown)
{
    int byte = encoder->guess[(int)(shown * GUESSES)];
    while (encoder->least[byte + 1] <= shown) {
        ++byte;
    }
    return (unsigned char)byte;
}

typedef struct Development {
    const Snapshot *snapshot;
    ToneCurve tone;
    float gain;
    unsigned char *rgba;
    Encoder encoder;
} Development;

static void develop_row(void *context, uint64_t row, unsigned worker)
{
    (void)worker;
    const Development *d = context;
    size_t first = (size_t)row * d->snapshot->width;
    for (size_t p = first; p < first + d->snapshot->width; ++p) {
        const float *mean = d->snapshot->radiance + 3 * p;
        Rgb shown = tone_curve(d->tone, rgb_scale(rgb(mean[0], mean[1], mean[2]), d->gain));
        unsigned char *to = d->rgba + 4 * p;
        to[0] = encode(&d->encoder, shown.r);
        to[1] = encode(&d->encoder, shown.g);
        to[2] = encode(&d->encoder, shown.b);
        to[3] = 255;
    }
}

void snapshot_develop(const Snapshot *snapshot, double exposure, ToneCurve tone,
                      unsigned char *rgba)
{
    Development d = {
        .snapshot = snapshot, .tone = tone, .gain = (float)exp2(exposure), .rgba = rgba};
    make_encoder(&d.encoder, tone);
    parallel_for(snapshot->height, thread_processor_count(), develop_row, &d, NULL);
}
