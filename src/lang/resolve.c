#include "lang/resolve.h"

#include "base/hash.h"
#include "lang/numeric.h"

#include <stdio.h>

// The resolver walks each tree once and writes into its nodes what names mean (see NameKind), which
// kind and field is meant, numbers in SI and colors decoded, so that nothing is looked up when the
// scene is evaluated. What can be known without evaluating is reported here: unknown names, kinds
// and fields, fields given twice or missing, names declared twice or never used.
//
// Depth: the parser bounds every path in the tree (ast_deepest), so recursion is safe.

static void resolve_expression(Resolver *r, AstId id);
static void resolve_items(Resolver *r, const uint32_t *items, uint32_t count);

static AstNode *node_at(const Resolver *r, AstId id)
{
    return &r->ast->nodes.items[id];
}

static Span span_at(const Resolver *r, AstId id)
{
    return ast_span(r->ast, id);
}

// The span of a name that begins at the begin of its node.
static Span name_span(const Resolver *r, AstId id, Symbol name)
{
    Span span = span_at(r, id);
    span.end = span.begin + (uint32_t)symbol_name(r->ev->names, name).length;
    return span;
}

static void suggest(Resolver *r, Diag *diag, Span at, Str text)
{
    if (text.length) {
        diag_suggest(r->ev->sink, diag, at, text.at);
    }
}

// --- Names -----------------------------------------------------------------------------------

static void report_unknown_name(Resolver *r, AstId id, Symbol name)
{
    Eval *ev = r->ev;
    Str text = symbol_name(ev->names, name);
    Diag *diag = report(ev, E0302, span_at(r, id), "there is no name `%s` here", text.at);
    if (name < ev->symbol_count && ev->symbols[name].kind) {
        diag_label(ev->sink, diag, "`%s` is a kind: write `%s { … }`", text.at, text.at);
        Span end = span_at(r, id);
        end.begin = end.end;
        diag_suggest(ev->sink, diag, end, " {}");
    } else if (diag_is_kept(ev->sink, diag)) {
        suggest(r, diag, span_at(r, id), scope_suggest(r, text));
    }
}

static void resolve_to_binding(Resolver *r, AstNode *node, const Binding *binding)
{
    bool is_variable = binding->kind == BINDING_PARAMETER || binding->kind == BINDING_LOOP;
    if (binding->kind == BINDING_IMPORT) {
        node->op = NAME_NAMESPACE;
        node->a = r->ast->nodes.items[binding->item].aux;
        node->b = binding->item;
        return;
    }
    node->op = is_variable ? NAME_VARIABLE : binding->frame == 0 ? NAME_GLOBAL : NAME_LET;
    node->aux = (uint16_t)(r->frame - binding->frame);
    node->a = binding->slot;
    node->b = binding->item;
}

// One of the built-in quantities; or nothing, which is reported.
static void resolve_constant(Resolver *r, AstId id, Symbol name)
{
    AstNode *node = node_at(r, id);
    int constant = constant_find(symbol_name(r->ev->names, name));
    if (constant >= 0) {
        node->op = NAME_CONSTANT;
        node->a = (uint32_t)constant;
        r->ev->lang->moves |= lang_constants[constant].moment >= 0;
        return;
    }
    node->op = NAME_BAD;
    if (!r->module->failed) { // else its declaration may be what could not be parsed
        report_unknown_name(r, id, name);
    }
}

static void resolve_name(Resolver *r, AstId id)
{
    AstNode *node = node_at(r, id);
    Symbol name = node->a;
    const Binding *binding = scope_find(r, name);
    if (binding) {
        resolve_to_binding(r, node, binding);
    } else if (name < r->ev->symbol_count && r->ev->symbols[name].builtin) {
        node->op = NAME_BUILTIN;
        node->a = r->ev->symbols[name].builtin - 1u;
    } else {
        resolve_constant(r, id, name);
    }
}

