// The film's sums, parts and layers; tone curves; the order of tiles.
#include "render/film.h"

#include "base/hash.h"
#include "base/mem.h"
#include "near.h"
#include "render/tiles.h"

#include <stdlib.h>
#include <string.h>

// --- Sums --------------------------------------------------------------------------------------

enum { W = 5, H = 3, PIXELS = W * H, BLOCKS = 4 };

// Radiance over many orders of magnitude, so that the order of summation shows in the last bits.
static Rgb sample_of(uint32_t pixel, uint32_t number)
{
    const uint32_t key = hash_combine(hash_u32(pixel), number);
    const float scale = exp2f((float)(key % 31) - 15);
    return rgb(hash_to_float(hash_u32(key)) * scale, hash_to_float(hash_u32(key + 1)) * scale,
               hash_to_float(hash_u32(key + 2)) * scale);
}

static AovSample aov_of(uint32_t pixel, uint32_t number)
{
    const uint32_t key = hash_combine(hash_u32(pixel + 1000), number);
    if (key % 3 == 0) {
        return (AovSample){.object = 0};
    }
    const Rgb c = sample_of(pixel, number + 7);
    return (AovSample){
        .albedo = c,
        .normal = {(double)c.r, (double)c.g, 1},
        .position = {(double)c.b, 2, 3},
        .depth = (double)c.g,
        .object = key % 9 + 1,
        .material = key % 5 + 1,
    };
}

// Fills a film as the renderer does: block after block.
static void expose(Film *film, uint32_t samples)
{
    for (uint32_t p = 0; p < PIXELS; ++p) {
        for (uint32_t from = 0; from < samples; from += SAMPLE_BLOCK) {
            FilmPixel sums = {.samples = 0};
            AovPixel aov = {.hits = 0};
            for (uint32_t i = from; i < samples && i < from + SAMPLE_BLOCK; ++i) {
                film_pixel_add(&sums, sample_of(p, film->first_sample + i));
                const AovSample a = aov_of(p, film->first_sample + i);
                film_aov_add(&aov, &a);
            }
            film_pixel_join(&film->pixels[p], &sums);
            film_aov_join(&film->aovs[p], &aov);
            if (film->blocks) {
                film->blocks[from / SAMPLE_BLOCK * PIXELS + p] = sums;
                film->aov_blocks[from / SAMPLE_BLOCK * PIXELS + p] = aov;
            }
        }
    }
    film->samples_done = samples;
}

static Film exposed(uint32_t first, uint32_t samples)
{
    Film film;
    assert_true(film_init(&film, W, H, first, samples, true));
    expose(&film, samples);
    return film;
}

static void assert_same(const Film *a, const Film *b)
{
    assert_int_equal(a->samples_done, b->samples_done);
    assert_memory_equal(a->pixels, b->pixels, PIXELS * sizeof *a->pixels);
    assert_memory_equal(a->aovs, b->aovs, PIXELS * sizeof *a->aovs);
}

// Any cut at blocks' borders, the last block not full, merges to the same bytes.
static void parts_merge_to_the_bytes_of_the_whole(void **state)
{
    (void)state;
    const uint32_t samples = BLOCKS * SAMPLE_BLOCK - 11;
    Film whole = exposed(0, samples);
    for (uint32_t cuts = 0; cuts < 1u << (BLOCKS - 1); ++cuts) {
        uint32_t begin = 0;
        Film joined = {0};
        for (uint32_t b = 1; b <= BLOCKS; ++b) {
            if (b < BLOCKS && !(cuts >> (b - 1) & 1)) {
                continue;
            }
            const uint32_t end = b == BLOCKS ? samples : b * SAMPLE_BLOCK;
            Film part = exposed(begin, end - begin);
            if (begin == 0) {
                joined = part;
            } else {
                assert_int_equal(film_merge(&joined, &part), FILM_MERGED);
                film_free(&part);
            }
            begin = end;
        }
        assert_same(&whole, &joined);
        film_free(&joined);
    }
    film_free(&whole);
}

