// The slides' shading models as functions of unit vectors (problems 7.1 and 7.3), in double: what
// the language offers to authors. The renderer's materials, which work in a surface's own frame,
// are tested against them. n is the normal, l leads to the light, v to the viewer, wi and wo along
// the incident and the outgoing light; all point away from the surface.
#ifndef BASE_SHADING_MODELS_H
#define BASE_SHADING_MODELS_H

#include "base/microfacet.h"

// Equation (6), slide 40: k d max(0, r·v)^e with r = 2 (l·n) n - l and d = 1 where n·l > 0, else 0.
double phong_model(Vec3 n, Vec3 v, Vec3 l, double e, double k);
// Equation (7), slide 43: k d (n·h)^e, h the unit vector along l + v; 0 where n·h is not above 0.
double blinn_phong_model(Vec3 n, Vec3 v, Vec3 l, double e, double k);
// Equation (9), slide 69: k/π [1 + (f90 - 1)(1 - n·wi)^5] [1 + (f90 - 1)(1 - n·wo)^5] with
// f90 = 1/2 + 2 roughness (wi·h)²; 0 where wi or wo is not above the surface.
double burley_model(Vec3 n, Vec3 wi, Vec3 wo, double roughness, double k);
// Equation (10), slide 79: F D G2/(4 (wi·n)(wo·n)) with Schlick's F (f0 = 1: facets that reflect
// all) and Heitz' height-correlated G2; 0 where wi or wo is not above the surface.
double ggx_model(Vec3 wi, Vec3 wo, Frame frame, Ggx ggx, double f0);

#endif
