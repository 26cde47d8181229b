#include "render/materials/refracts.h"

#include "render/materials/ggx.h"

extern const MaterialClass fresnel_material, layered_material, mask_material;

typedef bool (*NodeTest)(const NodeType *type, const void *params);

// Is the test true of the material or of one within it? Nodes refer to older ones only, so this
// ends.
static bool any_within(const Scene *scene, uint32_t material, NodeTest test)
{
    if (material >= scene->nodes[CATEGORY_MATERIAL].count) {
        return false;
    }
    const SceneNode *node = scene_node(scene, CATEGORY_MATERIAL, material);
    const NodeType *type = scene_node_type(scene, node);
    const char *params = scene_params(scene, node);
    if (type == &layered_material.node) {
        return false;
    }
    if (test(type, params)) {
        return true;
    }
    for (size_t i = 0; i < type->param_count; ++i) {
        const Param *param = &type->params[i];
        if (param->type == PARAM_NODE && param->category == CATEGORY_MATERIAL) {
            uint32_t inner = *(const uint32_t *)(const void *)(params + param->offset);
            if (inner < material && any_within(scene, inner, test)) {
                return true;
            }
        }
    }
    return false;
}

static bool is_fresnel(const NodeType *type, const void *params)
{
    (void)params;
    return type == &fresnel_material.node;
}

static bool lets_through(const NodeType *type, const void *params)
{
    const GgxParams *ggx = params;
    return type == &fresnel_material.node || type == &mask_material.node ||
           (type == &ggx_material.node && ggx->given != GGX_METAL);
}

bool material_refracts(const Scene *scene, uint32_t material)
{
    return any_within(scene, material, is_fresnel);
}

bool material_coats(const Scene *scene, uint32_t material)
{
    return any_within(scene, material, lets_through);
}
