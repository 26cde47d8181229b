// Microfacet reflection: metals, and rough surfaces of which only the reflection counts.
#include "render/materials/ggx.h"

#include "base/fresnel.h"
#include "render/ggx_energy.h"
#include "render/materials/interface.h"
#include "render/world.h"

enum { F0, IOR, ETA, K, ALPHA, ROTATION, FRESNEL, ENERGY };

static const char *const FRESNELS[] = {"schlick", "exact", NULL};
static const char *const ENERGIES[] = {"single", "preserve", NULL};

static const Param PARAMS[] = {
    [F0] = {.name = "f0",
            .type = PARAM_COLOR_TEX,
            PARAM_AT(GgxParams, f0),
            .min = 0,
            .max = 1,
            .flags = PARAM_NO_DEFAULT,
            .doc = "The reflectance seen along the normal. Exactly one of `f0`, `ior`, and `eta` "
                   "with `k` is given."},
    [IOR] = {.name = "ior",
             .type = PARAM_NUMBER_TEX,
             PARAM_AT(GgxParams, ior),
             .min = 1,
             .max = 100,
             .flags = PARAM_NO_DEFAULT,
             .doc = "The index of refraction of a surface that doesn't conduct. What it doesn't "
                    "reflect is lost, except as the coat of `layered`."},
    [ETA] = {.name = "eta",
             .type = PARAM_COLOR_TEX,
             PARAM_AT(GgxParams, eta),
             .min = 0,
             .max = 100,
             .flags = PARAM_NO_DEFAULT,
             .doc = "A metal's index of refraction for red, green and blue."},
    [K] = {.name = "k",
           .type = PARAM_COLOR_TEX,
           PARAM_AT(GgxParams, k),
           .min = 0,
           .max = 100,
           .flags = PARAM_NO_DEFAULT,
           .doc = "A metal's coefficient of extinction for red, green and blue."},
    [ALPHA] = {.name = "alpha",
               .type = PARAM_PAIR_TEX,
               PARAM_AT(GgxParams, roughness.alpha),
               .min = 0,
               .max = 1,
               .default_text = "0.2",
               .doc = "The roughness, or a pair: along the tangent (of growing u) and across it. "
                      "Below 0.0001 the surface is a perfect mirror."},
    [ROTATION] = {.name = "rotation",
                  .type = PARAM_NUMBER_TEX,
                  PARAM_AT(GgxParams, roughness.rotation),
                  .dims = DIM_BIT(DIM_ANGLE),
                  .default_text = "0deg",
                  .doc = "Turns the axes of a pair `alpha` about the normal, from the tangent "
                         "towards growing v. A texture gives radians."},
    [FRESNEL] = {.name = "fresnel",
                 .type = PARAM_CHOICE,
                 PARAM_AT(GgxParams, fresnel),
                 .choices = FRESNELS,
                 .flags = PARAM_NO_DEFAULT,
                 .doc = "The Fresnel factor. Without it: \"schlick\" with `f0`, else \"exact\"."},
    [ENERGY] = {.name = "energy",
                .type = PARAM_CHOICE,
                PARAM_AT(GgxParams, energy),
                .choices = ENERGIES,
                .default_text = "\"single\"",
                .doc = "\"preserve\" puts back the light that bounces between facets, which "
                       "\"single\" loses: up to 60 % where alpha is 1."},
};

// --- The author's fields ------------------------------------------------------------------------

static bool given(NodeFinish *finish, int32_t *out)
{
    bool f0 = finish->set >> F0 & 1, ior = finish->set >> IOR & 1;
    bool eta = finish->set >> ETA & 1, k = finish->set >> K & 1;
    if (eta != k) {
        finish->report(finish, eta ? ETA : K, E0950, "a metal needs both `eta` and `k`");
        return false;
    }
    if (f0 + ior + eta != 1) {
        int at = f0 + ior + eta == 0 ? -1 : eta ? ETA : IOR;
        finish->report(finish, at, E0950,
                       "`ggx` needs exactly one of `f0`, `ior`, and `eta` with `k`");
        return false;
    }
    *out = f0 ? GGX_F0 : ior ? GGX_IOR : GGX_METAL;
    return true;
}

