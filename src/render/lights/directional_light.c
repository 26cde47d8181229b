// Light from infinitely far away, out of one direction or out of a small disc in the sky.
#include "render/world.h"
#include "schema/photometry.h"

typedef struct DirectionalLight {
    Vec3 direction; // of travel
    Emission irradiance;
    double angle;      // diameter of the disc, rad
    Rgb perpendicular; // derived: irradiance of a surface that faces the light, W/m²
} DirectionalLight;

enum { DIRECTION, IRRADIANCE, ANGLE };

static const Param PARAMS[] = {
    [DIRECTION] = {.name = "direction",
                   .type = PARAM_VEC3,
                   PARAM_AT(DirectionalLight, direction),
                   .flags = PARAM_REQUIRED | PARAM_UNIT_VECTOR,
                   .doc = "Where the light travels: (0, -1, 0) falls straight down."},
    [IRRADIANCE] = {.name = "irradiance",
                    .type = PARAM_EMISSION,
                    PARAM_AT(DirectionalLight, irradiance),
                    .dims = DIM_BIT(DIM_NONE) | DIM_BIT(DIM_ILLUMINANCE),
                    .si = "W/m²",
                    .min = 0,
                    .max = INFINITY,
                    .flags = PARAM_REQUIRED,
                    .doc = "What a surface facing the light gets: a number (W/m² or lx) times "
                           "`color`, or a color."},
    [ANGLE] = {.name = "angle",
               .type = PARAM_NUMBER,
               PARAM_AT(DirectionalLight, angle),
               .dims = DIM_BIT(DIM_ANGLE),
               .min = 0,
               .max = PI,
               .default_text = "0deg",
               .doc = "The diameter of the disc that the light comes from, as seen from the scene: "
                      "soft shadows, and a disc in the sky and in mirrors. The sun's is 0.53deg; 0 "
                      "gives sharp shadows and nothing to see."},
};

static bool finish(NodeFinish *finish)
{
    DirectionalLight *light = finish->params;
    if (light->irradiance.texture != NONE_ID) {
        finish->report(finish, IRRADIANCE, E0401,
                       "`irradiance` takes a number or a color, not a texture");
        return false;
    }
    if (!emission_to_rgb(&light->irradiance, finish->color, &light->perpendicular)) {
        finish->report(finish, IRRADIANCE, E0932,
                       "a black light can't have a photometric irradiance");
        return false;
    }
    return true;
}

typedef struct DirectionalData {
    Frame frame; // world; n points to the light
    double sin2; // squared sine of the disc's radius
    double rise; // 1 - cos of it: the solid angle over 2π
    Rgb radiance;
} DirectionalData;

// A disc of fewer radians across is a point: its radiance would be beyond a float's range.
#define LEAST_ANGLE 1e-7

static bool prepare(const LightPrepare *prepare)
{
    Light *light = prepare->light;
    const DirectionalLight *params = light->params;
    DirectionalData *data = ARENA_NEW(prepare->arena, DirectionalData);
    if (!data) {
        return false;
    }
    Vec3 travel = transform_vector(&light->to_world, params->direction);
    data->frame = frame_from_normal(neg(normalize(travel)));
    light->delta = params->angle < LEAST_ANGLE;
    if (!light->delta) {
        double half = sin(params->angle / 4), full = sin(params->angle / 2);
        data->sin2 = full * full;
        data->rise = 2 * half * half;
        // A disc of radiance L and radius α gives a surface facing it π sin²α L.
        data->radiance = rgb_scale(params->perpendicular, (float)(1 / (PI * data->sin2)));
    }
    light->data = data;
    light->intensity = (double)luminance(params->perpendicular);
    light->cone = (LightCone){data->frame.n, params->angle / 2, 0};
    double radius = world_radius(prepare->world);
    light->power = light->intensity * PI * radius * radius;
    return true;
}

