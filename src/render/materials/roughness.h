// The fields that all GGX materials share: roughness and the direction of their tangent frame.
#ifndef RENDER_MATERIALS_ROUGHNESS_H
#define RENDER_MATERIALS_ROUGHNESS_H

#include "base/microfacet.h"
#include "render/material.h"
#include "render/texture.h"

typedef struct Roughness {
    PairTex alpha;
    NumberTex rotation; // radians, from the tangent dp/du to the axis of alpha's first number
} Roughness;

// The same at a point.
typedef struct Facets {
    Ggx ggx;
    bool smooth; // a perfect mirror or window: no facets at all
    double cos_rotation, sin_rotation;
} Facets;

void roughness_at(const ShadingPoint *point, const Roughness *roughness, Facets *out);
// LOBE_SMOOTH, LOBE_DELTA or both, as the surface is rough, polished, or a texture says where.
uint32_t roughness_lobes(const Roughness *roughness);

// To the facets' own tangent frame, and back.
static inline Vec3 facets_from_frame(const Facets *facets, Vec3 w)
{
    double c = facets->cos_rotation, s = facets->sin_rotation;
    return vec3(c * w.x + s * w.y, c * w.y - s * w.x, w.z);
}
static inline Vec3 facets_to_frame(const Facets *facets, Vec3 w)
{
    double c = facets->cos_rotation, s = facets->sin_rotation;
    return vec3(c * w.x - s * w.y, c * w.y + s * w.x, w.z);
}

#endif
