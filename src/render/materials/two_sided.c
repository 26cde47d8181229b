// A material for each side of a surface.
#include "render/materials/refracts.h"
#include "render/world.h"

typedef struct TwoSided {
    uint32_t front, back;
} TwoSided;

enum { FRONT, BACK };

static const Param PARAMS[] = {
    [FRONT] = {.name = "front",
               .type = PARAM_NODE,
               PARAM_AT(TwoSided, front),
               .category = CATEGORY_MATERIAL,
               .flags = PARAM_REQUIRED,
               .doc = "The material of the front side: the outside of closed shapes."},
    [BACK] = {.name = "back",
              .type = PARAM_NODE,
              PARAM_AT(TwoSided, back),
              .category = CATEGORY_MATERIAL,
              .flags = PARAM_NO_DEFAULT,
              .doc = "The material of the back side; without it the same as `front`."},
};

static bool finish(NodeFinish *finish)
{
    TwoSided *two = finish->params;
    if (!(finish->set >> BACK & 1)) {
        two->back = two->front;
    }
    if (material_refracts(finish->scene, two->front)) {
        finish->report(finish, FRONT, E0952, "glass in `two_sided`");
        return false;
    }
    if (material_refracts(finish->scene, two->back)) {
        finish->report(finish, BACK, E0952, "glass in `two_sided`");
        return false;
    }
    return true;
}

static uint32_t side_of(const TwoSided *two, bool front)
{
    return front ? two->front : two->back;
}

// The surface turned over, so that a material on the back has its front there, too.
static Surface turned_over(const Surface *surface)
{
    Surface turned = *surface;
    turned.front = true;
    return turned;
}

static uint32_t lobes(const World *world, const void *params)
{
    const TwoSided *two = params;
    return material_lobes(world, two->front) | material_lobes(world, two->back);
}

static uint32_t seen(const ShadingPoint *point, const void *params)
{
    return side_of(params, point->wo_side > 0);
}

static BsdfEval eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    return material_eval(point, seen(point, params), wi);
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    return material_sample(point, seen(point, params), lobe, u, v, out);
}

static int deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room)
{
    return material_deltas(point, seen(point, params), out, room);
}

static Rgb albedo(const ShadingPoint *point, const void *params)
{
    return material_albedo(point, seen(point, params));
}

static Rgb emitted(const World *world, const void *params, const Surface *surface)
{
    Surface turned = turned_over(surface);
    return material_emitted(world, side_of(params, surface->front), &turned);
}

static Rgb emitted_mean(const World *world, const void *params)
{
    const TwoSided *two = params;
    return rgb_add(material_emitted_mean(world, two->front),
                   material_emitted_mean(world, two->back));
}

static Rgb pass(const World *world, const void *params, const Surface *surface)
{
    Surface turned = turned_over(surface);
    return material_pass(world, side_of(params, surface->front), &turned);
}

static LocalTerms local(const ShadingPoint *point, const void *params, Vec3 l)
{
    return material_local(point, seen(point, params), l);
}

MATERIAL_EVAL(eval)

const MaterialClass two_sided_material = {
    .node = {.name = "two_sided",
             .category = CATEGORY_MATERIAL,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(TwoSided),
             .doc =
                 "One material for the front of a surface and one for its back: the two faces of "
                 "a sheet. An `emissive` on the back shines backwards. Glass can't be a side: it "
                 "belongs to both.",
             .formula = "f = f_front where the viewer is in front, else f_back",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "let paper = two_sided { front: lambert { color: #d8d0c0 }, back: lambert "
                        "{ color: #b03a2a } }\n"
                        "cylinder { from: (-0.6, 0, 0), to: (-0.6, 0.8, 0), radius: 0.45, caps: "
                        "false, material: paper }\n"
                        "disc { center: (0.7, 0.5, 0), normal: (-0.3, 0.2, 1), radius: 0.45, "
                        "material: paper }\n"
                        "disc { center: (0.7, 0.4, 0.8), normal: (0.3, -0.8, -1), radius: 0.3, "
                        "material: paper }",
             .finish = finish},
    .lobes = lobes,
    .eval = eval_into,
    .sample = sample,
    .deltas = deltas,
    .albedo = albedo,
    .emitted = emitted,
    .emitted_mean = emitted_mean,
    .pass = pass,
    .local = local,
};
