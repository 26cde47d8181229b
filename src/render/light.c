#include "render/light.h"

#include "base/hash.h"
#include "base/mem.h"
#include "render/distribution.h"
#include "render/light_report.h"
#include "render/light_tree.h"
#include "render/lights/area_light.h"
#include "render/world.h"

#include <string.h>

// Finds the light that a (shape, instance) is: open addressing, at most half full.
typedef struct ShapeSlot {
    uint32_t shape, instance, light; // light = NONE_ID: free
} ShapeSlot;

// The part of the choices that is by power alone. It bounds the noise where the tree's guess is far
// off: in mirrors, which see other lights than the point's brightest; and by lights that don't
// fall off as the tree thinks.
#define PLAIN_PART           0.0625F
#define PLAIN_PART_UNNATURAL 0.5F

// Up to so many lights at infinity are weighed one by one for each point.
enum { FEW = 8 };

struct LightSet {
    ARRAY(Light) lights;
    uint32_t *infinite;
    uint32_t infinite_count;
    AliasTable by_power;   // over `chosen`
    uint32_t *chosen;      // lights of power > 0: those at infinity first
    uint32_t *chosen_at;   // light → place in `chosen`, or NONE_ID
    AliasTable far;        // over the first of `chosen`, those at infinity, by irradiance
    double far_irradiance; // of all of them
    LightTree tree;        // over the others
    float plain_part;      // of the choices are by power alone
    ShapeSlot *slots;      // NULL: no shape is a light
    uint32_t slot_mask;
};

static uint32_t slot_of(uint32_t shape, uint32_t instance, uint32_t mask)
{
    return hash_combine(hash_u32(shape), instance) & mask;
}

static uint32_t find_shape(const LightSet *set, uint32_t shape, uint32_t instance)
{
    for (uint32_t i = slot_of(shape, instance, set->slot_mask);; i = (i + 1) & set->slot_mask) {
        const ShapeSlot *slot = &set->slots[i];
        if (slot->light == NONE_ID || (slot->shape == shape && slot->instance == instance)) {
            return slot->light;
        }
    }
}

uint32_t light_of_surface(const World *world, const Surface *surface)
{
    const LightSet *set = world->lights;
    if (!set->slots) {
        return NONE_ID;
    }
    bool emits = world_material(world, surface->material)->lobes & LOBE_EMIT;
    return emits || surface->lamp ? find_shape(set, surface->shape, surface->instance) : NONE_ID;
}

void light_infinite_ray(const Surface *surface, const LightSample *sample, Ray *out)
{
    *out = surface_spawn(surface, sample->direction);
}

// --- Building -----------------------------------------------------------------------------------

typedef struct Builder {
    World *world;
    LightSet *set;
    Arena *arena;
    DiagSink *sink;
    bool out_of_memory;
} Builder;

static const LightCone ALL_AROUND = {{0, 0, 1}, PI, PI / 2};

static void push(Builder *b, Light light)
{
    if (b->set->lights.count >= NONE_ID || !array_push(&b->set->lights, light)) {
        b->out_of_memory = true;
    }
}

// One light of a light node, as it stands in the world or in an instance.
static void push_node(Builder *b, uint32_t id, uint32_t instance)
{
    const Scene *scene = b->world->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_LIGHT, id);
    const LightClass *class = (const LightClass *)scene_node_type(scene, node);
    Light light = {.class = class,
                   .params = scene_params(scene, node),
                   .node = id,
                   .shape = NONE_ID,
                   .instance = instance,
                   .to_world = scene->transforms.items[node->transform],
                   .bounds = box3_empty(),
                   .cone = ALL_AROUND,
                   .parts = true};
    if (instance != NONE_ID) {
        const Affine *outer = &scene->transforms.items[scene->instances.items[instance].transform];
        light.to_world = affine_multiply(outer, &light.to_world);
    }
    if (class == &area_light_light) {
        light.shape = ((const AreaLight *)light.params)->shape;
        light.to_world = accel_to_world(b->world->accel, light.shape, instance);
    }
    push(b, light);
}

