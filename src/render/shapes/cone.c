#include "render/shapes/frustum.h"

typedef struct Cone {
    Vec3 from, to;
    double radius_from, radius_to;
    bool caps;
    Frustum frustum; // derived
} Cone;

static const Param cone_params[] = {
    {.name = "from",
     .type = PARAM_VEC3,
     PARAM_AT(Cone, from),
     .flags = PARAM_REQUIRED,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The middle of one end."},
    {.name = "to",
     .type = PARAM_VEC3,
     PARAM_AT(Cone, to),
     .flags = PARAM_REQUIRED,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The middle of the other end."},
    {.name = "radius_from",
     .type = PARAM_NUMBER,
     PARAM_AT(Cone, radius_from),
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .default_text = "1",
     .doc = "Radius at `from`."},
    {.name = "radius_to",
     .type = PARAM_NUMBER,
     PARAM_AT(Cone, radius_to),
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .default_text = "0",
     .doc = "Radius at `to`; 0 makes a tip."},
    {.name = "caps",
     .type = PARAM_BOOL,
     PARAM_AT(Cone, caps),
     .default_text = "true",
     .doc = "Whether the ends are closed by discs."},
};

static bool cone_finish(NodeFinish *finish)
{
    Cone *c = finish->params;
    if (!(length_squared(sub(c->to, c->from)) > 0)) {
        finish->report(finish, 1, E0801, "both ends of a cone are the same point");
        return false;
    }
    if (!(c->radius_from > 0 || c->radius_to > 0)) {
        finish->report(finish, 2, E0805, "a cone has a radius of zero at both ends");
        return false;
    }
    c->frustum = frustum_make(c->from, c->to, c->radius_from, c->radius_to, c->caps);
    return true;
}

static Box3 cone_bounds(const Scene *scene, const void *params)
{
    (void)scene;
    const Cone *c = params;
    return frustum_bounds(&c->frustum);
}

static bool cone_intersect(const void *params, const Ray *ray, ShapeHit *hit)
{
    const Cone *c = params;
    return frustum_intersect(&c->frustum, ray, hit);
}

static void cone_point(const Scene *scene, const void *params, const Ray *ray, const ShapeHit *hit,
                       ShapePoint *out)
{
    (void)scene;
    const Cone *c = params;
    frustum_point(&c->frustum, ray, hit, out);
}

static double cone_area(const Scene *scene, const void *params, const Affine *to_world)
{
    (void)scene;
    const Cone *c = params;
    return frustum_table(&c->frustum, to_world).total;
}

static void *cone_prepare_sampling(const Scene *scene, const void *params, const Affine *to_world,
                                   Arena *arena)
{
    (void)scene;
    const Cone *c = params;
    FrustumTable *table = ARENA_NEW(arena, FrustumTable);
    if (table) {
        *table = frustum_table(&c->frustum, to_world);
    }
    return table;
}

static void cone_sample_area(const Scene *scene, const void *params, const Affine *to_world,
                             const void *table, double u0, double u1, double u2, ShapeSample *out)
{
    (void)scene;
    const Cone *c = params;
    FrustumTable own;
    if (!table) {
        own = frustum_table(&c->frustum, to_world);
        table = &own;
    }
    frustum_sample_area(&c->frustum, to_world, table, u0, u1, u2, out);
}

static bool cone_closed(const void *params)
{
    const Cone *c = params;
    return c->caps;
}

const ShapeClass cone_shape = {
    .node = {.name = "cone",
             .category = CATEGORY_SHAPE,
             .params = cone_params,
             .param_count = sizeof cone_params / sizeof *cone_params,
             .size = sizeof(Cone),
             .doc = "A cone, or a piece of one, between two points. On the side u runs around the "
                    "axis and v along it.",
             .formula = "|p - axis| = radius_from + (radius_to - radius_from) z / height, a "
                        "quadratic in double precision",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "let clay = lambert { color: #c0704a }\n"
                        "cone { from: (-0.8, 0, 0), to: (-0.8, 1, 0), radius_from: 0.4, radius_to: "
                        "0, material: clay }\n"
                        "cone { from: (0.1, 0, 0), to: (0.1, 0.6, 0), radius_from: 0.4, radius_to: "
                        "0.2, material: clay }\n"
                        "cone {\n"
                        "  from: (0.9, 0, 0)\n"
                        "  to: (0.9, 0.5, 0)\n"
                        "  radius_from: 0.2\n"
                        "  radius_to: 0.35\n"
                        "  caps: false\n"
                        "  material: clay\n"
                        "}",
             .finish = cone_finish,
             .bounds = cone_bounds},
    .holding = HOLD_USER,
    .closed = cone_closed,
    .intersect = cone_intersect,
    .point = cone_point,
    .area = cone_area,
    .sample_area = cone_sample_area,
    .prepare_sampling = cone_prepare_sampling,
};
