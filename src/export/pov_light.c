// Lights. What is written as their color is explained in pov.h.
#include "export/pov.h"
#include "export/quantities.h"

#include "schema/photometry.h"

#include <string.h>

// POV-Ray's fading is 2/(1 + (r/d)^p). With a d far below the scene's scale it is 2 (d/r)^p.
#define TINY_FADE 1e-4

static const SceneNode *light_node(const Pov *pov, uint32_t light)
{
    return scene_node(pov->e->scene, CATEGORY_LIGHT, light);
}

// --- Fading --------------------------------------------------------------------------------------

typedef struct Fading {
    double factor;          // of the light's color
    double distance, power; // power 0: none
} Fading;

static Fading polynomial(const Pov *pov, const SceneNode *node)
{
    double a = export_number(pov->e, node, "a"), b = export_number(pov->e, node, "b");
    double c = export_number(pov->e, node, "c");
    if (b > 0 && c > 0) {
        export_note(
            pov->e, node->at,
            "1/(a + b r + c r²) with b and c has no partner: 1/(a + (b + c) r²) is written");
        c += b;
        b = 0;
    }
    double rest = c > 0 ? c : b, power = c > 0 ? 2 : 1;
    if (!(rest > 0)) {
        return (Fading){1 / a, 0, 0};
    }
    if (a > 0) {
        return (Fading){0.5 / a, c > 0 ? sqrt(a / c) : a / b, power};
    }
    double distance = c > 0 ? TINY_FADE : TINY_FADE * TINY_FADE;
    return (Fading){0.5 / (rest * pow(distance, power)), distance, power};
}

static Fading fading_of(const Pov *pov, const SceneNode *light)
{
    const Fading natural = {0.5 / (TINY_FADE * TINY_FADE), TINY_FADE, 2};
    uint32_t id = export_id(pov->e, light, "attenuation");
    if (id == NONE_ID) {
        return natural;
    }
    const SceneNode *node = scene_node(pov->e->scene, CATEGORY_ATTENUATION, id);
    if (export_is(pov->e, node, "constant")) {
        return (Fading){1, 0, 0};
    }
    if (export_is(pov->e, node, "polynomial")) {
        return polynomial(pov, node);
    }
    if (!export_is(pov->e, node, "inverse_square")) {
        export_note(pov->e, light->at, "the attenuation `%s` has no partner: none is written",
                    export_kind(pov->e, node));
        return (Fading){1, 0, 0};
    }
    return natural;
}

static void write_color(const Pov *pov, Rgb color, Fading fading)
{
    Rgb written = rgb_scale(color, (float)(pov->light_scale * fading.factor));
    pov_rgb(pov, written);
}

static void write_fading(const Pov *pov, Fading fading)
{
    if (fading.power > 0) {
        fputs("  fade_distance ", pov->e->out);
        pov_number(pov, fading.distance);
        fprintf(pov->e->out, " fade_power %d\n", (int)fading.power);
    }
}

static void begin_light(const Pov *pov, Vec3 position, Rgb color, Fading fading)
{
    fputs("light_source {\n  ", pov->e->out);
    pov_point(pov, position);
    fputs(", ", pov->e->out);
    write_color(pov, color, fading);
    fputc('\n', pov->e->out);
    write_fading(pov, fading);
}

// --- Point and spot ------------------------------------------------------------------------------

static void write_point(const Pov *pov, uint32_t light, const Affine *map)
{
    const SceneNode *node = light_node(pov, light);
    Vec3 position = transform_point(map, export_vec3(pov->e, node, "position"));
    begin_light(pov, position, export_intensity(pov->e, light, 4 * PI), fading_of(pov, node));
    fputs("}\n\n", pov->e->out);
}

static void write_spot_cone(const Pov *pov, Vec3 position, Vec3 axis, double degrees,
                            double tightness)
{
    fputs("  spotlight radius ", pov->e->out);
    pov_number(pov, degrees);
    fputs(" falloff ", pov->e->out);
    pov_number(pov, degrees);
    fputs(" tightness ", pov->e->out);
    pov_number(pov, tightness);
    fputs(" point_at ", pov->e->out);
    pov_point(pov, add(position, axis));
    fputs("\n}\n\n", pov->e->out);
}

