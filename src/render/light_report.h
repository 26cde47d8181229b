// What a light gives, in figures: for the ledger of lights and for notes about their laws.
#ifndef RENDER_LIGHT_REPORT_H
#define RENDER_LIGHT_REPORT_H

#include "render/world.h"

// The flux, as its luminance in W (times 683: lm). INFINITY where it has no end: at infinity, on an
// infinite shape.
double light_flux(const Light *light);
// The irradiance at `p`, were nothing in between, of a surface turned to face the light, as its
// luminance in W/m² (times 683: lx). Exact for small and for parallel lights, else to about 0.1 %;
// NAN where the light can't be sampled. Surroundings that are as bright on all sides are faced
// upwards.
double light_irradiance(const World *world, const Light *light, Vec3 p);
// Is the light's law of distance the natural one?
bool light_is_natural(const Scene *scene, const Light *light);
// Reports a note (N0901) on each light of the scene whose law of distance is not.
void light_note_laws(const Scene *scene, DiagSink *sink);
// Reports a warning (W0902) on each light with a position that lies inside a closed opaque shape,
// where it lights nothing. Shapes of instances are not looked at, and no more than 2^25 pairs of a
// light and a shape. For `threads`.
void light_warn_enclosed(const Scene *scene, unsigned threads, DiagSink *sink);

#endif
