#include "render/materials/roughness.h"

#include "render/world.h"

void roughness_at(const ShadingPoint *point, const Roughness *roughness, Facets *out)
{
    const TextureSet *textures = point->world->textures;
    const Vec2 alpha = pair_tex(textures, &roughness->alpha, point->surface);
    out->smooth = !(greater(alpha.x, alpha.y) >= GGX_ALPHA_MIN);
    out->ggx.alpha_x = lesser(greater(alpha.x, GGX_ALPHA_MIN), 1);
    out->ggx.alpha_y = lesser(greater(alpha.y, GGX_ALPHA_MIN), 1);
    out->cos_rotation = 1;
    out->sin_rotation = 0;
    if (out->ggx.alpha_x != out->ggx.alpha_y) {
        const double angle = (double)number_tex(textures, &roughness->rotation, point->surface);
        out->cos_rotation = cos(angle);
        out->sin_rotation = sin(angle);
    }
}

uint32_t roughness_lobes(const Roughness *roughness)
{
    if (roughness->alpha.texture != NONE_ID) {
        return LOBE_SMOOTH | LOBE_DELTA;
    }
    Vec2 alpha = roughness->alpha.value;
    return greater(alpha.x, alpha.y) >= GGX_ALPHA_MIN ? LOBE_SMOOTH : LOBE_DELTA;
}
