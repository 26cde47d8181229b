// The classical ray tracer (Whitted 1980; Cook, Porter and Carpenter 1984 for lights with a size):
// direct light, and rays that follow mirrors and refraction.
//
// Nothing is chosen that can be summed: every light without a size is added, and at a surface with
// several delta lobes all are followed, each with its share. So a scene of such lights has no noise
// but that of the pixel filter. What remains to be sampled are lights with a size: at each surface
// one direction to each of them and one by the material, weighted by the power heuristic.
#include "render/integrators/surface_hit.h"

// Branches that carry less than this part of a pixel's light are cut off.
static const float FAINT = 1e-4f;
// Branches that wait to be followed; where there is no room for one more, one of two is dropped by
// chance, and the other stands for both.
enum { MAX_WAITING = 64 };
// Lights with a size that are all sampled at each surface; of more, one is chosen each time.
enum { MAX_SIZED = 16 };

typedef struct Branch {
    Ray ray;
    Rgb throughput;
    int64_t depth;     // scatterings so far
    float squeeze;     // radiance here over radiance at the camera, by indices of refraction alone
    int passes;        // cut-outs crossed so far
    MediumStack media; // the transparent bodies that the ray is in
} Branch;

typedef struct Tree {
    const World *world;
    Sampler *sampler;
    IntegratorStats *stats;
    Rgb radiance; // found so far
    Branch waiting[MAX_WAITING];
    int count;
} Tree;

static void add_radiance(Tree *tree, const Branch *branch, Rgb radiance, int64_t depth)
{
    Rgb part = rgb_mul(branch->throughput, radiance);
    float clamp = tree->world->clamp;
    if (clamp > 0 && depth >= 2) {
        part = rgb(fminf(part.r, clamp), fminf(part.g, clamp), fminf(part.b, clamp));
    }
    tree->radiance = rgb_add(tree->radiance, part);
}

// --- Branches ------------------------------------------------------------------------------------

static void grow(Tree *tree, const Branch *branch)
{
    float weight = rgb_max(branch->throughput) * branch->squeeze;
    if (!(weight >= FAINT)) {
        return;
    }
    if (tree->count < MAX_WAITING) {
        tree->waiting[tree->count++] = *branch;
        return;
    }
    Branch *last = &tree->waiting[MAX_WAITING - 1];
    float other = rgb_max(last->throughput) * last->squeeze, both = weight + other;
    if (sampler_1d(tree->sampler) * both < weight) {
        *last = *branch;
        other = weight;
    }
    last->throughput = rgb_scale(last->throughput, both / other);
}

static void grow_scattered(Tree *tree, const Branch *from, const ShadingPoint *point,
                           const BsdfSample *s)
{
    Branch branch = *from;
    branch.ray = surface_spawn(point->surface, normalize(from_local(&point->frame, s->wi)));
    branch.throughput = rgb_mul(from->throughput, s->weight);
    branch.squeeze *= s->eta * s->eta;
    branch.depth += 1;
    if (s->wi.z * point->wo.z < 0) {
        medium_cross(tree->world, &branch.media, point->surface);
    }
    grow(tree, &branch);
}

// Mirrors and refraction.
static void follow_deltas(Tree *tree, const Branch *branch, const ShadingPoint *point)
{
    BsdfSample lobes[DELTA_ROOM];
    uint32_t material = point->surface->material;
    int count = material_deltas(point, material, lobes, DELTA_ROOM);
    for (int i = 0; i < count; ++i) {
        grow_scattered(tree, branch, point, &lobes[i]);
    }
    if (count >= 0) {
        return;
    }
    // Only the material knows which there are.
    float u, v;
    sampler_2d(tree->sampler, &u, &v);
    if (material_sample(point, material, sampler_1d(tree->sampler), u, v, &lobes[0]) &&
        (lobes[0].lobes & LOBE_DELTA) && !(lobes[0].lobes & LOBE_PASS)) {
        grow_scattered(tree, branch, point, &lobes[0]);
    }
}

static void follow_pass(Tree *tree, const Branch *from, const Surface *surface)
{
    if (from->passes < MAX_PASSES) {
        Branch branch = *from;
        Rgb pass = material_pass(tree->world, surface->material, surface);
        branch.ray = surface_spawn(surface, from->ray.direction);
        branch.throughput = rgb_mul(from->throughput, pass);
        branch.passes += 1;
        grow(tree, &branch);
    }
}

