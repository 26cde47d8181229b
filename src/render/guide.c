#include "render/guide.h"

#include "base/hash.h"
#include "base/mem.h"
#include "render/casters.h"
#include "render/shape.h"
#include "render/world.h"

// Rays from lamps; scatterings of one at mirrors and glass; notes in a cell, at most, and in all,
// at least.
enum { RAYS = 1 << 16, MOST_SCATTERINGS = 8, CELL = 8, FEWEST = 64 };
// Lamps that are seen under more than this, in sr, are found without help.
#define WIDE_LAMP 0.2
// Radii of lobes, over the distance of notes; and as angles.
#define SPREAD   2
#define SHARPEST 0.004
#define WIDEST   0.5

// --- Lobes ---------------------------------------------------------------------------------------
//
// Cauchy's distribution on the sphere (Kato and McCullagh 2020): its density
//
//     (1 - r²)² / (4π (1 + r² - 2 r cos θ)²)
//
// falls off slowly, so that what lies beside all lobes isn't left to luck again; and it is inverted
// in closed form.

typedef struct GuideLobe {
    Vec3 p, at;    // where the light came to rest, and what is aimed at
    double radius; // about it, on the way there
    double chance; // to be chosen, within the cell
} GuideLobe;

struct GuideCell {
    uint32_t count;
    double near2; // squared
    GuideLobe lobes[CELL];
};

// The chances of the lobes at p: the nearer the note, the more.
static void chances(const GuideCell *cell, Vec3 p, double out[CELL])
{
    double total = 0;
    for (uint32_t i = 0; i < cell->count; ++i) {
        const GuideLobe *lobe = &cell->lobes[i];
        out[i] = lobe->chance / (length_squared(sub(p, lobe->p)) + cell->near2);
        total += out[i];
    }
    for (uint32_t i = 0; i < cell->count; ++i) {
        out[i] /= total;
    }
}

typedef struct Aim {
    Vec3 axis;
    double r, one_minus_r;
} Aim;

static Aim aim_of(const GuideLobe *lobe, Vec3 p)
{
    const Vec3 to = sub(lobe->at, p);
    const double distance = length(to);
    Aim aim = {.axis = vec3(0, 1, 0), .one_minus_r = WIDEST};
    if (distance > 0) {
        aim.axis = scale(to, 1 / distance);
        aim.one_minus_r = smaller(larger(lobe->radius / distance, SHARPEST), WIDEST);
    }
    aim.r = 1 - aim.one_minus_r;
    return aim;
}

static double lobe_pdf(const Aim *aim, Vec3 direction)
{
    const double one_minus_cos = length_squared(sub(direction, aim->axis)) / 2;
    const double e = aim->one_minus_r, r = aim->r, top = e * (1 + r);
    const double below = e * e + 2 * r * one_minus_cos;
    const double root = top / below;
    return root * root / (4 * PI);
}

static Vec3 lobe_sample(const Aim *aim, double u, double v)
{
    const double e = aim->one_minus_r, r = aim->r, top = e * (1 + r);
    const double below = 1 / (1 / (e * e) - 4 * r * u / (top * top));
    const double one_minus_cos = smaller(larger((below - e * e) / (2 * r), 0), 2);
    const double sine = sqrt(one_minus_cos * (2 - one_minus_cos)), phi = 2 * PI * v;
    const Frame frame = frame_from_normal(aim->axis);
    const Vec3 local = vec3(sine * cos(phi), sine * sin(phi), 1 - one_minus_cos);
    return normalize(from_local(&frame, local));
}

Vec3 guide_sample(const GuideCell *cell, Vec3 p, float choice, float u, float v)
{
    double chance[CELL], rest = (double)choice;
    uint32_t i = 0;
    chances(cell, p, chance);
    while (i + 1 < cell->count && rest >= chance[i]) {
        rest -= chance[i++];
    }
    const Aim aim = aim_of(&cell->lobes[i], p);
    return lobe_sample(&aim, (double)u, (double)v);
}

