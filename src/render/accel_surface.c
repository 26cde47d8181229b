// What lies at a hit, and rays that leave it; the parts of intersection that need no hierarchy.
#include "base/hot.h"
#include "render/accel_plain.h"
#include "render/geometry.h"
#include "render/shapes/flat.h"
#include "render/shapes/mesh.h"

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
        *tmin = larger(*tmin, smaller(near, far));
        *tmax = smaller(*tmax, larger(near, far));
    }
    return *tmin <= *tmax;
}

// A triangle of a mesh in double precision, without gaps: Woop, Benthin, Wald 2013, "Watertight
// Ray/Triangle Intersection" (JCGT 2/1). A vertex is brought to the ray's frame by the same
// roundings for each triangle that it belongs to, and the sign of a difference of two rounded
// products is that of the exact one, or zero; zero counts as inside. t is that of the plane, so
// that its sign is that of the origin's side.
static FlatHit mesh_triangle_hit(const Mesh *mesh, uint32_t triangle, const FlatRay *flat,
                                 double tmax, ShapeHit *hit)
{
    const uint32_t *index = mesh->triangles + 3 * (size_t)triangle;
    Vec3 from[3];
    for (int i = 0; i < 3; ++i) {
        from[i] = sub(mesh_vertex(mesh, index[i]), flat->ray.origin);
    }
    const Vec3 normal = cross(sub(from[1], from[0]), sub(from[2], from[0]));
    const double t = dot(normal, from[0]) / dot(normal, flat->ray.direction);
    // Most of what misses does so here: the triangle on which the ray begins.
    if (!(t > flat->ray.tmin && t < tmax)) {
        return FLAT_MISSED;
    }
    double x[3], y[3];
    for (int i = 0; i < 3; ++i) {
        const double p[3] = {from[i].x, from[i].y, from[i].z}, along = p[flat->longest];
        x[i] = p[flat->next[0]] - along * flat->slope[0];
        y[i] = p[flat->next[1]] - along * flat->slope[1];
    }
    const double a = x[2] * y[1] - y[2] * x[1], b = x[0] * y[2] - y[0] * x[2];
    const double c = x[1] * y[0] - y[1] * x[0], sum = a + b + c;
    *hit = (ShapeHit){.t = t, .primitive = triangle, .u = b / sum, .v = c / sum};
    const bool outside = (a < 0 || b < 0 || c < 0) && (a > 0 || b > 0 || c > 0);
    return outside || sum == 0 ? FLAT_BESIDE : FLAT_INSIDE;
}

void flat_ray_prepare(const Scene *scene, uint32_t transform, const Ray *ray, FlatRay *out)
{
    out->transform = transform;
    out->ray = transform == 0 ? *ray : ray_map(&scene->inverses.items[transform], ray);
    const Vec3 size = vec3_abs(out->ray.direction);
    const bool x = size.x > size.y && size.x > size.z, y = !x && size.y > size.z;
    out->longest = x ? 0 : y ? 1 : 2;
    out->next[0] = x ? 1 : y ? 2 : 0;
    out->next[1] = x ? 2 : y ? 0 : 1;
    const double inverse = 1 / vec3_get(out->ray.direction, out->longest);
    out->slope[0] = vec3_get(out->ray.direction, out->next[0]) * inverse;
    out->slope[1] = vec3_get(out->ray.direction, out->next[1]) * inverse;
}

// Flat shapes reach a few roundings beyond their edges, so that a ray at the common edge of two of
// them finds one.
#define EDGE_SLACK (64 * ROUNDING)

// `corners` of a triangle (3) or parallelogram (4).
static FlatHit flat_shape_hit(const Vec3 *corners, int count, const Ray *ray, ShapeHit *hit)
{
    const Vec3 u = sub(corners[1], corners[0]), v = sub(corners[count - 1], corners[0]);
    if (!flat_meet(corners[0], u, v, ray, hit) || !(hit->t > ray->tmin && hit->t < ray->tmax)) {
        return FLAT_MISSED;
    }
    const double over = count == 3 ? hit->u + hit->v : fmax(hit->u, hit->v);
    if (!(hit->u >= -EDGE_SLACK && hit->v >= -EDGE_SLACK && over <= 1 + EDGE_SLACK)) {
        return FLAT_BESIDE;
    }
    hit->u = fmin(fmax(hit->u, 0), 1);
    hit->v = fmin(fmax(hit->v, 0), count == 3 ? 1 - hit->u : 1);
    return FLAT_INSIDE;
}

