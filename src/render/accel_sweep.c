// Rays against a group's few flat pieces, many at a time; see accel_parts.h.
#include "base/hot.h"
#include "base/mem.h"
#include "render/accel_local.h"
#include "render/accel_meet.h"

// --- Making --------------------------------------------------------------------------------------

// A linear function of the point, gradient · (p - corner), in the group's coordinates.
static void put_function(float to[4][SWEEP_BLOCK], uint32_t lane, const AccelGroup *group,
                         Vec3 gradient, Vec3 corner)
{
    const Vec3 from = scale(sub(corner, group->center), group->inverse_scale);
    to[0][lane] = (float)gradient.x;
    to[1][lane] = (float)gradient.y;
    to[2][lane] = (float)gradient.z;
    to[3][lane] = (float)-dot(gradient, from);
}

bool accel_make_sweep(AccelGroup *group)
{
    const uint32_t count = group->sweep_count, blocks = (count + SWEEP_BLOCK - 1) / SWEEP_BLOCK;
    if (count == 0) {
        return true;
    }
    const size_t alignment = 64;
    group->sweep_memory = mem_alloc_zeroed(blocks * sizeof(SweepBlock) + alignment, 1);
    if (!group->sweep_memory) {
        return false;
    }
    const uintptr_t address = (uintptr_t)group->sweep_memory + alignment - 1;
    group->sweep = (SweepBlock *)(address - address % alignment);
    group->kernel = sweep_kernel_best();
    for (uint32_t i = 0; i < count; ++i) {
        const AccelFlat *flat = &group->accel->flats[group->first_flat + i];
        SweepBlock *block = &group->sweep[i / SWEEP_BLOCK];
        const uint32_t lane = i % SWEEP_BLOCK;
        const double size = group->scale;
        put_function(block->plane, lane, group, flat->normal, flat->corner);
        put_function(block->s, lane, group, scale(flat->along_u, size), flat->corner);
        put_function(block->t, lane, group, scale(flat->along_v, size), flat->corner);
        block->over_s[lane] = (float)flat->over_s;
        block->over_t[lane] = (float)flat->over_t;
        block->steep[lane] = (float)(flat->steep * size);
    }
    return true;
}

// --- Sweeping ------------------------------------------------------------------------------------

// The pieces that the ray may meet, but for the one that it leaves, which is plane.
static inline uint32_t candidates(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                                  uint32_t instance, float *from)
{
    const uint32_t bits = group->kernel(group->sweep, group->sweep_count, local, from);
    const uint32_t own = ray->ends.flat - 1 - group->first_flat;
    const bool leaves = own < group->sweep_count && ray->ends.instance == instance;
    return leaves ? bits & ~(UINT32_C(1) << own) : bits;
}

// The one of several that may be met first.
static uint32_t first_of(uint32_t bits, const float *from)
{
    uint32_t first = (uint32_t)__builtin_ctz(bits);
    for (bits &= bits - 1; bits; bits &= bits - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(bits);
        first = from[i] < from[first] ? i : first;
    }
    return first;
}

// Those that may be met no farther than at `length`.
static inline uint32_t within(uint32_t bits, const float *from, float length)
{
    uint32_t left = 0;
    for (; bits; bits &= bits - 1) {
        left |= from[__builtin_ctz(bits)] > length ? 0 : bits & -bits;
    }
    return left;
}

// A ray's candidates, after the first of them.
typedef struct Others {
    const float *from;
    uint32_t bits;
    double begin, speed; // of the ray: see accel_sweep_intersect
    uint32_t best;       // the nearest that was met; NONE_ID: none was
    Meeting nearest;
} Others;

// Goes on with those where the first wasn't met, or where it may not be the nearest.
APART static bool intersect_others(const AccelGroup *group, const Ray *ray, Others *others,
                                   uint32_t instance, Hit *hit)
{
    const AccelFlat *flats = group->accel->flats + group->first_flat;
    double tmax = others->best == NONE_ID ? ray->tmax : others->nearest.distance;
    while (others->bits) {
        const uint32_t i = first_of(others->bits, others->from);
        others->bits &= ~(UINT32_C(1) << i);
        Meeting met;
        if (meet(&flats[i], ray, tmax, true, &met)) {
            others->nearest = met;
            others->best = i;
            tmax = met.distance;
            const float length = (float)(tmax * others->speed - others->begin);
            others->bits = within(others->bits, others->from, length);
        }
    }
    if (others->best == NONE_ID) {
        return false;
    }
    complete_hit(&flats[others->best], group->first_flat + others->best, &others->nearest, instance,
                 hit);
    return true;
}

static inline bool intersect(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                             double begin, double speed, uint32_t instance, Hit *hit)
{
    float from[SWEEP_MOST];
    uint32_t bits = candidates(group, ray, local, instance, from);
    if (!bits) {
        return false;
    }
    const AccelFlat *flats = group->accel->flats + group->first_flat;
    const uint32_t first = first_of(bits, from);
    bits &= ~(UINT32_C(1) << first);
    Meeting met;
    const bool is_met = meet(&flats[first], ray, ray->tmax, true, &met);
    if (is_met) {
        // None of the others comes first if this one's error doesn't let it.
        bits = within(bits, from, (float)(met.distance * speed - begin));
        if (!bits) {
            complete_hit(&flats[first], group->first_flat + first, &met, instance, hit);
            return true;
        }
    }
    Others others = {from, bits, begin, speed, is_met ? first : NONE_ID, met};
    return intersect_others(group, ray, &others, instance, hit);
}

static inline bool occluded(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                            uint32_t instance)
{
    float from[SWEEP_MOST];
    const AccelFlat *flats = group->accel->flats + group->first_flat;
    for (uint32_t bits = candidates(group, ray, local, instance, from); bits; bits &= bits - 1) {
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

bool accel_sweep_intersect(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                           double begin, double speed, uint32_t instance, Hit *hit)
{
    return intersect(group, ray, local, begin, speed, instance, hit);
}

bool accel_sweep_occluded(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                          uint32_t instance)
{
    return occluded(group, ray, local, instance);
}

HOT bool accel_swept_intersect(const AccelGroup *group, const Ray *ray, uint32_t instance, Hit *hit)
{
    LocalRay local;
    if (!group->sweep_count || !local_ray(group, ray, instance, &local)) {
        return false;
    }
    const SweepRay swept = sweep_ray(&local);
    return intersect(group, ray, &swept, local.begin, local.speed, instance, hit);
}

HOT bool accel_swept_occluded(const AccelGroup *group, const Ray *ray, uint32_t instance)
{
    LocalRay local;
    if (!group->sweep_count || !local_ray(group, ray, instance, &local)) {
        return false;
    }
    const SweepRay swept = sweep_ray(&local);
    return occluded(group, ray, &swept, instance);
}
