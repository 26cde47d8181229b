#include "render/geometry.h"

typedef struct Torus {
    Vec3 center, axis;
    double major_radius, minor_radius;
} Torus;

static const Param torus_params[] = {
    {.name = "center",
     .type = PARAM_VEC3,
     PARAM_AT(Torus, center),
     .dims = DIM_BIT(DIM_LENGTH),
     .default_text = "(0, 0, 0)",
     .doc = "The middle of the hole."},
    {.name = "axis",
     .type = PARAM_VEC3,
     PARAM_AT(Torus, axis),
     .flags = PARAM_UNIT_VECTOR,
     .default_text = "(0, 1, 0)",
     .doc = "The axis through the hole."},
    {.name = "major_radius",
     .type = PARAM_NUMBER,
     PARAM_AT(Torus, major_radius),
     .flags = PARAM_REQUIRED | PARAM_EXCLUDE_MIN,
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .doc = "Distance from the middle of the hole to that of the tube."},
    {.name = "minor_radius",
     .type = PARAM_NUMBER,
     PARAM_AT(Torus, minor_radius),
     .flags = PARAM_REQUIRED | PARAM_EXCLUDE_MIN,
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .doc = "Radius of the tube."},
};

static bool torus_finish(NodeFinish *finish)
{
    const Torus *torus = finish->params;
    if (!(torus->minor_radius < torus->major_radius)) {
        finish->report(finish, 3, E0805,
                       "the minor radius of a torus is not smaller than its major radius (%g)",
                       torus->major_radius);
        return false;
    }
    return true;
}

static Box3 torus_bounds(const Scene *scene, const void *params)
{
    (void)scene;
    const Torus *torus = params;
    Vec3 n = torus->axis;
    Vec3 reach = scale(
        vec3(sqrt(n.y * n.y + n.z * n.z), sqrt(n.z * n.z + n.x * n.x), sqrt(n.x * n.x + n.y * n.y)),
        torus->major_radius);
    double more = torus->minor_radius + rounding_error(max_abs(torus->center) +
                                                       torus->major_radius + torus->minor_radius);
    reach = add(reach, vec3(more, more, more));
    return (Box3){sub(torus->center, reach), add(torus->center, reach)};
}

// --- Intersection -----------------------------------------------------------------------------

// Along a ray the torus is the quartic s⁴ + c3 s³ + c2 s² + c1 s + c0. Its roots are found between
// those of its derivative, and so on down to the quadratic (Yuksel 2022, "High-Performance
// Polynomial Root Finding for Graphics"). Between two of these the ray comes nearer all the time or
// goes away all the time, so that a change of sign is a hit and no change is none; and the sign is
// that of the distance to the tube, which is exact to rounding even where the quartic's
// coefficients cancel.

typedef struct TorusRay {
    Vec3 o, d;           // in the torus's frame, n its axis; d of unit length
    double major, minor; // radii
} TorusRay;

// Squared distance from the tube's circle less the squared minor radius, as a product.
static double tube_distance(const TorusRay *r, double s)
{
    Vec3 p = add_scaled(r->o, r->d, s);
    double across = sqrt(p.x * p.x + p.y * p.y) - r->major;
    double distance = sqrt(across * across + p.z * p.z);
    return (distance - r->minor) * (distance + r->minor);
}

static double cubic(const double c[4], double s)
{
    return ((c[3] * s + c[2]) * s + c[1]) * s + c[0];
}

// The root of a cubic that changes sign in [a, b]: bisection in steps of regula falsi (Illinois).
static double cubic_root(const double c[4], double a, double fa, double b, double fb)
{
    for (int i = 0; i < 100 && fabs(b - a) > 4 * ROUNDING * (fabs(a) + fabs(b)); ++i) {
        double m = i % 3 == 2 ? 0.5 * (a + b) : (a * fb - b * fa) / (fb - fa);
        double fm = cubic(c, m);
        if (fm == 0) {
            return m;
        }
        if ((fm < 0) == (fb < 0)) {
            fa *= (fb < 0) == (fm < 0) ? 0.5 : 1;
            b = m;
            fb = fm;
        } else {
            fb *= 0.5;
            a = m;
            fa = fm;
        }
    }
    return 0.5 * (a + b);
}

