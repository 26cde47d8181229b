// A path, and what it finds of lights: what its rays meet, and what next-event estimation brings.
// Part of path.c, which has the rest: how it scatters and goes on.
#ifndef RENDER_INTEGRATORS_PATH_LIGHT_H
#define RENDER_INTEGRATORS_PATH_LIGHT_H

#include "base/hot.h"
#include "render/integrators/surface_hit.h"
#include "render/materials/lambert.h"

// Numbers of the sampler for each surface, two sets of four: two on the light, choice of the light
// and of its part, which may need more than 24 bits; two for the direction, choice of the lobe,
// roulette. Drawn together, so that their dimensions are fixed.
enum {
    LIGHT_U,
    LIGHT_V,
    LIGHT,
    LIGHT_PART,
    BSDF_U,
    BSDF_V,
    LOBE,
    ROULETTE,
    DIMENSIONS_PER_SURFACE
};

// Which lamps the present ray is to find.
typedef enum LampWays {
    LAMPS_ALL,
    LAMPS_WIDE,  // small ones are found otherwise
    LAMPS_SMALL, // only they
} LampWays;

typedef struct Path {
    const World *world;
    Sampler *sampler;
    IntegratorStats *stats;
    Rgb throughput; // of the path so far
    Rgb radiance;   // found so far
    Rgb indirect;   // of that, what came by chance from beyond the first surface (share.h)
    int64_t depth;  // scatterings so far
    int64_t spread; // those by smooth lobes
    float squeeze;  // radiance here over radiance at the camera, by indices of refraction alone
    // How the present ray's direction was chosen, for the weight of light that it hits.
    float pdf;         // by solid angle
    bool certain;      // by the camera or a delta lobe: no light sampling competes
    bool chosen;       // some scattering so far was one of several that might have been
    bool far;          // that is so of what led to the present surface
    bool smooth_first; // a smooth lobe is what the camera sees
    bool photons_find; // what traced lights emit along it is found by photons (photons.h)
    bool lamps_apart;  // what lights emit along the camera's ray isn't wanted
    LampWays lamps;    // see add_mirrored
    // Where it was chosen is one of these; the other is for where the next one will be.
    LightReceiver receivers[2];
    unsigned chosen_at;
    // What light sampling will have found where nothing stands in the shadow ray's way.
    bool waits;
    Rgb direct;
    Ray shadow;
    MediumStack media; // the transparent bodies that the present ray is in
} Path;

static inline const LightReceiver *chosen_at(const Path *path)
{
    return &path->receivers[path->chosen_at];
}
static inline LightReceiver *next_receiver(Path *path)
{
    return &path->receivers[path->chosen_at ^ 1];
}

static inline double finer(const Path *path, float coarse, uint32_t dimension)
{
    return (double)coarse + sampler_finer(path->sampler, dimension);
}

// What radiance found after so many scatterings gives to the camera.
static Rgb part_of(const Path *path, Rgb radiance, float weight, int64_t depth)
{
    const Rgb part = rgb_scale(rgb_mul(path->throughput, radiance), weight);
    const float clamp = path->world->clamp;
    return clamp > 0 && depth >= 2
               ? rgb(fminf(part.r, clamp), fminf(part.g, clamp), fminf(part.b, clamp))
               : part;
}

static void add_part(Path *path, Rgb part)
{
    path->radiance = rgb_add(path->radiance, part);
    if (path->far) {
        path->indirect = rgb_add(path->indirect, part);
    }
}

static void add_radiance(Path *path, Rgb radiance, float weight)
{
    add_part(path, part_of(path, radiance, weight, path->depth));
}

// The weight of light that the present ray hit, which light sampling would have found with
// light_pdf.
static float hit_weight(const Path *path, float light_pdf)
{
    if (path->certain || !(light_pdf > 0)) {
        return 1;
    }
    switch (path->world->sampling) {
    case SAMPLING_LIGHT:
        return 0;
    case SAMPLING_BSDF:
        return 1;
    default:
        return power_heuristic(path->pdf, light_pdf);
    }
}

static float hit_light_pdf(const Path *path, uint32_t index, Vec3 direction, const Surface *hit)
{
    const World *world = path->world;
    float chance = path->certain ? 0 : light_chance(world->lights, chosen_at(path), index);
    if (!(chance > 0)) {
        return 0;
    }
    const Light *light = light_set_get(world->lights, index);
    return chance * light->class->pdf(world, light, chosen_at(path)->p, direction, hit);
}

// Whether emission that the present ray meets is another's to find.
static inline bool found_apart(const Path *path)
{
    return path->depth == 0 && path->lamps_apart;
}

APART static void add_escaped(Path *path, Vec3 direction)
{
    const World *world = path->world;
    if (found_apart(path) || path->lamps == LAMPS_SMALL) {
        return;
    }
    uint32_t count;
    const uint32_t *infinite = light_set_infinite(world->lights, &count);
    for (uint32_t i = 0; i < count; ++i) {
        const Light *light = light_set_get(world->lights, infinite[i]);
        if (path->photons_find && world->photon_lights[infinite[i]]) {
            continue;
        }
        float chance =
            path->certain ? 0 : light_chance(world->lights, chosen_at(path), infinite[i]);
        float pdf = 0;
        Rgb radiance = light->class->escaped(world, light, direction, chance > 0 ? &pdf : NULL);
        add_radiance(path, radiance, hit_weight(path, chance * pdf));
    }
}

