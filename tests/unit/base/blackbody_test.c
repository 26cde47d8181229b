#include "../../trust.h"
#include "../test_support.h"

#include "base/blackbody.h"

static void planck_matches_reference_values(void **state)
{
    (void)state;
    // Reference check 16.
    assert_true(trust_near("16 blackbody, 483 nm, 6000 K, W/m2/sr/m", 3.1849e13,
                           planck_radiance(483e-9, 6000), 5e-5 * 3.1849e13));
    assert_true(trust_near("16 blackbody, 600 nm, 4500 K, W/m2/sr/m", 7.46497e12,
                           planck_radiance(600e-9, 4500), 5e-5 * 7.46497e12));
}

// Stefan and Boltzmann: the integral over all wavelengths is σ T⁴ / π.
static void planck_integrates_to_stefan_boltzmann(void **state)
{
    (void)state;
    double sum = 0, t = 3000;
    for (double l = 50e-9, step; l < 1e-3; l += step) {
        step = l * 1e-3;
        sum += planck_radiance(l + step / 2, t) * step;
    }
    assert_true(trust_near("16 blackbody over all wavelengths, sigma T^4 / pi", 1,
                           sum / (5.670374419e-8 * t * t * t * t / PI), 1e-3));
}

static void colors_have_luminance_1_and_go_from_red_to_blue(void **state)
{
    (void)state;
    double before = INFINITY;
    for (double t = 2000; t <= 20000; t *= 1.1) {
        double c[3];
        blackbody_color(t, c);
        assert_true(fabs(0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2] - 1) < 1e-9);
        assert_true(c[0] >= 0 && c[1] >= 0 && c[2] >= 0);
        assert_true(c[0] / (c[2] + 1e-9) <= before + 1e-9);
        before = c[0] / (c[2] + 1e-9);
    }
    for (double t = 300; t < 2000; t += 100) { // red alone, but luminous
        double c[3];
        blackbody_color(t, c);
        assert_true(isfinite(c[0]) && c[0] > c[1] && c[2] >= 0);
    }
    // Near 6504 K daylight's white point lies close by: nearly neutral.
    double white[3];
    blackbody_color(6504, white);
    assert_true(fabs(white[0] - 1) < 0.1 && fabs(white[1] - 1) < 0.1 && fabs(white[2] - 1) < 0.1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planck_matches_reference_values),
        cmocka_unit_test(planck_integrates_to_stefan_boltzmann),
        cmocka_unit_test(colors_have_luminance_1_and_go_from_red_to_blue),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