static void what_does_not_fit_is_not_merged(void **state)
{
    (void)state;
    Film head = exposed(0, SAMPLE_BLOCK), untouched = exposed(0, SAMPLE_BLOCK);
    Film later = exposed(2 * SAMPLE_BLOCK, SAMPLE_BLOCK), ragged = exposed(0, SAMPLE_BLOCK + 1);
    Film next = exposed(SAMPLE_BLOCK, SAMPLE_BLOCK), other;
    assert_true(film_init(&other, W, H + 1, SAMPLE_BLOCK, SAMPLE_BLOCK, true));
    assert_int_equal(film_merge(&head, &other), FILM_MERGE_SIZE);
    film_free(&other);
    assert_true(film_init(&other, W, H, SAMPLE_BLOCK, SAMPLE_BLOCK, false));
    assert_int_equal(film_merge(&head, &other), FILM_MERGE_SIZE);
    film_free(&other);
    assert_int_equal(film_merge(&head, &later), FILM_MERGE_GAP);
    assert_int_equal(film_merge(&head, &untouched), FILM_MERGE_GAP);
    assert_int_equal(film_merge(&next, &later), FILM_MERGE_NOT_HEAD);
    assert_int_equal(film_merge(&ragged, &later), FILM_MERGE_INCOMPLETE);
    next.pixels[3].samples -= 1; // stopped before its end
    assert_int_equal(film_merge(&head, &next), FILM_MERGE_INCOMPLETE);
    assert_same(&head, &untouched);
    Film *const all[] = {&head, &untouched, &later, &ragged, &next};
    for (size_t i = 0; i < 5; ++i) {
        film_free(all[i]);
    }
}

static void sizes_are_checked(void **state)
{
    (void)state;
    Film film;
    assert_false(film_init(&film, W, H, 1, 64, false)); // no multiple of a block
    assert_null(film.pixels);
    assert_false(film_init(&film, UINT32_MAX, UINT32_MAX, 0, 64, false));
    // Each of the four allocations of a part fails in turn.
    for (uint64_t allowed = 0; allowed < 4; ++allowed) {
        mem_fail_after(allowed);
        const bool made = film_init(&film, W, H, 64, 64, true);
        mem_fail_after(UINT64_MAX);
        assert_false(made);
        assert_null(film.pixels);
    }
}

static void mean_and_variance_are_the_samples(void **state)
{
    (void)state;
    FilmPixel pixel = {.samples = 0};
    assert_true(rgb_is_black(film_mean(&pixel)) && film_variance(&pixel) == 0);
    const float values[] = {1, 2, 4, 9};
    for (int i = 0; i < 4; ++i) {
        film_pixel_add(&pixel, rgb(values[i], values[i], values[i]));
    }
    assert_near((double)film_mean(&pixel).g, 4, 1e-6);
    // Sample variance (9 + 4 + 0 + 25) / 3 over n = 4.
    assert_near(film_variance(&pixel), 38.0 / 3 / 4, 1e-6);
}

static void layers_are_means_over_hits(void **state)
{
    (void)state;
    Film film = exposed(0, 50);
    float albedo[3 * PIXELS], id[PIXELS], alpha[PIXELS];
    assert_true(film_aov(&film, AOV_ALBEDO, albedo));
    assert_true(film_aov(&film, AOV_OBJECT_ID, id));
    assert_true(film_aov(&film, AOV_ALPHA, alpha));
    for (uint32_t p = 0; p < PIXELS; ++p) {
        double sum = 0;
        uint32_t hits = 0, first = 0;
        for (uint32_t i = 0; i < 50; ++i) {
            const AovSample a = aov_of(p, i);
            first = first ? first : a.object;
            hits += a.object != 0;
            sum += a.object ? (double)a.albedo.g : 0;
        }
        assert_near((double)albedo[3 * p + 1] / (sum / hits), 1, 1e-6);
        assert_true(id[p] == (float)first);
        assert_near((double)alpha[p], hits / 50.0, 1e-6);
    }
    assert_false(film_aov(&film, AOV_COUNT, albedo));
    film_free(&film);
    assert_true(film_init(&film, W, H, 0, 64, false));
    assert_false(film_aov(&film, AOV_ALBEDO, albedo));
    assert_true(film_aov(&film, AOV_VARIANCE, id));
    film_free(&film);
    for (int i = 0; i < AOV_COUNT; ++i) {
        assert_int_equal(film_find_aov(str_from(film_aovs[i].name)), i);
    }
    assert_int_equal(film_find_aov(STR("colour")), -1);
}

