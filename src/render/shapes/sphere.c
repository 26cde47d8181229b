#include "render/geometry.h"

typedef struct Sphere {
    Vec3 center;
    double radius;
} Sphere;

static const Param sphere_params[] = {
    {.name = "center",
     .type = PARAM_VEC3,
     PARAM_AT(Sphere, center),
     .dims = DIM_BIT(DIM_LENGTH),
     .default_text = "(0, 0, 0)",
     .doc = "The middle."},
    {.name = "radius",
     .type = PARAM_NUMBER,
     PARAM_AT(Sphere, radius),
     .flags = PARAM_EXCLUDE_MIN,
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .default_text = "1",
     .doc = "Distance from the middle to the surface."},
};

static Box3 sphere_bounds(const Scene *scene, const void *params)
{
    (void)scene;
    const Sphere *s = params;
    Vec3 r = vec3(s->radius, s->radius, s->radius);
    return (Box3){sub(s->center, r), add(s->center, r)};
}

static Vec3 sphere_ball(const void *params, double *radius)
{
    const Sphere *s = params;
    *radius = s->radius;
    return s->center;
}

// The quadratic in the form of Haines et al. 2019, "Precision Improvements for Ray/Sphere
// Intersection" (Ray Tracing Gems, 7): the discriminant from the vector between centre and line,
// the roots without cancellation. The sign of the root near an origin on the surface follows from
// that origin's side alone.
static bool sphere_intersect(const void *params, const Ray *ray, ShapeHit *hit)
{
    const Sphere *s = params;
    Vec3 f = sub(ray->origin, s->center), d = ray->direction;
    double a = length_squared(d), b = -dot(f, d);
    double discriminant = s->radius * s->radius - length_squared(add_scaled(f, d, b / a));
    if (!(discriminant >= 0)) {
        return false;
    }
    double c = length_squared(f) - s->radius * s->radius;
    double q = b + copysign(sqrt(a * discriminant), b);
    double near = b > 0 ? c / q : q / a, far = b > 0 ? q / a : c / q;
    double t = near > ray->tmin ? near : far;
    if (!(t > ray->tmin && t < ray->tmax)) {
        return false;
    }
    *hit = (ShapeHit){.t = t};
    return true;
}

// u grows eastwards, seen from outside with +y up, from the back (-z); v from the south pole to the
// north pole.
static void sphere_point_at(const Sphere *s, Vec3 n, ShapePoint *out)
{
    double around = n.x * n.x + n.z * n.z;
    Vec3 east = around > 1e-24 ? vec3(n.z, 0, -n.x) : vec3(1, 0, 0);
    *out = (ShapePoint){
        .p = add_scaled(s->center, n, s->radius),
        .geometric = n,
        .shading = n,
        .tangent = around > 1e-24 ? scale(east, 2 * PI * s->radius) : east,
        .bitangent = scale(cross(n, east), PI * s->radius / length(east)),
        .uv = {0.5 + atan2(n.x, n.z) / (2 * PI), 0.5 + atan2(n.y, sqrt(around)) / PI},
        .color = {1, 1, 1},
        .error = rounding_error(max_abs(s->center) + s->radius),
    };
}

static Vec3 sphere_normal(const Sphere *s, const Ray *ray, const ShapeHit *hit)
{
    return normalize(add_scaled(sub(ray->origin, s->center), ray->direction, hit->t));
}

static void sphere_place(const void *params, const Ray *ray, const ShapeHit *hit, ShapePoint *out)
{
    const Sphere *s = params;
    const Vec3 n = sphere_normal(s, ray, hit);
    *out = (ShapePoint){.p = add_scaled(s->center, n, s->radius),
                        .geometric = n,
                        .shading = n,
                        .error = rounding_error(max_abs(s->center) + s->radius)};
}

static void sphere_point(const Scene *scene, const void *params, const Ray *ray,
                         const ShapeHit *hit, ShapePoint *out)
{
    (void)scene;
    sphere_point_at(params, sphere_normal(params, ray, hit), out);
}

// What sampling needs of a transform.
typedef struct SphereTable {
    double area, most; // most: the largest |C n|
    bool similar;      // a sphere in the world, too: there
    Vec3 center;
    double radius;
    bool upright; // moved and scaled, not turned; then
    double error; // of points on it
} SphereTable;

