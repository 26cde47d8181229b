#include "render/geometry.h"

typedef struct Plane {
    Vec3 point, normal;
} Plane;

static const Param plane_params[] = {
    {.name = "point",
     .type = PARAM_VEC3,
     PARAM_AT(Plane, point),
     .dims = DIM_BIT(DIM_LENGTH),
     .default_text = "(0, 0, 0)",
     .doc = "Any point of the plane, where uv = (0, 0)."},
    {.name = "normal",
     .type = PARAM_VEC3,
     PARAM_AT(Plane, normal),
     .flags = PARAM_UNIT_VECTOR,
     .default_text = "(0, 1, 0)",
     .doc = "The direction in which its front side looks."},
};

static Box3 plane_bounds(const Scene *scene, const void *params)
{
    (void)scene;
    (void)params;
    return (Box3){{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
}

static bool plane_intersect(const void *params, const Ray *ray, ShapeHit *hit)
{
    const Plane *plane = params;
    double height = dot(sub(ray->origin, plane->point), plane->normal);
    *hit = (ShapeHit){.t = -height / dot(ray->direction, plane->normal)};
    return hit->t > ray->tmin && hit->t < ray->tmax;
}

// The axes of u and v, in metres: for a floor (normal +y) u is +x and v is -z.
static Frame plane_frame(const Plane *plane)
{
    return frame_from_tangent(plane->normal,
                              fabs(plane->normal.x) < 0.9 ? vec3(1, 0, 0) : vec3(0, 0, -1));
}

// From the plane's point.
static Vec3 plane_way(const Plane *plane, const Ray *ray, const ShapeHit *hit)
{
    const Vec3 from = add_scaled(sub(ray->origin, plane->point), ray->direction, hit->t);
    return add_scaled(from, plane->normal, -dot(from, plane->normal));
}

static ShapePoint plane_plain_point(const Plane *plane, Vec3 from)
{
    return (ShapePoint){.p = add(plane->point, from),
                        .geometric = plane->normal,
                        .shading = plane->normal,
                        .error = rounding_error(max_abs(plane->point) + length(from))};
}

static void plane_place(const void *params, const Ray *ray, const ShapeHit *hit, ShapePoint *out)
{
    *out = plane_plain_point(params, plane_way(params, ray, hit));
}

static void plane_point(const Scene *scene, const void *params, const Ray *ray, const ShapeHit *hit,
                        ShapePoint *out)
{
    (void)scene;
    const Vec3 from = plane_way(params, ray, hit);
    const Frame frame = plane_frame(params);
    *out = plane_plain_point(params, from);
    out->tangent = frame.s;
    out->bitangent = frame.t;
    out->uv = (Vec2){dot(from, frame.s), dot(from, frame.t)};
    out->color = rgb_gray(1);
}

const ShapeClass plane_shape = {
    .node = {.name = "plane",
             .category = CATEGORY_SHAPE,
             .params = plane_params,
             .param_count = sizeof plane_params / sizeof *plane_params,
             .size = sizeof(Plane),
             .doc = "An infinite plane. Its uv are metres from `point`; on a floor u runs along +x "
                    "and v along -z. It can't be a light, since its area has no end.",
             .formula = "(p - point) . normal = 0",
             .example =
                 "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                 "directional_light { direction: (-1, -1, -1), irradiance: 3 }\n"
                 "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], space: "
                 "\"uv\" } }\n"
                 "plane { material: lambert { color: checker { space: \"world\", scale: 2 } } }\n"
                 "plane { point: (0, 0, -3), normal: (0, 0, 1), material: lambert { color: #b0603c "
                 "} }\n"
                 "sphere { center: (0, 0.5, 0), radius: 0.5 }",
             .bounds = plane_bounds},
    .holding = HOLD_UNBOUNDED,
    .closed = shape_is_open,
    .intersect = plane_intersect,
    .point = plane_point,
    .place = plane_place,
};
