#include "schema/schema.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

static const DimInfo dims[] = {
#define DIMENSION(id, name, unit) {name, unit},
    DIMENSIONS(DIMENSION)
#undef DIMENSION
};

const DimInfo *dim_info(Dim dim)
{
    return &dims[dim < DIM_COUNT ? dim : DIM_NONE];
}

const UnitInfo schema_units[] = {
    {"deg", DIM_ANGLE, PI / 180}, {"rad", DIM_ANGLE, 1},
    {"turn", DIM_ANGLE, 2 * PI},  {"km", DIM_LENGTH, 1e3},
    {"m", DIM_LENGTH, 1},         {"cm", DIM_LENGTH, 1e-2},
    {"mm", DIM_LENGTH, 1e-3},     {"um", DIM_LENGTH, 1e-6},
    {"nm", DIM_LENGTH, 1e-9},     {"s", DIM_TIME, 1},
    {"ms", DIM_TIME, 1e-3},       {"K", DIM_TEMPERATURE, 1},
    {"W", DIM_POWER, 1},          {"kW", DIM_POWER, 1e3},
    {"lm", DIM_LUMINOUS_FLUX, 1}, {"cd", DIM_LUMINOUS_INTENSITY, 1},
    {"lx", DIM_ILLUMINANCE, 1},   {"nit", DIM_LUMINANCE, 1},
};
const size_t schema_unit_count = sizeof schema_units / sizeof schema_units[0];

const UnitInfo *unit_find(Str name)
{
    for (size_t i = 0; i < schema_unit_count; ++i) {
        if (str_equal(name, str_from(schema_units[i].name))) {
            return &schema_units[i];
        }
    }
    return NULL;
}

static const char *const categories[] = {
#define CATEGORY(id, name) name,
    CATEGORIES(CATEGORY)
#undef CATEGORY
};

const char *category_name(Category category)
{
    return category < CATEGORY_COUNT ? categories[category] : "value";
}

typedef struct ParamTypeInfo {
    size_t size, alignment;
    const char *name;
} ParamTypeInfo;

static const ParamTypeInfo param_types[] = {
#define PARAM_TYPE(id, type, name) {sizeof(type), _Alignof(type), name},
    PARAM_TYPES(PARAM_TYPE)
#undef PARAM_TYPE
};

size_t param_type_size(ParamType type)
{
    return type < PARAM_TYPE_COUNT ? param_types[type].size : 0;
}

const char *param_type_name(ParamType type)
{
    return type < PARAM_TYPE_COUNT ? param_types[type].name : "";
}

uint32_t category_common_fields(Category category)
{
    switch (category) {
    case CATEGORY_SHAPE:
        return COMMON_TRANSFORM | COMMON_MATERIAL | COMMON_NAME;
    case CATEGORY_LIGHT:
        return COMMON_TRANSFORM | COMMON_NAME | COMMON_COLOR;
    case CATEGORY_CAMERA:
        return COMMON_TRANSFORM | COMMON_NAME;
    case CATEGORY_MATERIAL:
        return COMMON_NAME;
    default:
        return 0;
    }
}

const char *common_field_name(CommonField field)
{
    switch (field) {
    case COMMON_TRANSFORM:
        return "transform";
    case COMMON_MATERIAL:
        return "material";
    case COMMON_NAME:
        return "name";
    case COMMON_COLOR:
        return "color";
    }
    return "";
}

const char *common_field_doc(CommonField field)
{
    switch (field) {
    case COMMON_TRANSFORM:
        return "A transform, or a list of transforms applied first to last.";
    case COMMON_MATERIAL:
        return "The material; without one, that of the group or instance around it, else "
               "`lambert {}`.";
    case COMMON_NAME:
        return "A name for messages, layers of object ids and `--camera`.";
    case COMMON_COLOR:
        return "The light's color, which a numeric strength is multiplied by; `rgb(1, 1, 1)` "
               "unless given.";
    }
    return "";
}

int schema_find(const Schema *schema, Str name)
{
    for (size_t i = 0; i < schema->type_count; ++i) {
        const char *kind = schema->types[i]->name;
        if (strncmp(kind, name.at, name.length) == 0 && kind[name.length] == '\0') {
            return (int)i;
        }
    }
    return -1;
}

int node_type_find_param(const NodeType *type, Str name)
{
    for (size_t i = 0; i < type->param_count; ++i) {
        const char *field = type->params[i].name;
        if (strncmp(field, name.at, name.length) == 0 && field[name.length] == '\0') {
            return (int)i;
        }
    }
    return -1;
}

// --- Did you mean ----------------------------------------------------------------------------

typedef struct Suggestion {
    char lowered[64]; // the misspelt name, without regard to case
    Str name;
    size_t limit, distance;
    const char *best;
} Suggestion;

// A third of the letters may be wrong, at least one: more, and the guess is noise.
static bool suggestion_begin(Suggestion *suggestion, Str name)
{
    if (name.length == 0 || name.length > sizeof suggestion->lowered) {
        return false;
    }
    for (size_t i = 0; i < name.length; ++i) {
        suggestion->lowered[i] = (char)tolower((unsigned char)name.at[i]);
    }
    suggestion->name = (Str){suggestion->lowered, name.length};
    suggestion->limit = str_suggestion_limit(name);
    suggestion->distance = suggestion->limit + 1;
    suggestion->best = NULL;
    return true;
}

// "rough" for `roughness`, "look_at_point" for `look_at`: one begins with the other.
static bool abbreviates(Str a, Str b)
{
    size_t shorter = a.length < b.length ? a.length : b.length;
    return shorter >= 3 && memcmp(a.at, b.at, shorter) == 0;
}

static void suggestion_try(Suggestion *suggestion, const char *candidate)
{
    Str text = str_from(candidate);
    size_t distance = str_distance(suggestion->name, text, suggestion->limit);
    // No letter in its place and none in common is no likeness, however short the name.
    if (distance >= text.length) {
        return;
    }
    if (distance > suggestion->limit && abbreviates(suggestion->name, text)) {
        distance = suggestion->limit;
    }
    if (distance < suggestion->distance) {
        suggestion->distance = distance;
        suggestion->best = candidate;
    }
}

const char *schema_suggest_type(const Schema *schema, Str name, Category category)
{
    Suggestion suggestion;
    if (!suggestion_begin(&suggestion, name)) {
        return NULL;
    }
    for (size_t i = 0; i < schema->type_count; ++i) {
        const NodeType *type = schema->types[i];
        if (!type->internal && (category == CATEGORY_COUNT || type->category == category)) {
            suggestion_try(&suggestion, type->name);
        }
    }
    return suggestion.best;
}

const char *node_type_suggest_param(const NodeType *type, Str name)
{
    Suggestion suggestion;
    if (!suggestion_begin(&suggestion, name)) {
        return NULL;
    }
    for (size_t i = 0; i < type->param_count; ++i) {
        suggestion_try(&suggestion, type->params[i].name);
    }
    uint32_t common = category_common_fields(type->category);
    for (uint32_t bit = 1; bit <= common; bit <<= 1) {
        if (common & bit) {
            suggestion_try(&suggestion, common_field_name((CommonField)bit));
        }
    }
    return suggestion.best;
}
