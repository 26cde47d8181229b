#include "render/material_report.h"

#include "render/materials/refracts.h"
#include "render/shape.h"

static bool any_refracts(const Scene *scene)
{
    bool any = false;
    for (uint32_t id = 0; !any && id < scene->nodes[CATEGORY_MATERIAL].count; ++id) {
        any = material_refracts(scene, id);
    }
    return any;
}

void material_warn_open_glass(const Scene *scene, DiagSink *sink)
{
    if (!any_refracts(scene)) {
        return;
    }
    for (uint32_t id = 0; id < scene->nodes[CATEGORY_SHAPE].count; ++id) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, id);
        const ShapeClass *class = shape_class(scene, node);
        bool may_be_closed = class->holding == HOLD_UNBOUNDED || class->holding == HOLD_TRIANGLES ||
                             class->closed(scene_params(scene, node));
        if (!may_be_closed && material_refracts(scene, node->material)) {
            diag_report(sink, W0950, node->at,
                        "light that is refracted by this `%s` never gets out of it",
                        class->node.name);
        }
    }
}