// The surface that a branch's ray meets, its light on the way there absorbed. Surfaces that are
// covered by the body that the ray is in are not there. False where it meets nothing.
static bool meet(const World *world, Branch *branch, IntegratorStats *stats, SurfaceHit *at)
{
    for (; branch->passes < MAX_PASSES; ++branch->passes) {
        if (!surface_hit_lean(world, &branch->ray, stats, at)) {
            Rgb left = medium_transmittance(medium_current(&branch->media), INFINITY);
            branch->throughput = rgb_mul(branch->throughput, left);
            return false;
        }
        if (!surface_reach(world, &branch->media, &at->surface, at->hit.t, &branch->throughput,
                           &at->point.outside)) {
            return true;
        }
        branch->ray = surface_spawn(&at->surface, branch->ray.direction);
    }
    branch->throughput = rgb_gray(0);
    return false;
}

// --- Direct light --------------------------------------------------------------------------------

static bool has_size(const Light *light)
{
    return light->class->pdf && !light->delta;
}

// The lights that have a size; counting stops beyond MAX_SIZED.
static int count_sized(const World *world)
{
    int count = 0;
    size_t all = light_set_count(world->lights);
    for (size_t i = 0; i < all && count <= MAX_SIZED; ++i) {
        count += has_size(light_set_get(world->lights, i));
    }
    return count;
}

// A direction chosen by the material at a surface, where the direct light is sampled, too.
typedef struct Scattered {
    Branch branch; // along it
    LightReceiver receiver;
    float pdf;
    bool one_of_many; // of the lights with a size, one is chosen
} Scattered;

// The density with which add_light comes upon a direction to a light with a size.
static float light_pdf(const World *world, uint32_t index, const Scattered *scattered,
                       Vec3 direction, const Surface *hit)
{
    const Light *light = light_set_get(world->lights, index);
    const LightReceiver *receiver = &scattered->receiver;
    float chance = scattered->one_of_many ? light_chance(world->lights, receiver, index)
                                          : (float)(light->power > 0);
    return chance > 0 && has_size(light)
               ? chance * light->class->pdf(world, light, receiver->p, direction, hit)
               : 0;
}

// Light that one light sends to the point and the point to the viewer, over the chance with which
// the light was chosen.
static void add_light(Tree *tree, const Branch *branch, const ShadingPoint *point,
                      const Light *light, float chance)
{
    const World *world = tree->world;
    const Surface *surface = point->surface;
    float u = 0.5f, v = 0.5f;
    double part = 0.5;
    LightSample s;
    if (has_size(light)) {
        sampler_2d(tree->sampler, &u, &v);
        part = sampler_1d_fine(tree->sampler);
    }
    if (!light->class->sample(world, light, surface->p, (double)u, (double)v, part, &s) ||
        rgb_is_black(s.value) || (world->sampling == SAMPLING_BSDF && !s.delta)) {
        return;
    }
    Vec3 wi = to_local(&point->frame, s.direction);
    BsdfEval bsdf = material_eval(point, surface->material, wi);
    if (rgb_is_black(bsdf.value)) {
        return;
    }
    Ray shadow;
    light_sample_ray(surface, &s, &shadow);
    ++tree->stats->shadow_rays;
    Rgb visible = surface_light_passed(point, &branch->media, wi, &shadow);
    float pdf = s.pdf * chance;
    bool alone = s.delta || world->sampling == SAMPLING_LIGHT;
    float weight = alone ? 1 : power_heuristic(pdf, bsdf.pdf);
    Rgb lit = rgb_mul(rgb_mul(s.value, bsdf.value), visible);
    add_radiance(tree, branch, rgb_scale(lit, weight / pdf), branch->depth + 1);
}

static void add_found(Tree *tree, const Scattered *scattered, uint32_t index, Rgb radiance,
                      const Surface *hit)
{
    const World *world = tree->world;
    const Branch *branch = &scattered->branch;
    float other = light_pdf(world, index, scattered, branch->ray.direction, hit);
    float weight = 1;
    if (other > 0 && world->sampling != SAMPLING_BSDF) {
        weight = world->sampling == SAMPLING_LIGHT ? 0 : power_heuristic(scattered->pdf, other);
    }
    add_radiance(tree, branch, rgb_scale(radiance, weight), branch->depth);
}

// The light that such a ray hits, behind cut-outs perhaps.
static void add_hit_lights(Tree *tree, Scattered *scattered)
{
    const World *world = tree->world;
    Branch *branch = &scattered->branch;
    SurfaceHit at;
    while (meet(world, branch, tree->stats, &at)) {
        uint32_t index = light_of_surface(world, &at.surface);
        if (index != NONE_ID) {
            add_found(tree, scattered, index, surface_emitted(world, &branch->ray, &at),
                      &at.surface);
        }
        if (!(surface_lobes(world, &at.surface) & LOBE_PASS)) {
            return;
        }
        Rgb pass = material_pass(world, at.surface.material, &at.surface);
        branch->throughput = rgb_mul(branch->throughput, pass);
        if (rgb_is_black(branch->throughput)) {
            return;
        }
        branch->ray = surface_spawn(&at.surface, branch->ray.direction);
        branch->passes += 1;
    }
    uint32_t count;
    const uint32_t *infinite = light_set_infinite(world->lights, &count);
    for (uint32_t i = 0; i < count; ++i) {
        const Light *light = light_set_get(world->lights, infinite[i]);
        Rgb radiance = light->class->escaped(world, light, branch->ray.direction, NULL);
        add_found(tree, scattered, infinite[i], radiance, NULL);
    }
}

