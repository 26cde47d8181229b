#include "render/casters.h"

#include "render/geometry.h"
#include "render/world.h"

// Pairs of a shape and an instance that are looked at.
enum { MOST_PAIRS = 1 << 22 };

typedef struct Search {
    const World *world;
    size_t most;
    CasterArray *out;
    bool all, out_of_memory;
} Search;

static bool is_specular(const World *world, uint32_t material)
{
    return world_material(world, material)->lobes & LOBE_DELTA;
}

bool caster_is_bounded(const World *world, uint32_t shape)
{
    const Scene *scene = world->scene;
    const ShapeClass *class = shape_class(scene, scene_node(scene, CATEGORY_SHAPE, shape));
    return class->holding != HOLD_UNBOUNDED && class->node.bounds;
}

extern const ShapeClass sphere_shape;

// The sphere about a shape whose box is `box` in its own space.
static void enclose(Caster *caster, const ShapeClass *class, Box3 box, const Affine *to_world)
{
    const Vec3 middle = box3_center(box);
    caster->center = transform_point(to_world, middle);
    caster->radius = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 from_middle = sub(box3_corner(box, corner), middle);
        const double r = length(transform_vector(to_world, from_middle));
        caster->radius = fmax(caster->radius, r);
    }
    if (class == &sphere_shape) {
        const Vec3 squares = affine_gram_eigenvalues(to_world);
        const double r = (box.max.x - middle.x) * sqrt(max_component(squares));
        caster->radius = fmin(caster->radius, r);
    }
    caster->radius *= 1 + 1e-6; // rounding
}

static void add_caster(Search *s, uint32_t shape, uint32_t instance)
{
    const Scene *scene = s->world->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, shape);
    const ShapeClass *class = shape_class(scene, node);
    if (!caster_is_bounded(s->world, shape)) {
        return;
    }
    const Affine to_world = accel_to_world(s->world->accel, shape, instance);
    const Box3 own = class->node.bounds(scene, scene_params(scene, node));
    Caster caster = {shape, instance, .box = transform_box(&to_world, own)};
    enclose(&caster, class, own, &to_world);
    const Vec3 size = sub(caster.box.max, caster.box.min);
    if (box3_is_empty(caster.box) || !(length_squared(size) < INFINITY) || !(caster.radius > 0)) {
        return; // it can't be hit
    }
    // Flat boxes hold something, too.
    const double least = 1e-3 * max_component(size);
    caster.box.min = sub(caster.box.min, vec3(least, least, least));
    caster.box.max = add(caster.box.max, vec3(least, least, least));
    if (s->out->count >= s->most) {
        s->all = false;
    } else if (!array_push(s->out, caster)) {
        s->out_of_memory = true;
    }
}

static void add_instances(Search *s, uint32_t shape, uint64_t *pairs)
{
    const Scene *scene = s->world->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, shape);
    for (uint32_t i = 0; i < scene->instances.count; ++i) {
        if (++*pairs > MOST_PAIRS) {
            s->all = false;
            return;
        }
        const SceneInstance *instance = &scene->instances.items[i];
        const uint32_t material = node->material == NONE_ID ? instance->material : node->material;
        if (instance->prototype == node->prototype && is_specular(s->world, material)) {
            add_caster(s, shape, i);
        }
    }
}

bool casters_find(const World *world, size_t most, CasterArray *out, bool *all)
{
    const Scene *scene = world->scene;
    Search s = {.world = world, .most = most, .out = out, .all = true};
    uint64_t pairs = 0;
    for (uint32_t shape = 0; shape < scene->nodes[CATEGORY_SHAPE].count; ++shape) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, shape);
        const bool own = node->material != NONE_ID;
        if (own && !is_specular(world, node->material)) {
            continue;
        }
        if (node->prototype != 0) {
            add_instances(&s, shape, &pairs);
        } else if (own) {
            add_caster(&s, shape, NONE_ID);
        }
    }
    if (all) {
        *all = s.all;
    }
    return !s.out_of_memory;
}
