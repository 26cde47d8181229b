// Normals from heights.
#include "render/materials/bent.h"
#include "render/world.h"

typedef struct BumpMap {
    Bent bent; // first
    NumberTex map;
    NumberTex strength;
} BumpMap;

static const Param PARAMS[] = {
    {.name = "base",
     .type = PARAM_NODE,
     PARAM_AT(BumpMap, bent.base),
     .category = CATEGORY_MATERIAL,
     .flags = PARAM_REQUIRED,
     .doc = "The material that the bumps are for."},
    {.name = "map",
     .type = PARAM_NUMBER_TEX,
     PARAM_AT(BumpMap, map),
     .flags = PARAM_REQUIRED,
     .doc = "The height above the surface."},
    {.name = "strength",
     .type = PARAM_NUMBER_TEX,
     PARAM_AT(BumpMap, strength),
     .dims = DIM_BIT(DIM_LENGTH),
     .default_text = "1",
     .doc = "Metres of height for a map of 1; negative turns bumps into hollows."},
};

// Heights are compared this far to both sides in u and in v.
static const double STEP = 1.0 / 2048;

// A vector of the world in the shape's own space.
static Vec3 to_object(const Scene *scene, const Surface *surface, Vec3 v)
{
    if (surface->instance < scene->instances.count) {
        uint32_t transform = scene->instances.items[surface->instance].transform;
        v = transform_vector(&scene->inverses.items[transform], v);
    }
    if (surface->shape < scene->nodes[CATEGORY_SHAPE].count) {
        uint32_t transform = scene_node(scene, CATEGORY_SHAPE, surface->shape)->transform;
        v = transform_vector(&scene->inverses.items[transform], v);
    }
    return v;
}

static double height_at(const World *world, const BumpMap *bump, const Surface *surface, Vec3 along,
                        Vec3 along_object, double du, double dv)
{
    Surface moved = *surface;
    double step = du + dv;
    moved.uv.x += du;
    moved.uv.y += dv;
    moved.p = add_scaled(moved.p, along, step);
    moved.object_p = add_scaled(moved.object_p, along_object, step);
    return (double)number_tex(world->textures, &bump->map, &moved) *
           (double)number_tex(world->textures, &bump->strength, &moved);
}

// dh/du or dh/dv by a central difference.
static double slope(const World *world, const BumpMap *bump, const Surface *surface, Vec3 along,
                    bool v)
{
    Vec3 object = to_object(world->scene, surface, along);
    double du = v ? 0 : STEP, dv = v ? STEP : 0;
    double up = height_at(world, bump, surface, along, object, du, dv);
    double down = height_at(world, bump, surface, along, object, -du, -dv);
    return (up - down) / (2 * STEP);
}

// The surface p + h n has the tangents dp/du + dh/du n and dp/dv + dh/dv n; their product is the
// normal (Blinn 1978), where the curvature is small against the heights.
static Vec3 normal(const World *world, const Bent *bent, const Surface *surface)
{
    const BumpMap *bump = (const BumpMap *)(const void *)bent;
    Vec3 n = surface->shading, u = surface->tangent, v = surface->bitangent;
    double hu = slope(world, bump, surface, u, false), hv = slope(world, bump, surface, v, true);
    u = add_scaled(u, n, -dot(u, n)); // into the plane of the shading normal
    v = add_scaled(v, n, -dot(v, n));
    double area = dot(cross(u, v), n);
    if (!(fabs(area) > 1e-12 * length(u) * length(v))) {
        return n; // at a pole of the coordinates
    }
    Vec3 turn = add(scale(cross(n, v), hu), scale(cross(u, n), hv));
    return add_scaled(n, turn, 1 / area);
}

static bool finish(NodeFinish *finish)
{
    BumpMap *bump = finish->params;
    bump->bent.normal = normal;
    return true;
}

MATERIAL_EVAL(bent_eval)

const MaterialClass bump_map_material = {
    .node =
        {.name = "bump_map",
         .category = CATEGORY_MATERIAL,
         .params = PARAMS,
         .param_count = sizeof PARAMS / sizeof *PARAMS,
         .size = sizeof(BumpMap),
         .doc = "Makes a surface look as if it had the heights of a texture; its outline stays. "
                "Slopes are taken over 1/1024 of the texture coordinates. Light never leaks "
                "through from behind the surface.",
         .formula = "n' ∝ n + (dh/du n × dp/dv + dh/dv dp/du × n)/|dp/du × dp/dv|, h = strength "
                    "map   (Blinn 1978)",
         .example =
             "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
             "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: (0, 0, 1.5) "
             "}, radiance: 12 }\n"
             "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], space: \"uv\" } "
             "}\n"
             "plane {\n"
             "  material: lambert { color: checker { a: gray(0.6), b: gray(0.35), space: "
             "\"world\", scale: 2 } }\n"
             "}\n"
             "for (i in 0..2) {\n"
             "  sphere {\n"
             "    center: (1.05 * (i - 1), 0.5, 0), radius: 0.5\n"
             "    material: bump_map {\n"
             "      map: noise { scale: 12, octaves: 4 } * 0.05\n"
             "      base: ggx { f0: rgb(0.9, 0.6, 0.4), alpha: 0.15 }, strength: [0, 0.5, 1][i]\n"
             "    }\n"
             "  }\n"
             "}",
         .finish = finish},
    BENT_FUNCTIONS,
    .caveat =
        "a bent normal shows and hides light that the surface doesn't: energy and reciprocity "
        "hold for its base alone",
};
