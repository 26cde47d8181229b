// What the evaluator knows of the schema beforehand: symbols of kinds and fields, defaults.
#include "lang/eval.h"

#include <stdio.h>

static Symbol known(Eval *ev, const char *name)
{
    Symbol symbol = intern(ev->names, str_from(name));
    if (!symbol) {
        out_of_memory(ev);
    }
    return symbol;
}

static void intern_fields(Eval *ev, KindInfo *kind)
{
    const NodeType *type = kind->type;
    kind->fields = arena_array(&ev->regions[0], type->param_count, sizeof *kind->fields);
    kind->shape_field = -1;
    for (size_t i = 0; i < type->param_count; ++i) {
        const Param *param = &type->params[i];
        kind->fields[i] = known(ev, param->name);
        if ((param->flags & PARAM_REQUIRED) && type->role == ROLE_PLAIN) {
            kind->required |= (uint64_t)1 << i;
        }
        if (type->category == CATEGORY_LIGHT && param->type == PARAM_NODE &&
            param->category == CATEGORY_SHAPE) {
            kind->shape_field = (int)i;
        }
    }
}

static void intern_all(Eval *ev)
{
    const Schema *schema = ev->lang->schema;
    for (size_t i = 0; i < schema->type_count; ++i) {
        ev->kinds[i].type = schema->types[i];
        known(ev, schema->types[i]->name);
        intern_fields(ev, &ev->kinds[i]);
        if (schema->types[i]->role == ROLE_GROUP) {
            ev->group_type = (int)i;
        }
        if (strcmp(schema->types[i]->name, "texture_math") == 0) {
            ev->texture_math = (int)i;
        }
    }
    for (uint32_t i = 0; i < builtin_count; ++i) {
        known(ev, builtins[i].name);
    }
    for (uint32_t bit = 1; bit <= COMMON_COLOR; bit <<= 1) {
        known(ev, common_field_name((CommonField)bit));
    }
    ev->symbol_items = known(ev, "items");
    ev->symbol_of = known(ev, "of");
}

static SymbolInfo *symbol_info(Eval *ev, const char *name)
{
    return &ev->symbols[interned(ev->names, str_from(name))];
}

void kinds_init(Eval *ev)
{
    const Schema *schema = ev->lang->schema;
    ev->group_type = ev->texture_math = -1;
    ev->kinds = arena_alloc_zeroed(&ev->regions[0], schema->type_count * sizeof *ev->kinds);
    intern_all(ev);
    ev->symbol_count = ev->names->count + 1;
    ev->symbols = arena_alloc_zeroed(&ev->regions[0], ev->symbol_count * sizeof *ev->symbols);
    for (size_t i = 0; i < schema->type_count; ++i) {
        if (!schema->types[i]->internal) {
            symbol_info(ev, schema->types[i]->name)->kind = (uint16_t)(i + 1);
        }
    }
    for (uint32_t i = 0; i < builtin_count; ++i) {
        symbol_info(ev, builtins[i].name)->builtin = (uint16_t)(i + 1);
    }
    for (uint32_t bit = 1; bit <= COMMON_COLOR; bit <<= 1) {
        symbol_info(ev, common_field_name((CommonField)bit))->common = (uint16_t)bit;
    }
}

int field_index(const Eval *ev, uint32_t type, Symbol name)
{
    const KindInfo *kind = &ev->kinds[type];
    if (kind->type->role == ROLE_GROUP && name == ev->symbol_items) {
        return FIELD_ITEMS;
    }
    if (kind->type->role == ROLE_INSTANCE && name == ev->symbol_of) {
        return FIELD_OF;
    }
    for (size_t i = 0; i < kind->type->param_count; ++i) {
        if (kind->fields[i] == name) {
            return (int)i + 1;
        }
    }
    uint32_t common = name < ev->symbol_count ? ev->symbols[name].common : 0;
    return common & category_common_fields(kind->type->category) ? (int)(FIELD_COMMON | common)
                                                                 : FIELD_BAD;
}

static void add_field_name(char *text, size_t size, size_t *length, const char *name)
{
    if (*length < size) {
        *length +=
            (size_t)snprintf(text + *length, size - *length, "%s%s", *length ? ", " : "", name);
    }
}

