// Lights and surroundings. The laws of angle and distance are nodes in the lights.
#include "export/blender.h"

#include "export/quantities.h"
#include "scene/ies.h"
#include "schema/photometry.h"

#include <string.h>

static Rgb scaled(const Blender *b, Rgb light)
{
    return rgb_scale(light, (float)b->lights);
}

// ", True)" or ", False)": whether it casts shadows; ends a call.
static void close_with_shadows(const Blender *b)
{
    blender_print(b, b->shadows ? ")\n\n" : ", shadows=False)\n\n");
}

// --- Laws ----------------------------------------------------------------------------------------

// "n.window(1, 4)"; false, and nothing written, for the natural law.
static bool write_attenuation(const Blender *b, const SceneNode *light, const char *before)
{
    uint32_t id = export_id(b->e, light, "attenuation");
    const SceneNode *node =
        id == NONE_ID ? NULL : scene_node(b->e->scene, CATEGORY_ATTENUATION, id);
    if (!node || export_is(b->e, node, "inverse_square")) {
        return false;
    }
    if (export_is(b->e, node, "constant")) {
        blender_print(b, "%sn.constant()", before);
    } else if (export_is(b->e, node, "polynomial")) {
        blender_print(b, "%sn.polynomial(", before);
        blender_number(b, export_number(b->e, node, "a"));
        blender_print(b, ", ");
        blender_number(b, export_number(b->e, node, "b"));
        blender_print(b, ", ");
        blender_number(b, export_number(b->e, node, "c"));
        blender_print(b, ")");
    } else if (export_is(b->e, node, "window")) {
        blender_print(b, "%sn.window(", before);
        blender_number(b, export_number(b->e, node, "start"));
        blender_print(b, ", ");
        blender_number(b, export_number(b->e, node, "end"));
        blender_print(b, ")");
    } else {
        export_note(b->e, light->at, "the attenuation `%s` has no partner: 1/r^2 is written",
                    export_kind(b->e, node));
        return false;
    }
    return true;
}

static void write_falloff(const Blender *b, const SceneNode *light, const SceneNode *falloff)
{
    if (falloff && export_is(b->e, falloff, "cosine_lobe")) {
        blender_print(b, "n.cosine_lobe(");
        blender_number(b, export_number(b->e, falloff, "exponent"));
        blender_print(b, ")");
    } else if (falloff && export_is(b->e, falloff, "smooth_cone")) {
        blender_print(b, "n.smooth_cone(");
        blender_number(b, export_number(b->e, falloff, "inner"));
        blender_print(b, ", ");
        blender_number(b, export_number(b->e, falloff, "outer"));
        blender_print(b, ")");
    } else {
        export_note(b->e, light->at, "the falloff of this light has no partner: none is written");
        blender_print(b, "1.0");
    }
}

// --- Kinds ---------------------------------------------------------------------------------------

static void begin(const Blender *b, const char *function, const SceneNode *node, Vec3 place)
{
    blender_print(b, "%s(into, ", function);
    blender_name(b, export_kind(b->e, node), node->name, node->at);
    blender_print(b, ", ");
    blender_vec3(b, place);
    blender_print(b, ", ");
}

static void write_point(const Blender *b, uint32_t id, const SceneNode *node, const Affine *map)
{
    begin(b, "point_light", node, transform_point(map, export_vec3(b->e, node, "position")));
    blender_rgb(b, scaled(b, export_intensity(b->e, id, 4 * PI)));
    if (write_attenuation(b, node, ", lambda n: [")) {
        blender_print(b, "]");
    }
    close_with_shadows(b);
}

static void write_spot(const Blender *b, uint32_t id, const SceneNode *node, const Affine *map)
{
    Export *e = b->e;
    uint32_t law = export_id(e, node, "falloff");
    const SceneNode *falloff = law == NONE_ID ? NULL : scene_node(e->scene, CATEGORY_FALLOFF, law);
    begin(b, "spot_light", node, transform_point(map, export_vec3(e, node, "position")));
    blender_vec3(b, normalize(transform_vector(map, export_spot_axis(e, node))));
    blender_print(b, ", ");
    blender_rgb(b, scaled(b, export_intensity(e, id, export_falloff_steradians(e, falloff))));
    blender_print(b, ", lambda n: [");
    write_falloff(b, node, falloff);
    write_attenuation(b, node, ", ");
    blender_print(b, "]");
    close_with_shadows(b);
}

static void write_directional(const Blender *b, uint32_t id, const SceneNode *node,
                              const Affine *map)
{
    double angle = export_number(b->e, node, "angle");
    Vec3 travel = normalize(transform_vector(map, export_vec3(b->e, node, "direction")));
    if (angle > 0) {
        export_note(b->e, node->at, "the disc of a light with an `angle` isn't seen by the camera");
    }
    begin(b, "directional_light", node, travel);
    blender_rgb(b, scaled(b, export_irradiance(b->e, id)));
    blender_print(b, ", ");
    blender_number(b, angle);
    close_with_shadows(b);
}

