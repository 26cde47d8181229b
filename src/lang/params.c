// `param name: type = default in range "description"` and the settings given from outside.
#include "lang/params.h"

#include <stdio.h>

typedef struct ParamWords {
    Symbol type;
    AstId value, range, description;
    Span type_at;
} ParamWords;

static ParamWords param_words(const Module *module, AstId item)
{
    const uint32_t *words = &module->ast.extra.items[module->ast.nodes.items[item].b];
    return (ParamWords){words[2], words[3], words[4], words[5], {module->file, words[6], words[7]}};
}

// --- Types -----------------------------------------------------------------------------------

// PARAM_KIND(name, type of the value, dimension, whether it is whole, manual line)
#define PARAM_KINDS(PARAM_KIND)                                                                    \
    PARAM_KIND(int, VALUE_NUMBER, DIM_NONE, true, "A whole number.")                               \
    PARAM_KIND(number, VALUE_NUMBER, DIM_NONE, false, "A bare number.")                            \
    PARAM_KIND(bool, VALUE_BOOL, DIM_NONE, false, "true or false.")                                \
    PARAM_KIND(string, VALUE_STRING, DIM_NONE, false, "Text.")                                     \
    PARAM_KIND(color, VALUE_COLOR, DIM_NONE, false, "A color.")                                    \
    PARAM_KIND(vector, VALUE_VECTOR, DIM_NONE, false, "A vector of 2 to 4 components.")            \
    PARAM_KIND(angle, VALUE_NUMBER, DIM_ANGLE, false, "An angle; it always needs a unit.")         \
    PARAM_KIND(length, VALUE_NUMBER, DIM_LENGTH, false, "A length.")                               \
    PARAM_KIND(time, VALUE_NUMBER, DIM_TIME, false, "A time.")                                     \
    PARAM_KIND(temperature, VALUE_NUMBER, DIM_TEMPERATURE, false, "A temperature.")                \
    PARAM_KIND(power, VALUE_NUMBER, DIM_POWER, false, "A power.")                                  \
    PARAM_KIND(luminous_flux, VALUE_NUMBER, DIM_LUMINOUS_FLUX, false, "A luminous flux.")          \
    PARAM_KIND(luminous_intensity, VALUE_NUMBER, DIM_LUMINOUS_INTENSITY, false,                    \
               "A luminous intensity.")                                                            \
    PARAM_KIND(illuminance, VALUE_NUMBER, DIM_ILLUMINANCE, false, "An illuminance.")               \
    PARAM_KIND(luminance, VALUE_NUMBER, DIM_LUMINANCE, false, "A luminance.")

typedef struct ParamKind {
    const char *name;
    ValueType type;
    Dim dim;
    bool whole;
} ParamKind;

static const ParamKind param_kinds[] = {
#define PARAM_KIND(name, type, dim, whole, doc) {#name, type, dim, whole},
    PARAM_KINDS(PARAM_KIND)
#undef PARAM_KIND
};

const ParamTypeName lang_param_types[] = {
#define PARAM_KIND(name, type, dim, whole, doc) {#name, doc},
    PARAM_KINDS(PARAM_KIND)
#undef PARAM_KIND
};
const size_t lang_param_type_count = sizeof lang_param_types / sizeof lang_param_types[0];

enum { PARAM_KIND_COUNT = sizeof param_kinds / sizeof param_kinds[0] };

static const ParamKind *find_kind(Eval *ev, const ParamWords *words)
{
    Str name = symbol_name(ev->names, words->type), best = {0};
    size_t distance = SIZE_MAX;
    for (int i = 0; i < PARAM_KIND_COUNT; ++i) {
        if (str_equal(name, str_from(param_kinds[i].name))) {
            return &param_kinds[i];
        }
        suggest_name(name, str_from(param_kinds[i].name), &best, &distance);
    }
    Diag *diag = report(ev, E0313, words->type_at, "there is no type `%s` of a param", name.at);
    if (best.length) {
        diag_suggest(ev->sink, diag, words->type_at, best.at);
    }
    diag_note(ev->sink, diag,
              "the types are int, number, bool, string, color, vector, angle, "
              "length, time, temperature, power, luminous_flux, "
              "luminous_intensity, illuminance and luminance");
    return NULL;
}

