// The sampler: the tables against their definition, stratification of every pixel's sequence,
// uniformity and independence across pixels and sets, and the rate at which integrals converge.
#include "base/hash.h"
#include "render/disc.h"
#include "render/sampler.h"
#include "render/sobol_tables.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint32_t reversed(uint32_t x)
{
    uint32_t out = 0;
    for (int i = 0; i < 32; ++i) {
        out |= (x >> i & 1) << (31 - i);
    }
    return out;
}

// Direction numbers v_k = m_k 2^(32-k) from a primitive polynomial of degree s with inner
// coefficients a (Joe and Kuo 2008, section 2).
static void direction_numbers(int s, uint32_t a, const uint32_t *m, uint32_t out[32])
{
    uint32_t all[32];
    for (int k = 0; k < 32; ++k) {
        if (s == 0) {
            all[k] = 1; // van der Corput
        } else if (k < s) {
            all[k] = m[k];
        } else {
            uint32_t v = all[k - s] ^ (all[k - s] << s);
            for (int i = 1; i < s; ++i) {
                v ^= (a >> (s - 1 - i) & 1) * (all[k - i] << i);
            }
            all[k] = v;
        }
        out[k] = all[k] << (31 - k);
    }
}

static void tables_follow_from_the_polynomials(void **state)
{
    (void)state;
    uint32_t v[4][32];
    direction_numbers(0, 0, NULL, v[0]);
    direction_numbers(1, 0, (const uint32_t[]){1}, v[1]);
    direction_numbers(2, 1, (const uint32_t[]){1, 3}, v[2]);
    direction_numbers(3, 1, (const uint32_t[]){1, 3, 1}, v[3]);
    for (uint32_t k = 0; k < 8; ++k) {
        for (uint32_t n = 0; n < 16; ++n) {
            for (int d = 0; d < 4; ++d) {
                uint32_t want = 0;
                for (uint32_t bit = 0; bit < 4; ++bit) {
                    want ^= (n >> bit & 1) * reversed(v[d][31 - (4 * k + bit)]);
                }
                assert_int_equal(sobol_nibbles[k][n][d], want);
            }
        }
    }
}

static void draw(uint32_t seed, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension,
                 double out[4])
{
    Sampler s;
    sampler_start(&s, seed, x, y, sample);
    sampler_seek(&s, dimension);
    for (int d = 0; d < 4; ++d) {
        out[d] = (double)sampler_1d(&s);
    }
}

// Every elementary interval 2^-a × 2^-(m-a) of the square holds one of 2^m points.
static bool is_net(const double (*points)[4], uint32_t m, int d0, int d1)
{
    bool *hit = malloc((size_t)1 << m);
    assert_non_null(hit);
    bool ok = true;
    for (uint32_t a = 0; ok && a <= m; ++a) {
        memset(hit, 0, (size_t)1 << m);
        for (uint32_t i = 0; ok && i < 1u << m; ++i) {
            const uint32_t x = (uint32_t)(points[i][d0] * (1u << a));
            const uint32_t y = (uint32_t)(points[i][d1] * (1u << (m - a)));
            const uint32_t cell = x << (m - a) | y;
            ok = !hit[cell];
            hit[cell] = true;
        }
    }
    free(hit);
    return ok;
}

static void first_two_dimensions_are_nets(void **state)
{
    (void)state;
    enum { MOST = 1 << 10 };
    static double points[MOST][4];
    for (uint32_t pixel = 0; pixel < 40; ++pixel) {
        const uint32_t set = pixel % 5, m = pixel % 11;
        // Any aligned run of 2^m samples, not only the first.
        const uint32_t start = (pixel * 7919 % 1000) << m;
        for (uint32_t i = 0; i < 1u << m; ++i) {
            draw(3, pixel, 2 * pixel, start + i, 4 * set, points[i]);
        }
        assert_true(is_net((const double(*)[4])points, m, 0, 1));
    }
}

static void draw_neighbour(uint32_t seed, uint32_t x, uint32_t y, uint32_t sample,
                           uint32_t dimension, double out[4])
{
    Sampler s;
    sampler_start_neighbour(&s, seed, x, y, sample);
    sampler_seek(&s, dimension);
    for (int d = 0; d < 4; ++d) {
        out[d] = (double)sampler_1d(&s);
    }
}