static void resolve_name_as_value(Resolver *r, AstId id)
{
    Symbol name = node_at(r, id)->a;
    resolve_name(r, id);
    if (node_at(r, id)->op == NAME_NAMESPACE) {
        const char *text = symbol_name(r->ev->names, name).at;
        Diag *diag = report(r->ev, E0310, span_at(r, id), "`%s` is a namespace, not a value", text);
        diag_label(r->ev->sink, diag, "write `%s.name`", text);
        node_at(r, id)->op = NAME_BAD;
    }
}

static Str suggest_global(const Resolver *r, const Module *module, Str name)
{
    Str best = {0};
    size_t distance = SIZE_MAX;
    for (size_t i = 0; i < module->globals.count; ++i) {
        if (module->ast.nodes.items[module->globals.items[i].item].tag != AST_IMPORT) {
            suggest_name(name, symbol_name(r->ev->names, module->globals.items[i].name), &best,
                         &distance);
        }
    }
    return best;
}

// `namespace.name`
static void resolve_global_member(Resolver *r, AstId id, Symbol space)
{
    Eval *ev = r->ev;
    AstNode *node = node_at(r, id);
    uint32_t number = node_at(r, node->a)->a;
    node->op = MEMBER_BAD;
    if (number == 0 || ev->modules.items[number - 1]->failed) {
        return; // the import was reported
    }
    Module *module = ev->modules.items[number - 1];
    Symbol name = node->b;
    int64_t slot = module_find(module, name);
    if (slot >= 0 && module->ast.nodes.items[module->globals.items[slot].item].tag != AST_IMPORT) {
        module->globals.items[slot].used = true;
        node->op = MEMBER_GLOBAL;
        node->aux = (uint16_t)(number - 1);
        node->b = (uint32_t)slot;
        return;
    }
    Str text = symbol_name(ev->names, name);
    Span at = span_at(r, id);
    at.begin = at.end - (uint32_t)text.length;
    Diag *diag =
        report(ev, E0308, at, "`%s` has no name `%s`", symbol_name(ev->names, space).at, text.at);
    if (diag_is_kept(ev->sink, diag)) {
        suggest(r, diag, at, suggest_global(r, module, text));
    }
}

static void resolve_member(Resolver *r, AstId id)
{
    AstId value = node_at(r, id)->a;
    node_at(r, id)->op = MEMBER_VALUE;
    if (node_at(r, value)->tag != AST_NAME) {
        resolve_expression(r, value);
        return;
    }
    Symbol space = node_at(r, value)->a;
    resolve_name(r, value);
    if (node_at(r, value)->op == NAME_NAMESPACE) {
        resolve_global_member(r, id, space);
    }
}

// --- Literals --------------------------------------------------------------------------------

static void resolve_number(Resolver *r, AstId id)
{
    AstNode *node = node_at(r, id);
    node->op = DIM_NONE;
    if (node->aux) {
        const UnitInfo *unit = &schema_units[node->aux - 1];
        double number = ast_number(node) * unit->factor;
        node->op = (uint8_t)unit->dim;
        memcpy(&node->a, &number, sizeof node->a);
        memcpy(&node->b, (const char *)&number + sizeof node->a, sizeof node->b);
    }
}

static void resolve_color(Resolver *r, AstId id)
{
    AstNode *node = node_at(r, id);
    Value color =
        make_color(r->ev, decode_srgb((node->a >> 16 & 255) / 255.0),
                   decode_srgb((node->a >> 8 & 255) / 255.0), decode_srgb((node->a & 255) / 255.0));
    if (!array_push(&r->module->constants, color)) {
        out_of_memory(r->ev);
    }
    node->a = (uint32_t)(r->module->constants.count - 1);
    node->op = COLOR_DECODED;
}

// --- Frames ----------------------------------------------------------------------------------

static uint32_t frame_begin(Resolver *r)
{
    uint32_t outer = r->next_slot;
    r->next_slot = 0;
    ++r->frame;
    return outer;
}

