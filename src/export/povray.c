// A scene for POV-Ray 3.7: its head, its camera, and the order of the rest.
#include "export/pov.h"
#include "export/targets.h"

#include "base/mem.h"

#include <inttypes.h>
#include <string.h>

// --- Camera --------------------------------------------------------------------------------------

static Vec3 column(const Affine *map, int i)
{
    return vec3(map->m[0][i], map->m[1][i], map->m[2][i]);
}

static void write_view(const Pov *pov, const Affine *frame, double half_width, double half_height)
{
    FILE *out = pov->e->out;
    fputs("  location ", out);
    pov_point(pov, column(frame, 3));
    fputs("\n  right ", out);
    pov_point(pov, scale(column(frame, 0), 2 * half_width));
    fputs("\n  up ", out);
    pov_point(pov, scale(column(frame, 1), 2 * half_height));
    fputs("\n  direction ", out);
    pov_point(pov, neg(column(frame, 2)));
    fputs("\n}\n\n", out);
}

static void write_lens(const Pov *pov, const SceneNode *node, const Affine *frame)
{
    double aperture = export_number(pov->e, node, "aperture");
    if (!(aperture > 0)) {
        return;
    }
    export_note(pov->e, node->at,
                "POV-Ray's lens blurs by its own law: the plane in focus is the same, the blur "
                "about as large");
    FILE *out = pov->e->out;
    double focus = export_number(pov->e, node, "focus_distance");
    fputs("  aperture ", out);
    pov_number(pov, 2 * aperture);
    fputs(" focal_point ", out);
    pov_point(pov, sub(column(frame, 3), scale(column(frame, 2), focus)));
    fputs(" blur_samples 64 variance 0\n", out);
}

static void write_camera(const Pov *pov, const SceneNode *node, double aspect)
{
    Export *e = pov->e;
    FILE *out = e->out;
    const char *projection = export_choice(e, node, "projection");
    Vec3 position = export_vec3(e, node, "position");
    Affine frame, whole;
    double fov = export_number(e, node, "fov"), half = tan(fov / 2);
    if (!affine_look_at(vec3(0, 0, 0), export_vec3(e, node, "direction"),
                        export_vec3(e, node, "up"), &frame)) {
        frame = affine_identity();
    }
    frame.m[0][3] = position.x, frame.m[1][3] = position.y, frame.m[2][3] = position.z;
    whole = affine_multiply(export_transform(e, node->transform), &frame);
    pov_comment(pov, "camera", node->name, node->at, "");
    if (strcmp(projection, "orthographic") == 0) {
        half = export_number(e, node, "height") / 2;
        fputs("camera {\n  orthographic\n", out);
    } else if (strcmp(projection, "perspective") == 0) {
        fputs("camera {\n  perspective // vertical field of view: ", out);
        pov_number(pov, fov * 180 / PI);
        fputs(" degrees\n", out);
        write_lens(pov, node, &whole);
    } else if (strcmp(projection, "panorama") == 0) {
        half = 0.5;
        fputs("camera {\n  spherical angle 360 180\n", out);
    } else {
        half = 0.5;
        export_note(e, node->at, "POV-Ray's fisheye is dark beyond its circle");
        fputs("camera {\n  fisheye angle ", out);
        pov_number(pov, fov * 180 / PI);
        fputc('\n', out);
    }
    write_view(pov, &whole, half * aspect, half);
}

