// A surface that gives off light.
#include "render/world.h"
#include "schema/photometry.h"

typedef struct Emissive {
    Emission radiance;
    uint32_t base; // material or NONE_ID
    Rgb emitted;   // derived: W/m²/sr, before the texture
} Emissive;

enum { RADIANCE, BASE };

static const Param PARAMS[] = {
    [RADIANCE] = {.name = "radiance",
                  .type = PARAM_EMISSION,
                  PARAM_AT(Emissive, radiance),
                  .flags = PARAM_REQUIRED,
                  .dims = DIM_BIT(DIM_NONE) | DIM_BIT(DIM_LUMINANCE),
                  .si = "W/m²/sr",
                  .min = 0,
                  .max = INFINITY,
                  .doc = "What the front side emits, the same in all directions: a number (W/m²/sr "
                         "or nit), a color or a texture."},
    [BASE] = {.name = "base",
              .type = PARAM_NODE,
              PARAM_AT(Emissive, base),
              .category = CATEGORY_MATERIAL,
              .flags = PARAM_NO_DEFAULT,
              .doc = "The material that reflects; without one the surface is black when off."},
};

static bool finish(NodeFinish *finish)
{
    Emissive *emissive = finish->params;
    if (!(finish->set & (1u << BASE))) {
        emissive->base = NONE_ID;
    }
    return emission_to_rgb(&emissive->radiance, rgb_gray(1), &emissive->emitted);
}

static uint32_t lobes(const World *world, const void *params)
{
    const Emissive *emissive = params;
    return LOBE_EMIT | (emissive->base == NONE_ID ? 0 : material_lobes(world, emissive->base));
}

static BsdfEval eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    const Emissive *emissive = params;
    return emissive->base == NONE_ID ? (BsdfEval){{0, 0, 0}, 0}
                                     : material_eval(point, emissive->base, wi);
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    const Emissive *emissive = params;
    return emissive->base != NONE_ID && material_sample(point, emissive->base, lobe, u, v, out);
}

static int deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room)
{
    const Emissive *emissive = params;
    return emissive->base == NONE_ID ? 0 : material_deltas(point, emissive->base, out, room);
}

static Rgb albedo(const ShadingPoint *point, const void *params)
{
    const Emissive *emissive = params;
    return emissive->base == NONE_ID ? rgb_gray(0) : material_albedo(point, emissive->base);
}

static Rgb emitted(const World *world, const void *params, const Surface *surface)
{
    const Emissive *emissive = params;
    if (!surface->front) {
        return rgb_gray(0);
    }
    return emissive->radiance.texture == NONE_ID
               ? emissive->emitted
               : rgb_mul(emissive->emitted,
                         texture_color(world->textures, emissive->radiance.texture, surface));
}

static Rgb emitted_mean(const World *world, const void *params)
{
    const Emissive *emissive = params;
    return emissive->radiance.texture == NONE_ID
               ? emissive->emitted
               : rgb_mul(emissive->emitted,
                         texture_mean(world->textures, emissive->radiance.texture));
}

static Rgb pass(const World *world, const void *params, const Surface *surface)
{
    const Emissive *emissive = params;
    return emissive->base == NONE_ID ? rgb_gray(0) : material_pass(world, emissive->base, surface);
}

static bool medium(const World *world, const void *params, Medium *out)
{
    const Emissive *emissive = params;
    return emissive->base != NONE_ID && material_medium(world, emissive->base, out);
}

static LocalTerms local(const ShadingPoint *point, const void *params, Vec3 l)
{
    const Emissive *emissive = params;
    return emissive->base == NONE_ID ? (LocalTerms){0} : material_local(point, emissive->base, l);
}

MATERIAL_EVAL(eval)

const MaterialClass emissive_material = {
    .node = {.name = "emissive",
             .category = CATEGORY_MATERIAL,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(Emissive),
             .doc = "Gives off light from its front side (the outside of closed shapes). Any shape "
                    "of this material is a light that is sampled, also inside instances.",
             .formula = "L = radiance, for directions on the front side",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "environment_light { radiance: 0.02 }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "for (i in 0..2) {\n"
                        "  sphere {\n"
                        "    center: (1.05 * (i - 1), 0.5, 0), radius: 0.3\n"
                        "    material: emissive { radiance: [rgb(4, 0.6, 0.3), rgb(2, 1.6, 1), "
                        "rgb(0.4, 0.9, 4)][i] }\n"
                        "  }\n"
                        "}",
             .finish = finish},
    .lobes = lobes,
    .eval = eval_into,
    .sample = sample,
    .deltas = deltas,
    .albedo = albedo,
    .emitted = emitted,
    .emitted_mean = emitted_mean,
    .pass = pass,
    .medium = medium,
    .local = local,
};
