// A small schema of the tests' own, so that the language is tested without the renderer: one kind
// with a field of every type, and the few kinds that the language treats in its own way.
#ifndef TEST_SCHEMA_H
#define TEST_SCHEMA_H

#include "scene/scene.h"
#include "schema/schema.h"

#include <string.h>

typedef struct Everything {
    bool flag;
    int64_t whole;
    double number, angle;
    Quantity quantity;
    Vec2 pair, vec2;
    Vec3 vec3, direction;
    Rgb color;
    Emission emission;
    NumberTex number_tex;
    PairTex pair_tex;
    ColorTex color_tex;
    const char *string, *file;
    int32_t choice;
    uint32_t node, optional;
    NumberList numbers;
    Vec2List vec2s;
    Vec3List vec3s;
    RgbList colors;
    FaceList faces;
    StringList strings;
    uint64_t set; // what `finish` was told
    int finished; // how often it ran on these parameters
} Everything;

static const char *const test_choices[] = {"red", "green", "blue", NULL};

static const Param everything_params[] = {
    {.name = "flag",
     .type = PARAM_BOOL,
     PARAM_AT(Everything, flag),
     .default_text = "true",
     .doc = "d"},
    {.name = "whole",
     .type = PARAM_INT,
     PARAM_AT(Everything, whole),
     .default_text = "7",
     .min = -10,
     .max = 10,
     .doc = "d"},
    {.name = "number",
     .type = PARAM_NUMBER,
     PARAM_AT(Everything, number),
     .dims = DIM_BIT(DIM_LENGTH),
     .default_text = "1.5",
     .min = 0,
     .max = 100,
     .flags = PARAM_EXCLUDE_MIN | PARAM_EXCLUDE_MAX,
     .doc = "d"},
    {.name = "angle",
     .type = PARAM_NUMBER,
     PARAM_AT(Everything, angle),
     .dims = DIM_BIT(DIM_ANGLE),
     .default_text = "40deg",
     .doc = "d"},
    {.name = "quantity",
     .type = PARAM_QUANTITY,
     PARAM_AT(Everything, quantity),
     .dims = DIM_BIT(DIM_POWER) | DIM_BIT(DIM_LUMINOUS_FLUX),
     .flags = PARAM_NO_DEFAULT,
     .doc = "d"},
    {.name = "pair",
     .type = PARAM_PAIR,
     PARAM_AT(Everything, pair),
     .default_text = "0.5",
     .doc = "d"},
    {.name = "vec2",
     .type = PARAM_VEC2,
     PARAM_AT(Everything, vec2),
     .default_text = "(1, 2)",
     .doc = "d"},
    {.name = "vec3",
     .type = PARAM_VEC3,
     PARAM_AT(Everything, vec3),
     .dims = DIM_BIT(DIM_LENGTH),
     .default_text = "(1, 2, 3)",
     .doc = "d"},
    {.name = "direction",
     .type = PARAM_VEC3,
     PARAM_AT(Everything, direction),
     .flags = PARAM_UNIT_VECTOR,
     .default_text = "(0, 1, 0)",
     .doc = "d"},
    {.name = "color",
     .type = PARAM_COLOR,
     PARAM_AT(Everything, color),
     .default_text = "rgb(1, 0.5, 0.25)",
     .doc = "d"},
    {.name = "emission",
     .type = PARAM_EMISSION,
     PARAM_AT(Everything, emission),
     .dims = DIM_BIT(DIM_NONE) | DIM_BIT(DIM_LUMINANCE),
     .default_text = "1",
     .doc = "d"},
    {.name = "number_tex",
     .type = PARAM_NUMBER_TEX,
     PARAM_AT(Everything, number_tex),
     .default_text = "0.25",
     .doc = "d"},
    {.name = "pair_tex",
     .type = PARAM_PAIR_TEX,
     PARAM_AT(Everything, pair_tex),
     .default_text = "0.2",
     .doc = "d"},
    {.name = "color_tex",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(Everything, color_tex),
     .default_text = "gray(0.5)",
     .doc = "d"},
    {.name = "string",
     .type = PARAM_STRING,
     PARAM_AT(Everything, string),
     .default_text = "\"text\"",
     .doc = "d"},
    {.name = "file",
     .type = PARAM_FILE,
     PARAM_AT(Everything, file),
     .flags = PARAM_NO_DEFAULT,
     .doc = "d"},
    {.name = "choice",
     .type = PARAM_CHOICE,
     PARAM_AT(Everything, choice),
     .choices = test_choices,
     .default_text = "\"green\"",
     .doc = "d"},
    {.name = "node",
     .type = PARAM_NODE,
     PARAM_AT(Everything, node),
     .category = CATEGORY_TEXTURE,
     .default_text = "plain {}",
     .doc = "d"},
    {.name = "optional",
     .type = PARAM_NODE,
     PARAM_AT(Everything, optional),
     .category = CATEGORY_TEXTURE,
     .flags = PARAM_NO_DEFAULT,
     .doc = "d"},
    {.name = "numbers",
     .type = PARAM_NUMBER_LIST,
     PARAM_AT(Everything, numbers),
     .default_text = "[1, 2]",
     .doc = "d"},
    {.name = "vec2s",
     .type = PARAM_VEC2_LIST,
     PARAM_AT(Everything, vec2s),
     .default_text = "[]",
     .doc = "d"},
    {.name = "vec3s",
     .type = PARAM_VEC3_LIST,
     PARAM_AT(Everything, vec3s),
     .flags = PARAM_NO_DEFAULT,
     .doc = "d"},
    {.name = "colors",
     .type = PARAM_COLOR_LIST,
     PARAM_AT(Everything, colors),
     .flags = PARAM_NO_DEFAULT,
     .doc = "d"},
    {.name = "faces",
     .type = PARAM_FACE_LIST,
     PARAM_AT(Everything, faces),
     .flags = PARAM_NO_DEFAULT,
     .doc = "d"},
    {.name = "strings",
     .type = PARAM_STRING_LIST,
     PARAM_AT(Everything, strings),
     .flags = PARAM_NO_DEFAULT,
     .doc = "d"},
};