// 4^b samples, from a multiple of 4^b on, of each aligned square of 2^a × 2^a pixels are a net; so
// are any 2^m of one pixel.
static void neighbours_complete_one_another(void **state)
{
    (void)state;
    enum { MOST = 1 << 12 };
    static double points[MOST][4];
    for (uint32_t i = 0; i < 200; ++i) {
        const uint32_t a = i % 5, most = a < 3 ? 5 - a : 2, b = i / 5 % (most + 1);
        const uint32_t x0 = hash_u32(i) % 64 << a, y0 = hash_u32(~i) % 64 << a;
        const uint32_t start = (i * 7919 % 100) << 2 * b, set = i % 7;
        for (uint32_t k = 0; k < 1u << (2 * a + 2 * b); ++k) {
            const uint32_t pixel = k >> 2 * b;
            draw_neighbour(5, x0 + pixel % (1u << a), y0 + (pixel >> a), start + k % (1u << 2 * b),
                           4 * set, points[k]);
        }
        assert_true(is_net((const double(*)[4])points, 2 * a + 2 * b, 0, 1));
    }
    for (uint32_t pixel = 0; pixel < 40; ++pixel) {
        const uint32_t m = pixel % 11, start = (pixel * 7919 % 1000) << m;
        for (uint32_t i = 0; i < 1u << m; ++i) {
            draw_neighbour(3, pixel, 3 * pixel, start + i, 4 * (pixel % 5), points[i]);
        }
        assert_true(is_net((const double(*)[4])points, m, 0, 1));
    }
}

// A shadow's edge, by one sample a pixel: the mean of each 4 × 4 pixels errs far less than that of
// independent pixels, which is the same as 16 samples would (variance f (1 - f) / 16).
static void noise_is_fine_grained(void **state)
{
    (void)state;
    const double radius = 0.7, f = PI / 4 * radius * radius; // of a quarter of a disc
    for (uint32_t set = 0; set < 4; ++set) {
        double square = 0;
        enum { BLOCKS = 1024 };
        for (uint32_t block = 0; block < BLOCKS; ++block) {
            double inside = 0;
            for (uint32_t i = 0; i < 16; ++i) {
                double p[4];
                draw_neighbour(11, block % 32 * 4 + i % 4, block / 32 * 4 + i / 4, 0, 4 * set, p);
                inside += p[0] * p[0] + p[1] * p[1] < radius * radius;
            }
            square += (inside / 16 - f) * (inside / 16 - f) / BLOCKS;
        }
        // The ratio is near 0.2; of independent pixels it would be 1 with a deviation of 0.044.
        assert_true(square < 0.4 * f * (1 - f) / 16);
    }
}

// Each pixel by itself is as random as it would be alone: its first points over many seeds, in
// cells; 4.9 standard deviations of chi-squared's are one failure in a million.
static void each_neighbour_is_uniform(void **state)
{
    (void)state;
    enum { SIDE = 8, SEEDS = 20000 };
    for (uint32_t pixel = 0; pixel < 6; ++pixel) {
        for (int d = 0; d < 3; ++d) {
            double count[SIDE * SIDE] = {0};
            for (uint32_t seed = 0; seed < SEEDS; ++seed) {
                double p[4];
                draw_neighbour(seed, 5 * pixel, 7 * pixel, pixel, 8, p);
                ++count[(int)(p[d] * SIDE) * SIDE + (int)(p[d + 1] * SIDE)];
            }
            const double mean = (double)SEEDS / (SIDE * SIDE);
            double chi = 0;
            for (int i = 0; i < SIDE * SIDE; ++i) {
                chi += (count[i] - mean) * (count[i] - mean) / mean;
            }
            const double freedom = SIDE * SIDE - 1;
            assert_true(fabs(chi - freedom) < 4.9 * sqrt(2 * freedom));
        }
    }
}

static void every_dimension_is_stratified(void **state)
{
    (void)state;
    enum { N = 256 };
    for (uint32_t pixel = 0; pixel < 20; ++pixel) {
        bool hit[4][N] = {{false}};
        for (uint32_t i = 0; i < N; ++i) {
            double p[4];
            draw(9, pixel, 5, N * pixel + i, 4 * pixel, p);
            for (int d = 0; d < 4; ++d) {
                const int cell = (int)(p[d] * N);
                assert_false(hit[d][cell]);
                hit[d][cell] = true;
            }
        }
    }
}