// What the renderer looks through where a scene has no camera (render/cameras/camera.c).
static void write_default_camera(const Pov *pov, Box3 bounds, double aspect)
{
    export_note(pov->e, (Span){0, 0, 0}, "the scene has no camera: one that sees all is written");
    if (box3_is_empty(bounds)) {
        bounds = (Box3){{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
    }
    double radius = fmax(length(sub(bounds.max, bounds.min)) / 2, 1e-9);
    double half = tan(20 * PI / 180), angle = atan(half * fmin(1, aspect));
    Vec3 middle = box3_center(bounds), from = normalize(vec3(0.5, 0.4, 1));
    Vec3 eye = add_scaled(middle, from, 1.05 * radius / sin(angle));
    Affine frame;
    if (!affine_look_at(eye, middle, vec3(0, 1, 0), &frame)) {
        frame = affine_translation(eye);
    }
    fputs("camera {\n  perspective\n", pov->e->out);
    write_view(pov, &frame, half * aspect, half);
}

// --- Bounds --------------------------------------------------------------------------------------

static bool is_bounded(Box3 box)
{
    return !box3_is_empty(box) && vec3_is_finite(box.min) && vec3_is_finite(box.max);
}

// The box of what is finite; empty without memory, or where nothing is.
static Box3 scene_box(const Scene *scene)
{
    size_t count = scene->prototypes.count;
    Box3 *boxes = mem_alloc(count, sizeof *boxes), all = box3_empty();
    if (!boxes) {
        return all;
    }
    for (size_t i = 0; i < count; ++i) {
        boxes[i] = box3_empty();
    }
    for (uint32_t id = 0; id < scene->nodes[CATEGORY_SHAPE].count; ++id) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, id);
        const NodeType *type = scene_node_type(scene, node);
        Box3 box = type->bounds ? type->bounds(scene, scene_params(scene, node)) : box3_empty();
        if (is_bounded(box)) {
            box = transform_box(&scene->transforms.items[node->transform], box);
            boxes[node->prototype] = box3_union(boxes[node->prototype], box);
        }
    }
    all = boxes[0];
    for (size_t i = 0; i < scene->instances.count; ++i) {
        const SceneInstance *instance = &scene->instances.items[i];
        if (is_bounded(boxes[instance->prototype])) {
            all = box3_union(all, transform_box(&scene->transforms.items[instance->transform],
                                                boxes[instance->prototype]));
        }
    }
    mem_free(boxes);
    return all;
}

static double box_radius(Box3 box)
{
    return box3_is_empty(box) ? 1 : fmax(length(box.min), length(box.max));
}

// --- The file ------------------------------------------------------------------------------------

static void check_integrator(const Pov *pov, const char *integrator, int64_t bounces)
{
    Span nowhere = {0, 0, 0};
    if (strcmp(integrator, "path") == 0 && bounces > 1) {
        export_note(pov->e, nowhere,
                    "global illumination has no partner: direct light, mirrors and refraction "
                    "only, as in the integrator \"direct\"");
    } else if (!pov->local && strcmp(integrator, "path") != 0 &&
               strcmp(integrator, "direct") != 0) {
        export_note(pov->e, nowhere, "the integrator \"%s\" has no partner: \"direct\" is written",
                    integrator);
    }
}

static void write_head(const Pov *pov, int64_t width, int64_t height, const char *integrator)
{
    FILE *out = pov->e->out;
    fprintf(out, "// %s, for POV-Ray 3.7: written by scnrender from integrator \"%s\".\n",
            pov->e->title, integrator);
    fprintf(out,
            "// Render it with one ray a pixel into a linear picture:\n"
            "//     povray +I<this file> +W%" PRId64 " +H%" PRId64 " +FE -A -D\n"
            "// Lights are written as %s; z is mirrored.\n",
            width, height,
            pov->local ? "their intensity, since `local` takes the raw expressions"
                       : "their intensity over pi, which POV-Ray's diffuse lacks");
    if (pov->e->notes->list.count == 0) {
        fputs("// All of the scene has an exact partner.\n", out);
    } else {
        fputs("// What has no exact partner:\n", out);
        export_write_notes(pov->e, "//   ");
    }
    fputs("\n#version 3.7;\n", out);
}

void povray_write(Export *e)
{
    char integrator[64];
    int64_t width = export_setting_int(e, "film", "width");
    int64_t height = export_setting_int(e, "film", "height");
    int64_t bounces = export_setting_int(e, "render", "bounces");
    export_setting_choice(e, "render", "integrator", integrator, sizeof integrator);
    Box3 box = scene_box(e->scene);
    Pov pov = {.e = e, .local = strcmp(integrator, "local") == 0, .radius = box_radius(box)};
    pov.shadows = !pov.local || export_setting_bool(e, "render", "shadows");
    pov.light_scale = pov.local ? 1 : 1 / PI;
    pov_sum_ambient(&pov);
    check_integrator(&pov, integrator, bounces);
    write_head(&pov, width, height, integrator);
    // The bailout is that of the integrator `direct`: fainter branches are cut off.
    int64_t level = pov.local ? 1 : bounces < 1 ? 1 : bounces > 256 ? 256 : bounces;
    fprintf(e->out, "global_settings { assumed_gamma 1 adc_bailout 0.0001 max_trace_level %d }\n\n",
            (int)level);
    double aspect = (double)width / (double)(height > 0 ? height : 1);
    if (e->scene->camera == NONE_ID) {
        write_default_camera(&pov, box, aspect);
    } else {
        write_camera(&pov, scene_node(e->scene, CATEGORY_CAMERA, e->scene->camera), aspect);
    }
    pov_declare_materials(&pov);
    pov_declare_meshes(&pov);
    pov_declare_prototypes(&pov);
    pov_lights(&pov);
    pov_shapes(&pov);
}
