#include "render/materials/interface.h"

#include "base/fresnel.h"

static Vec3 turned(const Interface *face, Vec3 w)
{
    return facets_from_frame(&face->facets, vec3(w.x, w.y, face->side * w.z));
}
static Vec3 turned_back(const Interface *face, Vec3 w)
{
    w = facets_to_frame(&face->facets, w);
    return vec3(w.x, w.y, face->side * w.z);
}

void interface_at(const ShadingPoint *point, const Roughness *roughness, double ior, double outside,
                  bool schlick, const Rgb *f0, Rgb tint, Interface *out)
{
    roughness_at(point, roughness, &out->facets);
    out->side = copysign(1, point->wo.z);
    out->wo = turned(out, point->wo);
    out->eta = point->wo_side > 0 ? ior / outside : outside / ior;
    out->schlick = schlick;
    out->colored = f0 != NULL;
    out->f0 = f0 ? *f0 : rgb_gray(0);
    out->tint = tint;
    out->only = point->layer == LAYER_REFLECT    ? LOBE_REFLECT
                : point->layer == LAYER_TRANSMIT ? LOBE_TRANSMIT
                                                 : 0;
    if (fabs(out->eta - 1) < 1e-6) {
        out->facets.smooth = true; // facets between equal media do nothing
    }
}

// The reflectance for red, green and blue. In double, since what passes is 1 minus it.
static Vec3 reflectance(const Interface *face, double cos_i, double *cos_t)
{
    if (!face->colored) {
        double f = face->schlick ? fresnel_dielectric_schlick(cos_i, face->eta, cos_t)
                                 : fresnel_dielectric(cos_i, face->eta, cos_t);
        return vec3(f, f, f);
    }
    double ct, c; // as fresnel_dielectric_schlick, with its own f0 for each channel
    if (fresnel_dielectric(cos_i, face->eta, &ct) == 1) {
        c = 0; // total internal reflection
    } else {
        c = face->eta < 1 ? ct : cos_i;
    }
    if (cos_t) {
        *cos_t = ct;
    }
    return vec3(fresnel_schlick((double)face->f0.r, c), fresnel_schlick((double)face->f0.g, c),
                fresnel_schlick((double)face->f0.b, c));
}

static Rgb scaled(Vec3 f, double s)
{
    return rgb((float)(f.x * s), (float)(f.y * s), (float)(f.z * s));
}

static Rgb passed(const Interface *face, Vec3 f, double s)
{
    return rgb_mul(scaled(sub(vec3(1, 1, 1), f), s), face->tint);
}

// With which chance reflection is chosen where so much is reflected.
static double reflect_chance(const Interface *face, Vec3 f)
{
    if (face->only) {
        return face->only == LOBE_REFLECT ? 1 : 0;
    }
    return face->colored ? lesser((double)luminance(scaled(f, 1)), 1) : f.x;
}

// Reflection by facets, as in ggx; `m` is the normal of those that do it, f their reflectance.
static void facets_reflect(const Interface *face, Vec3 wi, Vec3 m, Vec3 f, BsdfEval *out)
{
    const Ggx ggx = face->facets.ggx;
    const double common = ggx_d(ggx, m) / (4 * face->wo.z);
    out->value = scaled(f, common * ggx_g2(ggx, wi, face->wo));
    out->pdf = (float)(reflect_chance(face, f) * common * ggx_g1(ggx, face->wo));
}

// Walter et al. 2007, equation 21, with their separable G; the facet that refracts wi to wo has its
// normal along wo + eta wi.
static void facets_refract(const Interface *face, Vec3 wi, Vec3 m, Vec3 f, BsdfEval *out)
{
    const Ggx ggx = face->facets.ggx;
    const Vec3 wo = face->wo;
    const double o = dot(wo, m), i = dot(wi, m), root = face->eta * i + o;
    const double common = ggx_d(ggx, m) * ggx_g1(ggx, wo) * o * -i / (wo.z * root * root);
    out->value = passed(face, f, common * ggx_g1(ggx, wi));
    out->pdf = (float)((1 - reflect_chance(face, f)) * common * face->eta * face->eta);
}

