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

// What sampling needs of the rectangle in the world.
typedef struct RectangleTable {
    ShapePoint
        corner; // the point at u = v = 0; its tangents are the edges, its error is everyone's
    Vec3 x, y, normal; // unit, along the edges and across
    double lu, lv;     // lengths of the edges
    double area;
    Vec3 center;
    double far_squared; // from so far away, squared, it is sampled by area
    bool perpendicular;
} RectangleTable;

// By how many times the sum of its edges. Seen from there, solid angles in parts of areas differ by
// a factor of two between its ends at most, which the sampler's even points take care of; finding
// them costs more than it saves.
#define FAR 1.25

static RectangleTable rectangle_table(const Rectangle *r, const Affine *to_world)
{
    RectangleTable out;
    double error = 0;
    for (int corner = 3; corner >= 0; --corner) {
        flat_point(r->corner, r->u, r->v, corner & 1, corner >> 1, &out.corner);
        shape_point_map(to_world, &out.corner);
        error = larger(error, out.corner.error);
    }
    const Vec3 u = out.corner.tangent, v = out.corner.bitangent;
    out.lu = length(u);
    out.lv = length(v);
    out.x = scale(u, 1 / out.lu);
    out.y = scale(v, 1 / out.lv);
    out.normal = cross(out.x, out.y);
    out.area = length(cross(u, v));
    out.center = add_scaled(add_scaled(out.corner.p, u, 0.5), v, 0.5);
    out.far_squared = FAR * FAR * (out.lu + out.lv) * (out.lu + out.lv);
    out.perpendicular = fabs(dot(u, v)) <= 1e-9 * out.lu * out.lv;
    // Points are made from the corner in the world, which rounds once more.
    out.corner.error = error + rounding_error(max_abs(out.corner.p) + out.lu + out.lv);
    return out;
}

static void *rectangle_prepare_sampling(const Scene *scene, const void *params,
                                        const Affine *to_world, Arena *arena)
{
    (void)scene;
    RectangleTable *table = ARENA_NEW(arena, RectangleTable);
    if (table) {
        *table = rectangle_table(params, to_world);
    }
    return table;
}

static void table_point(const RectangleTable *table, double u, double v, ShapeSample *out)
{
    out->point = table->corner;
    out->point.p = add_scaled(add_scaled(table->corner.p, table->corner.tangent, u),
                              table->corner.bitangent, v);
    out->point.uv = (Vec2){u, v};
    out->primitive = 0;
}

static void rectangle_sample_area(const Scene *scene, const void *params, const Affine *to_world,
                                  const void *table, double u0, double u1, double u2,
                                  ShapeSample *out)
{
    (void)scene;
    (void)u2;
    RectangleTable own;
    if (!table) {
        own = rectangle_table(params, to_world);
        table = &own;
    }
    table_point(table, u0, u1, out);
    out->pdf = 1 / ((const RectangleTable *)table)->area;
}

// The rectangle as seen from a reference point: Ureña, Fajardo, King 2013, "An Area-Preserving
// Parametrization for Spherical Rectangles", section 3. Coordinates in its own axes about the
// reference, z0 < 0. The paper's sums of angles are products of complex numbers here, so that one
// arc tangent replaces four arc cosines.
typedef struct SphericalRectangle {
    double x0, y0, x1, y1, z0;
    double b0, b1, rest0, cos_k, sin_k; // rest0 = 1 - b0²
    double solid_angle;
} SphericalRectangle;

typedef struct Turn { // by an angle: the complex number of size 1
    double cosine, sine;
} Turn;

static Turn turn_add(Turn a, Turn b)
{
    return (Turn){a.cosine * b.cosine - a.sine * b.sine, a.sine * b.cosine + a.cosine * b.sine};
}

// The angle in [0, 2π), as far as it is known to be that of a solid angle.
static double solid_angle_of(Turn turn, const SphericalRectangle *q)
{
    const double angle = atan2(turn.sine, turn.cosine);
    if (angle >= 0 || turn.cosine < 0) {
        return angle >= 0 ? angle : angle + 2 * PI;
    }
    // More than 3/2 π is seen from before the rectangle, near it; else zero has been rounded.
    const bool before = q->x0 < 0 && q->x1 > 0 && q->y0 < 0 && q->y1 > 0;
    return before && -q->z0 < q->x1 - q->x0 + q->y1 - q->y0 ? angle + 2 * PI : 0;
}

