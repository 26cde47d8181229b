// Light in a coat over a base: the walk between the two, position-free (Guo, Hašan and Zhao 2018,
// "Position-Free Monte Carlo Simulation for Arbitrary Layered BSDFs"; as in pbrt-v4's LayeredBxDF,
// Pharr, Jakob and Humphreys 2023, 14.3).
//
// Both are planes of one normal; between them light falls off by Beer and Lambert's law. The BRDF
// is the expectation of a random walk: an estimate is unbiased but noisy. The walk's random numbers
// are a hash of the place and of the two directions, in which they are symmetric, and so is the lot
// from which end it begins: at one place the same pair of directions always gives the same value,
// and the same when they change places.
#ifndef RENDER_MATERIALS_LAYERS_H
#define RENDER_MATERIALS_LAYERS_H

#include "render/material.h"

// A stack at a point, seen from its coat's side, which the viewer is on. Directions are in
// point.frame, whose z is that side's normal.
typedef struct Layers {
    Surface surface;    // turned to the viewer
    ShadingPoint point; // of that surface; not to be copied
    uint32_t coat, base;
    Rgb depth; // optical thickness along the normal
} Layers;

void layers_at(const ShadingPoint *point, uint32_t coat, uint32_t base, Rgb depth, Layers *out);
// A direction of the shading point's frame in that of the layers, and back: its own inverse.
static inline Vec3 layers_turn(const ShadingPoint *point, Vec3 w)
{
    return point->wo_side > 0 ? w : vec3(w.x, -w.y, -w.z);
}

// The coat, seen from w (w.z > 0: from outside), and the base, seen from w within the coat.
static inline ShadingPoint layers_coat(const Layers *layers, Vec3 w, MaterialLayer part)
{
    ShadingPoint point = layers->point;
    point.wo = w;
    point.wo_side = w.z;
    point.layer = part;
    return point;
}
static inline ShadingPoint layers_base(const Layers *layers, Vec3 w)
{
    return layers_coat(layers, w, LAYER_NONE);
}

// The BRDF for a viewer and a light (both z > 0) without the coat's own reflection and without
// paths that meet delta lobes alone.
Rgb layers_walk(const Layers *layers, Vec3 viewer, Vec3 light);
// The paths that meet delta lobes alone: directions in which they leave, with what goes there. The
// number of them.
int layers_deltas(const Layers *layers, Vec3 viewer, BsdfSample *out, int room);

#endif