// --- Photometric ---------------------------------------------------------------------------------

enum { VERTICAL_STEPS = 360, HORIZONTAL_STEPS = 144 };

// The table as candelas of type C at even angles, as parts of 1000 of `largest`: Cycles reads type
// C alone, and interpolates cubically between the angles.
static void write_table(const Blender *b, const IesWeb *web, double largest)
{
    bool round = web->type == IES_TYPE_C && web->symmetry == IES_ROTATIONAL;
    int horizontal = round ? 0 : HORIZONTAL_STEPS, vertical = VERTICAL_STEPS;
    blender_print(b, "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 %d %d 1 2 0 0 0\n1 1 0\n", vertical + 1,
                  horizontal + 1);
    for (int i = 0; i <= vertical; ++i) {
        blender_print(b, "%g%s", 180.0 * i / vertical, i % 20 == 19 || i == vertical ? "\n" : " ");
    }
    for (int i = 0; i <= horizontal; ++i) {
        blender_print(b, "%g%s", round ? 0 : 360.0 * i / horizontal,
                      i % 20 == 19 || i == horizontal ? "\n" : " ");
    }
    for (int h = 0; h <= horizontal; ++h) {
        double c = round ? 0 : 2 * PI * h / horizontal;
        for (int v = 0; v <= vertical; ++v) {
            double angle = PI * v / vertical, s = sin(angle);
            double candela = ies_candela(web, cos(angle), s * cos(c), -s * sin(c));
            blender_print(b, "%.6g%s", largest > 0 ? 1000 * candela / largest : 0,
                          v % 12 == 11 || v == vertical ? "\n" : " ");
        }
    }
}

static double largest_candela(const IesWeb *web)
{
    double largest = 0;
    size_t count = (size_t)web->vertical_count * web->horizontal_count;
    for (size_t i = 0; i < count; ++i) {
        largest = fmax(largest, web->candela[i]);
    }
    return largest;
}

// In the world's terms the luminaire's straight down is -y: TILT counts from there.
static double tilt_factor(const IesWeb *web, Vec3 d, Vec3 u)
{
    Vec3 zero = web->type == IES_TYPE_A ? neg(u) : d;
    return ies_tilt_factor(web, acos(fmin(fmax(-zero.y, -1), 1)));
}

static void write_web(const Blender *b, uint32_t id, const SceneNode *node, const Affine *map,
                      const IesWeb *web, const char *indent)
{
    Vec3 d = normalize(transform_vector(map, export_vec3(b->e, node, "direction")));
    Vec3 up = transform_vector(map, export_vec3(b->e, node, "up"));
    Vec3 u = normalize(add_scaled(up, d, -dot(up, d))), s = cross(d, u);
    bool mirrored = affine_determinant(map) < 0;
    double largest = largest_candela(web);
    Quantity candela = {export_number(b->e, node, "scale") * tilt_factor(web, d, u),
                        DIM_LUMINOUS_INTENSITY};
    blender_print(b, "web = \"\"\"");
    write_table(b, web, largest);
    blender_print(b, "\"\"\"  # in parts of 1000 of %g cd\n%s", largest, indent);
    begin(b, "point_light", node, transform_point(map, export_vec3(b->e, node, "position")));
    blender_rgb(b, scaled(b, export_colored(b->e, id, candela)));
    blender_print(b, ", lambda n: [n.photometric(web, ");
    blender_number(b, largest);
    blender_print(b, ", %s)", mirrored ? "True" : "False");
    write_attenuation(b, node, ", ");
    // The light's axes: it looks along -z, and its -y is the file's u.
    blender_print(b, "], %s, (", b->shadows ? "True" : "False");
    blender_vec3(b, neg(s));
    blender_print(b, ", ");
    blender_vec3(b, neg(u));
    blender_print(b, ", ");
    blender_vec3(b, neg(d));
    blender_print(b, "))\n\n");
}

static void write_photometric(const Blender *b, uint32_t id, const SceneNode *node,
                              const Affine *map, const char *indent)
{
    const char *file = export_file(b->e, node, "file");
    FileBytes bytes;
    IesError error;
    Arena arena = {0};
    const IesWeb *web = NULL;
    if (file && sandbox_read(b->e->scene->sandbox, file, &bytes) == IO_OK) {
        web = ies_read(&arena, (Str){bytes.bytes, bytes.size}, &error);
        file_bytes_free(&bytes);
    }
    if (web) {
        export_note(b->e, node->at,
                    "a photometric file is written as a table of steps of %g degrees, between "
                    "which Cycles interpolates cubically",
                    180.0 / VERTICAL_STEPS);
        write_web(b, id, node, map, web, indent);
    } else {
        export_note(b->e, node->at, "the photometric file can't be read: the light is left out");
        blender_print(b, "# left out\n\n");
    }
    arena_free(&arena);
}