// Writes the number of slots of the frame into its node's aux.
static void frame_end(Resolver *r, AstId id, uint32_t outer)
{
    if (r->next_slot > UINT16_MAX) {
        report(r->ev, E0710, span_at(r, id), "more than %d names in one function or loop",
               UINT16_MAX);
    }
    node_at(r, id)->aux = (uint16_t)r->next_slot;
    r->next_slot = outer;
    --r->frame;
}

static void resolve_fn(Resolver *r, AstId id)
{
    const AstNode *node = node_at(r, id);
    bool is_anonymous = node->a == 0;
    const uint32_t *words = &r->ast->extra.items[node->b];
    AstId body = words[2];
    uint32_t count = ast_list_count(r->ast, words[3]);
    const uint32_t *parameters = ast_list_items(r->ast, words[3]);
    uint32_t outer = frame_begin(r);
    ++r->function;
    ScopeMark scope = scope_begin(r);
    for (uint32_t i = 0; i < count; ++i) {
        Symbol name = node_at(r, parameters[i])->a;
        scope_declare(r, name, BINDING_PARAMETER, parameters[i], name_span(r, parameters[i], name))
            ->quiet = is_anonymous;
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (node_at(r, parameters[i])->b) {
            resolve_expression(r, node_at(r, parameters[i])->b);
        }
    }
    resolve_expression(r, body);
    scope_end(r, scope);
    --r->function;
    frame_end(r, id, outer);
}

static void resolve_for(Resolver *r, AstId id)
{
    const AstNode *node = node_at(r, id);
    Symbol name = node->a;
    const uint32_t *words = &r->ast->extra.items[node->b];
    Span at = {r->module->file, words[0], words[1]};
    AstId sequence = words[2], body = words[3];
    resolve_expression(r, sequence);
    uint32_t outer = frame_begin(r);
    ScopeMark scope = scope_begin(r);
    scope_declare(r, name, BINDING_LOOP, id, at)->quiet = true;
    resolve_expression(r, body);
    scope_end(r, scope);
    frame_end(r, id, outer);
}

// --- Kinds and fields ------------------------------------------------------------------------

typedef struct GivenFields {
    uint64_t params;
    uint32_t others; // FIELD_COMMON bits, FIELD_ITEMS and FIELD_OF
} GivenFields;

static bool give_field(GivenFields *given, int field)
{
    uint32_t bit = field == FIELD_ITEMS   ? 0x10000
                   : field == FIELD_OF    ? 0x20000
                   : field & FIELD_COMMON ? (uint32_t)field & 0xff
                                          : 0;
    uint64_t param = bit ? 0 : (uint64_t)1 << (field - 1);
    bool twice = (given->others & bit) || (given->params & param);
    given->others |= bit;
    given->params |= param;
    return !twice;
}

static void resolve_field(Resolver *r, AstId id, uint32_t kind, GivenFields *given)
{
    AstNode *node = node_at(r, id);
    Symbol name = node->a;
    AstId value = node->b;
    int field = kind && name ? field_index(r->ev, kind - 1, name) : FIELD_BAD;
    node->aux = (uint16_t)field;
    if (kind && name && field == FIELD_BAD) {
        report_unknown_field(r->ev, kind - 1, name, name_span(r, id, name));
    } else if (field != FIELD_BAD && !give_field(given, field)) {
        Diag *diag = report(r->ev, E0306, name_span(r, id, name), "`%s` is given twice",
                            symbol_name(r->ev->names, name).at);
        diag_label(r->ev->sink, diag, "the second time");
        node_at(r, id)->aux = FIELD_BAD;
    }
    resolve_expression(r, value);
}

static void report_missing(Resolver *r, AstId id, const KindInfo *kind, uint64_t missing,
                           bool of_is_missing)
{
    const char *names[64];
    size_t count = 0;
    if (of_is_missing) {
        names[count++] = "of";
    }
    for (size_t i = 0; i < kind->type->param_count && count < 64; ++i) {
        if (missing >> i & 1) {
            names[count++] = kind->type->params[i].name;
        }
    }
    char text[512] = "";
    size_t length = 0;
    for (size_t i = 0; i < count && length < sizeof text; ++i) {
        const char *before = i == 0 ? "" : i + 1 == count ? " and " : ", ";
        length += (size_t)snprintf(text + length, sizeof text - length, "%s`%s`", before, names[i]);
    }
    Symbol name = node_at(r, id)->a;
    report(r->ev, E0307, name_span(r, id, name), "`%s` needs %s", kind->type->name, text);
}