// A bare number is in the SI unit of the type, except for angles: as in fields.
static bool coerce(Eval *ev, const ParamKind *kind, const char *name, Value *v, Where where)
{
    char found[DESCRIBE_SIZE];
    if (v->type != kind->type) {
        report(ev, E0414, where_span(where), "`%s` takes a value of type %s, not %s", name,
               kind->name, describe_value(ev, *v, found, sizeof found));
        return false;
    }
    if (kind->type == VALUE_NUMBER && v->dim != kind->dim) {
        if (v->dim == DIM_NONE && kind->dim != DIM_ANGLE) {
            v->dim = (uint8_t)kind->dim;
            return true;
        }
        const char *unit = kind->dim == DIM_ANGLE ? "deg" : dim_info(kind->dim)->si_unit;
        Diag *diag = report(ev, E0414, where_span(where), "`%s` takes a value of type %s, not %s",
                            name, kind->name, describe_value(ev, *v, found, sizeof found));
        if (kind->dim != DIM_NONE) {
            diag_note(ev->sink, diag, "give it a unit, as in 1%s", unit);
        }
        return false;
    }
    if (kind->whole && v->number != floor(v->number)) {
        report(ev, E0412, where_span(where), "`%s` takes a whole number", name);
        return false;
    }
    return true;
}

// --- Ranges ----------------------------------------------------------------------------------

static bool range_number(Eval *ev, Env *env, AstId id, uint8_t dim, double *out)
{
    Value v = eval(ev, env, id);
    if (v.type == VALUE_NUMBER && (v.dim == dim || v.dim == DIM_NONE)) {
        *out = v.number;
        return true;
    }
    if (!is_error(v)) {
        char found[DESCRIBE_SIZE], wanted[DESCRIBE_SIZE];
        report(ev, E0414, env_span(env, id), "the range is of %s, the param of %s",
               describe_value(ev, v, found, sizeof found),
               describe_value(ev, value_number(0, dim), wanted, sizeof wanted));
    }
    return false;
}

bool param_range(Eval *ev, Env *env, AstId item, uint8_t dim, ParamRange *out)
{
    AstId range = param_words(env->module, item).range;
    *out = (ParamRange){.min = -INFINITY, .max = INFINITY};
    const AstNode *node = env_node(env, range);
    if (!range) {
        return true;
    }
    if (node->tag == AST_RANGE) {
        out->exclude_max = node->aux != 0;
        bool first = range_number(ev, env, node->a, dim, &out->min);
        return range_number(ev, env, node->b, dim, &out->max) && first;
    }
    out->choices = eval(ev, env, range);
    if (out->choices.type == VALUE_LIST) {
        return true;
    }
    if (!is_error(out->choices)) {
        report(ev, E0414, env_span(env, range),
               "after `in` stands a range, as in 1..10, or a list of choices");
    }
    return false;
}

static bool is_choice(Eval *ev, const ParamRange *range, Value v, Span at)
{
    for (uint32_t i = 0; i < range->choices.count; ++i) {
        if (values_equal(ev, range->choices.items[i], v, at)) {
            return true;
        }
    }
    return false;
}

