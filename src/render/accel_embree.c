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
    const Ray *ray; // in the group's space
    double tmax;    // the ray's, then that of the nearest hit so far
    double speed;   // Embree's length for t = 1
    double start;   // Embree's length from the ray's origin to where the float ray begins
    uint32_t instance;
    Hit *hit;     // the nearest found by callbacks so far; NULL: any will do
    Hit doubtful; // the nearest such
    FlatRay flat; // the ray for the transform of the last flat shape tried
} Query;

// --- Rays -------------------------------------------------------------------------------------

static const Box3 unit_cube = {{-1, -1, -1}, {1, 1, 1}};

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
    Ray local = {scale(sub(ray->origin, group->center), group->inverse_scale), ray->direction, 0,
                 0};
    q->speed = group->inverse_scale;
    if (instance != NONE_ID) { // else of unit length
        const double size = length(ray->direction);
        local.direction = scale(ray->direction, 1 / size);
        q->speed = size * group->inverse_scale;
    }
    double begin = ray->tmin * q->speed, end = ray->tmax * q->speed;
    if (max_abs(local.origin) > 2 && !ray_clip(&local, unit_cube, 0x1p-10, &begin, &end)) {
        return false;
    }
    query_context_init(&q->embree);
    q->group = group;
    q->ray = ray;
    q->tmax = ray->tmax;
    q->start = begin - RAY_MARGIN;
    q->instance = instance;
    q->hit = hit;
    q->doubtful.t = INFINITY;
    q->flat.transform = NONE_ID;
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
    // The callback that found it left it in *hit.
    const bool found = rayhit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    if (q.doubtful.t < q.tmax && !(found && q.tmax - q.doubtful.t < RAY_MARGIN / q.speed)) {
        *hit = q.doubtful;
        return true;
    }
    return found;
}

static bool group_occluded(const AccelGroup *group, const Ray *ray, uint32_t instance)
{
    Query q;
    struct RTCRay embree_ray;
    return group->hierarchy && query_begin(&q, group, ray, instance, NULL, &embree_ray) &&
           (embree_occluded(&q, &embree_ray) || q.doubtful.t < q.tmax);
}

// --- Callbacks: triangles ---------------------------------------------------------------------

// Is a doubtful hit nearer than the one known, and far enough from the ray's ends to count?
static bool doubtful_counts(const Query *q, double t)
{
    const double certain = FLAT_CERTAIN / q->speed;
    return t < q->doubtful.t && t > q->ray->tmin + certain && t < q->ray->tmax - certain;
}

// Decides in double precision on a triangle that single precision proposes.
static void filter_flat(const struct RTCFilterFunctionNArguments *args)
{
    if (!args->valid[0]) {
        return;
    }
    const AccelKind *kind = args->geometryUserPtr;
    Query *q = (Query *)(void *)args->context;
    const struct RTCHit *hit = (const struct RTCHit *)(const void *)args->hit;
    uint32_t primitive, shape = accel_native_shape(kind, hit->primID, &primitive);
    const Scene *scene = kind->accel->scene;
    const uint32_t transform =
        kind->mesh ? kind->transform : scene_node(scene, CATEGORY_SHAPE, shape)->transform;
    if (transform != q->flat.transform) {
        flat_ray_prepare(scene, transform, q->ray, &q->flat);
    }
    ShapeHit local;
    const FlatHit found = accel_flat_hit(kind, shape, primitive, &q->flat, q->tmax, &local);
    Hit *to = NULL;
    if (found != FLAT_INSIDE) {
        args->valid[0] = 0;
        to = found == FLAT_BESIDE && doubtful_counts(q, local.t) ? &q->doubtful : NULL;
    } else if (q->hit) {
        q->tmax = local.t;
        to = q->hit;
    }
    if (to) {
        *to = (Hit){.t = local.t, .shape = shape, .instance = q->instance, .local = local};
    }
}

// --- Callbacks: other shapes ------------------------------------------------------------------

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

// Tells Embree of a hit that is in *q->hit. It goes on a little beyond, so that what single
// precision would place behind by mistake is tried.
static void report_hit(Query *q, const struct RTCIntersectFunctionNArguments *args)
{
    struct RTCRayHit *rayhit = (struct RTCRayHit *)(void *)args->rayhit;
    q->tmax = q->hit->t;
    rayhit->ray.tfar =
        fminf(rayhit->ray.tfar, float_up(q->tmax * q->speed - q->start + FLAT_GROWTH));
    rayhit->hit.geomID = args->geomID;
    rayhit->hit.primID = args->primID;
}