// Roots of the cubic inside (a, b), in order.
static int cubic_roots(const double c[4], double a, double b, double out[3])
{
    // Where its derivative 3 c3 s² + 2 c2 s + c1 vanishes.
    double ends[4] = {a, b, b, b};
    int pieces = 1;
    double discriminant = c[2] * c[2] - 3 * c[3] * c[1];
    if (discriminant > 0) {
        double q = -(c[2] + copysign(sqrt(discriminant), c[2]));
        double s0 = q / (3 * c[3]), s1 = c[1] / q;
        double low = fmin(s0, s1), high = fmax(s0, s1);
        if (low > a && low < b) {
            ends[pieces++] = low;
        }
        if (high > a && high < b) {
            ends[pieces++] = high;
        }
        ends[pieces] = b;
    }
    int count = 0;
    for (int i = 0; i < pieces; ++i) {
        double f0 = cubic(c, ends[i]), f1 = cubic(c, ends[i + 1]);
        if ((f0 < 0) != (f1 < 0)) {
            out[count++] = cubic_root(c, ends[i], f0, ends[i + 1], f1);
        }
    }
    return count;
}

// The crossing in [a, b], at whose ends the tube's distance has different signs.
static double tube_root(const TorusRay *r, double a, double fa, double b, double fb)
{
    double least = 2 * ROUNDING * (fabs(a) + fabs(b));
    for (int i = 0; i < 100 && b - a > least; ++i) {
        double m = i % 3 == 2 ? 0.5 * (a + b) : (a * fb - b * fa) / (fb - fa);
        if (!(m > a && m < b)) {
            m = 0.5 * (a + b);
        }
        double fm = tube_distance(r, m);
        if (fm == 0) {
            return m;
        }
        if ((fm < 0) == (fb < 0)) {
            b = m;
            fb = fm;
            fa *= 0.5;
        } else {
            a = m;
            fa = fm;
            fb *= 0.5;
        }
    }
    return 0.5 * (a + b);
}

// The part of the ray inside the sphere and the slab around the torus; false where there is none.
static bool torus_range(const TorusRay *r, double *begin, double *end)
{
    double outer = (r->major + r->minor) * (1 + 1e-9), half = r->minor * (1 + 1e-9);
    double b = -dot(r->o, r->d);
    double discriminant = outer * outer - length_squared(add_scaled(r->o, r->d, b));
    if (!(discriminant > 0)) {
        return false;
    }
    double root = sqrt(discriminant);
    *begin = fmax(*begin, b - root);
    *end = fmin(*end, b + root);
    if (r->d.z != 0) {
        double s0 = (-half - r->o.z) / r->d.z, s1 = (half - r->o.z) / r->d.z;
        *begin = fmax(*begin, fmin(s0, s1));
        *end = fmin(*end, fmax(s0, s1));
    } else if (fabs(r->o.z) > half) {
        return false;
    }
    return *begin < *end;
}

// The derivative of the quartic at s from `middle`, over 4.
static void quartic_derivative(const TorusRay *r, double middle, double c[4])
{
    Vec3 o = add_scaled(r->o, r->d, middle);
    double R2 = r->major * r->major;
    double b = dot(o, r->d), k = length_squared(o) + R2 - r->minor * r->minor;
    double a2 = r->d.x * r->d.x + r->d.y * r->d.y, b2 = o.x * r->d.x + o.y * r->d.y;
    c[3] = 1;
    c[2] = 3 * b;
    c[1] = 2 * b * b + k - 2 * R2 * a2;
    c[0] = b * k - 2 * R2 * b2;
}

