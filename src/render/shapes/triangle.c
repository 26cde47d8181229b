#include "render/shapes/flat.h"

typedef struct Triangle {
    Vec3 a, b, c;
} Triangle;

static const Param triangle_params[] = {
    {.name = "a",
     .type = PARAM_VEC3,
     PARAM_AT(Triangle, a),
     .flags = PARAM_REQUIRED,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The first corner, where uv = (0, 0)."},
    {.name = "b",
     .type = PARAM_VEC3,
     PARAM_AT(Triangle, b),
     .flags = PARAM_REQUIRED,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The second corner, where uv = (1, 0)."},
    {.name = "c",
     .type = PARAM_VEC3,
     PARAM_AT(Triangle, c),
     .flags = PARAM_REQUIRED,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The third corner, where uv = (0, 1)."},
};

static bool triangle_finish(NodeFinish *finish)
{
    const Triangle *t = finish->params;
    Vec3 u = sub(t->b, t->a), v = sub(t->c, t->a);
    double uu = length_squared(u), vv = length_squared(v), ww = length_squared(sub(t->c, t->b));
    if (!(uu > 0 && vv > 0 && ww > 0)) {
        finish->report(finish, uu > 0 ? 2 : 1, E0801,
                       "two corners of a triangle are the same point");
        return false;
    }
    if (!(length_squared(cross(u, v)) > 1e-24 * uu * vv)) {
        finish->report(finish, 2, E0802, "the corners of a triangle lie on one line");
        return false;
    }
    return true;
}

static Box3 triangle_bounds(const Scene *scene, const void *params)
{
    (void)scene;
    const Triangle *t = params;
    return box3_add(box3_add(box3_add(box3_empty(), t->a), t->b), t->c);
}

static int triangle_corners(const void *params, Vec3 out[4])
{
    const Triangle *t = params;
    out[0] = t->a;
    out[1] = t->b;
    out[2] = t->c;
    return 3;
}

static bool triangle_intersect(const void *params, const Ray *ray, ShapeHit *hit)
{
    const Triangle *t = params;
    return flat_meet(t->a, sub(t->b, t->a), sub(t->c, t->a), ray, hit) && hit->t > ray->tmin &&
           hit->t < ray->tmax && hit->u >= 0 && hit->v >= 0 && hit->u + hit->v <= 1;
}

static void triangle_point_at(const Triangle *t, double u, double v, ShapePoint *out)
{
    flat_point(t->a, sub(t->b, t->a), sub(t->c, t->a), u, v, out);
}

static void triangle_point(const Scene *scene, const void *params, const Ray *ray,
                           const ShapeHit *hit, ShapePoint *out)
{
    (void)scene;
    (void)ray;
    triangle_point_at(params, hit->u, hit->v, out);
}

static double triangle_area(const Scene *scene, const void *params, const Affine *to_world)
{
    (void)scene;
    const Triangle *t = params;
    return 0.5 * flat_area(sub(t->b, t->a), sub(t->c, t->a), to_world);
}

static void triangle_sample_area(const Scene *scene, const void *params, const Affine *to_world,
                                 const void *table, double u0, double u1, double u2,
                                 ShapeSample *out)
{
    (void)table;
    (void)u2;
    double root = sqrt(u0);
    triangle_point_at(params, 1 - root, u1 * root, &out->point);
    shape_point_map(to_world, &out->point);
    out->primitive = 0;
    out->pdf = 1 / triangle_area(scene, params, to_world);
}

// The triangle as seen from a reference point: unit directions of its corners, and the angles
// there.
typedef struct SphericalTriangle {
    Vec3 a, b, c;
    double alpha, angle_sum, solid_angle;
} SphericalTriangle;

static double angle_between(Vec3 a, Vec3 b)
{
    return atan2(length(cross(a, b)), dot(a, b));
}

// False where the reference lies in the plane, or the solid angle is too small for its sum of
// angles.
static bool spherical_triangle(const Triangle *t, const Affine *to_world, Vec3 reference,
                               SphericalTriangle *out)
{
    Vec3 a = sub(transform_point(to_world, t->a), reference);
    Vec3 b = sub(transform_point(to_world, t->b), reference);
    Vec3 c = sub(transform_point(to_world, t->c), reference);
    double la = length(a), lb = length(b), lc = length(c);
    double volume = fabs(dot(a, cross(b, c)));
    if (!(volume > 1e-9 * la * lb * lc)) {
        return false;
    }
    out->a = scale(a, 1 / la);
    out->b = scale(b, 1 / lb);
    out->c = scale(c, 1 / lc);
    Vec3 ab = cross(out->a, out->b), bc = cross(out->b, out->c), ca = cross(out->c, out->a);
    out->alpha = angle_between(ab, neg(ca));
    out->angle_sum = out->alpha + angle_between(bc, neg(ab)) + angle_between(ca, neg(bc));
    out->solid_angle = out->angle_sum - PI;
    return out->solid_angle > FLAT_LEAST_SOLID_ANGLE;
}

// The unit vector along the part of v that is perpendicular to the unit vector n.
static Vec3 perpendicular_part(Vec3 v, Vec3 n)
{
    return normalize(add_scaled(v, n, -dot(v, n)));
}

// Arvo 1995, "Stratified Sampling of Spherical Triangles".
static Vec3 spherical_triangle_direction(const SphericalTriangle *q, double u0, double u1)
{
    double area = PI + u0 * q->solid_angle; // of the part up to the chosen edge, plus pi
    double cos_alpha = cos(q->alpha), sin_alpha = sin(q->alpha);
    double sin_phi = sin(area) * cos_alpha - cos(area) * sin_alpha;
    double cos_phi = cos(area) * cos_alpha + sin(area) * sin_alpha;
    double k1 = cos_phi + cos_alpha, k2 = sin_phi - sin_alpha * dot(q->a, q->b);
    double cos_side = (k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) /
                      ((k2 * sin_phi + k1 * cos_phi) * sin_alpha);
    cos_side = isfinite(cos_side) ? fmin(fmax(cos_side, -1), 1) : 1;
    Vec3 across = perpendicular_part(q->c, q->a);
    Vec3 c = add(scale(q->a, cos_side), scale(across, sqrt(fmax(0, 1 - cos_side * cos_side))));
    double along = u1 * (1 - dot(c, q->b)); // 1 - cos of the angle from b towards c
    Vec3 side = perpendicular_part(c, q->b);
    return add(scale(q->b, 1 - along), scale(side, sqrt(fmax(0, along * (2 - along)))));
}

static bool triangle_sample_solid_angle(const void *params, const Affine *to_world,
                                        const void *table, Vec3 reference, double u0, double u1,
                                        ShapeSample *out)
{
    (void)table;
    const Triangle *t = params;
    SphericalTriangle q;
    if (!spherical_triangle(t, to_world, reference, &q)) {
        return false;
    }
    Vec3 a = transform_point(to_world, t->a);
    Ray ray = ray_make(reference, spherical_triangle_direction(&q, u0, u1), 0, INFINITY);
    ShapeHit hit;
    if (!flat_meet(a, sub(transform_point(to_world, t->b), a),
                   sub(transform_point(to_world, t->c), a), &ray, &hit)) {
        return false;
    }
    double u = fmin(fmax(hit.u, 0), 1), v = fmin(fmax(hit.v, 0), 1), sum = fmax(u + v, 1);
    triangle_point_at(t, u / sum, v / sum, &out->point);
    shape_point_map(to_world, &out->point);
    out->primitive = 0;
    out->pdf = 1 / q.solid_angle;
    return true;
}

static double triangle_solid_angle_pdf(const void *params, const Affine *to_world,
                                       const void *table, Vec3 reference, Vec3 direction)
{
    (void)table;
    (void)direction;
    SphericalTriangle q;
    return spherical_triangle(params, to_world, reference, &q) ? 1 / q.solid_angle : 0;
}

const ShapeClass triangle_shape = {
    .node = {.name = "triangle",
             .category = CATEGORY_SHAPE,
             .params = triangle_params,
             .param_count = sizeof triangle_params / sizeof *triangle_params,
             .size = sizeof(Triangle),
             .doc = "A flat triangle. Its front side is that from which its corners run "
                    "counter-clockwise. For more than a few, use a mesh.",
             .formula = "p = (1 - u - v) a + u b + v c. As a light it is sampled by solid angle "
                        "(Arvo 1995).",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "let clay = lambert { color: #c0704a }\n"
                        "for (i in 0..4) {\n"
                        "  triangle {\n"
                        "    a: (0.5 * i - 1.3, 0, 0.3), b: (0.5 * i - 0.8, 0, 0.1), c: (0.5 * i - "
                        "1.1, 0.9 - 0.1 * i, -0.2)\n"
                        "    material: clay\n"
                        "  }\n"
                        "}",
             .finish = triangle_finish,
             .bounds = triangle_bounds},
    .holding = HOLD_FLAT,
    .flat = true,
    .closed = shape_is_open,
    .intersect = triangle_intersect,
    .point = triangle_point,
    .corners = triangle_corners,
    .area = triangle_area,
    .sample_area = triangle_sample_area,
    .sample_solid_angle = triangle_sample_solid_angle,
    .solid_angle_pdf = triangle_solid_angle_pdf,
};