static void push_nodes(Builder *b)
{
    const Scene *scene = b->world->scene;
    for (uint32_t id = 0; id < scene->nodes[CATEGORY_LIGHT].count; ++id) {
        uint32_t prototype = scene_node(scene, CATEGORY_LIGHT, id)->prototype;
        if (prototype == 0) {
            push_node(b, id, NONE_ID);
            continue;
        }
        for (uint32_t i = 0; i < scene->instances.count; ++i) {
            if (scene->instances.items[i].prototype == prototype) {
                push_node(b, id, i);
            }
        }
    }
}

static bool emits(const World *world, uint32_t material)
{
    return world_material(world, material)->lobes & LOBE_EMIT;
}

static void push_shape(Builder *b, uint32_t shape, uint32_t instance)
{
    push(b, (Light){.class = &emissive_shape_light,
                    .node = NONE_ID,
                    .shape = shape,
                    .instance = instance,
                    .to_world = accel_to_world(b->world->accel, shape, instance),
                    .bounds = box3_empty(),
                    .cone = ALL_AROUND,
                    .parts = true});
}

// The shapes of prototypes that may emit, grouped by prototype: those of prototype p are
// items[first[p]] to items[first[p + 1] - 1].
typedef struct Candidates {
    uint32_t *first, *items;
} Candidates;

static bool may_emit_in_instance(const World *world, const SceneNode *node)
{
    return node->prototype != 0 && !(node->flags & NODE_LIGHT_ONLY) &&
           (node->material == NONE_ID || emits(world, node->material));
}

static bool find_candidates(const World *world, Candidates *out)
{
    const Scene *scene = world->scene;
    size_t prototypes = scene->prototypes.count;
    uint32_t shapes = (uint32_t)scene->nodes[CATEGORY_SHAPE].count, total = 0;
    out->first = mem_alloc_zeroed(prototypes + 1, sizeof *out->first);
    out->items = NULL;
    if (!out->first) {
        return false;
    }
    for (uint32_t s = 0; s < shapes; ++s) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, s);
        out->first[node->prototype] += may_emit_in_instance(world, node);
    }
    for (size_t p = 0; p <= prototypes; ++p) {
        total += out->first[p];
        out->first[p] = total; // one after the last of p; filling moves it to the first
    }
    out->items = mem_alloc((size_t)total + 1, sizeof *out->items);
    if (!out->items) {
        return false;
    }
    for (uint32_t s = shapes; s-- > 0;) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, s);
        if (may_emit_in_instance(world, node)) {
            out->items[--out->first[node->prototype]] = s;
        }
    }
    return true;
}

static void push_instanced(Builder *b)
{
    const Scene *scene = b->world->scene;
    Candidates candidates;
    if (scene->instances.count == 0) {
        return;
    }
    if (find_candidates(b->world, &candidates)) {
        for (uint32_t i = 0; i < scene->instances.count; ++i) {
            const SceneInstance *instance = &scene->instances.items[i];
            bool inherits = instance->material != NONE_ID && emits(b->world, instance->material);
            for (uint32_t k = candidates.first[instance->prototype];
                 k < candidates.first[instance->prototype + 1]; ++k) {
                uint32_t shape = candidates.items[k];
                bool own = scene_node(scene, CATEGORY_SHAPE, shape)->material != NONE_ID;
                if (own || inherits) {
                    push_shape(b, shape, i);
                }
            }
        }
    } else {
        b->out_of_memory = true;
    }
    mem_free(candidates.first);
    mem_free(candidates.items);
}

static void push_emitting_shapes(Builder *b)
{
    const Scene *scene = b->world->scene;
    if (!(b->world->all_lobes & LOBE_EMIT)) {
        return;
    }
    for (uint32_t s = 0; s < scene->nodes[CATEGORY_SHAPE].count; ++s) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, s);
        if (node->prototype == 0 && !(node->flags & NODE_LIGHT_ONLY) && node->material != NONE_ID &&
            emits(b->world, node->material)) {
            push_shape(b, s, NONE_ID);
        }
    }
    push_instanced(b);
}

