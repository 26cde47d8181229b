// The hierarchies of the accelerator's groups; see accel_parts.h for how the scene is laid out and
// what single precision is trusted with.
#include "base/mem.h"
#include "base/thread.h"
#include "render/accel_embree.h"
#include "render/geometry.h"
#include "render/render.h"
#include "render/shapes/mesh.h"

#include <stdatomic.h>
#include <stdio.h>

// --- Boxes ------------------------------------------------------------------------------------

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

static void bounds_balls(const BallRun *balls, struct RTCBounds *out)
{
    // Single precision has brought the balls out of their places by less than what is added.
    const float margin = (float)(BOX_MARGIN + 0x1p-21);
    *out = (struct RTCBounds){INFINITY, INFINITY, INFINITY, 0, -INFINITY, -INFINITY, -INFINITY, 0};
    for (int i = 0; i < RUN_LONGEST && balls->radius[i] >= 0; ++i) {
        const float reach = balls->radius[i] + margin;
        const float x = balls->x[i], y = balls->y[i], z = balls->z[i];
        out->lower_x = x - reach < out->lower_x ? x - reach : out->lower_x;
        out->lower_y = y - reach < out->lower_y ? y - reach : out->lower_y;
        out->lower_z = z - reach < out->lower_z ? z - reach : out->lower_z;
        out->upper_x = x + reach > out->upper_x ? x + reach : out->upper_x;
        out->upper_y = y + reach > out->upper_y ? y + reach : out->upper_y;
        out->upper_z = z + reach > out->upper_z ? z + reach : out->upper_z;
    }
}

static void bounds_shape(const struct RTCBoundsFunctionArguments *args)
{
    const AccelKind *kind = args->geometryUserPtr;
    if (kind->balls) {
        bounds_balls(&kind->balls[args->primID], args->bounds_o);
        return;
    }
    const Scene *scene = kind->accel->scene;
    const uint32_t end = accel_run_begin(kind, args->primID + 1);
    Box3 box = box3_empty();
    for (uint32_t i = accel_run_begin(kind, args->primID); i < end; ++i) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, kind->ids[i]);
        box = box3_union(box, accel_shape_box(scene, node));
    }
    write_bounds(kind->group, box, args->bounds_o);
}

static void bounds_pocket(const struct RTCBoundsFunctionArguments *args)
{
    const AccelGroup *group = args->geometryUserPtr;
    write_bounds(group, group->accel->groups[group->pockets[args->primID]].bounds, args->bounds_o);
}
static void bounds_instance(const struct RTCBoundsFunctionArguments *args)
{
    const AccelGroup *group = args->geometryUserPtr;
    write_bounds(group, accel_instance_box(group->accel, args->primID), args->bounds_o);
}

// --- Flat pieces ------------------------------------------------------------------------------

// The triangles or quads of one geometry, 3 or 4 corners each. Embree copies what it needs of them
// into its leaves, and they are given back once the hierarchies stand.
typedef struct Pieces {
    float *vertices; // 3 for each corner, and some for Embree to read beyond
    uint32_t *indices;
    size_t count;
    int corners;
} Pieces;

static bool pieces_make(Pieces *pieces, int corners, size_t count)
{
    const size_t each = (size_t)corners;
    *pieces = (Pieces){mem_alloc(3 * each * count + 4, sizeof(float)),
                       mem_alloc(each * count, sizeof(uint32_t)), count, corners};
    return pieces->vertices && pieces->indices;
}

