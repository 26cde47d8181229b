#include "render/material.h"

#include "render/world.h"

#include <string.h>

// How far above the surface a bent shading normal sees the viewer, as a cosine.
static const double GRAZING = 1e-3;

// The nearest normal that sees the viewer on the side where the surface does.
static Vec3 bend_to_viewer(Vec3 normal, Vec3 geometric, Vec3 wo, double side)
{
    const double target = copysign(GRAZING, side);
    const Vec3 bent = add_scaled(normal, wo, target - dot(wo, normal));
    const double l = length(bent);
    return l > 0 && dot(bent, geometric) > 0 ? scale(bent, 1 / l) : geometric;
}

static void frame_in(const ShadingPoint *point, Vec3 normal, Vec3 tangent, Vec3 wo,
                     ShadingPoint *out)
{
    const Vec3 ng = point->surface->geometric;
    const double side = dot(wo, ng);
    if (side * dot(wo, normal) <= 0 && side != 0) {
        normal = bend_to_viewer(normal, ng, wo, side);
    }
    out->frame = frame_from_tangent(normal, tangent);
    out->wo = to_local(&out->frame, wo);
    out->geometric = to_local(&out->frame, ng);
    out->wo_side = side;
    out->bent = true;
}

void shading_point_bent(const Surface *surface, Vec3 direction, ShadingPoint *out)
{
    const Vec3 tangent = surface->whole ? surface->tangent : vec3(0, 0, 0);
    frame_in(out, surface->shading, tangent, neg(direction), out);
}

void shading_point_bend(const ShadingPoint *point, Vec3 normal, Vec3 tangent, ShadingPoint *out)
{
    Vec3 wo = from_local(&point->frame, point->wo);
    out->world = point->world;
    out->surface = point->surface;
    out->outside = point->outside;
    out->layer = point->layer;
    frame_in(point, normal, tangent, wo, out);
}

// Whether one of the fields is a texture or tells directions on the surface apart, or a material
// that does.
static bool param_needs_whole(const World *world, const Param *param, const void *value)
{
    switch (param->type) {
    case PARAM_NUMBER_TEX:
        return ((const NumberTex *)value)->texture != NONE_ID;
    case PARAM_COLOR_TEX:
        return ((const ColorTex *)value)->texture != NONE_ID;
    case PARAM_PAIR_TEX: {
        const PairTex *pair = value;
        return pair->texture != NONE_ID || pair->value.x != pair->value.y;
    }
    case PARAM_EMISSION:
        return ((const Emission *)value)->texture != NONE_ID;
    case PARAM_NODE: {
        uint32_t id;
        memcpy(&id, value, sizeof id);
        return id != NONE_ID &&
               (param->category == CATEGORY_TEXTURE ||
                (param->category == CATEGORY_MATERIAL && material_needs_whole(world, id)));
    }
    default:
        return false;
    }
}

bool material_needs_whole(const World *world, uint32_t id)
{
    const WorldMaterial *m = world_material(world, id);
    const NodeType *type = &m->class->node;
    if (m->class->whole) {
        return true;
    }
    for (size_t i = 0; i < type->param_count; ++i) {
        const Param *param = &type->params[i];
        if (param_needs_whole(world, param, (const char *)m->params + param->offset)) {
            return true;
        }
    }
    return false;
}

uint32_t material_lobes(const World *world, uint32_t id)
{
    const WorldMaterial *m = world_material(world, id);
    return m->class->lobes(world, m->params);
}

// Do the shading and the geometric normal agree whether wi is on wo's side?
static bool sides_agree(const ShadingPoint *point, Vec3 wi)
{
    if (!point->bent) {
        return true;
    }
    bool shading = wi.z * point->wo.z > 0;
    bool geometric = dot(wi, point->geometric) * point->wo_side > 0;
    return shading == geometric;
}

BsdfEval material_eval(const ShadingPoint *point, uint32_t id, Vec3 wi)
{
    BsdfEval out;
    material_evaluate(point, world_material(point->world, id), wi, &out);
    return out;
}

void material_evaluate(const ShadingPoint *point, const WorldMaterial *m, Vec3 wi, BsdfEval *out)
{
    if (wi.z == 0 || point->wo.z == 0 || !sides_agree(point, wi)) {
        *out = (BsdfEval){{0, 0, 0}, 0};
        return;
    }
    m->class->eval(point, m->params, wi, out);
}

bool material_sample(const ShadingPoint *point, uint32_t id, float lobe, float u, float v,
                     BsdfSample *out)
{
    return material_choose(point, world_material(point->world, id), lobe, u, v, out);
}

bool material_choose(const ShadingPoint *point, const WorldMaterial *m, float lobe, float u,
                     float v, BsdfSample *out)
{
    if (point->wo.z == 0 || !m->class->sample(point, m->params, lobe, u, v, out)) {
        return false;
    }
    return (out->lobes & LOBE_PASS) || sides_agree(point, out->wi);
}

int material_deltas(const ShadingPoint *point, uint32_t id, BsdfSample *out, int room)
{
    const WorldMaterial *m = world_material(point->world, id);
    if (!(m->lobes & LOBE_DELTA) || point->wo.z == 0) {
        return 0;
    }
    if (!m->class->deltas) {
        return -1;
    }
    int found = m->class->deltas(point, m->params, out, room), kept = 0;
    for (int i = 0; i < found; ++i) {
        if (sides_agree(point, out[i].wi)) {
            out[kept++] = out[i];
        }
    }
    return found < 0 ? found : kept;
}

Rgb material_albedo(const ShadingPoint *point, uint32_t id)
{
    const WorldMaterial *m = world_material(point->world, id);
    return m->class->albedo(point, m->params);
}

Rgb material_emitted(const World *world, uint32_t id, const Surface *surface)
{
    const WorldMaterial *m = world_material(world, id);
    return m->class->emitted ? m->class->emitted(world, m->params, surface) : rgb_gray(0);
}

Rgb material_emitted_mean(const World *world, uint32_t id)
{
    const WorldMaterial *m = world_material(world, id);
    return m->class->emitted_mean ? m->class->emitted_mean(world, m->params) : rgb_gray(0);
}

Rgb material_pass(const World *world, uint32_t id, const Surface *surface)
{
    const WorldMaterial *m = world_material(world, id);
    return m->class->pass ? m->class->pass(world, m->params, surface) : rgb_gray(0);
}

bool material_medium(const World *world, uint32_t id, Medium *out)
{
    const WorldMaterial *m = world_material(world, id);
    return m->class->medium && m->class->medium(world, m->params, out);
}

LocalTerms material_local(const ShadingPoint *point, uint32_t id, Vec3 l)
{
    const WorldMaterial *m = world_material(point->world, id);
    if (m->class->local) {
        return m->class->local(point, m->params, l);
    }
    Rgb value = material_eval(point, id, l).value;
    return (LocalTerms){.specular = rgb_scale(value, (float)PI)};
}
