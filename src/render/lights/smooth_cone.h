#ifndef RENDER_LIGHTS_SMOOTH_CONE_H
#define RENDER_LIGHTS_SMOOTH_CONE_H

#include "render/attenuation.h"

typedef struct SmoothCone {
    double inner, outer; // rad, 0 < inner < outer <= π/2
} SmoothCone;

extern const FalloffClass smooth_cone_falloff;

#endif