static Span light_span(const Scene *scene, const Light *light)
{
    return light->node != NONE_ID ? scene_node(scene, CATEGORY_LIGHT, light->node)->at
                                  : scene_node(scene, CATEGORY_SHAPE, light->shape)->at;
}

static void prepare_lights(Builder *b)
{
    for (size_t i = 0; i < b->set->lights.count; ++i) {
        Light *light = &b->set->lights.items[i];
        uint32_t errors = b->sink->errors;
        Span at = light_span(b->world->scene, light);
        LightPrepare prepare = {b->world, light, b->arena, b->sink, at};
        if (!light->class->prepare(&prepare) && b->sink->errors == errors) {
            b->out_of_memory = true;
        }
        if (!(light->power > 0) || !isfinite(light->power)) {
            light->power = 0;
        }
    }
}

static void index_shapes(Builder *b)
{
    LightSet *set = b->set;
    size_t shapes = 0, size = 4;
    for (size_t i = 0; i < set->lights.count; ++i) {
        shapes += set->lights.items[i].shape != NONE_ID;
    }
    if (shapes == 0) {
        return;
    }
    while (size < 2 * shapes) {
        size *= 2;
    }
    set->slots = size > (size_t)1 << 31 ? NULL : arena_array(b->arena, size, sizeof *set->slots);
    if (!set->slots) {
        b->out_of_memory = true;
        return;
    }
    memset(set->slots, 0xff, size * sizeof *set->slots);
    set->slot_mask = (uint32_t)(size - 1);
    for (uint32_t i = 0; i < set->lights.count; ++i) {
        const Light *light = &set->lights.items[i];
        if (light->shape == NONE_ID) {
            continue;
        }
        if (find_shape(set, light->shape, light->instance) != NONE_ID) {
            diag_report(b->sink, E0935, light_span(b->world->scene, light),
                        "two lights stand on one shape");
            continue;
        }
        uint32_t slot = slot_of(light->shape, light->instance, set->slot_mask);
        while (set->slots[slot].light != NONE_ID) {
            slot = (slot + 1) & set->slot_mask;
        }
        set->slots[slot] = (ShapeSlot){light->shape, light->instance, i};
    }
    b->world->shape_lights = true;
}

// Numbers the lights that can be chosen, those at infinity first. A light that the tree can't hold
// (of no finite box) counts among the latter.
static void number_chosen(Builder *b)
{
    LightSet *set = b->set;
    size_t count = set->lights.count;
    uint32_t chosen = 0, far = 0;
    for (int pass = 0; pass < 2; ++pass) {
        for (uint32_t i = 0; i < count; ++i) {
            const Light *light = &set->lights.items[i];
            bool near = !light->class->infinite && !box3_is_empty(light->bounds) &&
                        vec3_is_finite(light->bounds.min) && vec3_is_finite(light->bounds.max);
            if (light->power > 0 && near == (pass == 1)) {
                set->chosen_at[i] = chosen;
                set->chosen[chosen++] = i;
                far += pass == 0;
            }
        }
    }
    set->by_power.count = chosen;
    set->far.count = far;
}

static bool make_choice_tables(Builder *b)
{
    LightSet *set = b->set;
    uint32_t chosen = set->by_power.count, far = set->far.count;
    double *weights = mem_alloc((size_t)chosen + 1, sizeof *weights);
    LightTreeItem *items = mem_alloc((size_t)chosen + 1, sizeof *items);
    bool good = weights && items;
    if (good) {
        for (uint32_t i = 0; i < chosen; ++i) {
            weights[i] = set->lights.items[set->chosen[i]].power;
        }
        good = alias_table_build(&set->by_power, b->arena, weights, chosen);
        for (uint32_t i = 0; i < chosen; ++i) {
            const Light *light = &set->lights.items[set->chosen[i]];
            weights[i] = light->intensity;
            if (i >= far) {
                items[i - far] = (LightTreeItem){light->bounds, light->cone, light->intensity};
            }
        }
        good = good && alias_table_build(&set->far, b->arena, weights, far) &&
               light_tree_build(&set->tree, b->arena, items, chosen - far);
        set->far_irradiance = far ? set->far.total : 0;
    }
    mem_free(weights);
    mem_free(items);
    return good;
}

