// Unidirectional path tracing with next-event estimation, weighted by multiple importance sampling
// (Kajiya 1986; Veach and Guibas 1995, power heuristic).
//
// At each surface one light is chosen and one direction on it (light sampling), and one direction
// is chosen by the material (BSDF sampling), along which the path goes on; light that this ray hits
// counts too, with weights that sum to one. `sampling` leaves one of the two out, where the other
// can find the light at all: the mean stays the same.
#include "render/casters.h"
#include "render/integrators/path_light.h"

// Roulette begins after this many scatterings by smooth lobes, for those before are stratified over
// a pixel's samples, which roulette would undo; or after this many of any. Mirrors and clear glass
// lead a path on as it was, and what finds the sun behind them is worth what it takes to get there.
enum { ROULETTE_START = 4, ROULETTE_LATEST = 8 };

// Of density 0: none.
static inline BsdfSample choose(const ShadingPoint *point, const WorldMaterial *material,
                                const Matt *matt, const float *n, const CosineDirection *cosine)
{
    if (matt->is) {
        return lambert_sample(point, matt->albedo, cosine_vec3(cosine));
    }
    BsdfSample out;
    if (!material_choose(point, material, n[LOBE], n[BSDF_U], n[BSDF_V], &out)) {
        out.pdf = 0;
    }
    return out;
}

// Ends paths by chance, the dimmer the sooner; what survives is brighter by as much. That radiance
// is squeezed in glass doesn't make a path dim. By the root of the throughput: a dim path costs few
// rays more, and may be the one that finds the sun; in the long run the chance to survive a
// scattering is its albedo, as it would be by the throughput itself.
static bool roulette(Path *path, float number)
{
    if (!path->world->russian_roulette ||
        (path->spread < ROULETTE_START && path->depth < ROULETTE_LATEST)) {
        return true;
    }
    float survival = rgb_max(path->throughput) * path->squeeze;
    if (survival >= 1) {
        return true;
    }
    survival = sqrtf(survival);
    if (!(number < survival)) {
        return false;
    }
    path->throughput = rgb_scale(path->throughput, 1 / survival);
    return true;
}

// Nothing can be found by going on after the last scattering where no ray can hit a light.
static bool last_ray_needed(const World *world)
{
    uint32_t infinite;
    light_set_infinite(world->lights, &infinite);
    return world->shape_lights || infinite > 0;
}

// Chooses a direction by the material or by the cell, as if they were one (Veach and Guibas 1995,
// one-sample model, balance heuristic).
APART static BsdfSample choose_guided(const ShadingPoint *point, const WorldMaterial *material,
                                      const GuideCell *cell, const float *n)
{
    BsdfSample out;
    const Vec3 p = point->surface->p;
    const float part = GUIDE_PART;
    if (n[LOBE] < part) {
        const Vec3 direction = guide_sample(cell, p, n[LOBE] / part, n[BSDF_U], n[BSDF_V]);
        BsdfEval bsdf;
        out.wi = to_local(&point->frame, direction);
        material_evaluate(point, material, out.wi, &bsdf);
        out.pdf = guided_pdf(cell, p, direction, bsdf.pdf);
        out.weight = rgb_scale(bsdf.value, 1 / out.pdf);
        out.eta = 1;
        out.lobes = LOBE_REFLECT | LOBE_SMOOTH;
        out.pdf = out.pdf < INFINITY ? out.pdf : 0;
        return out;
    }
    const float lobe = fminf((n[LOBE] - part) / (1 - part), 0x1.fffffep-1F);
    if (!material_choose(point, material, lobe, n[BSDF_U], n[BSDF_V], &out)) {
        out.pdf = 0;
        return out;
    }
    float pdf = (1 - part) * out.pdf; // of a delta lobe a chance
    if (!(out.lobes & LOBE_DELTA)) {
        pdf = guided_pdf(cell, p, from_local(&point->frame, out.wi), out.pdf);
    }
    out.weight = rgb_scale(out.weight, out.pdf / pdf);
    out.pdf = pdf;
    return out;
}

// Whether what traced lights emit along the next ray is left to photons.
APART static void leave_to_photons(Path *path, const Surface *surface,
                                   const WorldMaterial *material, uint32_t lobes)
{
    const bool delta = lobes & material->lobes & LOBE_DELTA;
    if (path->depth == 1) {
        path->smooth_first = !delta;
    }
    path->photons_find = path->depth > 1 && path->smooth_first && delta &&
                         caster_is_bounded(path->world, surface->shape);
}

