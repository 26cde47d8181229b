// Embree 3 or 4 behind accel.h: the only file that includes it. See accel_parts.h for how the scene
// is laid out and what single precision is trusted with.
#include "base/mem.h"
#include "base/thread.h"
#include "render/accel_parts.h"
#include "render/geometry.h"
#include "render/shapes/mesh.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext QueryContext;
#define query_context_init rtcInitRayQueryContext
#else
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext QueryContext;
#define query_context_init rtcInitIntersectContext
#endif

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

// One ray on its way through one group. The first member is what Embree hands to callbacks.
typedef struct Query {
    QueryContext embree;
    const AccelGroup *group;
    const Ray *ray;     // in the group's space; its tmax is the query's
    Vec3 direction;     // unit
    double speed;       // Embree's length for t = 1
    double start;       // Embree's length from the ray's origin to where the float ray begins
    double first, last; // tmin and tmax in that length
    uint32_t instance;
    Hit *hit; // the nearest found by callbacks so far; NULL: any will do
} Query;

// --- Rays
// -------------------------------------------------------------------------------------------

static Box3 unit_cube(double half)
{
    return (Box3){{-half, -half, -half}, {half, half, half}};
}

// The smallest float not below x.
static float float_up(double x)
{
    float f = (float)x;
    return (double)f < x ? nextafterf(f, INFINITY) : f;
}

// Fills the query and Embree's ray. The float ray begins where the true one comes near the group,
// so that its rounding is relative to the group's size and not to the distance. False where it
// never does.
static bool query_begin(Query *q, const AccelGroup *group, const Ray *ray, uint32_t instance,
                        Hit *hit, struct RTCRay *out)
{
    double inverse_scale = 1 / group->scale;
    double size = length(ray->direction);
    Ray local = {scale(sub(ray->origin, group->center), inverse_scale),
                 scale(ray->direction, 1 / size), 0, 0};
    q->speed = size * inverse_scale;
    q->first = local.tmin = ray->tmin * q->speed;
    q->last = local.tmax = ray->tmax * q->speed;
    double begin = local.tmin, end = local.tmax;
    if (max_abs(local.origin) > 2 && !ray_clip(&local, unit_cube(1), 0x1p-10, &begin, &end)) {
        return false;
    }
    query_context_init(&q->embree);
    q->group = group;
    q->ray = ray;
    q->direction = local.direction;
    q->start = begin - RAY_MARGIN;
    q->instance = instance;
    q->hit = hit;
    Vec3 origin = add_scaled(local.origin, local.direction, q->start);
    *out = (struct RTCRay){.org_x = (float)origin.x,
                           .org_y = (float)origin.y,
                           .org_z = (float)origin.z,
                           .dir_x = (float)local.direction.x,
                           .dir_y = (float)local.direction.y,
                           .dir_z = (float)local.direction.z,
                           .tfar = float_up(end - q->start + RAY_MARGIN),
                           .mask = UINT32_MAX};
    return true;
}

static void embree_intersect(Query *q, struct RTCRayHit *rayhit)
{
#if RTC_VERSION_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &q->embree;
    rtcIntersect1((RTCScene)q->group->hierarchy, rayhit, &arguments);
#else
    rtcIntersect1((RTCScene)q->group->hierarchy, &q->embree, rayhit);
#endif
}

static bool embree_occluded(Query *q, struct RTCRay *ray)
{
#if RTC_VERSION_MAJOR >= 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &q->embree;
    rtcOccluded1((RTCScene)q->group->hierarchy, ray, &arguments);
#else
    rtcOccluded1((RTCScene)q->group->hierarchy, &q->embree, ray);
#endif
    return ray->tfar < 0;
}

// The nearest hit in a group before ray->tmax.
static bool group_intersect(const AccelGroup *group, const Ray *ray, uint32_t instance, Hit *hit)
{
    Query q;
    struct RTCRayHit rayhit;
    if (!group->hierarchy || !query_begin(&q, group, ray, instance, hit, &rayhit.ray)) {
        return false;
    }
    rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    embree_intersect(&q, &rayhit);
    uint32_t geometry = rayhit.hit.geomID;
    if (geometry == RTC_INVALID_GEOMETRY_ID) {
        return false;
    }
    if (geometry >= group->kind_count || !group->kinds[geometry].native) {
        return true; // the callback left it in *hit
    }
    const AccelKind *kind = &group->kinds[geometry];
    uint32_t primitive, shape = accel_native_shape(kind, rayhit.hit.primID, &primitive);
    ShapeHit local;
    if (!accel_flat_hit(kind, shape, primitive, ray, &local)) {
        local = (ShapeHit){.t = (q.start + (double)rayhit.ray.tfar) / q.speed,
                           .u = (double)rayhit.hit.u,
                           .v = (double)rayhit.hit.v};
    }
    local.primitive = primitive;
    *hit = (Hit){.t = local.t, .shape = shape, .instance = instance, .local = local};
    return true;
}

