// Rays against a group's few flat pieces, many at a time; see accel_parts.h.
#include "render/accel_sweep.h"
#include "base/hot.h"
#include "base/mem.h"

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
    const SweepWay *ways[4];
    group->way = ways[accel_sweep_ways(ways) - 1];
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

bool accel_sweep_others(const AccelGroup *group, const Ray *ray, SweepOthers *others,
                        uint32_t instance, Hit *hit)
{
    const AccelFlat *flats = group->accel->flats + group->first_flat;
    double tmax = others->best == NONE_ID ? ray->tmax : others->nearest.distance;
    while (others->bits) {
        const uint32_t i = sweep_first(others->bits, others->from);
        others->bits &= ~(UINT32_C(1) << i);
        Meeting met;
        if (meet(&flats[i], ray, tmax, true, &met)) {
            others->nearest = met;
            others->best = i;
            tmax = met.distance;
            const float length = (float)(tmax * others->speed - others->begin);
            others->bits = sweep_within(others->bits, others->from, length);
        }
    }
    if (others->best == NONE_ID) {
        return false;
    }
    complete_hit(&flats[others->best], group->first_flat + others->best, &others->nearest, instance,
                 hit);
    return true;
}

bool accel_sweep_intersect(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                           double begin, double speed, uint32_t instance, Hit *hit)
{
    float from[SWEEP_MOST];
    const uint32_t bits = group->way->kernel(group->sweep, group->sweep_count, local, from);
    return sweep_nearest(group, ray, bits, from, begin, speed, instance, hit);
}

bool accel_sweep_occluded(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                          uint32_t instance)
{
    float from[SWEEP_MOST];
    const uint32_t bits = group->way->kernel(group->sweep, group->sweep_count, local, from);
    return sweep_any(group, ray, bits, instance);
}