static void intersect_shape(const struct RTCIntersectFunctionNArguments *args)
{
    if (!args->valid[0]) {
        return;
    }
    const AccelKind *kind = args->geometryUserPtr;
    Query *q = (Query *)(void *)args->context;
    uint32_t shape = kind->ids[args->primID];
    ShapeHit local;
    if (shape_hit(kind, shape, q->ray, q->tmax, &local)) {
        *q->hit = (Hit){.t = local.t, .shape = shape, .instance = q->instance, .local = local};
        report_hit(q, args);
    }
}

static void occluded_shape(const struct RTCOccludedFunctionNArguments *args)
{
    if (!args->valid[0]) {
        return;
    }
    const AccelKind *kind = args->geometryUserPtr;
    Query *q = (Query *)(void *)args->context;
    ShapeHit local;
    if (shape_hit(kind, kind->ids[args->primID], q->ray, q->tmax, &local)) {
        ((struct RTCRay *)(void *)args->ray)->tfar = -INFINITY;
    }
}

// --- Callbacks: groups within groups ----------------------------------------------------------

// A primitive of the pockets' or the instances' geometry: the group it leads to, and the ray there.
typedef struct Passage {
    const AccelGroup *group;
    uint32_t instance;
    Ray ray;
} Passage;

// False where the ray misses the inner group's box.
static bool pass_to_pocket(const Query *q, uint32_t primitive, Passage *out)
{
    out->group = &q->group->accel->groups[q->group->pockets[primitive]];
    out->instance = q->instance;
    out->ray = *q->ray;
    out->ray.tmax = q->tmax;
    return true;
}

static bool pass_to_instance(const Query *q, uint32_t primitive, Passage *out)
{
    const Accel *accel = q->group->accel;
    const SceneInstance *instance = &accel->scene->instances.items[primitive];
    out->group = &accel->groups[instance->prototype];
    out->instance = primitive;
    out->ray = ray_map(&accel->scene->inverses.items[instance->transform], q->ray);
    out->ray.tmax = q->tmax;
    double begin = out->ray.tmin, end = q->tmax;
    return ray_clip(&out->ray, out->group->bounds, out->group->scale * BOX_MARGIN, &begin, &end);
}

static void intersect_passage(const struct RTCIntersectFunctionNArguments *args,
                              bool (*pass)(const Query *, uint32_t, Passage *))
{
    Query *q = (Query *)(void *)args->context;
    Passage inner;
    if (args->valid[0] && pass(q, args->primID, &inner) &&
        group_intersect(inner.group, &inner.ray, inner.instance, q->hit)) {
        report_hit(q, args);
    }
}

static void occluded_passage(const struct RTCOccludedFunctionNArguments *args,
                             bool (*pass)(const Query *, uint32_t, Passage *))
{
    Query *q = (Query *)(void *)args->context;
    Passage inner;
    if (args->valid[0] && pass(q, args->primID, &inner) &&
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

// --- Building ---------------------------------------------------------------------------------

// The triangles of one geometry, three vertices each. Embree copies what it needs of them into its
// leaves, and they are given back once the hierarchy stands.
typedef struct Triangles {
    float *vertices; // 9 for each, and some for Embree to read beyond
    uint32_t *indices;
    size_t count;
} Triangles;

static bool triangles_make(Triangles *triangles, size_t count)
{
    *triangles = (Triangles){mem_alloc(9 * count + 4, sizeof(float)),
                             mem_alloc(3 * count, sizeof(uint32_t)), 0};
    return triangles->vertices && triangles->indices;
}

static void triangles_free(Triangles *triangles)
{
    mem_free(triangles->vertices);
    mem_free(triangles->indices);
}

static Vec3 group_point(const AccelGroup *group, Vec3 p)
{
    return scale(sub(p, group->center), 1 / group->scale);
}

// Moves a corner outwards, so that both edges from it move by FLAT_GROWTH: along the bisector, by
// that over the sine of half the angle between the edges' unit vectors u and v.
static Vec3 grown_corner(Vec3 p, Vec3 u, Vec3 v)
{
    Vec3 inwards = add(u, v);
    double cosine = length(inwards) / 2; // of half the angle
    double sine = length(sub(u, v)) / 2;
    if (!(cosine > 0x1p-20)) {
        return p; // flat: the other corners move the edges
    }
    return add_scaled(p, inwards, -FLAT_GROWTH / (2 * cosine * fmax(sine, FLAT_SHARPEST)));
}

// Appends a triangle of the group's space, grown. False where it has no area.
static bool triangles_add(Triangles *triangles, const AccelGroup *group, const Vec3 world[3])
{
    Vec3 corners[3], edges[3];
    for (int i = 0; i < 3; ++i) {
        corners[i] = group_point(group, world[i]);
    }
    for (int i = 0; i < 3; ++i) {
        edges[i] = sub(corners[(i + 1) % 3], corners[i]);
    }
    const bool good = length_squared(cross(edges[0], edges[1])) > 0;
    float *out = triangles->vertices + 9 * triangles->count;
    for (int i = 0; i < 3; ++i) {
        Vec3 p = corners[i];
        if (good) {
            p = grown_corner(p, normalize(edges[i]), neg(normalize(edges[(i + 2) % 3])));
        }
        out[3 * i] = (float)p.x;
        out[3 * i + 1] = (float)p.y;
        out[3 * i + 2] = (float)p.z;
        const size_t number = 3 * triangles->count + (size_t)i;
        triangles->indices[number] = (uint32_t)number;
    }
    ++triangles->count;
    return good;
}

static bool fill_mesh(const AccelKind *kind, Triangles *triangles, AccelIssues *issues)
{
    const Scene *scene = kind->accel->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, kind->ids[0]);
    const Mesh *mesh = mesh_of(scene, scene_params(scene, node));
    const Affine *to_group = node->transform ? &scene->transforms.items[node->transform] : NULL;
    if (!triangles_make(triangles, mesh->triangle_count)) {
        return false;
    }
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        Vec3 corners[3];
        for (uint32_t k = 0; k < 3; ++k) {
            Vec3 p = mesh_vertex(mesh, mesh->triangles[3 * (size_t)i + k]);
            corners[k] = to_group ? transform_point(to_group, p) : p;
        }
        issues->degenerate += !triangles_add(triangles, kind->group, corners);
    }
    return true;
}

