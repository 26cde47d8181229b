// What lies at a hit, and rays that leave it; the parts of intersection that need no hierarchy.
#include "render/accel_parts.h"
#include "render/geometry.h"
#include "render/shapes/flat.h"
#include "render/shapes/mesh.h"

// A ray leaves a surface at this many times the bound on the point's error.
#define SPAWN_FACTOR 4

Ray ray_map(const Affine *inverse, const Ray *ray)
{
    return (Ray){transform_point(inverse, ray->origin), transform_vector(inverse, ray->direction),
                 ray->tmin, ray->tmax};
}

bool ray_clip(const Ray *ray, Box3 box, double margin, double *tmin, double *tmax)
{
    for (int axis = 0; axis < 3; ++axis) {
        double o = vec3_get(ray->origin, axis), d = vec3_get(ray->direction, axis);
        double low = vec3_get(box.min, axis) - margin - o,
               high = vec3_get(box.max, axis) + margin - o;
        if (d == 0) {
            if (low > 0 || high < 0) {
                return false;
            }
            continue;
        }
        double inverse = 1 / d, near = low * inverse, far = high * inverse;
        *tmin = fmax(*tmin, fmin(near, far));
        *tmax = fmin(*tmax, fmax(near, far));
    }
    return *tmin <= *tmax;
}

// The corner of a flat piece, and the two edges from it.
typedef struct Flat {
    Vec3 corner, edge_u, edge_v;
    bool triangle; // else a parallelogram
} Flat;

static Flat flat_of(const AccelKind *kind, const SceneNode *node, uint32_t primitive)
{
    const Scene *scene = kind->accel->scene;
    const void *params = kind->params + node->index * kind->class->node.size;
    if (kind->class->holding == HOLD_TRIANGLES) {
        const Mesh *mesh = mesh_of(scene, params);
        const uint32_t *t = mesh->triangles + 3 * (size_t)primitive;
        Vec3 a = mesh_vertex(mesh, t[0]);
        return (Flat){a, sub(mesh_vertex(mesh, t[1]), a), sub(mesh_vertex(mesh, t[2]), a), true};
    }
    Vec3 corners[4];
    int count = kind->class->corners(params, corners);
    return (Flat){corners[0], sub(corners[1], corners[0]), sub(corners[count - 1], corners[0]),
                  count == 3};
}

bool accel_flat_hit(const AccelKind *kind, uint32_t shape, uint32_t primitive, const Ray *ray,
                    ShapeHit *hit)
{
    const Scene *scene = kind->accel->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, shape);
    Ray local = accel_shape_ray(scene, node, ray);
    Flat flat = flat_of(kind, node, primitive);
    if (!flat_meet(flat.corner, flat.edge_u, flat.edge_v, &local, hit)) {
        return false;
    }
    hit->primitive = primitive;
    hit->u = fmin(fmax(hit->u, 0), 1);
    hit->v = fmin(fmax(hit->v, 0), 1);
    double sum = hit->u + hit->v;
    if (flat.triangle && sum > 1) {
        hit->u /= sum;
        hit->v /= sum;
    }
    return true;
}

bool accel_unbounded_hit(const Accel *accel, const Ray *ray, Hit *hit)
{
    const Scene *scene = accel->scene;
    Ray world = *ray;
    bool found = false;
    for (uint32_t i = 0; i < accel->unbounded_count; ++i) {
        AccelUnbounded it = accel->unbounded[i];
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, it.shape);
        Ray local = world;
        if (it.instance != NONE_ID) {
            local = ray_map(&scene->inverses.items[scene->instances.items[it.instance].transform],
                            &world);
        }
        local = accel_shape_ray(scene, node, &local);
        ShapeHit at;
        if (shape_class(scene, node)->intersect(scene_params(scene, node), &local, &at)) {
            *hit = (Hit){.t = at.t, .shape = it.shape, .instance = it.instance, .local = at};
            world.tmax = at.t;
            found = true;
        }
    }
    return found;
}

Affine accel_to_world(const Accel *accel, uint32_t shape, uint32_t instance)
{
    const Scene *scene = accel->scene;
    const Affine *own =
        &scene->transforms.items[scene_node(scene, CATEGORY_SHAPE, shape)->transform];
    if (instance == NONE_ID) {
        return *own;
    }
    return affine_multiply(&scene->transforms.items[scene->instances.items[instance].transform],
                           own);
}

// Brings a point from one space to the next, its error grown by that of the way there and back.
static void map_out(const Scene *scene, uint32_t transform, ShapePoint *point)
{
    const Affine *map = &scene->transforms.items[transform];
    shape_point_map(map, point);
    point->error += affine_round_trip_error(map, &scene->inverses.items[transform], point->p);
}

void accel_surface(const Accel *accel, const Ray *ray, const Hit *hit, Surface *out)
{
    const Scene *scene = accel->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, hit->shape);
    const SceneInstance *instance =
        hit->instance == NONE_ID ? NULL : &scene->instances.items[hit->instance];
    Ray local = instance ? ray_map(&scene->inverses.items[instance->transform], ray) : *ray;
    local = accel_shape_ray(scene, node, &local);
    ShapePoint point;
    shape_class(scene, node)->point(scene, scene_params(scene, node), &local, &hit->local, &point);
    out->object_p = point.p;
    if (node->transform) {
        map_out(scene, node->transform, &point);
    }
    if (instance && instance->transform) {
        map_out(scene, instance->transform, &point);
    }
    out->p = point.p;
    out->geometric = point.geometric;
    out->shading = dot(point.shading, point.geometric) < 0 ? neg(point.shading) : point.shading;
    out->tangent = point.tangent;
    out->uv = point.uv;
    out->color = point.color;
    out->error = point.error;
    out->shape = hit->shape;
    out->instance = hit->instance;
    out->primitive = hit->local.primitive;
    out->material = node->material != NONE_ID || !instance ? node->material : instance->material;
    out->front = dot(ray->direction, point.geometric) < 0;
}

static Vec3 spawn_origin(const Surface *surface, Vec3 direction)
{
    double offset = SPAWN_FACTOR * surface->error;
    return add_scaled(surface->p, surface->geometric,
                      dot(direction, surface->geometric) < 0 ? -offset : offset);
}

Ray surface_spawn(const Surface *surface, Vec3 direction)
{
    return (Ray){spawn_origin(surface, direction), direction, 0, INFINITY};
}

Ray surface_spawn_to(const Surface *surface, Vec3 target, double target_error, double *distance)
{
    Vec3 origin = spawn_origin(surface, sub(target, surface->p));
    Vec3 way = sub(target, origin);
    *distance = length(sub(target, surface->p));
    double size = length(way);
    double margin = SPAWN_FACTOR * target_error + 1e-9 * size;
    return (Ray){origin, size > 0 ? scale(way, 1 / size) : surface->geometric, 0,
                 fmax(0, size - margin)};
}

AccelIssues accel_issues(const Accel *accel)
{
    return accel->issues;
}

Box3 accel_bounds(const Accel *accel)
{
    return accel->groups[0].bounds;
}
