// Shapes that emit: by an area_light node, or by their material.
#include "render/lights/area_light.h"

#include "base/hot.h"
#include "render/world.h"
#include "schema/photometry.h"

#include <float.h>

extern const MaterialClass emissive_material;

enum { SHAPE, RADIANCE, POWER, TWO_SIDED };

static const Param PARAMS[] = {
    [SHAPE] = {.name = "shape",
               .type = PARAM_NODE,
               PARAM_AT(AreaLight, shape),
               .category = CATEGORY_SHAPE,
               .flags = PARAM_REQUIRED,
               .doc = "What emits: any shape of finite area. It is seen; its own material "
                      "reflects, and without one it reflects nothing."},
    [RADIANCE] = {.name = "radiance",
                  .type = PARAM_EMISSION,
                  PARAM_AT(AreaLight, radiance),
                  .dims = DIM_BIT(DIM_NONE) | DIM_BIT(DIM_LUMINANCE),
                  .si = "W/m²/sr",
                  .min = 0,
                  .max = INFINITY,
                  .flags = PARAM_NO_DEFAULT,
                  .doc =
                      "What it emits in every direction: a number (W/m²/sr or nit) times `color`, "
                      "a color, or a texture; or give `power`."},
    [POWER] = {.name = "power",
               .type = PARAM_QUANTITY,
               PARAM_AT(AreaLight, power),
               .dims = DIM_BIT(DIM_POWER) | DIM_BIT(DIM_LUMINOUS_FLUX),
               .min = 0,
               .max = INFINITY,
               .flags = PARAM_NO_DEFAULT,
               .doc = "The whole emitted flux, in W or lm; or give `radiance`."},
    [TWO_SIDED] = {.name = "two_sided",
                   .type = PARAM_BOOL,
                   PARAM_AT(AreaLight, two_sided),
                   .default_text = "false",
                   .doc = "Does the back emit too? Else only the front side does: the outside of "
                          "closed shapes."},
};

static bool finish(NodeFinish *finish)
{
    AreaLight *light = finish->params;
    bool has_radiance = finish->set & (1u << RADIANCE), has_power = finish->set & (1u << POWER);
    if (has_radiance == has_power) {
        finish->report(finish, has_power ? POWER : -1, E0930,
                       "`area_light` takes either `radiance` or `power`, %s",
                       has_power ? "not both" : "and has neither");
        return false;
    }
    light->by_power = has_power;
    if (!has_radiance) {
        light->radiance = (Emission){.texture = NONE_ID};
    }
    bool bright = has_power ? quantity_to_rgb(light->power, finish->color, &light->strength)
                            : emission_to_rgb(&light->radiance, finish->color, &light->strength);
    if (!bright) {
        finish->report(finish, has_power ? POWER : RADIANCE, E0932,
                       "a black light can't have a photometric %s",
                       has_power ? "power" : "radiance");
    }
    return bright;
}

// What both classes keep of a shape.
typedef struct AreaData {
    const ShapeClass *class;
    const void *shape; // its parameters
    void *table;       // for sample_area
    double area;       // m²
    Affine to_world, to_object;
    uint32_t material; // of an emitting shape; NONE_ID for an area_light
    Rgb radiance;      // of an area_light, before the texture
    uint32_t texture;
    bool two_sided;
    bool is_even; // emits everywhere the same radiance, `even`
    Rgb even;
    uint32_t target; // see LightSample
    bool front_only; // flat, and dark behind the plane of `point` and `normal`
    Vec3 point, normal;
} AreaData;

// The material that a shape of an instance has.
static uint32_t shape_material(const Scene *scene, uint32_t shape, uint32_t instance)
{
    uint32_t own = scene_node(scene, CATEGORY_SHAPE, shape)->material;
    return own == NONE_ID && instance != NONE_ID ? scene->instances.items[instance].material : own;
}

// Geometry that both classes need. light->shape, instance and to_world are set.
static AreaData *prepare_shape(const LightPrepare *prepare)
{
    const Scene *scene = prepare->world->scene;
    Light *light = prepare->light;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, light->shape);
    AreaData *data = ARENA_NEW(prepare->arena, AreaData);
    if (!data || !affine_inverse(&light->to_world, &data->to_object)) {
        return NULL;
    }
    data->class = shape_class(scene, node);
    data->shape = scene_params(scene, node);
    data->to_world = light->to_world;
    data->texture = NONE_ID;
    data->material = NONE_ID;
    data->area = data->class->area && data->class->sample_area
                     ? data->class->area(scene, data->shape, &data->to_world)
                     : INFINITY;
    if (isfinite(data->area) && data->class->prepare_sampling) {
        data->table =
            data->class->prepare_sampling(scene, data->shape, &data->to_world, prepare->arena);
        if (!data->table) {
            return NULL;
        }
    }
    light->parts = !data->class->flat;
    data->target = data->class->flat && light->instance == NONE_ID ? light->shape + 1 : 0;
    light->bounds = transform_box(&data->to_world, data->class->node.bounds(scene, data->shape));
    light->data = data;
    return data;
}

