#include "render/sampler.h"

#include "base/clones.h"
#include "base/hash.h"
#include "base/hot.h"
#include "render/sobol_tables.h"

#include <stdbool.h>
#include <string.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

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
    sampler->first = sampler->held = 0;
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
typedef uint32_t Sixteen __attribute__((vector_size(64)));
#define INLINE static inline __attribute__((always_inline))

// hash_u32, of a number or a vector of them.
#define HASH(x)                                                                                    \
    ((x) ^= (x) >> 16, (x) *= 0x7feb352du, (x) ^= (x) >> 15, (x) *= 0x846ca68bu, (x) ^= (x) >> 16)

// A permutation in which each bit is flipped or not by a hash of the bits below it: applied to
// bit-reversed numbers, an Owen scramble. Laine and Karras 2011, with the constants of Vegdahl 2021
// ("Building a Better LK Hash"), which leave far less bias than the published ones.
#define LAINE_KARRAS(x, seed)                                                                      \
    ((x) ^= (x)*0x3d20adeau, (x) += (seed), (x) *= ((seed) >> 16) | 1u, (x) ^= (x)*0x05526c56u,    \
     (x) ^= (x)*0x53a22864u)

// What differs between the dimensions of a set in their scrambles.
#define SCRAMBLES 0x9e3779b9u, 2 * 0x9e3779b9u, 3 * 0x9e3779b9u, 4 * 0x9e3779b9u

INLINE uint32_t laine_karras(uint32_t x, uint32_t seed)
{
    LAINE_KARRAS(x, seed);
    return x;
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

// --- Two sets at once ----------------------------------------------------------------------------

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

VECTOR_CLONES static void fill_two(Sampler *sampler, uint32_t dimension)
{
    const uint32_t set = dimension >> 2;
    const uint32_t a = hash_combine(sampler->seed, set);
    const uint32_t b = hash_combine(sampler->seed, set + 1);
    const Four first = sobol(laine_karras(sampler->reversed_index, a)) ^ shift(sampler, a);
    const Four second = sobol(laine_karras(sampler->reversed_index, b)) ^ shift(sampler, b);
    Eight x = __builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7);
    Eight scramble = (Eight){a, a, a, a, b, b, b, b} + (Eight){SCRAMBLES, SCRAMBLES};
    HASH(scramble);
    LAINE_KARRAS(x, scramble);
    eight_reverse_bits(&x);
    // hash_to_float; 24 bits are positive in int, too, from which processors convert at once.
    const EightFloats values = __builtin_convertvector((EightInts)(x >> 8), EightFloats) * 0x1p-24f;
    memcpy(sampler->values, &values, sizeof values);
    sampler->first = 4 * set;
    sampler->held = 8;
}

// --- Eight sets at once, where bits are multiplied by matrices in one instruction ----------------

#if defined(__x86_64__)
#define WIDE __attribute__((target("avx2,avx512f,avx512bw,avx512vl,avx512vbmi,gfni")))

static bool has_wide(void)
{
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512vbmi") &&
           __builtin_cpu_supports("gfni");
}

// Of eight numbers' bytes b, one after another, in each of eight words.
WIDE INLINE __m512i bytes_of(__m256i numbers, int b)
{
    const __m512i places = _mm512_set1_epi64(0x1c1814100c080400 + 0x0101010101010101 * b);
    return _mm512_permutexvar_epi8(places, _mm512_castsi256_si512(numbers));
}