// --- Tone ----------------------------------------------------------------------------------------

static double encoded(ToneCurve tone, float value)
{
    return (double)tone_apply(tone, rgb_gray(value)).g;
}

static void srgb_is_the_standards_curve(void **state)
{
    (void)state;
    // IEC 61966-2-1: both pieces, their joint, and the clip.
    assert_near(encoded(TONE_SRGB, 0), 0, 0);
    assert_near(encoded(TONE_SRGB, 0.001f), 0.01292, 1e-7);
    assert_near(encoded(TONE_SRGB, 0.0031308f), 0.0404499, 1e-6);
    assert_near(encoded(TONE_SRGB, 0.18f), 0.4613561, 1e-6);
    assert_near(encoded(TONE_SRGB, 0.5f), 0.7353569, 1e-6);
    assert_near(encoded(TONE_SRGB, 1), 1, 1e-7);
    assert_near(encoded(TONE_SRGB, 7), 1, 0);
    // All 256 codes of 8 bits come back.
    for (int code = 0; code < 256; ++code) {
        const double v = code / 255.0;
        const double light = v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
        assert_int_equal((int)(encoded(TONE_SRGB, (float)light) * 255 + 0.5), code);
    }
}

static double decoded(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static void curves_follow_their_sources(void **state)
{
    (void)state;
    assert_near(encoded(TONE_LINEAR, 0.3f), 0.3, 1e-7);
    // Hable: f(x) = ((x(.15x + .05) + .004) / (x(.15x + .5) + .06)) - 1/15, shown is f(2x)/f(11.2):
    // the white point is 5.6.
    assert_near(encoded(TONE_FILMIC, 5.6f), 1, 1e-6);
    const double f1 = (2 * (0.3 + 0.05) + 0.004) / (2 * (0.3 + 0.5) + 0.06) - 1.0 / 15;
    const double w = (11.2 * (1.68 + 0.05) + 0.004) / (11.2 * (1.68 + 0.5) + 0.06) - 1.0 / 15;
    assert_near(decoded(encoded(TONE_FILMIC, 1)), f1 / w, 1e-6);
    assert_near(encoded(TONE_FILMIC, 0), 0, 1e-6);
    // Hill's matrices keep greys grey (within their five digits); 0.18 through his rational.
    const double v = 0.18, fit = (v * (v + 0.0245786) - 0.000090537) /
                                 (v * (0.983729 * v + 0.4329510) + 0.238081);
    assert_near(decoded(encoded(TONE_ACES, 0.18f)), fit, 1e-4);
    const Rgb gray = tone_apply(TONE_ACES, rgb_gray(0.5f));
    assert_near((double)gray.r, (double)gray.b, 1e-3);
    // A saturated colour turns pale where it is bright: part of the transform's point.
    assert_true(tone_apply(TONE_ACES, rgb(50, 0.1f, 0.1f)).g > 0.3f);
}

static void curves_rise_and_stay_in_range(void **state)
{
    (void)state;
    for (int tone = TONE_SRGB; tone <= TONE_FILMIC; ++tone) {
        double last = 0;
        for (int i = -60; i <= 250; ++i) {
            const double v = encoded((ToneCurve)tone, exp2f((float)i / 2));
            assert_true(v >= last && v <= 1);
            last = v;
        }
        assert_near(last, 1, 1e-6);
        const float odd[] = {NAN, INFINITY, -INFINITY, -1, 3e38f};
        for (int i = 0; i < 5; ++i) {
            const Rgb c = tone_apply((ToneCurve)tone, rgb(odd[i], 0.5f, odd[i]));
            assert_true(c.r >= 0 && c.r <= 1 && c.g >= 0 && c.g <= 1 && c.b >= 0 && c.b <= 1);
        }
    }
}

static void development_applies_exposure_and_tone(void **state)
{
    (void)state;
    Film film;
    assert_true(film_init(&film, 2, 1, 0, 4, true));
    for (int i = 0; i < 4; ++i) {
        film_pixel_add(&film.pixels[0], rgb(0.1f, 0.2f, 3));
    }
    const AovSample hit = {.object = 1};
    film_aov_add(&film.aovs[0], &hit);
    const FilmParams params = {.exposure = 1, .tone = TONE_SRGB};
    float out[8];
    film_develop(&film, &params, 4, true, 1, out);
    assert_near((double)out[0], 0.1, 1e-7);
    assert_near((double)out[2], 3, 1e-7);
    assert_near((double)out[3], 0.25, 0);
    assert_near((double)out[7], 0, 0); // no samples: black and empty
    film_develop(&film, &params, 3, false, 1, out);
    assert_near((double)out[0], encoded(TONE_SRGB, 0.2f), 1e-6);
    assert_near((double)out[1], encoded(TONE_SRGB, 0.4f), 1e-6);
    assert_near((double)out[2], 1, 0);
    assert_near((double)out[3], 0, 0);
    film_free(&film);
}

// --- Tiles ---------------------------------------------------------------------------------------

static void tiles_cover_each_pixel_once(void **state)
{
    (void)state;
    const uint32_t sizes[][4] = {
        {1, 1, 16, 16},     {16, 16, 16, 16}, {17, 15, 16, 16},
        {960, 540, 16, 16}, {1, 999, 7, 5},   {333, 40, 1, 1},
        {333, 40, 334, 1},  {50, 60, 49, 61}, {64, 64, 1u << 20, 1u << 20}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s) {
        const uint32_t w = sizes[s][0], h = sizes[s][1];
        char *seen = calloc(w, h);
        assert_non_null(seen);
        TileList tiles;
        assert_true(tiles_init(&tiles, w, h, sizes[s][2], sizes[s][3]));
        for (uint64_t i = 0; i < tiles.count; ++i) {
            const Tile t = tile_at(&tiles, i);
            assert_true(t.x0 < t.x1 && t.x1 <= w && t.y0 < t.y1 && t.y1 <= h);
            for (uint32_t y = t.y0; y < t.y1; ++y) {
                for (uint32_t x = t.x0; x < t.x1; ++x) {
                    assert_int_equal(seen[y * w + x]++, 0);
                }
            }
        }
        assert_null(memchr(seen, 0, (size_t)w * h));
        tiles_free(&tiles);
        free(seen);
    }
}

static void tiles_follow_their_neighbours(void **state)
{
    (void)state;
    TileList tiles;
    assert_true(tiles_init(&tiles, 512, 512, TILE_SIZE, TILE_SIZE));
    for (uint64_t i = 1; i < tiles.count; ++i) {
        const Tile a = tile_at(&tiles, i - 1), b = tile_at(&tiles, i);
        const int dx = abs((int)a.x0 - (int)b.x0), dy = abs((int)a.y0 - (int)b.y0);
        assert_int_equal(dx + dy, TILE_SIZE);
    }
    tiles_free(&tiles);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_merge_to_the_bytes_of_the_whole),
        cmocka_unit_test(what_does_not_fit_is_not_merged),
        cmocka_unit_test(sizes_are_checked),
        cmocka_unit_test(mean_and_variance_are_the_samples),
        cmocka_unit_test(layers_are_means_over_hits),
        cmocka_unit_test(srgb_is_the_standards_curve),
        cmocka_unit_test(curves_follow_their_sources),
        cmocka_unit_test(curves_rise_and_stay_in_range),
        cmocka_unit_test(development_applies_exposure_and_tone),
        cmocka_unit_test(tiles_cover_each_pixel_once),
        cmocka_unit_test(tiles_follow_their_neighbours),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
