#include "render/sampler.h"

#include "base/clones.h"
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

uint32_t sampler_pixel_seed(uint32_t seed, uint32_t pixel_x, uint32_t pixel_y)
{
    return hash_combine(hash_combine(hash_u32(seed ^ 0x5ca1ab1eu), pixel_x), pixel_y);
}

void sampler_start(Sampler *sampler, uint32_t seed, uint32_t pixel_x, uint32_t pixel_y,
                   uint32_t sample)
{
    sampler->seed = sampler_pixel_seed(seed, pixel_x, pixel_y);
    sampler->reversed_index = reverse_bits(sample);
    sampler->place = sampler->places = 0;
    sampler->dimension = 0;
    sampler->pair = 0;
}

void sampler_start_neighbour(Sampler *sampler, uint32_t seed, uint32_t pixel_x, uint32_t pixel_y,
                             uint32_t sample)
{
    // Four bits, reversed and spread.
    static const uint8_t spread[16] = {0x00, 0x80, 0x20, 0xa0, 0x08, 0x88, 0x28, 0xa8,
                                       0x02, 0x82, 0x22, 0xa2, 0x0a, 0x8a, 0x2a, 0xaa};
    sampler_start(sampler, seed, pixel_x / 16, pixel_y / 16, sample);
    sampler->place = spread[pixel_x % 16] | (uint32_t)spread[pixel_y % 16] >> 1;
    sampler->places = 255;
}

// Several numbers at once, which compilers don't find by themselves.
typedef uint32_t Four __attribute__((vector_size(16)));
typedef uint8_t Bytes __attribute__((vector_size(32)));
typedef uint32_t Eight __attribute__((vector_size(32)));
typedef int32_t EightInts __attribute__((vector_size(32)));
typedef float EightFloats __attribute__((vector_size(32)));
#define INLINE static inline __attribute__((always_inline))

INLINE void eight_hash(Eight *out)
{
    Eight x = *out;
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    *out = x ^ (x >> 16);
}

// A permutation in which each bit is flipped or not by a hash of the bits below it: applied to
// bit-reversed numbers, an Owen scramble. Laine and Karras 2011, with the constants of Vegdahl 2021
// ("Building a Better LK Hash"), which leave far less bias than the published ones.
INLINE uint32_t laine_karras(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    return x ^ x * 0x53a22864u;
}

INLINE void eight_laine_karras(Eight *out, const Eight *seeds)
{
    Eight x = *out;
    const Eight seed = *seeds;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    *out = x ^ x * 0x53a22864u;
}

INLINE void eight_reverse_bits(Eight *out)
{
    Eight x = *out;
    const Bytes bytes = (Bytes)x;
    x = (Eight)__builtin_shufflevector(bytes, bytes, 3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14,
                                       13, 12, 19, 18, 17, 16, 23, 22, 21, 20, 27, 26, 25, 24, 31,
                                       30, 29, 28);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    *out = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

// The four dimensions of Sobol's sequence for a reversed index, reversed.
INLINE Four sobol(uint32_t index)
{
    Four x = {0};
    for (int k = 0; k < 8; ++k) {
        const uint32_t nibble = k ? index >> (4 * k - 4) : index << 4; // times the size of a row
        Four row;
        memcpy(&row, (const char *)sobol_nibbles[k] + (nibble & 0xf0), sizeof row);
        x ^= row;
    }
    return x;
}

// What is added for the pixel's place in its patch, reversed. Sets differ in the order of pixels,
// as they do in that of samples.
INLINE Four shift(const Sampler *sampler, uint32_t seed)
{
    const uint32_t key = seed >> 16 | seed << 16; // not that of the samples' order
    const uint32_t place = laine_karras(sampler->place, key) & sampler->places;
    Four low, high;
    memcpy(&low, place_nibbles[0][place & 15], sizeof low);
    memcpy(&high, place_nibbles[1][place >> 4 & 15], sizeof high);
    return low ^ high;
}

VECTOR_CLONES static void fill_pair(Sampler *sampler, uint32_t pair)
{
    const uint32_t a = hash_combine(sampler->seed, 2 * pair);
    const uint32_t b = hash_combine(sampler->seed, 2 * pair + 1);
    const Four first = sobol(laine_karras(sampler->reversed_index, a)) ^ shift(sampler, a);
    const Four second = sobol(laine_karras(sampler->reversed_index, b)) ^ shift(sampler, b);
    Eight x = __builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7);
    const Eight seed = {a, a, a, a, b, b, b, b};
    const Eight dimension = {0x9e3779b9u, 2 * 0x9e3779b9u, 3 * 0x9e3779b9u, 4 * 0x9e3779b9u,
                             0x9e3779b9u, 2 * 0x9e3779b9u, 3 * 0x9e3779b9u, 4 * 0x9e3779b9u};
    Eight scramble = seed + dimension;
    eight_hash(&scramble);
    eight_laine_karras(&x, &scramble);
    eight_reverse_bits(&x);
    // hash_to_float; 24 bits are positive in int, too, from which processors convert at once.
    const EightFloats values = __builtin_convertvector((EightInts)(x >> 8), EightFloats) * 0x1p-24f;
    memcpy(sampler->values, &values, sizeof values);
    sampler->pair = pair + 1;
}

void sampler_fill(Sampler *sampler, uint32_t pair)
{
    fill_pair(sampler, pair);
}

void sampler_seek(Sampler *sampler, uint32_t dimension)
{
    sampler->dimension = (dimension + 3) & ~UINT32_C(3);
}
