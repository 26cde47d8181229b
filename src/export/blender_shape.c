// Shapes, meshes, prototypes and instances.
#include "export/blender.h"

#include "export/quantities.h"
#include "schema/photometry.h"

#include <string.h>

static const SceneNode *shape_node(const Blender *b, uint32_t shape)
{
    return scene_node(b->e->scene, CATEGORY_SHAPE, shape);
}

// --- Meshes --------------------------------------------------------------------------------------

// Numbers of up to this many bytes stand in the script for people to read.
enum { READABLE = 1024 };

static void write_base64(const Blender *b, const unsigned char *bytes, size_t size)
{
    static const char DIGITS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    FILE *out = b->e->out;
    fputc('"', out);
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        unsigned group = (unsigned)bytes[i] << 16 | (left > 1 ? (unsigned)bytes[i + 1] << 8 : 0) |
                         (left > 2 ? bytes[i + 2] : 0);
        fputc(DIGITS[group >> 18], out);
        fputc(DIGITS[group >> 12 & 63], out);
        fputc(left > 1 ? DIGITS[group >> 6 & 63] : '=', out);
        fputc(left > 2 ? DIGITS[group & 63] : '=', out);
    }
    fputc('"', out);
}

static void write_floats(const Blender *b, const float *values, size_t count)
{
    if (!values) {
        blender_print(b, "None");
    } else if (count * sizeof *values > READABLE) {
        write_base64(b, (const unsigned char *)values, count * sizeof *values);
    } else {
        for (size_t i = 0; i < count; ++i) {
            blender_print(b, i ? ", " : "[");
            blender_number(b, (double)values[i]);
        }
        blender_print(b, "]");
    }
}

static void write_indices(const Blender *b, const uint32_t *values, size_t count)
{
    if (count * sizeof *values > READABLE) {
        write_base64(b, (const unsigned char *)values, count * sizeof *values);
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        blender_print(b, i ? ", %u" : "[%u", (unsigned)values[i]);
    }
    blender_print(b, count ? "]" : "[]");
}

void blender_define_meshes(const Blender *b)
{
    const MeshArray *meshes = &b->e->scene->meshes;
    for (size_t i = 0; i < meshes->count; ++i) {
        const Mesh *mesh = &meshes->items[i];
        size_t n = mesh->vertex_count;
        blender_print(b, "@functools.lru_cache(maxsize=None)\ndef mesh_%zu():\n", i);
        blender_print(b, "    return mesh(\"mesh_%zu\", ", i);
        blender_vec3(b, mesh->origin);
        blender_print(b, ",\n                ");
        write_floats(b, mesh->positions, 3 * n);
        blender_print(b, ",\n                ");
        write_indices(b, mesh->triangles, 3 * (size_t)mesh->triangle_count);
        blender_print(b, ",\n                ");
        write_floats(b, mesh->normals, 3 * n);
        blender_print(b, ",\n                ");
        write_floats(b, mesh->uvs, 2 * n);
        blender_print(b, ",\n                ");
        write_floats(b, mesh->colors, 3 * n);
        blender_print(b, ")\n\n\n");
    }
}

// --- Kinds ---------------------------------------------------------------------------------------

static void tessellated(const Blender *b, const SceneNode *node, const char *error)
{
    export_note(b->e, node->at,
                "`%s` is written as flat pieces, 256 around: they lie within %s of "
                "the surface, and are shaded smoothly",
                export_kind(b->e, node), error);
}

static void vec3_field(const Blender *b, const SceneNode *node, const char *field)
{
    blender_vec3(b, export_vec3(b->e, node, field));
}

static void number_field(const Blender *b, const SceneNode *node, const char *field)
{
    blender_number(b, export_number(b->e, node, field));
}

static void write_frustum(const Blender *b, const SceneNode *node, bool cone)
{
    blender_print(b, "frustum(");
    vec3_field(b, node, "from");
    blender_print(b, ", ");
    vec3_field(b, node, "to");
    blender_print(b, ", ");
    number_field(b, node, cone ? "radius_from" : "radius");
    blender_print(b, ", ");
    number_field(b, node, cone ? "radius_to" : "radius");
    blender_print(b, export_bool(b->e, node, "caps") ? ")" : ", False)");
    tessellated(b, node, "7.6e-5 radii");
}