static bool is_declaration(AstTag tag)
{
    return tag == AST_LET || tag == AST_FN;
}

static void check_kind_items(Resolver *r, const NodeType *type, const uint32_t *items,
                             uint32_t count)
{
    for (uint32_t i = 0; i < count && type->role != ROLE_GROUP; ++i) {
        AstTag tag = node_at(r, items[i])->tag;
        if (tag == AST_FIELD || is_declaration(tag)) {
            continue;
        }
        Diag *diag =
            report(r->ev, E0311, span_at(r, items[i]), "`%s` takes fields, not items", type->name);
        diag_note(r->ev->sink, diag, "a `group { … }` takes items");
        return;
    }
}

static uint32_t find_kind(Resolver *r, AstId id)
{
    Symbol name = node_at(r, id)->a;
    if (!name) {
        return 0; // the parser has reported it
    }
    uint32_t kind = name < r->ev->symbol_count ? r->ev->symbols[name].kind : 0;
    if (!kind) {
        Str text = symbol_name(r->ev->names, name);
        Diag *diag = report(r->ev, E0303, name_span(r, id, name), "there is no kind `%s`", text.at);
        const char *near = schema_suggest_type(r->ev->lang->schema, text, CATEGORY_COUNT);
        suggest(r, diag, name_span(r, id, name), near ? str_from(near) : (Str){0});
        if (!near && scope_find(r, name)) {
            diag_label(r->ev->sink, diag, "a value is changed by `%s with { … }`", text.at);
            Span end = name_span(r, id, name);
            end.begin = end.end;
            diag_suggest(r->ev->sink, diag, end, " with");
        }
    }
    return kind;
}

static void resolve_kind(Resolver *r, AstId id)
{
    uint32_t kind = find_kind(r, id);
    uint32_t list = node_at(r, id)->b;
    uint32_t count = ast_list_count(r->ast, list);
    node_at(r, id)->aux = (uint16_t)kind;
    bool has_items = false;
    GivenFields given = {0};
    for (uint32_t i = 0; i < count; ++i) {
        has_items = has_items || node_at(r, ast_list_items(r->ast, list)[i])->tag != AST_FIELD;
    }
    ScopeMark scope = {0};
    if (has_items) {
        scope = scope_begin(r);
        resolve_items(r, ast_list_items(r->ast, list), count);
    }
    for (uint32_t i = 0; i < count; ++i) {
        AstId item = ast_list_items(r->ast, list)[i];
        if (node_at(r, item)->tag == AST_FIELD) {
            resolve_field(r, item, kind, &given);
        }
    }
    if (has_items) {
        scope_end(r, scope);
    }
    if (!kind) {
        return;
    }
    const KindInfo *info = &r->ev->kinds[kind - 1];
    check_kind_items(r, info->type, ast_list_items(r->ast, list), count);
    uint64_t missing = info->required & ~given.params;
    bool of_is_missing = info->type->role == ROLE_INSTANCE && !(given.others & 0x20000);
    if (missing || of_is_missing) {
        if (!r->module->failed) { // else it may be what could not be parsed
            report_missing(r, id, info, missing, of_is_missing);
        }
        node_at(r, id)->aux = 0; // not to be made
    }
}

// --- Expressions and items -------------------------------------------------------------------

static void resolve_list(Resolver *r, uint32_t list)
{
    for (uint32_t i = 0; i < ast_list_count(r->ast, list); ++i) {
        resolve_expression(r, ast_list_items(r->ast, list)[i]);
    }
}

