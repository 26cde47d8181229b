// What throws caustics: shapes that mirror or refract light in single directions.
#ifndef RENDER_CASTERS_H
#define RENDER_CASTERS_H

#include "base/array.h"
#include "base/vec.h"

struct World;

typedef struct Caster {
    uint32_t shape, instance;
    Box3 box;    // in the world
    Vec3 center; // of a sphere about it, in the world
    double radius;
} Caster;
typedef ARRAY(Caster) CasterArray;

// Whether a shape is one if its material is: it is bounded.
bool caster_is_bounded(const struct World *world, uint32_t shape);
// Appends the world's casters, `most` of them at most. *all (may be NULL): whether there are no
// more. False when memory runs out.
bool casters_find(const struct World *world, size_t most, CasterArray *out, bool *all);

#endif
