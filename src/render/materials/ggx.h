#ifndef RENDER_MATERIALS_GGX_H
#define RENDER_MATERIALS_GGX_H

#include "render/ggx_energy.h"
#include "render/materials/roughness.h"

typedef struct GgxParams {
    ColorTex f0;
    double ior;
    Rgb eta, k;
    Roughness roughness;
    int32_t fresnel; // GGX_SCHLICK, GGX_EXACT
    int32_t energy;  // GGX_SINGLE, GGX_PRESERVE
    // derived
    int32_t given;      // GGX_F0, …: which fields say how much is reflected
    Rgb normal;         // the reflectance along the normal; GGX_IOR and GGX_METAL
    GgxPairEnergy pair; // of a pair alpha, with energy: "preserve"
    bool has_pair;
    Rgb mean; // the cosine-weighted mean of the Fresnel factor; GGX_IOR and GGX_METAL
} GgxParams;

enum { GGX_SCHLICK, GGX_EXACT };
enum { GGX_SINGLE, GGX_PRESERVE };
enum { GGX_F0, GGX_IOR, GGX_METAL };

extern const MaterialClass ggx_material;

#endif