// Flat shapes, one or two triangles each.
static bool fill_flats(const AccelKind *kind, Triangles *triangles)
{
    const Scene *scene = kind->accel->scene;
    const size_t each = (size_t)kind->corners - 2;
    if (!triangles_make(triangles, each * kind->count)) {
        return false;
    }
    for (uint32_t i = 0; i < kind->count; ++i) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, kind->ids[i]);
        const Affine *to_group = node->transform ? &scene->transforms.items[node->transform] : NULL;
        Vec3 corners[4];
        kind->class->corners(kind->params + node->index * kind->class->node.size, corners);
        for (int c = 0; to_group && c < kind->corners; ++c) {
            corners[c] = transform_point(to_group, corners[c]);
        }
        triangles_add(triangles, kind->group, (const Vec3[]){corners[0], corners[1], corners[2]});
        if (each == 2) {
            triangles_add(triangles, kind->group,
                          (const Vec3[]){corners[0], corners[2], corners[3]});
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

static RTCGeometry kind_geometry(RTCDevice device, AccelKind *kind, Triangles *triangles,
                                 AccelIssues *issues)
{
    if (!kind->native) {
        return user_geometry(device, kind->count, kind, bounds_shape, intersect_shape,
                             occluded_shape);
    }
    if (!(kind->mesh ? fill_mesh(kind, triangles, issues) : fill_flats(kind, triangles))) {
        return NULL;
    }
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (geometry) {
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   triangles->vertices, 0, 3 * sizeof(float), 3 * triangles->count);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   triangles->indices, 0, 3 * sizeof(uint32_t), triangles->count);
        rtcSetGeometryUserData(geometry, kind);
        rtcSetGeometryIntersectFilterFunction(geometry, filter_flat);
        rtcSetGeometryOccludedFilterFunction(geometry, filter_flat);
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

static bool attach_all(RTCDevice device, AccelGroup *group, Triangles *triangles,
                       AccelIssues *issues)
{
    RTCScene hierarchy = (RTCScene)group->hierarchy;
    uint32_t number = 0;
    for (; number < group->kind_count; ++number) {
        RTCGeometry geometry =
            kind_geometry(device, &group->kinds[number], &triangles[number], issues);
        if (!attach(hierarchy, geometry, number)) {
            return false;
        }
    }
    bool ok = true;
    if (group->pocket_count) {
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
    return ok;
}

static bool group_build(RTCDevice device, AccelGroup *group, AccelIssues *issues)
{
    if (box3_is_empty(group->bounds)) {
        return true;
    }
    RTCScene hierarchy = rtcNewScene(device);
    group->hierarchy = hierarchy;
    Triangles *triangles = mem_alloc_zeroed(group->kind_count, sizeof *triangles);
    if (!hierarchy || !triangles) {
        mem_free(triangles);
        return false;
    }
    // Robust: leaves hold the triangles' vertices, so that those are needed for building only.
    rtcSetSceneFlags(hierarchy, RTC_SCENE_FLAG_ROBUST);
    const bool ok = attach_all(device, group, triangles, issues);
    if (ok) {
        rtcCommitScene(hierarchy);
    }
    for (uint32_t i = 0; i < group->kind_count; ++i) {
        triangles_free(&triangles[i]);
    }
    mem_free(triangles);
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
    if (!accel_collect(accel) || !accel_keep_maps(accel) ||
        !build_all(accel, threads ? threads : thread_processor_count())) {
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

// --- Queries ----------------------------------------------------------------------------------

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
