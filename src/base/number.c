#include "base/number.h"

#include "base/decimal.h"

#include <stddef.h>

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

const char *number_parse(const char *at, const char *end, double *value)
{
    Decimal decimal = {0};
    bool negative = at < end && *at == '-';
    at += at < end && (*at == '-' || *at == '+');
    const char *begin = at;
    at = read_digits(at, end, &decimal, 0);
    if (at < end && *at == '.') {
        const char *after = read_digits(at + 1, end, &decimal, -1);
        at = decimal.any ? after : at;
    }
    if (!decimal.any) {
        return NULL;
    }
    at = read_exponent(at, end, &decimal);
    const bool small = decimal.exponent > -400 && decimal.exponent < 400;
    double magnitude;
    if (decimal.digits > 19 || !small ||
        !decimal_from_parts(decimal.significand, (int)decimal.exponent, &magnitude)) {
        magnitude = decimal_read(begin, at);
    }
    *value = negative ? -magnitude : magnitude;
    return at;
}
