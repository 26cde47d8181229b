// The short series for sines, cosines and angles against the C library's functions.
#include "base/angle.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

static void test_circle_point(void **state)
{
    (void)state;
    enum { STEPS = 100000 };
    for (int i = 0; i <= STEPS; ++i) {
        const double u = (double)i / STEPS;
        const Vec2 p = circle_point(u);
        assert_true(fabs(p.x - cos(2 * PI * u)) < 2e-10);
        assert_true(fabs(p.y - sin(2 * PI * u)) < 2e-10);
    }
    for (int quarter = 0; quarter <= 4; ++quarter) {
        const Vec2 p = circle_point(0.25 * quarter);
        assert_true(fabs(p.x) + fabs(p.y) == 1);
    }
}

static void check_angle(double x, double y)
{
    const AnglePair a = two_angles((AnglePair){x, y}, (AnglePair){y, -x});
    assert_true(fabs(a[0] - atan2(y, x)) < 1e-12);
    assert_true(fabs(a[1] - atan2(-x, y)) < 1e-12);
}

static void test_two_angles(void **state)
{
    (void)state;
    enum { STEPS = 100000 };
    for (int i = 0; i < STEPS; ++i) {
        const double angle = 2 * PI * i / STEPS, size = pow(10, i % 21 - 10);
        check_angle(size * cos(angle), size * sin(angle));
    }
    static const double sides[] = {-1, 0, 1};
    for (int i = 0; i < 9; ++i) {
        if (i != 4) {
            check_angle(sides[i % 3], sides[i / 3]);
        }
    }
    const AnglePair none = two_angles((AnglePair){0, 0}, (AnglePair){0, 0});
    assert_true(none[0] == 0 && none[1] == 0);
    const AnglePair west = two_angles((AnglePair){-1, -1}, (AnglePair){0.0, -0.0});
    assert_true(fabs(west[0] - PI) < 1e-12 && fabs(west[1] + PI) < 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_circle_point),
        cmocka_unit_test(test_two_angles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
