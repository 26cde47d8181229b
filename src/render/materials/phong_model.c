#include "render/materials/phong_model.h"

#include "render/world.h"

enum { COLOR, AMBIENT, DIFFUSE, SPECULAR, SPECULAR_COLOR, SHININESS };

const Param phong_params[PHONG_PARAM_COUNT] = {
    [COLOR] = {.name = "color",
               .type = PARAM_COLOR_TEX,
               PARAM_AT(PhongModel, color),
               .min = 0,
               .max = 1,
               .default_text = "gray(0.5)",
               .doc = "The base color C(p): tints the ambient and the diffuse part, never the "
                      "specular one."},
    [AMBIENT] = {.name = "ambient",
                 .type = PARAM_NUMBER_TEX,
                 PARAM_AT(PhongModel, ambient),
                 .min = 0,
                 .max = 1,
                 .default_text = "0",
                 .doc = "k_am: stands for indirect light in the `local` integrator; the others "
                        "trace that light and leave this out."},
    [DIFFUSE] = {.name = "diffuse",
                 .type = PARAM_NUMBER_TEX,
                 PARAM_AT(PhongModel, diffuse),
                 .min = 0,
                 .max = 1,
                 .default_text = "1",
                 .doc = "k_d: the part of the light that is scattered evenly."},
    [SPECULAR] = {.name = "specular",
                  .type = PARAM_NUMBER_TEX,
                  PARAM_AT(PhongModel, specular),
                  .min = 0,
                  .max = 1,
                  .default_text = "0",
                  .doc = "k_s: the part of the light that goes into the highlight."},
    [SPECULAR_COLOR] = {.name = "specular_color",
                        .type = PARAM_COLOR_TEX,
                        PARAM_AT(PhongModel, specular_color),
                        .min = 0,
                        .max = 1,
                        .default_text = "rgb(1, 1, 1)",
                        .doc = "The color of the highlight."},
    [SHININESS] = {.name = "shininess",
                   .type = PARAM_NUMBER_TEX,
                   PARAM_AT(PhongModel, shininess),
                   .min = 0,
                   .max = 1e6,
                   .default_text = "20",
                   .doc = "The exponent e: the greater, the smaller the highlight."},
};

// The model's numbers at a point. Lobes are chosen by luminance.
typedef struct Terms {
    Rgb diffuse, specular; // the parts reflected by each
    double e;
    double diffuse_chance; // 0 where both are black
} Terms;

static Terms terms_at(const ShadingPoint *point, const PhongModel *model)
{
    const TextureSet *textures = point->world->textures;
    const Surface *surface = point->surface;
    Terms t;
    t.diffuse = rgb_scale(reflectance_tex(textures, &model->color, surface),
                          fraction_tex(textures, &model->diffuse, surface));
    t.specular = rgb_scale(reflectance_tex(textures, &model->specular_color, surface),
                           fraction_tex(textures, &model->specular, surface));
    t.e = fmax(0, (double)number_tex(textures, &model->shininess, surface));
    double d = (double)luminance(t.diffuse), s = (double)luminance(t.specular);
    t.diffuse_chance = d + s > 0 ? d / (d + s) : 0;
    return t;
}

bool phong_finish(NodeFinish *finish)
{
    const PhongModel *model = finish->params;
    Rgb c = model->color.value, s = model->specular_color.value;
    if (model->color.texture != NONE_ID || model->specular_color.texture != NONE_ID ||
        model->diffuse.texture != NONE_ID || model->specular.texture != NONE_ID) {
        return true; // not known here
    }
    float sum = rgb_max(rgb_add(rgb_scale(c, (float)model->diffuse.value),
                                rgb_scale(s, (float)model->specular.value)));
    if (sum > 1.0001f) {
        finish->report(finish, finish->set >> SPECULAR & 1 ? SPECULAR : -1, N0950,
                       "diffuse and specular reflection add up to %.3g, more than the light that "
                       "arrives",
                       (double)sum);
    }
    return true;
}

uint32_t phong_lobes(const World *world, const void *params)
{
    (void)world, (void)params;
    return LOBE_REFLECT | LOBE_SMOOTH;
}

static Vec3 to_front(Vec3 w, double side)
{
    return vec3(w.x, w.y, copysign(1, side) * w.z);
}

static BsdfEval eval_terms(const SpecularLobe *lobe, const Terms *t, Vec3 v, Vec3 l)
{
    double specular = lobe->norm(t->e) * pow(lobe->base(v, l), t->e) * l.z;
    double diffuse = l.z / PI;
    Rgb value =
        rgb_add(rgb_scale(t->diffuse, (float)diffuse), rgb_scale(t->specular, (float)specular));
    double pdf = t->diffuse_chance * diffuse;
    if (t->diffuse_chance < 1) {
        pdf += (1 - t->diffuse_chance) * lobe->pdf(t->e, v, l);
    }
    return (BsdfEval){value, (float)pdf};
}

BsdfEval phong_eval(const SpecularLobe *lobe, const ShadingPoint *point, const PhongModel *model,
                    Vec3 wi)
{
    if (wi.z * point->wo.z <= 0) {
        return (BsdfEval){{0, 0, 0}, 0};
    }
    Terms t = terms_at(point, model);
    return eval_terms(lobe, &t, to_front(point->wo, point->wo.z), to_front(wi, point->wo.z));
}

bool phong_sample(const SpecularLobe *lobe, const ShadingPoint *point, const PhongModel *model,
                  float choice, float u, float v, BsdfSample *out)
{
    Terms t = terms_at(point, model);
    Vec3 viewer = to_front(point->wo, point->wo.z), l;
    if ((double)choice < t.diffuse_chance) {
        l = sample_cosine_hemisphere(u, v);
    } else {
        l = lobe->sample(t.e, viewer, (double)u, (double)v);
    }
    if (!(l.z > 0)) {
        return false;
    }
    BsdfEval eval = eval_terms(lobe, &t, viewer, l);
    if (!(eval.pdf > 0)) {
        return false;
    }
    *out = (BsdfSample){to_front(l, point->wo.z), rgb_scale(eval.value, 1 / eval.pdf), eval.pdf, 1,
                        LOBE_REFLECT | LOBE_SMOOTH};
    return true;
}

Rgb phong_albedo(const ShadingPoint *point, const void *params)
{
    Terms t = terms_at(point, params);
    return rgb_add(t.diffuse, t.specular);
}

LocalTerms phong_local(const SpecularLobe *lobe, const ShadingPoint *point, const PhongModel *model,
                       Vec3 l)
{
    const TextureSet *textures = point->world->textures;
    Terms t = terms_at(point, model);
    Vec3 v = to_front(point->wo, point->wo.z);
    l = to_front(l, point->wo.z);
    LocalTerms terms = {0};
    terms.ambient = rgb_scale(reflectance_tex(textures, &model->color, point->surface),
                              fraction_tex(textures, &model->ambient, point->surface));
    if (l.z > 0) { // d_i, and the max(0, n·l)
        terms.diffuse = rgb_scale(t.diffuse, (float)l.z);
        terms.specular = rgb_scale(t.specular, (float)pow(lobe->base(v, l), t.e));
    }
    return terms;
}
