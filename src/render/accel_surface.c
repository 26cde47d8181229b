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

// A triangle of a mesh in double precision, without gaps: Woop, Benthin, Wald 2013, "Watertight
// Ray/Triangle Intersection" (JCGT 2/1). A vertex is brought to the ray's frame by the same
// roundings for each triangle that it belongs to, and the sign of a difference of two rounded
// products is that of the exact one, or zero; zero counts as inside. t is that of the plane, so
// that its sign is that of the origin's side.
static bool mesh_triangle_hit(const Mesh *mesh, uint32_t triangle, const Ray *ray, ShapeHit *hit)
{
    const uint32_t *index = mesh->triangles + 3 * (size_t)triangle;
    const Vec3 direction = ray->direction, size = vec3_abs(direction);
    const bool x_longest = size.x > size.y && size.x > size.z;
    const bool y_longest = !x_longest && size.y > size.z;
    Vec3 from[3];
    double x[3], y[3];
    for (int i = 0; i < 3; ++i) {
        const Vec3 p = from[i] = sub(mesh_vertex(mesh, index[i]), ray->origin);
        if (x_longest) {
            x[i] = p.y - p.x * (direction.y / direction.x);
            y[i] = p.z - p.x * (direction.z / direction.x);
        } else if (y_longest) {
            x[i] = p.z - p.y * (direction.z / direction.y);
            y[i] = p.x - p.y * (direction.x / direction.y);
        } else {
            x[i] = p.x - p.z * (direction.x / direction.z);
            y[i] = p.y - p.z * (direction.y / direction.z);
        }
    }
    const double a = x[2] * y[1] - y[2] * x[1], b = x[0] * y[2] - y[0] * x[2];
    const double c = x[1] * y[0] - y[1] * x[0], sum = a + b + c;
    if (((a < 0 || b < 0 || c < 0) && (a > 0 || b > 0 || c > 0)) || sum == 0) {
        return false;
    }
    const Vec3 normal = cross(sub(from[1], from[0]), sub(from[2], from[0]));
    const double t = dot(normal, from[0]) / dot(normal, direction);
    *hit = (ShapeHit){.t = t, .primitive = triangle, .u = b / sum, .v = c / sum};
    return t > ray->tmin && t < ray->tmax;
}

// Flat shapes reach a few roundings beyond their edges, so that a ray at the common edge of two of
// them finds one.
#define EDGE_SLACK (64 * ROUNDING)

static bool flat_shape_hit(const ShapeClass *class, const void *params, const Ray *ray,
                           ShapeHit *hit)
{
    Vec3 corners[4];
    const int count = class->corners(params, corners);
    const Vec3 u = sub(corners[1], corners[0]), v = sub(corners[count - 1], corners[0]);
    if (!flat_meet(corners[0], u, v, ray, hit) || !(hit->t > ray->tmin && hit->t < ray->tmax) ||
        !(hit->u >= -EDGE_SLACK && hit->v >= -EDGE_SLACK)) {
        return false;
    }
    const double over = count == 3 ? hit->u + hit->v : fmax(hit->u, hit->v);
    if (!(over <= 1 + EDGE_SLACK)) {
        return false;
    }
    hit->u = fmin(fmax(hit->u, 0), 1);
    hit->v = fmin(fmax(hit->v, 0), count == 3 ? 1 - hit->u : 1);
    return true;
}

bool accel_flat_hit(const AccelKind *kind, uint32_t shape, uint32_t primitive, const Ray *ray,
                    double tmax, ShapeHit *hit)
{
    const Scene *scene = kind->accel->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, shape);
    const void *params = kind->params + node->index * kind->class->node.size;
    Ray local = accel_shape_ray(scene, node, ray);
    local.tmax = tmax;
    return kind->class->holding == HOLD_TRIANGLES
               ? mesh_triangle_hit(mesh_of(scene, params), primitive, &local, hit)
               : flat_shape_hit(kind->class, params, &local, hit);
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
