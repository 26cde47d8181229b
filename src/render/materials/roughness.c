#include "render/materials/roughness.h"

#include "render/world.h"

Facets roughness_at(const ShadingPoint *point, const Roughness *roughness)
{
    const TextureSet *textures = point->world->textures;
    Vec2 alpha = pair_tex(textures, &roughness->alpha, point->surface);
    Facets facets = {.cos_rotation = 1};
    facets.smooth = !(fmax(alpha.x, alpha.y) >= GGX_ALPHA_MIN);
    facets.ggx.alpha_x = fmin(fmax(alpha.x, GGX_ALPHA_MIN), 1);
    facets.ggx.alpha_y = fmin(fmax(alpha.y, GGX_ALPHA_MIN), 1);
    if (facets.ggx.alpha_x != facets.ggx.alpha_y) {
        double angle = (double)number_tex(textures, &roughness->rotation, point->surface);
        facets.cos_rotation = cos(angle);
        facets.sin_rotation = sin(angle);
    }
    return facets;
}

uint32_t roughness_lobes(const Roughness *roughness)
{
    if (roughness->alpha.texture != NONE_ID) {
        return LOBE_SMOOTH | LOBE_DELTA;
    }
    Vec2 alpha = roughness->alpha.value;
    return fmax(alpha.x, alpha.y) >= GGX_ALPHA_MIN ? LOBE_SMOOTH : LOBE_DELTA;
}
