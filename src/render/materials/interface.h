// An interface between two transparent media, smooth or of microfacets: what `fresnel` is, and what
// a `ggx` becomes as the coat of `layered`.
#ifndef RENDER_MATERIALS_INTERFACE_H
#define RENDER_MATERIALS_INTERFACE_H

#include "render/materials/roughness.h"

// At a point, with the viewer turned to z > 0.
typedef struct Interface {
    Facets facets;
    Vec3 wo;       // in the facets' frame
    double side;   // of the viewer, ±1
    double eta;    // index beyond over index on the viewer's side
    bool schlick;  // in place of the exact Fresnel formula
    bool colored;  // Schlick's approximation from f0, a color
    Rgb f0, tint;  // tint: of what passes
    uint32_t only; // LOBE_REFLECT or LOBE_TRANSMIT: choose that part alone; 0: both
} Interface;

// `ior` behind the surface, `outside` before it. f0 NULL: by the indices. These are filled in
// place, as MATERIAL_EVAL says.
void interface_at(const ShadingPoint *point, const Roughness *roughness, double ior, double outside,
                  bool schlick, const Rgb *f0, Rgb tint, Interface *out);
void interface_eval(const Interface *face, Vec3 wi, BsdfEval *out);
bool interface_sample(const Interface *face, float lobe, float u, float v, BsdfSample *out);
int interface_deltas(const Interface *face, BsdfSample *out, int room);

#endif
