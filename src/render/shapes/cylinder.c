#include "render/shapes/frustum.h"

typedef struct Cylinder {
    Vec3 from, to;
    double radius;
    bool caps;
    Frustum frustum; // derived
} Cylinder;

static const Param cylinder_params[] = {
    {.name = "from",
     .type = PARAM_VEC3,
     PARAM_AT(Cylinder, from),
     .flags = PARAM_REQUIRED,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The middle of one end."},
    {.name = "to",
     .type = PARAM_VEC3,
     PARAM_AT(Cylinder, to),
     .flags = PARAM_REQUIRED,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The middle of the other end."},
    {.name = "radius",
     .type = PARAM_NUMBER,
     PARAM_AT(Cylinder, radius),
     .flags = PARAM_EXCLUDE_MIN,
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .default_text = "1",
     .doc = "Distance from the axis to the side."},
    {.name = "caps",
     .type = PARAM_BOOL,
     PARAM_AT(Cylinder, caps),
     .default_text = "true",
     .doc = "Whether the ends are closed by discs."},
};

static bool cylinder_finish(NodeFinish *finish)
{
    Cylinder *c = finish->params;
    if (!(length_squared(sub(c->to, c->from)) > 0)) {
        finish->report(finish, 1, E0801, "both ends of a cylinder are the same point");
        return false;
    }
    c->frustum = frustum_make(c->from, c->to, c->radius, c->radius, c->caps);
    return true;
}

static Box3 cylinder_bounds(const Scene *scene, const void *params)
{
    (void)scene;
    const Cylinder *c = params;
    return frustum_bounds(&c->frustum);
}

static bool cylinder_intersect(const void *params, const Ray *ray, ShapeHit *hit)
{
    const Cylinder *c = params;
    return frustum_intersect(&c->frustum, ray, hit);
}

static void cylinder_point(const Scene *scene, const void *params, const Ray *ray,
                           const ShapeHit *hit, ShapePoint *out)
{
    (void)scene;
    const Cylinder *c = params;
    frustum_point(&c->frustum, ray, hit, out);
}

static double cylinder_area(const Scene *scene, const void *params, const Affine *to_world)
{
    (void)scene;
    const Cylinder *c = params;
    return frustum_table(&c->frustum, to_world).total;
}

static void *cylinder_prepare_sampling(const Scene *scene, const void *params,
                                       const Affine *to_world, Arena *arena)
{
    (void)scene;
    const Cylinder *c = params;
    FrustumTable *table = ARENA_NEW(arena, FrustumTable);
    if (table) {
        *table = frustum_table(&c->frustum, to_world);
    }
    return table;
}

static void cylinder_sample_area(const Scene *scene, const void *params, const Affine *to_world,
                                 const void *table, double u0, double u1, double u2,
                                 ShapeSample *out)
{
    (void)scene;
    const Cylinder *c = params;
    FrustumTable own;
    if (!table) {
        own = frustum_table(&c->frustum, to_world);
        table = &own;
    }
    frustum_sample_area(&c->frustum, to_world, table, u0, u1, u2, out);
}

static bool cylinder_closed(const void *params)
{
    const Cylinder *c = params;
    return c->caps;
}

const ShapeClass cylinder_shape = {
    .node =
        {.name = "cylinder",
         .category = CATEGORY_SHAPE,
         .params = cylinder_params,
         .param_count = sizeof cylinder_params / sizeof *cylinder_params,
         .size = sizeof(Cylinder),
         .doc = "A round cylinder between two points. On the side u runs around the axis and v "
                "along it.",
         .formula =
             "|p - axis| = radius, a quadratic in double precision with roots that don't cancel",
         .example =
             "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
             "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: (0, 0, 1.5) "
             "}, radiance: 12 }\n"
             "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], space: \"uv\" } "
             "}\n"
             "plane { material: lambert { color: gray(0.5) } }\n"
             "let clay = lambert { color: #c0704a }\n"
             "cylinder { from: (-0.8, 0, 0), to: (-0.8, 0.9, 0), radius: 0.3, material: clay }\n"
             "cylinder { from: (-0.2, 0.25, 0.3), to: (0.9, 0.25, -0.2), radius: 0.25, material: "
             "clay }\n"
             "cylinder { from: (0.6, 0, -0.9), to: (0.6, 1.1, -0.9), radius: 0.3, caps: false, "
             "material: clay }",
         .finish = cylinder_finish,
         .bounds = cylinder_bounds},
    .holding = HOLD_USER,
    .closed = cylinder_closed,
    .intersect = cylinder_intersect,
    .point = cylinder_point,
    .area = cylinder_area,
    .sample_area = cylinder_sample_area,
    .prepare_sampling = cylinder_prepare_sampling,
};