static void make_tables(Builder *b)
{
    LightSet *set = b->set;
    size_t count = set->lights.count;
    set->infinite = arena_array(b->arena, count + 1, sizeof *set->infinite);
    set->chosen = arena_array(b->arena, count + 1, sizeof *set->chosen);
    set->chosen_at = arena_array(b->arena, count + 1, sizeof *set->chosen_at);
    if (!set->infinite || !set->chosen || !set->chosen_at) {
        b->out_of_memory = true;
        return;
    }
    set->plain_part = PLAIN_PART;
    for (uint32_t i = 0; i < count; ++i) {
        const Light *light = &set->lights.items[i];
        if (light->class->infinite && !light->delta) {
            set->infinite[set->infinite_count++] = i;
        }
        if (!light_is_natural(b->world->scene, light)) {
            set->plain_part = PLAIN_PART_UNNATURAL;
        }
        set->chosen_at[i] = NONE_ID;
    }
    number_chosen(b);
    if (!make_choice_tables(b)) {
        b->out_of_memory = true;
    }
}

LightSet *light_set_build(World *world, Arena *arena, DiagSink *sink)
{
    uint32_t errors = sink->errors;
    LightSet *set = mem_alloc_zeroed(1, sizeof *set);
    Builder b = {world, set, arena, sink, set == NULL};
    if (set) {
        push_nodes(&b);
        push_emitting_shapes(&b);
        prepare_lights(&b);
        index_shapes(&b);
        make_tables(&b);
    }
    if (b.out_of_memory && sink->errors == errors) {
        diag_report(sink, E0001, (Span){0}, "no memory for the lights");
    }
    if (sink->errors != errors) {
        light_set_free(set);
        return NULL;
    }
    return set;
}

void light_set_free(LightSet *set)
{
    if (set) {
        array_free(&set->lights);
        mem_free(set);
    }
}

// --- Choosing -----------------------------------------------------------------------------------

uint32_t light_node_of(const NodeType *type, const void *params, Category category)
{
    for (size_t i = 0; params && i < type->param_count; ++i) {
        if (type->params[i].type == PARAM_NODE && type->params[i].category == category) {
            uint32_t id;
            memcpy(&id, (const char *)params + type->params[i].offset, sizeof id);
            return id;
        }
    }
    return NONE_ID;
}

size_t light_set_count(const LightSet *set)
{
    return set->lights.count;
}

const Light *light_set_items(const LightSet *set)
{
    return set->lights.items;
}

uint32_t light_set_only(const LightSet *set)
{
    return set->by_power.count == 1 ? set->chosen[0] : NONE_ID;
}

const Light *light_set_get(const LightSet *set, size_t index)
{
    return &set->lights.items[index];
}

const uint32_t *light_set_infinite(const LightSet *set, uint32_t *count)
{
    *count = set->infinite_count;
    return set->infinite;
}

// One half of a table's choices is by weight, the other uniform, so that no light is starved.
static double mixed_chance(const AliasTable *table, uint32_t item)
{
    return 0.5 * ((double)table->chance[item] + 1 / (double)table->count);
}

static uint32_t choose_mixed(const AliasTable *table, double u)
{
    if (u < 0.5) {
        return alias_table_choose(table, 2 * u);
    }
    double place = (2 * u - 1) * table->count;
    return place < table->count ? (uint32_t)place : table->count - 1;
}

