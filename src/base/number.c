#include "base/number.h"

#include "base/mem.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// What the text says: significand * 10^exponent, exact as long as `digits` is at most 19.
typedef struct Decimal {
    uint64_t significand;
    int64_t exponent;
    int digits; // significant ones, leading zeros not counted
    bool any;   // at least one digit was there
} Decimal;

static const char *read_digits(const char *at, const char *end, Decimal *decimal, int step)
{
    for (; at < end && *at >= '0' && *at <= '9'; ++at) {
        decimal->any = true;
        decimal->exponent += step;
        if (decimal->digits < 19) {
            decimal->significand = decimal->significand * 10 + (uint64_t)(*at - '0');
        }
        decimal->digits += (decimal->digits || *at != '0') && decimal->digits < 1000;
    }
    return at;
}

// The exponent part; what isn't one is left alone ("2em" is a 2 and "em").
static const char *read_exponent(const char *at, const char *end, Decimal *decimal)
{
    const char *digit = at + 1;
    if (at >= end || (*at != 'e' && *at != 'E')) {
        return at;
    }
    bool negative = digit < end && *digit == '-';
    digit += digit < end && (*digit == '-' || *digit == '+');
    if (digit >= end || *digit < '0' || *digit > '9') {
        return at;
    }
    int64_t exponent = 0;
    for (; digit < end && *digit >= '0' && *digit <= '9'; ++digit) {
        exponent = exponent < 1000000 ? exponent * 10 + (*digit - '0') : exponent;
    }
    decimal->exponent += negative ? -exponent : exponent;
    return digit;
}

// The C library's exact conversion, for the few numbers that need it. It reads the locale's decimal
// point, which nobody in this program sets.
static bool convert_slowly(const char *begin, const char *end, double *value)
{
    char small[128];
    size_t length = (size_t)(end - begin);
    char *text = length < sizeof small ? small : mem_alloc(length + 1, 1);
    if (!text) {
        return false;
    }
    memcpy(text, begin, length);
    text[length] = '\0';
    *value = strtod(text, NULL);
    if (text != small) {
        mem_free(text);
    }
    return true;
}

const char *number_parse(const char *at, const char *end, double *value)
{
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                    1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                    1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const char *begin = at;
    Decimal decimal = {0};
    bool negative = at < end && *at == '-';
    at += at < end && (*at == '-' || *at == '+');
    at = read_digits(at, end, &decimal, 0);
    if (at < end && *at == '.') {
        const char *after = read_digits(at + 1, end, &decimal, -1);
        at = decimal.any ? after : at;
    }
    if (!decimal.any) {
        return NULL;
    }
    at = read_exponent(at, end, &decimal);
    // Clinger's fast path: both factors are exact doubles, so that one rounding is all there is.
    if (decimal.digits <= 19 && decimal.significand <= (uint64_t)1 << 53 &&
        decimal.exponent >= -22 && decimal.exponent <= 22) {
        double exact = (double)decimal.significand;
        exact = decimal.exponent < 0 ? exact / powers[-decimal.exponent]
                                     : exact * powers[decimal.exponent];
        *value = negative ? -exact : exact;
        return at;
    }
    return convert_slowly(begin, at, value) ? at : NULL;
}
