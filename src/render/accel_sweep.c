// Rays against a group's few flat pieces, eight at a time; see accel_parts.h.
#include "base/clones.h"
#include "base/mem.h"
#include "render/accel_parts.h"

#include <string.h>

enum { LANES = 8, MOST_BLOCKS = SWEEP_MOST / LANES };

// --- Making --------------------------------------------------------------------------------------

static void put(SweepFloats *to, uint32_t lane, double value)
{
    float lanes[LANES];
    memcpy(lanes, to, sizeof lanes);
    lanes[lane] = (float)value;
    memcpy(to, lanes, sizeof lanes);
}

// A linear function of the point, gradient · (p - corner), in the group's coordinates.
static void put_function(SweepFloats *to, uint32_t lane, const AccelGroup *group, Vec3 gradient,
                         Vec3 corner)
{
    put(&to[0], lane, gradient.x);
    put(&to[1], lane, gradient.y);
    put(&to[2], lane, gradient.z);
    put(&to[3], lane, -dot(gradient, scale(sub(corner, group->center), group->inverse_scale)));
}

bool accel_make_sweep(AccelGroup *group)
{
    const uint32_t count = group->sweep_count, blocks = (count + LANES - 1) / LANES;
    if (count == 0) {
        return true;
    }
    group->sweep = mem_alloc_zeroed(blocks, sizeof *group->sweep);
    for (uint32_t i = 0; group->sweep && i < count; ++i) {
        const AccelFlat *flat = &group->accel->flats[group->first_flat + i];
        SweepBlock *block = &group->sweep[i / LANES];
        const uint32_t lane = i % LANES;
        const double size = group->scale;
        put_function(block->plane, lane, group, flat->normal, flat->corner);
        put_function(block->s, lane, group, scale(flat->along_u, size), flat->corner);
        put_function(block->t, lane, group, scale(flat->along_v, size), flat->corner);
        put(&block->over_s, lane, flat->over_s);
        put(&block->over_t, lane, flat->over_t);
        put(&block->steep, lane, flat->steep * size);
    }
    return group->sweep != NULL;
}

// --- Sweeping ------------------------------------------------------------------------------------

typedef int32_t SweepInts __attribute__((vector_size(32)));

// What may be hit: a bit for each piece, and where.
typedef struct Candidates {
    uint32_t bits;
    SweepFloats t[MOST_BLOCKS];
} Candidates;

// One bit for each lane of a mask that is all ones.
static inline __attribute__((always_inline)) uint32_t gather_bits(const SweepInts *mask)
{
    int64_t parts[4];
    const SweepInts bits = *mask & (SweepInts){1, 2, 4, 8, 16, 32, 64, 128};
    memcpy(parts, &bits, sizeof parts);
    const int64_t all = (parts[0] | parts[1]) | (parts[2] | parts[3]);
    return (uint32_t)(all | all >> 32) & 255;
}

#define LINEAR(f, x, y, z) ((f)[0] * (x) + (f)[1] * (y) + (f)[2] * (z) + (f)[3])

// Comparisons are such that what isn't a number, where a ray is parallel to a plane, may be hit.
VECTOR_CLONES static void find_candidates(const SweepBlock *blocks, uint32_t count,
                                          const SweepRay *ray, Candidates *out)
{
    const float ox = ray->origin[0], oy = ray->origin[1], oz = ray->origin[2];
    const float dx = ray->direction[0], dy = ray->direction[1], dz = ray->direction[2];
    out->bits = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const SweepBlock *b = &blocks[i];
        const SweepFloats speed = b->plane[0] * dx + b->plane[1] * dy + b->plane[2] * dz;
        const SweepFloats inverse = 1 / speed, t = -LINEAR(b->plane, ox, oy, oz) * inverse;
        const SweepFloats size = (SweepFloats)((SweepInts)inverse & INT32_MAX);
        const SweepFloats error = size * (float)SWEEP_ERROR, limit = -(b->steep * error);
        const SweepFloats x = ox + t * dx, y = oy + t * dy, z = oz + t * dz;
        const SweepFloats s = LINEAR(b->s, x, y, z), r = LINEAR(b->t, x, y, z);
        const SweepInts missed = (t + error < ray->begin) | (t - error > ray->end) | (s < limit) |
                                 (r < limit) | (1 - s - b->over_s * r < limit) |
                                 (1 - r - b->over_t * s < limit);
        const SweepInts may_be = ~missed;
        out->t[i] = t;
        out->bits |= gather_bits(&may_be) << (LANES * i);
    }
}

// The candidates among the group's pieces, but for the one that the ray leaves, which is plane.
static uint32_t candidates_of(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                              uint32_t instance, Candidates *out)
{
    const uint32_t count = group->sweep_count;
    find_candidates(group->sweep, (count + LANES - 1) / LANES, local, out);
    uint32_t bits = out->bits & (UINT32_MAX >> (SWEEP_MOST - count));
    const uint32_t own = ray->ends.flat - 1 - group->first_flat;
    if (own < count && ray->ends.instance == instance) {
        bits &= ~(UINT32_C(1) << own);
    }
    return bits;
}

bool accel_sweep_intersect(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                           uint32_t instance, Hit *hit)
{
    Candidates candidates;
    uint32_t bits = candidates_of(group, ray, local, instance, &candidates);
    if (bits == 0) {
        return false;
    }
    float t[SWEEP_MOST];
    memcpy(t, candidates.t, sizeof t);
    bool found = false;
    Ray nearer = *ray;
    for (; bits; bits &= bits - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(bits);
        if (accel_meet_flat(group->accel, group->first_flat + i, &nearer, instance, true, hit)) {
            nearer.tmax = hit->t;
            found = true;
        }
    }
    return found;
}

bool accel_sweep_occluded(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                          uint32_t instance)
{
    Candidates candidates;
    Hit hit;
    uint32_t bits = candidates_of(group, ray, local, instance, &candidates);
    for (; bits; bits &= bits - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(bits);
        if (accel_meet_flat(group->accel, group->first_flat + i, ray, instance, true, &hit)) {
            return true;
        }
    }
    return false;
}
