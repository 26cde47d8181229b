// Rays through the accelerator's groups by the fast way, and the callbacks of both ways; see
// accel_parts.h.
#include "base/hot.h"
#include "render/accel_embree.h"
#include "render/accel_local.h"

// --- Rays -------------------------------------------------------------------------------------

// Whether the point of a surface to which a ray leads may be one of this instance's.
static bool ends_in_instance(const AccelGroup *group, const Ray *ray)
{
    const Vec3 end = add_scaled(ray->origin, ray->direction, ray->tmax);
    const double margin = 0x1p-10 * group->scale;
    return max_component(sub(end, group->bounds.max)) < margin &&
           max_component(sub(group->bounds.min, end)) < margin;
}

// Fills the query and Embree's ray; see accel_parts.h for where it begins and ends. `any`: for
// finding out whether anything is hit. False where the careful way has to be taken.
static bool query_begin(Query *q, const AccelGroup *group, const Ray *ray, const LocalRay *local,
                        uint32_t instance, bool any, Hit *hit, struct RTCRay *out)
{
    Vec3 origin = local_start(local);
    const Vec3 direction = local->direction;
    double end = local->end - local->begin;
    if (accel_leaves_piece(group, ray, instance)) {
        const Vec3 normal = accel_ends_normal(&ray->ends);
        if (ray->ends.near_edge || !(dot(direction, normal) >= LIFT_LEAST_COSINE)) {
            return false;
        }
        origin = add_scaled(origin, normal, FLAT_LIFT);
    }
    const double facing = (double)ray->ends.facing;
    if (any && facing > 0) {
        if (facing < LIFT_LEAST_COSINE || (instance != NONE_ID && ends_in_instance(group, ray))) {
            return false;
        }
        end -= 2 * FLAT_LIFT / facing; // one for the ray's own lift
    }
    query_context_init(&q->embree);
    q->group = group;
    q->ray = ray;
    q->tmax = ray->tmax;
    q->speed = local->speed;
    q->start = local->begin;
    q->instance = instance;
    q->careful = false;
    q->reported = -1;
    q->hit = hit;
    *out = (struct RTCRay){.org_x = (float)origin.x,
                           .org_y = (float)origin.y,
                           .org_z = (float)origin.z,
                           .dir_x = (float)direction.x,
                           .dir_y = (float)direction.y,
                           .dir_z = (float)direction.z,
                           .tfar = (float)end,
                           .mask = UINT32_MAX};
    return end > 0;
}

// Decides in double precision on the flat piece that was found.
static bool accept(const AccelGroup *group, const Ray *ray, uint32_t instance,
                   const struct RTCHit *found, Hit *hit)
{
    const uint32_t geometry = found->geomID;
    const bool met =
        geometry < GEOMETRY_KINDS
            ? accel_meet_flat(group->accel, accel_first_flat(group, geometry) + found->primID, ray,
                              instance, hit)
            : accel_meet_mesh(group->geometries[geometry - GEOMETRY_KINDS], found->primID, ray,
                              instance, hit);
    return met && !(hit->flat == ray->ends.flat && instance == ray->ends.instance);
}

static bool is_flat(const AccelGroup *group, uint32_t geometry)
{
    return geometry < GEOMETRY_KINDS || (geometry - GEOMETRY_KINDS < group->geometry_count &&
                                         group->geometries[geometry - GEOMETRY_KINDS]->mesh);
}

// The nearest hit in the group's hierarchy.
// By value: a local ray whose address is known lives in memory, where a sweep would wait for it.
static bool hierarchy_intersect(const AccelGroup *group, const Ray *ray, const LocalRay local,
                                uint32_t instance, Hit *hit)
{
    Query q;
    struct RTCRayHit rayhit;
    if (!query_begin(&q, group, ray, &local, instance, false, hit, &rayhit.ray)) {
        return careful_intersect(group, ray, instance, hit);
    }
    rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &q.embree;
    rtcIntersect1((RTCScene)group->hierarchy, &rayhit, &arguments);
#else
    rtcIntersect1((RTCScene)group->hierarchy, &q.embree, &rayhit);
#endif
    if (rayhit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
        return false;
    }
    if (!is_flat(group, rayhit.hit.geomID)) {
        return true; // the callback that found it left it in *hit
    }
    Hit flat;
    if (!accept(group, ray, instance, &rayhit.hit, &flat)) {
        return careful_intersect(group, ray, instance, hit);
    }
    *hit = flat;
    return true;
}

APART static bool intersect_both(const AccelGroup *group, const Ray *ray, uint32_t instance,
                                 Hit *hit)
{
    LocalRay local;
    if (!local_ray(group, ray, instance, &local)) {
        return false;
    }
    const SweepRay swept = sweep_ray(&local);
    if (!group->sweep_count ||
        !accel_sweep_intersect(group, ray, &swept, local.begin, local.speed, instance, hit)) {
        return hierarchy_intersect(group, ray, local, instance, hit);
    }
    Ray nearer = *ray;
    nearer.tmax = hit->t;
    local.end = smaller(local.end, hit->t * local.speed);
    hierarchy_intersect(group, &nearer, local, instance, hit);
    return true;
}