static void write_plane(const Blender *b, const SceneNode *node)
{
    // Wide enough for the horizon: the eye is seldom higher than the scene is large.
    double reach = 1;
    if (!box3_is_empty(b->box)) {
        reach = fmax(length(sub(b->box.max, b->box.min)), reach);
        reach = fmax(reach, length(sub(b->eye, box3_center(b->box))));
    }
    Affine inverse;
    Vec3 middle = b->eye;
    if (affine_inverse(export_transform(b->e, node->transform), &inverse)) {
        middle = transform_point(&inverse, middle);
    }
    double size = 1e4 * reach;
    export_note(b->e, node->at,
                "`plane` has no end: a square of %.3g m about the camera is written", 2 * size);
    blender_print(b, "plane(");
    vec3_field(b, node, "point");
    blender_print(b, ", ");
    vec3_field(b, node, "normal");
    blender_print(b, ", ");
    blender_number(b, size);
    blender_print(b, ", ");
    blender_vec3(b, middle);
    blender_print(b, ")");
}

static void write_round(const Blender *b, const SceneNode *node)
{
    if (export_is(b->e, node, "disc")) {
        blender_print(b, "disc(");
        vec3_field(b, node, "center");
        blender_print(b, ", ");
        vec3_field(b, node, "normal");
        blender_print(b, ", ");
        number_field(b, node, "radius");
        blender_print(b, ", ");
        number_field(b, node, "inner_radius");
        tessellated(b, node, "7.6e-5 radii");
    } else {
        blender_print(b, "torus(");
        vec3_field(b, node, "center");
        blender_print(b, ", ");
        vec3_field(b, node, "axis");
        blender_print(b, ", ");
        number_field(b, node, "major_radius");
        blender_print(b, ", ");
        number_field(b, node, "minor_radius");
        tessellated(b, node, "7.6e-5 major plus 3.1e-4 minor radii");
    }
    blender_print(b, ")");
}

// The mesh of a shape as an expression. False, and nothing written, where there is none.
static bool write_geometry(const Blender *b, const SceneNode *node, bool unit_sphere, bool shines)
{
    Export *e = b->e;
    const NodeType *type = scene_node_type(e->scene, node);
    if (type->mesh) {
        blender_print(b, "mesh_%u()", (unsigned)type->mesh(scene_params(e->scene, node)));
    } else if (export_is(e, node, "sphere")) {
        tessellated(b, node, "1.6e-4 radii");
        blender_print(b, "sphere(");
        if (!unit_sphere) {
            vec3_field(b, node, "center");
            blender_print(b, ", ");
            number_field(b, node, "radius");
        }
        blender_print(b, ")");
    } else if (export_is(e, node, "box")) {
        blender_print(b, "box(");
        vec3_field(b, node, "min");
        blender_print(b, ", ");
        vec3_field(b, node, "max");
        blender_print(b, ")");
    } else if (export_is(e, node, "plane")) {
        write_plane(b, node);
    } else if (export_is(e, node, "rectangle") || export_is(e, node, "triangle")) {
        bool whole = export_is(e, node, "rectangle");
        blender_print(b, whole ? "rectangle(" : "triangle(");
        vec3_field(b, node, whole ? "corner" : "a");
        blender_print(b, ", ");
        vec3_field(b, node, whole ? "u" : "b");
        blender_print(b, ", ");
        vec3_field(b, node, whole ? "v" : "c");
        blender_print(b, whole && shines ? ", 16)" : ")");
    } else if (export_is(e, node, "cylinder") || export_is(e, node, "cone")) {
        write_frustum(b, node, export_is(e, node, "cone"));
    } else if (export_is(e, node, "disc") || export_is(e, node, "torus")) {
        write_round(b, node);
    } else {
        export_note(e, node->at, "`%s` has no partner: it is left out", type->name);
        return false;
    }
    return true;
}

// --- Shapes --------------------------------------------------------------------------------------

