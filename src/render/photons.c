#include "render/photons.h"

#include "base/mem.h"
#include "render/casters.h"
#include "render/disc.h"
#include "render/distribution.h"
#include "render/integrators/surface_hit.h"
#include "render/light_report.h"

#include <stdlib.h>

// Casters that are known one by one; beyond, none is traced. Groups of them at which photons are
// aimed; of all lights together, about.
enum { MOST_CASTERS = 1 << 22, MOST_GROUPS = 32, MOST_PAIRS = 1 << 16 };
// The part of photons that is spread evenly over lights and groups of casters.
#define EVEN_PART 0.1
// With which chance a photon on something matt is seen by the camera, and ends, or else goes on.
#define SEEN_PART 0.8F
// Numbers of the sampler: for the start, and for each surface.
enum { START_DIMENSIONS = 8, SURFACE_DIMENSIONS = 4 };

typedef struct Group {
    Vec3 center;
    double radius;
} Group;

struct Photons {
    const World *world;
    Arena arena;
    Group *groups;
    uint32_t group_count;
    uint32_t *lights; // that are traced
    uint32_t light_count;
    bool *traced;     // by light
    bool *in_media;   // by light that is traced: may begin within a medium
    AliasTable pairs; // of one of `lights` and a group, light by light
    bool unbounded;   // there are shapes beyond which light at infinity begins
};

// --- Groups of casters ---------------------------------------------------------------------------

typedef struct Part {
    Caster *items;
    size_t count;
    Group group;
} Part;

static Part part_of(Caster *items, size_t count)
{
    Box3 box = box3_empty();
    for (size_t i = 0; i < count; ++i) {
        const Vec3 r = vec3(items[i].radius, items[i].radius, items[i].radius);
        box = box3_union(box, (Box3){sub(items[i].center, r), add(items[i].center, r)});
    }
    Part part = {items, count, {count == 1 ? items->center : box3_center(box), 0}};
    for (size_t i = 0; i < count; ++i) {
        const double far = length(sub(items[i].center, part.group.center)) + items[i].radius;
        part.group.radius = fmax(part.group.radius, far * (1 + 1e-9));
    }
    return part;
}

static int compare_along(const Caster *a, const Caster *b, int axis)
{
    const double x = vec3_get(a->center, axis), y = vec3_get(b->center, axis);
    // Equal ones by their numbers, so that the order is one.
    return x != y                       ? (x < y ? -1 : 1)
           : a->shape != b->shape       ? (a->shape < b->shape ? -1 : 1)
           : a->instance != b->instance ? (a->instance < b->instance ? -1 : 1)
                                        : 0;
}
static int compare_x(const void *a, const void *b)
{
    return compare_along(a, b, 0);
}
static int compare_y(const void *a, const void *b)
{
    return compare_along(a, b, 1);
}
static int compare_z(const void *a, const void *b)
{
    return compare_along(a, b, 2);
}

// The two halves of the casters of a part.
static void split(Part *part, Part *second)
{
    static int (*const compare[])(const void *, const void *) = {compare_x, compare_y, compare_z};
    Box3 box = box3_empty();
    for (size_t i = 0; i < part->count; ++i) {
        box = box3_add(box, part->items[i].center);
    }
    const Vec3 size = sub(box.max, box.min);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    qsort(part->items, part->count, sizeof *part->items, compare[axis]);
    const size_t half = part->count / 2;
    *second = part_of(part->items + half, part->count - half);
    *part = part_of(part->items, half);
}

// The widest group is halved until there are enough.
static bool make_groups(Photons *p, CasterArray *casters, uint32_t most)
{
    Part parts[MOST_GROUPS] = {part_of(casters->items, casters->count)};
    uint32_t count = 1;
    while (count < most) {
        uint32_t widest = 0;
        double radius = 0;
        for (uint32_t i = 0; i < count; ++i) {
            if (parts[i].count > 1 && parts[i].group.radius > radius) {
                radius = parts[i].group.radius;
                widest = i;
            }
        }
        if (!(radius > 0)) {
            break;
        }
        split(&parts[widest], &parts[count++]);
    }
    p->groups = arena_array(&p->arena, count, sizeof *p->groups);
    for (uint32_t i = 0; p->groups && i < count; ++i) {
        p->groups[i] = parts[i].group;
    }
    p->group_count = count;
    return p->groups;
}

// --- Lights --------------------------------------------------------------------------------------

// Whether photons can leave a light; what falls off unnaturally with distance isn't made of them.
static bool is_traceable(const World *world, const Light *light)
{
    LightOrigin origin;
    return light->class->begin && light->power > 0 && light->power < INFINITY &&
           light_is_natural(world->scene, light) &&
           light->class->begin(world, light, 0.5, 0.5, 0.5, &origin);
}

