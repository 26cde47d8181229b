// Glass, water, plastics, smooth or rough: reflection and refraction at once.
#include "base/fresnel.h"
#include "render/materials/roughness.h"
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

// The surface at a point, with the viewer turned to z > 0.
typedef struct Interface {
    const FresnelParams *params;
    Facets facets;
    Vec3 wo;
    double side; // of the viewer, ±1
    double eta;  // index beyond over index on the viewer's side
} Interface;

static Vec3 turned(const Interface *face, Vec3 w)
{
    return facets_from_frame(&face->facets, vec3(w.x, w.y, face->side * w.z));
}
static Vec3 turned_back(const Interface *face, Vec3 w)
{
    w = facets_to_frame(&face->facets, w);
    return vec3(w.x, w.y, face->side * w.z);
}

static Interface interface_at(const ShadingPoint *point, const FresnelParams *params)
{
    double outside = point->outside > 0 ? point->outside : params->outside;
    Interface face = {.params = params, .facets = roughness_at(point, &params->roughness)};
    face.side = copysign(1, point->wo.z);
    face.wo = turned(&face, point->wo);
    face.eta = point->wo_side > 0 ? params->ior / outside : outside / params->ior;
    if (fabs(face.eta - 1) < 1e-6) {
        face.facets.smooth = true; // facets between equal media do nothing
    }
    return face;
}

static double reflected(const Interface *face, double cos_i, double *cos_t)
{
    return face->params->approximation == SCHLICK
               ? fresnel_dielectric_schlick(cos_i, face->eta, cos_t)
               : fresnel_dielectric(cos_i, face->eta, cos_t);
}

static Rgb tint(const ShadingPoint *point, const FresnelParams *params)
{
    return reflectance_tex(point->world->textures, &params->color, point->surface);
}

static uint32_t lobes(const World *world, const void *params)
{
    (void)world;
    const FresnelParams *p = params;
    return LOBE_REFLECT | LOBE_TRANSMIT | roughness_lobes(&p->roughness);
}

// Reflection by facets, as in ggx.
static BsdfEval eval_reflection(const Interface *face, Vec3 wi)
{
    Ggx ggx = face->facets.ggx;
    Vec3 m = normalize(add(wi, face->wo));
    double f = reflected(face, dot(face->wo, m), NULL);
    double common = f * ggx_d(ggx, m) / (4 * face->wo.z);
    return (BsdfEval){rgb_gray((float)(common * ggx_g2(ggx, wi, face->wo))),
                      (float)(common * ggx_g1(ggx, face->wo))};
}

// Walter et al. 2007, equation 21, with their separable G; the facet that refracts wi to wo has its
// normal along wo + eta wi.
static BsdfEval eval_transmission(const Interface *face, Rgb color, Vec3 wi)
{
    Ggx ggx = face->facets.ggx;
    Vec3 wo = face->wo, m = add_scaled(wo, wi, face->eta);
    double l = length(m);
    if (!(l > 0)) {
        return (BsdfEval){{0, 0, 0}, 0};
    }
    m = scale(m, copysign(1, m.z) / l);
    double o = dot(wo, m), i = dot(wi, m);
    if (!(o > 0 && i < 0)) {
        return (BsdfEval){{0, 0, 0}, 0};
    }
    double root = face->eta * i + o;
    double through = (1 - reflected(face, o, NULL)) * ggx_d(ggx, m) * ggx_g1(ggx, wo) * o * -i /
                     (wo.z * root * root);
    return (BsdfEval){rgb_scale(color, (float)(through * ggx_g1(ggx, wi))),
                      (float)(through * face->eta * face->eta)};
}

static BsdfEval eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    Interface face = interface_at(point, params);
    if (face.facets.smooth) {
        return (BsdfEval){{0, 0, 0}, 0};
    }
    wi = turned(&face, wi);
    return wi.z > 0 ? eval_reflection(&face, wi)
                    : eval_transmission(&face, tint(point, params), wi);
}

// Radiance that leaves a medium of index eta for one of index 1 spreads: by 1/eta² (slides, section
// 3.2).
static bool sample_smooth(const ShadingPoint *point, const Interface *face, float lobe,
                          BsdfSample *out)
{
    Vec3 wo = face->wo;
    double cos_t, f = reflected(face, wo.z, &cos_t), eta = face->eta;
    if ((double)lobe < f) {
        *out = (BsdfSample){turned_back(face, vec3(-wo.x, -wo.y, wo.z)), rgb_gray(1), (float)f, 1,
                            LOBE_REFLECT | LOBE_DELTA};
        return true;
    }
    Vec3 wt = normalize(vec3(-wo.x / eta, -wo.y / eta, -cos_t));
    *out = (BsdfSample){turned_back(face, wt),
                        rgb_scale(tint(point, face->params), (float)(1 / (eta * eta))),
                        (float)(1 - f), (float)eta, LOBE_TRANSMIT | LOBE_DELTA};
    return cos_t > 0;
}

static bool sample_rough(const ShadingPoint *point, const Interface *face, float lobe, float u,
                         float v, BsdfSample *out)
{
    Vec3 m = ggx_sample_visible(face->facets.ggx, face->wo, (double)u, (double)v), wi;
    double cos_t, f = reflected(face, dot(face->wo, m), &cos_t);
    bool reflects = (double)lobe < f;
    wi = reflects ? normalize(reflect(face->wo, m)) : refract_with(face->wo, m, face->eta, cos_t);
    if (reflects ? !(wi.z > 0) : !(wi.z < 0)) {
        return false;
    }
    BsdfEval e = reflects ? eval_reflection(face, wi)
                          : eval_transmission(face, tint(point, face->params), wi);
    if (!(e.pdf > 0) || !isfinite(e.pdf)) {
        return false;
    }
    *out = (BsdfSample){turned_back(face, wi), rgb_scale(e.value, 1 / e.pdf), e.pdf,
                        reflects ? 1 : (float)face->eta,
                        LOBE_SMOOTH | (uint32_t)(reflects ? LOBE_REFLECT : LOBE_TRANSMIT)};
    return true;
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    Interface face = interface_at(point, params);
    return face.facets.smooth ? sample_smooth(point, &face, lobe, out)
                              : sample_rough(point, &face, lobe, u, v, out);
}

static int deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room)
{
    Interface face = interface_at(point, params);
    int count = 0;
    for (int i = 0; i < 2 && face.facets.smooth; ++i) {
        BsdfSample s; // the largest number chooses transmission, if there is any
        if (sample_smooth(point, &face, i == 0 ? 0 : 0x1.fffffep-1f, &s) &&
            (i == 0) == ((s.lobes & LOBE_REFLECT) != 0) && s.pdf > 0) {
            if (count == room) {
                return -1;
            }
            s.weight = rgb_scale(s.weight, s.pdf);
            s.pdf = 1;
            out[count++] = s;
        }
    }
    return count;
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
         .example = "sphere {\n"
                    "  material: fresnel { ior: 1.52, absorption: rgb(4, 1, 3) }\n"
                    "}"},
    .lobes = lobes,
    .eval = eval,
    .sample = sample,
    .deltas = deltas,
    .albedo = albedo,
    .medium = medium,
};