// Whether a lamp is small and far from where the present ray's direction was chosen.
static bool is_small(const Path *path, const Light *light)
{
    const double most = 0.15; // of the distance: the radius
    const Vec3 way = sub(box3_center(light->bounds), chosen_at(path)->p);
    const Vec3 size = sub(light->bounds.max, light->bounds.min);
    return length_squared(size) / 4 < most * most * length_squared(way);
}

APART static void add_emitted(Path *path, const Ray *ray, const Hit *hit, Surface *surface)
{
    const World *world = path->world;
    uint32_t index = light_of_surface(world, surface);
    if (index == NONE_ID || (path->photons_find && world->photon_lights[index])) {
        return;
    }
    const Light *light = light_set_get(world->lights, index);
    if (path->lamps && is_small(path, light) != (path->lamps == LAMPS_SMALL)) {
        return;
    }
    if (light->whole && !surface->whole) {
        accel_surface(world->accel, ray, hit, surface);
    }
    Rgb radiance = light->class->emitted(world, light, surface);
    if (!rgb_is_black(radiance)) {
        float pdf = hit_light_pdf(path, index, ray->direction, surface);
        add_radiance(path, radiance, hit_weight(path, pdf));
    }
}

// Follows the shadow ray that waits, if there is one. As late as may be, just before the next ray:
// neither waits for the other then, and both are on their way at once.
static inline void finish_direct(Path *path)
{
    if (!path->waits) {
        return;
    }
    path->waits = false;
    if (!accel_occluded(path->world->accel, &path->shadow)) {
        add_part(path, path->direct);
    }
}

// Chooses a light, and a direction to it; `dimension` is that of the first of the numbers.
static inline bool choose_direction(Path *path, const Surface *surface, const float *n,
                                    uint32_t dimension, float *chance, LightSample *out)
{
    const World *world = path->world;
    uint32_t index = world->only_light;
    *chance = 1;
    if (index == NONE_ID) {
        const double u = finer(path, n[LIGHT], dimension + LIGHT);
        index = light_choose(world->lights, next_receiver(path), u, chance);
        if (index == NONE_ID) {
            return false;
        }
    }
    const Light *light = &world->light_items[index];
    if (light_is_behind(light, next_receiver(path))) {
        return false; // told soon, a third of surfaces cost little; else by the material
    }
    const double part =
        light->parts ? finer(path, n[LIGHT_PART], dimension + LIGHT_PART) : (double)n[LIGHT_PART];
    return light->class->sample(world, light, surface->p, (double)n[LIGHT_U], (double)n[LIGHT_V],
                                part, out) &&
           !rgb_is_black(out->value) && (world->sampling != SAMPLING_BSDF || out->delta);
}

// The density of a direction, unit in the world, that is chosen by the material (with density bsdf)
// or by what is known about the cell (NULL: nothing).
static inline float guided_pdf(const GuideCell *cell, Vec3 p, Vec3 direction, float bsdf)
{
    if (!cell) {
        return bsdf;
    }
    const float part = GUIDE_PART;
    return (1 - part) * bsdf + part * guide_pdf(cell, p, direction);
}

// The commonest material is asked without calls, its numbers in registers, and for its albedo once.
typedef struct Matt {
    bool is; // the surface is of that material
    Rgb albedo;
} Matt;

static inline Matt matt_at(const ShadingPoint *point, const WorldMaterial *material)
{
    if (material->class != &lambert_material || point->bent) {
        return (Matt){false, rgb_gray(0)};
    }
    return (Matt){true,
                  material->is_even ? material->albedo : lambert_albedo(point, material->params)};
}

static inline BsdfEval evaluate(const ShadingPoint *point, const WorldMaterial *material,
                                const Matt *matt, Vec3 wi)
{
    if (matt->is) {
        return lambert_eval(point, matt->albedo, wi);
    }
    BsdfEval out;
    material_evaluate(point, material, wi, &out);
    return out;
}

// Light sampling: one direction to one light.
static void add_direct(Path *path, const ShadingPoint *point, const WorldMaterial *material,
                       const Matt *matt, const GuideCell *cell, const float *n, uint32_t dimension)
{
    const World *world = path->world;
    const Surface *surface = point->surface;
    float chance;
    LightSample s;
    if (!choose_direction(path, surface, n, dimension, &chance, &s)) {
        return;
    }
    const Vec3 wi = to_local(&point->frame, s.direction);
    const BsdfEval bsdf = evaluate(point, material, matt, wi);
    if (rgb_is_black(bsdf.value)) {
        return;
    }
    light_sample_ray(surface, &s, &path->shadow);
    ++path->stats->shadow_rays;
    float pdf = s.pdf * chance;
    bool alone = s.delta || world->sampling == SAMPLING_LIGHT;
    float weight =
        alone ? 1 : power_heuristic(pdf, guided_pdf(cell, surface->p, s.direction, bsdf.pdf));
    const Rgb value = rgb_mul(s.value, bsdf.value);
    const int64_t depth = path->depth + 1; // the light has been scattered here
    if (!world->media && !(world->all_lobes & LOBE_PASS)) {
        path->direct = part_of(path, value, weight / pdf, depth);
        path->waits = true;
        return;
    }
    const Rgb passed = world->media ? surface_light_passed(point, &path->media, wi, &path->shadow)
                                    : world_visibility(world, &path->shadow);
    if (!rgb_is_black(passed)) {
        add_part(path, part_of(path, rgb_mul(value, passed), weight / pdf, depth));
    }
}

#endif