static void resolve_block(Resolver *r, uint32_t list)
{
    ScopeMark scope = scope_begin(r);
    resolve_items(r, ast_list_items(r->ast, list), ast_list_count(r->ast, list));
    scope_end(r, scope);
}

static void resolve_with(Resolver *r, AstId id)
{
    resolve_expression(r, node_at(r, id)->a);
    uint32_t list = node_at(r, id)->b;
    for (uint32_t i = 0; i < ast_list_count(r->ast, list); ++i) {
        AstId field = ast_list_items(r->ast, list)[i];
        resolve_expression(r, node_at(r, field)->b);
    }
}

static void resolve_if(Resolver *r, AstId id)
{
    const AstNode *node = node_at(r, id);
    AstId condition = node->a, then = r->ast->extra.items[node->b];
    AstId otherwise = r->ast->extra.items[node->b + 1];
    resolve_expression(r, condition);
    resolve_expression(r, then);
    if (otherwise) {
        resolve_expression(r, otherwise);
    }
}

static void resolve_expect(Resolver *r, AstId id)
{
    const AstNode *node = node_at(r, id);
    AstId value = node->a, tolerance = r->ast->extra.items[node->b];
    AstId target = r->ast->extra.items[node->b + 1];
    resolve_expression(r, value);
    resolve_expression(r, tolerance);
    resolve_expression(r, target);
}

static void resolve_expression(Resolver *r, AstId id)
{
    AstNode *node = node_at(r, id);
    AstId a = node->a, b = node->b;
    switch ((AstTag)node->tag) {
    case AST_NUMBER:
        resolve_number(r, id);
        break;
    case AST_COLOR:
        resolve_color(r, id);
        break;
    case AST_NAME:
        resolve_name_as_value(r, id);
        break;
    case AST_MEMBER:
        resolve_member(r, id);
        break;
    case AST_VECTOR:
    case AST_LIST:
        resolve_list(r, a);
        break;
    case AST_UNARY:
    case AST_EMIT:
        resolve_expression(r, a);
        break;
    case AST_BINARY:
    case AST_INDEX:
    case AST_RANGE:
        resolve_expression(r, a);
        resolve_expression(r, b);
        break;
    case AST_CALL:
        resolve_expression(r, a);
        resolve_list(r, b);
        break;
    case AST_ARGUMENT:
        resolve_expression(r, b);
        break;
    case AST_KIND:
        resolve_kind(r, id);
        break;
    case AST_WITH:
        resolve_with(r, id);
        break;
    case AST_IF:
        resolve_if(r, id);
        break;
    case AST_EXPECT:
        resolve_expect(r, id);
        break;
    case AST_FOR:
        resolve_for(r, id);
        break;
    case AST_FN:
        resolve_fn(r, id);
        break;
    case AST_BLOCK:
        resolve_block(r, a);
        break;
    default: // literals that need nothing, and what the parser has reported
        break;
    }
}

static BindingKind binding_kind(AstTag tag)
{
    return tag == AST_LET     ? BINDING_LET
           : tag == AST_FN    ? BINDING_FN
           : tag == AST_PARAM ? BINDING_PARAM
                              : BINDING_IMPORT;
}

static void declare_item(Resolver *r, AstId id)
{
    AstTag tag = node_at(r, id)->tag;
    bool is_file = r->frame == 0 && r->scope == 1;
    if ((tag == AST_PARAM || tag == AST_IMPORT) && !is_file) {
        report(r->ev, E0311, span_at(r, id), "%s stands at the top of a file, not in a block",
               tag == AST_PARAM ? "a `param`" : "an `import`");
        return;
    }
    if (tag != AST_LET && tag != AST_FN && tag != AST_PARAM && tag != AST_IMPORT) {
        return;
    }
    Symbol name = item_symbol(r->module, id);
    Span at = item_name_span(r->module, id);
    bool is_missing = tag == AST_IMPORT && node_at(r, id)->aux == 0; // reported
    scope_declare(r, name, binding_kind(tag), id, at)->quiet = is_missing;
    if (is_file && !array_push(&r->module->globals, (Global){name, id, false})) {
        out_of_memory(r->ev);
    }
}