// An ellipsoid's area, for |C n|² = nᵀ CᵀC n over the unit sphere: 4π R_G of CᵀC's eigenvalues.
static SphereTable sphere_table(const Sphere *s, const Affine *to_world)
{
    Affine cofactors = affine_cofactors(to_world);
    Vec3 e = affine_gram_eigenvalues(&cofactors);
    double factor = 0;
    SphereTable table = {.area = 4 * PI * s->radius * s->radius * carlson_rg(e.x, e.y, e.z),
                         .most = sqrt(max_component(e)),
                         .similar = affine_is_similarity(to_world, &factor)};
    table.center = transform_point(to_world, s->center);
    table.radius = s->radius * factor;
    table.upright = true;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const double m = to_world->m[i][j];
            table.upright = table.upright && m == (i == j ? to_world->m[0][0] : 0);
        }
    }
    // The farthest point of the box, so that no other's error is larger.
    ShapePoint far = {.p = add(vec3_abs(s->center), vec3(s->radius, s->radius, s->radius)),
                      .geometric = {0, 0, 1},
                      .shading = {0, 0, 1},
                      .error = rounding_error(max_abs(s->center) + s->radius)};
    shape_point_map(to_world, &far);
    table.error = far.error + rounding_error(max_abs(table.center) + table.radius);
    return table;
}

static void *sphere_prepare_sampling(const Scene *scene, const void *params, const Affine *to_world,
                                     Arena *arena)
{
    (void)scene;
    SphereTable *table = ARENA_NEW(arena, SphereTable);
    if (table) {
        *table = sphere_table(params, to_world);
    }
    return table;
}

static double sphere_area(const Scene *scene, const void *params, const Affine *to_world)
{
    (void)scene;
    return sphere_table(params, to_world).area;
}

static void sphere_sample_area(const Scene *scene, const void *params, const Affine *to_world,
                               const void *table, double u0, double u1, double u2, ShapeSample *out)
{
    (void)scene;
    const Sphere *s = params;
    SphereTable own = table ? *(const SphereTable *)table : sphere_table(s, to_world);
    Affine cofactors = affine_cofactors(to_world);
    Rejection more = rejection_begin(u0, u1, u2);
    Vec3 n;
    for (int tries = 0; tries < REJECTION_TRIES; ++tries) {
        double y = 1 - 2 * u0, around = sqrt(fmax(0, 1 - y * y));
        n = vec3(around * sin(2 * PI * u1), y, around * cos(2 * PI * u1));
        if (own.similar || u2 * own.most <= length(transform_vector(&cofactors, n))) {
            break;
        }
        u0 = rejection_next(&more);
        u1 = rejection_next(&more);
        u2 = rejection_next(&more);
    }
    sphere_point_at(s, n, &out->point);
    shape_point_map(to_world, &out->point);
    out->primitive = 0;
    out->pdf = 1 / own.area;
}

// The cone under which a sphere is seen: its axis, and 1 - cos of its half angle without the
// cancellation that a far sphere would bring. False from inside or the surface itself.
typedef struct SphereCone {
    Vec3 center, axis;
    double radius, distance;
    double sin_squared; // of the half angle
    double one_minus_cos;
} SphereCone;

static bool sphere_cone(const Sphere *s, const Affine *to_world, const SphereTable *table,
                        Vec3 reference, SphereCone *cone)
{
    if (table) {
        cone->center = table->center;
        cone->radius = table->radius;
    } else {
        double factor;
        if (!affine_is_similarity(to_world, &factor)) {
            return false;
        }
        cone->center = transform_point(to_world, s->center);
        cone->radius = s->radius * factor;
    }
    Vec3 to_center = sub(cone->center, reference);
    cone->distance = length(to_center);
    if ((table && !table->similar) || !(cone->distance > cone->radius * (1 + 1e-9))) {
        return false;
    }
    cone->axis = scale(to_center, 1 / cone->distance);
    double sine = cone->radius / cone->distance;
    cone->sin_squared = sine * sine;
    cone->one_minus_cos = cone->sin_squared / (1 + sqrt(1 - cone->sin_squared));
    return true;
}

