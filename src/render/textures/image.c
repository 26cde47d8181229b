// A picture from a file, laid over a surface by its texture coordinates.
#include "render/texture.h"
#include "render/texture_image.h"

typedef struct ImageTexture {
    const char *file;
    int32_t encoding, filter, wrap;
    Vec2 scale, offset;
} ImageTexture;

enum { FILE_NAME, ENCODING, FILTER, WRAP, SCALE, OFFSET };

static const char *const ENCODINGS[] = {"auto", "srgb", "linear", NULL};
static const char *const FILTERS[] = {"bilinear", "nearest", NULL};
static const char *const WRAPS[] = {"repeat", "clamp", "mirror", "black", NULL};

static const Param PARAMS[] = {
    [FILE_NAME] = {.name = "file",
                   .type = PARAM_FILE,
                   PARAM_AT(ImageTexture, file),
                   .flags = PARAM_REQUIRED,
                   .doc = "A picture: PNG, JPEG, EXR, HDR, TIFF, WebP, …"},
    [ENCODING] = {.name = "encoding",
                  .type = PARAM_CHOICE,
                  PARAM_AT(ImageTexture, encoding),
                  .choices = ENCODINGS,
                  .default_text = "\"auto\"",
                  .doc =
                      "How the file's numbers mean light. \"auto\": as the file says or its type "
                      "suggests; use \"linear\" for maps that hold numbers, not colors."},
    [FILTER] = {.name = "filter",
                .type = PARAM_CHOICE,
                PARAM_AT(ImageTexture, filter),
                .choices = FILTERS,
                .default_text = "\"bilinear\"",
                .doc = "What lies between texel centres: interpolated, or the nearest texel."},
    [WRAP] = {.name = "wrap",
              .type = PARAM_CHOICE,
              PARAM_AT(ImageTexture, wrap),
              .choices = WRAPS,
              .default_text = "\"repeat\"",
              .doc = "What lies outside the picture."},
    [SCALE] = {.name = "scale",
               .type = PARAM_PAIR,
               PARAM_AT(ImageTexture, scale),
               .default_text = "(1, 1)",
               .doc = "How many copies stand in one unit of u and of v."},
    [OFFSET] = {.name = "offset",
                .type = PARAM_VEC2,
                PARAM_AT(ImageTexture, offset),
                .default_text = "(0, 0)",
                .doc = "Added to (u, v) after the scale."},
};

static bool prepare(const TexturePrepare *prepare, const void *params, const void **data)
{
    const ImageTexture *texture = params;
    *data = texture_set_image(prepare->set, prepare->scene, texture->file, texture->encoding,
                              prepare->sink, prepare->at);
    return *data != NULL;
}

static Rgb color(const TextureSet *set, const void *params, const void *data,
                 const Surface *surface)
{
    (void)set;
    const ImageTexture *texture = params;
    return texture_image_look_up(data, surface->uv.x * texture->scale.x + texture->offset.x,
                                 surface->uv.y * texture->scale.y + texture->offset.y,
                                 (TextureFilter)texture->filter, (TextureWrap)texture->wrap,
                                 (TextureWrap)texture->wrap);
}

static Rgb mean(const TextureSet *set, const void *params, const void *data)
{
    (void)set, (void)params;
    return ((const TextureImage *)data)->mean;
}

const TextureClass image_texture = {
    .node = {.name = "image",
             .category = CATEGORY_TEXTURE,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(ImageTexture),
             .doc =
                 "A picture from a file. Its bottom left corner lies at (u, v) = (0, 0), its top "
                 "right corner at (1, 1). A file that several textures name is read once.",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane {\n"
                        "  material: lambert { color: checker { a: gray(0.6), b: gray(0.35), "
                        "space: \"world\", scale: 2 } }\n"
                        "}\n"
                        "for (i in 0..2) {\n"
                        "  sphere {\n"
                        "    center: (1.05 * (i - 1), 0.5, 0), radius: 0.5\n"
                        "    material: lambert {\n"
                        "      color: image { file: \"textures/tiles.png\", scale: [(1, 1), (4, "
                        "2), (8, 4)][i] }\n"
                        "    }\n"
                        "  }\n"
                        "}"},
    .prepare = prepare,
    .color = color,
    .mean = mean,
};