static bool group_occluded(const AccelGroup *group, const Ray *ray, uint32_t instance)
{
    Query q;
    struct RTCRay embree_ray;
    return group->hierarchy && query_begin(&q, group, ray, instance, NULL, &embree_ray) &&
           embree_occluded(&q, &embree_ray);
}

// --- Callbacks: triangles
// -----------------------------------------------------------------------------

// Rejects a triangle's hit that lies outside of the ray's ends in double precision. Single
// precision is believed where the plane's distance from both ends is larger than its errors.
static void filter_flat(const struct RTCFilterFunctionNArguments *args)
{
    if (!args->valid[0]) {
        return;
    }
    const AccelKind *kind = args->geometryUserPtr;
    const Query *q = (const Query *)(const void *)args->context;
    const struct RTCRay *ray = (const struct RTCRay *)(const void *)args->ray;
    const struct RTCHit *hit = (const struct RTCHit *)(const void *)args->hit;
    double at = q->start + (double)ray->tfar;
    Vec3 normal = vec3((double)hit->Ng_x, (double)hit->Ng_y, (double)hit->Ng_z);
    double clear = fmin(at - q->first, q->last - at) * dot(normal, q->direction);
    double error = FLAT_ERROR * kind->sliver;
    if (fmin(at - q->first, q->last - at) > 0 &&
        clear * clear > error * error * length_squared(normal)) {
        return;
    }
    uint32_t primitive, shape = accel_native_shape(kind, hit->primID, &primitive);
    ShapeHit exact;
    if (!accel_flat_hit(kind, shape, primitive, q->ray, &exact) ||
        !(exact.t > q->ray->tmin && exact.t < q->ray->tmax)) {
        args->valid[0] = 0;
    }
}

// --- Callbacks: other shapes
// --------------------------------------------------------------------------

static void write_bounds(const AccelGroup *group, Box3 box, struct RTCBounds *out)
{
    float lower[3], upper[3];
    if (!accel_float_box(group, box, lower, upper)) {
        // An empty box: Embree leaves the primitive out.
        *out =
            (struct RTCBounds){INFINITY, INFINITY, INFINITY, 0, -INFINITY, -INFINITY, -INFINITY, 0};
        return;
    }
    *out = (struct RTCBounds){lower[0], lower[1], lower[2], 0, upper[0], upper[1], upper[2], 0};
}

static void bounds_shape(const struct RTCBoundsFunctionArguments *args)
{
    const AccelKind *kind = args->geometryUserPtr;
    const Scene *scene = kind->accel->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, kind->ids[args->primID]);
    write_bounds(kind->group, accel_shape_box(scene, node), args->bounds_o);
}

// Intersects a shape with the query's ray up to `tmax`.
static bool shape_hit(const AccelKind *kind, uint32_t shape, const Ray *ray, double tmax,
                      ShapeHit *hit)
{
    const Scene *scene = kind->accel->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, shape);
    Ray local = accel_shape_ray(scene, node, ray);
    local.tmax = tmax;
    return kind->class->intersect(kind->params + node->index * kind->class->node.size, &local, hit);
}

// How far the query still has to go, in t: to the nearest hit so far.
static double query_tmax(const Query *q, const struct RTCRay *ray)
{
    return fmin(q->ray->tmax, (q->start + (double)ray->tfar) / q->speed);
}

static void report_hit(const Query *q, double t, const struct RTCIntersectFunctionNArguments *args)
{
    struct RTCRayHit *rayhit = (struct RTCRayHit *)(void *)args->rayhit;
    rayhit->ray.tfar = fmaxf(0, float_up(t * q->speed - q->start));
    rayhit->hit.geomID = args->geomID;
    rayhit->hit.primID = args->primID;
}