static bool check_param_range(Eval *ev, Env *env, AstId item, Value v, Where where)
{
    ParamRange range;
    const char *name = symbol_name(ev->names, item_symbol(env->module, item)).at;
    if (!param_range(ev, env, item, v.dim, &range)) {
        return false;
    }
    Span at = where_span(where);
    TextBuffer is = {0}, limits = {0};
    text_add_value(ev, &is, v, true);
    if (range.choices.type == VALUE_LIST) {
        if (is_choice(ev, &range, v, at)) {
            return true;
        }
        text_add_value(ev, &limits, range.choices, true);
        report(ev, E0404, at, "`%s` must be one of %s, not %s", name, limits.text, is.text);
        return false;
    }
    if (v.type != VALUE_NUMBER) {
        if (param_words(env->module, item).range) {
            report(ev, E0414, at, "only a number has a range from … to …");
            return false;
        }
        return true;
    }
    if (v.number >= range.min &&
        (range.exclude_max ? v.number < range.max : v.number <= range.max)) {
        return true;
    }
    text_add_value(ev, &limits, value_number(range.min, v.dim), true);
    text_add(ev, &limits, range.exclude_max ? "..<" : "..");
    text_add_value(ev, &limits, value_number(range.max, v.dim), true);
    report(ev, E0404, at, "`%s` must lie in %s, this is %s", name, limits.text, is.text);
    return false;
}

// --- Settings --------------------------------------------------------------------------------

// The param that `--set name=…` means: one of the scene's own, or `namespace.name`.
static bool setting_is_for(Eval *ev, Str setting, const Module *module, Symbol param)
{
    Str name = symbol_name(ev->names, param);
    const Module *scene = ev->modules.items[0];
    if (module == scene) {
        return str_equal(setting, name);
    }
    const char *dot = memchr(setting.at, '.', setting.length);
    size_t before = dot ? (size_t)(dot - setting.at) : setting.length;
    Str space = {setting.at, before};
    Str last = {dot + 1, setting.length - before - (dot ? 1 : 0)};
    if (!dot || !str_equal(last, name)) {
        return false;
    }
    int64_t slot = module_find(scene, interned(ev->names, space));
    if (slot < 0) {
        return false;
    }
    const AstNode *import = &scene->ast.nodes.items[scene->globals.items[slot].item];
    return import->tag == AST_IMPORT && import->aux == module->number + 1;
}

static const ParamSetting *find_setting(Eval *ev, const Module *module, Symbol param)
{
    const ParamSetting *found = NULL;
    for (size_t i = 0; i < ev->lang->setting_count; ++i) {
        const ParamSetting *setting = &ev->lang->settings[i];
        if (setting_is_for(ev, setting->name, module, param)) {
            found = setting; // the last one counts
            ev->settings_used[i / 64] |= (uint64_t)1 << (i % 64);
        }
    }
    return found;
}