// POV-Ray's own soft edge is a cubic in the cosine. The slides' law is had by a small sphere about
// the light, seen by shadow rays only, that lets the law's part through in every direction.
static void write_filter(const Pov *pov, Vec3 position, Vec3 axis, double inner, double outer)
{
    FILE *out = pov->e->out;
    const double radius = 0.01; // above the distance at which POV-Ray ends shadow rays
    fputs("sphere { 0, ", out);
    pov_number(pov, radius);
    fputs(" // (1 - (angle - inner)/(outer - inner))^2, halved since patterns end below 1\n"
          "  pigment {\n    function { 0.5*pow(min(1, max(0, (",
          out);
    pov_number(pov, outer);
    fputs(" - acos(min(1, max(-1, (x*(", out);
    pov_number(pov, axis.x);
    fputs(") + y*(", out);
    pov_number(pov, axis.y);
    fputs(") + z*(", out);
    pov_number(pov, -axis.z);
    fputs("))/sqrt(x*x + y*y + z*z)))))/", out);
    pov_number(pov, outer - inner);
    fputs(")), 2) }\n    color_map { [0 rgbt <0, 0, 0, 0>] [0.5 rgbt <0, 0, 0, 1>] [1 rgbt <0, 0, "
          "0, 1>] }\n  }\n  finish { ambient 0 diffuse 0 }\n  no_image no_reflection translate ",
          out);
    pov_point(pov, position);
    fputs("\n}\n\n", out);
}

static void write_spot(const Pov *pov, uint32_t light, const Affine *map)
{
    Export *e = pov->e;
    const SceneNode *node = light_node(pov, light);
    Vec3 position = transform_point(map, export_vec3(e, node, "position"));
    Vec3 axis = normalize(transform_vector(map, export_spot_axis(e, node)));
    uint32_t id = export_id(e, node, "falloff");
    const SceneNode *falloff = id == NONE_ID ? NULL : scene_node(e->scene, CATEGORY_FALLOFF, id);
    Rgb intensity = export_intensity(e, light, export_falloff_steradians(e, falloff));
    if (falloff && export_is(e, falloff, "cosine_lobe")) {
        double n = export_number(e, falloff, "exponent");
        begin_light(pov, position, intensity, fading_of(pov, node));
        write_spot_cone(pov, position, axis, 90, n);
    } else if (falloff && export_is(e, falloff, "smooth_cone")) {
        double inner = export_number(e, falloff, "inner");
        double outer = export_number(e, falloff, "outer");
        begin_light(pov, position, intensity, fading_of(pov, node));
        write_spot_cone(pov, position, axis, outer * 180 / PI, 0);
        write_filter(pov, position, axis, inner, outer);
    } else {
        export_note(e, node->at, "the falloff of this light has no partner: it is left out");
    }
}

// --- Directional ---------------------------------------------------------------------------------

static void write_directional(const Pov *pov, uint32_t light, const Affine *map)
{
    const SceneNode *node = light_node(pov, light);
    Vec3 travel = normalize(transform_vector(map, export_vec3(pov->e, node, "direction")));
    if (export_number(pov->e, node, "angle") > 0) {
        export_note(pov->e, node->at,
                    "`angle` has no partner: the light comes from one direction, and its disc "
                    "isn't seen");
    }
    // Far enough for all that casts shadows to be before it.
    double distance = 100 * fmax(pov->radius, 10);
    begin_light(pov, scale(travel, -distance), export_irradiance(pov->e, light), (Fading){1, 0, 0});
    fputs("  parallel point_at <0, 0, 0>\n}\n\n", pov->e->out);
}

// --- Lights with a size --------------------------------------------------------------------------

// A lamp's shape: the middle, two half axes where it is flat, area, front.
typedef struct Lamp {
    Vec3 middle, u, v, normal;
    double area, projected; // m²; towards the front
    bool round, flat;
} Lamp;

