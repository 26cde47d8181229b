#ifndef RENDER_MATERIALS_LAMBERT_H
#define RENDER_MATERIALS_LAMBERT_H

#include "render/world.h"

typedef struct Lambert {
    ColorTex color;
} Lambert;

extern const MaterialClass lambert_material;
// What shapes without a material are made of.
extern const Lambert lambert_default;
// What the shape of an area_light without a material is made of: it emits, and reflects nothing.
extern const Lambert lambert_black;

// --- Inline: most surfaces are matt, and whoever follows many paths spares the calls -------------

static inline Rgb lambert_albedo(const ShadingPoint *point, const Lambert *lambert)
{
    return reflectance_tex(point->world->textures, &lambert->color, point->surface);
}

// MaterialClass.eval, of a surface of that albedo: f = k/π on both sides; pdf = cos/π.
static inline BsdfEval lambert_eval(const ShadingPoint *point, Rgb albedo, Vec3 wi)
{
    if (wi.z * point->wo.z <= 0) {
        return (BsdfEval){{0, 0, 0}, 0};
    }
    const float pdf = (float)(fabs(wi.z) * (1 / PI));
    return (BsdfEval){rgb_scale(albedo, pdf), pdf};
}

// MaterialClass.sample: the lobe's pdf is 0 where it chooses nothing.
static inline BsdfSample lambert_sample(const ShadingPoint *point, Rgb albedo, Vec3 wi)
{
    const float pdf = (float)(wi.z * (1 / PI));
    wi.z = copysign(wi.z, point->wo.z);
    return (BsdfSample){wi, albedo, pdf, 1, LOBE_REFLECT | LOBE_SMOOTH};
}

#endif
