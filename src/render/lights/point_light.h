#ifndef RENDER_LIGHTS_POINT_LIGHT_H
#define RENDER_LIGHTS_POINT_LIGHT_H

#include "render/light.h"

typedef struct PointLight {
    Vec3 position;
    Quantity intensity, power; // one of them
    uint32_t attenuation;
    Rgb radiant_intensity; // derived: W/sr
} PointLight;

extern const LightClass point_light_light;

#endif
