// A point that emits a beam.
#include "render/attenuation.h"
#include "render/lights/point_light.h"
#include "render/lights/smooth_cone.h"
#include "render/world.h"

typedef struct SpotLight {
    Vec3 position;
    Vec3 target, direction;    // one of them
    Quantity intensity, power; // one of them
    uint32_t falloff, attenuation;
    bool has_target;       // derived
    Rgb radiant_intensity; // derived: on the axis, W/sr
} SpotLight;

enum { POSITION, TARGET, DIRECTION, INTENSITY, POWER, FALLOFF, ATTENUATION };

static const Param PARAMS[] = {
    [POSITION] = {.name = "position",
                  .type = PARAM_VEC3,
                  PARAM_AT(SpotLight, position),
                  .dims = DIM_BIT(DIM_LENGTH),
                  .flags = PARAM_REQUIRED,
                  .doc = "Where it is."},
    [TARGET] = {.name = "target",
                .type = PARAM_VEC3,
                PARAM_AT(SpotLight, target),
                .dims = DIM_BIT(DIM_LENGTH),
                .flags = PARAM_NO_DEFAULT,
                .doc = "A point on its axis; or give `direction`."},
    [DIRECTION] = {.name = "direction",
                   .type = PARAM_VEC3,
                   PARAM_AT(SpotLight, direction),
                   .flags = PARAM_NO_DEFAULT | PARAM_UNIT_VECTOR,
                   .doc = "Where its axis points; or give `target`."},
    [INTENSITY] = {.name = "intensity",
                   .type = PARAM_QUANTITY,
                   PARAM_AT(SpotLight, intensity),
                   .dims = DIM_BIT(DIM_NONE) | DIM_BIT(DIM_LUMINOUS_INTENSITY),
                   .si = "W/sr",
                   .min = 0,
                   .max = INFINITY,
                   .flags = PARAM_NO_DEFAULT,
                   .doc = "The intensity on the axis, in W/sr or cd; or give `power`."},
    [POWER] = {.name = "power",
               .type = PARAM_QUANTITY,
               PARAM_AT(SpotLight, power),
               .dims = DIM_BIT(DIM_POWER) | DIM_BIT(DIM_LUMINOUS_FLUX),
               .min = 0,
               .max = INFINITY,
               .flags = PARAM_NO_DEFAULT,
               .doc = "The whole flux of the beam, in W or lm: a narrower beam of the same power "
                      "is brighter. Or give `intensity`."},
    [FALLOFF] = {.name = "falloff",
                 .type = PARAM_NODE,
                 PARAM_AT(SpotLight, falloff),
                 .category = CATEGORY_FALLOFF,
                 .default_text = "smooth_cone { inner: 25deg, outer: 30deg }",
                 .doc = "How the intensity falls off with the angle from the axis."},
    [ATTENUATION] = {.name = "attenuation",
                     .type = PARAM_NODE,
                     PARAM_AT(SpotLight, attenuation),
                     .category = CATEGORY_ATTENUATION,
                     .default_text = "inverse_square {}",
                     .doc = "How the light falls off with distance."},
};

static bool finish(NodeFinish *finish)
{
    SpotLight *light = finish->params;
    bool has_direction = finish->set & (1u << DIRECTION);
    light->has_target = finish->set & (1u << TARGET);
    if (light->has_target == has_direction) {
        finish->report(finish, has_direction ? DIRECTION : -1, E0937,
                       "`spot_light` takes either `target` or `direction`, %s",
                       has_direction ? "not both" : "and has neither");
        return false;
    }
    if (light->has_target && !(length_squared(sub(light->target, light->position)) > 0)) {
        finish->report(finish, TARGET, E0937, "`target` is at the light's `position`");
        return false;
    }
    return point_intensity(finish, INTENSITY, POWER, light->intensity, light->power,
                           falloff_integral(finish->scene, light->falloff),
                           &light->radiant_intensity);
}

typedef struct SpotData {
    Vec3 position, axis; // in the world
} SpotData;

static bool prepare(const LightPrepare *prepare)
{
    Light *light = prepare->light;
    const SpotLight *params = light->params;
    const Scene *scene = prepare->world->scene;
    SpotData *data = ARENA_NEW(prepare->arena, SpotData);
    if (!data) {
        return false;
    }
    Vec3 axis = params->has_target ? sub(params->target, params->position) : params->direction;
    data->position = transform_point(&light->to_world, params->position);
    data->axis = normalize(transform_vector(&light->to_world, axis));
    light->data = data;
    light->intensity = (double)luminance(params->radiant_intensity);
    light->power = light->intensity * falloff_integral(scene, params->falloff);
    light->bounds = box3_add(box3_empty(), data->position);
    light->cone = (LightCone){data->axis, 0, falloff_reach(scene, params->falloff)};
    return true;
}

