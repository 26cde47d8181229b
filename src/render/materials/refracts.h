// What materials are made of, for checks in finish, when there is no world yet.
#ifndef RENDER_MATERIALS_REFRACTS_H
#define RENDER_MATERIALS_REFRACTS_H

#include "scene/scene.h"

// Does the material refract light to its other side: is it, or holds it, a `fresnel`? A `layered`
// keeps what passes its coat.
bool material_refracts(const Scene *scene, uint32_t material);
// Lets it light through to a base below, as the coat of `layered`?
bool material_coats(const Scene *scene, uint32_t material);

#endif
