// Squares or cubes of two colours.
#include "render/textures/space.h"

typedef struct Checker {
    ColorTex a, b;
    Vec2 scale;
    int32_t space;
} Checker;

const char *const texture_spaces[] = {"uv", "object", "world", NULL};

// Coordinates are moved by this part of a cell, so that a face that lies on a boundary of cells has
// one colour although its points are rounded to either side.
static const double BOUNDARY_SHIFT = 1e-6;

static const Param PARAMS[] = {
    {.name = "a",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(Checker, a),
     .default_text = "gray(0.8)",
     .doc = "The color of the cell at the origin, and of every second one."},
    {.name = "b",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(Checker, b),
     .default_text = "gray(0.2)",
     .doc = "The color of the others."},
    {.name = "scale",
     .type = PARAM_PAIR,
     PARAM_AT(Checker, scale),
     .default_text = "1",
     .doc = "Cells in one unit of u and of v; in space the first number counts along all axes."},
    {.name = "space",
     .type = PARAM_CHOICE,
     PARAM_AT(Checker, space),
     .choices = texture_spaces,
     .default_text = "\"uv\"",
     .doc = "Squares in texture coordinates, or cubes in the shape's own space or in the world."},
};

static double cell(double x)
{
    return floor(x + BOUNDARY_SHIFT);
}

static Rgb color(const TextureSet *set, const void *params, const void *data,
                 const Surface *surface)
{
    (void)data;
    const Checker *checker = params;
    double sum;
    if (checker->space == SPACE_UV) {
        sum = cell(surface->uv.x * checker->scale.x) + cell(surface->uv.y * checker->scale.y);
    } else {
        const Vec3 p = scale(texture_point(checker->space, surface), checker->scale.x);
        sum = cell(p.x) + cell(p.y) + cell(p.z);
    }
    bool even = sum - 2 * floor(sum / 2) == 0;
    return color_tex(set, even ? &checker->a : &checker->b, surface);
}

static Rgb mean(const TextureSet *set, const void *params, const void *data)
{
    (void)data;
    const Checker *checker = params;
    return rgb_scale(rgb_add(color_tex_mean(set, &checker->a), color_tex_mean(set, &checker->b)),
                     0.5f);
}

const TextureClass checker_texture = {
    .node = {.name = "checker",
             .category = CATEGORY_TEXTURE,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(Checker),
             .doc = "A checkerboard of two colors or textures.",
             .formula = "a where floor(scale u) + floor(scale v) is even, else b",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "for (i in 0..2) {\n"
                        "  sphere {\n"
                        "    center: (1.05 * (i - 1), 0.5, 0), radius: 0.5\n"
                        "    material: lambert {\n"
                        "      color: checker { a: #e8e0d0, b: #803028, scale: [(8, 4), (16, 8), "
                        "(6, 1)][i] }\n"
                        "    }\n"
                        "  }\n"
                        "}"},
    .color = color,
    .mean = mean,
};
