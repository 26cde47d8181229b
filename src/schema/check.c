// The mistakes that people make in tables of kinds.
#include "schema/schema.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { MOST_PARAMS = 60 }; // NodeFinish.set has 64 bits, of which some are kept for common fields

typedef struct Check {
    char *message;
    size_t size;
    const NodeType *type;
    const Param *param;
} Check;

__attribute__((format(printf, 2, 3))) static bool fail(Check *check, const char *format, ...)
{
    char what[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    snprintf(check->message, check->size, "%s%s%s: %s",
             check->type && check->type->name ? check->type->name : "a kind",
             check->param ? "." : "", check->param && check->param->name ? check->param->name : "",
             what);
    return false;
}

static bool is_identifier(const char *name)
{
    if (!name || !(islower((unsigned char)*name) || *name == '_')) {
        return false;
    }
    for (; *name; ++name) {
        if (!islower((unsigned char)*name) && !isdigit((unsigned char)*name) && *name != '_') {
            return false;
        }
    }
    return true;
}

static bool is_common(const NodeType *type, const char *name)
{
    uint32_t common = category_common_fields(type->category);
    for (uint32_t bit = 1; bit <= common; bit <<= 1) {
        if ((common & bit) && strcmp(common_field_name((CommonField)bit), name) == 0) {
            return true;
        }
    }
    return false;
}

static bool takes_dimensions(ParamType type)
{
    switch (type) {
    case PARAM_NUMBER:
    case PARAM_QUANTITY:
    case PARAM_PAIR:
    case PARAM_VEC2:
    case PARAM_VEC3:
    case PARAM_EMISSION:
    case PARAM_NUMBER_TEX:
    case PARAM_PAIR_TEX:
    case PARAM_NUMBER_LIST:
    case PARAM_VEC2_LIST:
    case PARAM_VEC3_LIST:
        return true;
    default:
        return false;
    }
}

static size_t type_alignment(ParamType type)
{
    switch (type) {
#define PARAM_TYPE(id, c_type, name)                                                               \
    case PARAM_##id:                                                                               \
        return _Alignof(c_type);
        PARAM_TYPES(PARAM_TYPE)
#undef PARAM_TYPE
    default:
        return 1;
    }
}

static bool check_place(Check *check)
{
    const Param *param = check->param;
    size_t size = param_type_size(param->type);
    if (param->offset > check->type->size || size > check->type->size - param->offset) {
        return fail(check, "its value lies beyond the kind's struct");
    }
    if (param->offset % type_alignment(param->type) != 0) {
        return fail(check, "its offset doesn't suit its type");
    }
    for (const Param *other = check->type->params; other < param; ++other) {
        if (strcmp(other->name, param->name) == 0) {
            return fail(check, "the name stands twice");
        }
        if (other->offset < param->offset + size &&
            param->offset < other->offset + param_type_size(other->type)) {
            return fail(check, "shares its bytes with `%s`", other->name);
        }
    }
    return true;
}

static bool check_default(Check *check)
{
    const Param *param = check->param;
    bool required = (param->flags & PARAM_REQUIRED) != 0;
    bool none = (param->flags & PARAM_NO_DEFAULT) != 0;
    if (required && none) {
        return fail(check, "is required and may be left out");
    }
    if ((required || none) != (param->default_text == NULL)) {
        return fail(check, param->default_text ? "has a default that can't come to be used"
                                               : "has no default and isn't required");
    }
    if (param->type == PARAM_CHOICE && param->default_text) {
        size_t length = strlen(param->default_text);
        for (const char *const *choice = param->choices; *choice; ++choice) {
            if (length == strlen(*choice) + 2 && param->default_text[0] == '"' &&
                strncmp(param->default_text + 1, *choice, length - 2) == 0) {
                return true;
            }
        }
        return fail(check, "its default isn't one of its choices");
    }
    return true;
}

static bool check_param(Check *check)
{
    const Param *param = check->param;
    if (!is_identifier(param->name)) {
        return fail(check, "not a name in lower case");
    }
    if (is_common(check->type, param->name)) {
        return fail(check, "a common field of every %s has that name",
                    category_name(check->type->category));
    }
    if ((unsigned)param->type >= PARAM_TYPE_COUNT) {
        return fail(check, "unknown type");
    }
    if (!param->doc || !*param->doc) {
        return fail(check, "has no manual");
    }
    if (param->type == PARAM_CHOICE && (!param->choices || !param->choices[0])) {
        return fail(check, "has no choices");
    }
    if (param->type == PARAM_NODE && (unsigned)param->category >= CATEGORY_COUNT) {
        return fail(check, "takes nodes of no category");
    }
    if (param->dims >> DIM_COUNT || (param->dims && !takes_dimensions(param->type))) {
        return fail(check, "its dimensions don't suit its type");
    }
    // NaN fails this comparison, too.
    if (!(param->min < param->max) && !(param->min == 0 && param->max == 0)) {
        return fail(check, "its range is empty");
    }
    return check_default(check) && check_place(check);
}

static bool check_type(Check *check, const Schema *schema, size_t number)
{
    const NodeType *type = check->type;
    if (!type->internal && !is_identifier(type->name)) {
        return fail(check, "not a name in lower case");
    }
    if (!type->doc || !*type->doc) {
        return fail(check, "has no manual");
    }
    if ((unsigned)type->category >= CATEGORY_COUNT) {
        return fail(check, "belongs to no category");
    }
    if (type->param_count > MOST_PARAMS) {
        return fail(check, "has more than %d fields", MOST_PARAMS);
    }
    for (size_t i = 0; i < number; ++i) {
        if (strcmp(schema->types[i]->name, type->name) == 0) {
            return fail(check, "two kinds have that name");
        }
    }
    for (size_t i = 0; i < type->param_count; ++i) {
        check->param = &type->params[i];
        if (!check_param(check)) {
            return false;
        }
    }
    check->param = NULL;
    return true;
}

const char *schema_check(const Schema *schema, char *message, size_t message_size)
{
    Check check = {.message = message, .size = message_size};
    if (schema->type_count > UINT16_MAX) {
        fail(&check, "there are more kinds than a node's type can number");
        return message;
    }
    for (size_t i = 0; i < schema->type_count; ++i) {
        check.type = schema->types[i];
        if (!check_type(&check, schema, i)) {
            return message;
        }
    }
    return NULL;
}