// `whole` 9 with `flag` false is refused, at `whole`; `number` is doubled.
static bool everything_finish(NodeFinish *finish)
{
    Everything *params = finish->params;
    params->set = finish->set;
    params->number *= 2;
    ++params->finished;
    if (params->whole == 9 && !params->flag) {
        finish->report(finish, 1, E0404, "9 is not for %s", finish->type->name);
        return false;
    }
    return true;
}

typedef struct Ball {
    Vec3 center;
    double radius;
} Ball;

static const Param ball_params[] = {
    {.name = "center",
     .type = PARAM_VEC3,
     PARAM_AT(Ball, center),
     .dims = DIM_BIT(DIM_LENGTH),
     .default_text = "(0, 0, 0)",
     .doc = "d"},
    {.name = "radius",
     .type = PARAM_NUMBER,
     PARAM_AT(Ball, radius),
     .dims = DIM_BIT(DIM_LENGTH),
     .default_text = "1",
     .max = INFINITY,
     .flags = PARAM_EXCLUDE_MIN,
     .doc = "d"},
};

static Box3 ball_bounds(const Scene *scene, const void *params)
{
    (void)scene;
    const Ball *ball = params;
    Vec3 r = vec3(ball->radius, ball->radius, ball->radius);
    return (Box3){sub(ball->center, r), add(ball->center, r)};
}

typedef struct TextureMath {
    int32_t op;
    ColorTex a, b;
} TextureMath;

static const char *const math_ops[] = {"add", "subtract", "multiply", NULL};
static const Param math_params[] = {
    {.name = "op",
     .type = PARAM_CHOICE,
     PARAM_AT(TextureMath, op),
     .choices = math_ops,
     .flags = PARAM_REQUIRED,
     .doc = "d"},
    {.name = "a",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(TextureMath, a),
     .flags = PARAM_REQUIRED,
     .doc = "d"},
    {.name = "b",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(TextureMath, b),
     .flags = PARAM_REQUIRED,
     .doc = "d"},
};

typedef struct Lamp {
    uint32_t shape;
} Lamp;

static const Param lamp_params[] = {
    {.name = "shape",
     .type = PARAM_NODE,
     PARAM_AT(Lamp, shape),
     .category = CATEGORY_SHAPE,
     .flags = PARAM_NO_DEFAULT,
     .doc = "d"},
};

enum { TYPE_EVERYTHING, TYPE_BALL, TYPE_PLAIN, TYPE_MATH, TYPE_LAMP, TYPE_GROUP, TYPE_INSTANCE };

static const NodeType test_types[] = {
    {.name = "everything",
     .category = CATEGORY_MATERIAL,
     .params = everything_params,
     .param_count = sizeof everything_params / sizeof everything_params[0],
     .size = sizeof(Everything),
     .doc = "d",
     .finish = everything_finish},
    {.name = "ball",
     .category = CATEGORY_SHAPE,
     .params = ball_params,
     .param_count = 2,
     .size = sizeof(Ball),
     .doc = "d",
     .bounds = ball_bounds},
    {.name = "plain", .category = CATEGORY_TEXTURE, .doc = "d"},
    {.name = "texture_math",
     .category = CATEGORY_TEXTURE,
     .params = math_params,
     .param_count = 3,
     .size = sizeof(TextureMath),
     .internal = true,
     .doc = "d"},
    {.name = "lamp",
     .category = CATEGORY_LIGHT,
     .params = lamp_params,
     .param_count = 1,
     .size = sizeof(Lamp),
     .doc = "d"},
    {.name = "group", .category = CATEGORY_SHAPE, .role = ROLE_GROUP, .doc = "d"},
    {.name = "instance", .category = CATEGORY_SHAPE, .role = ROLE_INSTANCE, .doc = "d"},
};

static const NodeType *const test_type_list[] = {
    &test_types[0], &test_types[1], &test_types[2], &test_types[3],
    &test_types[4], &test_types[5], &test_types[6],
};

static const Schema test_schema = {test_type_list, 7};

#endif
