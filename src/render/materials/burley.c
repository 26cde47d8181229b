// Burley's diffuse reflection: brighter at grazing angles the rougher it is.
#include "base/fresnel.h"
#include "render/world.h"

typedef struct Burley {
    ColorTex color;
    NumberTex roughness;
} Burley;

static const Param PARAMS[] = {
    {.name = "color",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(Burley, color),
     .min = 0,
     .max = 1,
     .default_text = "gray(0.5)",
     .doc = "The factor k, about the part of the light that is reflected."},
    {.name = "roughness",
     .type = PARAM_NUMBER_TEX,
     PARAM_AT(Burley, roughness),
     .min = 0,
     .max = 1,
     .default_text = "0.5",
     .doc = "From 0, darker towards the edges, to 1, brighter there."},
};

static uint32_t lobes(const World *world, const void *params)
{
    (void)world, (void)params;
    return LOBE_REFLECT | LOBE_SMOOTH;
}

// 1 + (f90 - 1)(1 - c)^5 is Schlick's form, turned round.
static double rim(double f90, double cos_w)
{
    return 1 + (f90 - 1) * fresnel_schlick(0, cos_w);
}

static BsdfEval eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    const Burley *burley = params;
    Vec3 wo = point->wo;
    if (wi.z * wo.z <= 0) {
        return (BsdfEval){{0, 0, 0}, 0};
    }
    const TextureSet *textures = point->world->textures;
    double alpha = (double)fraction_tex(textures, &burley->roughness, point->surface);
    double cos_d = dot(wi, normalize(add(wi, wo)));
    double f90 = 0.5 + 2 * alpha * cos_d * cos_d;
    double pdf = fabs(wi.z) / PI;
    double f = pdf * rim(f90, fabs(wi.z)) * rim(f90, fabs(wo.z));
    Rgb k = reflectance_tex(textures, &burley->color, point->surface);
    return (BsdfEval){rgb_scale(k, (float)f), (float)pdf};
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    (void)lobe;
    Vec3 wi = sample_cosine_hemisphere(u, v);
    wi.z = copysign(wi.z, point->wo.z);
    BsdfEval e = eval(point, params, wi);
    if (!(e.pdf > 0)) {
        return false;
    }
    *out = (BsdfSample){wi, rgb_scale(e.value, 1 / e.pdf), e.pdf, 1, LOBE_REFLECT | LOBE_SMOOTH};
    return true;
}

static Rgb albedo(const ShadingPoint *point, const void *params)
{
    const Burley *burley = params;
    return reflectance_tex(point->world->textures, &burley->color, point->surface);
}

MATERIAL_EVAL(eval)

const MaterialClass burley_material = {
    .node = {.name = "burley",
             .category = CATEGORY_MATERIAL,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(Burley),
             .doc = "Burley's matt surface (Disney 2012), for clay, cloth, rubber; the same from "
                    "both sides. It doesn't conserve energy by construction: at roughness 1 and "
                    "grazing angles it gives back more than it gets.",
             .formula = "f = color/π [1 + (f90 - 1)(1 - n·wi)^5] [1 + (f90 - 1)(1 - n·wo)^5],\n"
                        "f90 = 1/2 + 2 roughness (wi·h)²   (slides, equation 9; slide 69)",
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
                        "    material: burley { color: #b0805a, roughness: [0, 0.5, 1][i] }\n"
                        "  }\n"
                        "}"},
    .lobes = lobes,
    .eval = eval_into,
    .sample = sample,
    .albedo = albedo,
    .caveat =
        "Burley's model isn't energy-conserving by construction: where it is rough and seen at "
        "a grazing angle, it gives back more than it gets",
};