HOT bool group_intersect(const AccelGroup *group, const Ray *ray, uint32_t instance, Hit *hit)
{
    return group->hierarchy ? intersect_both(group, ray, instance, hit)
                            : group->way->intersect(group, ray, instance, hit);
}

static bool hierarchy_occluded(const AccelGroup *group, const Ray *ray, const LocalRay local,
                               uint32_t instance)
{
    Query q;
    struct RTCRay embree_ray;
    if (!query_begin(&q, group, ray, &local, instance, true, NULL, &embree_ray)) {
        return careful_occluded(group, ray, instance);
    }
#if RTC_VERSION_MAJOR >= 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &q.embree;
    rtcOccluded1((RTCScene)group->hierarchy, &embree_ray, &arguments);
#else
    rtcOccluded1((RTCScene)group->hierarchy, &q.embree, &embree_ray);
#endif
    return embree_ray.tfar < 0;
}

APART static bool occluded_by_both(const AccelGroup *group, const Ray *ray, uint32_t instance)
{
    LocalRay local;
    if (!local_ray(group, ray, instance, &local)) {
        return false;
    }
    const SweepRay swept = sweep_ray(&local);
    return (group->sweep_count && accel_sweep_occluded(group, ray, &swept, instance)) ||
           hierarchy_occluded(group, ray, local, instance);
}

HOT bool group_occluded(const AccelGroup *group, const Ray *ray, uint32_t instance)
{
    return group->hierarchy ? occluded_by_both(group, ray, instance)
                            : group->way->occluded(group, ray, instance);
}

// --- Callbacks: shapes ------------------------------------------------------------------------

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

// Which of a run's balls the ray may meet before its end: a bit each. What lies exactly at the
// margin may. False alarms cost time alone.
static inline uint32_t balls_near(const BallRun *balls, const struct RTCRay *ray, float far)
{
    typedef float Four __attribute__((vector_size(16)));
    typedef int32_t FourInts __attribute__((vector_size(16)));
    Four x, y, z, radius;
    memcpy(&x, balls->x, sizeof x);
    memcpy(&y, balls->y, sizeof y);
    memcpy(&z, balls->z, sizeof z);
    memcpy(&radius, balls->radius, sizeof radius);
    x -= ray->org_x;
    y -= ray->org_y;
    z -= ray->org_z;
    const Four along = x * ray->dir_x + y * ray->dir_y + z * ray->dir_z;
    x -= along * ray->dir_x;
    y -= along * ray->dir_y;
    z -= along * ray->dir_z;
    radius += (float)BALL_MARGIN;
    const FourInts near = (x * x + y * y + z * z <= radius * radius) & (along - radius <= far);
    uint32_t bits = 0;
    for (int i = 0; i < RUN_LONGEST; ++i) {
        bits |= (uint32_t)near[i] & UINT32_C(1) << i;
    }
    return bits;
}

// A ray through a run of a kind's shapes, up to tmax.
typedef struct RunRay {
    const AccelKind *kind;
    uint32_t primitive;
    const struct RTCRay *embree;
    const Ray *ray;
    double tmax;
    float far; // Embree's length beyond which nothing is looked for
} RunRay;

// The number of the nearest shape of a run that is hit, its hit in *hit; NONE_ID: none is.
static inline uint32_t run_hit(const RunRay *run, ShapeHit *hit)
{
    const AccelKind *kind = run->kind;
    uint32_t found = NONE_ID;
    double tmax = run->tmax;
    if (kind->balls) {
        uint32_t near = balls_near(&kind->balls[run->primitive], run->embree, run->far);
        if (!near) {
            return NONE_ID;
        }
        const uint32_t begin = kind->runs[run->primitive];
        Ray ray = *run->ray;
        for (; near; near &= near - 1) {
            const uint32_t i = begin + (uint32_t)__builtin_ctz(near);
            ray.tmax = tmax;
            if (kind->class->intersect(kind->row + i * kind->class->node.size, &ray, hit)) {
                tmax = hit->t;
                found = i;
            }
        }
        return found;
    }
    const uint32_t end = accel_run_begin(kind, run->primitive + 1);
    for (uint32_t i = accel_run_begin(kind, run->primitive); i < end; ++i) {
        if (shape_hit(kind, kind->ids[i], run->ray, tmax, hit)) {
            tmax = hit->t;
            found = i;
        }
    }
    return found;
}

// How far along its ray a query still looks: on the fast way Embree alone knows of flat pieces.
static double query_tmax(const Query *q, const struct RTCRay *ray)
{
    return q->careful || ray->tfar == q->reported
               ? q->tmax
               : smaller(q->tmax, ((double)ray->tfar + q->start) / q->speed);
}