// --- Surroundings --------------------------------------------------------------------------------

static bool is_rotation(const Affine *map)
{
    return fabs(fabs(affine_determinant(map)) - 1) < 1e-6;
}

static void write_environment(const Blender *b, uint32_t id, const SceneNode *node)
{
    Export *e = b->e;
    const char *file = export_file(e, node, "image");
    Emission radiance = export_emission(e, node, "radiance");
    const Affine *map = export_transform(e, node->transform);
    Rgb color = rgb_gray(0);
    emission_to_rgb(&radiance, e->scene->light_colors.items[id], &color);
    if (radiance.texture != NONE_ID) {
        export_note(e, node->at,
                    "a texture for the `radiance` of surroundings: gray 0.5 of it is "
                    "written");
        color = rgb_scale(color, 0.5f);
    }
    blender_print(b, "background(n, ");
    blender_rgb(b, color);
    if (file) {
        blender_print(b, ", ");
        blender_string(b, file);
        blender_print(b, ", ");
        blender_number(b, export_number(e, node, "rotation"));
        if (!affine_is_identity(map)) {
            if (!is_rotation(map)) {
                export_note(e, node->at, "a transform of surroundings other than a rotation");
            }
            blender_print(b, ", (");
            for (int i = 0; i < 3; ++i) { // the inverse of a rotation: its columns as rows
                blender_print(b, i ? ", " : "");
                blender_vec3(b, vec3(map->m[0][i], map->m[1][i], map->m[2][i]));
            }
            blender_print(b, ")");
        }
    }
    blender_print(b, ")");
}

void blender_surroundings(const Blender *b, const char *indent)
{
    const SceneNodeArray *lights = &b->e->scene->nodes[CATEGORY_LIGHT];
    uint32_t count = 0;
    for (uint32_t id = 0; id < lights->count; ++id) {
        count += export_is(b->e, &lights->items[id], "environment_light");
    }
    if (count == 0) {
        blender_print(b, "%ssurroundings(lambda n: background(n, (0, 0, 0)))\n\n", indent);
        return;
    }
    blender_print(b, "%ssurroundings(lambda n: ", indent);
    uint32_t done = 0;
    for (uint32_t id = 0; id < lights->count; ++id) {
        const SceneNode *node = &lights->items[id];
        if (!export_is(b->e, node, "environment_light")) {
            continue;
        }
        blender_print(b, ++done < count ? "n.sum(" : "");
        if (b->local) {
            export_note(b->e, node->at,
                        "surroundings light the scene, which they don't in `local`");
        }
        write_environment(b, id, node);
        blender_print(b, done < count ? ", " : "");
    }
    for (uint32_t i = 1; i < count; ++i) {
        blender_print(b, ")");
    }
    blender_print(b, ")\n\n");
}

// --- All -----------------------------------------------------------------------------------------

uint32_t blender_light_of_shape(const Blender *b, uint32_t shape)
{
    const SceneNodeArray *lights = &b->e->scene->nodes[CATEGORY_LIGHT];
    for (uint32_t id = 0; id < lights->count; ++id) {
        const SceneNode *light = &lights->items[id];
        if (export_is(b->e, light, "area_light") && export_id(b->e, light, "shape") == shape) {
            return id;
        }
    }
    return NONE_ID;
}

void blender_lights(const Blender *b, uint32_t prototype, const char *indent)
{
    const SceneNodeArray *lights = &b->e->scene->nodes[CATEGORY_LIGHT];
    for (uint32_t id = 0; id < lights->count; ++id) {
        const SceneNode *node = &lights->items[id];
        const Affine *map = export_transform(b->e, node->transform);
        if (node->prototype != prototype || export_is(b->e, node, "environment_light") ||
            export_is(b->e, node, "area_light")) { // these are shapes
            continue;
        }
        blender_comment(b, indent, export_kind(b->e, node), node->name, node->at);
        blender_print(b, "%s", indent);
        if (export_is(b->e, node, "point_light")) {
            write_point(b, id, node, map);
        } else if (export_is(b->e, node, "spot_light")) {
            write_spot(b, id, node, map);
        } else if (export_is(b->e, node, "directional_light")) {
            write_directional(b, id, node, map);
        } else if (export_is(b->e, node, "photometric_light")) {
            write_photometric(b, id, node, map, indent);
        } else {
            export_note(b->e, node->at, "`%s` has no partner: it is left out",
                        export_kind(b->e, node));
            blender_print(b, "# left out\n\n");
        }
    }
}