static void intersect_shape(const struct RTCIntersectFunctionNArguments *args)
{
    if (!args->valid[0]) {
        return;
    }
    const AccelKind *kind = args->geometryUserPtr;
    const Query *q = (const Query *)(const void *)args->context;
    const struct RTCRayHit *rayhit = (const struct RTCRayHit *)(const void *)args->rayhit;
    uint32_t shape = kind->ids[args->primID];
    ShapeHit local;
    if (shape_hit(kind, shape, q->ray, query_tmax(q, &rayhit->ray), &local)) {
        *q->hit = (Hit){.t = local.t, .shape = shape, .instance = q->instance, .local = local};
        report_hit(q, local.t, args);
    }
}

static void occluded_shape(const struct RTCOccludedFunctionNArguments *args)
{
    if (!args->valid[0]) {
        return;
    }
    const AccelKind *kind = args->geometryUserPtr;
    const Query *q = (const Query *)(const void *)args->context;
    ShapeHit local;
    if (shape_hit(kind, kind->ids[args->primID], q->ray, q->ray->tmax, &local)) {
        ((struct RTCRay *)(void *)args->ray)->tfar = -INFINITY;
    }
}

// --- Callbacks: groups within groups
// ------------------------------------------------------------------

// A primitive of the pockets' or the instances' geometry: the group it leads to, and the ray there.
typedef struct Passage {
    const AccelGroup *group;
    uint32_t instance;
    Ray ray;
} Passage;

// False where the ray misses the inner group's box.
static bool pass_to_pocket(const Query *q, uint32_t primitive, double tmax, Passage *out)
{
    out->group = &q->group->accel->groups[q->group->pockets[primitive]];
    out->instance = q->instance;
    out->ray = *q->ray;
    out->ray.tmax = tmax;
    return true;
}

static bool pass_to_instance(const Query *q, uint32_t primitive, double tmax, Passage *out)
{
    const Accel *accel = q->group->accel;
    const SceneInstance *instance = &accel->scene->instances.items[primitive];
    out->group = &accel->groups[instance->prototype];
    out->instance = primitive;
    out->ray = ray_map(&accel->scene->inverses.items[instance->transform], q->ray);
    out->ray.tmax = tmax;
    double begin = out->ray.tmin, end = tmax;
    return ray_clip(&out->ray, out->group->bounds, out->group->scale * BOX_MARGIN, &begin, &end);
}

static void intersect_passage(const struct RTCIntersectFunctionNArguments *args,
                              bool (*pass)(const Query *, uint32_t, double, Passage *))
{
    const Query *q = (const Query *)(const void *)args->context;
    const struct RTCRayHit *rayhit = (const struct RTCRayHit *)(const void *)args->rayhit;
    Passage inner;
    if (args->valid[0] && pass(q, args->primID, query_tmax(q, &rayhit->ray), &inner) &&
        group_intersect(inner.group, &inner.ray, inner.instance, q->hit)) {
        report_hit(q, q->hit->t, args);
    }
}

static void occluded_passage(const struct RTCOccludedFunctionNArguments *args,
                             bool (*pass)(const Query *, uint32_t, double, Passage *))
{
    const Query *q = (const Query *)(const void *)args->context;
    Passage inner;
    if (args->valid[0] && pass(q, args->primID, q->ray->tmax, &inner) &&
        group_occluded(inner.group, &inner.ray, inner.instance)) {
        ((struct RTCRay *)(void *)args->ray)->tfar = -INFINITY;
    }
}

static void bounds_pocket(const struct RTCBoundsFunctionArguments *args)
{
    const AccelGroup *group = args->geometryUserPtr;
    write_bounds(group, group->accel->groups[group->pockets[args->primID]].bounds, args->bounds_o);
}
static void intersect_pocket(const struct RTCIntersectFunctionNArguments *args)
{
    intersect_passage(args, pass_to_pocket);
}
static void occluded_pocket(const struct RTCOccludedFunctionNArguments *args)
{
    occluded_passage(args, pass_to_pocket);
}

static void bounds_instance(const struct RTCBoundsFunctionArguments *args)
{
    const AccelGroup *group = args->geometryUserPtr;
    write_bounds(group, accel_instance_box(group->accel, args->primID), args->bounds_o);
}
static void intersect_instance(const struct RTCIntersectFunctionNArguments *args)
{
    intersect_passage(args, pass_to_instance);
}
static void occluded_instance(const struct RTCOccludedFunctionNArguments *args)
{
    occluded_passage(args, pass_to_instance);
}

// --- Building
// ------------------------------------------------------------------------------------------

