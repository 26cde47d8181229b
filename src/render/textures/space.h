// Where a pattern lies: the field `space` of textures that are functions of a point.
#ifndef RENDER_TEXTURES_SPACE_H
#define RENDER_TEXTURES_SPACE_H

#include "render/texture.h"

typedef enum TextureSpace { SPACE_UV, SPACE_OBJECT, SPACE_WORLD } TextureSpace;
// The choices of such a field, in the order of the enum.
extern const char *const texture_spaces[];

// The surface's point there; (u, v, 0) for texture coordinates.
static inline Vec3 texture_point(int32_t space, const Surface *surface)
{
    switch ((TextureSpace)space) {
    case SPACE_UV:
        return vec3(surface->uv.x, surface->uv.y, 0);
    case SPACE_WORLD:
        return surface->p;
    case SPACE_OBJECT:
    default:
        return surface->object_p;
    }
}

#endif
