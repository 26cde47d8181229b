// The `camera` kind: its fields, and what is right only in some combinations.
#include "render/camera.h"

enum {
    POSITION,
    LOOK_AT,
    DIRECTION,
    UP,
    FOV,
    PROJECTION,
    HEIGHT,
    APERTURE,
    F_STOP,
    FOCAL_LENGTH,
    FOCUS_DISTANCE,
    FOCUS_AT,
    FIELD_COUNT
};

static const char *const projections[] = {"perspective", "orthographic", "fisheye", "panorama",
                                          NULL};

#define LENGTH_FIELD .type = PARAM_NUMBER, .dims = DIM_BIT(DIM_LENGTH)
#define POSITIVE     .min = 0, .max = INFINITY, .flags = PARAM_NO_DEFAULT | PARAM_EXCLUDE_MIN
#define POINT        .type = PARAM_VEC3, .dims = DIM_BIT(DIM_LENGTH)

static const Param camera_params[FIELD_COUNT] = {
    [POSITION] = {.name = "position",
                  POINT,
                  PARAM_AT(CameraParams, position),
                  .flags = PARAM_REQUIRED,
                  .doc = "where the lens is"},
    [LOOK_AT] = {.name = "look_at",
                 POINT,
                 PARAM_AT(CameraParams, look_at),
                 .flags = PARAM_NO_DEFAULT,
                 .doc = "the point in the middle of the picture; this or `direction`"},
    [DIRECTION] = {.name = "direction",
                   .type = PARAM_VEC3,
                   PARAM_AT(CameraParams, direction),
                   .flags = PARAM_NO_DEFAULT | PARAM_UNIT_VECTOR,
                   .doc = "which way the camera looks; this or `look_at`"},
    [UP] = {.name = "up",
            .type = PARAM_VEC3,
            PARAM_AT(CameraParams, up),
            .flags = PARAM_UNIT_VECTOR,
            .default_text = "(0, 1, 0)",
            .doc = "a direction that is upright in the picture"},
    [FOV] = {.name = "fov",
             .type = PARAM_NUMBER,
             .dims = DIM_BIT(DIM_ANGLE),
             PARAM_AT(CameraParams, fov),
             .min = 0,
             .max = 2 * PI,
             .flags = PARAM_EXCLUDE_MIN,
             .default_text = "40deg",
             .doc = "vertical field of view: less than 180deg in perspective, up to 360deg for a "
                    "fisheye"},
    [PROJECTION] = {.name = "projection",
                    .type = PARAM_CHOICE,
                    PARAM_AT(CameraParams, projection),
                    .choices = projections,
                    .default_text = "\"perspective\"",
                    .doc = "how directions come to lie on the film"},
    [HEIGHT] = {.name = "height",
                LENGTH_FIELD,
                PARAM_AT(CameraParams, height),
                POSITIVE,
                .doc = "height of what an orthographic camera sees"},
    [APERTURE] = {.name = "aperture",
                  LENGTH_FIELD,
                  PARAM_AT(CameraParams, aperture),
                  .min = 0,
                  .max = INFINITY,
                  .flags = PARAM_NO_DEFAULT,
                  .doc = "radius of the lens; 0, or none: all is in focus"},
    [F_STOP] = {.name = "f_stop",
                .type = PARAM_NUMBER,
                PARAM_AT(CameraParams, f_stop),
                POSITIVE,
                .doc = "the aperture by its f-number: radius = focal_length / (2 f_stop)"},
    [FOCAL_LENGTH] = {.name = "focal_length",
                      LENGTH_FIELD,
                      PARAM_AT(CameraParams, focal_length),
                      POSITIVE,
                      .doc = "of the lens, for `f_stop`; the field of view is `fov`'s business"},
    [FOCUS_DISTANCE] = {.name = "focus_distance",
                        LENGTH_FIELD,
                        PARAM_AT(CameraParams, focus_distance),
                        POSITIVE,
                        .doc =
                            "from the lens to the plane in focus, along the axis; without it and "
                            "`focus_at` it is the distance to `look_at`"},
    [FOCUS_AT] = {.name = "focus_at",
                  POINT,
                  PARAM_AT(CameraParams, focus_at),
                  .flags = PARAM_NO_DEFAULT,
                  .doc = "a point in the plane in focus"},
};

static bool is_set(const NodeFinish *finish, int param)
{
    return finish->set >> param & 1;
}

static bool finish_view(NodeFinish *finish, CameraParams *c)
{
    if (is_set(finish, LOOK_AT) == is_set(finish, DIRECTION)) {
        if (is_set(finish, LOOK_AT)) {
            finish->report(finish, DIRECTION, E0920,
                           "`look_at` and `direction` can't both be given");
        } else {
            finish->report(finish, -1, E0920, "`camera` needs `look_at` or `direction`");
        }
        return false;
    }
    if (is_set(finish, LOOK_AT)) {
        const Vec3 forward = sub(c->look_at, c->position);
        if (!(length_squared(forward) > 0)) {
            finish->report(finish, LOOK_AT, E0921, "the camera looks at the point where it stands");
            return false;
        }
        c->direction = normalize(forward);
    }
    if (!affine_look_at(vec3(0, 0, 0), c->direction, c->up, &c->frame)) {
        Diag *diag = finish->report(finish, is_set(finish, UP) ? UP : -1, E0921,
                                    "the camera looks along its `up` direction");
        diag_note(finish->sink, diag, "any `up` that isn't parallel to the view will do");
        return false;
    }
    c->frame.m[0][3] = c->position.x;
    c->frame.m[1][3] = c->position.y;
    c->frame.m[2][3] = c->position.z;
    return true;
}

