// Phong's model: a highlight about the mirrored direction.
#include "render/materials/phong_model.h"

// r·v with r = 2 (l·n) n - l.
static double mirrored(Vec3 v, Vec3 l)
{
    return fmax(0, l.z * v.z - l.x * v.x - l.y * v.y);
}

// Lafortune and Willems 1994.
static double norm(double e)
{
    return (e + 2) / (2 * PI);
}

static Vec3 sample_lobe(double e, Vec3 v, double u1, double u2)
{
    double c = pow(1 - u1, 1 / (e + 1)), s = sqrt(fmax(0, 1 - c * c)), phi = 2 * PI * u2;
    Frame frame = frame_from_normal(vec3(-v.x, -v.y, v.z));
    return normalize(from_local(&frame, vec3(s * cos(phi), s * sin(phi), c)));
}

static double lobe_pdf(double e, Vec3 v, Vec3 l)
{
    return (e + 1) / (2 * PI) * pow(mirrored(v, l), e);
}

static const SpecularLobe LOBE = {mirrored, norm, sample_lobe, lobe_pdf};

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

const MaterialClass phong_material = {
    .node = {.name = "phong",
             .category = CATEGORY_MATERIAL,
             .params = phong_params,
             .param_count = PHONG_PARAM_COUNT,
             .size = sizeof(PhongModel),
             .doc = "Phong's model (1973), as a BRDF whose diffuse and specular are the parts of "
                    "the light that it reflects at normal incidence; with the integrator "
                    "\"local\" the raw expressions of the slides. The same from both sides.",
             .formula =
                 "f = diffuse color / π + specular specular_color (e+2)/(2π) max(0, r·v)^e,\n"
                 "r = 2 (n·l) n - l, e = shininess   (Lafortune and Willems 1994)\n"
                 "local: ambient color + diffuse color max(0, n·l) + specular specular_color d "
                 "max(0, r·v)^e,\n"
                 "d = 1 where n·l > 0, else 0   (slides, equations 4 to 6; slide 40)",
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
                        "    material: phong { color: #a03020, diffuse: 0.7, specular: 0.3, "
                        "shininess: [8, 40, 400][i] }\n"
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