static void sixteen_points_fill_four_dimensions(void **state)
{
    (void)state;
    // The four dimensions of Sobol are no (0, 4)-net, but 2^4 points of a digital net with t <= 3
    // hold at most 2^t points in each elementary interval of volume 2^-4.
    for (uint32_t pixel = 0; pixel < 50; ++pixel) {
        int count[16] = {0};
        for (uint32_t i = 0; i < 16; ++i) {
            double p[4];
            draw(1, pixel, 77, i, 0, p);
            const int cell =
                (p[0] >= 0.5) | (p[1] >= 0.5) << 1 | (p[2] >= 0.5) << 2 | (p[3] >= 0.5) << 3;
            ++count[cell];
        }
        for (int c = 0; c < 16; ++c) {
            assert_in_range(count[c], 0, 8);
        }
    }
}

// --- Chi-squared tests over many pixels

// The chance that chi² with k degrees of freedom is larger, by Wilson and Hilferty's cube root.
static double chi2_p(double chi2, double k)
{
    const double z = (cbrt(chi2 / k) - (1 - 2 / (9 * k))) / sqrt(2 / (9 * k));
    return 0.5 * erfc(z / sqrt(2));
}

enum { CELLS = 16, DRAWS = 1 << 18 };

// Uniform over a CELLS × CELLS grid? Ten tests at a family-wise 1e-3; a cell's share that is off by
// 10 % in a tenth of the cells would be found with near certainty at 1024 draws a cell.
static double grid_p(void (*pair)(uint32_t i, double *x, double *y))
{
    static int count[CELLS][CELLS];
    memset(count, 0, sizeof count);
    for (uint32_t i = 0; i < DRAWS; ++i) {
        double x, y;
        pair(i, &x, &y);
        assert_true(x >= 0 && x < 1 && y >= 0 && y < 1);
        ++count[(int)(y * CELLS)][(int)(x * CELLS)];
    }
    const double expected = (double)DRAWS / (CELLS * CELLS);
    double chi2 = 0;
    for (int c = 0; c < CELLS * CELLS; ++c) {
        const double d = (&count[0][0])[c] - expected;
        chi2 += d * d / expected;
    }
    return chi2_p(chi2, CELLS * CELLS - 1);
}

static void pair_of_pixel(uint32_t i, double *x, double *y)
{
    double p[4];
    draw(0, i & 511, i >> 9, 0, 0, p);
    *x = p[0];
    *y = p[1];
}
static void pair_of_lens(uint32_t i, double *x, double *y)
{
    double p[4];
    draw(0, i & 511, i >> 9, 5, 0, p);
    *x = p[2];
    *y = p[3];
}
static void neighbours_across(uint32_t i, double *x, double *y)
{
    double p[4], q[4];
    draw(0, 2 * (i & 511), i >> 9, 0, 0, p);
    draw(0, 2 * (i & 511) + 1, i >> 9, 0, 0, q);
    *x = p[0];
    *y = q[0];
}
static void neighbours_down(uint32_t i, double *x, double *y)
{
    double p[4], q[4];
    draw(0, i & 511, 2 * (i >> 9), 3, 0, p);
    draw(0, i & 511, 2 * (i >> 9) + 1, 3, 0, q);
    *x = p[1];
    *y = q[1];
}
static void sets_of_a_sample(uint32_t i, double *x, double *y)
{
    double p[4], q[4];
    draw(0, i & 511, i >> 9, 1, 0, p);
    draw(0, i & 511, i >> 9, 1, 4, q);
    *x = p[0];
    *y = q[0];
}
static void far_sets_of_a_sample(uint32_t i, double *x, double *y)
{
    double p[4], q[4];
    draw(0, i & 511, i >> 9, 1, 8, p);
    draw(0, i & 511, i >> 9, 1, 36, q);
    *x = p[1];
    *y = q[2];
}
static void seeds(uint32_t i, double *x, double *y)
{
    double p[4], q[4];
    draw(i, 3, 4, 0, 0, p);
    draw(i + 1, 3, 4, 0, 0, q);
    *x = p[0];
    *y = q[0];
}
static void samples_of_pixels(uint32_t i, double *x, double *y)
{
    double p[4], q[4];
    draw(0, i & 511, i >> 9, 0, 0, p);
    draw(0, i & 511, i >> 9, 2, 0, q);
    // Successive points of one pixel fall into different halves by design; what lies below that
    // must not be tied.
    *x = fmod(p[0] * 16, 1);
    *y = fmod(q[0] * 16, 1);
}

