#include "render/light_report.h"

#include "render/attenuation.h"

double light_flux(const Light *light)
{
    bool endless =
        light->class->infinite || (light->shape != NONE_ID && !(light->power > 0) &&
                                   !vec3_is_finite(sub(light->bounds.max, light->bounds.min)));
    return endless ? INFINITY : light->power;
}

enum { STRATA = 64 };

// Sample i of STRATA²: strata of two numbers, and a third that follows the golden ratio.
static bool sample_number(const World *world, const Light *light, Vec3 p, int i, LightSample *out)
{
    double u = (i % STRATA + 0.5) / STRATA, v = ((double)(i / STRATA) + 0.5) / STRATA;
    double third = fmod(i * 0.61803398874989485, 1);
    return light->class->sample(world, light, p, u, v, third, out);
}

double light_irradiance(const World *world, const Light *light, Vec3 p)
{
    if (light->power <= 0) {
        return isinf(light_flux(light)) ? NAN : 0;
    }
    LightSample s;
    bool found = sample_number(world, light, p, 0, &s);
    if (found && s.delta) {
        return (double)luminance(s.value);
    }
    // The direction to face: the mean of those that light comes from.
    Vec3 sum = {0, 0, 0};
    double total = 0;
    for (int i = 0; i < STRATA * STRATA; ++i) {
        if (sample_number(world, light, p, i, &s) && !s.delta) {
            double part = (double)luminance(s.value) / (double)s.pdf;
            sum = add_scaled(sum, s.direction, part);
            total += part;
        }
    }
    if (!(total > 0)) {
        return 0;
    }
    Vec3 normal = length(sum) > 1e-3 * total ? normalize(sum) : vec3(0, 1, 0);
    double irradiance = 0;
    for (int i = 0; i < STRATA * STRATA; ++i) {
        if (sample_number(world, light, p, i, &s) && !s.delta) {
            irradiance +=
                (double)luminance(s.value) / (double)s.pdf * fmax(dot(s.direction, normal), 0);
        }
    }
    return irradiance / (STRATA * STRATA);
}

bool light_is_natural(const Scene *scene, const Light *light)
{
    return attenuation_is_natural(
        scene, light_node_of(&light->class->node, light->params, CATEGORY_ATTENUATION));
}

void light_note_laws(const Scene *scene, DiagSink *sink)
{
    const SceneNodeArray *lights = &scene->nodes[CATEGORY_LIGHT];
    for (uint32_t i = 0; i < lights->count; ++i) {
        const SceneNode *node = &lights->items[i];
        const NodeType *type = scene_node_type(scene, node);
        uint32_t id = light_node_of(type, scene_params(scene, node), CATEGORY_ATTENUATION);
        if (!attenuation_is_natural(scene, id)) {
            const SceneNode *law = scene_node(scene, CATEGORY_ATTENUATION, id);
            Diag *diag = diag_report(sink, N0901, node->at,
                                     "this light's attenuation, `%s`, is not nature's",
                                     scene_node_type(scene, law)->name);
            diag_note(sink, diag, "only `inverse_square` conserves energy");
        }
    }
}
