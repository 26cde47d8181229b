#include "render/sampler.h"

#include "base/hash.h"
#include "render/sobol_tables.h"

#include <string.h>

static uint32_t reverse_bits(uint32_t x)
{
    x = (x >> 16) | (x << 16);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

// A permutation in which each bit is flipped or not by a hash of the bits below it: applied to
// bit-reversed numbers, an Owen scramble. Laine and Karras 2011, with the constants of Vegdahl 2021
// ("Building a Better LK Hash"), which leave far less bias than the published ones.
static uint32_t laine_karras(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

uint32_t sampler_pixel_seed(uint32_t seed, uint32_t pixel_x, uint32_t pixel_y)
{
    return hash_combine(hash_combine(hash_u32(seed ^ 0x5ca1ab1eu), pixel_x), pixel_y);
}

void sampler_start(Sampler *sampler, uint32_t seed, uint32_t pixel_x, uint32_t pixel_y,
                   uint32_t sample)
{
    sampler->seed = sampler_pixel_seed(seed, pixel_x, pixel_y);
    sampler->reversed_index = reverse_bits(sample);
    sampler->dimension = 0;
    sampler->set = 0;
}

// The same for four numbers at once, which compilers don't find by themselves.
typedef uint32_t Four __attribute__((vector_size(16)));
typedef int32_t FourInts __attribute__((vector_size(16)));
typedef float FourFloats __attribute__((vector_size(16)));

static inline Four four_hash(Four x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

static inline Four four_laine_karras(Four x, Four seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

static inline Four four_reverse_bits(Four x)
{
    x = (x >> 16) | (x << 16);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

void sampler_fill(Sampler *sampler, uint32_t set)
{
    const uint32_t seed = hash_combine(sampler->seed, set);
    const uint32_t index = laine_karras(sampler->reversed_index, seed);
    Four x = {0, 0, 0, 0};
    for (int k = 0; k < 8; ++k) {
        Four row;
        memcpy(&row, sobol_nibbles[k][(index >> (4 * k)) & 15], sizeof row);
        x ^= row;
    }
    const Four dimension = {0x9e3779b9u, 2 * 0x9e3779b9u, 3 * 0x9e3779b9u, 4 * 0x9e3779b9u};
    x = four_reverse_bits(four_laine_karras(x, four_hash(seed + dimension)));
    // hash_to_float; 24 bits are positive in int, too, from which processors convert at once.
    const FourFloats values = __builtin_convertvector((FourInts)(x >> 8), FourFloats) * 0x1p-24f;
    memcpy(sampler->values, &values, sizeof values);
    sampler->set = set + 1;
}

void sampler_seek(Sampler *sampler, uint32_t dimension)
{
    sampler->dimension = (dimension + 3) & ~UINT32_C(3);
}