// Tells Embree of a hit that is in *q->hit. It goes on a little beyond, so that what single
// precision would place behind by mistake is tried.
static void report_hit(Query *q, const struct RTCIntersectFunctionNArguments *args)
{
    struct RTCRayHit *rayhit = (struct RTCRayHit *)(void *)args->rayhit;
    q->tmax = q->hit->t;
    const double beyond = q->careful ? FLAT_GROWTH : 0x1p-23;
    q->reported = (float)(q->tmax * q->speed - q->start + beyond);
    rayhit->ray.tfar = q->reported < rayhit->ray.tfar ? q->reported : rayhit->ray.tfar;
    rayhit->hit.geomID = args->geomID;
    rayhit->hit.primID = args->primID;
}

void intersect_shape(const struct RTCIntersectFunctionNArguments *args)
{
    if (!args->valid[0]) {
        return;
    }
    const AccelKind *kind = args->geometryUserPtr;
    Query *q = (Query *)(void *)args->context;
    const struct RTCRay *ray = (const struct RTCRay *)(const void *)args->rayhit;
    const RunRay run = {kind, args->primID, ray, q->ray, query_tmax(q, ray), ray->tfar};
    ShapeHit local;
    const uint32_t found = run_hit(&run, &local);
    if (found != NONE_ID) {
        *q->hit =
            (Hit){.t = local.t, .shape = kind->ids[found], .instance = q->instance, .local = local};
        // For the surface, which asks for it when the ray has passed what else is near.
        __builtin_prefetch(scene_node(kind->accel->scene, CATEGORY_SHAPE, q->hit->shape));
        report_hit(q, args);
    }
}

void occluded_shape(const struct RTCOccludedFunctionNArguments *args)
{
    if (!args->valid[0]) {
        return;
    }
    const AccelKind *kind = args->geometryUserPtr;
    Query *q = (Query *)(void *)args->context;
    struct RTCRay *ray = (struct RTCRay *)(void *)args->ray;
    const RunRay run = {kind, args->primID, ray, q->ray, q->tmax, INFINITY};
    ShapeHit local;
    if (run_hit(&run, &local) != NONE_ID) {
        ray->tfar = -INFINITY;
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
    out->ray.ends = q->ray->ends;
    double begin = out->ray.tmin, end = tmax;
    return ray_clip(&out->ray, out->group->bounds, out->group->scale * BOX_MARGIN, &begin, &end);
}

typedef bool Pass(const Query *q, uint32_t primitive, double tmax, Passage *out);

static void intersect_passage(const struct RTCIntersectFunctionNArguments *args, Pass *pass)
{
    Query *q = (Query *)(void *)args->context;
    Passage inner;
    Hit hit;
    if (!args->valid[0]) {
        return;
    }
    const double tmax = query_tmax(q, (const struct RTCRay *)(const void *)args->rayhit);
    if (pass(q, args->primID, tmax, &inner) &&
        group_intersect(inner.group, &inner.ray, inner.instance, &hit)) {
        *q->hit = hit;
        report_hit(q, args);
    }
}

static void occluded_passage(const struct RTCOccludedFunctionNArguments *args, Pass *pass)
{
    Query *q = (Query *)(void *)args->context;
    Passage inner;
    if (args->valid[0] && pass(q, args->primID, q->tmax, &inner) &&
        group_occluded(inner.group, &inner.ray, inner.instance)) {
        ((struct RTCRay *)(void *)args->ray)->tfar = -INFINITY;
    }
}

void intersect_pocket(const struct RTCIntersectFunctionNArguments *args)
{
    intersect_passage(args, pass_to_pocket);
}
void occluded_pocket(const struct RTCOccludedFunctionNArguments *args)
{
    occluded_passage(args, pass_to_pocket);
}
void intersect_instance(const struct RTCIntersectFunctionNArguments *args)
{
    intersect_passage(args, pass_to_instance);
}
void occluded_instance(const struct RTCOccludedFunctionNArguments *args)
{
    occluded_passage(args, pass_to_instance);
}

// --- Queries ----------------------------------------------------------------------------------

APART static bool intersect_unbounded(const Accel *accel, const Ray *ray, Hit *hit)
{
    if (!accel_unbounded_hit(accel, ray, hit)) {
        return group_intersect(&accel->groups[0], ray, NONE_ID, hit);
    }
    Ray nearer = *ray;
    nearer.tmax = hit->t;
    group_intersect(&accel->groups[0], &nearer, NONE_ID, hit);
    return true;
}

HOT bool accel_intersect(const Accel *accel, const Ray *ray, Hit *hit)
{
    return accel->unbounded_count ? intersect_unbounded(accel, ray, hit)
                                  : group_intersect(&accel->groups[0], ray, NONE_ID, hit);
}

APART static bool occluded_by_unbounded(const Accel *accel, const Ray *ray)
{
    Hit hit;
    return accel_unbounded_hit(accel, ray, &hit);
}

HOT bool accel_occluded(const Accel *accel, const Ray *ray)
{
    return (accel->unbounded_count && occluded_by_unbounded(accel, ray)) ||
           group_occluded(&accel->groups[0], ray, NONE_ID);
}
