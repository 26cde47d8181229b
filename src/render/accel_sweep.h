// What the sweep does with the pieces that its kernel proposes, inline.
#ifndef RENDER_ACCEL_SWEEP_H
#define RENDER_ACCEL_SWEEP_H

#include "render/accel_local.h"
#include "render/accel_meet.h"

// Of the pieces `bits` all but the one that the ray leaves, which is plane.
static inline uint32_t sweep_without_own(const AccelGroup *group, const Ray *ray, uint32_t instance,
                                         uint32_t bits)
{
    const uint32_t own = ray->ends.flat - 1 - group->first_flat;
    const bool leaves = own < group->sweep_count && ray->ends.instance == instance;
    return leaves ? bits & ~(UINT32_C(1) << own) : bits;
}

// The one of several that may be met first.
static inline uint32_t sweep_first(uint32_t bits, const float *from)
{
    uint32_t first = (uint32_t)__builtin_ctz(bits);
    for (bits &= bits - 1; bits; bits &= bits - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(bits);
        first = from[i] < from[first] ? i : first;
    }
    return first;
}

// Those that may be met no farther than at `length`.
static inline uint32_t sweep_within(uint32_t bits, const float *from, float length)
{
    uint32_t left = 0;
    for (; bits; bits &= bits - 1) {
        left |= from[__builtin_ctz(bits)] > length ? 0 : bits & -bits;
    }
    return left;
}

// A ray's candidates, after the first of them.
typedef struct SweepOthers {
    const float *from;
    uint32_t bits;
    double begin, speed; // of the ray: see sweep_nearest
    uint32_t best;       // the nearest that was met; NONE_ID: none was
    Meeting nearest;
} SweepOthers;

// Goes on with those where the first wasn't met, or where it may not be the nearest.
bool accel_sweep_others(const AccelGroup *group, const Ray *ray, SweepOthers *others,
                        uint32_t instance, Hit *hit);

// The nearest of the pieces that the kernel proposes: `bits`, met at `from` or farther. Lengths are
// counted from `begin` on the ray, where t = 1 is `speed`.
static inline bool sweep_nearest(const AccelGroup *group, const Ray *ray, uint32_t bits,
                                 const float *from, double begin, double speed, uint32_t instance,
                                 Hit *hit)
{
    bits = sweep_without_own(group, ray, instance, bits);
    if (!bits) {
        return false;
    }
    const AccelFlat *flats = group->accel->flats + group->first_flat;
    const uint32_t first = sweep_first(bits, from);
    bits &= ~(UINT32_C(1) << first);
    Meeting met;
    const bool is_met = meet(&flats[first], ray, ray->tmax, true, &met);
    if (is_met) {
        // None of the others comes first if this one's error doesn't let it.
        bits = sweep_within(bits, from, (float)(met.distance * speed - begin));
        if (!bits) {
            complete_hit(&flats[first], group->first_flat + first, &met, instance, hit);
            return true;
        }
    }
    SweepOthers others = {from, bits, begin, speed, is_met ? first : NONE_ID, met};
    return accel_sweep_others(group, ray, &others, instance, hit);
}

// Whether any of them is met.
static inline bool sweep_any(const AccelGroup *group, const Ray *ray, uint32_t bits,
                             uint32_t instance)
{
    const AccelFlat *flats = group->accel->flats + group->first_flat;
    for (bits = sweep_without_own(group, ray, instance, bits); bits; bits &= bits - 1) {
        const AccelFlat *flat = &flats[__builtin_ctz(bits)];
        Meeting met;
        // The way to a point of a lamp ends in its plane.
        const bool target = flat->shape + 1 == ray->ends.target && instance == NONE_ID;
        if (!target && meet(flat, ray, ray->tmax, true, &met)) {
            return true;
        }
    }
    return false;
}

#endif
