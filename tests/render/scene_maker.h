// Makes flat scenes for tests without the language, through the schema: fields by name, defaults
// and `finish` as the evaluator does.
//
//     uint32_t white = PUT(&maker, "lambert", {"color", {0.8}});
//     PUT(&maker, "sphere", {"center", {0, 1, 0}}, {"material", {white}});
#ifndef TEST_SCENE_MAKER_H
#define TEST_SCENE_MAKER_H

#include "base/diag.h"
#include "render/render.h"
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What a field's initializer leaves out is zero, by intent.
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"

// One field: numbers (a component each; a single one is spread over a color), or a node's id as the
// first number, or a choice's or file's text. `material`, `transform` (an id of
// scene_add_transform) and `color` of a light are fields, too.
typedef struct MakerField {
    const char *name;
    double v[4];
    const char *text;
    uint32_t dim;
    bool texture;     // v[0] is a texture's id
    const void *list; // Vec3, Rgb, double or uint32_t items (faces: triangles)
    uint32_t count;   // of them
} MakerField;

typedef struct SceneMaker {
    Arena arena;
    DiagSink sink;
    Sandbox sandbox;
    Scene scene;
    uint32_t prototype, flags; // of the shapes put next
    int errors;                // reported by finish
} SceneMaker;

#define PUT(maker, kind, ...)                                                                      \
    maker_put(maker, kind, (const MakerField[]){{"", {0}}, __VA_ARGS__},                           \
              sizeof((const MakerField[]){{"", {0}}, __VA_ARGS__}) / sizeof(MakerField))

// A kind with all fields left out.
#define PUT_DEFAULT(maker, kind) maker_put(maker, kind, NULL, 0)

static inline void maker_init(SceneMaker *maker)
{
    memset(maker, 0, sizeof *maker);
    diag_sink_init(&maker->sink, &maker->arena);
    sandbox_init(&maker->sandbox);
    maker->sandbox.allow_all = true;
    if (!scene_init(&maker->scene, render_schema(), &maker->sandbox)) {
        abort();
    }
}

static inline void maker_free(SceneMaker *maker)
{
    scene_free(&maker->scene);
    sandbox_free(&maker->sandbox);
    diag_sink_free(&maker->sink);
    arena_free(&maker->arena);
}

static inline void maker_set_list(SceneMaker *maker, void *at, const Param *param,
                                  const MakerField *f)
{
    if (param->type == PARAM_VEC3_LIST) {
        *(Vec3List *)at = (Vec3List){(Vec3 *)(uintptr_t)f->list, f->count};
    } else if (param->type == PARAM_COLOR_LIST) {
        *(RgbList *)at = (RgbList){(Rgb *)(uintptr_t)f->list, f->count};
    } else if (param->type == PARAM_NUMBER_LIST) {
        *(NumberList *)at = (NumberList){(double *)(uintptr_t)f->list, f->count};
    } else if (param->type == PARAM_FACE_LIST) {
        FaceList faces = {(uint32_t *)(uintptr_t)f->list, NULL, f->count, f->count / 3};
        faces.sizes = arena_array(&maker->arena, faces.count, sizeof *faces.sizes);
        for (uint32_t i = 0; i < faces.count; ++i) {
            faces.sizes[i] = 3;
        }
        *(FaceList *)at = faces;
    } else {
        fprintf(stderr, "scene maker: no list for %s\n", param->name);
        abort();
    }
}

static inline int32_t maker_choice(const Param *param, const char *text)
{
    for (int32_t i = 0; param->choices[i]; ++i) {
        if (strcmp(param->choices[i], text) == 0) {
            return i;
        }
    }
    fprintf(stderr, "scene maker: no choice %s\n", text);
    abort();
}

// `numbers`: how many components were given.
static inline void maker_set(SceneMaker *maker, void *at, const Param *param, const MakerField *f,
                             int numbers)
{
    const double *v = f->v;
    const uint32_t texture = f->texture ? (uint32_t)v[0] : NONE_ID;
    const Vec3 three = numbers == 1 ? vec3(v[0], v[0], v[0]) : vec3(v[0], v[1], v[2]);
    Rgb color = rgb((float)three.x, (float)three.y, (float)three.z);
    color = f->texture ? rgb_gray(1) : color;
    const double number = f->texture ? 1 : v[0];
    const Vec2 pair = {number, numbers == 1 ? number : v[1]};
    switch (param->type) {
    case PARAM_BOOL:
        *(bool *)at = v[0] != 0;
        break;
    case PARAM_INT:
        *(int64_t *)at = (int64_t)v[0];
        break;
    case PARAM_NUMBER:
        *(double *)at = v[0];
        break;
    case PARAM_QUANTITY:
        *(Quantity *)at = (Quantity){v[0], f->dim};
        break;
    case PARAM_PAIR:
    case PARAM_VEC2:
        *(Vec2 *)at = pair;
        break;
    case PARAM_VEC3:
        *(Vec3 *)at = vec3(v[0], v[1], v[2]);
        if (param->flags & PARAM_UNIT_VECTOR) {
            *(Vec3 *)at = normalize(*(Vec3 *)at);
        }
        break;
    case PARAM_COLOR:
        *(Rgb *)at = color;
        break;
    case PARAM_EMISSION:
        *(Emission *)at = (Emission){color, f->dim, texture, numbers == 1 && !f->texture};
        break;
    case PARAM_NUMBER_TEX:
        *(NumberTex *)at = (NumberTex){number, texture};
        break;
    case PARAM_PAIR_TEX:
        *(PairTex *)at = (PairTex){pair, texture};
        break;
    case PARAM_COLOR_TEX:
        *(ColorTex *)at = (ColorTex){color, texture};
        break;
    case PARAM_STRING:
    case PARAM_FILE:
        *(const char **)at = f->text;
        break;
    case PARAM_CHOICE:
        *(int32_t *)at = maker_choice(param, f->text);
        break;
    case PARAM_NODE:
        *(uint32_t *)at = (uint32_t)v[0];
        break;
    default:
        maker_set_list(maker, at, param, f);
        break;
    }
}

