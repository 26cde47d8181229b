#include "base/noise.h"

#include "base/hash.h"

#include <stdint.h>

static double gradient(uint64_t hash, Vec3 d)
{
    unsigned h = hash & 15;
    double u = h < 8 ? d.x : d.y;
    double v = h < 4 ? d.y : h == 12 || h == 14 ? d.x : d.z;
    return (h & 1 ? -u : u) + (h & 2 ? -v : v);
}

static double fade(double t)
{
    return t * t * t * (t * (t * 6 - 15) + 10);
}

static double between(double t, double a, double b)
{
    return a + t * (b - a);
}

// The whole part, and what is left in [0, 1). Beyond 2^53 every double is whole, and the noise 0.
static int64_t split(double x, double *rest)
{
    if (!(fabs(x) < 0x1p62)) {
        *rest = 0;
        return 0;
    }
    const int64_t towards_zero = (int64_t)x;
    const int64_t whole = towards_zero - ((double)towards_zero > x);
    *rest = x - (double)whole;
    return whole;
}

double noise3(Vec3 p)
{
    Vec3 f;
    const int64_t x = split(p.x, &f.x), y = split(p.y, &f.y), z = split(p.z, &f.z);
    // The hash of a corner is that of its coordinates in turn, so corners share what they begin
    // with.
    double corners[8];
    for (int a = 0; a < 2; ++a) {
        const uint64_t hash_x = hash_u64((uint64_t)(x + a));
        for (int b = 0; b < 2; ++b) {
            const uint64_t hash_xy = hash_u64(hash_x ^ (uint64_t)(y + b));
            for (int c = 0; c < 2; ++c) {
                const uint64_t hash = hash_u64(hash_xy ^ (uint64_t)(z + c));
                corners[a + 2 * b + 4 * c] = gradient(hash, sub(f, vec3(a, b, c)));
            }
        }
    }
    double u = fade(f.x), v = fade(f.y), w = fade(f.z);
    return between(
        w, between(v, between(u, corners[0], corners[1]), between(u, corners[2], corners[3])),
        between(v, between(u, corners[4], corners[5]), between(u, corners[6], corners[7])));
}
