#include "export/fields.h"

#include <stdlib.h>
#include <string.h>

static const Param *find(const NodeType *type, const char *field)
{
    int index = node_type_find_param(type, str_from(field));
    return index < 0 ? NULL : &type->params[index];
}

// The field's value, of one of two types; NULL after a note.
static const void *value_of(Export *e, const SceneNode *node, const char *field, ParamType type,
                            ParamType other)
{
    const NodeType *kind = scene_node_type(e->scene, node);
    const Param *param = find(kind, field);
    if (!param || (param->type != type && param->type != other)) {
        export_note(e, node->at, "the exporter knows no field `%s` of `%s` any more", field,
                    kind->name);
        return NULL;
    }
    return (const char *)scene_params(e->scene, node) + param->offset;
}

#define GETTER(name, Type, type, other, otherwise)                                                 \
    Type name(Export *e, const SceneNode *node, const char *field)                                 \
    {                                                                                              \
        const void *value = value_of(e, node, field, type, other);                                 \
        return value ? *(const Type *)value : (Type)otherwise;                                     \
    }

#define NONE                                                                                       \
    {                                                                                              \
        0                                                                                          \
    }
GETTER(export_number, double, PARAM_NUMBER, PARAM_NUMBER, 0)
GETTER(export_bool, bool, PARAM_BOOL, PARAM_BOOL, false)
GETTER(export_int, int64_t, PARAM_INT, PARAM_INT, 0)
GETTER(export_vec2, Vec2, PARAM_VEC2, PARAM_PAIR, NONE)
GETTER(export_vec3, Vec3, PARAM_VEC3, PARAM_VEC3, NONE)
GETTER(export_rgb, Rgb, PARAM_COLOR, PARAM_COLOR, NONE)
GETTER(export_quantity, Quantity, PARAM_QUANTITY, PARAM_QUANTITY, NONE)
GETTER(export_numbers, NumberList, PARAM_NUMBER_LIST, PARAM_NUMBER_LIST, NONE)
GETTER(export_rgbs, RgbList, PARAM_COLOR_LIST, PARAM_COLOR_LIST, NONE)
GETTER(export_id, uint32_t, PARAM_NODE, PARAM_NODE, NONE_ID)

NumberTex export_number_tex(Export *e, const SceneNode *node, const char *field)
{
    const NumberTex *value = value_of(e, node, field, PARAM_NUMBER_TEX, PARAM_NUMBER_TEX);
    return value ? *value : (NumberTex){0, NONE_ID};
}

PairTex export_pair_tex(Export *e, const SceneNode *node, const char *field)
{
    const PairTex *value = value_of(e, node, field, PARAM_PAIR_TEX, PARAM_PAIR_TEX);
    return value ? *value : (PairTex){{0, 0}, NONE_ID};
}

ColorTex export_color_tex(Export *e, const SceneNode *node, const char *field)
{
    const ColorTex *value = value_of(e, node, field, PARAM_COLOR_TEX, PARAM_COLOR_TEX);
    return value ? *value : (ColorTex){{0, 0, 0}, NONE_ID};
}

Emission export_emission(Export *e, const SceneNode *node, const char *field)
{
    const Emission *value = value_of(e, node, field, PARAM_EMISSION, PARAM_EMISSION);
    return value ? *value : (Emission){.texture = NONE_ID};
}

const char *export_file(Export *e, const SceneNode *node, const char *field)
{
    const char *const *value = value_of(e, node, field, PARAM_FILE, PARAM_STRING);
    return value ? *value : NULL;
}

const char *export_choice(Export *e, const SceneNode *node, const char *field)
{
    const int32_t *value = value_of(e, node, field, PARAM_CHOICE, PARAM_CHOICE);
    const Param *param = find(scene_node_type(e->scene, node), field);
    for (int32_t i = 0; value && param->choices[i]; ++i) {
        if (i == *value) {
            return param->choices[i];
        }
    }
    return "";
}

// --- Settings ------------------------------------------------------------------------------------

static const Param *setting_param(Export *e, const char *kind, const char *field, ParamType type)
{
    int number = schema_find(e->scene->schema, str_from(kind));
    const Param *param = number < 0 ? NULL : find(e->scene->schema->types[number], field);
    if (!param || param->type != type) {
        export_note(e, (Span){0, 0, 0}, "the exporter knows no field `%s` of `%s` any more", field,
                    kind);
        return NULL;
    }
    return param;
}

static const void *setting_value(const Export *e, const char *kind, const Param *param)
{
    const char *params = scene_setting(e->scene, kind);
    return params ? params + param->offset : NULL;
}

int64_t export_setting_int(Export *e, const char *kind, const char *field)
{
    const Param *param = setting_param(e, kind, field, PARAM_INT);
    if (!param) {
        return 0;
    }
    const int64_t *value = setting_value(e, kind, param);
    return value ? *value : param->default_text ? strtoll(param->default_text, NULL, 10) : 0;
}

bool export_setting_bool(Export *e, const char *kind, const char *field)
{
    const Param *param = setting_param(e, kind, field, PARAM_BOOL);
    if (!param) {
        return false;
    }
    const bool *value = setting_value(e, kind, param);
    return value ? *value : param->default_text && strcmp(param->default_text, "true") == 0;
}

const char *export_setting_choice(Export *e, const char *kind, const char *field, char *out,
                                  size_t size)
{
    const Param *param = setting_param(e, kind, field, PARAM_CHOICE);
    out[0] = '\0';
    if (!param) {
        return out;
    }
    const int32_t *value = setting_value(e, kind, param);
    for (int32_t i = 0; value && param->choices[i]; ++i) {
        if (i == *value) {
            snprintf(out, size, "%s", param->choices[i]);
        }
    }
    if (!value && param->default_text) { // "\"path\"" as in a scene
        size_t length = strlen(param->default_text);
        snprintf(out, size, "%.*s", length > 2 ? (int)(length - 2) : 0, param->default_text + 1);
    }
    return out;
}

// --- Nodes ---------------------------------------------------------------------------------------

const char *export_kind(const Export *e, const SceneNode *node)
{
    return scene_node_type(e->scene, node)->name;
}

bool export_is(const Export *e, const SceneNode *node, const char *kind)
{
    return strcmp(export_kind(e, node), kind) == 0;
}

const Affine *export_transform(const Export *e, uint32_t transform)
{
    return &e->scene->transforms.items[transform];
}