// Uniform in the cone: the normal of the point, by the law of cosines (pbrt 4, 6.2.4), which stays
// on the sphere however far it is.
static Vec3 sphere_cone_normal(const SphereCone *cone, double u0, double u1)
{
    double less = u0 * cone->one_minus_cos; // 1 - cos theta
    double sin_squared = less * (2 - less);
    double ratio = smaller(1, sin_squared / cone->sin_squared);
    double cos_alpha = ratio * sqrt(cone->sin_squared) + (1 - less) * sqrt(1 - ratio);
    double sin_alpha = sqrt(larger(0, 1 - cos_alpha * cos_alpha));
    Frame frame = frame_from_normal(neg(cone->axis));
    return from_local(&frame,
                      vec3(sin_alpha * cos(2 * PI * u1), sin_alpha * sin(2 * PI * u1), cos_alpha));
}

// The same as below without what textures ask for.
static bool sphere_aim(const void *params, const Affine *to_world, const void *table_of,
                       Vec3 reference, double u0, double u1, ShapeAim *out)
{
    const SphereTable *table = table_of;
    SphereCone cone;
    if (!table || !table->upright || !sphere_cone(params, to_world, table, reference, &cone)) {
        return false;
    }
    out->normal = normalize(sphere_cone_normal(&cone, u0, u1));
    out->p = add_scaled(cone.center, out->normal, cone.radius);
    out->error = table->error;
    out->pdf = 1 / (2 * PI * cone.one_minus_cos);
    out->by_angle = true;
    return true;
}

static bool sphere_sample_solid_angle(const void *params, const Affine *to_world, const void *table,
                                      Vec3 reference, double u0, double u1, ShapeSample *out)
{
    const Sphere *s = params;
    SphereCone cone;
    if (!sphere_cone(s, to_world, table, reference, &cone)) {
        return false;
    }
    const Vec3 n = sphere_cone_normal(&cone, u0, u1);
    // Back to the shape's own space for its uv: a similarity's inverse is its transpose over s².
    double factor = cone.radius / s->radius;
    Vec3 own = scale(transform_transposed(to_world, n), 1 / factor);
    sphere_point_at(s, normalize(own), &out->point);
    shape_point_map(to_world, &out->point);
    out->primitive = 0;
    out->pdf = 1 / (2 * PI * cone.one_minus_cos);
    return true;
}

static double sphere_solid_angle_pdf(const void *params, const Affine *to_world, const void *table,
                                     Vec3 reference, Vec3 direction)
{
    (void)direction;
    SphereCone cone;
    return sphere_cone(params, to_world, table, reference, &cone)
               ? 1 / (2 * PI * cone.one_minus_cos)
               : 0;
}

const ShapeClass sphere_shape = {
    .node = {.name = "sphere",
             .category = CATEGORY_SHAPE,
             .params = sphere_params,
             .param_count = sizeof sphere_params / sizeof *sphere_params,
             .size = sizeof(Sphere),
             .bounds = sphere_bounds,
             .doc = "A sphere. Normals point outwards; u runs around the y axis and v from the "
                    "south pole to the north pole.",
             .formula = "|p - center| = radius, intersected in double precision (Haines et al. "
                        "2019, Ray Tracing Gems 7). As a light it is sampled by the cone under "
                        "which it is seen (Shirley, Wang, Zimmerman 1996).",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "let clay = lambert { color: #c0704a }\n"
                        "sphere { center: (-0.6, 0.5, 0), radius: 0.5, material: clay }\n"
                        "sphere { center: (0.4, 0.3, 0.4), radius: 0.3, material: clay }\n"
                        "sphere { radius: 0.3, material: clay, transform: [scale(2, 1, 1), "
                        "translate(0.8, 0.3, -0.6)] }"},
    .holding = HOLD_USER,
    .closed = shape_is_closed,
    .intersect = sphere_intersect,
    .ball = sphere_ball,
    .point = sphere_point,
    .place = sphere_place,
    .area = sphere_area,
    .sample_area = sphere_sample_area,
    .sample_solid_angle = sphere_sample_solid_angle,
    .aim = sphere_aim,
    .solid_angle_pdf = sphere_solid_angle_pdf,
    .prepare_sampling = sphere_prepare_sampling,
};