// Chooses the next ray, and by which lobes; false where the path ends.
static bool scatter(Path *path, const ShadingPoint *point, const WorldMaterial *material,
                    const Matt *matt, BsdfSample s, float number, Ray *ray, uint32_t *lobes)
{
    const World *world = path->world;
    if (!(s.pdf > 0)) {
        return false;
    }
    *lobes = s.lobes;
    path->throughput = rgb_mul(path->throughput, s.weight);
    if (rgb_is_black(path->throughput)) {
        return false;
    }
    Vec3 direction = ray->direction;
    if (!(s.lobes & LOBE_PASS)) {
        path->squeeze *= s.eta * s.eta;
        if (world->media && s.wi.z * point->wo.z < 0) {
            medium_cross(world, &path->media, point->surface);
        }
        ++path->depth;
        path->spread += !(s.lobes & LOBE_DELTA);
        path->chosen |= !(s.lobes & LOBE_DELTA) || s.pdf < 1;
        if (world->photon_lights) {
            leave_to_photons(path, point->surface, material, s.lobes);
        }
        if ((path->depth == world->bounces && !last_ray_needed(world)) || !roulette(path, number)) {
            return false;
        }
        path->chosen_at ^= 1;
        path->pdf = s.pdf;
        path->certain = s.lobes & LOBE_DELTA;
        direction = from_local(&point->frame, s.wi);
        if (!matt->is) { // whose direction is of unit length as it is
            direction = renormalize(direction);
        }
    }
    *ray = surface_spawn(point->surface, direction);
    return true;
}

// After the last scattering a ray goes on through cut-outs alone, which scatter nothing.
APART static bool pass_on(Path *path, const WorldMaterial *material, const Surface *surface,
                          Ray *ray)
{
    if (!(material->lobes & LOBE_PASS)) {
        return false;
    }
    path->throughput =
        rgb_mul(path->throughput, material_pass(path->world, surface->material, surface));
    *ray = surface_spawn(surface, ray->direction);
    return !rgb_is_black(path->throughput);
}

// Whether directions are chosen by the guide. Where there are photons, what is seen by way of a
// smooth lobe first is left to them.
static bool is_guided(const Path *path, const WorldMaterial *material)
{
    const World *world = path->world;
    return world->guide && guide_serves(material->lobes) &&
           (!world->photon_lights || (path->depth > 0 && !path->smooth_first));
}

typedef enum Arrival {
    ARRIVED_NOWHERE, // the path ends
    ARRIVED_HIDDEN,  // at a surface that isn't there: *ray is the way on
    ARRIVED,
} Arrival;

// The present ray up to the next surface, and what lights emit along it.
static inline Arrival arrive(Path *path, Ray *ray, Hit *hit, Surface *surface, double *outside,
                             const WorldMaterial **material)
{
    const World *world = path->world;
    ++path->stats->rays;
    if (!accel_intersect(world->accel, ray, hit)) {
        if (world->media) {
            path->throughput = rgb_mul(
                path->throughput, medium_transmittance(medium_current(&path->media), INFINITY));
        }
        add_escaped(path, ray->direction);
        return ARRIVED_NOWHERE;
    }
    *material = surface_reached(world, ray, hit, surface);
    if (surface_reach(world, &path->media, surface, hit->t, &path->throughput, outside)) {
        *ray = surface_spawn(surface, ray->direction);
        return ARRIVED_HIDDEN;
    }
    if (((*material)->lobes & LOBE_EMIT || surface->lamp) && !found_apart(path)) {
        add_emitted(path, ray, hit, surface);
    }
    return ARRIVED;
}

// What lights emit along a ray, and nothing that anything scatters.
static void trace_lamps(Path *path, Ray ray)
{
    for (int i = 0; i < MAX_PASSES; ++i) {
        Hit hit;
        Surface surface;
        double outside;
        const WorldMaterial *material;
        const Arrival arrival = arrive(path, &ray, &hit, &surface, &outside, &material);
        if (arrival == ARRIVED_NOWHERE ||
            (arrival == ARRIVED && !pass_on(path, material, &surface, &ray))) {
            return;
        }
    }
}

// Small lamps that the camera sees by way of a mirror or of smooth glass are bright, and chance
// takes their way seldom: of clear glass, one path in twenty-five is reflected. So all delta lobes
// of the surface that is seen first are looked along, for the sake of such lamps alone; what is
// wide may be as bright by way of all lobes, and a choice between these is then no noise. False
// where the one that the path takes will do, or they aren't known.
APART static bool add_mirrored(Path *path, const ShadingPoint *point, const WorldMaterial *material)
{
    const World *world = path->world;
    BsdfSample lobes[DELTA_ROOM];
    const int count = material_deltas(point, point->surface->material, lobes, DELTA_ROOM);
    const bool others = material->lobes & (LOBE_SMOOTH | LOBE_PASS);
    if (count < 1 || (count == 1 && !others)) {
        return false;
    }
    for (int i = 0; i < count; ++i) {
        Path seen = *path;
        seen.lamps_apart = false;
        seen.lamps = LAMPS_SMALL;
        seen.certain = true;
        seen.chosen_at ^= 1;
        seen.depth = 1;
        seen.radiance = rgb_gray(0);
        seen.throughput = rgb_mul(path->throughput, lobes[i].weight);
        if (rgb_is_black(seen.throughput)) {
            continue;
        }
        if (world->media && lobes[i].wi.z * point->wo.z < 0) {
            medium_cross(world, &seen.media, point->surface);
        }
        const Vec3 direction = renormalize(from_local(&point->frame, lobes[i].wi));
        trace_lamps(&seen, surface_spawn(point->surface, direction));
        path->radiance = rgb_add(path->radiance, seen.radiance);
    }
    return true;
}

