#include "base/noise.h"

#include "base/hash.h"

#include <stdint.h>

static uint64_t corner_hash(int64_t x, int64_t y, int64_t z)
{
    return hash_u64(hash_u64(hash_u64((uint64_t)x) ^ (uint64_t)y) ^ (uint64_t)z);
}

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

// The whole part, kept where it fits 64 bits; beyond 2^53 every double is whole, and the noise 0.
static int64_t whole(double x)
{
    return fabs(x) < 0x1p62 ? (int64_t)floor(x) : 0;
}

double noise3(Vec3 p)
{
    int64_t x = whole(p.x), y = whole(p.y), z = whole(p.z);
    Vec3 f = vec3(p.x - floor(p.x), p.y - floor(p.y), p.z - floor(p.z));
    double corners[8];
    for (int i = 0; i < 8; ++i) {
        int a = i & 1, b = i >> 1 & 1, c = i >> 2;
        corners[i] = gradient(corner_hash(x + a, y + b, z + c), sub(f, vec3(a, b, c)));
    }
    double u = fade(f.x), v = fade(f.y), w = fade(f.z);
    return between(
        w, between(v, between(u, corners[0], corners[1]), between(u, corners[2], corners[3])),
        between(v, between(u, corners[4], corners[5]), between(u, corners[6], corners[7])));
}