static Rgb each(Rgb eta, Rgb k, double (*f)(double, double))
{
    return rgb((float)f((double)eta.r, (double)k.r), (float)f((double)eta.g, (double)k.g),
               (float)f((double)eta.b, (double)k.b));
}

static Rgb schlick_mean(Rgb f0)
{
    return rgb((float)fresnel_schlick_mean((double)f0.r), (float)fresnel_schlick_mean((double)f0.g),
               (float)fresnel_schlick_mean((double)f0.b));
}

// A texture of alpha gives both numbers, so that only a pair as such needs a table of its own.
static void prepare_pair(GgxParams *ggx)
{
    const PairTex *alpha = &ggx->roughness.alpha;
    Ggx facets = {greater(alpha->value.x, GGX_ALPHA_MIN), greater(alpha->value.y, GGX_ALPHA_MIN)};
    ggx->has_pair = ggx->energy == GGX_PRESERVE && alpha->texture == NONE_ID &&
                    facets.alpha_x != facets.alpha_y;
    if (ggx->has_pair) {
        ggx_pair_energy_make(facets, &ggx->pair);
    }
}

// The facet of these indices; `mean` is worked out where it is wanted.
static GgxFacet facet_of(const GgxParams *ggx, double ior, Rgb eta, Rgb k, bool mean)
{
    GgxFacet facet = {.ior = ior, .eta = eta, .k = k};
    facet.normal = ggx->given == GGX_IOR ? rgb_gray((float)fresnel_f0(ior))
                                         : each(eta, k, fresnel_conductor_f0);
    if (!mean) {
        return facet;
    }
    if (ggx->fresnel == GGX_SCHLICK) {
        facet.mean = schlick_mean(facet.normal);
    } else if (ggx->given == GGX_IOR) {
        facet.mean = rgb_gray((float)fresnel_dielectric_mean(ior));
    } else {
        facet.mean = each(eta, k, fresnel_conductor_mean);
    }
    return facet;
}

// Fields that weren't given name no textures.
static void forget_others(GgxParams *ggx)
{
    if (ggx->given != GGX_F0) {
        ggx->f0.texture = NONE_ID;
    }
    if (ggx->given != GGX_IOR) {
        ggx->ior.texture = NONE_ID;
    }
    if (ggx->given != GGX_METAL) {
        ggx->eta.texture = ggx->k.texture = NONE_ID;
    }
}

static bool finish(NodeFinish *finish)
{
    GgxParams *ggx = finish->params;
    if (!given(finish, &ggx->given)) {
        return false;
    }
    if (!(finish->set >> FRESNEL & 1)) {
        ggx->fresnel = ggx->given == GGX_F0 ? GGX_SCHLICK : GGX_EXACT;
    } else if (ggx->given == GGX_F0 && ggx->fresnel == GGX_EXACT) {
        finish->report(finish, FRESNEL, E0951,
                       "the exact Fresnel formula needs `ior`, or `eta` and `k`");
        return false;
    }
    forget_others(ggx);
    ggx->varies =
        ggx->ior.texture != NONE_ID || ggx->eta.texture != NONE_ID || ggx->k.texture != NONE_ID;
    if (ggx->given != GGX_F0 && !ggx->varies) {
        ggx->facet = facet_of(ggx, ggx->ior.value, ggx->eta.value, ggx->k.value, true);
    }
    prepare_pair(ggx);
    return true;
}

// --- At a point
// -----------------------------------------------------------------------------------