// The place in [0, 1] on a segment that is nearest to a line, and the line's t there.
static double segment_near_line(Vec3 a, Vec3 along, const Ray *ray, double *t)
{
    const Vec3 from = sub(a, ray->origin), d = ray->direction;
    const double dd = length_squared(d), ee = length_squared(along), de = dot(d, along);
    const double fd = dot(from, d), fe = dot(from, along);
    const double determinant = dd * ee - de * de;
    double s = determinant > 0 ? (de * fd - dd * fe) / determinant : 0;
    s = s > 0 ? fmin(s, 1) : 0;
    *t = (fd + s * de) / dd;
    return s;
}

// The nearest point to the ray's line on the edges of a triangle or parallelogram; returns the
// vector to it from the line.
static Vec3 nearest_on_edges(const Vec3 *corners, int count, const Ray *ray, ShapeHit *hit)
{
    static const double us[4] = {0, 1, 1, 0}, vs[4] = {0, 0, 1, 1};
    Vec3 nearest = {INFINITY, 0, 0};
    for (int i = 0; i < count; ++i) {
        const int j = (i + 1) % count, last = count - 1;
        const Vec3 along = sub(corners[j], corners[i]);
        double t;
        const double s = segment_near_line(corners[i], along, ray, &t);
        const Vec3 p = add_scaled(corners[i], along, s);
        const Vec3 beside = sub(p, add_scaled(ray->origin, ray->direction, t));
        if (length_squared(beside) < length_squared(nearest)) {
            nearest = beside;
            const double u0 = us[i == last ? 3 : i], u1 = us[j == last ? 3 : j];
            const double v0 = vs[i == last ? 3 : i], v1 = vs[j == last ? 3 : j];
            *hit = (ShapeHit){.t = t, .u = u0 + s * (u1 - u0), .v = v0 + s * (v1 - v0)};
        }
    }
    return nearest;
}

// A primitive that the ray passes beside: is it near enough to be in doubt?
static FlatHit flat_beside(const AccelKind *kind, uint32_t transform, const Vec3 *corners,
                           int count, const Ray *ray, ShapeHit *hit)
{
    const uint32_t primitive = hit->primitive;
    Vec3 beside = nearest_on_edges(corners, count, ray, hit);
    hit->primitive = primitive;
    if (transform) {
        beside = transform_vector(&kind->accel->scene->transforms.items[transform], beside);
    }
    return length(beside) < FLAT_DOUBT * kind->group->scale ? FLAT_BESIDE : FLAT_MISSED;
}

FlatHit accel_flat_hit(const AccelKind *kind, uint32_t shape, uint32_t primitive,
                       const FlatRay *flat, double tmax, ShapeHit *hit)
{
    Vec3 corners[4];
    int count = 3;
    FlatHit found;
    if (kind->mesh) {
        found = mesh_triangle_hit(kind->mesh, primitive, flat, tmax, hit);
        if (found != FLAT_BESIDE) {
            return found;
        }
        for (int i = 0; i < 3; ++i) {
            const size_t corner = 3 * (size_t)primitive + (size_t)i;
            corners[i] = mesh_vertex(kind->mesh, kind->mesh->triangles[corner]);
        }
    } else {
        const SceneNode *node = scene_node(kind->accel->scene, CATEGORY_SHAPE, shape);
        count = kind->class->corners(kind->params + node->index * kind->class->node.size, corners);
        Ray ray = flat->ray;
        ray.tmax = tmax;
        found = flat_shape_hit(corners, count, &ray, hit);
        if (found != FLAT_BESIDE) {
            return found;
        }
    }
    return flat_beside(kind, flat->transform, corners, count, &flat->ray, hit);
}

// The ray in a shape's own space: the ray itself, or one made in *room.
static inline const Ray *own_ray(const Scene *scene, const SceneNode *node,
                                 const SceneInstance *instance, const Ray *ray, Ray *room)
{
    if (instance) {
        *room = ray_map(&scene->inverses.items[instance->transform], ray);
        ray = room;
    }
    if (node->transform != 0) {
        *room = ray_map(&scene->inverses.items[node->transform], ray);
        ray = room;
    }
    return ray;
}