// The material of a shape that stands in an area_light.
static void write_lamp(const Blender *b, uint32_t light, const SceneNode *shape)
{
    Export *e = b->e;
    const SceneNode *node = scene_node(e->scene, CATEGORY_LIGHT, light);
    Quantity power = export_quantity(e, node, "power");
    bool both = export_bool(e, node, "two_sided");
    blender_print(b, "lamp(");
    blender_name(b, "area_light", node->name, node->at);
    if (power.value > 0) {
        blender_print(b, ", lambda n: radiance_of(");
        blender_rgb(b, export_colored(e, light, power));
        blender_print(b, ", data, ");
        blender_matrix(b, export_transform(e, shape->transform));
        blender_print(b, ", %d)", both ? 2 : 1);
        if (shape->prototype != 0) {
            export_note(e, node->at,
                        "a lamp's power in an instance: its radiance is that of the piece itself");
        }
    } else {
        Emission radiance = export_emission(e, node, "radiance");
        Rgb value = rgb_gray(0);
        emission_to_rgb(&radiance, e->scene->light_colors.items[light], &value);
        blender_print(b, ", lambda n: ");
        blender_color_tex(b, (ColorTex){value, radiance.texture});
    }
    if (shape->material != NONE_ID) {
        blender_print(b, ", material_%u", (unsigned)shape->material);
    } else {
        blender_print(b, ", None");
    }
    blender_print(b, both ? ", True)" : ")");
}

static void write_shape(const Blender *b, uint32_t id, const char *indent)
{
    Export *e = b->e;
    const SceneNode *node = shape_node(b, id);
    const Affine *map = export_transform(e, node->transform);
    uint32_t light = blender_light_of_shape(b, id);
    bool shines = light != NONE_ID || blender_emits(b, node->material);
    if (shines && (scene_node_type(e->scene, node)->mesh || export_is(e, node, "triangle") ||
                   export_is(e, node, "box"))) {
        export_note(e, node->at,
                    "a lamp of triangles: Cycles samples large ones up to 1 %% too dark "
                    "where they are seen flat");
    }
    // A lamp's power is spread over the mesh itself.
    bool unit_sphere = export_is(e, node, "sphere") && light == NONE_ID &&
                       !blender_uses_object_space(b, node->material);
    blender_comment(b, indent, export_kind(e, node), node->name, node->at);
    blender_print(b, "%sdata = ", indent);
    if (!write_geometry(b, node, unit_sphere, shines)) {
        blender_print(b, "None\n\n");
        return;
    }
    blender_print(b, "\n%sshape(into, ", indent);
    blender_name(b, export_kind(e, node), node->name, node->at);
    blender_print(b, ", data, ");
    if (light != NONE_ID) {
        if (b->local) {
            export_note(e, node->at, "a light with a size is one, not a point in its middle");
        }
        write_lamp(b, light, node);
    } else if (node->material != NONE_ID) {
        blender_print(b, "use(material_%u)", (unsigned)node->material);
    } else {
        blender_print(b, "material");
    }
    if (!affine_is_identity(map) || unit_sphere) {
        blender_print(b, ", ");
        blender_matrix(b, map);
    }
    if (unit_sphere) {
        blender_print(b, ", (");
        vec3_field(b, node, "center");
        blender_print(b, ", ");
        number_field(b, node, "radius");
        blender_print(b, ")");
    }
    blender_print(b, ")\n\n");
}

void blender_shapes(const Blender *b, uint32_t prototype, const char *indent)
{
    const Scene *scene = b->e->scene;
    for (uint32_t id = 0; id < scene->nodes[CATEGORY_SHAPE].count; ++id) {
        if (shape_node(b, id)->prototype == prototype) {
            write_shape(b, id, indent);
        }
    }
}

void blender_define_prototypes(const Blender *b)
{
    const Scene *scene = b->e->scene;
    for (uint32_t p = 1; p < scene->prototypes.count; ++p) {
        const Prototype *prototype = &scene->prototypes.items[p];
        blender_print(b, "def prototype_%u(into, material):\n", (unsigned)p);
        blender_comment(b, "    ", "a piece that is placed many times", prototype->name,
                        prototype->at);
        blender_shapes(b, p, "    ");
        blender_lights(b, p, "    ");
        blender_print(b, "    return into\n\n\n");
    }
}

void blender_instances(const Blender *b, const char *indent)
{
    const Scene *scene = b->e->scene;
    for (size_t i = 0; i < scene->instances.count; ++i) {
        const SceneInstance *instance = &scene->instances.items[i];
        blender_comment(b, indent, "instance", instance->name, instance->at);
        blender_print(b, "%sinstance(prototype_%u, ", indent, (unsigned)instance->prototype);
        blender_name(b, "instance", instance->name, instance->at);
        if (instance->material == NONE_ID) {
            blender_print(b, ", None, ");
        } else {
            blender_print(b, ", use(material_%u), ", (unsigned)instance->material);
        }
        blender_matrix(b, export_transform(b->e, instance->transform));
        blender_print(b, ")\n\n");
    }
}