float guide_pdf(const GuideCell *cell, Vec3 p, Vec3 direction)
{
    double pdf = 0, chance[CELL];
    chances(cell, p, chance);
    for (uint32_t i = 0; i < cell->count; ++i) {
        const Aim aim = aim_of(&cell->lobes[i], p);
        pdf += chance[i] * lobe_pdf(&aim, direction);
    }
    return (float)pdf;
}

// --- Rays from lamps -----------------------------------------------------------------------------

typedef struct Note {
    Vec3 p, from;  // where light came to rest, and the last mirror or glass before
    double weight; // about its flux
} Note;

typedef struct GuideBuilder {
    const World *world;
    CasterArray casters;
    Note *notes;
    uint32_t count;
    uint32_t random;
} GuideBuilder;

static float draw(GuideBuilder *b)
{
    b->random = hash_u32(b->random + 0x9e3779b9U);
    return hash_to_float(b->random);
}

// How long the line through q in direction d is within a box.
static double chord(Box3 box, Vec3 q, Vec3 d)
{
    double from = -INFINITY, to = INFINITY;
    for (int axis = 0; axis < 3; ++axis) {
        const double along = vec3_get(d, axis), at = vec3_get(q, axis);
        if (fabs(along) < 1e-12) {
            continue;
        }
        const double a = (vec3_get(box.min, axis) - at) / along;
        const double c = (vec3_get(box.max, axis) - at) / along;
        from = larger(from, smaller(a, c));
        to = smaller(to, larger(a, c));
    }
    return larger(to - from, 0);
}

// A ray from a lamp through a point of a caster's box; *weight is about its flux.
static bool send(GuideBuilder *b, const Caster *caster, Ray *ray, double *weight)
{
    const World *world = b->world;
    const Vec3 size = sub(caster->box.max, caster->box.min);
    const double x = (double)draw(b), y = (double)draw(b), z = (double)draw(b);
    const Vec3 q = add(caster->box.min, vec3(x * size.x, y * size.y, z * size.z));
    const LightReceiver at = {.p = q};
    float chance;
    const uint32_t index = light_choose(world->lights, &at, (double)draw(b), &chance);
    if (index == NONE_ID) {
        return false;
    }
    const Light *light = light_set_get(world->lights, index);
    LightSample s;
    const double u0 = (double)draw(b), u1 = (double)draw(b), u2 = (double)draw(b);
    // A lamp without size is found by no ray, and so not by way of glass.
    if (!light->class->sample(world, light, q, u0, u1, u2, &s) || s.delta ||
        !(s.pdf * (float)WIDE_LAMP > 1)) {
        return false;
    }
    const double away = s.distance < INFINITY
                            ? s.distance * (1 - 1e-6)
                            : 2 * world_radius(world) + length(sub(q, caster->box.min));
    *ray = ray_make(add_scaled(q, s.direction, away), neg(s.direction), 0, INFINITY);
    *weight = (double)luminance(s.value) * size.x * size.y * size.z /
              (chord(caster->box, q, s.direction) * (double)(s.pdf * chance));
    return *weight > 0 && *weight < INFINITY;
}

bool guide_serves(uint32_t lobes)
{
    return (lobes & (LOBE_SMOOTH | LOBE_DELTA | LOBE_TRANSMIT | LOBE_PASS)) == LOBE_SMOOTH;
}

