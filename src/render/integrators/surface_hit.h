// What integrators share: the surface that a ray meets, and what of it they show as it is.
#ifndef RENDER_INTEGRATORS_SURFACE_HIT_H
#define RENDER_INTEGRATORS_SURFACE_HIT_H

#include "render/accel_plain.h"
#include "render/integrator.h"

// So many surfaces that let light pass (cut-outs) are crossed by one ray; the next ends it.
enum { MAX_PASSES = 1024 };

// Not to be copied: `point` refers to `surface`.
typedef struct SurfaceHit {
    Hit hit;
    Surface surface;
    ShadingPoint point;
} SurfaceHit;

// What lies at a hit, as much of it as its material asks for, and that material. Of a flat piece
// little is worked out without that, and its material is found on the way.
static inline const WorldMaterial *surface_reached(const World *world, const Ray *ray,
                                                   const Hit *hit, Surface *surface)
{
    const AccelFlat *plain = accel_plain_flat(world->accel, hit);
    const bool flat = hit->flat != 0;
    if (plain) {
        accel_fill_plain(plain, ray, hit, surface);
    } else if (flat) {
        accel_surface_plain(world->accel, ray, hit, surface);
    }
    const WorldMaterial *material =
        world_material(world, flat ? surface->material : accel_material(world->accel, hit));
    if (material->whole) {
        accel_surface(world->accel, ray, hit, surface);
    } else if (!flat) {
        accel_surface_plain(world->accel, ray, hit, surface);
    }
    return material;
}
// The nearest surface along a ray of unit direction, ready for shading; counts the ray. False where
// it meets nothing.
bool surface_hit(const World *world, const Ray *ray, IntegratorStats *stats, SurfaceHit *out);
// The same with no more of the surface than its material asks for.
bool surface_hit_lean(const World *world, const Ray *ray, IntegratorStats *stats, SurfaceHit *out);
// The same, whole, for views: goes on through surfaces that let more than half of the light pass.
bool surface_hit_visible(const World *world, const Ray *ray, IntegratorStats *stats,
                         SurfaceHit *out);
// What the arbitrary output variables tell of a hit.
void aov_fill(const Hit *hit, const ShadingPoint *point, AovSample *aov);

// The lobes of a surface's material.
uint32_t surface_lobes(const World *world, const Surface *surface);
// Where light for the point is looked for: a material that lets nothing through is lit from the
// viewer's side only. `lobes` are the material's.
static inline LightReceiver surface_receiver(const ShadingPoint *point, uint32_t lobes)
{
    const Surface *surface = point->surface;
    const double side = lobes & LOBE_TRANSMIT ? 0 : copysign(1, point->wo_side);
    return (LightReceiver){surface->p, scale(surface->geometric, side)};
}
// The part of light that arrives along the shadow ray to a light in direction wi (of the frame),
// through what the ray to the point was in, or what it is in beyond the surface.
Rgb surface_light_passed(const ShadingPoint *point, const MediumStack *media, Vec3 wi,
                         const Ray *shadow);
// Takes a ray in `media` over `distance` to the surface: *carried, radiance or flux, is dimmed by
// what it goes through. True where the surface is covered by that: it isn't there, `media` are
// those behind it, and the ray goes on. *outside: see ShadingPoint.
bool surface_reach_through(const World *world, MediumStack *media, const Surface *surface,
                           double distance, Rgb *carried, double *outside);
static inline bool surface_reach(const World *world, MediumStack *media, const Surface *surface,
                                 double distance, Rgb *carried, double *outside)
{
    *outside = 0;
    return world->media && surface_reach_through(world, media, surface, distance, carried, outside);
}
// The radiance that a surface emits to where the ray that found it came from. Makes the surface
// whole where that is asked for.
Rgb surface_emitted(const World *world, const Ray *ray, SurfaceHit *at);
// The radiance of all lights at infinity along a direction in which nothing is hit.
Rgb world_escaped(const World *world, Vec3 direction);

// The weight of a sample of density p where another strategy has density q: p² / (p² + q²) (Veach
// and Guibas 1995), safe where squares overflow.
static inline float power_heuristic(float p, float q)
{
    if (!(p > 0)) {
        return 0;
    }
    float ratio = q / p;
    return 1 / (1 + ratio * ratio);
}

#endif
