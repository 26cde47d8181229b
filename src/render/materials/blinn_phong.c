// Blinn's variant of Phong's model: a highlight where the half vector meets the normal.
#include "base/fresnel.h"
#include "render/materials/phong_model.h"

// n·h with h = (l + v)/|l + v|.
static double half_cosine(Vec3 v, Vec3 l)
{
    return fmax(0, normalize(add(v, l)).z);
}

// 1 over the integral of (n·h)^e n·l over the directions l, for v along the normal: exact (Giesen
// 2009, "Phong and Blinn-Phong normalization factors").
static double norm(double e)
{
    return (e + 2) * (e + 4) / (8 * PI * (exp2(-e / 2) + e));
}

// A half vector with density (e+1)/(2π) (n·h)^e, and v mirrored about it.
static Vec3 sample_lobe(double e, Vec3 v, double u1, double u2)
{
    double c = pow(1 - u1, 1 / (e + 1)), s = sqrt(fmax(0, 1 - c * c)), phi = 2 * PI * u2;
    return normalize(reflect(v, vec3(s * cos(phi), s * sin(phi), c)));
}

static double lobe_pdf(double e, Vec3 v, Vec3 l)
{
    Vec3 h = normalize(add(v, l));
    return (e + 1) / (2 * PI) * pow(fmax(0, h.z), e) / (4 * dot(v, h));
}

static const SpecularLobe LOBE = {half_cosine, norm, sample_lobe, lobe_pdf};

static BsdfEval eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    return phong_eval(&LOBE, point, params, wi);
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    return phong_sample(&LOBE, point, params, lobe, u, v, out);
}

static LocalTerms local(const ShadingPoint *point, const void *params, Vec3 l)
{
    return phong_local(&LOBE, point, params, l);
}

MATERIAL_EVAL(eval)

const MaterialClass blinn_phong_material = {
    .node = {.name = "blinn_phong",
             .category = CATEGORY_MATERIAL,
             .params = phong_params,
             .param_count = PHONG_PARAM_COUNT,
             .size = sizeof(PhongModel),
             .doc = "Blinn's variant (1977) of Phong's model, with the half vector h between the "
                    "directions to the light and to the viewer. As `phong` otherwise.",
             .formula =
                 "f = diffuse color / π + specular specular_color (e+2)(e+4)/(8π(2^(-e/2)+e)) "
                 "(n·h)^e,\n"
                 "h = (l + v)/|l + v|, e = shininess\n"
                 "local: ambient color + diffuse color max(0, n·l) + specular specular_color "
                 "d (n·h)^e,\n"
                 "d = 1 where n·l > 0, else 0   (slides, equations 4, 5 and 7; slide 43)",
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
                        "    material: blinn_phong {\n"
                        "      color: #305080\n"
                        "      diffuse: 0.7\n"
                        "      specular: 0.3\n"
                        "      shininess: [8, 40, 400][i]\n"
                        "    }\n"
                        "  }\n"
                        "}",
             .finish = phong_finish},
    .lobes = phong_lobes,
    .eval = eval_into,
    .sample = sample,
    .albedo = phong_albedo,
    .local = local,
    .caveat = "the model adds its terms without a bound: diffuse and specular should not exceed 1 "
              "together",
};
