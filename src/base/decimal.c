#include "base/decimal.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool from_doubles(uint64_t mantissa, int exponent, double *out)
{
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                    1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                    1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    if (FLT_EVAL_METHOD != 0 || mantissa > (uint64_t)1 << 53 || exponent < -22 || exponent > 22) {
        return false;
    }
    // Both factors are exact, so the one operation rounds once.
    *out =
        exponent < 0 ? (double)mantissa / powers[-exponent] : (double)mantissa * powers[exponent];
    return true;
}

// With the x87's 64-bit significand any uint64_t and 10^27 are exact too. The result is rounded
// twice, to 64 bits and then to 53, which matters only where the first rounding may have made or
// unmade a tie: where the 11 bits below are 10000000000 (or within one of it).
static bool from_long_doubles(uint64_t mantissa, int exponent, double *out)
{
#if LDBL_MANT_DIG == 64 && defined __x86_64__
    static const long double powers[] = {1e0L,  1e1L,  1e2L,  1e3L,  1e4L,  1e5L,  1e6L,
                                         1e7L,  1e8L,  1e9L,  1e10L, 1e11L, 1e12L, 1e13L,
                                         1e14L, 1e15L, 1e16L, 1e17L, 1e18L, 1e19L, 1e20L,
                                         1e21L, 1e22L, 1e23L, 1e24L, 1e25L, 1e26L, 1e27L};
    if (exponent < -27 || exponent > 27) {
        return false;
    }
    long double value = exponent < 0 ? (long double)mantissa / powers[-exponent]
                                     : (long double)mantissa * powers[exponent];
    uint64_t significand;
    memcpy(&significand, &value, sizeof significand);
    uint64_t below = significand & 0x7ff;
    if (below >= 0x3ff && below <= 0x401) {
        return false;
    }
    *out = (double)value;
    return true;
#else
    (void)mantissa, (void)exponent, (void)out;
    return false;
#endif
}

bool decimal_from_parts(uint64_t mantissa, int exponent, double *out)
{
    return from_doubles(mantissa, exponent, out) || from_long_doubles(mantissa, exponent, out);
}

double decimal_read(const char *text, const char *end)
{
    // 768 significant digits decide every double; a digit that stands for all further ones settles
    // ties.
    enum { KEPT = 780 };
    char copy[KEPT + 32];
    int count = 0;
    long long exponent = 0;
    bool after_point = false, more = false;
    const char *at = text;
    for (; at < end && *at != 'e' && *at != 'E'; ++at) {
        if (*at == '.') {
            after_point = true;
        } else if (*at != '_' && (count > 0 || *at != '0')) {
            if (count < KEPT) {
                copy[count++] = *at;
                exponent -= after_point;
            } else {
                more = more || *at != '0';
                exponent += !after_point;
            }
        } else if (*at == '0') {
            exponent -= after_point;
        }
    }
    if (count == 0) {
        return 0;
    }
    if (more) {
        copy[count++] = '1';
        --exponent;
    }
    if (at < end) {
        bool negative = at + 1 < end && at[1] == '-';
        long long written = 0;
        for (++at; at < end; ++at) {
            if (*at >= '0' && *at <= '9' && written < 100000000000) {
                written = written * 10 + (*at - '0');
            }
        }
        exponent += negative ? -written : written;
    }
    if (exponent > 1000) {
        return INFINITY; // count >= 1 and the first digit isn't 0
    }
    if (exponent < -3000) {
        return 0;
    }
    snprintf(copy + count, sizeof copy - (size_t)count, "e%lld", exponent);
    locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0); // glibc's is static: can't fail
    double value = strtod_l(copy, NULL, c_locale);
    freelocale(c_locale);
    return value;
}
