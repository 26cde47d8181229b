// What `phong` and `blinn_phong` share: a diffuse part of the base colour plus a specular lobe that
// the base colour does not tint.
#ifndef RENDER_MATERIALS_PHONG_MODEL_H
#define RENDER_MATERIALS_PHONG_MODEL_H

#include "render/material.h"
#include "render/texture.h"

typedef struct PhongModel {
    ColorTex color, specular_color;
    NumberTex ambient, diffuse, specular, shininess;
} PhongModel;

enum { PHONG_PARAM_COUNT = 6 };
extern const Param phong_params[PHONG_PARAM_COUNT];

// A lobe of exponent e. Directions lie on the front side (z > 0).
typedef struct SpecularLobe {
    // The lobe's base: r·v or n·h, not negative. The slides' raw expression is its power e.
    double (*base)(Vec3 v, Vec3 l);
    // The factor that makes of the power a BRDF which reflects all light at normal incidence.
    double (*norm)(double e);
    // Chooses l by two numbers in [0, 1); it may lie below the surface.
    Vec3 (*sample)(double e, Vec3 v, double u1, double u2);
    // The density of that by solid angle.
    double (*pdf)(double e, Vec3 v, Vec3 l);
} SpecularLobe;

bool phong_finish(NodeFinish *finish);
uint32_t phong_lobes(const struct World *world, const void *params);
BsdfEval phong_eval(const SpecularLobe *lobe, const ShadingPoint *point, const PhongModel *model,
                    Vec3 wi);
bool phong_sample(const SpecularLobe *lobe, const ShadingPoint *point, const PhongModel *model,
                  float choice, float u, float v, BsdfSample *out);
Rgb phong_albedo(const ShadingPoint *point, const void *params);
LocalTerms phong_local(const SpecularLobe *lobe, const ShadingPoint *point, const PhongModel *model,
                       Vec3 l);

#endif
