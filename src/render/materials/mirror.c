// A perfect mirror, of any color or of a metal.
#include "base/fresnel.h"
#include "render/world.h"

typedef struct Mirror {
    ColorTex color;
    ColorTex eta, k;
    bool metal; // derived: by eta and k
} Mirror;

enum { COLOR, ETA, K };

static const Param PARAMS[] = {
    [COLOR] = {.name = "color",
               .type = PARAM_COLOR_TEX,
               PARAM_AT(Mirror, color),
               .min = 0,
               .max = 1,
               .default_text = "rgb(1, 1, 1)",
               .doc = "The part of the light that is reflected, at all angles."},
    [ETA] = {.name = "eta",
             .type = PARAM_COLOR_TEX,
             PARAM_AT(Mirror, eta),
             .min = 0,
             .max = 100,
             .flags = PARAM_NO_DEFAULT,
             .doc = "A metal's index of refraction for red, green and blue; with `k`, in place of "
                    "`color`."},
    [K] = {.name = "k",
           .type = PARAM_COLOR_TEX,
           PARAM_AT(Mirror, k),
           .min = 0,
           .max = 100,
           .flags = PARAM_NO_DEFAULT,
           .doc = "A metal's coefficient of extinction for red, green and blue."},
};

static bool finish(NodeFinish *finish)
{
    Mirror *mirror = finish->params;
    bool eta = finish->set >> ETA & 1, k = finish->set >> K & 1;
    mirror->metal = eta && k;
    if (eta != k) {
        finish->report(finish, eta ? ETA : K, E0950, "a metal needs both `eta` and `k`");
        return false;
    }
    if (mirror->metal && finish->set >> COLOR & 1) {
        finish->report(finish, COLOR, E0950, "a metal's color follows from `eta` and `k`");
        return false;
    }
    if (!mirror->metal) {
        mirror->eta.texture = mirror->k.texture = NONE_ID;
    }
    return true;
}

static uint32_t lobes(const World *world, const void *params)
{
    (void)world, (void)params;
    return LOBE_REFLECT | LOBE_DELTA;
}

static BsdfEval eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    (void)point, (void)params, (void)wi;
    return (BsdfEval){{0, 0, 0}, 0};
}

static Rgb reflectance(const ShadingPoint *point, const Mirror *mirror, double cos_i)
{
    if (mirror->metal) {
        const TextureSet *textures = point->world->textures;
        return fresnel_metal(cos_i, positive_tex(textures, &mirror->eta, point->surface),
                             positive_tex(textures, &mirror->k, point->surface));
    }
    return reflectance_tex(point->world->textures, &mirror->color, point->surface);
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    (void)lobe, (void)u, (void)v;
    Vec3 wo = point->wo;
    *out = (BsdfSample){vec3(-wo.x, -wo.y, wo.z), reflectance(point, params, fabs(wo.z)), 1, 1,
                        LOBE_REFLECT | LOBE_DELTA};
    return true;
}

static int deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room)
{
    return room > 0 && sample(point, params, 0, 0, 0, out) ? 1 : -1;
}

static Rgb albedo(const ShadingPoint *point, const void *params)
{
    return reflectance(point, params, 1);
}

MATERIAL_EVAL(eval)

const MaterialClass mirror_material = {
    .node = {.name = "mirror",
             .category = CATEGORY_MATERIAL,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(Mirror),
             .doc = "A perfect mirror, the same from both sides. The integrator \"local\" shows it "
                    "black, since it reflects no light of its own making.",
             .formula = "L(wr) = color L(wi), wi = 2 (wr·n) n - wr   (slides, section 3.1);\n"
                        "a metal: color = F(eta, k, n·wr), exact and unpolarised",
             .example =
                 "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                 "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: (0, 0, "
                 "1.5) }, radiance: 12 }\n"
                 "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], space: "
                 "\"uv\" } }\n"
                 "plane {\n"
                 "  material: lambert { color: checker { a: gray(0.6), b: gray(0.35), space: "
                 "\"world\", scale: 2 } }\n"
                 "}\n"
                 "for (i in 0..2) {\n"
                 "  sphere {\n"
                 "    center: (1.05 * (i - 1), 0.5, 0), radius: 0.5\n"
                 "    material: [\n"
                 "      mirror {}, mirror { color: #e0b080 },\n"
                 "      mirror { eta: rgb(0.2, 0.92, 1.1), k: rgb(3.91, 2.45, 2.14) } // copper\n"
                 "    ][i]\n"
                 "  }\n"
                 "}",
             .finish = finish},
    .lobes = lobes,
    .eval = eval_into,
    .sample = sample,
    .deltas = deltas,
    .albedo = albedo,
};
