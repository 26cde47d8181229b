// Sines, cosines and angles by short series, inline and without branches, which the C library's
// take by ranges that are anybody's guess where directions are chosen by chance. What they give
// doesn't depend on the C library.
#ifndef BASE_ANGLE_H
#define BASE_ANGLE_H

#include "base/vec.h"

typedef double AnglePair __attribute__((vector_size(16)));
typedef long long AngleMask __attribute__((vector_size(16)));

// The point of the unit circle at a part of the way around, (cos 2πu, sin 2πu) for u in [0, 1],
// to 2e-10. Taylor's series for the distance from the nearest axis, at most π/4.
static inline Vec2 circle_point(double u)
{
    const int quarter = (int)(4 * u + 0.5);
    const double angle = 2 * PI * (u - 0.25 * quarter), q = -angle * angle;
    AnglePair series = 1 + q * (AnglePair){1.0 / 110, 1.0 / 90};
    series = 1 + q * (AnglePair){1.0 / 72, 1.0 / 56} * series;
    series = 1 + q * (AnglePair){1.0 / 42, 1.0 / 30} * series;
    series = 1 + q * (AnglePair){1.0 / 20, 1.0 / 12} * series;
    series = 1 + q * (AnglePair){1.0 / 6, 1.0 / 2} * series;
    const AnglePair near = {series[1], angle * series[0]}; // cosine, sine
    const AnglePair across = __builtin_shufflevector(near, near, 1, 0);
    const AngleMask turned = (AngleMask){0, 0} - (quarter & 1);
    // A quarter on, (c, s) is (-s, c); half the way around (-c, -s).
    const AngleMask signs = {(long long)((uint64_t)((quarter + 1) >> 1 & 1) << 63),
                             (long long)((uint64_t)(quarter >> 1 & 1) << 63)};
    const AngleMask xy = (((AngleMask)across & turned) | ((AngleMask)near & ~turned)) ^ signs;
    const AnglePair out = (AnglePair)xy;
    return (Vec2){out[0], out[1]};
}

// The angles of two points (x[i], y[i]), atan2(y[i], x[i]) to 1e-12; that of (0, 0) is 0. The
// smaller coordinate over the larger, turned by π/4 where that is more than tan(π/8); the series'
// coefficients are those of its interpolation at Chebyshev's points there.
static inline AnglePair two_angles(AnglePair x, AnglePair y)
{
    const AngleMask size = {INT64_MAX, INT64_MAX}, sign = ~size;
    const AnglePair ax = (AnglePair)((AngleMask)x & size), ay = (AnglePair)((AngleMask)y & size);
    const AngleMask steep = ay > ax;
    const AnglePair most = (AnglePair)(((AngleMask)ay & steep) | ((AngleMask)ax & ~steep));
    const AnglePair least = (AnglePair)(((AngleMask)ax & steep) | ((AngleMask)ay & ~steep));
    const AngleMask far = least > 0.41421356237309503 * most;
    const AngleMask none = most == 0;
    const AnglePair over = (AnglePair)((AngleMask)(least - (AnglePair)((AngleMask)most & far)));
    const AnglePair under = most + (AnglePair)((AngleMask)least & far) +
                            (AnglePair)((AngleMask)(AnglePair){1, 1} & none);
    const AnglePair t = over / under, q = t * t;
    AnglePair a = 0.06974195213901974 + q * -0.03765507712448715;
    a = -0.089925521412553 + q * a;
    a = 0.1110345679614711 + q * a;
    a = -0.1428538654526753 + q * a;
    a = 0.19999993053237736 + q * a;
    a = -0.3333333327691722 + q * a;
    a = t * (0.9999999999992444 + q * a) +
        (AnglePair)((AngleMask)(AnglePair){PI / 4, PI / 4} & far);
    // From the nearest axis to that of x, to the left half, to the lower one.
    const AnglePair half = {PI / 2, PI / 2}, whole = {PI, PI};
    a = (AnglePair)(((AngleMask)(half - a) & steep) | ((AngleMask)a & ~steep));
    const AngleMask left = x < 0;
    a = (AnglePair)(((AngleMask)(whole - a) & left) | ((AngleMask)a & ~left));
    return (AnglePair)((AngleMask)a | ((AngleMask)y & sign));
}

#endif
