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
                 "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                 "environment_light {}\n"
                 "plane { material: lambert { color: gray(0.5) } }\n"
                 "let n = 48\n"
                 "fn at(k) = (0.8 * cos(360deg * k / n), 0.8 * sin(360deg * k / n))\n"
                 "mesh {\n"
                 "  vertices: concat([(0, 0, 0)], [for (k in 0..<n) (at(k).x, at(k).y, 0)])\n"
                 "  colors: concat([gray(1)], [for (k in 0..<n) hsv(360deg * k / n, 1, 1)])\n"
                 "  faces: [for (k in 0..<n) [0, 1 + k, 1 + (k + 1) % n]]\n"
                 "  material: lambert { color: vertex_color {} }, transform: translate(0, 0.8, 0)\n"
                 "}"},
    .color = color,
};
