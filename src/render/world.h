// A scene made ready for rendering: accelerator, materials, lights with their choice, textures,
// settings.
#ifndef RENDER_WORLD_H
#define RENDER_WORLD_H

#include "base/diag.h"
#include "render/accel.h"
#include "render/camera.h"
#include "render/guide.h"
#include "render/light.h"
#include "render/material.h"
#include "render/texture.h"
#include "scene/scene.h"

enum { SAMPLING_MIS, SAMPLING_LIGHT, SAMPLING_BSDF };      // RenderParams.sampling
enum { CAUSTICS_PLAIN, CAUSTICS_GUIDED, CAUSTICS_TRACED }; // RenderParams.caustics

typedef struct World {
    const Scene *scene;
    Accel *accel;
    LightSet *lights;
    const Light *light_items; // all of them, by index
    uint32_t only_light;      // the one that light_choose chooses everywhere, or NONE_ID
    const Guide
        *guide; // to light by way of mirrors and glass; NULL: none is asked for, or none found
    // By light: whether its caustics are found by photons (photons.h), and are to be left out of
    // paths. NULL: no light's are. Set by who traces photons.
    const bool *photon_lights;
    TextureSet *textures;
    const WorldMaterial *materials; // material_count + 1; the last is the default
    uint32_t material_count;
    uint32_t all_lobes;       // union over the materials in the scene
    bool shape_lights;        // some light is a shape
    bool media;               // some material has a medium
    MediumStack camera_media; // the transparent bodies that the camera stands in
    Arena arena;              // of materials and lights
    // from `render { … }`
    int64_t bounces;
    int32_t sampling;
    bool shadows, russian_roulette;
    float clamp;        // 0: none
    double ao_distance; // INFINITY: any
    // For the view of depths: the camera (NULL: none), and between which depths the scene's bounded
    // shapes lie; far is infinite where there are none.
    const Camera *camera;
    double near, far;
} World;

// The material `id` (NONE_ID: the default; MATERIAL_BLACK: what reflects nothing).
static inline const WorldMaterial *world_material(const World *world, uint32_t id)
{
    if (id < world->material_count) {
        return &world->materials[id];
    }
    return &world->materials[world->material_count + (id == MATERIAL_BLACK)];
}

// Makes a scene ready, with `threads` threads (0: all). The scene must not change while the world
// lives. NULL after a report to `sink`: a texture that can't be read, no memory, …
World *world_build(const Scene *scene, unsigned threads, DiagSink *sink);
void world_free(World *world);
// A part of world_build: fills `materials` of a world of which only `scene` is set, for questions
// that need no rays; world_free gives it back. False when memory runs out.
bool world_resolve_materials(World *world);
// Sets camera, camera_media, near and far; the camera must live until another is set, or the world
// ends.
void world_set_camera(World *world, const Camera *camera);

// Half the diagonal of the box of all bounded shapes; 1 where there are none.
double world_radius(const World *world);

// The part of light that passes along `ray` (1: unoccluded, 0: blocked), cut-outs counted.
Rgb world_visibility(const World *world, const Ray *ray);

#endif