static bool read_lamp(const Pov *pov, uint32_t shape, Lamp *out)
{
    Export *e = pov->e;
    const SceneNode *node = scene_node(e->scene, CATEGORY_SHAPE, shape);
    const Affine *map = export_transform(e, node->transform);
    if (export_is(e, node, "rectangle")) {
        Vec3 u = transform_vector(map, export_vec3(e, node, "u"));
        Vec3 v = transform_vector(map, export_vec3(e, node, "v"));
        Vec3 corner = transform_point(map, export_vec3(e, node, "corner")), n = cross(u, v);
        double area = length(n);
        *out = (Lamp){.middle = add_scaled(corner, add(u, v), 0.5),
                      .u = u,
                      .v = v,
                      .flat = true,
                      .normal = scale(n, affine_determinant(map) < 0 ? -1 / area : 1 / area),
                      .area = area,
                      .projected = area};
        return true;
    }
    bool sphere = export_is(e, node, "sphere");
    if (!sphere && !export_is(e, node, "disc")) {
        return false;
    }
    double r = export_number(e, node, "radius") * cbrt(fabs(affine_determinant(map)));
    Vec3 n =
        sphere ? vec3(0, 1, 0) : normalize(transform_vector(map, export_vec3(e, node, "normal")));
    Frame f = frame_from_normal(n);
    *out = (Lamp){.middle = transform_point(map, export_vec3(e, node, "center")),
                  .normal = n,
                  .u = scale(f.s, 2 * r),
                  .v = scale(f.t, 2 * r),
                  .round = true,
                  .flat = !sphere,
                  .area = (sphere ? 4 : 1) * PI * r * r,
                  .projected = PI * r * r};
    return true;
}

// The light of a lamp of this radiance.
static void write_lamp_light(const Pov *pov, uint32_t shape, Rgb radiance, bool both, Span at)
{
    const Fading natural = {0.5 / (TINY_FADE * TINY_FADE), TINY_FADE, 2};
    Lamp lamp;
    FILE *out = pov->e->out;
    if (!read_lamp(pov, shape, &lamp)) {
        export_note(pov->e, at,
                    "a lamp of this shape has no partner: it is seen, but its light is left out");
        return;
    }
    export_note(pov->e, at,
                pov->local ? "a light with a size is a lattice of 9 x 9 points, not one"
                           : "a light with a size is a lattice of 9 x 9 points");
    if (!lamp.flat) {
        export_note(pov->e, at,
                    "a ball shines from a disc that turns to the lit point: near it a few percent "
                    "are missing");
    }
    for (int side = 0; side < (both && lamp.flat ? 2 : 1); ++side) {
        Vec3 n = side ? neg(lamp.normal) : lamp.normal;
        begin_light(pov, lamp.middle, rgb_scale(radiance, (float)lamp.projected), natural);
        fputs("  area_light ", out);
        // Points at both ends: with these lengths they are the middles of 9 x 9 cells.
        pov_point(pov, scale(lamp.u, 8.0 / 9));
        fputs(", ", out);
        pov_point(pov, scale(lamp.v, 8.0 / 9));
        fprintf(out, ", 9, 9 area_illumination on%s%s\n", lamp.round ? " circular" : "",
                lamp.flat ? "" : " orient");
        if (lamp.flat) { // Lambert's cosine at the lamp
            write_spot_cone(pov, lamp.middle, n, 90, 1);
        } else {
            fputs("}\n\n", out);
        }
    }
}

Rgb pov_area_radiance(const Pov *pov, uint32_t light)
{
    Export *e = pov->e;
    const SceneNode *node = light_node(pov, light);
    Quantity power = export_quantity(e, node, "power");
    bool both = export_bool(e, node, "two_sided");
    Lamp lamp;
    if (power.value > 0) {
        if (!read_lamp(pov, export_id(e, node, "shape"), &lamp)) {
            export_note(e, node->at, "how bright a lamp of this shape looks is left out");
            return rgb_gray(0);
        }
        power.value /= PI * lamp.area * (both ? 2 : 1);
        return export_colored(pov->e, light, power);
    }
    Emission radiance = export_emission(e, node, "radiance");
    Rgb out = rgb_gray(0);
    emission_to_rgb(&radiance, e->scene->light_colors.items[light], &out);
    if (radiance.texture != NONE_ID) {
        export_note(e, node->at, "a texture for `radiance`: its middle color is written");
        out = rgb_mul(out, pov_texture_mean(pov, radiance.texture));
    }
    return out;
}

