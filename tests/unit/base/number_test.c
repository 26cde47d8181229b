#include "../test_support.h"
#include "base/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *parse(const char *text, double *value)
{
    // Exactly as many bytes as the text has, so that reading on is found.
    size_t length = strlen(text);
    char *copy = malloc(length ? length : 1);
    memcpy(copy, text, length);
    const char *end = number_parse(copy, copy + length, value);
    const char *result = end ? text + (end - copy) : NULL;
    free(copy);
    return result;
}

static void same_as_the_c_library(void **state)
{
    (void)state;
    static const char *const numbers[] = {
        "0",
        "-0",
        "1",
        "+1",
        "-17",
        "1.5",
        ".5",
        "5.",
        "1e3",
        "1E-3",
        "1e+22",
        "1e23",
        "9007199254740993",
        "123456789012345678901234567890",
        "0.1",
        "0.30000000000000004",
        "2.2250738585072011e-308",
        "4.9e-324",
        "1e-400",
        "1e400",
        "-1e400",
        "1.7976931348623157e308",
        "1e99999999999999999999",
        "0.000000000000000000000000000000000000012345678901234567890123456789",
        "179769313486231580793728971405301e276",
        "8.41e21",
        "9.5367431640625e-7",
    };
    for (size_t i = 0; i < TEST_COUNT(numbers); ++i) {
        double got = NAN, wanted = strtod(numbers[i], NULL);
        const char *end = parse(numbers[i], &got);
        assert_non_null(end);
        assert_int_equal(*end, '\0');
        assert_memory_equal(&got, &wanted, sizeof got);
    }
    unsigned long long bits = 88172645463325252u;
    for (int i = 0; i < 200000; ++i) {
        bits ^= bits << 13, bits ^= bits >> 7, bits ^= bits << 17;
        double wanted, got = NAN;
        memcpy(&wanted, &bits, sizeof wanted);
        if (!isfinite(wanted)) {
            continue;
        }
        char text[64];
        snprintf(text, sizeof text, "%.*g", 1 + i % 20, wanted);
        wanted = strtod(text, NULL);
        assert_non_null(parse(text, &got));
        assert_memory_equal(&got, &wanted, sizeof got);
        snprintf(text, sizeof text, "%.*f", i % 12, (double)(int)(bits % 2000000) / 1000 - 1000);
        wanted = strtod(text, NULL);
        assert_non_null(parse(text, &got));
        assert_memory_equal(&got, &wanted, sizeof got);
    }
}

static void stops_where_the_number_stops(void **state)
{
    (void)state;
    static const char *const texts[][2] = {
        {"1e", "e"},   {"1e+", "e+"},   {"2em", "em"}, {"1.5.5", ".5"}, {"1-2", "-2"},
        {"3 4", " 4"}, {"0x10", "x10"}, {"1,5", ",5"}, {"1..2", ".2"},
    };
    for (size_t i = 0; i < TEST_COUNT(texts); ++i) {
        double value;
        const char *end = parse(texts[i][0], &value);
        assert_non_null(end);
        assert_string_equal(end, texts[i][1]);
    }
    static const char *const none[] = {"", "-", "+", ".", "-.", "e5", "nan", "inf", " 1", "--1"};
    for (size_t i = 0; i < TEST_COUNT(none); ++i) {
        double value;
        assert_null(parse(none[i], &value));
    }
}

static void long_numbers_are_exact(void **state)
{
    (void)state;
    char text[5000];
    memset(text, '3', sizeof text);
    text[1] = '.';
    text[sizeof text - 1] = '\0';
    double got = 0, wanted = strtod(text, NULL);
    assert_non_null(parse(text, &got));
    assert_true(got == wanted);
    memset(text, '0', sizeof text - 1);
    text[sizeof text - 2] = '7';
    assert_non_null(parse(text, &got));
    assert_true(got == 7);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_as_the_c_library),
        cmocka_unit_test(stops_where_the_number_stops),
        cmocka_unit_test(long_numbers_are_exact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