static void eval_transmission(const Interface *face, Vec3 wi, BsdfEval *out)
{
    Vec3 m = add_scaled(face->wo, wi, face->eta);
    const double l = length(m);
    m = scale(m, copysign(1, m.z) / l);
    const double o = dot(face->wo, m), i = dot(wi, m);
    if (l > 0 && o > 0 && i < 0) {
        facets_refract(face, wi, m, reflectance(face, o, NULL), out);
    }
}

void interface_eval(const Interface *face, Vec3 wi, BsdfEval *out)
{
    out->value = rgb_gray(0);
    out->pdf = 0;
    if (face->facets.smooth) {
        return;
    }
    wi = turned(face, wi);
    if (wi.z > 0) {
        const Vec3 m = normalize(add(wi, face->wo));
        facets_reflect(face, wi, m, reflectance(face, dot(face->wo, m), NULL), out);
    } else {
        eval_transmission(face, wi, out);
    }
}

// The two directions of a smooth interface, their weight the part of the light that takes them.
// Radiance that leaves a medium of index eta for one of index 1 spreads: by 1/eta² (slides, section
// 3.2).
static BsdfSample smooth_reflection(const Interface *face, Vec3 f)
{
    Vec3 wo = face->wo;
    return (BsdfSample){turned_back(face, vec3(-wo.x, -wo.y, wo.z)), scaled(f, 1), 1, 1,
                        LOBE_REFLECT | LOBE_DELTA};
}
static BsdfSample smooth_transmission(const Interface *face, Vec3 f, double cos_t)
{
    Vec3 wo = face->wo;
    double r = 1 / face->eta;
    Vec3 wt = normalize(vec3(-wo.x * r, -wo.y * r, -cos_t));
    return (BsdfSample){turned_back(face, wt), passed(face, f, r * r), 1, (float)face->eta,
                        LOBE_TRANSMIT | LOBE_DELTA};
}

static bool sample_smooth(const Interface *face, float lobe, BsdfSample *out)
{
    double cos_t;
    Vec3 f = reflectance(face, face->wo.z, &cos_t);
    double chance = reflect_chance(face, f);
    bool reflects = (double)lobe < chance;
    if (!reflects && !(cos_t > 0)) {
        return false;
    }
    chance = reflects ? chance : 1 - chance;
    *out = reflects ? smooth_reflection(face, f) : smooth_transmission(face, f, cos_t);
    out->pdf = (float)chance;
    out->weight = rgb_scale(out->weight, (float)(1 / chance));
    return true;
}

static bool sample_rough(const Interface *face, float lobe, float u, float v, BsdfSample *out)
{
    Vec3 m = ggx_sample_visible(face->facets.ggx, face->wo, (double)u, (double)v), wi;
    double cos_t;
    Vec3 f = reflectance(face, dot(face->wo, m), &cos_t);
    bool reflects = (double)lobe < reflect_chance(face, f);
    wi = reflects ? normalize(reflect(face->wo, m)) : refract_with(face->wo, m, face->eta, cos_t);
    if (reflects ? !(wi.z > 0) : !(wi.z < 0)) {
        return false;
    }
    BsdfEval e;
    (reflects ? facets_reflect : facets_refract)(face, wi, m, f, &e);
    if (!(e.pdf > 0) || !isfinite(e.pdf)) {
        return false;
    }
    *out = (BsdfSample){turned_back(face, wi), rgb_scale(e.value, 1 / e.pdf), e.pdf,
                        reflects ? 1 : (float)face->eta,
                        LOBE_SMOOTH | (uint32_t)(reflects ? LOBE_REFLECT : LOBE_TRANSMIT)};
    return true;
}

bool interface_sample(const Interface *face, float lobe, float u, float v, BsdfSample *out)
{
    return face->facets.smooth ? sample_smooth(face, lobe, out)
                               : sample_rough(face, lobe, u, v, out);
}

int interface_deltas(const Interface *face, BsdfSample *out, int room)
{
    if (!face->facets.smooth) {
        return 0;
    }
    double cos_t;
    Vec3 f = reflectance(face, face->wo.z, &cos_t);
    bool reflects = max_component(f) > 0, passes = cos_t > 0;
    if (reflects + passes > room) {
        return -1;
    }
    if (reflects) {
        *out++ = smooth_reflection(face, f);
    }
    if (passes) {
        *out = smooth_transmission(face, f, cos_t);
    }
    return reflects + passes;
}
