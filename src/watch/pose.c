#include "watch/pose.h"

#include "lang/lang.h"

#include <math.h>
#include <string.h>

// How near to the poles a camera may be turned, so that it never looks along `up`.
static const double FARTHEST_UP = 89 * PI / 180;

static Vec3 column(const Affine *map, int i)
{
    return vec3(map->m[0][i], map->m[1][i], map->m[2][i]);
}

double pose_own_distance(const Camera *camera)
{
    const CameraParams *params = &camera->params;
    Vec3 to = sub(params->look_at, params->position);
    double distance = length(to);
    // A `look_at` that wasn't given is 0, which hardly ever lies in the very direction of the view.
    Vec3 along = neg(column(&params->frame, 2));
    bool own = distance > 0 && length(sub(scale(to, 1 / distance), along)) < 1e-9;
    return own ? distance * length(column(&camera->to_world, 2)) : 0;
}

CameraPose pose_from_camera(const Camera *camera, double distance)
{
    const CameraParams *params = &camera->params;
    Vec3 back = column(&camera->to_world, 2);
    double size = length(back); // the transform's scale; the frame itself is orthonormal
    CameraPose pose = {.position = column(&camera->to_world, 3),
                       .fov = params->fov,
                       .height = params->height * size,
                       .aperture = params->aperture * size,
                       .projection = params->projection};
    pose.target = add_scaled(pose.position, normalize(back), -distance);
    // The author's own `up` where the picture stays upright with it, else the picture's.
    Vec3 top = normalize(column(&camera->to_world, 1)), up = params->up;
    Vec3 right = normalize(column(&camera->to_world, 0));
    bool kept =
        length_squared(up) > 0 && fabs(dot(normalize(up), right)) < 1e-9 && dot(up, top) > 0;
    pose.up = kept ? normalize(up) : top;
    double focus = params->focus_distance * size;
    bool usual = fabs(focus - distance) < 1e-9 * distance;
    pose.focus_distance = pose.aperture > 0 && !usual ? focus : 0;
    return pose;
}

// --- Moves ---------------------------------------------------------------------------------------

void pose_orbit(CameraPose *pose, double right, double up)
{
    Vec3 arm = sub(pose->position, pose->target);
    double distance = length(arm);
    double sine = fmax(-1, fmin(1, dot(arm, pose->up) / distance));
    double from = asin(sine), to = fmax(-FARTHEST_UP, fmin(FARTHEST_UP, from + up));
    Vec3 level = add_scaled(arm, pose->up, -dot(arm, pose->up));
    if (!(length(level) > 1e-12 * distance)) {
        level = frame_from_normal(pose->up).s;
    }
    Affine turn = affine_rotation(pose->up, right);
    level = transform_vector(&turn, normalize(level));
    pose->position = add_scaled(add_scaled(pose->target, level, distance * cos(to)), pose->up,
                                distance * sin(to));
}

void pose_pan(CameraPose *pose, double right, double up)
{
    Affine view;
    if (!affine_look_at(pose->position, pose->target, pose->up, &view)) {
        return;
    }
    double distance = length(sub(pose->target, pose->position));
    double shown = pose->projection == CAMERA_PERSPECTIVE    ? 2 * distance * tan(pose->fov / 2)
                   : pose->projection == CAMERA_ORTHOGRAPHIC ? pose->height
                                                             : distance;
    Vec3 by = add(scale(column(&view, 0), right * shown), scale(column(&view, 1), up * shown));
    pose->position = add(pose->position, by);
    pose->target = add(pose->target, by);
}

void pose_dolly(CameraPose *pose, double factor)
{
    pose->position = add_scaled(pose->target, sub(pose->position, pose->target), factor);
    pose->height *= factor;
}

// --- As text -------------------------------------------------------------------------------------