// The power of a surface that emits radiance L diffusely is π A L (twice for two sides). Light that
// spreads over an infinite surface can't be sampled: its power counts as zero.
static double diffuse_power(const AreaData *data, Rgb radiance)
{
    double power = PI * data->area * (double)luminance(radiance) * (data->two_sided ? 2 : 1);
    return isfinite(power) ? power : 0;
}

// The light's strength, and the directions into which it shines where the shape is flat.
static void set_strength(const LightPrepare *prepare, AreaData *data, Rgb radiance, bool both_sides)
{
    Light *light = prepare->light;
    light->power = diffuse_power(data, radiance);
    light->intensity =
        isfinite(data->area) ? data->area * (double)luminance(radiance) : light->power;
    if (data->class->flat && isfinite(data->area) && !both_sides) {
        ShapeSample s;
        data->class->sample_area(prepare->world->scene, data->shape, &data->to_world, data->table,
                                 0.5, 0.5, 0.5, &s);
        light->cone = (LightCone){s.point.geometric, 0, PI / 2};
        data->front_only = true;
        data->point = s.point.p;
        data->normal = s.point.geometric;
    }
}

static bool prepare_area_light(const LightPrepare *prepare)
{
    const AreaLight *params = prepare->light->params;
    AreaData *data = prepare_shape(prepare);
    if (!data) {
        return false;
    }
    data->two_sided = params->two_sided;
    data->texture = params->radiance.texture;
    data->radiance = params->strength;
    if (params->by_power) {
        if (!(data->area > 0) || !isfinite(data->area)) {
            diag_report(prepare->sink, E0933, prepare->at,
                        "a shape of %s area can't emit a given power; give `radiance`",
                        data->area > 0 ? "infinite" : "no");
            return false;
        }
        double sides = params->two_sided ? 2 : 1;
        data->radiance = rgb_scale(params->strength, (float)(1 / (PI * data->area * sides)));
        data->texture = NONE_ID;
    }
    Rgb mean = data->texture == NONE_ID
                   ? data->radiance
                   : rgb_mul(data->radiance, texture_mean(prepare->world->textures, data->texture));
    prepare->light->whole = data->texture != NONE_ID;
    data->is_even = data->texture == NONE_ID;
    data->even = data->radiance;
    set_strength(prepare, data, mean, params->two_sided);
    return true;
}

static bool prepare_emissive(const LightPrepare *prepare)
{
    const World *world = prepare->world;
    AreaData *data = prepare_shape(prepare);
    if (!data) {
        return false;
    }
    data->material = shape_material(world->scene, prepare->light->shape, prepare->light->instance);
    prepare->light->whole = material_needs_whole(world, data->material);
    // Only `emissive` itself is known to be dark behind.
    bool one_sided = world_material(world, data->material)->class == &emissive_material;
    data->is_even = one_sided && !prepare->light->whole;
    data->even = material_emitted_mean(world, data->material);
    set_strength(prepare, data, material_emitted_mean(world, data->material), !one_sided);
    return true;
}

static Rgb emitted(const World *world, const Light *light, const Surface *hit)
{
    const AreaData *data = light->data;
    if (data->material != NONE_ID) {
        return material_emitted(world, data->material, hit);
    }
    if (!hit->front && !data->two_sided) {
        return rgb_gray(0);
    }
    return data->texture == NONE_ID
               ? data->radiance
               : rgb_mul(data->radiance, texture_color(world->textures, data->texture, hit));
}

// The radiance that a sampled point emits to its front, or to its back.
static Rgb emitted_at(const World *world, const Light *light, const ShapeSample *s, bool front)
{
    const AreaData *data = light->data;
    if (data->material == NONE_ID && data->texture == NONE_ID) {
        return front || data->two_sided ? data->radiance : rgb_gray(0);
    }
    Surface surface = {.p = s->point.p,
                       .geometric = s->point.geometric,
                       .shading = s->point.shading,
                       .tangent = s->point.tangent,
                       .bitangent = s->point.bitangent,
                       .object_p = transform_point(&data->to_object, s->point.p),
                       .uv = s->point.uv,
                       .color = s->point.color,
                       .error = s->point.error,
                       .shape = light->shape,
                       .instance = light->instance,
                       .primitive = s->primitive,
                       .material = data->material,
                       .front = front};
    return emitted(world, light, &surface);
}