bool accel_unbounded_hit(const Accel *accel, const Ray *ray, Hit *hit)
{
    const Scene *scene = accel->scene;
    Ray nearer, room; // copied to only where they have to be
    bool found = false;
    for (uint32_t i = 0; i < accel->unbounded_count; ++i) {
        const AccelUnbounded it = accel->unbounded[i];
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, it.shape);
        const SceneInstance *instance =
            it.instance == NONE_ID ? NULL : &scene->instances.items[it.instance];
        const Ray *local = own_ray(scene, node, instance, found ? &nearer : ray, &room);
        ShapeHit at;
        if (shape_class(scene, node)->intersect(scene_params(scene, node), local, &at)) {
            *hit = (Hit){.t = at.t, .shape = it.shape, .instance = it.instance, .local = at};
            nearer = *ray;
            nearer.tmax = at.t;
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

void accel_map_out(const Accel *accel, uint32_t transform, ShapePoint *point)
{
    const Affine *to = &accel->scene->transforms.items[transform];
    if (transform < accel->map_count) {
        space_map_point(&accel->maps[transform], to, point);
    } else {
        const SpaceMap map = space_map(to, &accel->scene->inverses.items[transform]);
        space_map_point(&map, to, point);
    }
}

// The point of a shape in its own space. That of a flat one depends on the hit alone.
static void hit_point(const Scene *scene, const SceneNode *node, const SceneInstance *instance,
                      const Ray *ray, const ShapeHit *hit, bool whole, ShapePoint *out)
{
    const ShapeClass *class = shape_class(scene, node);
    Ray room;
    if (class->holding != HOLD_TRIANGLES && class->holding != HOLD_FLAT) {
        ray = own_ray(scene, node, instance, ray, &room);
    }
    if (class->place && !whole) {
        class->place(scene_params(scene, node), ray, hit, out);
    } else {
        class->point(scene, scene_params(scene, node), ray, hit, out);
    }
}

uint32_t accel_node_material(const SceneNode *node, const SceneInstance *instance)
{
    const uint32_t material =
        node->material != NONE_ID || !instance ? node->material : instance->material;
    return material == NONE_ID && node->flags & NODE_LIGHT_ONLY ? MATERIAL_BLACK : material;
}

static bool shading_is_bent(const ShapePoint *point)
{
    const Vec3 a = point->geometric, b = point->shading;
    return a.x != b.x || a.y != b.y || a.z != b.z;
}

static void fill_surface(const Accel *accel, const Ray *ray, const Hit *hit, bool whole,
                         Surface *out)
{
    const Scene *scene = accel->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, hit->shape);
    const SceneInstance *instance =
        hit->instance == NONE_ID ? NULL : &scene->instances.items[hit->instance];
    const AccelFlat *flat = hit->flat - 1 < accel->flat_count ? &accel->flats[hit->flat - 1] : NULL;
    const ShapeHit local = flat ? accel_primitive_hit(flat, &hit->local) : hit->local;
    ShapePoint point;
    if (!flat || whole || flat->smooth) {
        hit_point(scene, node, instance, ray, &local, whole, &point);
        out->object_p = point.p;
        if (node->transform) {
            accel_map_out(accel, node->transform, &point);
        }
    }
    if (flat) { // the same, however much is asked for
        point.p = hit->p;
        point.geometric = flat->normal;
        point.shading = flat->smooth ? point.shading : flat->normal;
        point.error = flat->error;
        if (!whole) {
            point.tangent = point.bitangent = vec3(0, 0, 0);
        }
    }
    accel_set_leaving(hit, flat && flat->swept, point.geometric, out);
    if (instance && instance->transform) {
        accel_map_out(accel, instance->transform, &point);
    }
    out->p = point.p;
    out->geometric = point.geometric;
    out->bent = shading_is_bent(&point);
    out->shading = !out->bent                                ? point.geometric
                   : dot(point.shading, point.geometric) < 0 ? neg(point.shading)
                                                             : point.shading;
    out->error = point.error;
    if (whole) {
        out->tangent = point.tangent;
        out->bitangent = point.bitangent;
        out->uv = point.uv;
        out->color = point.color;
    }
    out->whole = whole;
    out->shape = hit->shape;
    out->instance = hit->instance;
    out->primitive = local.primitive;
    out->material = accel_node_material(node, instance);
    out->lamp = node->flags & NODE_LIGHT_ONLY;
    out->front = dot(ray->direction, point.geometric) < 0;
}

void accel_surface(const Accel *accel, const Ray *ray, const Hit *hit, Surface *out)
{
    fill_surface(accel, ray, hit, true, out);
}

HOT void accel_surface_plain(const Accel *accel, const Ray *ray, const Hit *hit, Surface *out)
{
    const AccelFlat *flat = accel_plain_flat(accel, hit);
    if (flat) {
        accel_fill_plain(flat, ray, hit, out);
    } else {
        fill_surface(accel, ray, hit, false, out);
    }
}

uint32_t accel_material(const Accel *accel, const Hit *hit)
{
    const Scene *scene = accel->scene;
    if (hit->instance == NONE_ID) {
        return hit->flat - 1 < accel->flat_count
                   ? accel->flats[hit->flat - 1].material
                   : accel_node_material(scene_node(scene, CATEGORY_SHAPE, hit->shape), NULL);
    }
    return accel_node_material(scene_node(scene, CATEGORY_SHAPE, hit->shape),
                               &scene->instances.items[hit->instance]);
}

AccelIssues accel_issues(const Accel *accel)
{
    return accel->issues;
}

Box3 accel_bounds(const Accel *accel)
{
    return accel->groups[0].bounds;
}
