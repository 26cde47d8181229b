// Comparing doubles in cmocka, whose own assert_float_equal takes floats.
#ifndef TESTS_NEAR_H
#define TESTS_NEAR_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define assert_near(value, wanted, tolerance)                                                      \
    do {                                                                                           \
        const double near_value = (value), near_wanted = (wanted);                                 \
        if (!(fabs(near_value - near_wanted) <= (tolerance))) {                                    \
            fail_msg("%s is %.17g, not %.17g", #value, near_value, near_wanted);                   \
        }                                                                                          \
    } while (0)

#endif
