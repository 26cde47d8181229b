// Lights that were put inside something they can't shine out of.
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

static void look_around(const World *world, const SceneNode *light, Vec3 p, DiagSink *sink)
{
    const Scene *scene = world->scene;
    const SceneNodeArray *shapes = &scene->nodes[CATEGORY_SHAPE];
    for (size_t i = 0; i < shapes->count; ++i) {
        const SceneNode *shape = &shapes->items[i];
        if (shape->prototype == 0 && !(shape->flags & NODE_LIGHT_ONLY) &&
            !(world_material(world, shape->material)->lobes & (LOBE_TRANSMIT | LOBE_PASS)) &&
            shape_holds(scene, shape, p)) {
            warn(scene, light, shape, sink);
            return;
        }
    }
}

void light_warn_enclosed(const Scene *scene, DiagSink *sink)
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
            look_around(&world, &lights->items[i], p, sink);
        }
    }
    arena_free(&world.arena);
}