static void put_vertex(const AccelGroup *group, Vec3 p, float out[3])
{
    double inverse_scale = 1 / group->scale;
    out[0] = (float)((p.x - group->center.x) * inverse_scale);
    out[1] = (float)((p.y - group->center.y) * inverse_scale);
    out[2] = (float)((p.z - group->center.z) * inverse_scale);
}

// |a| |b| / |a x b| for the two shorter edges of a triangle of Embree's; 0 where it has no area.
static double triangle_sliver(const float *a, const float *b, const float *c)
{
    Vec3 p = vec3((double)a[0], (double)a[1], (double)a[2]);
    Vec3 q = vec3((double)b[0], (double)b[1], (double)b[2]);
    Vec3 r = vec3((double)c[0], (double)c[1], (double)c[2]);
    double e0 = length(sub(q, p)), e1 = length(sub(r, q)), e2 = length(sub(p, r));
    double area = length(cross(sub(q, p), sub(r, p)));
    return area > 0 ? e0 * e1 * e2 / (fmax(e0, fmax(e1, e2)) * area) : 0;
}

static float *new_vertices(RTCGeometry geometry, size_t count)
{
    return rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   3 * sizeof(float), count);
}

// A mesh: its vertices rounded to the group's coordinates, its own indices.
static bool fill_mesh(AccelKind *kind, RTCGeometry geometry, AccelIssues *issues)
{
    const Scene *scene = kind->accel->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, kind->ids[0]);
    const Mesh *mesh = mesh_of(scene, scene_params(scene, node));
    const Affine *to_group = node->transform ? &scene->transforms.items[node->transform] : NULL;
    float *vertices = new_vertices(geometry, mesh->vertex_count);
    if (!vertices) {
        return false;
    }
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
        Vec3 p = mesh_vertex(mesh, i);
        put_vertex(kind->group, to_group ? transform_point(to_group, p) : p,
                   vertices + 3 * (size_t)i);
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh->triangles, 0, 3 * sizeof(uint32_t), mesh->triangle_count);
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        const uint32_t *t = mesh->triangles + 3 * (size_t)i;
        double sliver = triangle_sliver(vertices + 3 * (size_t)t[0], vertices + 3 * (size_t)t[1],
                                        vertices + 3 * (size_t)t[2]);
        issues->degenerate += sliver == 0;
        kind->sliver = fmax(kind->sliver, sliver);
    }
    return true;
}

// Flat shapes, three or four vertices each, one or two triangles each.
static bool fill_flats(AccelKind *kind, RTCGeometry geometry)
{
    const Scene *scene = kind->accel->scene;
    size_t corner_count = (size_t)kind->corners, each = corner_count - 2;
    float *vertices = new_vertices(geometry, corner_count * kind->count);
    uint32_t *indices =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(uint32_t), each * kind->count);
    if (!vertices || !indices) {
        return false;
    }
    for (uint32_t i = 0; i < kind->count; ++i) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, kind->ids[i]);
        Vec3 corners[4];
        kind->class->corners(kind->params + node->index * kind->class->node.size, corners);
        uint32_t base = (uint32_t)(i * corner_count);
        for (uint32_t c = 0; c < corner_count; ++c) {
            Vec3 p = node->transform
                         ? transform_point(&scene->transforms.items[node->transform], corners[c])
                         : corners[c];
            put_vertex(kind->group, p, vertices + 3 * (size_t)(base + c));
        }
        for (uint32_t t = 0; t < each; ++t) {
            uint32_t *out = indices + 3 * (i * each + t);
            out[0] = base, out[1] = base + t + 1, out[2] = base + t + 2;
            double sliver =
                triangle_sliver(vertices + 3 * (size_t)out[0], vertices + 3 * (size_t)out[1],
                                vertices + 3 * (size_t)out[2]);
            kind->sliver = fmax(kind->sliver, sliver);
        }
    }
    return true;
}

static RTCGeometry user_geometry(RTCDevice device, uint32_t count, void *user,
                                 RTCBoundsFunction bounds, RTCIntersectFunctionN intersect,
                                 RTCOccludedFunctionN occluded)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    if (geometry) {
        rtcSetGeometryUserPrimitiveCount(geometry, count);
        rtcSetGeometryUserData(geometry, user);
        rtcSetGeometryBoundsFunction(geometry, bounds, NULL);
        rtcSetGeometryIntersectFunction(geometry, intersect);
        rtcSetGeometryOccludedFunction(geometry, occluded);
    }
    return geometry;
}

