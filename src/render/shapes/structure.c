// `group` and `instance`: shapes to the language, but no geometry of their own. The evaluator
// flattens them into the scene's prototypes and instances.
#include "schema/schema.h"

#include <stddef.h>

typedef struct Group {
    uint32_t unused; // a group has only the fields of every shape, and its items
} Group;

const NodeType group_kind = {
    .name = "group",
    .category = CATEGORY_SHAPE,
    .role = ROLE_GROUP,
    .size = sizeof(Group),
    .doc = "Shapes, lights and other items under one transform. Its material is that of all shapes "
           "inside that have none. Bound to a name, it is a piece that `instance` can place many "
           "times.",
    .example =
        "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: (0, 0, 1.5) }, "
        "radiance: 12 }\n"
        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], space: \"uv\" } }\n"
        "plane { material: lambert { color: gray(0.5) } }\n"
        "let chair = group {\n"
        "  material: lambert { color: #c0704a }\n"
        "  box { min: (-0.25, 0.4, -0.25), max: (0.25, 0.45, 0.25) }\n"
        "  box { min: (-0.25, 0.45, -0.25), max: (0.25, 1, -0.2) }\n"
        "  for (x in [-0.22, 0.22]) {\n"
        "    for (z in [-0.22, 0.22]) {\n"
        "      cylinder { from: (x, 0, z), to: (x, 0.4, z), radius: 0.03 }\n"
        "    }\n"
        "  }\n"
        "}\n"
        "group { transform: [rotate_y(25deg), translate(-0.5, 0, 0)], chair }\n"
        "group { transform: [rotate_y(-60deg), translate(0.6, 0, -0.2)], chair }",
};

typedef struct Instance {
    uint32_t of;
} Instance;

static const Param instance_params[] = {
    {.name = "of",
     .type = PARAM_NODE,
     PARAM_AT(Instance, of),
     .flags = PARAM_REQUIRED,
     .category = CATEGORY_SHAPE,
     .doc = "The shape or group to be placed."},
};

const NodeType instance_kind = {
    .name = "instance",
    .category = CATEGORY_SHAPE,
    .role = ROLE_INSTANCE,
    .params = instance_params,
    .param_count = sizeof instance_params / sizeof *instance_params,
    .size = sizeof(Instance),
    .doc = "A shape or group placed once more. The geometry is shared: a million instances cost a "
           "million transforms. Its material is that of all shapes inside that have none.",
    .example =
        "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: (0, 0, 1.5) }, "
        "radiance: 12 }\n"
        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], space: \"uv\" } }\n"
        "plane { material: lambert { color: gray(0.5) } }\n"
        "let tree = group {\n"
        "  cylinder { from: (0, 0, 0), to: (0, 0.3, 0), radius: 0.04, material: lambert { color: "
        "#6b4a2b } }\n"
        "  for (i in 0..2) {\n"
        "    cone {\n"
        "      from: (0, 0.2 + 0.2 * i, 0)\n"
        "      to: (0, 0.6 + 0.2 * i, 0)\n"
        "      radius_from: 0.25 - 0.06 * i\n"
        "      radius_to: 0\n"
        "      material: lambert { color: #3f6f3f }\n"
        "    }\n"
        "  }\n"
        "}\n"
        "for (i in 0..<40) {\n"
        "  let x = 3 * random(i, 1) - 1.5, let z = 3 - 6 * random(i, 2) - 2\n"
        "  instance { of: tree, transform: [scale(0.6 + 0.5 * random(i)), translate(x, 0, z)] }\n"
        "}",
};