// sobol() ^ shift() of eight reversed indices and places: four sets in each of two vectors.
WIDE INLINE void wide_sobol(__m256i indices, __m256i places, __m512i out[2])
{
    __m512i sums[2]; // byte by byte of dimensions 0 and 1, and of 2 and 3: eight sets in each word
    for (int p = 0; p < 2; ++p) {
        sums[p] = _mm512_setzero_si512();
        for (int b = 0; b < 5; ++b) {
            const __m512i bytes = b < 4 ? bytes_of(indices, b) : bytes_of(places, 0);
            const __m512i matrices = _mm512_loadu_si512(sobol_matrices[p][b]);
            sums[p] = _mm512_xor_si512(sums[p], _mm512_gf2p8affine_epi64_epi8(bytes, matrices, 0));
        }
    }
    // Byte i of dimension d of set s is byte s of word 4 d + i, counted through both sums.
    for (int half = 0; half < 2; ++half) {
        const __m512i first = _mm512_set_epi8(
            123, 115, 107, 99, 91, 83, 75, 67, 59, 51, 43, 35, 27, 19, 11, 3, 122, 114, 106, 98, 90,
            82, 74, 66, 58, 50, 42, 34, 26, 18, 10, 2, 121, 113, 105, 97, 89, 81, 73, 65, 57, 49,
            41, 33, 25, 17, 9, 1, 120, 112, 104, 96, 88, 80, 72, 64, 56, 48, 40, 32, 24, 16, 8, 0);
        const __m512i from = _mm512_add_epi8(first, _mm512_set1_epi8((char)(4 * half)));
        out[half] = _mm512_permutex2var_epi8(sums[0], from, sums[1]);
    }
}

WIDE INLINE __m512i wide_reverse_bits(__m512i x)
{
    const __m512i matrix = _mm512_set1_epi64((long long)0x8040201008040201);
    const __m128i bytes = _mm_set_epi8(12, 13, 14, 15, 8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3);
    return _mm512_shuffle_epi8(_mm512_gf2p8affine_epi64_epi8(x, matrix, 0),
                               _mm512_broadcast_i32x4(bytes));
}

WIDE HOT static void fill_eight(Sampler *sampler, uint32_t dimension)
{
    const uint32_t set = dimension >> 2, seed = sampler->seed;
    const Eight sets = set + (Eight){0, 1, 2, 3, 4, 5, 6, 7};
    Eight seeds = seed ^ (sets + (0x9e3779b9u + (seed << 6) + (seed >> 2))); // hash_combine
    HASH(seeds);
    const Eight keys = seeds >> 16 | seeds << 16;
    Eight indices = sampler->reversed_index + (Eight){0}, places = sampler->place + (Eight){0};
    LAINE_KARRAS(indices, seeds);
    LAINE_KARRAS(places, keys);
    places &= sampler->places;
    __m512i sums[2];
    wide_sobol((__m256i)indices, (__m256i)places, sums);
    for (int half = 0; half < 2; ++half) {
        const __m512i from =
            _mm512_add_epi32(_mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0),
                             _mm512_set1_epi32(4 * half));
        Sixteen x = (Sixteen)sums[half];
        Sixteen scramble =
            (Sixteen)_mm512_permutexvar_epi32(from, _mm512_castsi256_si512((__m256i)seeds)) +
            (Sixteen){SCRAMBLES, SCRAMBLES, SCRAMBLES, SCRAMBLES};
        HASH(scramble);
        LAINE_KARRAS(x, scramble);
        const __m512i bits = _mm512_srli_epi32(wide_reverse_bits((__m512i)x), 8);
        _mm512_storeu_ps(sampler->values + 16 * half,
                         _mm512_mul_ps(_mm512_cvtepi32_ps(bits), _mm512_set1_ps(0x1p-24F)));
    }
    sampler->first = 4 * set;
    sampler->held = SAMPLER_AHEAD;
}
#endif

int sampler_fills(SamplerFill *out[2])
{
    int count = 0;
    out[count++] = fill_two;
#if defined(__x86_64__)
    if (has_wide()) {
        out[count++] = fill_eight;
    }
#endif
    return count;
}

HOT void sampler_fill(Sampler *sampler, uint32_t dimension)
{
#if defined(__x86_64__)
    if (has_wide()) {
        fill_eight(sampler, dimension);
        return;
    }
#endif
    fill_two(sampler, dimension);
}

void sampler_seek(Sampler *sampler, uint32_t dimension)
{
    sampler->dimension = (dimension + 3) & ~UINT32_C(3);
}