static RTCGeometry kind_geometry(RTCDevice device, AccelKind *kind, AccelIssues *issues)
{
    if (!kind->native) {
        return user_geometry(device, kind->count, kind, bounds_shape, intersect_shape,
                             occluded_shape);
    }
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) {
        return NULL;
    }
    rtcSetGeometryUserData(geometry, kind);
    rtcSetGeometryIntersectFilterFunction(geometry, filter_flat);
    rtcSetGeometryOccludedFilterFunction(geometry, filter_flat);
    bool mesh = kind->class->holding == HOLD_TRIANGLES;
    if (!(mesh ? fill_mesh(kind, geometry, issues) : fill_flats(kind, geometry))) {
        rtcReleaseGeometry(geometry);
        return NULL;
    }
    return geometry;
}

static bool attach(RTCScene hierarchy, RTCGeometry geometry, uint32_t number)
{
    if (!geometry) {
        return false;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(hierarchy, geometry, number);
    rtcReleaseGeometry(geometry);
    return true;
}

static bool group_build(RTCDevice device, AccelGroup *group, AccelIssues *issues)
{
    if (box3_is_empty(group->bounds)) {
        return true;
    }
    RTCScene hierarchy = rtcNewScene(device);
    group->hierarchy = hierarchy;
    if (!hierarchy) {
        return false;
    }
    rtcSetSceneFlags(hierarchy, RTC_SCENE_FLAG_ROBUST);
    bool ok = true;
    uint32_t number = 0;
    for (; ok && number < group->kind_count; ++number) {
        ok = attach(hierarchy, kind_geometry(device, &group->kinds[number], issues), number);
    }
    if (ok && group->pocket_count) {
        ok = attach(hierarchy,
                    user_geometry(device, group->pocket_count, group, bounds_pocket,
                                  intersect_pocket, occluded_pocket),
                    number++);
    }
    if (ok && group->instance_count) {
        ok = attach(hierarchy,
                    user_geometry(device, group->instance_count, group, bounds_instance,
                                  intersect_instance, occluded_instance),
                    number);
    }
    if (ok) {
        rtcCommitScene(hierarchy);
    }
    return ok;
}

static void note_error(void *failed, enum RTCError code, const char *text)
{
    (void)code;
    (void)text;
    atomic_store((atomic_bool *)failed, true);
}

static bool build_all(Accel *accel, unsigned threads)
{
    char config[64];
    snprintf(config, sizeof config, "threads=%u", threads);
    RTCDevice device = rtcNewDevice(config);
    accel->device = device;
    if (!device) {
        return false;
    }
    atomic_bool failed = false;
    rtcSetDeviceErrorFunction(device, note_error, &failed);
    bool ok = true;
    for (uint32_t i = 0; ok && i < accel->group_count; ++i) {
        ok = group_build(device, &accel->groups[i], &accel->issues) && !atomic_load(&failed);
    }
    rtcSetDeviceErrorFunction(device, NULL, NULL);
    return ok;
}

Accel *accel_build(const Scene *scene, unsigned threads)
{
    Accel *accel = mem_alloc_zeroed(1, sizeof *accel);
    if (!accel) {
        return NULL;
    }
    accel->scene = scene;
    if (!accel_collect(accel) || !build_all(accel, threads ? threads : thread_processor_count())) {
        accel_free(accel);
        return NULL;
    }
    return accel;
}

void accel_free(Accel *accel)
{
    if (!accel) {
        return;
    }
    for (uint32_t i = 0; i < accel->group_count; ++i) {
        if (accel->groups[i].hierarchy) {
            rtcReleaseScene((RTCScene)accel->groups[i].hierarchy);
        }
    }
    if (accel->device) {
        rtcReleaseDevice((RTCDevice)accel->device);
    }
    accel_collect_free(accel);
    mem_free(accel);
}

// --- Queries
// -------------------------------------------------------------------------------------------

bool accel_intersect(const Accel *accel, const Ray *ray, Hit *hit)
{
    Ray nearer = *ray;
    bool found = accel->unbounded_count && accel_unbounded_hit(accel, ray, hit);
    if (found) {
        nearer.tmax = hit->t;
    }
    return group_intersect(&accel->groups[0], &nearer, NONE_ID, hit) || found;
}

bool accel_occluded(const Accel *accel, const Ray *ray)
{
    Hit hit;
    return (accel->unbounded_count && accel_unbounded_hit(accel, ray, &hit)) ||
           group_occluded(&accel->groups[0], ray, NONE_ID);
}
