// A scene made ready for rendering: accelerator, lights with their choice, textures, settings.
#ifndef RENDER_WORLD_H
#define RENDER_WORLD_H

#include "render/accel.h"
#include "scene/scene.h"

struct LightSet;   // light.h
struct TextureSet; // texture.h

typedef struct World {
    const Scene *scene;
    Accel *accel;
    struct LightSet *lights;
    struct TextureSet *textures;
    // from `render { … }`
    int64_t bounces;
    int32_t sampling; // "mis", "light", "bsdf" in this order
    bool shadows, russian_roulette;
    float clamp;
} World;

#endif