// The surface at a point, and the viewer on its front in the facets' frame.
typedef struct Gloss {
    const GgxParams *params;
    Facets facets;
    Vec3 wo;
    double side; // of the viewer: ±1
    Rgb f0;
    const GgxFacet *facet; // unless f0 says all
    GgxFacet own;          // where it varies
    // energy: "preserve"
    double missing_mean; // 1 - mean albedo of mirror facets
    double missing_wo;   // 1 - their albedo towards wo
    Rgb between;         // what light loses to the facets on its way between them
    double diffuse_chance;
} Gloss;

// What is missing in single scattering is added as a lobe that looks the same from everywhere but
// for the cosines (Kulla and Conty 2017):
//   f = F (1 - E(wo)) (1 - E(wi)) / (π (1 - E_mean)), F = F_mean² E_mean / (1 - F_mean (1 -
//   E_mean))
// With F = 1 it sums to what is missing.
static double facets_albedo(const Gloss *gloss, Vec3 w)
{
    const GgxParams *ggx = gloss->params;
    return ggx->has_pair ? ggx_pair_energy(&ggx->pair, w)
                         : ggx_energy(gloss->facets.ggx.alpha_x, w.z);
}

static float between_facets(float f_mean, double e_mean)
{
    double f = (double)f_mean;
    return (float)(f * f * e_mean / (1 - f * (1 - e_mean)));
}

static void prepare_energy(Gloss *gloss)
{
    const GgxParams *ggx = gloss->params;
    double e = ggx->has_pair ? ggx->pair.mean : ggx_energy_mean(gloss->facets.ggx.alpha_x);
    Rgb f = ggx->given == GGX_F0 ? schlick_mean(gloss->f0) : gloss->facet->mean;
    gloss->missing_mean = 1 - e;
    gloss->missing_wo = 1 - facets_albedo(gloss, gloss->wo);
    gloss->between = rgb(between_facets(f.r, e), between_facets(f.g, e), between_facets(f.b, e));
    double spread = gloss->missing_wo * (double)luminance(gloss->between);
    double mirrored = (1 - gloss->missing_wo) * (double)luminance(f);
    gloss->diffuse_chance = spread > 0 ? spread / (spread + mirrored) : 0;
}

static double ior_at(const ShadingPoint *point, const GgxParams *ggx)
{
    return greater(1, (double)number_tex(point->world->textures, &ggx->ior, point->surface));
}

static GgxFacet varying_facet(const ShadingPoint *point, const GgxParams *ggx)
{
    const TextureSet *textures = point->world->textures;
    const double ior = ggx->given == GGX_IOR ? ior_at(point, ggx) : 1;
    const Rgb eta = positive_tex(textures, &ggx->eta, point->surface);
    const Rgb k = positive_tex(textures, &ggx->k, point->surface);
    return facet_of(ggx, ior, eta, k, ggx->energy == GGX_PRESERVE);
}

static void gloss_at(const ShadingPoint *point, const GgxParams *params, Gloss *out)
{
    out->params = params;
    roughness_at(point, &params->roughness, &out->facets);
    out->side = copysign(1, point->wo.z);
    out->wo =
        facets_from_frame(&out->facets, vec3(point->wo.x, point->wo.y, out->side * point->wo.z));
    if (params->given == GGX_F0) {
        out->f0 = reflectance_tex(point->world->textures, &params->f0, point->surface);
    } else {
        if (params->varies) {
            out->own = varying_facet(point, params);
        }
        out->facet = params->varies ? &out->own : &params->facet;
        out->f0 = out->facet->normal;
    }
    out->diffuse_chance = 0;
    if (params->energy == GGX_PRESERVE && !out->facets.smooth) {
        prepare_energy(out);
    }
}

static Vec3 to_front(const Gloss *gloss, Vec3 wi)
{
    return facets_from_frame(&gloss->facets, vec3(wi.x, wi.y, gloss->side * wi.z));
}