// Fills the sample from the point that was chosen; all but its radiance.
static inline bool take_aim(const AreaData *data, const ShapeAim *aim, Vec3 reference,
                            double *facing, LightSample *out)
{
    const Vec3 to = sub(aim->p, reference);
    const double r2 = length_squared(to), across = -dot(to, aim->normal);
    if (!(r2 >= DBL_MIN) || !(fabs(across) > 0) || !(aim->pdf > 0)) {
        return false;
    }
    // The root and both divisions at once.
    const double r = sqrt(r2), inverse = r * (1 / r2);
    out->direction = scale(to, inverse);
    *facing = across * inverse;
    const double cosine = fabs(*facing);
    out->distance = r;
    out->point = aim->p;
    out->error = aim->error;
    out->target = data->target;
    out->facing = data->class->holding == HOLD_USER ? 0 : cosine;
    out->pdf = (float)(aim->by_angle ? aim->pdf : aim->pdf * r2 / fabs(across) * r);
    out->delta = false;
    return out->pdf > 0 && out->pdf < INFINITY;
}

// Sampled by solid angle where the shape can, else by area.
HOT static bool sample(const World *world, const Light *light, Vec3 reference, double u0, double u1,
                       double u2, LightSample *out)
{
    const AreaData *data = light->data;
    const ShapeClass *class = data->class;
    if (data->front_only && dot(sub(reference, data->point), data->normal) <= 0) {
        return false;
    }
    ShapeAim aim;
    double facing;
    if (class->aim && data->is_even &&
        class->aim(data->shape, &data->to_world, data->table, reference, u0, u1, &aim)) {
        if (!take_aim(data, &aim, reference, &facing, out)) {
            return false;
        }
        out->value = facing > 0 || data->two_sided ? data->even : rgb_gray(0);
        return true;
    }
    ShapeSample s;
    aim.by_angle =
        class->sample_solid_angle &&
        class->sample_solid_angle(data->shape, &data->to_world, data->table, reference, u0, u1, &s);
    if (!aim.by_angle) {
        class->sample_area(world->scene, data->shape, &data->to_world, data->table, u0, u1, u2, &s);
    }
    aim.p = s.point.p;
    aim.normal = s.point.geometric;
    aim.error = s.point.error;
    aim.pdf = s.pdf;
    if (!take_aim(data, &aim, reference, &facing, out)) {
        return false;
    }
    out->value = emitted_at(world, light, &s, facing > 0);
    return true;
}

static float pdf(const World *world, const Light *light, Vec3 reference, Vec3 direction,
                 const Surface *hit)
{
    (void)world;
    const AreaData *data = light->data;
    if (data->class->solid_angle_pdf) {
        double by_angle = data->class->solid_angle_pdf(data->shape, &data->to_world, data->table,
                                                       reference, direction);
        if (by_angle > 0) {
            return (float)by_angle;
        }
    }
    double facing = fabs(dot(direction, hit->geometric));
    double by_area = length_squared(sub(hit->p, reference)) / (facing * data->area);
    return isfinite(by_area) ? (float)by_area : 0;
}

static bool begin(const World *world, const Light *light, double u0, double u1, double u2,
                  LightOrigin *out)
{
    const AreaData *data = light->data;
    if (!data->class->sample_area || !(data->area > 0) || !isfinite(data->area)) {
        return false;
    }
    *out = (LightOrigin){.point = false};
    data->class->sample_area(world->scene, data->shape, &data->to_world, data->table, u0, u1, u2,
                             &out->surface);
    out->pdf = out->surface.pdf;
    return out->pdf > 0 && out->pdf < INFINITY;
}

static Rgb leaving(const World *world, const Light *light, const LightOrigin *origin,
                   Vec3 direction)
{
    const double facing = dot(direction, origin->surface.point.geometric);
    const Rgb radiance = emitted_at(world, light, &origin->surface, facing > 0);
    return rgb_scale(radiance, (float)fabs(facing));
}

const LightClass area_light_light = {
    .node =
        {.name = "area_light",
         .category = CATEGORY_LIGHT,
         .params = PARAMS,
         .param_count = sizeof PARAMS / sizeof *PARAMS,
         .size = sizeof(AreaLight),
         .doc = "A shape that emits light diffusely from its front side: a lamp with a size, and "
                "so with soft shadows.",
         .formula = "L = radiance, or Φ / (π A), halved if two-sided",
         .example =
             "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
             "plane { material: lambert { color: gray(0.6) } }\n"
             "plane { point: (0, 0, -1), normal: (0, 0, 1), material: lambert { color: gray(0.6) } "
             "}\n"
             "area_light {\n"
             "  shape: disc { center: (-0.8, 1.5, 0.2), normal: (0.3, -1, 0), radius: 0.3 }\n"
             "  power: 40W\n"
             "}\n"
             "area_light { shape: sphere { center: (0.9, 1, -0.3), radius: 0.15 }, color: #ffb060, "
             "radiance: 12 }\n"
             "sphere { center: (0, 0.4, 0), radius: 0.4, material: lambert { color: #c0704a } }",
         .finish = finish},
    .prepare = prepare_area_light,
    .sample = sample,
    .pdf = pdf,
    .emitted = emitted,
    .begin = begin,
    .leaving = leaving,
};

const LightClass emissive_shape_light = {
    .prepare = prepare_emissive,
    .sample = sample,
    .pdf = pdf,
    .emitted = emitted,
    .begin = begin,
    .leaving = leaving,
};
