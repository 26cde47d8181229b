// The GGX (Trowbridge-Reitz) distribution of microfacets, anisotropic, with Smith's masking.
// Directions are unit, in the frame (tx, ty, n) of the slides' section 3.4; alpha_x and alpha_y
// belong to the tangents x and y.
#ifndef BASE_MICROFACET_H
#define BASE_MICROFACET_H

#include "base/vec.h"

typedef struct Ggx {
    double alpha_x, alpha_y; // > 0, at most 1
} Ggx;

// Below this roughness a surface is treated as smooth: GGX's lobe would be narrower than what the
// sampling numbers' 24 bits tell apart.
#define GGX_ALPHA_MIN 1e-4

// D(m) = 1/(π αx αy ((m·tx/αx)² + (m·ty/αy)² + (m·n)²)²); 0 where m·n < 0.
double ggx_d(Ggx ggx, Vec3 m);
// Λ(w) = (-1 + √(1 + (αx² x² + αy² y²)/z²))/2; infinite for z = 0.
double ggx_lambda(Ggx ggx, Vec3 w);
// 1/(1 + Λ(w)): the part of the facets facing w that w sees.
double ggx_g1(Ggx ggx, Vec3 w);
// Heitz 2014, height-correlated: 1/(1 + Λ(wi) + Λ(wo)); the two χ⁺ are the caller's.
double ggx_g2(Ggx ggx, Vec3 wi, Vec3 wo);
// A microfacet normal seen from wo (wo.z > 0), by numbers in [0, 1): spherical caps after Dupuy and
// Benyoub 2023, which gives the visible normals of Heitz 2018 with less work.
Vec3 ggx_sample_visible(Ggx ggx, Vec3 wo, double u, double v);
// Its density by solid angle: G1(wo) max(0, wo·m) D(m)/wo.z.
double ggx_visible_pdf(Ggx ggx, Vec3 wo, Vec3 m);

#endif