static void pieces_free(Pieces *pieces)
{
    mem_free(pieces->vertices);
    mem_free(pieces->indices);
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

// Fills the piece `index` with corners in the group's space, grown where it has an area; false
// where it has none.
static bool pieces_fill(const Pieces *pieces, size_t index, const AccelGroup *group, const Vec3 *at)
{
    const int n = pieces->corners;
    Vec3 corners[4], edges[4];
    for (int i = 0; i < n; ++i) {
        corners[i] = group_point(group, at[i]);
    }
    for (int i = 0; i < n; ++i) {
        edges[i] = sub(corners[(i + 1) % n], corners[i]);
    }
    const bool good = length_squared(cross(edges[0], edges[1])) > 0;
    for (int i = 0; i < n; ++i) {
        Vec3 p = corners[i];
        if (good) {
            p = grown_corner(p, normalize(edges[i]), neg(normalize(edges[(i + n - 1) % n])));
        }
        const size_t number = (size_t)n * index + (size_t)i;
        float *out = pieces->vertices + 3 * number;
        out[0] = (float)p.x;
        out[1] = (float)p.y;
        out[2] = (float)p.z;
        pieces->indices[number] = (uint32_t)number;
    }
    return good;
}

// The corner across from `corner`.
static Vec3 far_corner(const AccelFlat *f)
{
    const double apart = 1 / (1 - f->over_s * f->over_t);
    return add(f->corner,
               add(scale(f->u, (1 - f->over_s) * apart), scale(f->v, (1 - f->over_t) * apart)));
}

static bool fill_quads(const AccelGroup *group, Pieces *pieces)
{
    if (!pieces_make(pieces, 4, group->quad_count)) {
        return false;
    }
    const AccelFlat *flats = group->accel->flats + accel_first_flat(group, GEOMETRY_QUADS);
    for (uint32_t i = 0; i < group->quad_count; ++i) {
        const AccelFlat *f = &flats[i];
        pieces_fill(
            pieces, i, group,
            (const Vec3[]){f->corner, add(f->corner, f->u), far_corner(f), add(f->corner, f->v)});
    }
    return true;
}

static bool fill_triangles(const AccelGroup *group, Pieces *pieces)
{
    if (!pieces_make(pieces, 3, group->triangle_count)) {
        return false;
    }
    const AccelFlat *flats = group->accel->flats + accel_first_flat(group, GEOMETRY_TRIANGLES);
    for (uint32_t i = 0; i < group->triangle_count; ++i) {
        const AccelFlat *f = &flats[i];
        pieces_fill(pieces, i, group,
                    (const Vec3[]){f->corner, add(f->corner, f->u), add(f->corner, f->v)});
    }
    return true;
}

// Large meshes are filled in parts, by threads.
enum { MESH_PART = 16384 };

typedef struct MeshFilling {
    const AccelKind *kind;
    const Pieces *pieces;
    atomic_uint_fast64_t degenerate;
} MeshFilling;

static void fill_mesh_part(void *context, uint64_t part, unsigned worker)
{
    (void)worker;
    MeshFilling *filling = context;
    const AccelKind *kind = filling->kind;
    const Scene *scene = kind->accel->scene;
    const Mesh *mesh = kind->mesh;
    const Affine *to_group = kind->transform ? &scene->transforms.items[kind->transform] : NULL;
    const size_t begin = (size_t)part * MESH_PART;
    const size_t rest = mesh->triangle_count - begin,
                 end = begin + (rest < MESH_PART ? rest : MESH_PART);
    uint64_t degenerate = 0;
    for (size_t i = begin; i < end; ++i) {
        Vec3 corners[3];
        for (size_t k = 0; k < 3; ++k) {
            Vec3 p = mesh_vertex(mesh, mesh->triangles[3 * i + k]);
            corners[k] = to_group ? transform_point(to_group, p) : p;
        }
        degenerate += !pieces_fill(filling->pieces, i, kind->group, corners);
    }
    atomic_fetch_add_explicit(&filling->degenerate, degenerate, memory_order_relaxed);
}

static bool fill_mesh(const AccelKind *kind, Pieces *pieces, AccelIssues *issues)
{
    const size_t count = kind->mesh->triangle_count;
    if (!pieces_make(pieces, 3, count)) {
        return false;
    }
    MeshFilling filling = {.kind = kind, .pieces = pieces, .degenerate = 0};
    parallel_for((count + MESH_PART - 1) / MESH_PART, kind->accel->threads, fill_mesh_part,
                 &filling, NULL);
    issues->degenerate += filling.degenerate;
    return true;
}

// --- Geometries -------------------------------------------------------------------------------

static RTCGeometry pieces_geometry(RTCDevice device, const Pieces *pieces)
{
    const bool quads = pieces->corners == 4;
    const size_t each = (size_t)pieces->corners;
    RTCGeometry geometry =
        rtcNewGeometry(device, quads ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
    if (geometry) {
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   pieces->vertices, 0, 3 * sizeof(float), each * pieces->count);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                   quads ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3, pieces->indices, 0,
                                   each * sizeof(uint32_t), pieces->count);
    }
    return geometry;
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

// What a group's hierarchies are built of.
typedef struct Build {
    RTCDevice device;
    AccelGroup *group;
    AccelIssues *issues;
    Pieces *pieces; // of the geometries of flat pieces, in their order
    size_t pieces_count;
} Build;

// Adds a geometry to the hierarchy, and lets go of it.
static bool attach(const AccelGroup *group, RTCGeometry geometry, uint32_t number)
{
    if (!geometry) {
        return false;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID((RTCScene)group->hierarchy, geometry, number);
    rtcReleaseGeometry(geometry);
    return true;
}

static bool attach_pieces(Build *b, uint32_t number,
                          bool (*fill)(const AccelGroup *group, Pieces *pieces))
{
    Pieces *pieces = &b->pieces[b->pieces_count++];
    return fill(b->group, pieces) && attach(b->group, pieces_geometry(b->device, pieces), number);
}

static bool attach_table(Build *b)
{
    return (b->group->quad_count == 0 || attach_pieces(b, GEOMETRY_QUADS, fill_quads)) &&
           (b->group->triangle_count == 0 || attach_pieces(b, GEOMETRY_TRIANGLES, fill_triangles));
}

static bool attach_kinds(Build *b)
{
    AccelGroup *group = b->group;
    for (uint32_t k = 0; k < group->geometry_count; ++k) {
        const AccelKind *kind = group->geometries[k];
        RTCGeometry geometry;
        if (kind->mesh) {
            Pieces *pieces = &b->pieces[b->pieces_count++];
            geometry =
                fill_mesh(kind, pieces, b->issues) ? pieces_geometry(b->device, pieces) : NULL;
        } else {
            geometry =
                user_geometry(b->device, accel_primitive_count(kind), (void *)(uintptr_t)kind,
                              bounds_shape, intersect_shape, occluded_shape);
        }
        if (!attach(group, geometry, GEOMETRY_KINDS + k)) {
            return false;
        }
    }
    return true;
}

static bool attach_groups(Build *b)
{
    AccelGroup *group = b->group;
    uint32_t number = GEOMETRY_KINDS + group->geometry_count;
    bool ok = true;
    if (group->pocket_count) {
        ok = attach(group,
                    user_geometry(b->device, group->pocket_count, group, bounds_pocket,
                                  intersect_pocket, occluded_pocket),
                    number++);
    }
    if (ok && group->instance_count) {
        ok = attach(group,
                    user_geometry(b->device, group->instance_count, group, bounds_instance,
                                  intersect_instance, occluded_instance),
                    number);
    }
    return ok;
}

// --- Hierarchies ------------------------------------------------------------------------------

// With so many rays for each primitive or fewer, a hierarchy that is built in a third of the time
// pays, though rays take a tenth longer in it (a million spheres, seen by two million rays).
#define QUICK_RAYS  4
#define QUICK_LEAST 10000 // primitives; below it no one waits

static uint64_t piece_count(const AccelGroup *group)
{
    uint64_t count = (uint64_t)group->quad_count + group->triangle_count + group->mesh_triangles +
                     group->pocket_count + group->instance_count;
    for (uint32_t k = 0; k < group->geometry_count; ++k) {
        count += group->geometries[k]->count;
    }
    return count;
}

// Of curved shapes, which are met in double precision in any hierarchy alike. The picture that the
// scene itself asks for decides, not the options of this run: what is rendered piece by piece, or
// goes on, has one hierarchy.
static bool is_quick(const AccelGroup *group)
{
    const uint64_t count = piece_count(group);
    if (count < QUICK_LEAST) {
        return false;
    }
    const FilmParams film = scene_film(group->accel->scene);
    const RenderParams render = scene_render(group->accel->scene);
    const double rays = 2.0 * (double)film.width * (double)film.height * (double)render.samples;
    return rays < QUICK_RAYS * (double)count;
}

static bool group_build(RTCDevice device, AccelGroup *group, AccelIssues *issues)
{
    const bool flat = group->quad_count + group->triangle_count + group->mesh_triangles > 0;
    if (box3_is_empty(group->bounds) ||
        (!flat && group->geometry_count + group->pocket_count + group->instance_count == 0)) {
        return true;
    }
    const size_t most = (size_t)GEOMETRY_KINDS + group->geometry_count;
    Build b = {.device = device,
               .group = group,
               .issues = issues,
               .pieces = mem_alloc_zeroed(most, sizeof *b.pieces)};
    RTCScene hierarchy = rtcNewScene(device);
    group->hierarchy = hierarchy;
    bool ok = hierarchy && b.pieces;
    if (ok) {
        // Robust: neighbouring pieces have no gaps.
        rtcSetSceneFlags(hierarchy,
                         flat ? RTC_SCENE_FLAG_ROBUST | SCENE_FLAG_FILTERED : RTC_SCENE_FLAG_NONE);
        if (!flat && is_quick(group)) {
            rtcSetSceneBuildQuality(hierarchy, RTC_BUILD_QUALITY_LOW);
            accel_make_runs(group);
        }
        ok = attach_table(&b) && attach_kinds(&b) && attach_groups(&b);
    }
    if (ok) {
        rtcCommitScene(hierarchy);
    }
    for (size_t i = 0; i < b.pieces_count; ++i) {
        pieces_free(&b.pieces[i]);
    }
    mem_free(b.pieces);
    return ok;
}

static void note_error(void *failed, enum RTCError code, const char *text)
{
    (void)code;
    (void)text;
    atomic_store((atomic_bool *)failed, true);
}

// Threads are worth it for so many pieces; and where the system refuses one, TBB, which Embree
// builds with, ends the program (it throws from a destructor).
static unsigned build_threads(const Accel *accel, unsigned wanted)
{
    enum { WORTH_THREADS = 10000 };
    uint64_t pieces = 0;
    for (uint32_t i = 0; i < accel->group_count; ++i) {
        pieces += piece_count(&accel->groups[i]);
    }
    return wanted > 1 && pieces >= WORTH_THREADS && thread_can_start(wanted) ? wanted : 1;
}

static bool build_groups(Accel *accel, RTCDevice device)
{
    atomic_bool failed = false;
    rtcSetDeviceErrorFunction(device, note_error, &failed);
    bool ok = true;
    for (uint32_t i = 0; ok && i < accel->group_count; ++i) {
        ok = group_build(device, &accel->groups[i], &accel->issues) && !atomic_load(&failed);
    }
    rtcSetDeviceErrorFunction(device, NULL, NULL);
    return ok;
}

// The device that builds without other threads. It is made once and stays: when the last device is
// given back, Embree lifts its limit of threads, and TBB starts some.
static bool build_alone(Accel *accel)
{
    static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    static RTCDevice device;
    pthread_mutex_lock(&mutex);
    if (!device) {
        device = rtcNewDevice("threads=1,hugepages=0");
    }
    const bool ok = device && build_groups(accel, device);
    pthread_mutex_unlock(&mutex);
    return ok;
}

static bool build_all(Accel *accel)
{
    const unsigned threads = build_threads(accel, accel->threads);
    if (threads == 1) {
        return build_alone(accel);
    }
    char config[64];
    snprintf(config, sizeof config, "threads=%u,hugepages=0", threads);
    RTCDevice device = rtcNewDevice(config);
    accel->device = device;
    return device && build_groups(accel, device);
}

Accel *accel_build(const Scene *scene, unsigned threads)
{
    Accel *accel = mem_alloc_zeroed(1, sizeof *accel);
    if (!accel) {
        return NULL;
    }
    accel->scene = scene;
    accel->threads = threads ? threads : thread_processor_count();
    if (!accel_collect(accel) || !accel_keep_maps(accel) || !accel_tabulate(accel) ||
        !build_all(accel)) {
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
