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
// *radius: the point's distance from the middle, or that negative.
static inline DiscPair sample_disc_pair(float u, float v, double *radius)
{
    const DiscPair ab = {2 * (double)u - 1, 2 * (double)v - 1};
    const DiscPair ba = __builtin_shufflevector(ab, ab, 1, 0);
    const DiscPair size = (DiscPair)((DiscMask)ab & INT64_MAX);
    const DiscMask wider = size > __builtin_shufflevector(size, size, 1, 0);
    const DiscMask wide = __builtin_shufflevector(wider, wider, 0, 0);
    // The larger of the two is the radius; the other tells the angle from its axis.
    const DiscPair larger_first = (DiscPair)(((DiscMask)ab & wide) | ((DiscMask)ba & ~wide));
    const double r = *radius = larger_first[0];
    const double angle = r != 0 ? PI / 4 * (larger_first[1] / r) : 0;
    const double q = -angle * angle;
    DiscPair series = 1 + q * (DiscPair){1.0 / 110, 1.0 / 90};
    series = 1 + q * (DiscPair){1.0 / 72, 1.0 / 56} * series;
    series = 1 + q * (DiscPair){1.0 / 42, 1.0 / 30} * series;
    series = 1 + q * (DiscPair){1.0 / 20, 1.0 / 12} * series;
    series = 1 + q * (DiscPair){1.0 / 6, 1.0 / 2} * series;
    const DiscPair along = r * (DiscPair){series[1], angle * series[0]}; // cosine, sine
    const DiscPair across = __builtin_shufflevector(along, along, 1, 0);
    return (DiscPair)(((DiscMask)along & wide) | ((DiscMask)across & ~wide));
}

static inline Vec2 sample_disc(float u, float v)
{
    double r;
    const DiscPair xy = sample_disc_pair(u, v, &r);
    return (Vec2){xy[0], xy[1]};
}

// A direction about +z. As it is made: one that is kept for later is stored and read alike, where
// processors would wait if two numbers were stored and both read at once.
typedef struct CosineDirection {
    DiscPair xy;
    double z;
} CosineDirection;

// Of unit length with pdf z/π from (u, v) in [0,1)². The height is that of the radius, which is
// known long before the series are; a step of Newton's method makes good what they lack.
static inline CosineDirection sample_cosine(float u, float v)
{
    double r;
    const DiscPair xy = sample_disc_pair(u, v, &r), squares = xy * xy;
    const double zz = 1 - r * r, z = sqrt(zz);
    const double over = 1.5 - 0.5 * (squares[0] + squares[1] + zz);
    return (CosineDirection){over * xy, over * z};
}

static inline Vec3 cosine_vec3(const CosineDirection *d)
{
    return vec3(d->xy[0], d->xy[1], d->z);
}

static inline Vec3 sample_cosine_hemisphere(float u, float v)
{
    const CosineDirection d = sample_cosine(u, v);
    return cosine_vec3(&d);
}

#endif