static void pixels_sets_and_seeds_are_independent(void **state)
{
    (void)state;
    void (*const pairs[])(uint32_t, double *, double *) = {
        pair_of_pixel,        pair_of_lens, neighbours_across, neighbours_down, sets_of_a_sample,
        far_sets_of_a_sample, seeds,        samples_of_pixels,
    };
    const size_t n = sizeof pairs / sizeof *pairs;
    const double alpha = 1 - pow(1 - 1e-3, 1 / (double)n); // Šidák
    for (size_t i = 0; i < n; ++i) {
        const double p = grid_p(pairs[i]);
        if (!(p > alpha && p < 1 - alpha / 100)) {
            fail_msg("pair %zu: p = %g", i, p);
        }
    }
}

// --- Convergence -------------------------------------------------------------------------------

// Smooth, of mean 0: root mean square error over many pixels of the mean of n samples.
static double error_with(uint32_t n, uint32_t set, int d0, int d1)
{
    enum { PIXELS = 200 };
    double square = 0;
    for (uint32_t pixel = 0; pixel < PIXELS; ++pixel) {
        double sum = 0;
        for (uint32_t i = 0; i < n; ++i) {
            double p[4];
            draw(11, pixel, 1, i, 4 * set, p);
            sum += exp(p[d0]) * cos(2 * p[d1]) - (exp(1.0) - 1) * sin(2.0) / 2;
        }
        square += sum * sum / ((double)n * n);
    }
    return sqrt(square / PIXELS);
}

// Owen 1997: variance n^-3 (log n)^(s-1) for smooth integrands; independent samples give n^-1.
static void smooth_integrals_converge_fast(void **state)
{
    (void)state;
    for (uint32_t set = 0; set < 3; ++set) {
        const double coarse = error_with(16, set, 0, 1), fine = error_with(1024, set, 0, 1);
        const double slope = log(fine / coarse) / log(1024.0 / 16);
        if (!(slope < -1.35 && slope > -1.75)) {
            fail_msg("set %u: error falls as n^%g", set, slope);
        }
        const double slope_lens =
            log(error_with(1024, set, 2, 3) / error_with(16, set, 2, 3)) / log(1024.0 / 16);
        if (!(slope_lens < -1.2)) {
            fail_msg("set %u, dimensions 2 and 3: error falls as n^%g", set, slope_lens);
        }
    }
}

// The star discrepancy's lower bound over a grid of corners.
static double discrepancy(const double (*points)[2], int n)
{
    double worst = 0;
    for (int a = 1; a <= 32; ++a) {
        for (int b = 1; b <= 32; ++b) {
            int inside = 0;
            for (int i = 0; i < n; ++i) {
                inside += points[i][0] < a / 33.0 && points[i][1] < b / 33.0;
            }
            worst = fmax(worst, fabs((double)inside / n - a / 33.0 * b / 33.0));
        }
    }
    return worst;
}

static void discrepancy_is_far_below_randoms(void **state)
{
    (void)state;
    enum { N = 256 };
    double own = 0, random = 0;
    uint64_t key = 5;
    for (uint32_t pixel = 0; pixel < 20; ++pixel) {
        double ours[N][2], theirs[N][2];
        for (uint32_t i = 0; i < N; ++i) {
            double p[4];
            draw(2, pixel, pixel, i, 0, p);
            for (int d = 0; d < 2; ++d) {
                ours[i][d] = p[d];
                key = hash_u64(key);
                theirs[i][d] = (double)(key >> 11) * 0x1p-53;
            }
        }
        own += discrepancy((const double(*)[2])ours, N) / 20;
        random += discrepancy((const double(*)[2])theirs, N) / 20;
    }
    assert_true(own < random / 3);
}

static void dimensions_are_handed_out_in_order(void **state)
{
    (void)state;
    double set0[4], set1[4], set2[4];
    draw(1, 2, 3, 4, 0, set0);
    draw(1, 2, 3, 4, 4, set1);
    draw(1, 2, 3, 4, 8, set2);
    Sampler s;
    sampler_start(&s, 1, 2, 3, 4);
    float u, v;
    assert_true((double)sampler_1d(&s) == set0[0]);
    sampler_2d(&s, &u, &v);
    assert_true((double)u == set0[1] && (double)v == set0[2]);
    sampler_2d(&s, &u, &v); // not across two sets
    assert_true((double)u == set1[0] && (double)v == set1[1]);
    sampler_seek(&s, 7); // rounded up
    assert_true((double)sampler_1d(&s) == set2[0]);
    sampler_seek(&s, 4); // and back
    assert_true((double)sampler_1d(&s) == set1[0]);
}

