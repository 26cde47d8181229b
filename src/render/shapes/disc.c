#include "render/geometry.h"

typedef struct Disc {
    Vec3 center, normal;
    double radius, inner_radius;
} Disc;

static const Param disc_params[] = {
    {.name = "center",
     .type = PARAM_VEC3,
     PARAM_AT(Disc, center),
     .dims = DIM_BIT(DIM_LENGTH),
     .default_text = "(0, 0, 0)",
     .doc = "The middle."},
    {.name = "normal",
     .type = PARAM_VEC3,
     PARAM_AT(Disc, normal),
     .flags = PARAM_UNIT_VECTOR,
     .default_text = "(0, 1, 0)",
     .doc = "The direction in which its front side looks."},
    {.name = "radius",
     .type = PARAM_NUMBER,
     PARAM_AT(Disc, radius),
     .flags = PARAM_EXCLUDE_MIN,
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .default_text = "1",
     .doc = "Distance from the middle to the rim."},
    {.name = "inner_radius",
     .type = PARAM_NUMBER,
     PARAM_AT(Disc, inner_radius),
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .default_text = "0",
     .doc = "Radius of a round hole in the middle; 0: none."},
};

static bool disc_finish(NodeFinish *finish)
{
    const Disc *disc = finish->params;
    if (!(disc->inner_radius < disc->radius)) {
        finish->report(finish, 3, E0805,
                       "the inner radius of a disc is not smaller than its radius (%g)",
                       disc->radius);
        return false;
    }
    return true;
}

static Box3 disc_bounds(const Scene *scene, const void *params)
{
    (void)scene;
    const Disc *disc = params;
    Vec3 n = disc->normal;
    Vec3 r = scale(vec3(sqrt(fmax(0, 1 - n.x * n.x)), sqrt(fmax(0, 1 - n.y * n.y)),
                        sqrt(fmax(0, 1 - n.z * n.z))),
                   disc->radius);
    // The square root of a rounding error is no rounding error.
    double more = disc->radius * 1e-7;
    r = add(r, vec3(r.x < more ? more : 0, r.y < more ? more : 0, r.z < more ? more : 0));
    return (Box3){sub(disc->center, r), add(disc->center, r)};
}

static bool disc_intersect(const void *params, const Ray *ray, ShapeHit *hit)
{
    const Disc *disc = params;
    Vec3 from = sub(ray->origin, disc->center);
    double t = -dot(from, disc->normal) / dot(ray->direction, disc->normal);
    if (!(t > ray->tmin && t < ray->tmax)) {
        return false;
    }
    double r2 = length_squared(add_scaled(from, ray->direction, t));
    *hit = (ShapeHit){.t = t};
    return r2 <= disc->radius * disc->radius && r2 >= disc->inner_radius * disc->inner_radius;
}

// `from` is a vector from the middle, in the plane. u runs counter-clockwise seen from the front, v
// from the rim inwards, so that u x v is the front side, too.
static void disc_point_at(const Disc *disc, Vec3 from, ShapePoint *out)
{
    Frame frame = frame_from_normal(disc->normal);
    double x = dot(from, frame.s), y = dot(from, frame.t), r = sqrt(x * x + y * y);
    double around = atan2(y, x) / (2 * PI), ring = disc->radius - disc->inner_radius;
    bool middle = !(r > 1e-12 * disc->radius);
    *out = (ShapePoint){.p = add(disc->center, from),
                        .geometric = disc->normal,
                        .shading = disc->normal,
                        .tangent = middle ? frame.s : scale(cross(disc->normal, from), 2 * PI),
                        .bitangent = middle ? frame.t : scale(from, -ring / r),
                        .uv = {around < 0 ? around + 1 : around, (disc->radius - r) / ring},
                        .color = {1, 1, 1},
                        .error = rounding_error(max_abs(disc->center) + disc->radius)};
}

static void disc_point(const Scene *scene, const void *params, const Ray *ray, const ShapeHit *hit,
                       ShapePoint *out)
{
    (void)scene;
    const Disc *disc = params;
    Vec3 from = add_scaled(sub(ray->origin, disc->center), ray->direction, hit->t);
    disc_point_at(disc, add_scaled(from, disc->normal, -dot(from, disc->normal)), out);
}

static double disc_area(const Scene *scene, const void *params, const Affine *to_world)
{
    (void)scene;
    const Disc *disc = params;
    Affine cofactors = affine_cofactors(to_world);
    return PI * (disc->radius - disc->inner_radius) * (disc->radius + disc->inner_radius) *
           length(transform_vector(&cofactors, disc->normal));
}

static void disc_sample_area(const Scene *scene, const void *params, const Affine *to_world,
                             const void *table, double u0, double u1, double u2, ShapeSample *out)
{
    (void)table;
    (void)u2;
    const Disc *disc = params;
    double inner = disc->inner_radius * disc->inner_radius;
    double r = sqrt(inner + u0 * (disc->radius * disc->radius - inner));
    Frame frame = frame_from_normal(disc->normal);
    Vec3 from = add(scale(frame.s, r * cos(2 * PI * u1)), scale(frame.t, r * sin(2 * PI * u1)));
    disc_point_at(disc, from, &out->point);
    shape_point_map(to_world, &out->point);
    out->primitive = 0;
    out->pdf = 1 / disc_area(scene, params, to_world);
}

const ShapeClass disc_shape = {
    .node =
        {.name = "disc",
         .category = CATEGORY_SHAPE,
         .params = disc_params,
         .param_count = sizeof disc_params / sizeof *disc_params,
         .size = sizeof(Disc),
         .doc = "A flat disc, or a ring. u runs around the middle, v from the rim inwards, so "
                "that the tangent of a brushed disc follows its circles.",
         .formula = "(p - center) . normal = 0, inner_radius <= |p - center| <= radius",
         .example =
             "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
             "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: (0, 0, 1.5) "
             "}, radiance: 12 }\n"
             "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], space: \"uv\" } "
             "}\n"
             "plane { material: lambert { color: gray(0.5) } }\n"
             "let clay = lambert { color: #c0704a }\n"
             "disc { center: (-0.7, 0.5, 0), normal: (0.3, 0.2, 1), radius: 0.5, material: clay }\n"
             "disc {\n"
             "  center: (0.6, 0.55, 0)\n"
             "  normal: (-0.4, 0.3, 1)\n"
             "  radius: 0.55\n"
             "  inner_radius: 0.3\n"
             "  material: clay\n"
             "}",
         .finish = disc_finish,
         .bounds = disc_bounds},
    .holding = HOLD_USER,
    .flat = true,
    .closed = shape_is_open,
    .intersect = disc_intersect,
    .point = disc_point,
    .area = disc_area,
    .sample_area = disc_sample_area,
};
