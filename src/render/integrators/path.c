// Unidirectional path tracing with next-event estimation, weighted by multiple importance sampling
// (Kajiya 1986; Veach and Guibas 1995, power heuristic).
//
// At each surface one light is chosen and one direction on it (light sampling), and one direction
// is chosen by the material (BSDF sampling), along which the path goes on; light that this ray hits
// counts too, with weights that sum to one. `sampling` leaves one of the two out, where the other
// can find the light at all: the mean stays the same.
#include "render/casters.h"
#include "render/integrators/surface_hit.h"
#include "render/materials/lambert.h"

// Numbers of the sampler for each surface, two sets of four: two on the light, choice of the light
// and of its part; two for the direction, choice of the lobe, roulette.
enum { DIMENSIONS_PER_SURFACE = 8 };
// Roulette begins after this many scatterings by smooth lobes, for those before are stratified over
// a pixel's samples, which roulette would undo; or after this many of any. Mirrors and clear glass
// lead a path on as it was, and what finds the sun behind them is worth what it takes to get there.
enum { ROULETTE_START = 4, ROULETTE_LATEST = 8 };

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

// The numbers of one surface, drawn together so that their dimensions are fixed.
typedef union SurfaceNumbers {
    struct {
        float light_u, light_v, light, light_part, u, v, lobe, roulette;
    };
    float all[DIMENSIONS_PER_SURFACE];
} SurfaceNumbers;
enum { LIGHT = 2, LIGHT_PART = 3 }; // dimensions of the choices that may need more than 24 bits

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

static void add_escaped(Path *path, Vec3 direction)
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

static void add_emitted(Path *path, const Ray *ray, const Hit *hit, Surface *surface)
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
static inline bool choose_direction(Path *path, const Surface *surface, const SurfaceNumbers *n,
                                    uint32_t dimension, float *chance, LightSample *out)
{
    const World *world = path->world;
    uint32_t index = world->only_light;
    *chance = 1;
    if (index == NONE_ID) {
        const double u = finer(path, n->light, dimension + LIGHT);
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
        light->parts ? finer(path, n->light_part, dimension + LIGHT_PART) : (double)n->light_part;
    return light->class->sample(world, light, surface->p, (double)n->light_u, (double)n->light_v,
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

// The material's choices; the commonest material without calls, its numbers in registers.
static inline bool is_plain_lambert(const ShadingPoint *point, const WorldMaterial *material)
{
    return material->class == &lambert_material && !point->bent;
}

static inline BsdfEval evaluate(const ShadingPoint *point, const WorldMaterial *material, Vec3 wi)
{
    if (is_plain_lambert(point, material)) {
        return lambert_eval(point, material->params, wi);
    }
    BsdfEval out;
    material_evaluate(point, material, wi, &out);
    return out;
}

// Of density 0: none.
static inline BsdfSample choose(const ShadingPoint *point, const WorldMaterial *material,
                                const SurfaceNumbers *n, const CosineDirection *cosine)
{
    if (is_plain_lambert(point, material)) {
        return lambert_sample(point, material->params, cosine_vec3(cosine));
    }
    BsdfSample out;
    if (!material_choose(point, material, n->lobe, n->u, n->v, &out)) {
        out.pdf = 0;
    }
    return out;
}

// Light sampling: one direction to one light.
static void add_direct(Path *path, const ShadingPoint *point, const WorldMaterial *material,
                       const GuideCell *cell, const SurfaceNumbers *n, uint32_t dimension)
{
    const World *world = path->world;
    const Surface *surface = point->surface;
    float chance;
    LightSample s;
    if (!choose_direction(path, surface, n, dimension, &chance, &s)) {
        return;
    }
    const Vec3 wi = to_local(&point->frame, s.direction);
    const BsdfEval bsdf = evaluate(point, material, wi);
    if (rgb_is_black(bsdf.value)) {
        return;
    }
    path->shadow = light_sample_ray(surface, &s);
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
static BsdfSample choose_guided(const ShadingPoint *point, const WorldMaterial *material,
                                const GuideCell *cell, const SurfaceNumbers *n)
{
    BsdfSample out;
    const Vec3 p = point->surface->p;
    const float part = GUIDE_PART;
    if (n->lobe < part) {
        const Vec3 direction = guide_sample(cell, p, n->lobe / part, n->u, n->v);
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
    const float lobe = fminf((n->lobe - part) / (1 - part), 0x1.fffffep-1F);
    if (!material_choose(point, material, lobe, n->u, n->v, &out)) {
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
static void leave_to_photons(Path *path, const Surface *surface, const WorldMaterial *material,
                             uint32_t lobes)
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
                    BsdfSample s, float number, Ray *ray, uint32_t *lobes)
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
        if (!is_plain_lambert(point, material)) { // whose direction is of unit length as it is
            direction = renormalize(direction);
        }
    }
    *ray = surface_spawn(point->surface, direction);
    return true;
}

// After the last scattering a ray goes on through cut-outs alone, which scatter nothing.
static bool pass_on(Path *path, const WorldMaterial *material, const Surface *surface, Ray *ray)
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

// What lies at a hit, as much of it as its material asks for. Of a flat piece little is worked out
// without that, and its material is found on the way.
static inline const WorldMaterial *reached_surface(const World *world, const Ray *ray,
                                                   const Hit *hit, Surface *surface)
{
    const bool flat = hit->flat != 0;
    if (flat) {
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
    *material = reached_surface(world, ray, hit, surface);
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
static bool add_mirrored(Path *path, const ShadingPoint *point, const WorldMaterial *material)
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

static void trace(Path *path, Ray ray, AovSample *aov)
{
    const World *world = path->world;
    uint32_t dimension = path->sampler->dimension;
    for (int64_t i = 0; i < world->bounces + MAX_PASSES; ++i) {
        const uint32_t first = dimension + (uint32_t)i * DIMENSIONS_PER_SURFACE;
        SurfaceNumbers n;
        finish_direct(path);
        sampler_eight(path->sampler, first, n.all);
        const CosineDirection cosine = sample_cosine(n.u, n.v);
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
        const BsdfSample chosen = cell ? choose_guided(&point, material, cell, &n)
                                       : choose(&point, material, &n, &cosine);
        if (material->lobes & LOBE_SMOOTH) {
            add_direct(path, &point, material, cell, &n, first);
        }
        bool mirrored = false;
        if (path->depth == 0 && material->lobes & LOBE_DELTA && world->shape_lights) {
            finish_direct(path);
            mirrored = add_mirrored(path, &point, material);
        }
        uint32_t lobes;
        if (!scatter(path, &point, material, chosen, n.roulette, &ray, &lobes)) {
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

static Rgb for_film(const World *world, const Ray *ray, Sampler *sampler, bool lamps_apart,
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