static bool boxes_meet(Box3 a, Box3 b)
{
    return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y &&
           a.min.z <= b.max.z && b.min.z <= a.max.z;
}

static bool list_lights(Photons *p)
{
    const World *world = p->world;
    const size_t count = light_set_count(world->lights);
    p->lights = arena_array(&p->arena, count + 1, sizeof *p->lights);
    p->traced = arena_array(&p->arena, count + 1, sizeof *p->traced);
    p->in_media = arena_array(&p->arena, count + 1, sizeof *p->in_media);
    if (!p->lights || !p->traced || !p->in_media) {
        return false;
    }
    for (uint32_t i = 0; i < count; ++i) {
        const Light *light = light_set_get(world->lights, i);
        p->traced[i] = is_traceable(world, light);
        if (p->traced[i]) {
            p->in_media[p->light_count] = world->media && !light->class->infinite;
            p->lights[p->light_count++] = i;
        }
    }
    return true;
}

// Bodies of media are casters, or rough: only what lies beside all of them surely begins outside.
static void find_lights_in_media(Photons *p, const CasterArray *casters)
{
    const World *world = p->world;
    for (uint32_t m = 0; m < world->material_count; ++m) {
        const WorldMaterial *material = &world->materials[m];
        if (material->medium && !(material->lobes & LOBE_DELTA)) {
            return;
        }
    }
    for (uint32_t l = 0; l < p->light_count; ++l) {
        const Light *light = light_set_get(world->lights, p->lights[l]);
        bool near = false;
        for (size_t i = 0; i < casters->count && !near; ++i) {
            near = boxes_meet(light->bounds, casters->items[i].box);
        }
        p->in_media[l] &= near;
    }
}

// About the light that goes to a group.
static double pair_weight(const Light *light, const Group *group)
{
    const double r2 = group->radius * group->radius;
    if (light->class->infinite) {
        return light->intensity * PI * r2;
    }
    const double d2 = length_squared(sub(group->center, box3_center(light->bounds)));
    const double s2 = r2 / fmax(d2, 1e-300);
    const double angle = s2 < 1 ? 2 * PI * s2 / (1 + sqrt(1 - s2)) : 4 * PI;
    return light->intensity * angle;
}

static bool make_pairs(Photons *p)
{
    const uint32_t count = p->light_count * p->group_count;
    double *weights = mem_alloc(count, sizeof *weights), total = 0;
    if (!weights) {
        return false;
    }
    for (uint32_t i = 0; i < count; ++i) {
        const Light *light = light_set_get(p->world->lights, p->lights[i / p->group_count]);
        weights[i] = pair_weight(light, &p->groups[i % p->group_count]);
        total += weights[i];
    }
    for (uint32_t i = 0; i < count; ++i) {
        weights[i] = total > 0 ? weights[i] + EVEN_PART * total / count : 1;
    }
    const bool good = alias_table_build(&p->pairs, &p->arena, weights, count);
    mem_free(weights);
    return good;
}

static bool has_unbounded(const World *world)
{
    const Scene *scene = world->scene;
    for (uint32_t s = 0; s < scene->nodes[CATEGORY_SHAPE].count; ++s) {
        if (!caster_is_bounded(world, s)) {
            return true;
        }
    }
    return false;
}

// True if all went well; p->group_count is 0 where there is nothing to trace.
static bool prepare(Photons *p, CasterArray *casters)
{
    bool all;
    if (!(p->world->all_lobes & LOBE_DELTA)) {
        return true;
    }
    if (!list_lights(p) || !casters_find(p->world, MOST_CASTERS, casters, &all)) {
        return false;
    }
    if (!all || casters->count == 0 || p->light_count == 0 || p->light_count > MOST_PAIRS) {
        return true;
    }
    const uint32_t share = MOST_PAIRS / p->light_count;
    find_lights_in_media(p, casters);
    p->unbounded = has_unbounded(p->world);
    return make_groups(p, casters, share < MOST_GROUPS ? share : MOST_GROUPS) && make_pairs(p);
}

bool photons_new(const World *world, Photons **out)
{
    CasterArray casters = {0};
    Photons *p = mem_alloc_zeroed(1, sizeof *p);
    *out = NULL;
    if (!p) {
        return false;
    }
    p->world = world;
    const bool good = prepare(p, &casters);
    array_free(&casters);
    if (good && p->group_count > 0) {
        *out = p;
    } else {
        photons_free(p);
    }
    return good;
}