static void follow(GuideBuilder *b, const Caster *caster, Ray ray, double weight)
{
    const World *world = b->world;
    Vec3 from = ray.origin;
    for (int i = 0; i <= MOST_SCATTERINGS; ++i) {
        Hit hit;
        if (!accel_intersect(world->accel, &ray, &hit)) {
            return;
        }
        Surface surface;
        accel_surface(world->accel, &ray, &hit, &surface);
        if (i == 0 && (surface.shape != caster->shape || surface.instance != caster->instance)) {
            return;
        }
        const WorldMaterial *material = world_material(world, surface.material);
        if (guide_serves(material->lobes)) {
            if (i > 0 && weight > 0 && weight < INFINITY) {
                b->notes[b->count++] = (Note){surface.p, from, weight};
            }
            return;
        }
        ShadingPoint point;
        shading_point(world, &surface, ray.direction, &point);
        BsdfSample s;
        // What is reflected is faint, but as hard to find: it is followed more often than it
        // would be by its part.
        const float number = draw(b), lobe = number * number, u = draw(b), v = draw(b);
        if (!material_choose(&point, material, lobe, u, v, &s) || !(s.lobes & LOBE_DELTA)) {
            return;
        }
        const float taken = s.pdf < 0.5F ? sqrtf(s.pdf) : 1 - sqrtf(fmaxf(1 - s.pdf, 0));
        weight *= (double)(luminance(s.weight) * s.pdf / fmaxf(taken, 0.01F));
        from = surface.p;
        ray = surface_spawn(&surface, renormalize(from_local(&point.frame, s.wi)));
    }
}

// --- Cells ---------------------------------------------------------------------------------------

// A tree that halves the notes: the first child follows its parent.
typedef struct GuideNode {
    double split;
    uint32_t second; // child
    int axis;        // -1: a cell, number `second`
} GuideNode;

struct Guide {
    Box3 box;
    GuideNode *nodes;
    GuideCell *cells;
    uint32_t node_count, cell_count;
};

static void swap(Note *a, Note *b)
{
    const Note note = *a;
    *a = *b;
    *b = note;
}

// Brings the notes of lesser coordinate into the first half: quickselect (Hoare 1961), in three
// parts, since many notes may lie in one plane.
static void halve(Note *notes, uint32_t count, int axis)
{
    const uint32_t middle = count / 2;
    uint32_t low = 0, high = count;
    while (high - low > 1) {
        const double pivot = vec3_get(notes[low + (high - low) / 2].p, axis);
        uint32_t less = low, more = high;
        for (uint32_t i = low; i < more;) {
            const double x = vec3_get(notes[i].p, axis);
            if (x < pivot) {
                swap(&notes[less++], &notes[i++]);
            } else if (x > pivot) {
                swap(&notes[i], &notes[--more]);
            } else {
                ++i;
            }
        }
        if (middle >= less && middle < more) {
            return;
        }
        *(middle < less ? &high : &low) = middle < less ? less : more;
    }
}

// How far apart on the glass notes are that are next to each other where light comes to rest: so
// wide a lobe has to be. The lesser of two, since light comes by several ways.
static double spread(const Note *notes, uint32_t count, uint32_t of)
{
    uint32_t next[2] = {of, of};
    double d2[2] = {INFINITY, INFINITY};
    for (uint32_t i = 0; i < count; ++i) {
        const double d = length_squared(sub(notes[i].p, notes[of].p));
        if (i == of || d >= d2[1]) {
            continue;
        }
        const bool nearest = d < d2[0];
        next[1] = nearest ? next[0] : i;
        d2[1] = nearest ? d2[0] : d;
        next[0] = nearest ? i : next[0];
        d2[0] = nearest ? d : d2[0];
    }
    const double a = length(sub(notes[next[0]].from, notes[of].from));
    const double b = length(sub(notes[next[1]].from, notes[of].from));
    return SPREAD * (next[1] == of ? a : smaller(a, b));
}

static Box3 box_of(const Note *notes, uint32_t count)
{
    Box3 box = box3_empty();
    for (uint32_t i = 0; i < count; ++i) {
        box = box3_add(box, notes[i].p);
    }
    return box;
}

