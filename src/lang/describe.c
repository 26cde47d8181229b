// Values in words, for diagnostics and for str().
#include "lang/measure.h"

#include <stdarg.h>
#include <stdio.h>

void format_number(double number, char *buffer, size_t size)
{
    bool is_whole = number == floor(number) && fabs(number) <= 0x1p53;
    snprintf(buffer, size, is_whole ? "%.0f" : "%.15g", number == 0 ? 0.0 : number);
}

static const char *article(const char *noun)
{
    return strchr("aeio", noun[0]) ? "an" : "a"; // "a unit"
}

static const char *describe_node(const Eval *ev, const NodeValue *node, char *buffer, size_t size)
{
    const NodeType *type = ev->lang->schema->types[node->type];
    if (type->role == ROLE_GROUP) {
        snprintf(buffer, size, "a group");
    } else {
        snprintf(buffer, size, "the %s `%s`", category_name(type->category), type->name);
    }
    return buffer;
}

const char *describe_value(const Eval *ev, Value v, char *buffer, size_t size)
{
    static const char *const names[] = {
        [VALUE_UNSET] = "nothing",
        [VALUE_FORCING] = "nothing",
        [VALUE_ERROR] = "an error",
        [VALUE_NOTHING] = "nothing",
        [VALUE_BOOL] = "a bool",
        [VALUE_NUMBER] = "a number",
        [VALUE_STRING] = "a string",
        [VALUE_VECTOR] = "a vector",
        [VALUE_COLOR] = "a color",
        [VALUE_LIST] = "a list",
        [VALUE_RANGE] = "a range",
        [VALUE_FUNCTION] = "a function",
        [VALUE_BUILTIN] = "a function",
        [VALUE_NODE] = "a node",
        [VALUE_TRANSFORM] = "a transform",
        [VALUE_BOUNDS] = "the bounds of a shape",
        [VALUE_MEASURE] = "a measured number",
    };
    if (v.type == VALUE_SIGHT) {
        snprintf(buffer, size, "%s",
                 v.sight->object              ? "an object"
                 : v.sight->kind == SIGHT_RAY ? "a ray"
                 : isfinite(v.sight->x1)      ? "a region"
                                              : "a picture");
        return buffer;
    }
    if (v.type == VALUE_NODE) {
        return describe_node(ev, v.node, buffer, size);
    }
    if (v.type == VALUE_NUMBER) {
        const char *noun = dim_info((Dim)v.dim)->name;
        snprintf(buffer, size, "%s %s", article(noun), noun);
    } else if (v.type == VALUE_VECTOR && v.dim != DIM_NONE) {
        snprintf(buffer, size, "a vector of %d with the dimension %s", v.small,
                 dim_info((Dim)v.dim)->name);
    } else if (v.type == VALUE_VECTOR) {
        snprintf(buffer, size, "a vector of %d", v.small);
    } else if (v.type == VALUE_MEASURE && v.small == 3) {
        snprintf(buffer, size, "a measured color");
    } else {
        snprintf(buffer, size, "%s", names[v.type]);
    }
    return buffer;
}

// "a power or a luminous flux"
static size_t describe_dims(uint32_t dims, const char *plain, char *buffer, size_t size)
{
    size_t length = 0;
    uint32_t named = dims & ~DIM_BIT(DIM_NONE);
    if (!named) {
        return (size_t)snprintf(buffer, size, "a %s", plain);
    }
    buffer[0] = '\0';
    for (int dim = 1; dim < DIM_COUNT && length < size; ++dim) {
        if (named & DIM_BIT(dim)) {
            const char *noun = dim_info((Dim)dim)->name;
            named &= ~DIM_BIT(dim);
            const char *before = length == 0 ? "" : named ? ", " : " or ";
            length += (size_t)snprintf(buffer + length, size - length, "%s%s %s", before,
                                       article(noun), noun);
        }
    }
    return length < size ? length : size; // no further than the text itself
}

