#include "render/integrators/surface_hit.h"

bool surface_hit(const World *world, const Ray *ray, IntegratorStats *stats, SurfaceHit *out)
{
    ++stats->rays;
    if (!accel_intersect(world->accel, ray, &out->hit)) {
        return false;
    }
    accel_surface(world->accel, ray, &out->hit, &out->surface);
    shading_point(world, &out->surface, ray->direction, &out->point);
    return true;
}

bool surface_hit_lean(const World *world, const Ray *ray, IntegratorStats *stats, SurfaceHit *out)
{
    ++stats->rays;
    if (!accel_intersect(world->accel, ray, &out->hit)) {
        return false;
    }
    surface_reached(world, ray, &out->hit, &out->surface);
    shading_point(world, &out->surface, ray->direction, &out->point);
    return true;
}

bool surface_hit_visible(const World *world, const Ray *ray, IntegratorStats *stats,
                         SurfaceHit *out)
{
    Ray rest = *ray;
    double passed = 0;
    for (int i = 0; i < MAX_PASSES; ++i) {
        if (!surface_hit(world, &rest, stats, out)) {
            return false;
        }
        out->hit.t += passed;
        Rgb pass = surface_lobes(world, &out->surface) & LOBE_PASS
                       ? material_pass(world, out->surface.material, &out->surface)
                       : rgb_gray(0);
        if (!(luminance(pass) > 0.5f)) {
            return true;
        }
        passed = out->hit.t;
        rest = surface_spawn(&out->surface, ray->direction);
    }
    return false;
}

void aov_fill(const Hit *hit, const ShadingPoint *point, AovSample *aov)
{
    const Surface *surface = point->surface;
    aov->albedo = material_albedo(point, surface->material);
    aov->normal = surface->front ? surface->shading : neg(surface->shading);
    aov->position = surface->p;
    aov->depth = hit->t;
    aov->object = surface->shape + 1;
    aov->material = surface->material >= MATERIAL_BLACK ? 0 : surface->material + 1;
}

uint32_t surface_lobes(const World *world, const Surface *surface)
{
    return world_material(world, surface->material)->lobes;
}

Rgb surface_light_passed(const ShadingPoint *point, const MediumStack *media, Vec3 wi,
                         const Ray *shadow)
{
    if (wi.z * point->wo.z > 0) {
        return medium_visibility(point->world, media, shadow);
    }
    MediumStack beyond = *media;
    medium_cross(point->world, &beyond, point->surface);
    return medium_visibility(point->world, &beyond, shadow);
}

bool surface_reach_through(const World *world, MediumStack *media, const Surface *surface,
                           double distance, Rgb *carried, double *outside)
{
    const Medium *medium = medium_current(media);
    // What is seen from behind, though nothing says that its body was entered, was begun in.
    if (!medium && !surface->front) {
        medium = world_material(world, surface->material)->medium;
    }
    *carried = rgb_mul(*carried, medium_transmittance(medium, distance));
    const MediumBoundary boundary = medium_boundary(world, media, surface);
    if (boundary.hidden) {
        medium_cross(world, media, surface);
        return true;
    }
    *outside = boundary.medium ? boundary.outside : 0;
    return false;
}

Rgb surface_emitted(const World *world, const Ray *ray, SurfaceHit *at)
{
    Surface *surface = &at->surface;
    uint32_t index = light_of_surface(world, surface);
    if (index == NONE_ID) {
        return rgb_gray(0);
    }
    const Light *light = light_set_get(world->lights, index);
    if (light->whole && !surface->whole) {
        accel_surface(world->accel, ray, &at->hit, surface);
    }
    return light->class->emitted(world, light, surface);
}

Rgb world_escaped(const World *world, Vec3 direction)
{
    uint32_t count;
    const uint32_t *infinite = light_set_infinite(world->lights, &count);
    Rgb sum = rgb_gray(0);
    for (uint32_t i = 0; i < count; ++i) {
        const Light *light = light_set_get(world->lights, infinite[i]);
        sum = rgb_add(sum, light->class->escaped(world, light, direction, NULL));
    }
    return sum;
}