// With `digits` after the point, and no zeros at the end.
static void add_number(Text *text, double value, int digits)
{
    char number[400];
    int length = snprintf(number, sizeof number, "%.*f", digits, value);
    if (strchr(number, '.')) {
        while (number[length - 1] == '0') {
            number[--length] = '\0';
        }
        if (number[length - 1] == '.') {
            number[--length] = '\0';
        }
    }
    text_print(text, "%s", strcmp(number, "-0") == 0 ? "0" : number);
}

static void add_vector(Text *text, Vec3 v, int digits)
{
    for (int i = 0; i < 3; ++i) {
        text_print(text, i ? ", " : "(");
        add_number(text, vec3_get(v, i), digits);
    }
    text_print(text, ")");
}

static const char *projection_name(const Schema *schema, int32_t projection)
{
    const NodeType *camera = schema->types[schema_find(schema, STR("camera"))];
    return camera->params[node_type_find_param(camera, STR("projection"))].choices[projection];
}

// Digits after the point for a step of a ten-thousandth of `size`.
static int digits_for(double size)
{
    double digits = ceil(4 - log10(size));
    return digits > 0 ? digits < 15 ? (int)digits : 15 : 0;
}

void pose_text(const CameraPose *pose, const Schema *schema, Text *text)
{
    double distance = length(sub(pose->target, pose->position));
    int digits = digits_for(distance);
    text_print(text, "camera { position: ");
    add_vector(text, pose->position, digits);
    text_print(text, ", look_at: ");
    add_vector(text, pose->target, digits);
    if (pose->up.x != 0 || pose->up.y != 1 || pose->up.z != 0) {
        text_print(text, ", up: ");
        add_vector(text, pose->up, 6);
    }
    if (pose->projection != CAMERA_PERSPECTIVE) {
        text_print(text, ", projection: \"%s\"", projection_name(schema, pose->projection));
    }
    if (pose->projection == CAMERA_ORTHOGRAPHIC) {
        text_print(text, ", height: ");
        add_number(text, pose->height, digits_for(pose->height));
    } else if (pose->projection != CAMERA_PANORAMA) {
        text_print(text, ", fov: ");
        add_number(text, pose->fov * 180 / PI, 4);
        text_print(text, "deg");
    }
    if (pose->aperture > 0) {
        text_print(text, ", aperture: ");
        add_number(text, pose->aperture, digits_for(pose->aperture));
    }
    if (pose->focus_distance > 0) {
        text_print(text, ", focus_distance: ");
        add_number(text, pose->focus_distance, digits_for(pose->focus_distance));
    }
    text_print(text, " }");
}

static bool take_camera(const Scene *scene, CameraParams *out, char *message, size_t message_size)
{
    if (scene->nodes[CATEGORY_CAMERA].count != 1) {
        snprintf(message, message_size, "the text describes %zu cameras, not one",
                 scene->nodes[CATEGORY_CAMERA].count);
        return false;
    }
    const SceneNode *node = scene_node(scene, CATEGORY_CAMERA, 0);
    *out = *(const CameraParams *)scene_params(scene, node);
    out->frame = affine_multiply(&scene->transforms.items[node->transform], &out->frame);
    return true;
}

bool camera_from_text(const Schema *schema, const char *text, CameraParams *out, char *message,
                      size_t message_size)
{
    Sandbox sandbox; // nothing may be read
    Lang lang;
    Scene scene;
    sandbox_init(&sandbox);
    bool good = false;
    if (!lang_init(&lang, schema, &sandbox) || !scene_init(&scene, schema, &sandbox)) {
        snprintf(message, message_size, "not enough memory");
        lang_free(&lang);
        return false;
    }
    lang.limits.steps = 100000; // it is no program
    lang.limits.memory = 1 << 24;
    if (lang_load_text(&lang, str_from(text), "/camera", "camera", &scene)) {
        good = take_camera(&scene, out, message, message_size);
    } else {
        snprintf(message, message_size, "%s",
                 lang.sink.count > 0 ? lang.sink.items[0].message : "it has errors");
    }
    scene_free(&scene);
    lang_free(&lang);
    sandbox_free(&sandbox);
    return good;
}