// Eight at once are those of eight calls, and sampler_1d_fine's further bits can be had later.
static void eight_at_once_are_the_same(void **state)
{
    (void)state;
    for (uint32_t first = 0; first < 64; first += 4) {
        Sampler one, many, fine;
        sampler_start(&one, 1, 2, 3, first);
        many = fine = one;
        sampler_seek(&one, first);
        sampler_seek(&fine, first);
        const float *eight = sampler_eight(&many, first);
        for (uint32_t d = 0; d < 8; ++d) {
            assert_true(sampler_1d(&one) == eight[d]);
            assert_true(sampler_1d_fine(&fine) ==
                        (double)eight[d] + sampler_finer(&many, first + d));
        }
        assert_true(sampler_1d(&many) == sampler_1d(&one));
    }
}

// What the processor has for many dimensions at once gives what the plain function does, bit by
// bit.
static void all_ways_to_fill_are_the_same(void **state)
{
    (void)state;
    SamplerFill *fills[2];
    const int count = sampler_fills(fills);
    for (uint32_t i = 0; i < 2000; ++i) {
        Sampler s;
        const uint32_t x = hash_u32(i) % 5000, y = hash_u32(~i) % 5000;
        const uint32_t sample = hash_u32(i + 7) >> (i % 32), dimension = hash_u32(i + 9) % 1000;
        (i % 2 ? sampler_start : sampler_start_neighbour)(&s, i / 100, x, y, sample);
        for (int k = 0; k < count; ++k) {
            Sampler filled = s;
            fills[k](&filled, dimension);
            assert_int_equal(filled.first, dimension & ~3U);
            assert_true(filled.held >= 8 && filled.held <= SAMPLER_AHEAD);
            for (uint32_t d = 0; d < filled.held; d += 8) {
                Sampler plain = s;
                fills[0](&plain, filled.first + d);
                assert_memory_equal(plain.values, filled.values + d, 8 * sizeof *plain.values);
            }
        }
    }
}

// sample_disc against the sines and cosines that its series stand for (Shirley and Chiu 1997).
static void disc_follows_its_formula(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 100000; ++i) {
        const float u = (float)(hash_u32(2 * i) >> 8) * 0x1p-24F;
        const float v = i % 10 ? (float)(hash_u32(2 * i + 1) >> 8) * 0x1p-24F : 1 - u;
        const double a = 2 * (double)u - 1, b = 2 * (double)v - 1;
        const double r = fabs(a) > fabs(b) ? a : b;
        const double phi = fabs(a) > fabs(b) ? PI / 4 * b / a : PI / 2 - PI / 4 * a / b;
        const Vec2 p = sample_disc(u, v);
        assert_true(fabs(p.x - r * cos(phi)) < 1e-7 && fabs(p.y - r * sin(phi)) < 1e-7);
        const Vec3 d = sample_cosine_hemisphere(u, v);
        assert_true(fabs(length(d) - 1) < 1e-7 && d.z >= 0);
    }
    const Vec2 middle = sample_disc(0.5F, 0.5F);
    assert_true(middle.x == 0 && middle.y == 0);
}

static void sampling_is_pinned(void **state)
{
    (void)state;
    // Pictures made with a seed shall stay what they are: a change here changes every picture.
    uint32_t sum = 0;
    for (uint32_t i = 0; i < 1000; ++i) {
        double p[4];
        draw(i % 7, i % 13, i % 17, i, i % 40, p);
        for (int d = 0; d < 4; ++d) {
            sum = hash_combine(sum, (uint32_t)(p[d] * 0x1p24));
        }
    }
    assert_int_equal(sum, 0x1385c54a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_follow_from_the_polynomials),
        cmocka_unit_test(first_two_dimensions_are_nets),
        cmocka_unit_test(neighbours_complete_one_another),
        cmocka_unit_test(noise_is_fine_grained),
        cmocka_unit_test(each_neighbour_is_uniform),
        cmocka_unit_test(every_dimension_is_stratified),
        cmocka_unit_test(sixteen_points_fill_four_dimensions),
        cmocka_unit_test(pixels_sets_and_seeds_are_independent),
        cmocka_unit_test(smooth_integrals_converge_fast),
        cmocka_unit_test(discrepancy_is_far_below_randoms),
        cmocka_unit_test(dimensions_are_handed_out_in_order),
        cmocka_unit_test(eight_at_once_are_the_same),
        cmocka_unit_test(all_ways_to_fill_are_the_same),
        cmocka_unit_test(disc_follows_its_formula),
        cmocka_unit_test(sampling_is_pinned),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
