// Points of the unit disc and cosine-weighted directions, inline: each path takes one at every
// surface.
#ifndef RENDER_DISC_H
#define RENDER_DISC_H

#include "base/vec.h"

typedef double DiscPair __attribute__((vector_size(16)));
typedef long long DiscMask __attribute__((vector_size(16)));

// A point of the unit disc from (u, v) in [0,1)², uniform by area, neighbours kept (Shirley and
// Chiu 1997: concentric). Without branches, which half of all paths would take one way; the sine
// and the cosine of an angle of at most π/4 are short series side by side, good to 2e-10, so that
// directions don't depend on the C library.
static inline Vec2 sample_disc(float u, float v)
{
    const DiscPair ab = {2 * (double)u - 1, 2 * (double)v - 1};
    const DiscPair ba = __builtin_shufflevector(ab, ab, 1, 0);
    const DiscPair size = (DiscPair)((DiscMask)ab & INT64_MAX);
    const DiscMask wider = size > __builtin_shufflevector(size, size, 1, 0);
    const DiscMask wide = __builtin_shufflevector(wider, wider, 0, 0);
    // The larger of the two is the radius; the other tells the angle from its axis.
    const DiscPair larger_first = (DiscPair)(((DiscMask)ab & wide) | ((DiscMask)ba & ~wide));
    const double r = larger_first[0];
    const double angle = r != 0 ? PI / 4 * (larger_first[1] / r) : 0;
    const double q = -angle * angle;
    DiscPair series = 1 + q * (DiscPair){1.0 / 110, 1.0 / 90};
    series = 1 + q * (DiscPair){1.0 / 72, 1.0 / 56} * series;
    series = 1 + q * (DiscPair){1.0 / 42, 1.0 / 30} * series;
    series = 1 + q * (DiscPair){1.0 / 20, 1.0 / 12} * series;
    series = 1 + q * (DiscPair){1.0 / 6, 1.0 / 2} * series;
    const DiscPair along = r * (DiscPair){series[1], angle * series[0]}; // cosine, sine
    const DiscPair across = __builtin_shufflevector(along, along, 1, 0);
    const DiscPair xy = (DiscPair)(((DiscMask)along & wide) | ((DiscMask)across & ~wide));
    return (Vec2){xy[0], xy[1]};
}

// A direction about +z with pdf z/π from (u, v) in [0,1)², of unit length to 2e-10. Its height is
// that of the radius, which is known long before the series are.
static inline Vec3 sample_cosine_hemisphere(float u, float v)
{
    const double r = larger(fabs(2 * (double)u - 1), fabs(2 * (double)v - 1));
    const Vec2 d = sample_disc(u, v);
    return vec3(d.x, d.y, sqrt(1 - r * r));
}

#endif