void photons_free(Photons *photons)
{
    if (photons) {
        arena_free(&photons->arena);
        mem_free(photons);
    }
}

const bool *photons_of_lights(const Photons *photons)
{
    return photons->traced;
}

// --- Leaving a light -----------------------------------------------------------------------------

typedef struct Photon {
    Ray ray;
    Rgb flux; // over the density with which it was chosen
    MediumStack media;
    int64_t scatterings;
} Photon;

// The directions from a point to a group: 1 - cos θ is at most `rise` about the axis.
typedef struct Cone {
    Vec3 axis;
    double rise;
} Cone;

static Cone cone_to(const Group *group, Vec3 from)
{
    const Vec3 to = sub(group->center, from);
    const double d2 = length_squared(to), s2 = group->radius * group->radius / d2;
    if (!(s2 < 1)) {
        return (Cone){vec3(0, 0, 1), 2};
    }
    return (Cone){scale(to, 1 / sqrt(d2)), s2 / (1 + sqrt(1 - s2))};
}

static Vec3 cone_sample(const Cone *cone, float u, float v)
{
    const Vec2 disc = sample_disc(u, v);
    const double r2 = disc.x * disc.x + disc.y * disc.y, height = cone->rise * r2;
    const double spread = r2 > 0 ? sqrt(height * (2 - height) / r2) : 0;
    const Frame frame = frame_from_normal(cone->axis);
    return normalize(from_local(&frame, vec3(disc.x * spread, disc.y * spread, 1 - height)));
}

static bool cone_holds(const Cone *cone, Vec3 direction)
{
    return length_squared(sub(direction, cone->axis)) / 2 <= cone->rise;
}

// The density, over solid angle or area, with which a ray of light number l is chosen; `chosen` is
// the group that it was aimed at.
static double density_towards(const Photons *p, uint32_t l, uint32_t chosen, Vec3 from,
                              Vec3 direction)
{
    double density = 0;
    for (uint32_t g = 0; g < p->group_count; ++g) {
        const Cone cone = cone_to(&p->groups[g], from);
        if (g == chosen || cone_holds(&cone, direction)) {
            const double chance = (double)p->pairs.chance[l * p->group_count + g];
            density += chance / (2 * PI * cone.rise);
        }
    }
    return density;
}

static double density_along(const Photons *p, uint32_t l, uint32_t chosen, Vec3 through,
                            Vec3 direction)
{
    double density = 0;
    for (uint32_t g = 0; g < p->group_count; ++g) {
        const double r2 = p->groups[g].radius * p->groups[g].radius;
        const Vec3 to = sub(p->groups[g].center, through);
        if (g == chosen || length_squared(cross(to, direction)) <= r2) {
            density += (double)p->pairs.chance[l * p->group_count + g] / (PI * r2);
        }
    }
    return density;
}

// The numbers of a photon's start.
typedef struct StartNumbers {
    float aim_u, aim_v, u, v, pair, part, lens_u, lens_v;
} StartNumbers;

static bool leave_infinite(const Photons *p, uint32_t l, uint32_t g, const LightOrigin *origin,
                           const StartNumbers *n, IntegratorStats *stats, Photon *out)
{
    const World *world = p->world;
    const Group *group = &p->groups[g];
    const Frame frame = frame_from_normal(origin->direction);
    const Vec2 disc = sample_disc(n->aim_u, n->aim_v);
    const Vec3 across = vec3(disc.x * group->radius, disc.y * group->radius, 0);
    const Vec3 through = add(group->center, from_local(&frame, across));
    const Box3 bounds = accel_bounds(world->accel);
    const double back = length(sub(through, box3_center(bounds))) + 2 * world_radius(world);
    const Vec3 start = add_scaled(through, origin->direction, -back);
    out->ray = ray_make(start, origin->direction, 0, INFINITY);
    const double density = density_along(p, l, g, through, origin->direction) * origin->pdf;
    out->flux = rgb_scale(out->flux, (float)(1 / density));
    if (p->unbounded) {
        const Ray behind = ray_make(start, neg(origin->direction), 0, INFINITY);
        ++stats->shadow_rays;
        out->flux = rgb_mul(out->flux, world_visibility(world, &behind));
    }
    return true;
}

static void leave_surface(const LightOrigin *origin, Vec3 direction, Photon *out)
{
    const ShapePoint *point = &origin->surface.point;
    const Surface surface = {
        .p = point->p, .geometric = point->geometric, .error = point->error, .instance = NONE_ID};
    out->ray = surface_spawn(&surface, direction);
}

