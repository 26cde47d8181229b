// The registry: every row of nodes.def, as the program's schema and as classes.
#include "render/attenuation.h"
#include "render/integrator.h"
#include "render/light.h"
#include "render/material.h"
#include "render/render.h"
#include "render/shape.h"
#include "render/texture.h"

// What the rows name.
#define SHAPE(id)       extern const ShapeClass id##_shape;
#define MATERIAL(id)    extern const MaterialClass id##_material;
#define TEXTURE(id)     extern const TextureClass id##_texture;
#define LIGHT(id)       extern const LightClass id##_light;
#define ATTENUATION(id) extern const AttenuationClass id##_attenuation;
#define FALLOFF(id)     extern const FalloffClass id##_falloff;
#define KIND(id)        extern const NodeType id##_kind;
#define INTEGRATOR(id)  extern const IntegratorClass id##_integrator;
#include "render/nodes.def"

// The types, in the order of nodes.def. A class begins with its NodeType.
static const NodeType *const node_types[] = {
#define SHAPE(id)       &id##_shape.node,
#define MATERIAL(id)    &id##_material.node,
#define TEXTURE(id)     &id##_texture.node,
#define LIGHT(id)       &id##_light.node,
#define ATTENUATION(id) &id##_attenuation.node,
#define FALLOFF(id)     &id##_falloff.node,
#define KIND(id)        &id##_kind,
#include "render/nodes.def"
};

const IntegratorClass *const integrator_classes[] = {
#define INTEGRATOR(id) &id##_integrator,
#include "render/nodes.def"
    NULL,
};

const Schema *render_schema(void)
{
    static const Schema schema = {node_types, sizeof node_types / sizeof *node_types};
    return &schema;
}

const ShapeClass *shape_class(const Scene *scene, const SceneNode *node)
{
    return (const ShapeClass *)(const void *)scene_node_type(scene, node);
}
