// Decimal text to doubles, against the C library's strtod.
#include "base/decimal.h"

#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t next(uint64_t *state)
{
    uint64_t x = *state += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static void check_parts(uint64_t mantissa, int exponent, size_t *exact)
{
    char text[64];
    snprintf(text, sizeof text, "%" PRIu64 "e%d", mantissa, exponent);
    double value, expected = strtod(text, NULL);
    if (decimal_from_parts(mantissa, exponent, &value)) {
        ++*exact;
        if (memcmp(&value, &expected, sizeof value) != 0) {
            fail_msg("%s: %.17g, not %.17g", text, value, expected);
        }
    }
    double read = decimal_read(text, text + strlen(text));
    if (memcmp(&read, &expected, sizeof read) != 0) {
        fail_msg("%s read: %.17g, not %.17g", text, read, expected);
    }
}

static void random_parts(void **state)
{
    (void)state;
    uint64_t seed = 7;
    size_t exact = 0;
    enum { COUNT = 200000 };
    for (int i = 0; i < COUNT; ++i) {
        uint64_t bits = next(&seed);
        check_parts(next(&seed) >> (bits & 63), (int)(bits >> 8) % 30, &exact);
    }
    assert_true(exact > COUNT * 9 / 10);
}

// Around ties, where rounding twice would show: m * 10^e with the bits below the 53rd at a half.
static void near_ties(void **state)
{
    (void)state;
    uint64_t seed = 9;
    size_t exact = 0;
    for (int i = 0; i < 100000; ++i) {
        uint64_t half = (next(&seed) >> 11 << 11) | 0x8000000000000400u;
        check_parts(half + next(&seed) % 5 - 2, 0, &exact);
        check_parts(half + next(&seed) % 5 - 2, -(int)(next(&seed) % 23), &exact);
        check_parts(half + next(&seed) % 5 - 2, (int)(next(&seed) % 23), &exact);
    }
}

static void printed_doubles_come_back(void **state)
{
    (void)state;
    uint64_t seed = 11;
    for (int i = 0; i < 100000; ++i) {
        uint64_t bits = next(&seed) & INT64_MAX;
        double value;
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value)) {
            continue;
        }
        char text[64];
        snprintf(text, sizeof text, "%.17g", value);
        double read = decimal_read(text, text + strlen(text));
        assert_memory_equal(&read, &value, sizeof value);
    }
}

static void hard_texts(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "0",
        "0.000",
        "00001",
        "1e308",
        "1.7976931348623157e308",
        "1.7976931348623159e308",
        "1e309",
        "4.9e-324",
        "2.4703282292062327e-324",
        "2.4703282292062328e-324",
        "2.2250738585072011e-308",
        "9007199254740993",
        "9007199254740992.99999999999999999999",
        "0.1e1000000000000",
        "1e-99999999999999999999",
        "123456789012345678901234567890e-10",
        "0.000000000000000000000000000000000000000000000000000001",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        double read = decimal_read(texts[i], texts[i] + strlen(texts[i]));
        double expected = strtod(texts[i], NULL);
        assert_memory_equal(&read, &expected, sizeof read);
    }
    const char *split = "1_000.000_5";
    assert_true(decimal_read(split, split + strlen(split)) == 1000.0005);
}

// A tie that only a digit far behind breaks, in either direction.
static void digits_without_end(void **state)
{
    (void)state;
    enum { ZEROS = 5000 };
    char text[ZEROS + 64];
    int length = snprintf(text, sizeof text, "9007199254740993.");
    memset(text + length, '0', ZEROS);
    text[length + ZEROS] = '\0';
    assert_true(decimal_read(text, text + length + ZEROS) == 9007199254740992.0);
    text[length + ZEROS - 1] = '1';
    assert_true(decimal_read(text, text + length + ZEROS) == 9007199254740994.0);
    memset(text, '9', ZEROS);
    memcpy(text + ZEROS, "e-5000", 7);
    assert_true(decimal_read(text, text + ZEROS + 6) == 1.0);
    memset(text, '0', ZEROS);
    memcpy(text, "0.", 2);
    memcpy(text + ZEROS, "15e5000", 8);
    assert_true(decimal_read(text, text + ZEROS + 7) == 15.0 * 1.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_parts),       cmocka_unit_test(near_ties),
        cmocka_unit_test(hard_texts),         cmocka_unit_test(printed_doubles_come_back),
        cmocka_unit_test(digits_without_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