static void describe_choices(const Param *param, char *buffer, size_t size)
{
    size_t length = (size_t)snprintf(buffer, size, "one of");
    for (size_t i = 0; param->choices[i] && length < size; ++i) {
        length += (size_t)snprintf(buffer + length, size - length, "%s \"%s\"", i ? "," : "",
                                   param->choices[i]);
    }
}

const char *describe_param(const Param *param, char *buffer, size_t size)
{
    size_t length;
    switch (param->type) {
    case PARAM_BOOL:
        snprintf(buffer, size, "true or false");
        break;
    case PARAM_INT:
        snprintf(buffer, size, "a whole number");
        break;
    case PARAM_NUMBER:
    case PARAM_QUANTITY:
        describe_dims(param->dims, "number", buffer, size);
        break;
    case PARAM_NUMBER_TEX:
        length = describe_dims(param->dims, "number", buffer, size);
        snprintf(buffer + length, size - length, " or a texture");
        break;
    case PARAM_EMISSION:
        length = describe_dims(param->dims, "number", buffer, size);
        snprintf(buffer + length, size - length, ", a number, a color or a texture");
        break;
    case PARAM_CHOICE:
        describe_choices(param, buffer, size);
        break;
    case PARAM_FILE:
        snprintf(buffer, size, "the name of a file, as a string");
        break;
    case PARAM_NODE: {
        const char *noun = category_name(param->category);
        snprintf(buffer, size, "%s %s", article(noun), noun);
        break;
    }
    default:
        snprintf(buffer, size, "a %s", param_type_name(param->type));
    }
    return buffer;
}

// --- Values as text --------------------------------------------------------------------------

void text_add(Eval *ev, TextBuffer *out, const char *format, ...)
{
    for (;;) {
        size_t room = out->capacity - out->length;
        va_list arguments;
        va_start(arguments, format);
        int length = vsnprintf(room ? out->text + out->length : NULL, room, format, arguments);
        va_end(arguments);
        if (length < 0) { // excepted: no format used here fails
            return;
        }
        if ((size_t)length < room) {
            out->length += (size_t)length;
            return;
        }
        size_t capacity = (out->capacity + (size_t)length) * 2 + 64;
        char *grown = arena_alloc(ev->arena, capacity);
        if (out->length) {
            memcpy(grown, out->text, out->length);
        }
        out->text = grown;
        out->capacity = capacity;
    }
}

static void add_quantity(Eval *ev, TextBuffer *out, double number, uint8_t dim)
{
    char text[40];
    if (dim == DIM_ANGLE) { // as authors write angles
        format_number(number * (180 / PI), text, sizeof text);
        text_add(ev, out, "%sdeg", text);
        return;
    }
    format_number(number, text, sizeof text);
    text_add(ev, out, "%s%s", text, dim_info((Dim)dim)->si_unit);
}

static void add_components(Eval *ev, TextBuffer *out, Value v)
{
    text_add(ev, out, v.type == VALUE_COLOR ? "rgb(" : "(");
    for (int i = 0; i < v.small; ++i) {
        text_add(ev, out, i ? ", " : "");
        add_quantity(ev, out, v.components[i], v.dim);
    }
    text_add(ev, out, ")");
}

static void add_string(Eval *ev, TextBuffer *out, Value v, bool quoted)
{
    if (!count_steps(ev, v.count / (quoted ? 1 : BYTES_A_STEP), out->at)) {
        return;
    }
    if (!quoted) {
        text_add(ev, out, "%s", v.string); // which has no NUL but at its end
        return;
    }
    text_add(ev, out, "\"");
    for (uint32_t i = 0; i < v.count; ++i) {
        char c = v.string[i];
        const char *escape = c == '\n' ? "\\n" : c == '\t' ? "\\t" : c == '"' ? "\\\"" : NULL;
        escape = c == '\\' ? "\\\\" : escape;
        text_add(ev, out, escape ? "%s" : "%.1s", escape ? escape : v.string + i);
    }
    text_add(ev, out, "\"");
}

