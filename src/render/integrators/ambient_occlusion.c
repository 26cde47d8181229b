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
    .example =
        "render { integrator: \"ambient_occlusion\", ao_distance: 1 }\n"
        "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
        "directional_light { direction: (-1, -1.5, -1), irradiance: 3 }\n"
        "environment_light { color: #a8c4e8, radiance: 0.3 }\n"
        "plane { material: phong { color: gray(0.5), ambient: 0.15 } }\n"
        "sphere {\n"
        "  center: (-0.8, 0.5, 0)\n"
        "  radius: 0.5\n"
        "  material: phong { color: #b03020, ambient: 0.15, diffuse: 0.6, specular: 0.3, "
        "shininess: 60 }\n"
        "}\n"
        "sphere { center: (0.3, 0.4, -0.6), radius: 0.4, material: mirror { color: gray(0.9) } }\n"
        "box { min: (0.6, 0, -0.2), max: (1.2, 0.6, 0.4), material: phong { color: #3060a0, "
        "ambient: 0.15 } }",
    .radiance = radiance,
};