static void add_scattered(Tree *tree, const Branch *from, const ShadingPoint *point,
                          bool one_of_many)
{
    float u, v;
    BsdfSample s;
    sampler_2d(tree->sampler, &u, &v);
    float lobe = sampler_1d(tree->sampler);
    if (!material_sample(point, point->surface->material, lobe, u, v, &s) ||
        (s.lobes & (LOBE_DELTA | LOBE_PASS)) || rgb_is_black(s.weight)) {
        return;
    }
    Scattered scattered = {*from,
                           surface_receiver(point, surface_lobes(tree->world, point->surface)),
                           s.pdf, one_of_many};
    Branch *branch = &scattered.branch;
    branch->ray = surface_spawn(point->surface, normalize(from_local(&point->frame, s.wi)));
    branch->throughput = rgb_mul(from->throughput, s.weight);
    branch->depth += 1;
    if (s.wi.z * point->wo.z < 0) {
        medium_cross(tree->world, &branch->media, point->surface);
    }
    add_hit_lights(tree, &scattered);
}

static void add_direct(Tree *tree, const Branch *branch, const ShadingPoint *point)
{
    const LightSet *lights = tree->world->lights;
    int sized = count_sized(tree->world);
    bool one_of_many = sized > MAX_SIZED;
    for (size_t i = 0; i < light_set_count(lights); ++i) {
        const Light *light = light_set_get(lights, i);
        if (!has_size(light) || (!one_of_many && light->power > 0)) {
            add_light(tree, branch, point, light, 1);
        }
    }
    if (sized == 0) {
        return;
    }
    if (one_of_many) {
        float chance;
        double number = sampler_1d_fine(tree->sampler);
        LightReceiver receiver =
            surface_receiver(point, surface_lobes(tree->world, point->surface));
        uint32_t index = light_choose(lights, &receiver, number, &chance);
        if (index != NONE_ID && has_size(light_set_get(lights, index))) {
            add_light(tree, branch, point, light_set_get(lights, index), chance);
        }
    }
    add_scattered(tree, branch, point, one_of_many);
}

// --- The tree ------------------------------------------------------------------------------------

static void follow(Tree *tree, Branch *branch, AovSample *aov)
{
    const World *world = tree->world;
    SurfaceHit at;
    if (!meet(world, branch, tree->stats, &at)) {
        add_radiance(tree, branch, world_escaped(world, branch->ray.direction), branch->depth);
        return;
    }
    if (aov) {
        aov_fill(&at.hit, &at.point, aov);
    }
    add_radiance(tree, branch, surface_emitted(world, &branch->ray, &at), branch->depth);
    uint32_t lobes = surface_lobes(world, &at.surface);
    if (lobes & LOBE_PASS) {
        follow_pass(tree, branch, &at.surface);
    }
    if (branch->depth >= world->bounces) {
        return;
    }
    if (lobes & LOBE_SMOOTH) {
        add_direct(tree, branch, &at.point);
    }
    if (lobes & LOBE_DELTA) {
        follow_deltas(tree, branch, &at.point);
    }
}

static Rgb radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                    IntegratorStats *stats)
{
    Tree tree;
    tree.world = world;
    tree.sampler = sampler;
    tree.stats = stats;
    tree.radiance = rgb_gray(0);
    tree.count = 0;
    Branch root = {
        .ray = *ray, .throughput = rgb_gray(1), .squeeze = 1, .media = world->camera_media};
    follow(&tree, &root, aov);
    while (tree.count > 0) {
        Branch branch = tree.waiting[--tree.count];
        follow(&tree, &branch, NULL);
    }
    return tree.radiance;
}

const IntegratorClass direct_integrator = {
    .name = "direct",
    .doc = "The classical ray tracer: direct light, and mirrors and refraction followed up to "
           "`bounces`, without light that reaches a surface by way of others (glass casts "
           "shadows). At glass both the "
           "reflected and the refracted ray are followed, and every light is added, so that a "
           "scene without area lights, surroundings and the like has no noise but the pixel "
           "filter's. Rays that carry less than a ten-thousandth of a pixel's light are cut off. "
           "Of more than 16 lights with a size one is chosen at each surface.",
    .example =
        "render { integrator: \"direct\" }\n"
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