static bool sample(const World *world, const Light *light, Vec3 reference, double u0, double u1,
                   double u2, LightSample *out)
{
    (void)u0, (void)u1, (void)u2;
    const SpotLight *params = light->params;
    const SpotData *data = light->data;
    Vec3 to = sub(data->position, reference);
    double r = length(to);
    if (!(r > 0)) {
        return false;
    }
    Vec3 direction = scale(to, 1 / r);
    double beam = falloff_factor(world->scene, params->falloff, -dot(direction, data->axis));
    float factor =
        beam > 0 ? (float)(beam * attenuation_factor(world->scene, params->attenuation, r)) : 0;
    *out = (LightSample){.direction = direction,
                         .distance = r,
                         .point = data->position,
                         .value = rgb_scale(params->radiant_intensity, factor),
                         .pdf = 1,
                         .delta = true};
    return factor > 0;
}

static bool begin(const World *world, const Light *light, double u0, double u1, double u2,
                  LightOrigin *out)
{
    (void)world, (void)u0, (void)u1, (void)u2;
    const SpotData *data = light->data;
    *out = (LightOrigin){.surface.point.p = data->position, .point = true, .pdf = 1};
    return true;
}

static Rgb leaving(const World *world, const Light *light, const LightOrigin *origin,
                   Vec3 direction)
{
    (void)origin;
    const SpotLight *params = light->params;
    const SpotData *data = light->data;
    const double beam = falloff_factor(world->scene, params->falloff, dot(direction, data->axis));
    return rgb_scale(params->radiant_intensity, (float)beam);
}

const LightClass spot_light_light = {
    .node = {.name = "spot_light",
             .category = CATEGORY_LIGHT,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(SpotLight),
             .doc = "A point that emits a beam about an axis (the slides' spot light).",
             .formula = "E = I g(θ) f(r) cos θi, θ from the axis to the lit point; I = Φ / ∫ g dω",
             .example =
                 "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                 "environment_light { radiance: 0.03 }\n"
                 "plane { material: lambert { color: gray(0.6) } }\n"
                 "plane { point: (0, 0, -1), normal: (0, 0, 1), material: lambert { color: "
                 "gray(0.6) } }\n"
                 "for (i in 0..2) {\n"
                 "  let x = 1.1 * (i - 1)\n"
                 "  spot_light {\n"
                 "    position: (x, 1.7, 1), target: (x, 0.3, -0.6), intensity: 12\n"
                 "    falloff: [\n"
                 "      cosine_lobe { exponent: 10 }, smooth_cone { inner: 10deg, outer: 30deg },\n"
                 "      smooth_cone { inner: 20deg, outer: 20.1deg }\n"
                 "    ][i]\n"
                 "  }\n"
                 "}",
             .finish = finish},
    .prepare = prepare,
    .sample = sample,
    .begin = begin,
    .leaving = leaving,
};

// --- Falloffs of a scene -------------------------------------------------------------------------

static const SmoothCone DEFAULT_CONE = {25 * PI / 180, 30 * PI / 180};

static const FalloffClass *falloff_class(const Scene *scene, uint32_t falloff, const void **params)
{
    if (falloff == NONE_ID) {
        *params = &DEFAULT_CONE;
        return &smooth_cone_falloff;
    }
    const SceneNode *node = scene_node(scene, CATEGORY_FALLOFF, falloff);
    *params = scene_params(scene, node);
    return (const FalloffClass *)(const void *)scene_node_type(scene, node);
}

double falloff_factor(const Scene *scene, uint32_t falloff, double cos_angle)
{
    const void *params;
    const FalloffClass *class = falloff_class(scene, falloff, &params);
    return class->factor(params, cos_angle);
}

double falloff_integral(const Scene *scene, uint32_t falloff)
{
    const void *params;
    const FalloffClass *class = falloff_class(scene, falloff, &params);
    return class->integral(params);
}

double falloff_reach(const Scene *scene, uint32_t falloff)
{
    const void *params;
    const FalloffClass *class = falloff_class(scene, falloff, &params);
    return class->reach(params);
}
