// The sweep's inner loop: a ray against so many flat pieces at once as the processor has lanes. It
// only proposes, so that kernels may differ in their roundings without any hit being another one.
#ifndef RENDER_SWEEP_KERNEL_H
#define RENDER_SWEEP_KERNEL_H

#include <stdint.h>

// So many pieces of a group are swept if it has no more.
enum { SWEEP_MOST = 32, SWEEP_BLOCK = 16 };

// A bound on the rounding errors of single precision, as a length and in parts of the group's size,
// for rays that meet a piece head-on: they grow with the inverse of the cosine.
#define SWEEP_ERROR 0x1p-18

// Pieces, in the group's coordinates: the plane, s and t as linear functions of the point, and the
// rest of AccelFlat's numbers. Aligned to 64 bytes.
typedef struct SweepBlock {
    float plane[4][SWEEP_BLOCK], s[4][SWEEP_BLOCK], t[4][SWEEP_BLOCK];
    float over_s[SWEEP_BLOCK], over_t[SWEEP_BLOCK], steep[SWEEP_BLOCK];
} SweepBlock;

// A ray in a group's coordinates, its direction of unit length; |origin| <= 2.
typedef struct SweepRay {
    float origin[3], direction[3];
    float end;
} SweepRay;

// A bit for each of the `count` pieces that the ray may meet between 0 and its end, and in `from`
// the least length at which it may meet each of these.
typedef uint32_t SweepKernel(const SweepBlock *blocks, uint32_t count, const SweepRay *ray,
                             float from[SWEEP_MOST]);

#endif