// "burley takes color, roughness"; a material's `name` goes without saying.
static void note_fields(Eval *ev, Diag *diag, const NodeType *type)
{
    char text[512] = "";
    size_t length = 0;
    if (type->role == ROLE_GROUP) {
        add_field_name(text, sizeof text, &length, "items");
    } else if (type->role == ROLE_INSTANCE) {
        add_field_name(text, sizeof text, &length, "of");
    }
    for (size_t i = 0; i < type->param_count && type->role == ROLE_PLAIN; ++i) {
        add_field_name(text, sizeof text, &length, type->params[i].name);
    }
    uint32_t common = category_common_fields(type->category);
    for (uint32_t bit = 1; type->category != CATEGORY_MATERIAL && bit <= common; bit <<= 1) {
        if (common & bit) {
            add_field_name(text, sizeof text, &length, common_field_name((CommonField)bit));
        }
    }
    diag_note(ev->sink, diag, length ? "%s takes %s" : "%s takes no fields", type->name, text);
}

void report_unknown_field(Eval *ev, uint32_t type, Symbol name, Span at)
{
    const NodeType *kind = ev->kinds[type].type;
    Str text = symbol_name(ev->names, name);
    Diag *diag = report(ev, E0301, at, "`%s` is not a field of `%s`", text.at, kind->name);
    const char *near = node_type_suggest_param(kind, text);
    if (near) {
        diag_suggest(ev->sink, diag, at, near);
    }
    note_fields(ev, diag, kind);
}

// --- Defaults --------------------------------------------------------------------------------

// What a parameter holds that was neither given nor has a default: zeros, and no node.
static void clear_param(const Param *param, char *params)
{
    const uint32_t none = NONE_ID;
    size_t offset = param->offset;
    switch (param->type) {
    case PARAM_NODE:
        break;
    case PARAM_NUMBER_TEX:
        offset += offsetof(NumberTex, texture);
        break;
    case PARAM_PAIR_TEX:
        offset += offsetof(PairTex, texture);
        break;
    case PARAM_COLOR_TEX:
        offset += offsetof(ColorTex, texture);
        break;
    case PARAM_EMISSION:
        offset += offsetof(Emission, texture);
        break;
    default:
        return;
    }
    memcpy(params + offset, &none, sizeof none);
}

// All defaults of a kind as the source of a file, `let p0 = …` and so on; 0 without any.
static uint32_t defaults_source(Eval *ev, const NodeType *type)
{
    TextBuffer text = {0};
    for (size_t i = 0; i < type->param_count; ++i) {
        if (type->params[i].default_text && type->role == ROLE_PLAIN) {
            text_add(ev, &text, "let p%zu = %s\n", i, type->params[i].default_text);
        }
    }
    if (!text.length) {
        return 0;
    }
    char shown[128];
    snprintf(shown, sizeof shown, "(defaults of %s)", type->name);
    Sources *sources = &ev->lang->sources;
    char *copy = arena_copy_string(&ev->lang->arena, text.text, text.length);
    uint32_t file =
        copy ? sources_add(sources, shown, NULL, (Str){copy, text.length}, (Span){0}) : 0;
    if (!file) {
        out_of_memory(ev);
    }
    return file;
}

static bool fill_defaults(Eval *ev, uint32_t number, char *params)
{
    const NodeType *type = ev->kinds[number].type;
    for (size_t i = 0; i < type->param_count; ++i) {
        clear_param(&type->params[i], params);
    }
    uint32_t file = defaults_source(ev, type);
    if (!file) {
        return true;
    }
    Module *module = module_load_text(ev, file, true);
    NodeValue node = {.type = (uint16_t)number, .scene_id = NONE_ID, .params = params};
    bool good = !module->failed;
    for (uint32_t slot = 0; slot < module->globals.count; ++slot) {
        AstId item = module->globals.items[slot].item;
        Str name = symbol_name(ev->names, module->globals.items[slot].name);
        int index = 0;
        for (size_t i = 1; i < name.length; ++i) {
            index = index * 10 + (name.at[i] - '0');
        }
        Value v = force_slot(ev, module->env, slot, item);
        AstId expression = module->ast.extra.items[module->ast.nodes.items[item].b + 2];
        good = !is_error(v) && fill_param(ev, &node, index, v, (Where){module, expression}) && good;
    }
    return good;
}

// Made once, by the language's own parser and evaluator; in the region that is never rewound.
const char *kind_defaults(Eval *ev, uint32_t type)
{
    KindInfo *kind = &ev->kinds[type];
    if (kind->defaults || kind->making) {
        return kind->defaults;
    }
    must_be_alone(ev);
    kind->making = true; // and for good, if this fails: it is reported once
    uint32_t region = ev->region;
    CallFrame *calls = ev->calls;
    ev->region = 0;
    ev->arena = &ev->regions[0];
    ev->calls = NULL;
    char *params = arena_alloc_zeroed(ev->arena, kind->type->size);
    if (fill_defaults(ev, type, params)) {
        kind->defaults = params;
    }
    ev->calls = calls;
    ev->region = region;
    ev->arena = &ev->regions[region];
    return kind->defaults;
}
