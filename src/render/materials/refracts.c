#include "render/materials/refracts.h"

#include "render/material.h"

extern const MaterialClass fresnel_material;

// Nodes refer to older ones only, so this ends.
bool material_refracts(const Scene *scene, uint32_t material)
{
    if (material >= scene->nodes[CATEGORY_MATERIAL].count) {
        return false;
    }
    const SceneNode *node = scene_node(scene, CATEGORY_MATERIAL, material);
    const NodeType *type = scene_node_type(scene, node);
    if (type == &fresnel_material.node) {
        return true;
    }
    const char *params = scene_params(scene, node);
    for (size_t i = 0; i < type->param_count; ++i) {
        const Param *param = &type->params[i];
        if (param->type == PARAM_NODE && param->category == CATEGORY_MATERIAL) {
            uint32_t inner = *(const uint32_t *)(const void *)(params + param->offset);
            if (inner < material && material_refracts(scene, inner)) {
                return true;
            }
        }
    }
    return false;
}
