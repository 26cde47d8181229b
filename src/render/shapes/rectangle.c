#include "render/shapes/flat.h"

typedef struct Rectangle {
    Vec3 corner, u, v;
} Rectangle;

static const Param rectangle_params[] = {
    {.name = "corner",
     .type = PARAM_VEC3,
     PARAM_AT(Rectangle, corner),
     .flags = PARAM_REQUIRED,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "One corner."},
    {.name = "u",
     .type = PARAM_VEC3,
     PARAM_AT(Rectangle, u),
     .flags = PARAM_REQUIRED,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The edge from the corner along which u grows from 0 to 1."},
    {.name = "v",
     .type = PARAM_VEC3,
     PARAM_AT(Rectangle, v),
     .flags = PARAM_REQUIRED,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The edge from the corner along which v grows from 0 to 1; the front side is u x v."},
};

static bool rectangle_finish(NodeFinish *finish)
{
    const Rectangle *r = finish->params;
    double uu = length_squared(r->u), vv = length_squared(r->v);
    if (!(uu > 0)) {
        finish->report(finish, 1, E0801, "the edge `u` of a rectangle has no length");
    }
    if (!(vv > 0)) {
        finish->report(finish, 2, E0801, "the edge `v` of a rectangle has no length");
    }
    if (!(uu > 0 && vv > 0)) {
        return false;
    }
    if (!(length_squared(cross(r->u, r->v)) > 1e-24 * uu * vv)) {
        finish->report(finish, 2, E0802, "the edges `u` and `v` of a rectangle are parallel");
        return false;
    }
    return true;
}

static Box3 rectangle_bounds(const Scene *scene, const void *params)
{
    (void)scene;
    const Rectangle *r = params;
    Vec3 a = add(r->corner, r->u);
    Box3 box = box3_add(box3_add(box3_empty(), r->corner), a);
    return box3_add(box3_add(box, add(r->corner, r->v)), add(a, r->v));
}

static int rectangle_corners(const void *params, Vec3 out[4])
{
    const Rectangle *r = params;
    out[0] = r->corner;
    out[1] = add(r->corner, r->u);
    out[2] = add(out[1], r->v);
    out[3] = add(r->corner, r->v);
    return 4;
}

static bool rectangle_intersect(const void *params, const Ray *ray, ShapeHit *hit)
{
    const Rectangle *r = params;
    return flat_meet(r->corner, r->u, r->v, ray, hit) && hit->t > ray->tmin && hit->t < ray->tmax &&
           hit->u >= 0 && hit->u <= 1 && hit->v >= 0 && hit->v <= 1;
}

static void rectangle_point(const Scene *scene, const void *params, const Ray *ray,
                            const ShapeHit *hit, ShapePoint *out)
{
    (void)scene;
    (void)ray;
    const Rectangle *r = params;
    flat_point(r->corner, r->u, r->v, hit->u, hit->v, out);
}

static double rectangle_area(const Scene *scene, const void *params, const Affine *to_world)
{
    (void)scene;
    const Rectangle *r = params;
    return flat_area(r->u, r->v, to_world);
}

static void rectangle_sample_area(const Scene *scene, const void *params, const Affine *to_world,
                                  const void *table, double u0, double u1, double u2,
                                  ShapeSample *out)
{
    (void)scene;
    (void)table;
    (void)u2;
    const Rectangle *r = params;
    flat_point(r->corner, r->u, r->v, u0, u1, &out->point);
    shape_point_map(to_world, &out->point);
    out->primitive = 0;
    out->pdf = 1 / flat_area(r->u, r->v, to_world);
}

// The rectangle as seen from a reference point: Ureña, Fajardo, King 2013, "An Area-Preserving
// Parametrization for Spherical Rectangles", section 3. Coordinates in its own axes about the
// reference, z0 < 0.
typedef struct SphericalRectangle {
    double x0, y0, x1, y1, z0;
    double b0, b1, k;
    double solid_angle;
} SphericalRectangle;

static double clamped_acos(double x)
{
    return acos(fmin(fmax(x, -1), 1));
}

// False where the edges aren't perpendicular, the reference lies in the plane, or the solid angle
// is too small for its sum of angles.
static bool spherical_rectangle(const Rectangle *r, const Affine *to_world, Vec3 reference,
                                SphericalRectangle *out)
{
    Vec3 u = transform_vector(to_world, r->u), v = transform_vector(to_world, r->v);
    double lu = length(u), lv = length(v);
    if (!(fabs(dot(u, v)) <= 1e-9 * lu * lv)) {
        return false;
    }
    Vec3 x = scale(u, 1 / lu), y = scale(v, 1 / lv);
    Vec3 from = sub(transform_point(to_world, r->corner), reference);
    double z0 = -fabs(dot(from, cross(x, y)));
    double x0 = dot(from, x), y0 = dot(from, y), x1 = x0 + lu, y1 = y0 + lv;
    if (!(z0 < -1e-9 * (fabs(x0) + fabs(y0) + lu + lv))) {
        return false;
    }
    // z components of the normals of the four planes through the edges, and the inner angles.
    double n0 = -y0 / sqrt(z0 * z0 + y0 * y0), n1 = x1 / sqrt(z0 * z0 + x1 * x1);
    double n2 = y1 / sqrt(z0 * z0 + y1 * y1), n3 = -x0 / sqrt(z0 * z0 + x0 * x0);
    double g0 = clamped_acos(-n0 * n1), g1 = clamped_acos(-n1 * n2);
    double g2 = clamped_acos(-n2 * n3), g3 = clamped_acos(-n3 * n0);
    double k = 2 * PI - g2 - g3;
    *out = (SphericalRectangle){x0, y0, x1, y1, z0, n0, n2, k, g0 + g1 - k};
    return out->solid_angle > FLAT_LEAST_SOLID_ANGLE;
}

static bool rectangle_sample_solid_angle(const void *params, const Affine *to_world, Vec3 reference,
                                         double u0, double u1, ShapeSample *out)
{
    const Rectangle *r = params;
    SphericalRectangle q;
    if (!spherical_rectangle(r, to_world, reference, &q)) {
        return false;
    }
    double angle = u0 * q.solid_angle + q.k;
    double f = (cos(angle) * q.b0 - q.b1) / sin(angle);
    double cu = copysign(1 / sqrt(f * f + q.b0 * q.b0), f);
    cu = fmin(fmax(cu, -1), 1);
    double x = -(cu * q.z0) / fmax(sqrt(1 - cu * cu), 1e-300);
    x = fmin(fmax(x, q.x0), q.x1);
    double d2 = x * x + q.z0 * q.z0;
    double h0 = q.y0 / sqrt(d2 + q.y0 * q.y0), h1 = q.y1 / sqrt(d2 + q.y1 * q.y1);
    double h = h0 + u1 * (h1 - h0);
    double y = h * h < 1 - 1e-15 ? h * sqrt(d2 / (1 - h * h)) : q.y1;
    y = fmin(fmax(y, q.y0), q.y1);
    flat_point(r->corner, r->u, r->v, (x - q.x0) / (q.x1 - q.x0), (y - q.y0) / (q.y1 - q.y0),
               &out->point);
    shape_point_map(to_world, &out->point);
    out->primitive = 0;
    out->pdf = 1 / q.solid_angle;
    return true;
}

static double rectangle_solid_angle_pdf(const void *params, const Affine *to_world, Vec3 reference,
                                        Vec3 direction)
{
    (void)direction;
    SphericalRectangle q;
    return spherical_rectangle(params, to_world, reference, &q) ? 1 / q.solid_angle : 0;
}

const ShapeClass rectangle_shape = {
    .node = {.name = "rectangle",
             .category = CATEGORY_SHAPE,
             .params = rectangle_params,
             .param_count = sizeof rectangle_params / sizeof *rectangle_params,
             .size = sizeof(Rectangle),
             .doc = "A flat piece between two edges from one corner; a parallelogram where they "
                    "aren't perpendicular. Its front side is that from which u turns to v "
                    "counter-clockwise.",
             .formula = "p = corner + s u + t v, 0 <= s, t <= 1. As a light it is sampled by solid "
                        "angle (Ureña, Fajardo, King 2013) where its edges are perpendicular, else "
                        "by area.",
             .example = "rectangle { corner: (-1, 0, 1), u: (2, 0, 0), v: (0, 0, -2) }",
             .finish = rectangle_finish,
             .bounds = rectangle_bounds},
    .holding = HOLD_FLAT,
    .flat = true,
    .closed = shape_is_open,
    .intersect = rectangle_intersect,
    .point = rectangle_point,
    .corners = rectangle_corners,
    .area = rectangle_area,
    .sample_area = rectangle_sample_area,
    .sample_solid_angle = rectangle_sample_solid_angle,
    .solid_angle_pdf = rectangle_solid_angle_pdf,
};