static bool torus_intersect(const void *params, const Ray *ray, ShapeHit *hit)
{
    const Torus *torus = params;
    double speed = length(ray->direction);
    Frame frame = frame_from_normal(torus->axis);
    TorusRay r = {to_local(&frame, sub(ray->origin, torus->center)),
                  to_local(&frame, scale(ray->direction, 1 / speed)), torus->major_radius,
                  torus->minor_radius};
    double begin = ray->tmin * speed, end = ray->tmax * speed;
    if (!torus_range(&r, &begin, &end)) {
        return false;
    }
    double middle = 0.5 * (begin + end), c[4], turns[3], ends[5];
    quartic_derivative(&r, middle, c);
    int count = cubic_roots(c, begin - middle, end - middle, turns);
    ends[0] = begin;
    for (int i = 0; i < count; ++i) {
        ends[i + 1] = middle + turns[i];
    }
    ends[count + 1] = end;
    double f0 = tube_distance(&r, begin);
    for (int i = 0; i <= count; ++i) {
        double f1 = tube_distance(&r, ends[i + 1]);
        if ((f0 < 0) != (f1 < 0)) {
            *hit = (ShapeHit){.t = tube_root(&r, ends[i], f0, ends[i + 1], f1) / speed};
            return hit->t > ray->tmin && hit->t < ray->tmax;
        }
        f0 = f1;
    }
    return false;
}

// --- Points -----------------------------------------------------------------------------------

// (x, y) and (c, s) are unit vectors: around the axis, and around the tube from its outermost
// circle. u runs around the axis, v around the tube.
static void torus_point_at(const Torus *torus, double x, double y, double c, double s,
                           ShapePoint *out)
{
    Frame frame = frame_from_normal(torus->axis);
    double ring = torus->major_radius + torus->minor_radius * c;
    Vec3 n = from_local(&frame, vec3(x * c, y * c, s));
    double u = atan2(y, x) / (2 * PI), v = atan2(s, c) / (2 * PI);
    double size = max_abs(torus->center) + torus->major_radius + torus->minor_radius;
    *out = (ShapePoint){.p = add(torus->center, from_local(&frame, vec3(x * ring, y * ring,
                                                                        s * torus->minor_radius))),
                        .geometric = n,
                        .shading = n,
                        .tangent = scale(from_local(&frame, vec3(-y, x, 0)), 2 * PI * ring),
                        .bitangent = scale(from_local(&frame, vec3(-x * s, -y * s, c)),
                                           2 * PI * torus->minor_radius),
                        .uv = {u < 0 ? u + 1 : u, v < 0 ? v + 1 : v},
                        .color = {1, 1, 1},
                        .error = rounding_error(2 * size)};
}

static void torus_point(const Scene *scene, const void *params, const Ray *ray, const ShapeHit *hit,
                        ShapePoint *out)
{
    (void)scene;
    const Torus *torus = params;
    Frame frame = frame_from_normal(torus->axis);
    Vec3 p = add_scaled(sub(ray->origin, torus->center), ray->direction, hit->t);
    p = to_local(&frame, p);
    double ring = sqrt(p.x * p.x + p.y * p.y), across = ring - torus->major_radius;
    double tube = sqrt(across * across + p.z * p.z);
    torus_point_at(torus, p.x / ring, p.y / ring, across / tube, p.z / tube, out);
}

// --- Sampling ---------------------------------------------------------------------------------

typedef struct TorusTable {
    double area, most; // most: a bound on |C n|
    bool similar;
} TorusTable;

static double normal_factor(const Frame *frame, const Affine *cofactors, double around, double tube)
{
    Vec3 n = from_local(frame, vec3(cos(around) * cos(tube), sin(around) * cos(tube), sin(tube)));
    return length(transform_vector(cofactors, n));
}

// The area is the integral of r (R + r cos v) |C n| over both angles, by the trapezoid rule, which
// is exact to rounding soon for smooth periodic functions.
static TorusTable torus_table(const Torus *torus, const Affine *to_world)
{
    enum { NODES = 128 };
    double factor, R = torus->major_radius, r = torus->minor_radius, sum = 0;
    bool similar = affine_is_similarity(to_world, &factor);
    Affine cofactors = affine_cofactors(to_world);
    Frame frame = frame_from_normal(torus->axis);
    if (similar) {
        return (TorusTable){4 * PI * PI * R * r * factor * factor, factor * factor, true};
    }
    for (int i = 0; i < NODES; ++i) {
        for (int j = 0; j < NODES; ++j) {
            double around = 2 * PI * i / NODES, tube = 2 * PI * j / NODES;
            sum += (R + r * cos(tube)) * normal_factor(&frame, &cofactors, around, tube);
        }
    }
    Vec3 e = affine_gram_eigenvalues(&cofactors);
    return (TorusTable){sum * r * 4 * PI * PI / (NODES * NODES), sqrt(max_component(e)), false};
}

