// Pixel filters: the drawn places have the filter's density, and mean zero.
#include "render/filter.h"

#include "base/vec.h"
#include "near.h"

static const FilterKind kinds[] = {FILTER_BOX, FILTER_TENT, FILTER_GAUSSIAN,
                                   FILTER_BLACKMAN_HARRIS};
enum { KINDS = 4 };

// The filters as their definitions have them, not normalized; x in pixels, w the whole width.
static double definition(FilterKind kind, double x, double w)
{
    switch (kind) {
    case FILTER_BOX:
        return 1;
    case FILTER_TENT:
        return 1 - fabs(2 * x / w);
    case FILTER_GAUSSIAN:
        return exp(-x * x / (2 * (w / 6) * (w / 6)));
    case FILTER_BLACKMAN_HARRIS:
    case FILTER_CENTER:
        break;
    }
    const double t = 2 * PI * (x / w + 0.5);
    return 0.35875 - 0.48829 * cos(t) + 0.14128 * cos(2 * t) - 0.01168 * cos(3 * t);
}

static double integral(FilterKind kind, double a, double b, double w)
{
    enum { STEPS = 200 }; // Simpson
    double sum = 0;
    for (int i = 0; i <= STEPS; ++i) {
        const double weight = i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2;
        sum += weight * definition(kind, a + (b - a) * i / STEPS, w);
    }
    return sum * (b - a) / (3 * STEPS);
}

static void cumulative_is_the_definitions_integral(void **state)
{
    (void)state;
    for (int k = 0; k < KINDS; ++k) {
        const double w = filter_default_width(kinds[k]);
        const double left = integral(kinds[k], -w / 2, 0, w);
        for (int i = 0; i <= 20; ++i) {
            const double x = -w / 2 + w * i / 20;
            // In two steps about the tent's kink.
            const double part =
                x <= 0 ? integral(kinds[k], -w / 2, x, w) : left + integral(kinds[k], 0, x, w);
            assert_near(filter_cumulative(kinds[k], i / 20.0), part / (2 * left), 1e-8);
        }
    }
}

// Each of N strata of u, by the middle: the share of them that falls into a bin is the filter's
// integral over it, but for two strata at the bin's ends.
static void drawn_density_is_the_filters(void **state)
{
    (void)state;
    enum { N = 1 << 20, BINS = 60 };
    for (int k = 0; k < KINDS; ++k) {
        PixelFilter f;
        filter_init(&f, kinds[k], 0);
        const double w = f.width;
        int bins[BINS] = {0};
        double mean = 0, last = -w;
        for (int i = 0; i < N; ++i) {
            const double x = filter_sample(&f, (float)((i + 0.5) / N));
            assert_true(x >= -w / 2 && x <= w / 2 && x >= last);
            last = x;
            mean += x / N;
            const int bin = (int)((x / w + 0.5) * BINS);
            ++bins[bin < BINS ? bin : BINS - 1];
        }
        assert_near(mean, 0, 1e-9);
        const double all = 2 * integral(kinds[k], -w / 2, 0, w);
        for (int b = 0; b < BINS; ++b) {
            const double a = -w / 2 + w * b / BINS;
            const double want = integral(kinds[k], a, a + w / BINS, w) / all;
            // A cell of the table that straddles a bin's border is shared out evenly.
            assert_near((double)bins[b] / N, want, 2e-4);
        }
    }
}

// Second moments, which say how far a filter blurs: box w²/12, tent w²/24, gaussian σ² less what is
// cut off at 3σ, Blackman-Harris by quadrature.
static void spread_is_the_filters(void **state)
{
    (void)state;
    enum { N = 1 << 18 };
    const double cut = 1 - 2 * 3 * exp(-4.5) / (sqrt(2 * PI) * erf(3 / sqrt(2)));
    const double want[KINDS] = {1.0 / 12, 4.0 / 24, 0.25 * cut, 0.1726585};
    for (int k = 0; k < KINDS; ++k) {
        PixelFilter f;
        filter_init(&f, kinds[k], 0);
        double square = 0;
        for (int i = 0; i < N; ++i) {
            const double x = filter_sample(&f, (float)((i + 0.5) / N));
            square += x * x / N;
        }
        assert_near(square / want[k], 1, 1e-3);
    }
}

static void width_scales(void **state)
{
    (void)state;
    PixelFilter narrow, wide;
    filter_init(&narrow, FILTER_BLACKMAN_HARRIS, 1);
    filter_init(&wide, FILTER_BLACKMAN_HARRIS, 8);
    for (int i = 0; i < 1000; ++i) {
        const float u = (float)i / 1000;
        assert_near(8 * filter_sample(&narrow, u), filter_sample(&wide, u), 1e-12);
    }
    // The largest number that a sampler gives, and the smallest.
    const float most = 1 - 0x1p-24f;
    assert_true(filter_sample(&wide, most) <= 4 && filter_sample(&wide, most) > 3);
    assert_true(filter_sample(&wide, 0) >= -4 && filter_sample(&wide, 0) < -3);
}

static void center_never_leaves_it(void **state)
{
    (void)state;
    PixelFilter filter;
    for (int width = 0; width < 3; ++width) {
        filter_init(&filter, FILTER_CENTER, width);
        for (int i = 0; i < 1000; ++i) {
            assert_true(filter_sample(&filter, (float)i / 1000) == 0);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cumulative_is_the_definitions_integral),
        cmocka_unit_test(drawn_density_is_the_filters),
        cmocka_unit_test(spread_is_the_filters),
        cmocka_unit_test(width_scales),
        cmocka_unit_test(center_never_leaves_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
