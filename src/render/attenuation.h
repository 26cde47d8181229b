// How the light of a small source falls off with distance, and with the angle from its axis: one
// file a kind in lights/, a row ATTENUATION(id) or FALLOFF(id) in nodes.def.
#ifndef RENDER_ATTENUATION_H
#define RENDER_ATTENUATION_H

#include "scene/scene.h"

typedef struct AttenuationClass {
    NodeType node; // first
    // Does it follow the inverse-square law? NULL: no.
    bool (*natural)(const void *params);
    // Irradiance over intensity at distance r > 0 in metres: 1/r² for the natural law.
    double (*factor)(const void *params, double r);
} AttenuationClass;

typedef struct FalloffClass {
    NodeType node; // first
    // Intensity over that on the axis, at an angle from the axis given by its cosine.
    double (*factor)(const void *params, double cos_angle);
    // The integral of `factor` over the sphere of directions, sr: flux over the axis' intensity.
    double (*integral)(const void *params);
    // The angle from the axis, rad, beyond which `factor` is 0.
    double (*reach)(const void *params);
} FalloffClass;

// The factor of an attenuation node; NONE_ID is the inverse square.
double attenuation_factor(const Scene *scene, uint32_t attenuation, double r);
bool attenuation_is_natural(const Scene *scene, uint32_t attenuation);
// The functions of a falloff node; NONE_ID is the default smooth_cone of 25 and 30 degrees.
double falloff_factor(const Scene *scene, uint32_t falloff, double cos_angle);
double falloff_integral(const Scene *scene, uint32_t falloff);
double falloff_reach(const Scene *scene, uint32_t falloff);

#endif