static bool leave(const Photons *p, const StartNumbers *n, double pair, IntegratorStats *stats,
                  Photon *out)
{
    const World *world = p->world;
    const uint32_t chosen = alias_table_choose(&p->pairs, pair);
    const uint32_t l = chosen / p->group_count, g = chosen % p->group_count;
    const Light *light = light_set_get(world->lights, p->lights[l]);
    LightOrigin origin;
    if (!light->class->begin(world, light, (double)n->u, (double)n->v, (double)n->part, &origin)) {
        return false;
    }
    out->scatterings = 0;
    out->media.count = 0;
    if (origin.infinite) {
        out->flux = light->class->leaving(world, light, &origin, origin.direction);
        return leave_infinite(p, l, g, &origin, n, stats, out) && !rgb_is_black(out->flux);
    }
    const Vec3 from = origin.surface.point.p;
    const Cone cone = cone_to(&p->groups[g], from);
    const Vec3 direction = cone_sample(&cone, n->aim_u, n->aim_v);
    const double density = density_towards(p, l, g, from, direction) * origin.pdf;
    out->flux =
        rgb_scale(light->class->leaving(world, light, &origin, direction), (float)(1 / density));
    if (rgb_is_black(out->flux)) {
        return false;
    }
    if (p->in_media[l]) {
        out->media = medium_around(world, from);
    }
    if (origin.point) {
        out->ray = ray_make(from, direction, 0, INFINITY);
    } else {
        leave_surface(&origin, direction, out);
    }
    return true;
}

// --- On the way ----------------------------------------------------------------------------------

// Takes a direction that was chosen by a delta lobe. What is carried is flux, not radiance: it
// isn't squeezed in glass, and it is the geometric normal's cosines that count (Veach 1997, 5.3.2).
// The normal h by which the direction was chosen, of a map perhaps, follows from the directions.
static double delta_adjoint(const ShadingPoint *point, const BsdfSample *s, bool exact)
{
    const double eta = (double)s->eta;
    const bool crosses = s->wi.z * point->wo.z < 0;
    const Vec3 h = crosses ? add_scaled(point->wo, s->wi, eta) : add(point->wo, s->wi);
    const double out_h = fabs(dot(s->wi, h)), in_h = fabs(dot(point->wo, h));
    const double out_g = fabs(dot(s->wi, point->geometric)), in_g = fabs(point->wo_side);
    if (exact) {
        return eta * eta;
    }
    return in_g > 0 && out_h > 0 ? eta * eta * in_h * out_g / (in_g * out_h) : 0;
}

// The weight of a photon that comes along `in` and leaves towards `out` (both unit, in the world):
// the scattering is what a path sees that looks against it, flux over area that of the geometric
// normal. Without the density of `out`.
static Rgb smooth_adjoint(const World *world, const Surface *at, const WorldMaterial *material,
                          double outside, Vec3 in, Vec3 out, Vec3 *wi, bool *crosses)
{
    Surface surface = *at;
    surface.front = dot(out, surface.geometric) > 0;
    ShadingPoint point;
    shading_point(world, &surface, neg(out), &point);
    point.outside = outside;
    *wi = to_local(&point.frame, neg(in));
    *crosses = wi->z * point.wo.z < 0;
    BsdfEval bsdf;
    material_evaluate(&point, material, *wi, &bsdf);
    const double arriving = fabs(dot(in, surface.geometric));
    const double leaving = fabs(dot(out, surface.geometric));
    return arriving > 0 ? rgb_scale(bsdf.value, (float)(leaving / arriving)) : rgb_gray(0);
}

// Scatters a photon; false where it isn't.
static bool go_on(const World *world, const Surface *surface, const WorldMaterial *material,
                  double outside, const float numbers[SURFACE_DIMENSIONS], Photon *photon)
{
    ShadingPoint point;
    shading_point(world, surface, photon->ray.direction, &point);
    point.outside = outside;
    BsdfSample s;
    if (!material_choose(&point, material, numbers[2], numbers[0], numbers[1], &s)) {
        return false;
    }
    if (s.lobes & LOBE_PASS) {
        photon->flux = rgb_mul(photon->flux, s.weight);
        photon->ray = surface_spawn(surface, photon->ray.direction);
        return true;
    }
    const bool delta = s.lobes & material->lobes & LOBE_DELTA;
    if (photon->scatterings == 0 && !(delta && caster_is_bounded(world, surface->shape))) {
        return false;
    }
    const Vec3 direction = renormalize(from_local(&point.frame, s.wi));
    bool crosses = s.wi.z * point.wo.z < 0;
    Rgb weight;
    if (s.lobes & LOBE_DELTA) {
        // As the path tracer, which would look from the other side: no light from behind the
        // shading normal.
        const Vec3 back = neg(photon->ray.direction);
        if (surface->bent && dot(back, surface->shading) * dot(back, surface->geometric) <= 0) {
            return false;
        }
        const bool exact = !point.bent && !surface->bent && !material->whole;
        weight = rgb_scale(s.weight, (float)delta_adjoint(&point, &s, exact));
    } else {
        Vec3 wi;
        weight = smooth_adjoint(world, surface, material, outside, photon->ray.direction, direction,
                                &wi, &crosses);
        weight = rgb_scale(weight, 1 / s.pdf);
    }
    if (crosses && world->media) {
        medium_cross(world, &photon->media, surface);
    }
    ++photon->scatterings;
    photon->flux = rgb_mul(photon->flux, weight);
    photon->ray = surface_spawn(surface, direction);
    return !rgb_is_black(photon->flux);
}

