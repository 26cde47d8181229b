// Normals from a picture.
#include "render/materials/bent.h"
#include "render/world.h"

#include <string.h>

typedef struct NormalMap {
    Bent bent; // first
    ColorTex map;
    NumberTex strength;
} NormalMap;

enum { BASE, MAP, STRENGTH };

static const Param PARAMS[] = {
    [BASE] = {.name = "base",
              .type = PARAM_NODE,
              PARAM_AT(NormalMap, bent.base),
              .category = CATEGORY_MATERIAL,
              .flags = PARAM_REQUIRED,
              .doc = "The material that the normals are for."},
    [MAP] = {.name = "map",
             .type = PARAM_COLOR_TEX,
             PARAM_AT(NormalMap, map),
             .flags = PARAM_REQUIRED,
             .doc =
                 "Normals as colors: red, green, blue from 0 to 1 are -1 to 1 along dp/du, dp/dv "
                 "(green upwards) and the surface's normal. A picture of it is read as "
                 "`encoding: \"linear\"`."},
    [STRENGTH] = {.name = "strength",
                  .type = PARAM_NUMBER_TEX,
                  PARAM_AT(NormalMap, strength),
                  .default_text = "1",
                  .doc = "Multiplies the slope: 0 is flat; negative turns hollows into bumps."},
};

static Vec3 normal(const World *world, const Bent *bent, const Surface *surface)
{
    const NormalMap *map = (const NormalMap *)(const void *)bent;
    Rgb c = color_tex(world->textures, &map->map, surface);
    double strength = (double)number_tex(world->textures, &map->strength, surface);
    Frame frame = texture_frame(surface);
    Vec3 n = vec3(strength * (2 * (double)c.r - 1), strength * (2 * (double)c.g - 1),
                  2 * (double)c.b - 1);
    n.z = fmax(n.z, 1e-3 * (fabs(n.x) + fabs(n.y))); // a map can't turn a surface over
    return from_local(&frame, n);
}

// Is the map a picture of eight bits that would be decoded as a photo?
static bool read_as_photo(const NodeFinish *finish, const NormalMap *map)
{
    if (map->map.texture >= finish->scene->nodes[CATEGORY_TEXTURE].count) {
        return false;
    }
    const SceneNode *node = scene_node(finish->scene, CATEGORY_TEXTURE, map->map.texture);
    const NodeType *type = scene_node_type(finish->scene, node);
    int encoding = node_type_find_param(type, STR("encoding"));
    int file = node_type_find_param(type, STR("file"));
    if (encoding < 0 || file < 0 || type->params[encoding].type != PARAM_CHOICE) {
        return false;
    }
    const char *params = scene_params(finish->scene, node);
    int32_t choice = *(const int32_t *)(const void *)(params + type->params[encoding].offset);
    const char *path = *(const char *const *)(const void *)(params + type->params[file].offset);
    const char *ending = path ? strrchr(path, '.') : NULL;
    bool holds_numbers = ending && (strcmp(ending, ".exr") == 0 || strcmp(ending, ".hdr") == 0);
    return !holds_numbers && strcmp(type->params[encoding].choices[choice], "linear") != 0;
}

static bool finish(NodeFinish *finish)
{
    NormalMap *map = finish->params;
    map->bent.normal = normal;
    if (read_as_photo(finish, map)) {
        finish->report(finish, MAP, W0951,
                       "the normals will be decoded as colors; write `encoding: \"linear\"`");
    }
    return true;
}

MATERIAL_EVAL(bent_eval)

const MaterialClass normal_map_material = {
    .node = {.name = "normal_map",
             .category = CATEGORY_MATERIAL,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(NormalMap),
             .doc =
                 "Gives a material finer normals than its shape has, from a picture. Light never "
                 "leaks through from behind the surface; a normal that turns away from the "
                 "viewer is bent back.",
             .formula = "n ∝ strength (2 r - 1) s + strength (2 g - 1) t + (2 b - 1) n",
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
                        "    material: normal_map {\n"
                        "      map: image { file: \"textures/studs.png\", encoding: \"linear\", "
                        "scale: (8, 4) }\n"
                        "      base: lambert { color: #b06040 }, strength: [0, 0.5, 1][i]\n"
                        "    }\n"
                        "  }\n"
                        "}",
             .finish = finish},
    BENT_FUNCTIONS,
    .caveat =
        "a bent normal shows and hides light that the surface doesn't: energy and reciprocity "
        "hold for its base alone",
};