// Defaults of numbers, vectors, colors, choices and bools; nodes are left out (NONE_ID).
static inline void maker_default(SceneMaker *maker, void *at, const Param *param)
{
    MakerField f = {.name = param->name};
    const char *text = param->default_text;
    int numbers = 0;
    if (param->type == PARAM_NODE || !text) {
        f.v[0] = NONE_ID;
        if (param->type == PARAM_NODE) {
            maker_set(maker, at, param, &f, 1);
        }
        return;
    }
    if (param->type == PARAM_CHOICE) {
        f.text = arena_copy_string(&maker->arena, text + 1, strlen(text) - 2);
    } else if (param->type == PARAM_BOOL) {
        f.v[0] = strcmp(text, "true") == 0;
    } else if (*text == '[') {
        return;
    }
    for (const char *c = text; *c && numbers < 4;) {
        char *end;
        double x = strtod(c, &end);
        if (end == c) {
            ++c;
            continue;
        }
        bool degrees = strncmp(end, "deg", 3) == 0;
        f.v[numbers++] = degrees ? x * PI / 180 : x;
        c = end;
    }
    maker_set(maker, at, param, &f, numbers ? numbers : 1);
}

static inline Diag *maker_report(NodeFinish *self, int param, DiagCode code, const char *format,
                                 ...)
{
    SceneMaker *maker = self->caller;
    (void)param;
    ++maker->errors;
    return diag_report(&maker->sink, code, (Span){0, (uint32_t)maker->errors, 0}, "%s", format);
}

// How many components were given: three where any but the first is not zero, so that (1, 0, 0) as a
// color would be white; no test needs it.
static inline int maker_numbers(const MakerField *f)
{
    return f->v[1] != 0 || f->v[2] != 0 || f->v[3] != 0 ? 3 : 1;
}

// The new node's id, or NONE_ID where its finish reported an error.
static inline uint32_t maker_put(SceneMaker *maker, const char *kind, const MakerField *fields,
                                 size_t count)
{
    int type = schema_find(maker->scene.schema, str_from(kind));
    if (type < 0) {
        fprintf(stderr, "scene maker: no kind %s\n", kind);
        abort();
    }
    const NodeType *node_type = maker->scene.schema->types[type];
    char *params = arena_alloc_zeroed(&maker->arena, node_type->size + 16);
    SceneNode node = {
        .material = NONE_ID, .prototype = maker->prototype, .flags = (uint16_t)maker->flags};
    NodeFinish finish = {.type = node_type,
                         .params = params,
                         .scene = &maker->scene,
                         .color = {1, 1, 1},
                         .report = maker_report,
                         .sink = &maker->sink,
                         .caller = maker};
    for (size_t i = 0; i < node_type->param_count; ++i) {
        maker_default(maker, params + node_type->params[i].offset, &node_type->params[i]);
    }
    for (size_t i = 1; i < count; ++i) {
        const MakerField *f = &fields[i];
        int param = node_type_find_param(node_type, str_from(f->name));
        if (param >= 0) {
            finish.set |= UINT64_C(1) << param;
            maker_set(maker, params + node_type->params[param].offset, &node_type->params[param], f,
                      maker_numbers(f));
        } else if (strcmp(f->name, "material") == 0) {
            node.material = (uint32_t)f->v[0];
        } else if (strcmp(f->name, "transform") == 0) {
            node.transform = (uint32_t)f->v[0];
        } else if (strcmp(f->name, "color") == 0) {
            finish.color = rgb((float)f->v[0], (float)f->v[1], (float)f->v[2]);
        } else {
            fprintf(stderr, "scene maker: no field %s of %s\n", f->name, kind);
            abort();
        }
    }
    if (node_type->finish && !node_type->finish(&finish)) {
        return NONE_ID;
    }
    uint32_t id = scene_add_node(&maker->scene, (uint16_t)type, params, node);
    if (node_type->category == CATEGORY_LIGHT) {
        maker->scene.light_colors.items[id] = finish.color;
    }
    return id;
}

// The same for a shape that stands in an area_light.
#define PUT_LIGHT_SHAPE(maker, kind, ...)                                                          \
    maker_put_light_shape(maker, kind, (const MakerField[]){{"", {0}}, __VA_ARGS__},               \
                          sizeof((const MakerField[]){{"", {0}}, __VA_ARGS__}) /                   \
                              sizeof(MakerField))

static inline uint32_t maker_put_light_shape(SceneMaker *maker, const char *kind,
                                             const MakerField *fields, size_t count)
{
    maker->flags = NODE_LIGHT_ONLY;
    uint32_t id = maker_put(maker, kind, fields, count);
    maker->flags = 0;
    return id;
}

#endif