static Rgb fresnel_at(const Gloss *gloss, double cos_i)
{
    const GgxParams *p = gloss->params;
    if (p->fresnel == GGX_SCHLICK) {
        return rgb((float)fresnel_schlick((double)gloss->f0.r, cos_i),
                   (float)fresnel_schlick((double)gloss->f0.g, cos_i),
                   (float)fresnel_schlick((double)gloss->f0.b, cos_i));
    }
    if (p->given == GGX_IOR) {
        return rgb_gray((float)fresnel_dielectric(cos_i, gloss->facet->ior, NULL));
    }
    return fresnel_metal(cos_i, gloss->facet->eta, gloss->facet->k);
}

static uint32_t lobes(const World *world, const void *params)
{
    (void)world;
    const GgxParams *ggx = params;
    return LOBE_REFLECT | roughness_lobes(&ggx->roughness);
}

// As the coat of `layered` a surface that isn't a metal lets through what it doesn't reflect, and
// refracts it: by `ior`, or by the index that f0's luminance belongs to.
static bool is_interface(const ShadingPoint *point, const GgxParams *ggx)
{
    return point->layer != LAYER_NONE && ggx->given != GGX_METAL;
}

static void as_interface(const ShadingPoint *point, const GgxParams *ggx, Interface *out)
{
    double outside = point->outside > 0 ? point->outside : 1;
    if (ggx->given == GGX_IOR) {
        interface_at(point, &ggx->roughness, ior_at(point, ggx), outside,
                     ggx->fresnel == GGX_SCHLICK, NULL, rgb_gray(1), out);
        return;
    }
    Rgb f0 = reflectance_tex(point->world->textures, &ggx->f0, point->surface);
    double root = lesser(sqrt((double)luminance(f0)), 0.8);
    interface_at(point, &ggx->roughness, outside * (1 + root) / (1 - root), outside, true, &f0,
                 rgb_gray(1), out);
}

// Expression (10), times the cosine; wi.z > 0, and h the normal half-way between the two.
static void eval_front(const Gloss *gloss, Vec3 wi, Vec3 h, BsdfEval *out)
{
    Ggx ggx = gloss->facets.ggx;
    Vec3 wo = gloss->wo;
    double d = ggx_d(ggx, h), cos_d = dot(wo, h);
    double f = d * ggx_g2(ggx, wi, wo) / (4 * wo.z);
    double pdf = d * ggx_g1(ggx, wo) / (4 * wo.z);
    out->value = rgb_scale(fresnel_at(gloss, cos_d), (float)f);
    out->pdf = (float)pdf;
    if (gloss->diffuse_chance > 0) {
        double missing_wi = 1 - facets_albedo(gloss, wi);
        double cosine = wi.z / PI;
        double spread = cosine * gloss->missing_wo * missing_wi / gloss->missing_mean;
        out->value = rgb_add(out->value, rgb_scale(gloss->between, (float)spread));
        out->pdf = (float)(gloss->diffuse_chance * cosine + (1 - gloss->diffuse_chance) * pdf);
    }
}

static void eval(const ShadingPoint *point, const void *params, Vec3 wi, BsdfEval *out)
{
    if (is_interface(point, params)) {
        Interface face;
        as_interface(point, params, &face);
        interface_eval(&face, wi, out);
        return;
    }
    out->value = rgb_gray(0);
    out->pdf = 0;
    if (wi.z * point->wo.z <= 0) {
        return;
    }
    Gloss gloss;
    gloss_at(point, params, &gloss);
    if (!gloss.facets.smooth) {
        wi = to_front(&gloss, wi);
        eval_front(&gloss, wi, normalize(add(wi, gloss.wo)), out);
    }
}

