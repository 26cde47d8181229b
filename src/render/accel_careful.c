// The careful way through a group: what single precision proposes is decided one by one; see
// accel_parts.h.
#include "render/accel_embree.h"

typedef struct CarefulQuery {
    Query base;   // first: what Embree hands to callbacks
    Hit doubtful; // the nearest such
    FlatRay flat; // the ray for the transform of the last flat shape tried
} CarefulQuery;

// The smallest float not below x.
static float float_up(double x)
{
    float f = (float)x;
    return (double)f < x ? nextafterf(f, INFINITY) : f;
}

static const Box3 unit_cube = {{-1, -1, -1}, {1, 1, 1}};

// Fills the query and Embree's ray. The float ray begins where the true one comes near the group,
// so that its rounding is relative to the group's size and not to the distance. False where it
// never does.
static bool query_begin(CarefulQuery *careful, const AccelGroup *group, const Ray *ray,
                        uint32_t instance, Hit *hit, struct RTCRay *out)
{
    Query *q = &careful->base;
    Ray local = ray_make(scale(sub(ray->origin, group->center), group->inverse_scale),
                         ray->direction, 0, 0);
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
    q->careful = true;
    q->reported = -1;
    q->hit = hit;
    careful->doubtful.t = INFINITY;
    careful->flat.transform = NONE_ID;
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

// Is a doubtful hit nearer than the one known, and far enough from the ray's ends to count?
static bool doubtful_counts(const CarefulQuery *q, double t)
{
    const double certain = FLAT_CERTAIN / q->base.speed;
    return t < q->doubtful.t && t > q->base.ray->tmin + certain && t < q->base.ray->tmax - certain;
}

// Decides in double precision on one primitive of a flat or mesh shape.
static FlatHit decide(CarefulQuery *q, const AccelKind *kind, uint32_t shape, uint32_t primitive,
                      ShapeHit *local)
{
    const Scene *scene = kind->accel->scene;
    const uint32_t transform =
        kind->mesh ? kind->transform : scene_node(scene, CATEGORY_SHAPE, shape)->transform;
    if (transform != q->flat.transform) {
        flat_ray_prepare(scene, transform, q->base.ray, &q->flat);
    }
    return accel_flat_hit(kind, shape, primitive, &q->flat, q->base.tmax, local);
}

// Takes what was decided: true where the hit is certain.
static bool take(CarefulQuery *q, FlatHit found, uint32_t shape, const ShapeHit *local,
                 uint32_t flat)
{
    Hit *to = NULL;
    if (found == FLAT_BESIDE && doubtful_counts(q, local->t)) {
        to = &q->doubtful;
    } else if (found == FLAT_INSIDE && q->base.hit) {
        q->base.tmax = local->t;
        to = q->base.hit;
    }
    if (to) {
        *to = (Hit){.t = local->t,
                    .shape = shape,
                    .instance = q->base.instance,
                    .local = *local,
                    .flat = flat};
        if (flat <= q->base.group->accel->flat_count) {
            accel_complete_hit(q->base.group->accel, to);
        }
    }
    return found == FLAT_INSIDE;
}

// Tries one piece of the table.
static bool try_flat(CarefulQuery *q, uint32_t number)
{
    const AccelFlat *flat = &q->base.group->accel->flats[number];
    bool certain = false;
    for (uint32_t i = 0; i <= flat->pair; ++i) {
        ShapeHit local;
        const FlatHit found = decide(q, flat->kind, flat->shape, flat->primitive + i, &local);
        certain = take(q, found, flat->shape, &local, number + 1) || certain;
    }
    return certain;
}

static bool try_triangle(CarefulQuery *q, const AccelKind *kind, uint32_t triangle, uint32_t number)
{
    ShapeHit local;
    const FlatHit found = decide(q, kind, kind->ids[0], triangle, &local);
    return take(q, found, kind->ids[0], &local, number + 1);
}

static void filter_flat(const struct RTCFilterFunctionNArguments *args)
{
    if (!args->valid[0]) {
        return;
    }
    CarefulQuery *q = (CarefulQuery *)(void *)args->context;
    const AccelGroup *group = q->base.group;
    const RayEnds *ends = &q->base.ray->ends;
    const struct RTCHit *hit = (const struct RTCHit *)(const void *)args->hit;
    const bool tabled = hit->geomID < GEOMETRY_KINDS;
    const AccelKind *kind = tabled ? NULL : group->geometries[hit->geomID - GEOMETRY_KINDS];
    const uint32_t number =
        hit->primID + (tabled ? accel_first_flat(group, hit->geomID) : kind->first);
    // A ray doesn't meet the plane piece again that it leaves.
    const bool own = number + 1 == ends->flat && q->base.instance == ends->instance;
    const bool certain =
        !own && (tabled ? try_flat(q, number) : try_triangle(q, kind, hit->primID, number));
    if (!certain) {
        args->valid[0] = 0;
    }
}

#if RTC_VERSION_MAJOR >= 4
#define CAREFUL_ARGUMENTS(name, init)                                                              \
    init(&(name));                                                                                 \
    (name).context = &q.base.embree;                                                               \
    (name).filter = filter_flat;                                                                   \
    (name).flags |= RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER
#endif

bool careful_intersect(const AccelGroup *group, const Ray *ray, uint32_t instance, Hit *hit)
{
    CarefulQuery q;
    struct RTCRayHit rayhit;
    if (!group->hierarchy || !query_begin(&q, group, ray, instance, hit, &rayhit.ray)) {
        return false;
    }
    rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    CAREFUL_ARGUMENTS(arguments, rtcInitIntersectArguments);
    rtcIntersect1((RTCScene)group->hierarchy, &rayhit, &arguments);
#else
    q.base.embree.filter = filter_flat;
    rtcIntersect1((RTCScene)group->hierarchy, &q.base.embree, &rayhit);
#endif
    // The callback that found it left it in *hit.
    const bool found = rayhit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    if (q.doubtful.t < q.base.tmax &&
        !(found && q.base.tmax - q.doubtful.t < RAY_MARGIN / q.base.speed)) {
        *hit = q.doubtful;
    } else if (!found) {
        return false;
    }
    return true;
}

bool careful_occluded(const AccelGroup *group, const Ray *ray, uint32_t instance)
{
    CarefulQuery q;
    struct RTCRay embree_ray;
    if (!group->hierarchy || !query_begin(&q, group, ray, instance, NULL, &embree_ray)) {
        return false;
    }
#if RTC_VERSION_MAJOR >= 4
    struct RTCOccludedArguments arguments;
    CAREFUL_ARGUMENTS(arguments, rtcInitOccludedArguments);
    rtcOccluded1((RTCScene)group->hierarchy, &embree_ray, &arguments);
#else
    q.base.embree.filter = filter_flat;
    rtcOccluded1((RTCScene)group->hierarchy, &q.base.embree, &embree_ray);
#endif
    return embree_ray.tfar < 0 || q.doubtful.t < q.base.tmax;
}