static void resolve_item(Resolver *r, AstId id)
{
    AstNode *node = node_at(r, id);
    const uint32_t *words = &r->ast->extra.items[node->b];
    AstId parts[] = {0, 0};
    if (node->tag == AST_LET) {
        parts[0] = words[2];
    } else if (node->tag == AST_PARAM) {
        parts[0] = words[3];
        parts[1] = words[4];
    } else if (node->tag != AST_IMPORT && node->tag != AST_FIELD) {
        resolve_expression(r, id);
    }
    for (int i = 0; i < 2; ++i) {
        if (parts[i]) {
            resolve_expression(r, parts[i]);
        }
    }
}

// In the scope at hand; fields are left to the kind around them.
static void resolve_items(Resolver *r, const uint32_t *items, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        declare_item(r, items[i]);
    }
    for (uint32_t i = 0; i < count; ++i) {
        resolve_item(r, items[i]);
    }
}

// The names of the file by hash, for `namespace.name` elsewhere.
static void index_globals(Resolver *r)
{
    Module *module = r->module;
    uint32_t size = 16;
    while (size < module->globals.count * 2) {
        size *= 2;
    }
    module->global_slots = arena_alloc_zeroed(r->ev->arena, size * sizeof(uint32_t));
    module->global_mask = size - 1;
    for (uint32_t i = 0; i < module->globals.count; ++i) {
        uint32_t at = hash_u32(module->globals.items[i].name) & module->global_mask;
        Symbol name = module->globals.items[i].name;
        while (module->global_slots[at] &&
               module->globals.items[module->global_slots[at] - 1].name != name) {
            at = (at + 1) & module->global_mask;
        }
        if (!module->global_slots[at]) { // else it is declared twice, which was reported
            module->global_slots[at] = i + 1;
        }
    }
}

// --- Files -----------------------------------------------------------------------------------

void resolver_make_room(Resolver *r)
{
    const uint32_t needed = r->ev->names->count + 1;
    if (needed <= r->symbols) {
        return;
    }
    const uint32_t room = needed + needed / 2;
    uint32_t *current = arena_alloc_zeroed(r->ev->arena, room * sizeof *current);
    bool *relied = arena_alloc_zeroed(r->ev->arena, room * sizeof *relied);
    if (r->symbols) {
        memcpy(current, r->current, r->symbols * sizeof *current);
        memcpy(relied, r->relied, r->symbols * sizeof *relied);
    }
    r->current = current;
    r->relied = relied;
    r->symbols = room;
}

void resolver_begin(Resolver *r, Eval *ev, Module *module)
{
    *r = (Resolver){.ev = ev, .module = module, .ast = &module->ast, .binding_count = 1};
    resolver_make_room(r);
    scope_begin(r);
}

void resolver_declare(Resolver *r, AstId item)
{
    const Symbol name = item_symbol(r->module, item);
    const uint32_t before = r->binding_count;
    declare_item(r, item);
    // What was taken for a built-in name is none.
    r->refused = r->refused || (r->binding_count > before && name && r->relied[name]);
}

void resolver_resolve(Resolver *r, AstId item)
{
    const AstNode *node = node_at(r, item);
    if (!((node->tag == AST_LET || node->tag == AST_PARAM) && node->op == ITEM_RESOLVED)) {
        resolve_item(r, item);
    }
}

void resolver_end(Resolver *r)
{
    scope_end(r, (ScopeMark){.bindings = 1});
    r->module->slot_count = r->next_slot;
    index_globals(r);
    numeric_make(r->ev, r->module);
}

void resolve_module(Eval *ev, Module *module)
{
    Resolver r;
    resolver_begin(&r, ev, module);
    const uint32_t list = node_at(&r, module->ast.root)->a;
    resolve_items(&r, ast_list_items(&module->ast, list), ast_list_count(&module->ast, list));
    resolver_end(&r);
}
