#include "export/quantities.h"

#include "base/mem.h"
#include "schema/photometry.h"

#include <string.h>

// --- Lights --------------------------------------------------------------------------------------

static const SceneNode *light_node(const Export *e, uint32_t light)
{
    return scene_node(e->scene, CATEGORY_LIGHT, light);
}

Rgb export_colored(Export *e, uint32_t light, Quantity quantity)
{
    Rgb out = rgb_gray(0);
    quantity_to_rgb(quantity, e->scene->light_colors.items[light], &out);
    return out;
}

Rgb export_intensity(Export *e, uint32_t light, double steradians)
{
    const SceneNode *node = light_node(e, light);
    Quantity power = export_quantity(e, node, "power");
    if (power.value > 0) { // one of the two is given, the other 0
        power.value /= steradians;
        return export_colored(e, light, power);
    }
    return export_colored(e, light, export_quantity(e, node, "intensity"));
}

Rgb export_irradiance(Export *e, uint32_t light)
{
    Emission irradiance = export_emission(e, light_node(e, light), "irradiance");
    Rgb out = rgb_gray(0);
    emission_to_rgb(&irradiance, e->scene->light_colors.items[light], &out);
    return out;
}

double export_cone_steradians(double inner, double outer)
{
    // ∫ (1 - (θ - θ0)/Δ)² sin θ dθ from θ0 to θ1 = cos θ0 + 2 sin θ0/Δ - 2 (cos θ0 - cos θ1)/Δ²
    double width = outer - inner;
    double difference = 2 * sin((outer + inner) / 2) * sin(width / 2);
    double soft = cos(inner) + 2 * (sin(inner) - difference / width) / width;
    return 2 * PI * (2 * pow(sin(inner / 2), 2) + soft);
}

double export_falloff_steradians(Export *e, const SceneNode *falloff)
{
    if (falloff && export_is(e, falloff, "cosine_lobe")) {
        return 2 * PI / (export_number(e, falloff, "exponent") + 1);
    }
    if (falloff && export_is(e, falloff, "smooth_cone")) {
        return export_cone_steradians(export_number(e, falloff, "inner"),
                                      export_number(e, falloff, "outer"));
    }
    return 4 * PI;
}

Vec3 export_spot_axis(Export *e, const SceneNode *light)
{
    Vec3 axis = export_vec3(e, light, "direction");
    if (!(length_squared(axis) > 0)) {
        axis = sub(export_vec3(e, light, "target"), export_vec3(e, light, "position"));
    }
    return axis;
}

// --- Camera --------------------------------------------------------------------------------------

// What the renderer looks through where a scene has no camera (render/cameras/camera.c).
static ExportView default_view(Export *e, Box3 bounds, double aspect)
{
    export_note(e, (Span){0, 0, 0}, "the scene has no camera: one that sees all is written");
    if (box3_is_empty(bounds)) {
        bounds = (Box3){{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
    }
    double radius = fmax(length(sub(bounds.max, bounds.min)) / 2, 1e-9);
    double fov = 40 * PI / 180, half = tan(fov / 2), angle = atan(half * fmin(1, aspect));
    Vec3 middle = box3_center(bounds), from = normalize(vec3(0.5, 0.4, 1));
    Vec3 eye = add_scaled(middle, from, 1.05 * radius / sin(angle));
    ExportView view = {.projection = "perspective", .fov = fov, .half_height = half};
    if (!affine_look_at(eye, middle, vec3(0, 1, 0), &view.frame)) {
        view.frame = affine_translation(eye);
    }
    return view;
}

ExportView export_view(Export *e, Box3 bounds, double aspect)
{
    if (e->scene->camera == NONE_ID) {
        return default_view(e, bounds, aspect);
    }
    const SceneNode *node = scene_node(e->scene, CATEGORY_CAMERA, e->scene->camera);
    ExportView view = {.node = node,
                       .projection = export_choice(e, node, "projection"),
                       .fov = export_number(e, node, "fov"),
                       .aperture = export_number(e, node, "aperture"),
                       .focus = export_number(e, node, "focus_distance")};
    bool flat = strcmp(view.projection, "orthographic") == 0;
    view.half_height = flat ? export_number(e, node, "height") / 2 : tan(view.fov / 2);
    Vec3 position = export_vec3(e, node, "position");
    Affine frame;
    if (!affine_look_at(vec3(0, 0, 0), export_vec3(e, node, "direction"),
                        export_vec3(e, node, "up"), &frame)) {
        frame = affine_identity();
    }
    frame.m[0][3] = position.x, frame.m[1][3] = position.y, frame.m[2][3] = position.z;
    view.frame = affine_multiply(export_transform(e, node->transform), &frame);
    return view;
}

// --- Bounds --------------------------------------------------------------------------------------

static bool is_bounded(Box3 box)
{
    return !box3_is_empty(box) && vec3_is_finite(box.min) && vec3_is_finite(box.max);
}

Box3 export_scene_box(const Scene *scene)
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