// Shapes whose material emits.
static void write_emitting_shapes(const Pov *pov)
{
    const Scene *scene = pov->e->scene;
    for (uint32_t id = 0; id < scene->nodes[CATEGORY_SHAPE].count; ++id) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, id);
        Rgb radiance = pov_emitted(pov, node->material);
        if (rgb_is_black(radiance) || (node->flags & NODE_LIGHT_ONLY)) {
            continue;
        }
        if (node->prototype != 0) {
            export_note(pov->e, node->at, "what shines inside an instance lights nothing");
            continue;
        }
        pov_comment(pov, "the light of", node->name, node->at, "");
        write_lamp_light(pov, id, radiance, false, node->at);
    }
}

// --- Surroundings --------------------------------------------------------------------------------

static Rgb surroundings(const Pov *pov)
{
    Export *e = pov->e;
    Rgb sum = rgb_gray(0);
    for (uint32_t id = 0; id < e->scene->nodes[CATEGORY_LIGHT].count; ++id) {
        const SceneNode *node = light_node(pov, id);
        if (!export_is(e, node, "environment_light")) {
            continue;
        }
        Emission radiance = export_emission(e, node, "radiance");
        Rgb color = rgb_gray(0);
        if (export_file(e, node, "image") || radiance.texture != NONE_ID) {
            export_note(e, node->at, "surroundings that are a picture or texture are left out");
            continue;
        }
        emission_to_rgb(&radiance, e->scene->light_colors.items[id], &color);
        sum = rgb_add(sum, color);
        if (!pov->local) {
            export_note(e, node->at, "surroundings are seen, but light nothing");
        }
    }
    return sum;
}

// --- All -----------------------------------------------------------------------------------------

static void write_light(const Pov *pov, uint32_t id, const Affine *map)
{
    const SceneNode *node = light_node(pov, id);
    pov_comment(pov, export_kind(pov->e, node), node->name, node->at, "");
    if (export_is(pov->e, node, "point_light")) {
        write_point(pov, id, map);
    } else if (export_is(pov->e, node, "spot_light")) {
        write_spot(pov, id, map);
    } else if (export_is(pov->e, node, "directional_light")) {
        write_directional(pov, id, map);
    } else if (export_is(pov->e, node, "area_light")) {
        write_lamp_light(pov, export_id(pov->e, node, "shape"), pov_area_radiance(pov, id),
                         export_bool(pov->e, node, "two_sided"), node->at);
    } else {
        export_note(pov->e, node->at, "`%s` has no partner: it is left out",
                    export_kind(pov->e, node));
    }
}

void pov_lights(const Pov *pov)
{
    const Scene *scene = pov->e->scene;
    Rgb around = surroundings(pov);
    fputs("// --- Lights\n\n", pov->e->out);
    if (!rgb_is_black(around)) {
        fputs("background { ", pov->e->out);
        pov_rgb(pov, around);
        fputs(" }\n\n", pov->e->out);
    }
    for (uint32_t id = 0; id < scene->nodes[CATEGORY_LIGHT].count; ++id) {
        const SceneNode *node = light_node(pov, id);
        const Affine *own = export_transform(pov->e, node->transform);
        if (export_is(pov->e, node, "environment_light")) {
            continue;
        }
        if (node->prototype == 0) {
            write_light(pov, id, own);
            continue;
        }
        for (size_t i = 0; i < scene->instances.count; ++i) {
            const SceneInstance *instance = &scene->instances.items[i];
            if (instance->prototype == node->prototype) {
                Affine map = affine_multiply(export_transform(pov->e, instance->transform), own);
                write_light(pov, id, &map);
            }
        }
    }
    write_emitting_shapes(pov);
}

void pov_sum_ambient(Pov *pov)
{
    const Scene *scene = pov->e->scene;
    for (uint32_t id = 0; id < scene->nodes[CATEGORY_LIGHT].count; ++id) {
        const SceneNode *node = light_node(pov, id);
        bool point = export_is(pov->e, node, "point_light");
        Fading fading = point ? fading_of(pov, node) : (Fading){0, 0, 2};
        if (export_is(pov->e, node, "directional_light")) {
            pov->ambient_light = rgb_add(pov->ambient_light, export_irradiance(pov->e, id));
        } else if (point && fading.power == 0) {
            Rgb s = rgb_scale(export_intensity(pov->e, id, 4 * PI), (float)fading.factor);
            pov->ambient_light = rgb_add(pov->ambient_light, s);
        } else if (!export_is(pov->e, node, "environment_light")) {
            pov->ambient_partial = true;
        }
    }
}
