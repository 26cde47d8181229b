#ifndef RENDER_LIGHTS_ENVIRONMENT_LIGHT_H
#define RENDER_LIGHTS_ENVIRONMENT_LIGHT_H

#include "render/light.h"

extern const LightClass environment_light_light;

#endif
