// What integrators share: the surface that a ray meets, and what of it they show as it is.
#ifndef RENDER_INTEGRATORS_SURFACE_HIT_H
#define RENDER_INTEGRATORS_SURFACE_HIT_H

#include "render/integrator.h"

// So many surfaces that let light pass (cut-outs) are crossed by one ray; the next ends it.
enum { MAX_PASSES = 1024 };

// Not to be copied: `point` refers to `surface`.
typedef struct SurfaceHit {
    Hit hit;
    Surface surface;
    ShadingPoint point;
} SurfaceHit;

// The nearest surface along a ray of unit direction, ready for shading; counts the ray. False where
// it meets nothing.
bool surface_hit(const World *world, const Ray *ray, IntegratorStats *stats, SurfaceHit *out);
// The same for views: goes on through surfaces that let more than half of the light pass.
bool surface_hit_visible(const World *world, const Ray *ray, IntegratorStats *stats,
                         SurfaceHit *out);
// What the arbitrary output variables tell of a hit.
void aov_fill(const Hit *hit, const ShadingPoint *point, AovSample *aov);

// The lobes of a surface's material.
uint32_t surface_lobes(const World *world, const Surface *surface);
// The radiance that a surface emits to where the ray that found it came from.
Rgb surface_emitted(const World *world, const Surface *surface);
// The radiance of all lights at infinity along a direction in which nothing is hit.
Rgb world_escaped(const World *world, Vec3 direction);

#endif