static bool sample(const World *world, const Light *light, Vec3 reference, double u0, double u1,
                   double u2, LightSample *out)
{
    (void)world, (void)reference, (void)u2;
    const DirectionalLight *params = light->params;
    const DirectionalData *data = light->data;
    *out = (LightSample){.direction = data->frame.n,
                         .distance = INFINITY,
                         .value = params->perpendicular,
                         .pdf = 1,
                         .delta = true};
    if (!light->delta) {
        // Uniform over the cap: 1 - cos θ from 0 to `rise`.
        Vec2 disc = sample_disc((float)u0, (float)u1);
        double r2 = disc.x * disc.x + disc.y * disc.y, height = data->rise * r2;
        double spread = r2 > 0 ? sqrt(height * (2 - height) / r2) : 0;
        Vec3 local = vec3(disc.x * spread, disc.y * spread, 1 - height);
        out->direction = normalize(from_local(&data->frame, local));
        out->value = data->radiance;
        out->pdf = (float)(1 / (2 * PI * data->rise));
        out->delta = false;
    }
    return true;
}

static bool in_disc(const Light *light, Vec3 direction)
{
    const DirectionalData *data = light->data;
    return !light->delta && dot(direction, data->frame.n) > 0 &&
           length_squared(cross(direction, data->frame.n)) <= data->sin2;
}

static float pdf(const World *world, const Light *light, Vec3 reference, Vec3 direction,
                 const Surface *hit)
{
    (void)world, (void)reference, (void)hit;
    const DirectionalData *data = light->data;
    return in_disc(light, direction) ? (float)(1 / (2 * PI * data->rise)) : 0;
}

static Rgb escaped(const World *world, const Light *light, Vec3 direction, float *pdf_out)
{
    const DirectionalData *data = light->data;
    if (pdf_out) {
        *pdf_out = pdf(world, light, vec3(0, 0, 0), direction, NULL);
    }
    return in_disc(light, direction) ? data->radiance : rgb_gray(0);
}

static bool begin(const World *world, const Light *light, double u0, double u1, double u2,
                  LightOrigin *out)
{
    LightSample s;
    sample(world, light, vec3(0, 0, 0), u0, u1, u2, &s);
    *out = (LightOrigin){.infinite = true, .direction = neg(s.direction), .pdf = (double)s.pdf};
    return true;
}

static Rgb leaving(const World *world, const Light *light, const LightOrigin *origin,
                   Vec3 direction)
{
    (void)world, (void)origin, (void)direction;
    const DirectionalLight *params = light->params;
    const DirectionalData *data = light->data;
    return light->delta ? params->perpendicular : data->radiance;
}

const LightClass directional_light_light = {
    .node =
        {.name = "directional_light",
         .category = CATEGORY_LIGHT,
         .params = PARAMS,
         .param_count = sizeof PARAMS / sizeof *PARAMS,
         .size = sizeof(DirectionalLight),
         .doc = "Light from infinitely far away (the slides' directional light): out of one "
                "direction everywhere, or, with an `angle`, out of a disc in the sky such as "
                "the sun's.",
         .formula = "E = irradiance · cos θ; the disc's radiance is irradiance / (π sin²(angle "
                    "/ 2))",
         .example =
             "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
             "plane { material: lambert { color: gray(0.6) } }\n"
             "plane { point: (0, 0, -1), normal: (0, 0, 1), material: lambert { color: gray(0.6) } "
             "}\n"
             "directional_light { direction: (-1, -1, -1.2), irradiance: 3, angle: 5deg } // ten "
             "times the sun's disc\n"
             "environment_light { color: #a8c4e8, radiance: 0.15 }\n"
             "sphere { center: (0, 0.4, 0), radius: 0.4, material: lambert { color: #c0704a } }",
         .finish = finish},
    .infinite = true,
    .prepare = prepare,
    .sample = sample,
    .pdf = pdf,
    .escaped = escaped,
    .begin = begin,
    .leaving = leaving,
};