// What a light at infinity gives at a point, about. Wide light, which scattered rays often find by
// chance, needs half as many samples.
static double far_irradiance(const Light *light, const LightReceiver *at)
{
    double irradiance = light->intensity * (light->cone.normals < 0.5 ? 1 : 0.5);
    if (light->cone.normals >= PI || length_squared(at->normal) == 0) {
        return irradiance;
    }
    double cosine = fmin(fmax(dot(at->normal, light->cone.axis), -1), 1);
    double angle = fmax(acos(cosine) - light->cone.normals, 0);
    return irradiance * fmax(cos(angle), 0);
}

// How the choice at a point splits.
typedef struct Split {
    double far; // the chance of the lights at infinity, all together
    double total, weights[FEW];
} Split;

// A small part is even on all levels, since what is guessed may be in the shadow.
#define EVEN 0.125

static Split split_at(const LightSet *set, const LightReceiver *at)
{
    Split split = {.far = 0};
    if (set->far.count == 0) {
        return split;
    }
    split.total = set->far_irradiance;
    if (set->far.count <= FEW) {
        split.total = 0;
        for (uint32_t i = 0; i < set->far.count; ++i) {
            split.weights[i] = far_irradiance(&set->lights.items[set->chosen[i]], at);
            split.total += split.weights[i];
        }
    }
    double near = set->tree.count ? light_tree_importance(&set->tree, at) : 0;
    split.far = !(near > 0)          ? 1
                : !(split.total > 0) ? 0
                                     : EVEN + (1 - 2 * EVEN) * split.total / (split.total + near);
    return split;
}

static double far_chance(const LightSet *set, const Split *split, uint32_t item)
{
    if (set->far.count > FEW) {
        return mixed_chance(&set->far, item);
    }
    double even = 1.0 / set->far.count;
    return split->total > 0 ? EVEN * even + (1 - EVEN) * split->weights[item] / split->total : even;
}

static uint32_t choose_far(const LightSet *set, const Split *split, double u)
{
    if (set->far.count > FEW) {
        return choose_mixed(&set->far, u);
    }
    uint32_t item = 0;
    for (u -= far_chance(set, split, item); u >= 0 && item + 1 < set->far.count;) {
        u -= far_chance(set, split, ++item);
    }
    return item;
}

// The chance of item `item` of the tables: a part is by power alone, whatever the point; the rest
// looks at the point. tree_chance < 0: not known yet.
static float chance_of(const LightSet *set, const LightReceiver *at, uint32_t item,
                       const Split *split, double tree_chance)
{
    double here;
    if (item < set->far.count) {
        here = split->far * far_chance(set, split, item);
    } else {
        if (tree_chance < 0) {
            tree_chance = light_tree_chance(&set->tree, at, item - set->far.count);
        }
        here = (1 - split->far) * tree_chance;
    }
    double plain = (double)set->plain_part;
    return (float)(plain * mixed_chance(&set->by_power, item) + (1 - plain) * here);
}

uint32_t light_choose(const LightSet *set, const LightReceiver *at, double u, float *chance)
{
    uint32_t count = set->by_power.count;
    if (count <= 1) {
        *chance = 1;
        return count ? set->chosen[0] : NONE_ID;
    }
    const Split split = split_at(set, at);
    double plain = (double)set->plain_part, tree_chance = -1;
    uint32_t item;
    if (u < plain) {
        item = choose_mixed(&set->by_power, u / plain);
    } else {
        u = (u - plain) / (1 - plain);
        if (u < split.far) {
            item = choose_far(set, &split, u / split.far);
        } else {
            item =
                light_tree_choose(&set->tree, at, (u - split.far) / (1 - split.far), &tree_chance);
            if (item == NONE_ID) {
                return NONE_ID;
            }
            item += set->far.count;
        }
    }
    *chance = chance_of(set, at, item, &split, tree_chance);
    return set->chosen[item];
}

float light_chance(const LightSet *set, const LightReceiver *at, uint32_t light)
{
    uint32_t item = set->chosen_at[light];
    if (item == NONE_ID) {
        return 0;
    }
    if (set->by_power.count == 1) {
        return 1;
    }
    const Split split = split_at(set, at);
    return chance_of(set, at, item, &split, -1);
}
