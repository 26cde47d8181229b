// A point that emits the same in all directions.
#include "render/lights/point_light.h"

#include "render/attenuation.h"
#include "render/world.h"
#include "schema/photometry.h"

enum { POSITION, INTENSITY, POWER, ATTENUATION };

static const Param PARAMS[] = {
    [POSITION] = {.name = "position",
                  .type = PARAM_VEC3,
                  PARAM_AT(PointLight, position),
                  .dims = DIM_BIT(DIM_LENGTH),
                  .flags = PARAM_REQUIRED,
                  .doc = "Where it is."},
    [INTENSITY] = {.name = "intensity",
                   .type = PARAM_QUANTITY,
                   PARAM_AT(PointLight, intensity),
                   .dims = DIM_BIT(DIM_NONE) | DIM_BIT(DIM_LUMINOUS_INTENSITY),
                   .si = "W/sr",
                   .min = 0,
                   .max = INFINITY,
                   .flags = PARAM_NO_DEFAULT,
                   .doc = "The intensity in every direction, in W/sr or cd; or give `power`."},
    [POWER] = {.name = "power",
               .type = PARAM_QUANTITY,
               PARAM_AT(PointLight, power),
               .dims = DIM_BIT(DIM_POWER) | DIM_BIT(DIM_LUMINOUS_FLUX),
               .min = 0,
               .max = INFINITY,
               .flags = PARAM_NO_DEFAULT,
               .doc = "The whole emitted flux, in W or lm; or give `intensity`."},
    [ATTENUATION] = {.name = "attenuation",
                     .type = PARAM_NODE,
                     PARAM_AT(PointLight, attenuation),
                     .category = CATEGORY_ATTENUATION,
                     .default_text = "inverse_square {}",
                     .doc = "How the light falls off with distance."},
};

bool point_intensity(NodeFinish *finish, int intensity_field, int power_field, Quantity intensity,
                     Quantity power, double steradians, Rgb *out)
{
    // As masks: GCC 12.2 at -O2 miscompiles `(set >> a & 1) == (set >> b & 1)` here.
    const uint64_t by_intensity = UINT64_C(1) << intensity_field;
    const uint64_t by_power = UINT64_C(1) << power_field;
    const uint64_t given = finish->set & (by_intensity | by_power);
    const bool has_power = given & by_power;
    if (given != by_intensity && given != by_power) {
        finish->report(finish, has_power ? power_field : -1, E0930,
                       "`%s` takes either `intensity` or `power`, %s", finish->type->name,
                       has_power ? "not both" : "and has neither");
        return false;
    }
    Quantity quantity = has_power ? power : intensity;
    if (has_power) {
        quantity.value /= steradians;
    }
    if (!quantity_to_rgb(quantity, finish->color, out)) {
        finish->report(finish, has_power ? power_field : intensity_field, E0932,
                       "a black light can't have a photometric %s",
                       has_power ? "power" : "intensity");
        return false;
    }
    return true;
}

static bool finish(NodeFinish *finish)
{
    PointLight *light = finish->params;
    return point_intensity(finish, INTENSITY, POWER, light->intensity, light->power, 4 * PI,
                           &light->radiant_intensity);
}

typedef struct PointData {
    Vec3 position; // in the world
} PointData;

static bool prepare(const LightPrepare *prepare)
{
    const PointLight *params = prepare->light->params;
    PointData *data = ARENA_NEW(prepare->arena, PointData);
    if (!data) {
        return false;
    }
    data->position = transform_point(&prepare->light->to_world, params->position);
    prepare->light->data = data;
    prepare->light->intensity = (double)luminance(params->radiant_intensity);
    prepare->light->power = 4 * PI * prepare->light->intensity;
    prepare->light->bounds = box3_add(box3_empty(), data->position);
    return true;
}

static bool sample(const World *world, const Light *light, Vec3 reference, double u0, double u1,
                   double u2, LightSample *out)
{
    (void)u0, (void)u1, (void)u2;
    const PointLight *params = light->params;
    const PointData *data = light->data;
    Vec3 to = sub(data->position, reference);
    double r = length(to);
    if (!(r > 0)) {
        return false;
    }
    float factor = (float)attenuation_factor(world->scene, params->attenuation, r);
    *out = (LightSample){.direction = scale(to, 1 / r),
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
    const PointData *data = light->data;
    *out = (LightOrigin){.surface.point.p = data->position, .point = true, .pdf = 1};
    return true;
}

static Rgb leaving(const World *world, const Light *light, const LightOrigin *origin,
                   Vec3 direction)
{
    (void)world, (void)origin, (void)direction;
    return ((const PointLight *)light->params)->radiant_intensity;
}

const LightClass point_light_light = {
    .node =
        {.name = "point_light",
         .category = CATEGORY_LIGHT,
         .params = PARAMS,
         .param_count = sizeof PARAMS / sizeof *PARAMS,
         .size = sizeof(PointLight),
         .doc = "A point that emits the same in all directions.",
         .formula = "E = I cos θ / r², I = Φ / 4π",
         .example =
             "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
             "plane { material: lambert { color: gray(0.6) } }\n"
             "plane { point: (0, 0, -1), normal: (0, 0, 1), material: lambert { color: gray(0.6) } "
             "}\n"
             "point_light { position: (-1, 1, 1), color: #ffb080, power: 50W }\n"
             "point_light { position: (1, 1, 1), color: #80b0ff, power: 50W }\n"
             "sphere { center: (0, 0.4, 0), radius: 0.4, material: lambert { color: #c0704a } }",
         .finish = finish},
    .prepare = prepare,
    .sample = sample,
    .begin = begin,
    .leaving = leaving,
};
