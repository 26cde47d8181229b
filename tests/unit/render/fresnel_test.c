// The Fresnel formulas, Snell's law, and reference check 23.
#include "../../trust.h"
#include "../test_support.h"
#include "base/fresnel.h"

#include <complex.h>

#define assert_near(a, b, tolerance)                                                               \
    do {                                                                                           \
        double near_a = (a), near_b = (b);                                                         \
        if (!(fabs(near_a - near_b) <= (tolerance))) {                                             \
            fail_msg("%s = %.10g, not %.10g", #a, near_a, near_b);                                 \
        }                                                                                          \
    } while (0)

static double degrees(double x)
{
    return x * PI / 180;
}

static void known_values(void **state)
{
    (void)state;
    assert_true(
        trust_near("23 Fresnel 1.5, 0 degrees", 0.04, fresnel_dielectric(1, 1.5, NULL), 1e-12));
    assert_true(trust_near("23 Fresnel 1.5, 45 degrees", 0.0502399,
                           fresnel_dielectric(cos(degrees(45)), 1.5, NULL), 5e-8));
    assert_true(trust_near("23 Fresnel 1.5, Brewster's angle", 0.0739645,
                           fresnel_dielectric(cos(atan(1.5)), 1.5, NULL), 5e-8));
    assert_true(trust_near("23 Fresnel 1.5, 75 degrees", 0.2530606,
                           fresnel_dielectric(cos(degrees(75)), 1.5, NULL), 5e-8));
    assert_near(fresnel_dielectric(0, 1.5, NULL), 1, 1e-12);
    // Nothing there: nothing reflected, at any angle.
    for (double c = 0; c <= 1; c += 0.125) {
        assert_near(fresnel_dielectric(c, 1, NULL), 0, 1e-15);
        assert_near(fresnel_dielectric_schlick(c, 1, NULL), 0, 1e-15);
    }
    // The critical angle.
    double critical = asin(1 / 1.5), inside = 0, outside = PI / 2;
    for (int i = 0; i < 60; ++i) { // where all is reflected from, by bisection
        const double middle = (inside + outside) / 2;
        *(fresnel_dielectric(cos(middle), 1 / 1.5, NULL) < 1 ? &inside : &outside) = middle;
    }
    assert_true(
        trust_near("23 Fresnel 1.5, critical angle in degrees", 41.8103, inside * 180 / PI, 5e-5));
    assert_true(fresnel_dielectric(cos(critical - 1e-6), 1 / 1.5, NULL) < 1);
    assert_true(fresnel_dielectric(cos(critical + 1e-6), 1 / 1.5, NULL) == 1);
    assert_true(fresnel_dielectric_schlick(cos(critical + 1e-6), 1 / 1.5, NULL) == 1);
    // Schlick: slides, section 3.2.
    assert_near(fresnel_f0(1.5), 0.04, 1e-12);
    assert_near(fresnel_f0(1 / 1.5), 0.04, 1e-12);
    assert_near(fresnel_dielectric_schlick(0.5, 1.5, NULL), 0.04 + 0.96 / 32, 1e-12);
}

// Both formulas agree on the two directions of a ray, and cos_t obeys Snell's law.
static void both_directions_agree(void **state)
{
    (void)state;
    for (int i = 1; i <= 1000; ++i) {
        double ci = i / 1000.0, eta = 1 + i % 37 * 0.05, ct, back;
        double f = fresnel_dielectric(ci, eta, &ct);
        assert_near(sqrt(1 - ci * ci), eta * sqrt(1 - ct * ct), 1e-12);
        assert_near(fresnel_dielectric(ct, 1 / eta, &back), f, 1e-9);
        assert_near(back, ci, 1e-9);
        double s = fresnel_dielectric_schlick(ci, eta, NULL);
        assert_near(fresnel_dielectric_schlick(ct, 1 / eta, NULL), s, 1e-9);
    }
}

// The slides' formulas for the directions, straight from the text.
static void directions(void **state)
{
    (void)state;
    Vec3 n = normalize(vec3(1, -2, 3));
    for (int i = 0; i < 200; ++i) {
        Vec3 wi = normalize(vec3(sin(i * 1.7) + 0.4, cos(i * 2.9), sin(i * 0.6) * 2));
        if (dot(wi, n) <= 0) {
            wi = neg(wi);
        }
        double eta = 0.5 + 0.01 * i, r = 1 / eta, ci = dot(n, wi);
        double root = 1 - r * r * (1 - ci * ci);
        Vec3 wt;
        assert_int_equal(refract(wi, n, eta, &wt), root >= 0);
        if (root >= 0) {
            double ct = sqrt(root);
            Vec3 expected = sub(scale(n, r * ci - ct), scale(wi, r));
            assert_near(length(sub(wt, expected)), 0, 1e-12);
            assert_near(dot(wt, n), -ct, 1e-12);
            assert_near(length(sub(refract_with(wi, n, eta, ct), expected)), 0, 1e-12);
        }
        Vec3 wr = reflect(wi, n);
        assert_near(dot(wr, n), ci, 1e-12);
        assert_near(length(sub(normalize(add(wr, wi)), n)), 0, 1e-9);
    }
}

// The conductor's formula against complex arithmetic.
static void conductors(void **state)
{
    (void)state;
    static const double METALS[][2] = {
        {0.143, 3.983}, {1.442, 1.603}, {0.2, 3.9}, {2.9, 3.1}, {1.5, 0}};
    for (size_t i = 0; i < TEST_COUNT(METALS); ++i) {
        double eta = METALS[i][0], k = METALS[i][1];
        for (double c = 0.001; c <= 1; c += 0.0333) {
            double complex m2 = (eta + k * I) * (eta + k * I);
            double complex root = csqrt(m2 - (1 - c * c));
            double rs = cabs((c - root) / (c + root)), rp = cabs((m2 * c - root) / (m2 * c + root));
            assert_near(fresnel_conductor(c, eta, k), 0.5 * (rs * rs + rp * rp), 1e-12);
        }
        assert_near(fresnel_conductor(1, eta, k), fresnel_conductor_f0(eta, k), 1e-12);
        assert_near(fresnel_conductor(0, eta, k), 1, 1e-9);
    }
    assert_near(fresnel_conductor(0.3, 1.5, 0), fresnel_dielectric(0.3, 1.5, NULL), 1e-12);
}

static double mean_by_quadrature(double eta)
{
    enum { N = 400000 };
    double sum = 0;
    for (int i = 0; i < N; ++i) {
        double c = (i + 0.5) / N;
        sum += 2 * c * fresnel_dielectric(c, eta, NULL) / N;
    }
    return sum;
}

static void means(void **state)
{
    (void)state;
    assert_true(trust_near("23 Fresnel 1.5, cosine average from outside", 0.0917780,
                           fresnel_dielectric_mean(1.5), 5e-8));
    assert_true(trust_near("23 Fresnel 1.5, cosine average from inside", 0.5963458,
                           fresnel_dielectric_mean(1 / 1.5), 5e-8));
    static const double ETA[] = {1.0001, 1.02, 1.33, 2.42, 7, 1 / 1.33, 0.3};
    for (size_t i = 0; i < TEST_COUNT(ETA); ++i) {
        assert_near(fresnel_dielectric_mean(ETA[i]), mean_by_quadrature(ETA[i]), 1e-6);
    }
    assert_near(fresnel_dielectric_mean(1), 0, 1e-12);
    assert_near(fresnel_schlick_mean(0.04), 0.04 + 0.96 / 21, 1e-12);
    assert_near(fresnel_conductor_mean(1.5, 0), fresnel_dielectric_mean(1.5), 1e-4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_values), cmocka_unit_test(both_directions_agree),
        cmocka_unit_test(directions),   cmocka_unit_test(conductors),
        cmocka_unit_test(means),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