static bool is_word(Str text)
{
    if (text.length == 0 || str_equal(text, STR("true")) || str_equal(text, STR("false"))) {
        return false;
    }
    for (size_t i = 0; i < text.length; ++i) {
        unsigned char c = (unsigned char)text.at[i];
        bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c >= 128;
        bool inner = (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '/';
        if (!letter && (i == 0 || !inner)) {
            return false;
        }
    }
    return true;
}

// The setting's text as a file of its own, `let name = text`, which sees built-ins only.
static Value setting_value(Eval *ev, const ParamSetting *setting, const ParamKind *kind,
                           Where *where)
{
    TextBuffer text = {0};
    text_add(ev, &text, "let %.*s = ", (int)setting->name.length, setting->name.at);
    Str given = setting->value;
    bool is_quoted = given.length && given.at[0] == '"';
    if (!is_quoted && (kind->type == VALUE_STRING || is_word(given))) {
        Value string = {.type = VALUE_STRING, .count = (uint32_t)given.length, .string = given.at};
        text_add_value(ev, &text, string, true);
    } else {
        text_add(ev, &text, "%.*s", (int)given.length, given.at);
    }
    for (size_t i = 0; i < 4 + setting->name.length; ++i) {
        text.text[i] = text.text[i] == '.' ? '_' : text.text[i];
    }
    Sources *sources = &ev->lang->sources;
    char *copy = arena_copy_string(&ev->lang->arena, text.text, text.length);
    uint32_t file =
        copy ? sources_add(sources, "--set", NULL, (Str){copy, text.length}, (Span){0}) : 0;
    if (!file) {
        out_of_memory(ev);
    }
    Module *module = module_load_text(ev, file, true);
    if (module->failed) {
        return value_error();
    }
    const Ast *ast = &module->ast;
    uint32_t list = ast->nodes.items[ast->root].a;
    if (module->globals.count != 1 || ast_list_count(ast, list) != 1) {
        report(ev, E0414, ast_span(ast, ast->root), "a setting is one value");
        return value_error();
    }
    AstId item = module->globals.items[0].item;
    *where = (Where){module, ast->extra.items[ast->nodes.items[item].b + 2]};
    return force_slot(ev, module->env, 0, item);
}

Value eval_param(Eval *ev, Env *env, AstId item)
{
    Module *module = env->module;
    ParamWords words = param_words(module, item);
    Symbol symbol = item_symbol(module, item);
    const char *name = symbol_name(ev->names, symbol).at;
    Where where = {module, words.value};
    Value v = words.value ? eval(ev, env, words.value) : value_error();
    const ParamKind *kind = find_kind(ev, &words);
    if (!kind) {
        return value_error();
    }
    // The default has to be sound even where a setting replaces it.
    bool good = !is_error(v) && coerce(ev, kind, name, &v, where) &&
                check_param_range(ev, env, item, v, where);
    const ParamSetting *setting = find_setting(ev, module, symbol);
    if (good && setting) {
        v = setting_value(ev, setting, kind, &where);
        good = !is_error(v) && coerce(ev, kind, name, &v, where) &&
               check_param_range(ev, env, item, v, where);
    }
    return good ? v : value_error();
}

bool check_settings(Eval *ev, Module *module)
{
    Diag *diag = NULL;
    for (size_t i = 0; i < ev->lang->setting_count; ++i) {
        if (ev->settings_used[i / 64] >> (i % 64) & 1) {
            continue;
        }
        Str given = ev->lang->settings[i].name, best = {0};
        size_t distance = SIZE_MAX;
        for (size_t k = 0; k < module->globals.count; ++k) {
            const Global *global = &module->globals.items[k];
            if (module->ast.nodes.items[global->item].tag == AST_PARAM) {
                suggest_name(given, symbol_name(ev->names, global->name), &best, &distance);
            }
        }
        if (diag) { // which stands nowhere, so that one is all that is kept
            diag_note(ev->sink, diag, "nor for --set %.*s", (int)given.length, given.at);
        } else {
            diag = report(ev, E0309, (Span){0}, "--set %.*s: the scene has no such param",
                          (int)given.length, given.at);
        }
        if (best.length) {
            diag_note(ev->sink, diag, "did you mean `%s`?", best.at);
        }
    }
    return !diag;
}

// --- As JSON ---------------------------------------------------------------------------------

static void json_string(FILE *out, Str text)
{
    fputc('"', out);
    for (size_t i = 0; i < text.length; ++i) {
        unsigned char c = (unsigned char)text.at[i];
        if (c == '"' || c == '\\') {
            fprintf(out, "\\%c", c);
        } else if (c < 0x20) {
            fprintf(out, "\\u%04x", c);
        } else {
            fputc(c, out);
        }
    }
    fputc('"', out);
}

static void json_value(Eval *ev, FILE *out, Value v)
{
    if (is_bare(v) || v.type == VALUE_BOOL) {
        TextBuffer text = {0};
        text_add_value(ev, &text, v, false);
        fputs(text.length ? text.text : "null", out); // nothing: evaluation was stopped
    } else if (v.type == VALUE_LIST) {
        fputc('[', out);
        for (uint32_t i = 0; i < v.count; ++i) {
            fputs(i ? ", " : "", out);
            json_value(ev, out, v.items[i]);
        }
        fputc(']', out);
    } else if (is_error(v)) {
        fputs("null", out);
    } else {
        TextBuffer text = {0};
        text_add_value(ev, &text, v, false);
        json_string(out, (Str){text.text ? text.text : "", text.length});
    }
}

// `space`: the namespace of an imported file, with its dot; or "".
static void json_param(Eval *ev, Env *env, uint32_t slot, AstId item, const char *space, FILE *out)
{
    ParamWords words = param_words(env->module, item);
    Value v = force_slot(ev, env, slot, item);
    Value standard = eval(ev, env, words.value);
    const ParamKind *kind = find_kind(ev, &words);
    if (kind && standard.type == VALUE_NUMBER && standard.dim == DIM_NONE) {
        standard.dim = (uint8_t)kind->dim;
    }
    fputs("{\"name\": ", out);
    TextBuffer name = {0};
    text_add(ev, &name, "%s%s", space, symbol_name(ev->names, item_symbol(env->module, item)).at);
    json_string(out, (Str){name.text, name.length});
    fprintf(out, ", \"type\": \"%s\", \"default\": ", kind ? kind->name : "");
    json_value(ev, out, standard);
    fputs(", \"value\": ", out);
    json_value(ev, out, v);
    ParamRange range;
    uint8_t dim = kind ? (uint8_t)kind->dim : v.dim; // v may be an error
    if (words.range && param_range(ev, env, item, dim, &range)) {
        if (range.choices.type == VALUE_LIST) {
            fputs(", \"choices\": ", out);
            json_value(ev, out, range.choices);
        } else {
            fputs(", \"min\": ", out);
            json_value(ev, out, value_number(range.min, dim));
            fputs(", \"max\": ", out);
            json_value(ev, out, value_number(range.max, dim));
            fputs(range.exclude_max ? ", \"exclude_max\": true" : "", out);
        }
    }
    fputs(", \"description\": ", out);
    json_string(out, words.description ? symbol_name(ev->names, env_node(env, words.description)->a)
                                       : (Str){"", 0});
    fputc('}', out);
}

static void json_params(Eval *ev, const Module *module, const char *space, bool *first, FILE *out)
{
    for (uint32_t slot = 0; slot < module->globals.count; ++slot) {
        AstId item = module->globals.items[slot].item;
        if (module->ast.nodes.items[item].tag == AST_PARAM) {
            fputs(*first ? "\n  " : ",\n  ", out);
            json_param(ev, module->env, slot, item, space, out);
            *first = false;
        }
    }
}

// The file that a global of `module` imports, if it is sound and no global before imports it, too.
static const Module *imported_first(Eval *ev, const Module *module, uint32_t slot)
{
    const AstNode *nodes = module->ast.nodes.items;
    const AstNode *import = &nodes[module->globals.items[slot].item];
    if (import->tag != AST_IMPORT || import->aux == 0) {
        return NULL;
    }
    for (uint32_t before = 0; before < slot; ++before) {
        const AstNode *other = &nodes[module->globals.items[before].item];
        if (other->tag == AST_IMPORT && other->aux == import->aux) {
            return NULL;
        }
    }
    const Module *imported = ev->modules.items[import->aux - 1];
    return imported->failed || !imported->env || imported == module ? NULL : imported;
}

void params_write_json(Eval *ev, const Module *module, FILE *out)
{
    bool first = true;
    fputc('[', out);
    json_params(ev, module, "", &first, out);
    for (uint32_t slot = 0; slot < module->globals.count; ++slot) {
        const Module *imported = imported_first(ev, module, slot);
        if (imported) {
            TextBuffer space = {0};
            text_add(ev, &space, "%s.",
                     symbol_name(ev->names, module->globals.items[slot].name).at);
            json_params(ev, imported, space.text, &first, out);
        }
    }
    fputs(first ? "]\n" : "\n]\n", out);
}
