// Integer hashes for sampling: small, fast, well mixed; not for security.
#ifndef BASE_HASH_H
#define BASE_HASH_H

#include <stdint.h>

// The finalizer "lowbias32" by Chris Wellons; bijective.
static inline uint32_t hash_u32(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

static inline uint32_t hash_combine(uint32_t seed, uint32_t value)
{
    return hash_u32(seed ^ (value + 0x9e3779b9u + (seed << 6) + (seed >> 2)));
}

// SplitMix64's finalizer (Steele, Lea, Flood 2014); bijective.
static inline uint64_t hash_u64(uint64_t x)
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

// [0, 1) from the top 24 bits.
static inline float hash_to_float(uint32_t x)
{
    return (float)(x >> 8) * 0x1p-24f;
}

#endif
