#ifndef RENDER_MATERIALS_REFRACTS_H
#define RENDER_MATERIALS_REFRACTS_H

#include "scene/scene.h"

// Does the material refract light to its other side: is it, or holds it, a `fresnel`? For checks in
// finish, when there is no world yet.
bool material_refracts(const Scene *scene, uint32_t material);

#endif
