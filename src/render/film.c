#include "render/film.h"

#include "base/mem.h"
#include "base/thread.h"

bool film_init(Film *film, uint32_t width, uint32_t height, uint32_t first_sample, uint32_t samples,
               bool aovs)
{
    *film = (Film){.width = width, .height = height, .first_sample = first_sample};
    if (first_sample % SAMPLE_BLOCK != 0) {
        *film = (Film){0};
        return false;
    }
    const size_t count = film_pixel_count(film);
    film->pixels = mem_alloc_zeroed(count, sizeof *film->pixels);
    film->aovs = aovs ? mem_alloc_zeroed(count, sizeof *film->aovs) : NULL;
    bool ok = film->pixels && (film->aovs || !aovs);
    if (ok && first_sample > 0) {
        film->block_count = samples / SAMPLE_BLOCK + (samples % SAMPLE_BLOCK != 0);
        const size_t blocks = film->block_count;
        ok = blocks == 0 || count <= SIZE_MAX / blocks;
        film->blocks = ok ? mem_alloc_zeroed(count * blocks, sizeof *film->blocks) : NULL;
        film->aov_blocks =
            ok && aovs ? mem_alloc_zeroed(count * blocks, sizeof *film->aov_blocks) : NULL;
        ok = ok && film->blocks && (film->aov_blocks || !aovs);
    }
    if (!ok) {
        film_free(film);
    }
    return ok;
}

enum { POPULATED_AT_ONCE = 1 << 22 };         // bytes, of a thread
static const size_t MOST_POPULATED = 1 << 29; // more is provided as it is reached

typedef struct Population {
    char *bytes;
    size_t size;
} Population;

static void populate_part(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    const Population *all = context;
    const size_t begin = (size_t)item * POPULATED_AT_ONCE;
    const size_t left = all->size - begin;
    mem_populate(all->bytes + begin, left < POPULATED_AT_ONCE ? left : POPULATED_AT_ONCE);
}

static void populate(void *array, size_t size, unsigned threads)
{
    Population all = {array, size};
    if (array && size <= MOST_POPULATED) {
        const uint64_t parts = (size + POPULATED_AT_ONCE - 1) / POPULATED_AT_ONCE;
        parallel_for(parts, threads, populate_part, &all, NULL);
    }
}

void film_populate(const Film *film, unsigned threads)
{
    const size_t count = film_pixel_count(film);
    populate(film->pixels, count * sizeof *film->pixels, threads);
    populate(film->aovs, count * sizeof *film->aovs, threads);
}

bool film_share(Film *film, double quantum, uint32_t reach)
{
    film->gains = mem_alloc_zeroed(film_pixel_count(film), sizeof *film->gains);
    film->quantum = quantum;
    film->reach = reach;
    return film->gains != NULL;
}

void film_free(Film *film)
{
    mem_free(film->gains);
    mem_free(film->pixels);
    mem_free(film->aovs);
    mem_free(film->blocks);
    mem_free(film->aov_blocks);
    *film = (Film){0};
}

