// The sweep, for each kind of processor; see accel_parts.h.
#include "base/hot.h"
#include "render/accel_sweep.h"

#if defined(__x86_64__)
#include <immintrin.h>

// SIGNED(a, b): -a with the sign of b. With lanes of 4, fused operations missing.
#define NAMED(of) of##_sse2
#define TARGET
#define LANES         4
#define V             __m128
#define SET           _mm_set1_ps
#define LOAD          _mm_load_ps
#define STORE         _mm_storeu_ps
#define ADD           _mm_add_ps
#define SUB           _mm_sub_ps
#define MUL           _mm_mul_ps
#define DIV           _mm_div_ps
#define FMA(a, b, c)  _mm_add_ps(_mm_mul_ps(a, b), c)
#define FNMA(a, b, c) _mm_sub_ps(c, _mm_mul_ps(a, b))
#define ABS(a)        _mm_andnot_ps(_mm_set1_ps(-0.0F), a)
#define SIGNED(a, b)  _mm_xor_ps(a, _mm_andnot_ps(b, _mm_set1_ps(-0.0F)))
#define MASK          __m128
#define LESS(a, b)    _mm_cmplt_ps(a, b)
#define OR(a, b)      _mm_or_ps(a, b)
#define BITS(mask)    (uint32_t) _mm_movemask_ps(mask)
#include "render/accel_sweep_way.inc"

#define NAMED(of)    of##_avx2
#define TARGET       __attribute__((target("avx2,fma")))
#define LANES        8
#define V            __m256
#define SET          _mm256_set1_ps
#define LOAD         _mm256_load_ps
#define STORE        _mm256_storeu_ps
#define ADD          _mm256_add_ps
#define SUB          _mm256_sub_ps
#define MUL          _mm256_mul_ps
#define DIV          _mm256_div_ps
#define FMA          _mm256_fmadd_ps
#define FNMA         _mm256_fnmadd_ps
#define ABS(a)       _mm256_andnot_ps(_mm256_set1_ps(-0.0F), a)
#define SIGNED(a, b) _mm256_xor_ps(a, _mm256_andnot_ps(b, _mm256_set1_ps(-0.0F)))
#define MASK         __m256
#define LESS(a, b)   _mm256_cmp_ps(a, b, _CMP_LT_OQ)
#define OR(a, b)     _mm256_or_ps(a, b)
#define BITS(mask)   (uint32_t) _mm256_movemask_ps(mask)
#include "render/accel_sweep_way.inc"

#define NAMED(of) of##_avx512
#define TARGET    __attribute__((target("avx512f")))
#define LANES     16
#define V         __m512
#define SET       _mm512_set1_ps
#define LOAD      _mm512_load_ps
#define STORE     _mm512_storeu_ps
#define ADD       _mm512_add_ps
#define SUB       _mm512_sub_ps
#define MUL       _mm512_mul_ps
#define DIV       _mm512_div_ps
#define FMA       _mm512_fmadd_ps
#define FNMA      _mm512_fnmadd_ps
#define ABS(a)    _mm512_abs_ps(a)
#define SIGNED(a, b)                                                                               \
    _mm512_castsi512_ps(_mm512_ternarylogic_epi32(_mm512_castps_si512(a), _mm512_castps_si512(b),  \
                                                  _mm512_set1_epi32(INT32_MIN), 0xd2))
#define MASK       uint32_t
#define LESS(a, b) (uint32_t) _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ)
#define OR(a, b)   ((a) | (b))
#define BITS(mask) (mask)
#include "render/accel_sweep_way.inc"

int accel_sweep_ways(const SweepWay *out[4])
{
    int count = 0;
    out[count++] = &way_sse2;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        out[count++] = &way_avx2;
    }
    if (__builtin_cpu_supports("avx512f")) {
        out[count++] = &way_avx512;
    }
    return count;
}

#else

#include <math.h>

#define NAMED(of) of##_plain
#define TARGET
#define LANES         1
#define V             float
#define SET(a)        (a)
#define LOAD(p)       (*(p))
#define STORE(p, a)   (*(p) = (a))
#define ADD(a, b)     ((a) + (b))
#define SUB(a, b)     ((a) - (b))
#define MUL(a, b)     ((a) * (b))
#define DIV(a, b)     ((a) / (b))
#define FMA(a, b, c)  ((a) * (b) + (c))
#define FNMA(a, b, c) ((c) - (a) * (b))
#define ABS(a)        fabsf(a)
#define SIGNED(a, b)  (signbit(b) ? (a) : -(a))
#define MASK          uint32_t
#define LESS(a, b)    (uint32_t)((a) < (b))
#define OR(a, b)      ((a) | (b))
#define BITS(mask)    (mask)
#include "render/accel_sweep_way.inc"

int accel_sweep_ways(const SweepWay *out[4])
{
    out[0] = &way_plain;
    return 1;
}

#endif