// False where the edges aren't perpendicular, the reference lies far away or in the plane, or the
// solid angle is too small for its sum of angles.
static bool spherical_rectangle(const RectangleTable *table, Vec3 reference,
                                SphericalRectangle *out)
{
    if (length_squared(sub(table->center, reference)) > table->far_squared) {
        return false;
    }
    const Vec3 from = sub(table->corner.p, reference);
    const double z0 = -fabs(dot(from, table->normal));
    const double x0 = dot(from, table->x), x1 = x0 + table->lu;
    const double y0 = dot(from, table->y), y1 = y0 + table->lv;
    if (!table->perpendicular || !(z0 < -1e-9 * (fabs(x0) + fabs(y0) + table->lu + table->lv))) {
        return false;
    }
    // The z components n of the normals of the planes through the reference and the edges, and
    // 1 - n²; then the inner angles acos(-n n') between neighbours. Square roots in step, which
    // processors take two or four at a time.
    const double offset[4] = {-y0, x1, y1, -x0};
    double n[4], rest[4];
    for (int i = 0; i < 4; ++i) {
        const double inverse = 1 / sqrt(offset[i] * offset[i] + z0 * z0), cosine = z0 * inverse;
        n[i] = offset[i] * inverse;
        rest[i] = cosine * cosine;
    }
    Turn g[4];
    for (int i = 0; i < 4; ++i) {
        const int next = (i + 1) & 3;
        g[i].cosine = -n[i] * n[next];
        g[i].sine = sqrt(rest[i] + n[i] * n[i] * rest[next]);
    }
    // k = 2π - g2 - g3, and the solid angle is g0 + g1 + g2 + g3 - 2π.
    const Turn g23 = turn_add(g[2], g[3]), all = turn_add(turn_add(g[0], g[1]), g23);
    *out = (SphericalRectangle){x0, y0, x1, y1, z0, n[0], n[2], rest[0], g23.cosine, -g23.sine, 0};
    out->solid_angle = solid_angle_of(all, out);
    return out->solid_angle > FLAT_LEAST_SOLID_ANGLE;
}

// The place on the rectangle, in units of its edges, that two numbers choose evenly by solid angle.
static Vec2 spherical_place(const RectangleTable *t, const SphericalRectangle *q, double u0,
                            double u1)
{
    const double angle = u0 * q->solid_angle;
    const Turn at = turn_add((Turn){q->cos_k, q->sin_k}, (Turn){cos(angle), sin(angle)});
    // The paper's f is `over` / at.sine, and x = -cu z0 / sqrt(1 - cu²), cu = ±1 / sqrt(f² + b0²).
    const double over = at.cosine * q->b0 - q->b1;
    const double under = larger(over * over - q->rest0 * at.sine * at.sine, 1e-300);
    double x = -q->z0 * copysign(at.sine, over * at.sine) / sqrt(under);
    x = smaller(larger(x, q->x0), q->x1);
    double d2 = x * x + q->z0 * q->z0;
    double h0 = q->y0 / sqrt(d2 + q->y0 * q->y0), h1 = q->y1 / sqrt(d2 + q->y1 * q->y1);
    double h = h0 + u1 * (h1 - h0);
    double y = h * h < 1 - 1e-15 ? h * sqrt(d2 / (1 - h * h)) : q->y1;
    y = smaller(larger(y, q->y0), q->y1);
    return (Vec2){(x - q->x0) / t->lu, (y - q->y0) / t->lv};
}

static bool rectangle_sample_solid_angle(const void *params, const Affine *to_world,
                                         const void *table, Vec3 reference, double u0, double u1,
                                         ShapeSample *out)
{
    RectangleTable own;
    if (!table) {
        own = rectangle_table(params, to_world);
        table = &own;
    }
    SphericalRectangle q;
    if (!spherical_rectangle(table, reference, &q)) {
        return false;
    }
    const Vec2 place = spherical_place(table, &q, u0, u1);
    table_point(table, place.x, place.y, out);
    out->pdf = 1 / q.solid_angle;
    return true;
}

static bool rectangle_aim(const void *params, const Affine *to_world, const void *table,
                          Vec3 reference, double u0, double u1, ShapeAim *out)
{
    (void)params;
    (void)to_world;
    const RectangleTable *t = table;
    SphericalRectangle q;
    out->by_angle = spherical_rectangle(t, reference, &q);
    out->pdf = 1 / t->area;
    if (out->by_angle) {
        const Vec2 place = spherical_place(t, &q, u0, u1);
        out->pdf = 1 / q.solid_angle;
        u0 = place.x;
        u1 = place.y;
    }
    out->p = add(t->corner.p, add(scale(t->corner.tangent, u0), scale(t->corner.bitangent, u1)));
    out->normal = t->corner.geometric;
    out->error = t->corner.error;
    return true;
}

static double rectangle_solid_angle_pdf(const void *params, const Affine *to_world,
                                        const void *table, Vec3 reference, Vec3 direction)
{
    (void)direction;
    RectangleTable own;
    if (!table) {
        own = rectangle_table(params, to_world);
        table = &own;
    }
    SphericalRectangle q;
    return spherical_rectangle(table, reference, &q) ? 1 / q.solid_angle : 0;
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
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "let clay = lambert { color: #c0704a }\n"
                        "rectangle { corner: (-1.2, 0, 0.2), u: (0.9, 0, -0.3), v: (0, 0.9, 0), "
                        "material: clay }\n"
                        "rectangle { corner: (0.1, 0.01, 0.5), u: (1, 0, 0), v: (0.3, 0.6, -0.8), "
                        "material: clay }",
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
    .aim = rectangle_aim,
    .solid_angle_pdf = rectangle_solid_angle_pdf,
    .prepare_sampling = rectangle_prepare_sampling,
};
