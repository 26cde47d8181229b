// Lights that were put inside something they can't shine out of.
#include "base/thread.h"
#include "render/light_report.h"

#include <string.h>

enum { MOST_PAIRS = 1 << 25, MOST_CROSSINGS = 64 };

// The world position of a light whose kind has a `position`. False for the others.
static bool light_position(const Scene *scene, const SceneNode *node, Vec3 *out)
{
    const NodeType *type = scene_node_type(scene, node);
    int index = node_type_find_param(type, STR("position"));
    if (index < 0 || type->params[index].type != PARAM_VEC3) {
        return false;
    }
    Vec3 local;
    memcpy(&local, (const char *)scene_params(scene, node) + type->params[index].offset,
           sizeof local);
    *out = transform_point(&scene->transforms.items[node->transform], local);
    return true;
}

static bool box_holds(Box3 box, Vec3 p)
{
    return p.x > box.min.x && p.x < box.max.x && p.y > box.min.y && p.y < box.max.y &&
           p.z > box.min.z && p.z < box.max.z;
}

// Is a point inside a closed shape? A ray from it crosses the surface an odd number of times.
static bool shape_holds(const Scene *scene, const SceneNode *node, Vec3 p)
{
    const ShapeClass *class = shape_class(scene, node);
    const void *params = scene_params(scene, node);
    if (!class->intersect || !class->closed(params)) {
        return false;
    }
    Vec3 local = transform_point(&scene->inverses.items[node->transform], p);
    if (!class->node.bounds || !box_holds(class->node.bounds(scene, params), local)) {
        return false;
    }
    // No axis and no diagonal, along which edges would lie.
    Ray ray = ray_make(local, normalize(vec3(0.29, 0.83, 0.47)), 0, INFINITY);
    int crossings = 0;
    for (ShapeHit hit; crossings < MOST_CROSSINGS && class->intersect(params, &ray, &hit);) {
        ++crossings;
        ray.tmin = nextafter(hit.t * (1 + 1e-9), INFINITY);
    }
    return crossings % 2 == 1;
}

static void warn(const Scene *scene, const SceneNode *light, const SceneNode *shape, DiagSink *sink)
{
    Diag *diag = diag_report(sink, W0902, light->at, "this light lies inside an opaque %s",
                             scene_node_type(scene, shape)->name);
    diag_note(sink, diag, "nothing outside of it is lit");
    diag_frame(sink, diag, shape->at, "the %s around it", scene_node_type(scene, shape)->name);
}

// A point and the shapes that may be around it, in pieces for threads.
enum { PIECE = 1 << 14 };
typedef struct Surroundings {
    const World *world;
    Vec3 p;
    _Atomic uint32_t first; // the number of the first shape that holds it, of those looked at
} Surroundings;

static bool is_around(const World *world, uint32_t number, Vec3 p)
{
    const SceneNode *shape = scene_node(world->scene, CATEGORY_SHAPE, number);
    return shape->prototype == 0 && !(shape->flags & NODE_LIGHT_ONLY) &&
           !(world_material(world, shape->material)->lobes & (LOBE_TRANSMIT | LOBE_PASS)) &&
           shape_holds(world->scene, shape, p);
}

static void look_at_piece(void *context, uint64_t piece, unsigned worker)
{
    (void)worker;
    Surroundings *all = context;
    const uint32_t count = (uint32_t)all->world->scene->nodes[CATEGORY_SHAPE].count;
    const uint32_t begin = (uint32_t)piece * PIECE;
    const uint32_t end = count - begin > PIECE ? begin + PIECE : count;
    for (uint32_t i = begin; i < end && i < atomic_load(&all->first); ++i) {
        if (is_around(all->world, i, all->p)) {
            uint32_t before = atomic_load(&all->first);
            while (i < before && !atomic_compare_exchange_weak(&all->first, &before, i)) {
            }
        }
    }
}

static void look_around(const World *world, const SceneNode *light, Vec3 p, unsigned threads,
                        DiagSink *sink)
{
    const Scene *scene = world->scene;
    const size_t count = scene->nodes[CATEGORY_SHAPE].count;
    Surroundings all = {.world = world, .p = p};
    atomic_init(&all.first, NONE_ID);
    parallel_for((count - 1) / PIECE + 1, threads, look_at_piece, &all, NULL);
    const uint32_t first = atomic_load(&all.first);
    if (first != NONE_ID) {
        warn(scene, light, scene_node(scene, CATEGORY_SHAPE, first), sink);
    }
}

void light_warn_enclosed(const Scene *scene, unsigned threads, DiagSink *sink)
{
    const SceneNodeArray *lights = &scene->nodes[CATEGORY_LIGHT];
    const size_t shapes = scene->nodes[CATEGORY_SHAPE].count;
    World world = {.scene = scene};
    if (lights->count == 0 || shapes == 0 || lights->count > MOST_PAIRS / shapes ||
        !world_resolve_materials(&world)) {
        arena_free(&world.arena);
        return;
    }
    for (size_t i = 0; i < lights->count; ++i) {
        Vec3 p;
        if (light_position(scene, &lights->items[i], &p)) {
            look_around(&world, &lights->items[i], p, threads, sink);
        }
    }
    arena_free(&world.arena);
}