static void add_list(Eval *ev, TextBuffer *out, Value v)
{
    text_add(ev, out, "[");
    for (uint32_t i = 0; i < v.count && !ev->stop; ++i) {
        text_add(ev, out, i ? ", " : "");
        text_add_value(ev, out, v.items[i], true);
    }
    text_add(ev, out, "]");
}

static void add_function(Eval *ev, TextBuffer *out, Value v)
{
    if (v.type == VALUE_BUILTIN) {
        text_add(ev, out, "fn %s", builtins[v.count].name);
        return;
    }
    const Module *module = v.function->env->module;
    const AstNode *fn = &module->ast.nodes.items[v.function->fn];
    const uint32_t *words = ast_list_items(&module->ast, module->ast.extra.items[fn->b + 3]);
    uint32_t count = ast_list_count(&module->ast, module->ast.extra.items[fn->b + 3]);
    text_add(ev, out, "fn%s%s(", fn->a ? " " : "", symbol_name(ev->names, fn->a).at);
    for (uint32_t i = 0; i < count; ++i) {
        text_add(ev, out, "%s%s", i ? ", " : "",
                 symbol_name(ev->names, module->ast.nodes.items[words[i]].a).at);
    }
    text_add(ev, out, ")");
}

static void add_transform_text(Eval *ev, TextBuffer *out, const Affine *map)
{
    text_add(ev, out, "matrix(");
    for (int i = 0; i < 3; ++i) {
        Value row = {.type = VALUE_VECTOR, .small = 4, .components = map->m[i]};
        text_add(ev, out, i ? ", " : "");
        add_components(ev, out, row);
    }
    text_add(ev, out, ")");
}

void text_add_value(Eval *ev, TextBuffer *out, Value v, bool quoted)
{
    if (!out->text) {
        text_add(ev, out, "%s", ""); // a text all the same where a limit ends it at once
    }
    if (!count_step(ev, out->at)) {
        return;
    }
    if (stack_is_deep(ev)) {
        report_deep_stack(ev, out->at);
        return;
    }
    switch ((ValueType)v.type) {
    case VALUE_BOOL:
        text_add(ev, out, v.boolean ? "true" : "false");
        break;
    case VALUE_NUMBER:
        add_quantity(ev, out, v.number, v.dim);
        break;
    case VALUE_STRING:
        add_string(ev, out, v, quoted);
        break;
    case VALUE_VECTOR:
    case VALUE_COLOR:
        add_components(ev, out, v);
        break;
    case VALUE_LIST:
        add_list(ev, out, v);
        break;
    case VALUE_RANGE:
        text_add(ev, out, "%.0f..<%.0f", v.number, v.number + v.count);
        break;
    case VALUE_FUNCTION:
    case VALUE_BUILTIN:
        add_function(ev, out, v);
        break;
    case VALUE_NODE:
        text_add(ev, out, "%s { … }", ev->lang->schema->types[v.node->type]->name);
        break;
    case VALUE_TRANSFORM:
        add_transform_text(ev, out, v.transform);
        break;
    case VALUE_BOUNDS: {
        Vec3 a = v.bounds->min, b = v.bounds->max;
        text_add(ev, out, "bounds(");
        add_components(ev, out, (Value){.type = VALUE_VECTOR, .small = 3, .components = &a.x});
        text_add(ev, out, ", ");
        add_components(ev, out, (Value){.type = VALUE_VECTOR, .small = 3, .components = &b.x});
        text_add(ev, out, ")");
        break;
    }
    case VALUE_SIGHT:
        text_add_sight(ev, out, v.sight);
        break;
    case VALUE_MEASURE:
        text_add_measure(ev, out, v.measure);
        break;
    default:
        text_add(ev, out, "nothing");
    }
}
