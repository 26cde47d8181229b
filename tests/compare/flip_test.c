// ꟻLIP against its paper's definition (Andersson et al. 2020), by values that follow from it in
// closed form: section and table numbers are the paper's.
#include "../unit/test_support.h"

#include "../../compare/metrics/flip.h"

#include <math.h>
#include <string.h>

enum { SIZE = 64 };

static const double PPD = 67.0206432765823; // 0.7 m from 0.7 m and 3840 pixels: 3840 π/180

static void expect_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance)) {
        fail_msg("%.9g, not %.9g", value, expected);
    }
}

static void fill(float *picture, float r, float g, float b)
{
    for (int i = 0; i < SIZE * SIZE; ++i) {
        picture[3 * i] = r;
        picture[3 * i + 1] = g;
        picture[3 * i + 2] = b;
    }
}

static void test_viewing_conditions(void **state)
{
    (void)state;
    expect_near(flip_pixels_per_degree(0.7, 0.7, 3840), PPD, 1e-9);
}

static void test_equal_pictures_have_no_error(void **state)
{
    (void)state;
    static float a[SIZE * SIZE * 3], error[SIZE * SIZE];
    for (int i = 0; i < SIZE * SIZE * 3; ++i) {
        a[i] = (float)((i * 7919) % 1000) / 999;
    }
    assert_true(flip(a, a, SIZE, SIZE, PPD, error));
    for (int i = 0; i < SIZE * SIZE; ++i) {
        expect_near((double)error[i], 0, 1e-6);
    }
}

// Even pictures have no edges and pass the filters unchanged, so that section 4.1 alone counts.
static void test_even_pictures(void **state)
{
    (void)state;
    static float a[SIZE * SIZE * 3], b[SIZE * SIZE * 3], error[SIZE * SIZE];
    fill(a, 0, 1, 0);
    fill(b, 0, 0, 1);
    assert_true(flip(a, b, SIZE, SIZE, PPD, error)); // the largest distance there is
    expect_near((double)error[SIZE * SIZE / 2 + SIZE / 2], 1, 1e-5);
    // Black and white are 100 apart in L*. Green is L* a* b* = (87.7347, -86.1827, 83.1793), blue
    // (32.2970, 79.1875, -107.8602); Hunt's effect multiplies a*, b* by L*/100.
    const double ga = -86.1827 * 0.877347, gb = 83.1793 * 0.877347;
    const double ba = 79.1875 * 0.322970, bb = -107.8602 * 0.322970;
    const double largest = pow(87.7347 - 32.2970 + hypot(ga - ba, gb - bb), 0.7);
    const double distance = pow(100, 0.7), knee = 0.4 * largest;
    fill(a, 0, 0, 0);
    fill(b, 1, 1, 1);
    assert_true(flip(a, b, SIZE, SIZE, PPD, error));
    expect_near((double)error[0], 0.95 + 0.05 * (distance - knee) / (largest - knee), 1e-4);
    // Below the knee the map is linear: L* of a gray of luminance y is 116 cbrt(y) - 16.
    fill(a, 0.2f, 0.2f, 0.2f);
    fill(b, 0.25f, 0.25f, 0.25f);
    assert_true(flip(a, b, SIZE, SIZE, PPD, error));
    const double small = pow(116 * (cbrt(0.25) - cbrt(0.2)), 0.7);
    expect_near((double)error[0], 0.95 / knee * small, 1e-4);
}

static void test_contrast_kernels(void **state)
{
    (void)state;
    // Table 1, by the ratio of a weight to that one pixel beside it.
    const double b1[] = {0.0047, 0.0053};
    for (int c = 0; c < 3; ++c) {
        FlipKernel kernel;
        assert_true(flip_contrast_kernel((FlipChannel)c, PPD, &kernel));
        const int side = 2 * kernel.radius + 1, middle = side * kernel.radius + kernel.radius;
        assert_int_equal(kernel.radius, 10); // ceil(3 sqrt(0.04/(2 π²)) 67.02)
        double sum = 0;
        for (int i = 0; i < side * side; ++i) {
            sum += kernel.weights[i];
        }
        expect_near(sum, 1, 1e-12);
        expect_near(kernel.weights[middle + 1], kernel.weights[middle - side], 1e-15);
        if (c < 2) {
            expect_near(kernel.weights[middle + 1] / kernel.weights[middle],
                        exp(-M_PI * M_PI / (PPD * PPD * b1[c])), 1e-9);
        }
        flip_kernel_free(&kernel);
    }
}

static void test_feature_kernels(void **state)
{
    (void)state;
    for (int points = 0; points < 2; ++points) {
        FlipKernel kernel;
        assert_true(flip_feature_kernel(points != 0, PPD, &kernel));
        const int side = 2 * kernel.radius + 1;
        assert_int_equal(kernel.radius, 9); // ceil(3 0.5 0.082 67.02)
        double positive = 0, negative = 0;
        for (int i = 0; i < side * side; ++i) {
            *(kernel.weights[i] > 0 ? &positive : &negative) += kernel.weights[i];
        }
        expect_near(positive, 1, 1e-12);
        expect_near(negative, -1, 1e-12);
        flip_kernel_free(&kernel);
    }
}

// A step of gray: beside it the edge detector gives the step's height, since all of its negative
// weights lie on one side; and the color is that of the filtered step.
static void test_step(void **state)
{
    (void)state;
    static float a[SIZE * SIZE * 3], b[SIZE * SIZE * 3], error[SIZE * SIZE];
    const double low = 0.3, high = 0.5;
    const int at = SIZE / 2;
    fill(a, (float)low, (float)low, (float)low);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        b[3 * i] = b[3 * i + 1] = b[3 * i + 2] = (float)(i % SIZE > at ? high : low);
    }
    assert_true(flip(a, b, SIZE, SIZE, PPD, error));
    FlipKernel kernel;
    assert_true(flip_contrast_kernel(FLIP_ACHROMATIC, PPD, &kernel));
    const int side = 2 * kernel.radius + 1;
    double right = 0;
    for (int i = 0; i < side * side; ++i) {
        right += i % side > kernel.radius ? kernel.weights[i] : 0;
    }
    flip_kernel_free(&kernel);
    const double seen = low + (high - low) * right;
    const double one[3] = {low, low, low}, other[3] = {seen, seen, seen};
    const double color = flip_color_difference(one, other);
    const double expected = pow(color, 1 - sqrt((high - low) / sqrt(2)));
    expect_near((double)error[at * SIZE + at], expected, 1e-4);
    // Far from the step nothing differs on its left, and only the color on its right.
    expect_near((double)error[at * SIZE], 0, 1e-6);
    const double far[3] = {high, high, high};
    expect_near((double)error[at * SIZE + SIZE - 1], flip_color_difference(one, far), 1e-4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_viewing_conditions),
        cmocka_unit_test(test_equal_pictures_have_no_error),
        cmocka_unit_test(test_even_pictures),
        cmocka_unit_test(test_contrast_kernels),
        cmocka_unit_test(test_feature_kernels),
        cmocka_unit_test(test_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
