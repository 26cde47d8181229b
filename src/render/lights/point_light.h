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

// The intensity of a small source that was given as such or by its power, whichever of the two
// fields was set; `steradians` is power over intensity. False after a report.
bool point_intensity(NodeFinish *finish, int intensity_field, int power_field, Quantity intensity,
                     Quantity power, double steradians, Rgb *out);

#endif