static double torus_area(const Scene *scene, const void *params, const Affine *to_world)
{
    (void)scene;
    return torus_table(params, to_world).area;
}

static void *torus_prepare_sampling(const Scene *scene, const void *params, const Affine *to_world,
                                    Arena *arena)
{
    (void)scene;
    TorusTable *table = ARENA_NEW(arena, TorusTable);
    if (table) {
        *table = torus_table(params, to_world);
    }
    return table;
}

// The angle v around the tube whose share of the area up to it is u: v + (r/R) sin v = 2 pi u,
// Kepler's equation, by Newton's method kept inside a bracket.
static double tube_angle(const Torus *torus, double u)
{
    double e = torus->minor_radius / torus->major_radius, target = 2 * PI * u;
    double low = fmax(0, target - e), high = fmin(2 * PI, target + e), v = target;
    for (int i = 0; i < 60; ++i) {
        double f = v + e * sin(v) - target;
        *(f > 0 ? &high : &low) = v;
        double next = v - f / (1 + e * cos(v));
        if (!(next > low && next < high)) {
            next = 0.5 * (low + high);
        }
        if (fabs(next - v) < 1e-15 * (1 + v)) {
            break;
        }
        v = next;
    }
    return v;
}

static void torus_sample_area(const Scene *scene, const void *params, const Affine *to_world,
                              const void *table, double u0, double u1, double u2, ShapeSample *out)
{
    (void)scene;
    const Torus *torus = params;
    TorusTable own = table ? *(const TorusTable *)table : torus_table(torus, to_world);
    Affine cofactors = affine_cofactors(to_world);
    Frame frame = frame_from_normal(torus->axis);
    Rejection more = rejection_begin(u0, u1, u2);
    double around = 0, tube = 0;
    for (int tries = 0; tries < REJECTION_TRIES; ++tries) {
        around = 2 * PI * u0;
        tube = tube_angle(torus, u1);
        if (own.similar || u2 * own.most <= normal_factor(&frame, &cofactors, around, tube)) {
            break;
        }
        u0 = rejection_next(&more);
        u1 = rejection_next(&more);
        u2 = rejection_next(&more);
    }
    torus_point_at(torus, cos(around), sin(around), cos(tube), sin(tube), &out->point);
    shape_point_map(to_world, &out->point);
    out->primitive = 0;
    out->pdf = 1 / own.area;
}

const ShapeClass torus_shape = {
    .node = {.name = "torus",
             .category = CATEGORY_SHAPE,
             .params = torus_params,
             .param_count = sizeof torus_params / sizeof *torus_params,
             .size = sizeof(Torus),
             .doc =
                 "A ring: the surface of a tube that runs around an axis. u runs around the axis, "
                 "v around the tube from its outermost circle.",
             .formula =
                 "(sqrt(x² + y²) - major_radius)² + z² = minor_radius², z along the axis; the "
                 "quartic's roots are isolated by those of its derivatives (Yuksel 2022) and "
                 "refined in double precision.",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "let clay = lambert { color: #c0704a }\n"
                        "torus { center: (-0.4, 0.15, 0.2), major_radius: 0.5, minor_radius: 0.15, "
                        "material: clay }\n"
                        "torus {\n"
                        "  center: (0.6, 0.5, 0)\n"
                        "  axis: (-0.4, 0.2, 1)\n"
                        "  major_radius: 0.4\n"
                        "  minor_radius: 0.1\n"
                        "  material: clay\n"
                        "}",
             .finish = torus_finish,
             .bounds = torus_bounds},
    .holding = HOLD_USER,
    .closed = shape_is_closed,
    .intersect = torus_intersect,
    .point = torus_point,
    .area = torus_area,
    .sample_area = torus_sample_area,
    .prepare_sampling = torus_prepare_sampling,
};
