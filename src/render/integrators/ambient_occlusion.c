// How much of the surroundings a point sees: the part of light from an evenly bright sky that
// reaches it, (1/π) ∫ V cosθ dω (Zhukov, Iones and Kronin 1998, "An Ambient Light Illumination
// Model"), estimated with one ray a sample.
#include "render/integrators/surface_hit.h"

static Rgb radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                    IntegratorStats *stats)
{
    SurfaceHit at;
    if (!surface_hit_visible(world, ray, stats, &at)) {
        return rgb_gray(0);
    }
    if (aov) {
        aov_fill(&at.hit, &at.point, aov);
    }
    float u, v;
    sampler_2d(sampler, &u, &v);
    Vec3 wi = sample_cosine_hemisphere(u, v);
    wi.z = copysign(wi.z, at.point.wo.z);
    Vec3 direction = normalize(from_local(&at.point.frame, wi));
    if (dot(direction, at.surface.geometric) * at.point.wo_side <= 0) {
        return rgb_gray(0); // above the shading normal's plane only: the surface is in the way
    }
    Ray out = surface_spawn(&at.surface, direction);
    out.tmax = world->ao_distance;
    ++stats->shadow_rays;
    return world_visibility(world, &out);
}

const IntegratorClass ambient_occlusion_integrator = {
    .name = "ambient_occlusion",
    .doc = "How open each point lies, whatever the lights and materials: the part of an evenly "
           "bright sky's light that reaches it, (1/π) ∫ V cosθ dω, from 1 (nothing near) to 0. "
           "Only what is nearer than `ao_distance` hides the sky. Black where nothing is hit.",
    .radiance = radiance,
};