// Luminance in double, from the same weights as luminance().
static double luminance_of(double r, double g, double b)
{
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

void film_pixel_add(FilmPixel *pixel, Rgb radiance)
{
    const double r = (double)radiance.r, g = (double)radiance.g, b = (double)radiance.b;
    const double l = luminance_of(r, g, b);
    pixel->sum[0] += r;
    pixel->sum[1] += g;
    pixel->sum[2] += b;
    pixel->square_sum += l * l;
    pixel->samples += 1;
}

void film_pixel_add_varying(FilmPixel *pixel, Rgb radiance, double variance)
{
    film_pixel_add(pixel, radiance);
    pixel->square_sum += variance;
}

void film_pixel_join(FilmPixel *pixel, const FilmPixel *block)
{
    for (int i = 0; i < 3; ++i) {
        pixel->sum[i] += block->sum[i];
    }
    pixel->square_sum += block->square_sum;
    pixel->samples += block->samples;
}

void film_aov_add(AovPixel *pixel, const AovSample *sample)
{
    if (sample->object == 0) {
        return;
    }
    const AovPixel one = {
        .albedo = {(double)sample->albedo.r, (double)sample->albedo.g, (double)sample->albedo.b},
        .normal = {sample->normal.x, sample->normal.y, sample->normal.z},
        .position = {sample->position.x, sample->position.y, sample->position.z},
        .depth = sample->depth,
        .object = sample->object,
        .material = sample->material,
        .hits = 1,
    };
    film_aov_join(pixel, &one);
}

void film_aov_join(AovPixel *pixel, const AovPixel *block)
{
    if (pixel->hits == 0) {
        pixel->object = block->object;
        pixel->material = block->material;
    }
    for (int i = 0; i < 3; ++i) {
        pixel->albedo[i] += block->albedo[i];
        pixel->normal[i] += block->normal[i];
        pixel->position[i] += block->position[i];
    }
    pixel->depth += block->depth;
    pixel->hits += block->hits;
}

bool film_is_even(const Film *film)
{
    const size_t count = film_pixel_count(film);
    for (size_t p = 0; p < count; ++p) {
        if (film->pixels[p].samples != film->samples_done) {
            return false;
        }
    }
    return true;
}

static FilmMerge can_merge(const Film *film, const Film *part)
{
    if (film->width != part->width || film->height != part->height || !film->aovs != !part->aovs ||
        !film->gains != !part->gains) {
        return FILM_MERGE_SIZE;
    }
    if (film->first_sample != 0) {
        return FILM_MERGE_NOT_HEAD;
    }
    if (film->samples_done % SAMPLE_BLOCK != 0 || !film_is_even(film) || !film_is_even(part)) {
        return FILM_MERGE_INCOMPLETE;
    }
    if (part->first_sample == 0 || part->first_sample != film->samples_done) {
        return FILM_MERGE_GAP;
    }
    return FILM_MERGED;
}

// Another processor's last places may have led to another quantum.
static void merge_gains(Film *film, const Film *part)
{
    const double ratio = part->quantum / film->quantum;
    const size_t count = film->gains ? film_pixel_count(film) : 0;
    for (size_t p = 0; p < count; ++p) {
        for (int i = 0; i < 3; ++i) {
            const int64_t gain = part->gains[p].sum[i];
            const int64_t here = ratio == 1 ? gain : llrint((double)gain * ratio);
            int64_t *sum = &film->gains[p].sum[i];
            *sum = (int64_t)((uint64_t)*sum + (uint64_t)here);
        }
    }
}

FilmMerge film_merge(Film *film, const Film *part)
{
    const FilmMerge verdict = can_merge(film, part);
    if (verdict != FILM_MERGED) {
        return verdict;
    }
    const size_t count = film_pixel_count(film);
    for (uint32_t b = 0; b < part->block_count; ++b) {
        for (size_t p = 0; p < count; ++p) {
            film_pixel_join(&film->pixels[p], &part->blocks[b * count + p]);
            if (film->aovs) {
                film_aov_join(&film->aovs[p], &part->aov_blocks[b * count + p]);
            }
        }
    }
    merge_gains(film, part);
    film->samples_done += part->samples_done;
    return FILM_MERGED;
}

Rgb film_mean(const FilmPixel *pixel)
{
    if (pixel->samples == 0) {
        return rgb_gray(0);
    }
    const double n = pixel->samples;
    return rgb((float)(pixel->sum[0] / n), (float)(pixel->sum[1] / n), (float)(pixel->sum[2] / n));
}

static bool neighbours_agree(const Film *film, size_t pixel)
{
    const size_t x = pixel % film->width, y = pixel / film->width, reach = film->reach;
    const size_t x0 = x > reach ? x - reach : 0, y0 = y > reach ? y - reach : 0;
    for (size_t j = y0; j <= y + reach && j < film->height; ++j) {
        for (size_t i = x0; i <= x + reach && i < film->width; ++i) {
            if (film->pixels[j * film->width + i].samples != film->pixels[pixel].samples) {
                return false;
            }
        }
    }
    return true;
}

// How much of its gain a pixel shows. Of independent samples all of it would leave the least error;
// but a pixel's own are stratified, the better the more there are. The mean is the same for any.
static const double gain_part = 0.7;

static Rgb color_with_gain(const Film *film, size_t p)
{
    const FilmPixel *pixel = &film->pixels[p];
    if (!film->gains || pixel->samples == 0) {
        return film_mean(pixel);
    }
    float color[3];
    for (int i = 0; i < 3; ++i) {
        const int64_t gain = __atomic_load_n(&film->gains[p].sum[i], __ATOMIC_RELAXED);
        const double sum = pixel->sum[i] + gain_part * (double)gain * film->quantum;
        color[i] = (float)fmax(sum / pixel->samples, 0); // below it by rounding alone
    }
    return rgb(color[0], color[1], color[2]);
}

Rgb film_color(const Film *film, size_t pixel, bool even)
{
    return !film->gains || even || neighbours_agree(film, pixel) ? color_with_gain(film, pixel)
                                                                 : film_mean(&film->pixels[pixel]);
}

double film_luminance(const FilmPixel *pixel)
{
    return pixel->samples
               ? luminance_of(pixel->sum[0], pixel->sum[1], pixel->sum[2]) / (double)pixel->samples
               : 0;
}

double film_variance(const FilmPixel *pixel)
{
    if (pixel->samples < 2) {
        return 0;
    }
    const double n = pixel->samples;
    const double mean = luminance_of(pixel->sum[0], pixel->sum[1], pixel->sum[2]) / n;
    return fmax(0, (pixel->square_sum / n - mean * mean) / (n - 1));
}

static float film_alpha(const Film *film, size_t p)
{
    if (!film->aovs) {
        return 1;
    }
    const uint32_t samples = film->pixels[p].samples;
    return samples ? (float)((double)film->aovs[p].hits / samples) : 0;
}

enum { ROWS_AT_ONCE = 16 }; // that a thread develops

typedef struct Development {
    const Film *film;
    ToneCurve tone;
    float gain;
    int channels;
    bool linear;
    bool even; // all pixels have as many samples
    float *out;
} Development;

static void develop_rows(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    const Development *d = context;
    const size_t first = (size_t)item * ROWS_AT_ONCE, end = first + ROWS_AT_ONCE;
    const size_t last = end < d->film->height ? end : d->film->height;
    for (size_t p = first * d->film->width; p < last * d->film->width; ++p) {
        Rgb color = film_color(d->film, p, d->even);
        if (!d->linear) {
            color = tone_apply(d->tone, rgb_scale(color, d->gain));
        }
        float *to = d->out + p * (size_t)d->channels;
        to[0] = color.r;
        to[1] = color.g;
        to[2] = color.b;
        if (d->channels == 4) {
            to[3] = film_alpha(d->film, p);
        }
    }
}

void film_develop(const Film *film, const FilmParams *params, int channels, bool linear,
                  unsigned threads, float *out)
{
    Development development = {.film = film,
                               .tone = (ToneCurve)params->tone,
                               .gain = linear ? 1 : (float)exp2(params->exposure),
                               .channels = channels,
                               .linear = linear,
                               .even = film_is_even(film),
                               .out = out};
    const uint64_t bands = ((uint64_t)film->height + ROWS_AT_ONCE - 1) / ROWS_AT_ONCE;
    parallel_for(bands, threads, develop_rows, &development, NULL);
}

static const char *const suffixes_rgb[] = {"R", "G", "B"};
static const char *const suffixes_xyz[] = {"X", "Y", "Z"};
static const char *const suffixes_z[] = {"Z"};
static const char *const suffixes_id[] = {"id"};
static const char *const suffixes_y[] = {"Y"};
static const char *const suffixes_a[] = {"A"};

const FilmAov film_aovs[AOV_COUNT] = {
    [AOV_ALBEDO] = {"albedo", 3, suffixes_rgb, false, "the first surface's reflectance"},
    [AOV_NORMAL] = {"normal", 3, suffixes_xyz, false, "the first surface's shading normal"},
    [AOV_DEPTH] = {"depth", 1, suffixes_z, false,
                   "metres along the camera's axis (fisheye, panorama: from the camera)"},
    [AOV_POSITION] = {"position", 3, suffixes_xyz, false, "the first surface's place, metres"},
    [AOV_OBJECT_ID] = {"object_id", 1, suffixes_id, true, "number of the shape, from 1; 0: none"},
    [AOV_MATERIAL_ID] = {"material_id", 1, suffixes_id, true,
                         "number of the material, from 1; 0: none"},
    [AOV_VARIANCE] = {"variance", 1, suffixes_y, false,
                      "variance of the mean luminance, estimated from the pixel's own samples"},
    [AOV_ALPHA] = {"alpha", 1, suffixes_a, false, "fraction of the samples that hit something"},
};

int film_find_aov(Str name)
{
    for (int i = 0; i < AOV_COUNT; ++i) {
        if (str_equal(name, str_from(film_aovs[i].name))) {
            return i;
        }
    }
    return -1;
}

static void write_mean(const double *sums, int channels, double hits, float *out)
{
    for (int i = 0; i < channels; ++i) {
        out[i] = hits > 0 ? (float)(sums[i] / hits) : 0;
    }
}

bool film_aov(const Film *film, int aov, float *out)
{
    if (aov < 0 || aov >= AOV_COUNT || (!film->aovs && aov != AOV_VARIANCE)) {
        return false;
    }
    const int channels = film_aovs[aov].channels;
    const size_t count = film_pixel_count(film);
    for (size_t p = 0; p < count; ++p) {
        float *to = out + p * (size_t)channels;
        const AovPixel *a = film->aovs ? &film->aovs[p] : NULL;
        if (aov == AOV_VARIANCE) {
            to[0] = (float)film_variance(&film->pixels[p]);
        } else if (aov == AOV_ALPHA) {
            to[0] = film_alpha(film, p);
        } else if (aov == AOV_OBJECT_ID || aov == AOV_MATERIAL_ID) {
            to[0] = (float)(aov == AOV_OBJECT_ID ? a->object : a->material);
        } else {
            write_mean(aov == AOV_ALBEDO     ? a->albedo
                       : aov == AOV_NORMAL   ? a->normal
                       : aov == AOV_POSITION ? a->position
                                             : &a->depth,
                       channels, a->hits, to);
        }
    }
    return true;
}
