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
    .example = "group {\n  transform: translate(0, 1, 0)\n  sphere {}\n  box { size: (3, 0.1, 3) "
               "}\n}",
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
        "let tree = group { cylinder { from: (0, 0, 0), to: (0, 1, 0), radius: 0.1 } sphere { "
        "center: (0, 1.5, 0), radius: 0.7 } }\n"
        "for (i in 0..<10) { instance { of: tree, transform: translate(2 * i, 0, 0) } }",
};
