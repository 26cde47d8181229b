// Glass, water, plastics, smooth or rough: reflection and refraction at once.
#include "render/materials/interface.h"
#include "render/world.h"

typedef struct FresnelParams {
    double ior, outside;
    Roughness roughness;
    ColorTex color;
    Rgb absorption;
    int32_t approximation;
    int64_t priority;
} FresnelParams;

enum { EXACT, SCHLICK };
static const char *const APPROXIMATIONS[] = {"exact", "schlick", NULL};

static const Param PARAMS[] = {
    {.name = "ior",
     .type = PARAM_NUMBER,
     PARAM_AT(FresnelParams, ior),
     .dims = DIM_BIT(DIM_NONE),
     .min = 1,
     .max = 100,
     .default_text = "1.5",
     .doc = "The index of refraction inside, behind the surface."},
    {.name = "outside",
     .type = PARAM_NUMBER,
     PARAM_AT(FresnelParams, outside),
     .dims = DIM_BIT(DIM_NONE),
     .min = 1,
     .max = 100,
     .default_text = "1",
     .doc =
         "The index of refraction in front of the surface, where no other body of `fresnel` is."},
    {.name = "alpha",
     .type = PARAM_PAIR_TEX,
     PARAM_AT(FresnelParams, roughness.alpha),
     .min = 0,
     .max = 1,
     .default_text = "0",
     .doc = "The roughness, as in `ggx`; 0 is clear."},
    {.name = "rotation",
     .type = PARAM_NUMBER_TEX,
     PARAM_AT(FresnelParams, roughness.rotation),
     .dims = DIM_BIT(DIM_ANGLE),
     .default_text = "0deg",
     .doc = "Turns the axes of a pair `alpha`, as in `ggx`."},
    {.name = "color",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(FresnelParams, color),
     .min = 0,
     .max = 1,
     .default_text = "rgb(1, 1, 1)",
     .doc = "Tints light each time it passes the surface; the reflection stays white."},
    {.name = "absorption",
     .type = PARAM_COLOR,
     PARAM_AT(FresnelParams, absorption),
     .min = 0,
     .max = INFINITY,
     .default_text = "rgb(0, 0, 0)",
     .doc = "Per metre inside: what is left after a distance d is exp(-absorption d)."},
    {.name = "approximation",
     .type = PARAM_CHOICE,
     PARAM_AT(FresnelParams, approximation),
     .choices = APPROXIMATIONS,
     .default_text = "\"exact\"",
     .doc = "How much is reflected: by Fresnel's exact formula or by Schlick's approximation."},
    {.name = "priority",
     .type = PARAM_INT,
     PARAM_AT(FresnelParams, priority),
     .min = -1000000,
     .max = 1000000,
     .default_text = "0",
     .doc = "Where bodies overlap, the one of the highest priority fills the place; of equal ones "
            "the one entered last."},
};

static Rgb tint(const ShadingPoint *point, const FresnelParams *params)
{
    return reflectance_tex(point->world->textures, &params->color, point->surface);
}

static void at(const ShadingPoint *point, const FresnelParams *params, Interface *out)
{
    const double outside = point->outside > 0 ? point->outside : params->outside;
    interface_at(point, &params->roughness, params->ior, outside, params->approximation == SCHLICK,
                 NULL, tint(point, params), out);
}

static uint32_t lobes(const World *world, const void *params)
{
    (void)world;
    const FresnelParams *p = params;
    return LOBE_REFLECT | LOBE_TRANSMIT | roughness_lobes(&p->roughness);
}

static void eval(const ShadingPoint *point, const void *params, Vec3 wi, BsdfEval *out)
{
    Interface face;
    at(point, params, &face);
    interface_eval(&face, wi, out);
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    Interface face;
    at(point, params, &face);
    return interface_sample(&face, lobe, u, v, out);
}

static int deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room)
{
    Interface face;
    at(point, params, &face);
    return interface_deltas(&face, out, room);
}

static Rgb albedo(const ShadingPoint *point, const void *params)
{
    return tint(point, params);
}

static bool medium(const World *world, const void *params, Medium *out)
{
    (void)world;
    const FresnelParams *p = params;
    *out = (Medium){p->ior, p->outside, p->absorption, p->priority};
    return true;
}

const MaterialClass fresnel_material = {
    .node =
        {.name = "fresnel",
         .category = CATEGORY_MATERIAL,
         .params = PARAMS,
         .param_count = sizeof PARAMS / sizeof *PARAMS,
         .size = sizeof(FresnelParams),
         .doc = "The surface of a transparent body, glass or liquid: part of the light is "
                "reflected, part refracted, clear or, with `alpha`, frosted. It belongs on "
                "closed shapes, whose normals tell the inside. Bodies may overlap: see "
                "`priority`. The integrator \"local\" shows of it the reflections of frosted "
                "glass at most.",
         .formula =
             "F = 1/2 [((ni ci - nt ct)/(ni ci + nt ct))² + ((ni ct - nt ci)/(ni ct + nt ci))²]\n"
             "wt = (r ci - ct) n - r wi, r = ni/nt, ct = √(1 - r²(1 - ci²)); F = 1 where that is "
             "no number\n"
             "Lr = F Li, Lt = (nt/ni)² (1 - F) color Li   (slides, section 3.2)\n"
             "schlick: F = f0 + (1 - f0)(1 - c)^5, f0 = ((ni - nt)/(ni + nt))², c the cosine in "
             "the thinner medium\n"
             "alpha: f = |wi·h||wo·h| (1 - F) G1(wi) G1(wo) D(h) no²/(|wi·n||wo·n| (ni wi·h + no "
             "wo·h)²)\n"
             "   (Walter et al. 2007, equation 21); overlapping bodies: Schmidt and Budge 2002",
         .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
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
                    "      fresnel { ior: 1.5 }, fresnel { ior: 1.5, alpha: 0.15 },\n"
                    "      fresnel { ior: 1.5, absorption: rgb(4, 0.7, 1.5) }\n"
                    "    ][i]\n"
                    "  }\n"
                    "}"},
    .lobes = lobes,
    .eval = eval,
    .sample = sample,
    .deltas = deltas,
    .albedo = albedo,
    .medium = medium,
};