static void warn_unused(NodeFinish *finish, int param, const CameraParams *c)
{
    if (is_set(finish, param)) {
        finish->report(finish, param, W0920, "`%s` has no effect with projection \"%s\"",
                       camera_params[param].name, projections[c->projection]);
    }
}

static bool finish_projection(NodeFinish *finish, CameraParams *c)
{
    if (c->projection == CAMERA_PERSPECTIVE && c->fov >= PI) {
        finish->report(finish, FOV, E0922,
                       "`fov` of a perspective camera must be less than 180deg");
        return false;
    }
    if (c->projection == CAMERA_ORTHOGRAPHIC && !is_set(finish, HEIGHT)) {
        finish->report(finish, -1, E0923, "an orthographic camera needs `height`");
        return false;
    }
    if (c->projection != CAMERA_ORTHOGRAPHIC) {
        warn_unused(finish, HEIGHT, c);
    }
    if (c->projection == CAMERA_ORTHOGRAPHIC || c->projection == CAMERA_PANORAMA) {
        warn_unused(finish, FOV, c);
    }
    return true;
}

static bool finish_aperture(NodeFinish *finish, CameraParams *c)
{
    if (is_set(finish, APERTURE) && is_set(finish, F_STOP)) {
        finish->report(finish, F_STOP, E0924, "`aperture` and `f_stop` can't both be given");
        return false;
    }
    if (is_set(finish, F_STOP) != is_set(finish, FOCAL_LENGTH)) {
        const bool have_stop = is_set(finish, F_STOP);
        finish->report(finish, have_stop ? F_STOP : FOCAL_LENGTH, E0924,
                       "`%s` needs `%s` beside it", have_stop ? "f_stop" : "focal_length",
                       have_stop ? "focal_length" : "f_stop");
        return false;
    }
    if (is_set(finish, F_STOP)) {
        c->aperture = c->focal_length / (2 * c->f_stop);
    } else if (!is_set(finish, APERTURE)) {
        c->aperture = 0;
    }
    return true;
}

static bool finish_focus(NodeFinish *finish, CameraParams *c)
{
    if (is_set(finish, FOCUS_DISTANCE) && is_set(finish, FOCUS_AT)) {
        finish->report(finish, FOCUS_AT, E0925,
                       "`focus_distance` and `focus_at` can't both be given");
        return false;
    }
    if (is_set(finish, FOCUS_AT)) {
        c->focus_distance = dot(sub(c->focus_at, c->position), c->direction);
        if (!(c->focus_distance > 0)) {
            finish->report(finish, FOCUS_AT, E0925, "`focus_at` lies behind the camera");
            return false;
        }
    } else if (!is_set(finish, FOCUS_DISTANCE)) {
        if (c->aperture > 0 && !is_set(finish, LOOK_AT)) {
            finish->report(finish, -1, E0925,
                           "a camera with an aperture needs `focus_distance` or `focus_at`");
            return false;
        }
        c->focus_distance = is_set(finish, LOOK_AT) ? length(sub(c->look_at, c->position)) : 1;
    }
    return true;
}

static bool camera_finish(NodeFinish *finish)
{
    CameraParams *c = finish->params;
    // Each part is checked, so that all errors are told at once.
    bool ok = finish_view(finish, c);
    ok = finish_projection(finish, c) && ok;
    if (c->projection == CAMERA_FISHEYE || c->projection == CAMERA_PANORAMA) {
        for (int param = APERTURE; param <= FOCUS_AT; ++param) {
            warn_unused(finish, param, c);
        }
        c->aperture = 0;
        return ok;
    }
    ok = finish_aperture(finish, c) && ok;
    return ok && finish_focus(finish, c);
}

const NodeType camera_kind = {
    .name = "camera",
    .category = CATEGORY_CAMERA,
    .params = camera_params,
    .param_count = FIELD_COUNT,
    .size = sizeof(CameraParams),
    .doc = "What the picture is seen with. The first camera of a scene is used unless another is "
           "named on the command line. Its picture is upright with `up` towards the top.",
    .formula =
        "A thin lens: a point at depth d shows as a circle of confusion, in the plane in focus at "
        "depth s, of diameter A |d - s| / d with A = 2 aperture. fisheye: equidistant, the angle "
        "off the axis grows with the distance from the picture's middle, fov from the bottom to "
        "the top. panorama: longitude and latitude, the direction looked along in the middle.",
    .example =
        "camera {\n"
        "  position: (0, 1.2, 4)\n"
        "  look_at: (0, 0.4, 0)\n"
        "  fov: 30deg\n"
        "  aperture: 6cm\n"
        "  focus_at: (0, 0.3, 0)\n"
        "}\n"
        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], space: \"uv\" } }\n"
        "plane {\n"
        "  material: lambert { color: checker { a: gray(0.6), b: gray(0.35), space: \"world\", "
        "scale: 2 } }\n"
        "}\n"
        "for (i in 0..8) {\n"
        "  sphere {\n"
        "    center: (0.4 * i - 1.6, 0.3, 1.2 - 0.3 * i)\n"
        "    radius: 0.25\n"
        "    material: burley { color: hsv(40deg * i, 0.7, 0.8) }\n"
        "  }\n"
        "}",
    .finish = camera_finish,
};
