#include "render/materials/lambert.h"

const Lambert lambert_default = {{{0.5f, 0.5f, 0.5f}, NONE_ID}};
const Lambert lambert_black = {{{0, 0, 0}, NONE_ID}};

static const Param PARAMS[] = {
    {.name = "color",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(Lambert, color),
     .min = 0,
     .max = 1,
     .default_text = "gray(0.5)",
     .doc = "The part of the light that is reflected, its albedo."},
};

static Rgb albedo(const ShadingPoint *point, const void *params)
{
    return lambert_albedo(point, params);
}

static uint32_t lobes(const World *world, const void *params)
{
    (void)world, (void)params;
    return LOBE_REFLECT | LOBE_SMOOTH;
}

static void eval(const ShadingPoint *point, const void *params, Vec3 wi, BsdfEval *out)
{
    *out = lambert_eval(point, lambert_albedo(point, params), wi);
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    (void)lobe;
    *out = lambert_sample(point, lambert_albedo(point, params), sample_cosine_hemisphere(u, v));
    return out->pdf > 0;
}

// Equation (5) with k_dl = 1; no ambient and no specular term.
static LocalTerms local(const ShadingPoint *point, const void *params, Vec3 l)
{
    double cos_l = fmax(0, copysign(1, point->wo.z) * l.z);
    return (LocalTerms){.diffuse = rgb_scale(albedo(point, params), (float)cos_l)};
}

const MaterialClass lambert_material = {
    .node = {.name = "lambert",
             .category = CATEGORY_MATERIAL,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(Lambert),
             .doc = "A perfectly matt surface, the same from both sides: it looks equally bright "
                    "from everywhere.",
             .formula = "f = color / π   (Lambert's law; slides, equation 8)",
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
                        "    material: lambert { color: [#c0392b, #d9a441, #2f6f9f][i] }\n"
                        "  }\n"
                        "}"},
    .lobes = lobes,
    .eval = eval,
    .sample = sample,
    .albedo = albedo,
    .local = local,
};
