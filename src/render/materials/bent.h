// What normal_map and bump_map share: a base material seen in a shading frame of their making.
//
// Light leaks: a direction that lies on different sides of the surface by its geometry and by the
// bent normal is neither reflected nor transmitted (material.h), so that no light comes through
// from behind; and a bent normal that would turn away from the viewer is bent back until it just
// faces it (shading_point_bend), so that no black specks appear. Energy is lost by the first, never
// made.
#ifndef RENDER_MATERIALS_BENT_H
#define RENDER_MATERIALS_BENT_H

#include "render/material.h"
#include "render/texture.h"

// The part of the parameters that the functions below read; first in the kinds' structs.
typedef struct Bent {
    uint32_t base;
    // The new shading normal at a point: in the world, not of unit length, n·shading > 0.
    Vec3 (*normal)(const struct World *world, const struct Bent *bent, const Surface *surface);
} Bent;

// The frame of texture coordinates: s along dp/du and t along dp/dv as near as can be, n the
// shading normal; t = ±n × s, as the coordinates are turned. World.
Frame texture_frame(const Surface *surface);

uint32_t bent_lobes(const struct World *world, const void *params);
BsdfEval bent_eval(const ShadingPoint *point, const void *params, Vec3 wi);
bool bent_sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                 BsdfSample *out);
int bent_deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room);
Rgb bent_albedo(const ShadingPoint *point, const void *params);
Rgb bent_emitted(const struct World *world, const void *params, const Surface *surface);
Rgb bent_emitted_mean(const struct World *world, const void *params);
Rgb bent_pass(const struct World *world, const void *params, const Surface *surface);
bool bent_medium(const struct World *world, const void *params, Medium *out);
LocalTerms bent_local(const ShadingPoint *point, const void *params, Vec3 l);

#define BENT_FUNCTIONS                                                                             \
    .whole = true, .lobes = bent_lobes, .eval = bent_eval_into, .sample = bent_sample,             \
    .deltas = bent_deltas, .albedo = bent_albedo, .emitted = bent_emitted,                         \
    .emitted_mean = bent_emitted_mean, .pass = bent_pass, .medium = bent_medium,                   \
    .local = bent_local

#endif
