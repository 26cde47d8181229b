// Cut-outs: a surface that isn't there everywhere.
#include "render/world.h"

typedef struct Mask {
    NumberTex opacity;
    uint32_t base;
} Mask;

static const Param PARAMS[] = {
    {.name = "opacity",
     .type = PARAM_NUMBER_TEX,
     PARAM_AT(Mask, opacity),
     .min = 0,
     .max = 1,
     .flags = PARAM_REQUIRED,
     .doc = "1 where the surface is, 0 where it isn't; between, a part of the light passes."},
    {.name = "base",
     .type = PARAM_NODE,
     PARAM_AT(Mask, base),
     .category = CATEGORY_MATERIAL,
     .flags = PARAM_REQUIRED,
     .doc = "The material of the surface where it is."},
};

static float opacity_at(const World *world, const Mask *mask, const Surface *surface)
{
    return fraction_tex(world->textures, &mask->opacity, surface);
}

static uint32_t lobes(const World *world, const void *params)
{
    const Mask *mask = params;
    return LOBE_PASS | material_lobes(world, mask->base);
}

static BsdfEval eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    const Mask *mask = params;
    float opacity = opacity_at(point->world, mask, point->surface);
    BsdfEval e = {{0, 0, 0}, 0};
    if (opacity > 0) {
        e = material_eval(point, mask->base, wi);
    }
    return (BsdfEval){rgb_scale(e.value, opacity), e.pdf * opacity};
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    const Mask *mask = params;
    float opacity = opacity_at(point->world, mask, point->surface);
    if (!(lobe < opacity)) {
        Vec3 wo = point->wo;
        *out = (BsdfSample){vec3(-wo.x, -wo.y, -wo.z), rgb_gray(1), 1 - opacity, 1,
                            LOBE_TRANSMIT | LOBE_DELTA | LOBE_PASS};
        return true;
    }
    lobe = fminf(lobe / opacity, 0x1.fffffep-1f);
    if (!material_sample(point, mask->base, lobe, u, v, out)) {
        return false;
    }
    out->pdf *= opacity; // as is the value: the weight stays
    return true;
}

// What passes is told by `pass`.
static int deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room)
{
    const Mask *mask = params;
    float opacity = opacity_at(point->world, mask, point->surface);
    int count = opacity > 0 ? material_deltas(point, mask->base, out, room) : 0;
    for (int i = 0; i < count; ++i) {
        out[i].weight = rgb_scale(out[i].weight, opacity);
    }
    return count;
}

static Rgb albedo(const ShadingPoint *point, const void *params)
{
    const Mask *mask = params;
    return rgb_scale(material_albedo(point, mask->base),
                     opacity_at(point->world, mask, point->surface));
}

static Rgb emitted(const World *world, const void *params, const Surface *surface)
{
    const Mask *mask = params;
    return rgb_scale(material_emitted(world, mask->base, surface),
                     opacity_at(world, mask, surface));
}

static Rgb emitted_mean(const World *world, const void *params)
{
    const Mask *mask = params;
    float opacity = (float)mask->opacity.value;
    if (mask->opacity.texture != NONE_ID) {
        opacity *= luminance(texture_mean(world->textures, mask->opacity.texture));
    }
    return rgb_scale(material_emitted_mean(world, mask->base), fminf(fmaxf(opacity, 0), 1));
}

static Rgb pass(const World *world, const void *params, const Surface *surface)
{
    const Mask *mask = params;
    float opacity = opacity_at(world, mask, surface);
    Rgb base = material_pass(world, mask->base, surface);
    return rgb_add(rgb_gray(1 - opacity), rgb_scale(base, opacity));
}

static bool medium(const World *world, const void *params, Medium *out)
{
    const Mask *mask = params;
    return material_medium(world, mask->base, out);
}

static LocalTerms local(const ShadingPoint *point, const void *params, Vec3 l)
{
    const Mask *mask = params;
    float opacity = opacity_at(point->world, mask, point->surface);
    LocalTerms t = material_local(point, mask->base, l);
    return (LocalTerms){rgb_scale(t.ambient, opacity), rgb_scale(t.diffuse, opacity),
                        rgb_scale(t.specular, opacity)};
}

MATERIAL_EVAL(eval)

const MaterialClass mask_material = {
    .node = {.name = "mask",
             .category = CATEGORY_MATERIAL,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(Mask),
             .doc = "Cuts holes into a surface: leaves, fences, lace. Light passes the holes "
                    "straight on, shadows show them, and passing one doesn't count as a bounce.",
             .formula = "f = opacity f_base + (1 - opacity) δ(wi + wo)",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane {\n"
                        "  material: lambert { color: checker { a: gray(0.6), b: gray(0.35), "
                        "space: \"world\", scale: 2 } }\n"
                        "}\n"
                        "for (i in 0..2) {\n"
                        "  sphere {\n"
                        "    center: (1.05 * (i - 1), 0.5, 0), radius: 0.5\n"
                        "    material: mask {\n"
                        "      opacity: checker { a: gray(1), b: gray(0), scale: [4, 8, 16][i] }\n"
                        "      base: lambert { color: #c07030 }\n"
                        "    }\n"
                        "  }\n"
                        "}"},
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
