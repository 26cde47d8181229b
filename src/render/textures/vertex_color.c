// The colours that a mesh carries at its vertices.
#include "render/texture.h"

static Rgb color(const TextureSet *set, const void *params, const void *data,
                 const Surface *surface)
{
    (void)set, (void)params, (void)data;
    return surface->color;
}

const TextureClass vertex_color_texture = {
    .node = {.name = "vertex_color",
             .category = CATEGORY_TEXTURE,
             .doc = "The color that a mesh has at its vertices, interpolated over each triangle; "
                    "white on shapes that have none.",
             .example =
                 "mesh { file: \"scan.ply\", material: lambert { color: vertex_color {} } }"},
    .color = color,
};