static void make_cell(GuideCell *cell, const Note *notes, uint32_t count)
{
    double total = 0;
    for (uint32_t i = 0; i < count; ++i) {
        total += notes[i].weight;
    }
    const Box3 box = box_of(notes, count);
    cell->count = count;
    // A small part of the cell; never nothing.
    cell->near2 = 0.1 * length_squared(sub(box.max, box.min)) / (double)count + 1e-300;
    for (uint32_t i = 0; i < count; ++i) {
        // Half evenly: what a note weighs says little about its neighbours.
        cell->lobes[i] = (GuideLobe){notes[i].p, notes[i].from, spread(notes, count, i),
                                     0.5 / count + 0.5 * notes[i].weight / total};
    }
}

static void make_node(Guide *guide, Note *notes, uint32_t count)
{
    const uint32_t number = guide->node_count++;
    if (count <= CELL) {
        guide->nodes[number] = (GuideNode){0, guide->cell_count, -1};
        make_cell(&guide->cells[guide->cell_count++], notes, count);
        return;
    }
    const Box3 box = box_of(notes, count);
    const Vec3 size = sub(box.max, box.min);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const uint32_t half = count / 2;
    halve(notes, count, axis);
    const double split = vec3_get(notes[half].p, axis);
    make_node(guide, notes, half);
    guide->nodes[number] = (GuideNode){split, guide->node_count, axis};
    make_node(guide, notes + half, count - half);
}

static bool make_guide(Arena *arena, Note *notes, uint32_t count, Guide *guide)
{
    // Each cell holds at least half of what it can, or it would not have been made.
    const size_t cells = 2 * (size_t)count / CELL + 2;
    guide->nodes = arena_array(arena, 2 * cells, sizeof *guide->nodes);
    guide->cells = arena_array(arena, cells, sizeof *guide->cells);
    if (!guide->nodes || !guide->cells) {
        return false;
    }
    const Box3 box = box_of(notes, count);
    const double more = 0.05 * max_component(sub(box.max, box.min));
    guide->box.min = sub(box.min, vec3(more, more, more));
    guide->box.max = add(box.max, vec3(more, more, more));
    make_node(guide, notes, count);
    return true;
}

static void send_all(GuideBuilder *b)
{
    for (uint32_t i = 0; i < RAYS; ++i) {
        const Caster *caster = &b->casters.items[(uint64_t)i * b->casters.count / RAYS];
        Ray ray;
        double weight;
        if (send(b, caster, &ray, &weight)) {
            follow(b, caster, ray, weight);
        }
    }
}

bool guide_build(const World *world, Arena *arena, const Guide **out)
{
    uint32_t infinite;
    light_set_infinite(world->lights, &infinite);
    *out = NULL;
    if (!(world->all_lobes & LOBE_DELTA) || (!world->shape_lights && infinite == 0)) {
        return true;
    }
    GuideBuilder b = {.world = world};
    bool good = casters_find(world, RAYS, &b.casters, NULL);
    if (good && b.casters.count > 0) {
        b.notes = mem_alloc(RAYS, sizeof *b.notes);
        good = b.notes;
    }
    if (b.notes) {
        send_all(&b);
    }
    if (b.count >= FEWEST) {
        Guide *guide = ARENA_NEW(arena, Guide);
        good = guide && make_guide(arena, b.notes, b.count, guide);
        *out = good ? guide : NULL;
    }
    array_free(&b.casters);
    mem_free(b.notes);
    return good;
}

const GuideCell *guide_find(const Guide *guide, Vec3 p)
{
    const Box3 *box = &guide->box;
    if (p.x < box->min.x || p.y < box->min.y || p.z < box->min.z || p.x > box->max.x ||
        p.y > box->max.y || p.z > box->max.z) {
        return NULL;
    }
    uint32_t node = 0;
    while (guide->nodes[node].axis >= 0) {
        const bool second = vec3_get(p, guide->nodes[node].axis) >= guide->nodes[node].split;
        node = second ? guide->nodes[node].second : node + 1;
    }
    return &guide->cells[guide->nodes[node].second];
}