// A direction, and the normal half-way to it.
static Vec3 choose_front(const Gloss *gloss, double lobe, float u, float v, Vec3 *h)
{
    if (lobe < gloss->diffuse_chance) {
        const Vec3 wi = sample_cosine_hemisphere(u, v);
        *h = normalize(add(wi, gloss->wo));
        return wi;
    }
    *h = ggx_sample_visible(gloss->facets.ggx, gloss->wo, (double)u, (double)v);
    return normalize(reflect(gloss->wo, *h));
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    if (is_interface(point, params)) {
        Interface face;
        as_interface(point, params, &face);
        return interface_sample(&face, lobe, u, v, out);
    }
    Gloss gloss;
    gloss_at(point, params, &gloss);
    Vec3 wo = point->wo;
    if (gloss.facets.smooth) {
        *out = (BsdfSample){vec3(-wo.x, -wo.y, wo.z), fresnel_at(&gloss, fabs(wo.z)), 1, 1,
                            LOBE_REFLECT | LOBE_DELTA};
        return true;
    }
    Vec3 h, wi = choose_front(&gloss, (double)lobe, u, v, &h);
    if (!(wi.z > 0)) {
        return false;
    }
    BsdfEval e;
    eval_front(&gloss, wi, h, &e);
    if (!(e.pdf > 0) || !isfinite(e.pdf)) {
        return false;
    }
    wi = facets_to_frame(&gloss.facets, wi);
    *out = (BsdfSample){vec3(wi.x, wi.y, gloss.side * wi.z), rgb_scale(e.value, 1 / e.pdf), e.pdf,
                        1, LOBE_REFLECT | LOBE_SMOOTH};
    return true;
}

static int deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room)
{
    if (is_interface(point, params)) {
        Interface face;
        as_interface(point, params, &face);
        return interface_deltas(&face, out, room);
    }
    Facets facets;
    roughness_at(point, &((const GgxParams *)params)->roughness, &facets);
    if (!facets.smooth) {
        return 0;
    }
    return room > 0 && sample(point, params, 0, 0, 0, out) ? 1 : -1;
}

static Rgb albedo(const ShadingPoint *point, const void *params)
{
    Gloss gloss;
    gloss_at(point, params, &gloss);
    return fresnel_at(&gloss, fabs(point->wo.z));
}

const MaterialClass ggx_material = {
    .node =
        {.name = "ggx",
         .category = CATEGORY_MATERIAL,
         .params = PARAMS,
         .param_count = sizeof PARAMS / sizeof *PARAMS,
         .size = sizeof(GgxParams),
         .doc = "Reflection by microfacets (GGX): brushed and polished metals, glossy surfaces; "
                "the same from both sides. With energy \"preserve\" a surface that absorbs "
                "nothing gives all light back at any roughness.",
         .formula =
             "f = F D(h) G2(wi, wo) / (4 (n·wi)(n·wo))   (slides, equation 10; slide 79)\n"
             "D(m) = 1/(π αx αy ((m·tx/αx)² + (m·ty/αy)² + (m·n)²)²)\n"
             "G2 = 1/(1 + Λ(wi) + Λ(wo)), Λ(w) = (√(1 + (αx² x² + αy² y²)/z²) - 1)/2   (Heitz "
             "2014)\n"
             "F = f0 + (1 - f0)(1 - wi·h)^5, or exact by ior, or eta and k\n"
             "preserve: + F' (1 - E(wi))(1 - E(wo))/(π (1 - E_mean)), E the albedo where F = 1,\n"
             "F' = F_mean² E_mean/(1 - F_mean (1 - E_mean))   (Kulla and Conty 2017)",
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
                    "    material: ggx {\n"
                    "      eta: rgb(0.143, 0.375, 1.442), k: rgb(3.983, 2.386, 1.603) // gold\n"
                    "      alpha: [(0.02, 0.02), (0.2, 0.2), (0.05, 0.5)][i]\n"
                    "    }\n"
                    "  }\n"
                    "}",
         .finish = finish},
    .lobes = lobes,
    .eval = eval,
    .sample = sample,
    .deltas = deltas,
    .albedo = albedo,
};
