#ifndef RENDER_LIGHTS_AREA_LIGHT_H
#define RENDER_LIGHTS_AREA_LIGHT_H

#include "render/light.h"

typedef struct AreaLight {
    uint32_t shape;
    Emission radiance; // one of them
    Quantity power;
    bool two_sided;
    bool by_power; // derived
    Rgb strength;  // derived: radiance before the texture, W/m²/sr, or flux, W
} AreaLight;

extern const LightClass area_light_light;
// Shapes with an emitting material: the same but for where the radiance comes from.
extern const LightClass emissive_shape_light;

#endif
