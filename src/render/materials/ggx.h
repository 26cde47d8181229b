#ifndef RENDER_MATERIALS_GGX_H
#define RENDER_MATERIALS_GGX_H

#include "render/ggx_energy.h"
#include "render/materials/roughness.h"

// How a facet reflects, where indices of refraction say so.
typedef struct GgxFacet {
    double ior; // GGX_IOR
    Rgb eta, k; // GGX_METAL
    Rgb normal; // the reflectance along the normal
    Rgb mean;   // the cosine-weighted mean of the Fresnel factor
} GgxFacet;

typedef struct GgxParams {
    ColorTex f0;
    NumberTex ior;
    ColorTex eta, k;
    Roughness roughness;
    int32_t fresnel; // GGX_SCHLICK, GGX_EXACT
    int32_t energy;  // GGX_SINGLE, GGX_PRESERVE
    // derived
    int32_t given;      // GGX_F0, …: which fields say how much is reflected
    bool varies;        // GGX_IOR and GGX_METAL: textures say how much
    GgxFacet facet;     // GGX_IOR and GGX_METAL, unless it varies
    GgxPairEnergy pair; // of a pair alpha, with energy: "preserve"
    bool has_pair;
} GgxParams;

enum { GGX_SCHLICK, GGX_EXACT };
enum { GGX_SINGLE, GGX_PRESERVE };
enum { GGX_F0, GGX_IOR, GGX_METAL };

extern const MaterialClass ggx_material;

#endif