// The camera's side of a photon that has come to a surface: the last scattering.
static bool is_seen(const World *world, const PhotonFilm *film, const Surface *at,
                    const WorldMaterial *material, double outside, const Photon *photon,
                    const StartNumbers *n, IntegratorStats *stats, PhotonSplat *out)
{
    CameraView view;
    if (!camera_view(film->camera, at->p, n->lens_u, n->lens_v, &view) ||
        !(fabs(view.x - 0.5) <= 0.5 + film->margin_x) ||
        !(fabs(view.y - 0.5) <= 0.5 + film->margin_y)) {
        return false;
    }
    Vec3 wi;
    bool crosses;
    const Rgb scattered = smooth_adjoint(world, at, material, outside, photon->ray.direction,
                                         view.direction, &wi, &crosses);
    if (rgb_is_black(scattered)) {
        return false;
    }
    MediumStack media = photon->media;
    if (world->media && crosses) {
        medium_cross(world, &media, at);
    }
    const Ray ray = surface_spawn_to(at, view.from, view.distance, 0, 0);
    ++stats->shadow_rays;
    const Rgb visible = medium_visibility(world, &media, &ray);
    out->x = view.x;
    out->y = view.y;
    out->light =
        rgb_scale(rgb_mul(rgb_mul(photon->flux, scattered), visible), (float)view.film_area);
    if (!rgb_is_finite(out->light)) {
        ++stats->bad_samples;
        return false;
    }
    return !rgb_is_black(out->light);
}

bool photon_trace(const Photons *p, const PhotonFilm *film, Sampler *sampler,
                  IntegratorStats *stats, PhotonSplat *out)
{
    const World *world = p->world;
    const float *first = sampler_eight(sampler, 0);
    const StartNumbers n = {first[0], first[1], first[2], first[3],
                            first[4], first[5], first[6], first[7]};
    Photon photon;
    if (!leave(p, &n, (double)n.pair + sampler_finer(sampler, 4), stats, &photon)) {
        return false;
    }
    for (int64_t i = 0; i < world->bounces + MAX_PASSES; ++i) {
        Hit hit;
        ++stats->rays;
        if (!accel_intersect(world->accel, &photon.ray, &hit)) {
            return false;
        }
        Surface surface;
        accel_surface_plain(world->accel, &photon.ray, &hit, &surface);
        double outside;
        if (surface_reach(world, &photon.media, &surface, hit.t, &photon.flux, &outside)) {
            photon.ray = surface_spawn(&surface, photon.ray.direction);
            continue;
        }
        // The last scattering is what the camera sees.
        if (photon.scatterings >= world->bounces || rgb_is_black(photon.flux)) {
            return false;
        }
        const WorldMaterial *material = world_material(world, surface.material);
        if (material->whole) {
            accel_surface(world->accel, &photon.ray, &hit, &surface);
        }
        float numbers[SURFACE_DIMENSIONS];
        sampler_seek(sampler, START_DIMENSIONS + (uint32_t)i * SURFACE_DIMENSIONS);
        for (int k = 0; k < SURFACE_DIMENSIONS; ++k) {
            numbers[k] = sampler_1d(sampler);
        }
        if ((material->lobes & LOBE_SMOOTH) && photon.scatterings > 0) {
            const bool seen = numbers[3] < SEEN_PART;
            photon.flux = rgb_scale(photon.flux, 1 / (seen ? SEEN_PART : 1 - SEEN_PART));
            if (seen) {
                return is_seen(world, film, &surface, material, outside, &photon, &n, stats, out);
            }
        }
        if (!go_on(world, &surface, material, outside, numbers, &photon)) {
            return false;
        }
    }
    return false;
}