HOT static void trace(Path *path, Ray ray, AovSample *aov)
{
    const World *world = path->world;
    uint32_t dimension = path->sampler->dimension;
    for (int64_t i = 0; i < world->bounces + MAX_PASSES; ++i) {
        const uint32_t first = dimension + (uint32_t)i * DIMENSIONS_PER_SURFACE;
        finish_direct(path);
        const float *n = sampler_eight(path->sampler, first);
        const CosineDirection cosine = sample_cosine(n[BSDF_U], n[BSDF_V]);
        Hit hit;
        Surface surface;
        double outside;
        const WorldMaterial *material;
        const Arrival arrival = arrive(path, &ray, &hit, &surface, &outside, &material);
        if (arrival == ARRIVED_NOWHERE) {
            return;
        }
        if (arrival == ARRIVED_HIDDEN) {
            continue;
        }
        path->far = path->chosen;
        const bool last = path->depth >= world->bounces;
        if (last && !(aov && i == 0)) {
            if (!pass_on(path, material, &surface, &ray)) {
                return;
            }
            continue;
        }
        ShadingPoint point;
        shading_point(world, &surface, ray.direction, &point);
        point.outside = outside;
        if (aov && i == 0) {
            aov_fill(&hit, &point, aov);
            if (last && !pass_on(path, material, &surface, &ray)) {
                return;
            }
            if (last) {
                continue;
            }
        }
        *next_receiver(path) = surface_receiver(&point, material->lobes);
        const GuideCell *cell =
            is_guided(path, material) ? guide_find(world->guide, surface.p) : NULL;
        const Matt matt = matt_at(&point, material);
        const BsdfSample chosen = cell ? choose_guided(&point, material, cell, n)
                                       : choose(&point, material, &matt, n, &cosine);
        if (material->lobes & LOBE_SMOOTH) {
            add_direct(path, &point, material, &matt, cell, n, first);
        }
        bool mirrored = false;
        if (path->depth == 0 && material->lobes & LOBE_DELTA && world->shape_lights) {
            finish_direct(path);
            mirrored = add_mirrored(path, &point, material);
        }
        uint32_t lobes;
        if (!scatter(path, &point, material, &matt, chosen, n[ROULETTE], &ray, &lobes)) {
            finish_direct(path);
            return;
        }
        const bool known = mirrored && path->depth == 1 && lobes & LOBE_DELTA;
        path->lamps = known ? LAMPS_WIDE : LAMPS_ALL;
    }
    finish_direct(path);
}

static void begin(Path *path, const World *world, Sampler *sampler, IntegratorStats *stats)
{
    path->world = world;
    path->sampler = sampler;
    path->stats = stats;
    path->throughput = rgb_gray(1);
    path->radiance = path->indirect = rgb_gray(0);
    path->depth = path->spread = 0;
    path->squeeze = 1;
    path->certain = true;
    path->chosen = path->far = false;
    path->chosen_at = 0;
    path->waits = false;
    path->smooth_first = path->photons_find = path->lamps_apart = false;
    path->lamps = LAMPS_ALL;
    if (world->media) {
        path->media = world->camera_media;
    }
}

static Rgb found(const Path *path)
{
    const Rgb found = path->radiance;
    if (!rgb_is_finite(found) || found.r < 0 || found.g < 0 || found.b < 0) {
        ++path->stats->bad_samples;
        return rgb_gray(0);
    }
    return found;
}

static Rgb radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                    IntegratorStats *stats)
{
    Path path;
    begin(&path, world, sampler, stats);
    trace(&path, *ray, aov);
    return found(&path);
}

static Rgb lamps(const World *world, const Ray *ray, Sampler *sampler, IntegratorStats *stats)
{
    Path path;
    begin(&path, world, sampler, stats);
    trace_lamps(&path, *ray);
    return found(&path);
}

HOT static Rgb for_film(const World *world, const Ray *ray, Sampler *sampler, bool lamps_apart,
                        AovSample *aov, Rgb *indirect, IntegratorStats *stats)
{
    Path path;
    begin(&path, world, sampler, stats);
    path.lamps_apart = lamps_apart;
    trace(&path, *ray, aov);
    const Rgb all = found(&path);
    *indirect = rgb_is_black(all) ? rgb_gray(0) : path.indirect; // a bad one has none
    return all;
}

const IntegratorClass path_integrator = {
    .name = "path",
    .doc = "All light by path tracing: indirect light, soft shadows, reflections, refraction.",
    .example =
        "render { integrator: \"path\" }\n"
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
    .lamps = lamps,
    .for_film = for_film,
    .photons = true,
};
