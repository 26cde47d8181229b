// What can be written at a place: kinds, fields, names, units, choices, files.
#include "lsp/context.h"
#include "lsp/features.h"
#include "lsp/hover.h"
#include "lsp/scene_files.h"

#include <limits.h>

// CompletionItemKind
enum {
    ITEM_FUNCTION = 3,
    ITEM_FIELD = 5,
    ITEM_VARIABLE = 6,
    ITEM_CLASS = 7,
    ITEM_MODULE = 9,
    ITEM_PROPERTY = 10,
    ITEM_UNIT = 11,
    ITEM_VALUE = 12,
    ITEM_KEYWORD = 14,
    ITEM_FILE = 17,
    ITEM_FOLDER = 19,
    ITEM_CONSTANT = 21,
    ITEM_TYPE = 25,
};

// How near to what is wanted, first in a list's order.
typedef enum Rank { RANK_WANTED, RANK_LOCAL, RANK_COMMON, RANK_OTHER, RANK_LAST } Rank;

typedef struct Maker {
    Server *server;
    Document *document;
    const Analysis *analysis;
    Context context;
    const Param *param; // that the value is for, or NULL
    CommonField common;
    cJSON *items;
    bool *named; // by symbol: it was added
    int names;   // how many
    bool is_incomplete;
} Maker;

// --- Items ---------------------------------------------------------------------------------------

// `insert` is what is written (a snippet where it has a `$`), NULL for the label.
static cJSON *add_item(Maker *m, const char *label, int kind, Rank rank, const char *detail,
                       const char *insert)
{
    cJSON *item = cJSON_CreateObject();
    char sort[128];
    snprintf(sort, sizeof sort, "%d%s", (int)rank, label);
    cJSON_AddStringToObject(item, "label", label);
    cJSON_AddNumberToObject(item, "kind", kind);
    json_add_text(item, "sortText", str_from(sort));
    if (detail) {
        json_add_text(item, "detail", str_from(detail));
    }
    const char *text = insert ? insert : label;
    bool snippet = insert && strchr(insert, '$');
    if (snippet) {
        cJSON_AddNumberToObject(item, "insertTextFormat", 2);
    }
    if (!m->server->client.edit_range) {
        cJSON_AddItemToObject(item, "textEdit",
                              json_edit(m->server, &m->document->text, m->context.begin,
                                        m->context.end, str_from(text)));
    } else if (insert) {
        json_add_text(item, "textEditText", str_from(text));
    }
    cJSON_AddItemToArray(m->items, item);
    return item;
}

// What completionItem/resolve looks up.
static void add_entry(cJSON *item, const char *kind, const char *name, const char *field)
{
    cJSON *data = cJSON_AddObjectToObject(item, "data");
    cJSON_AddStringToObject(data, "entry", kind);
    cJSON_AddStringToObject(data, "name", name);
    if (field) {
        cJSON_AddStringToObject(data, "field", field);
    }
}

static void add_documentation(const Server *server, cJSON *item, Str text)
{
    cJSON *documentation = cJSON_AddObjectToObject(item, "documentation");
    cJSON_AddStringToObject(documentation, "kind",
                            hover_style(server) == MANUAL_MARKDOWN ? "markdown" : "plaintext");
    json_add_text(documentation, "value", text);
}

// --- Kinds ---------------------------------------------------------------------------------------

// "sphere { $0 }", or with the fields that it needs.
static void write_kind_snippet(const NodeType *type, FILE *out)
{
    int stop = 0;
    fprintf(out, "%s { ", type->name);
    for (size_t i = 0; i < type->param_count; ++i) {
        if (type->params[i].flags & PARAM_REQUIRED) {
            fprintf(out, "%s%s: $%d", stop ? ", " : "", type->params[i].name, stop + 1);
            ++stop;
        }
    }
    fputs(stop ? "$0 }" : "$0 }", out);
}

static void add_kind(Maker *m, const NodeType *type, Rank rank)
{
    Memo memo = {0};
    FILE *out = m->server->client.snippets ? memo_begin(&memo) : NULL;
    if (out) {
        write_kind_snippet(type, out);
        fputc('\0', out);
    }
    Str snippet = memo_text(&memo);
    cJSON *item = add_item(m, type->name, ITEM_CLASS, rank, category_name(type->category),
                           snippet.length > 0 ? snippet.at : NULL);
    memo_free(&memo);
    add_entry(item, "kind", type->name, NULL);
}

static bool wants_category(const Maker *m, Category category)
{
    const Param *param = m->param;
    if (m->common) {
        return m->common == COMMON_MATERIAL && category == CATEGORY_MATERIAL;
    }
    if (!param) {
        return false;
    }
    switch (param->type) {
    case PARAM_NODE:
        return param->category == category;
    case PARAM_NUMBER_TEX:
    case PARAM_PAIR_TEX:
    case PARAM_COLOR_TEX:
    case PARAM_EMISSION:
        return category == CATEGORY_TEXTURE;
    default:
        return false;
    }
}

static void add_kinds(Maker *m, bool items_only)
{
    const Schema *schema = m->server->host->schema;
    for (size_t i = 0; i < schema->type_count; ++i) {
        const NodeType *type = schema->types[i];
        bool is_item = type->category == CATEGORY_SHAPE || type->category == CATEGORY_LIGHT ||
                       type->category == CATEGORY_CAMERA || type->category == CATEGORY_SETTING;
        if (!type->internal && (!items_only || is_item)) {
            add_kind(m, type,
                     wants_category(m, type->category) ? RANK_WANTED
                     : m->param || m->common           ? RANK_LAST
                                                       : RANK_COMMON);
        }
    }
}

// --- Names ---------------------------------------------------------------------------------------

// Notes that a name is listed; false where it was before (an inner one hides it).
static bool is_new(Maker *m, Str name)
{
    Symbol symbol = interned(&m->analysis->lang.names, name);
    if (!m->named) {
        m->named = arena_alloc_zeroed(&m->server->scratch, m->analysis->lang.names.count + 1);
    }
    if (!symbol || !m->named || m->named[symbol]) {
        return false;
    }
    return m->named[symbol] = true;
}

// Of very many names those are listed that have the letters written so far, in their order.
enum { MOST_NAMES = 300 };

static bool matches(const Maker *m, Str name)
{
    Str text = buffer_content(&m->document->text);
    uint32_t at = m->context.begin;
    for (size_t i = 0; at < m->context.end && i < name.length; ++i) {
        at += (text.at[at] | 0x20) == (name.at[i] | 0x20);
    }
    return at == m->context.end && at > m->context.begin;
}

static int item_kind(AstTag tag)
{
    return tag == AST_FN ? ITEM_FUNCTION : tag == AST_IMPORT ? ITEM_MODULE : ITEM_VARIABLE;
}

// A declaration of file `file` of the survey.
static void add_name_of(Maker *m, uint32_t file, AstId item, Rank rank)
{
    const Ast *ast = survey_ast(m->analysis->survey, file);
    AstTag tag = (AstTag)ast_node(ast, item)->tag;
    Str name = survey_name(m->analysis->survey, file, item);
    if (name.length == 0 || !is_new(m, name)) {
        return;
    }
    if (m->names >= MOST_NAMES && !matches(m, name)) {
        m->is_incomplete = true; // asked for again when more is written
        return;
    }
    ++m->names;
    const NodeType *type = tree_infer_kind(m->analysis, file, item);
    Span at = survey_name_span(m->analysis->survey, file, item);
    const ReportValue *value =
        report_value(&m->document->found, tree_file_path(m->analysis, file), at.begin);
    Str declaration = hover_declaration(m->analysis, file, item);
    char detail[160], insert[300];
    size_t line = 0;
    while (line < declaration.length && declaration.at[line] != '\n') {
        ++line;
    }
    if (value && !value->varies) {
        snprintf(detail, sizeof detail, "%s", value->text);
    } else {
        snprintf(detail, sizeof detail, "%.*s", (int)(line < 120 ? line : 120), declaration.at);
    }
    bool call = tag == AST_FN && m->server->client.snippets && name.length < 200;
    snprintf(insert, sizeof insert, "%s($0)", call ? name.at : "");
    bool wanted = type && wants_category(m, type->category);
    cJSON *entry = add_item(m, name.at, item_kind(tag), wanted ? RANK_WANTED : rank, detail,
                            call ? insert : NULL);
    Memo memo;
    FILE *out = memo_begin(&memo);
    if (out) {
        hover_comment(tree_text(m->analysis, file), ast_node(ast, item)->begin, out);
        Str text = memo_text(&memo);
        if (text.length > 0 && tag != AST_PARAMETER && tag != AST_FOR) {
            add_documentation(m->server, entry, text);
        }
    }
    memo_free(&memo);
}

static void add_name(void *context, AstId item)
{
    add_name_of(context, 0, item, RANK_LOCAL);
}

static bool gives_color(const char *name)
{
    static const char *const names[] = {"rgb", "srgb", "hsv", "gray", "blackbody"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        if (strcmp(names[i], name) == 0) {
            return true;
        }
    }
    return false;
}

static bool gives_transform(const char *name)
{
    static const char *const names[] = {"translate", "scale",  "rotate_x", "rotate_y",
                                        "rotate_z",  "rotate", "look_at",  "matrix"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        if (strcmp(names[i], name) == 0) {
            return true;
        }
    }
    return false;
}

static bool wants_color(const Maker *m)
{
    return m->common == COMMON_COLOR ||
           (m->param && (m->param->type == PARAM_COLOR || m->param->type == PARAM_COLOR_TEX ||
                         m->param->type == PARAM_COLOR_LIST || m->param->type == PARAM_EMISSION));
}

static void add_builtins(Maker *m)
{
    for (size_t i = 0; i < lang_builtin_count; ++i) {
        const BuiltinInfo *builtin = &lang_builtins[i];
        char insert[80];
        snprintf(insert, sizeof insert, "%s($0)", builtin->name);
        bool wanted = (wants_color(m) && gives_color(builtin->name)) ||
                      (m->common == COMMON_TRANSFORM && gives_transform(builtin->name));
        cJSON *item = add_item(m, builtin->name, ITEM_FUNCTION, wanted ? RANK_WANTED : RANK_OTHER,
                               builtin->signature, m->server->client.snippets ? insert : NULL);
        add_entry(item, "builtin", builtin->name, NULL);
    }
    for (size_t i = 0; i < lang_constant_count; ++i) {
        cJSON *item = add_item(m, lang_constants[i].name, ITEM_CONSTANT, RANK_OTHER,
                               lang_constants[i].doc, NULL);
        (void)item;
    }
}

static void add_words(Maker *m, const char *const *words, size_t count, Rank rank)
{
    for (size_t i = 0; i < count; ++i) {
        add_item(m, words[i], ITEM_KEYWORD, rank, NULL, NULL);
    }
}

// --- Items and values ----------------------------------------------------------------------------

static void add_items(Maker *m)
{
    static const char *const words[] = {"let", "fn", "for", "if", "expect"};
    static const char *const file_words[] = {"import", "param"};
    add_words(m, words, sizeof words / sizeof *words, RANK_OTHER);
    if (!m->context.type) {
        add_words(m, file_words, sizeof file_words / sizeof *file_words, RANK_OTHER);
    }
    context_names(m->analysis, m->context.begin, add_name, m);
    add_kinds(m, true);
}

static void add_default(Maker *m)
{
    const char *text = m->param ? m->param->default_text : NULL;
    bool listed = m->param && (m->param->type == PARAM_CHOICE || m->param->type == PARAM_BOOL);
    if (text && !listed) {
        add_item(m, text, ITEM_VALUE, RANK_WANTED, "default", NULL);
    }
}

static void add_choices(Maker *m, bool quoted)
{
    const char *const *choices =
        m->param && m->param->type == PARAM_CHOICE ? m->param->choices : NULL;
    for (size_t i = 0; choices && choices[i]; ++i) {
        char text[120];
        snprintf(text, sizeof text, quoted ? "\"%s\"" : "%s", choices[i]);
        bool is_default =
            m->param->default_text && strlen(m->param->default_text) > 2 &&
            strncmp(m->param->default_text + 1, choices[i], strlen(choices[i])) == 0 &&
            m->param->default_text[strlen(choices[i]) + 1] == '"';
        add_item(m, text, ITEM_VALUE, RANK_WANTED, is_default ? "default" : NULL, NULL);
    }
}

// The names of a function's parameters that are not given yet, where an argument begins.
static void add_arguments(Maker *m)
{
    const Context *context = &m->context;
    if (!context->in_call || !context->argument_begins) {
        return;
    }
    TreePath path;
    tree_path(survey_ast(m->analysis->survey, 0), context->callee_end, &path);
    uint32_t file = 0;
    Str name = {buffer_content(&m->document->text).at + context->callee_begin,
                context->callee_end - context->callee_begin};
    AstId item = context_find(m->analysis, context->callee_begin, name);
    if (!item && path.count > 0) {
        item = path.nodes[path.count - 1];
    }
    AstId fn = item ? tree_function(m->analysis, &file, item) : 0;
    const Ast *ast = survey_ast(m->analysis->survey, file);
    AstId parameter;
    for (uint32_t i = context->argument; fn && (parameter = tree_parameter_at(ast, fn, i)); ++i) {
        Str called = tree_symbol(m->analysis, ast_node(ast, parameter)->a);
        char text[200];
        snprintf(text, sizeof text, "%.*s: ", (int)(called.length < 190 ? called.length : 190),
                 called.at);
        add_item(m, text, ITEM_PROPERTY, RANK_WANTED, "argument by name", NULL);
    }
}

static void add_values(Maker *m)
{
    static const char *const words[] = {"if", "fn", "not", "true", "false"};
    static const char *const list_words[] = {"for"};
    add_arguments(m);
    add_choices(m, true);
    if (m->param && m->param->type == PARAM_BOOL) {
        add_words(m, words + 3, 2, RANK_WANTED);
    }
    if (m->param && m->param->type == PARAM_FILE && m->server->client.snippets) {
        add_item(m, "\"…\"", ITEM_FILE, RANK_WANTED, "a file", "\"$0\"");
    }
    add_default(m);
    context_names(m->analysis, m->context.begin, add_name, m);
    add_builtins(m);
    add_kinds(m, false);
    add_words(m, words, m->param && m->param->type == PARAM_BOOL ? 3 : 5, RANK_LAST);
    if (m->context.in_list) {
        add_words(m, list_words, 1, RANK_OTHER);
    }
}

// --- Fields --------------------------------------------------------------------------------------

static bool is_given(const Context *context, const char *name)
{
    for (uint32_t i = 0; i < context->given_fields; ++i) {
        if (str_equal(context->given[i], str_from(name))) {
            return true;
        }
    }
    return false;
}

static void add_field(Maker *m, const char *name, Rank rank, const char *detail, Str documentation)
{
    if (is_given(&m->context, name)) {
        return;
    }
    char text[120];
    Str rest = buffer_content(&m->document->text);
    uint32_t end = m->context.end;
    bool has_colon = end < rest.length && rest.at[end] == ':';
    snprintf(text, sizeof text, has_colon ? "%s" : "%s: ", name);
    cJSON *item = add_item(m, name, ITEM_FIELD, rank, detail, text);
    add_documentation(m->server, item, documentation);
}

static void add_param_field(Maker *m, const Param *param)
{
    Memo memo;
    FILE *out = memo_begin(&memo);
    if (out) {
        manual_write_takes(param, out);
        fputc('\0', out);
    }
    Str takes = memo_text(&memo);
    add_field(m, param->name, param->flags & PARAM_REQUIRED ? RANK_WANTED : RANK_LOCAL, takes.at,
              str_from(param->doc));
    memo_free(&memo);
}

static void add_fields(Maker *m)
{
    const NodeType *type = m->context.type;
    if (!type) {
        add_items(m);
        return;
    }
    for (size_t i = 0; i < type->param_count; ++i) {
        add_param_field(m, &type->params[i]);
    }
    uint32_t common = category_common_fields(type->category);
    for (uint32_t bit = 1; bit <= common; bit <<= 1) {
        if (common & bit) {
            CommonField field = (CommonField)bit;
            add_field(m, common_field_name(field), RANK_COMMON, manual_common_takes(field),
                      str_from(common_field_doc(field)));
        }
    }
    if (type->role == ROLE_GROUP && !m->context.in_with) {
        add_items(m);
    }
}

// --- Members, units, types -----------------------------------------------------------------------

static void add_members_of_file(Maker *m, int64_t file)
{
    const Ast *ast = survey_ast(m->analysis->survey, (uint32_t)file);
    uint32_t list = ast->root ? ast_node(ast, ast->root)->a : 0;
    for (uint32_t i = 0; i < ast_list_count(ast, list); ++i) {
        AstId item = ast_list_items(ast, list)[i];
        uint8_t tag = ast_node(ast, item)->tag;
        if (tag == AST_LET || tag == AST_FN || tag == AST_PARAM) {
            add_name_of(m, (uint32_t)file, item, RANK_LOCAL);
        }
    }
}

static void add_parts(Maker *m, const ReportValue *value)
{
    static const struct {
        const char *name, *of, *word;
    } parts[] = {
        {"x", "a vector", "vector"},    {"y", "a vector", "vector"},  {"z", "a vector", "vector"},
        {"w", "a vector", "vector"},    {"r", "a color", "color"},    {"g", "a color", "color"},
        {"b", "a color", "color"},      {"min", "bounds", "bounds"},  {"max", "bounds", "bounds"},
        {"center", "bounds", "bounds"}, {"size", "bounds", "bounds"},
    };
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) {
        if (!value || strstr(value->type, parts[i].word)) {
            add_item(m, parts[i].name, ITEM_PROPERTY, RANK_LOCAL, parts[i].of, NULL);
        }
    }
}

static void add_members(Maker *m)
{
    const DocumentTokens *tokens = &m->document->tokens;
    uint32_t before = m->context.member_of;
    if (before >= tokens->count) {
        return;
    }
    const DocumentToken *token = &tokens->items[before];
    Str name = {buffer_content(&m->document->text).at + token->begin, token->end - token->begin};
    AstId item = context_find(m->analysis, token->begin, name);
    const Ast *ast = survey_ast(m->analysis->survey, 0);
    if (item && ast_node(ast, item)->tag == AST_IMPORT) {
        int64_t file = survey_import(m->analysis->survey, 0, item);
        if (file >= 0) {
            add_members_of_file(m, file);
        }
        return;
    }
    const ReportValue *value =
        item ? report_value(&m->document->found, m->document->real,
                            survey_name_span(m->analysis->survey, 0, item).begin)
             : NULL;
    add_parts(m, value);
}

static void add_units(Maker *m)
{
    uint32_t dims = m->param ? m->param->dims & ~DIM_BIT(DIM_NONE) : 0;
    for (size_t i = 0; i < schema_unit_count; ++i) {
        const UnitInfo *unit = &schema_units[i];
        char detail[80];
        snprintf(detail, sizeof detail, "%s, %.10g %s", dim_info(unit->dim)->name, unit->factor,
                 dim_info(unit->dim)->si_unit);
        add_item(m, unit->name, ITEM_UNIT, dims & DIM_BIT(unit->dim) ? RANK_WANTED : RANK_OTHER,
                 detail, NULL);
    }
}

static void add_types(Maker *m)
{
    for (size_t i = 0; i < lang_param_type_count; ++i) {
        add_item(m, lang_param_types[i].name, ITEM_TYPE, RANK_LOCAL, lang_param_types[i].doc, NULL);
    }
}

// --- Files ---------------------------------------------------------------------------------------

static void add_file(void *context, const char *name, bool is_folder)
{
    Maker *m = context;
    char text[NAME_MAX + 2];
    snprintf(text, sizeof text, is_folder ? "%s/" : "%s", name);
    add_item(m, text, is_folder ? ITEM_FOLDER : ITEM_FILE, is_folder ? RANK_LOCAL : RANK_WANTED,
             NULL, NULL);
}

// `written` is what stands in the string before the cursor.
static void add_files(Maker *m, Str written, bool scenes)
{
    size_t folder = written.length;
    while (folder > 0 && written.at[folder - 1] != '/') {
        --folder;
    }
    m->context.begin += (uint32_t)folder;
    scene_files(m->server, m->analysis, m->document->real, (Str){written.at, folder}, scenes,
                add_file, m);
}

static void add_strings(Maker *m, uint32_t offset)
{
    Str text = buffer_content(&m->document->text);
    uint32_t begin = m->context.begin;
    if (m->context.in_import || (m->param && m->param->type == PARAM_FILE)) {
        add_files(m, (Str){text.at + begin, offset > begin ? offset - begin : 0},
                  m->context.in_import);
    } else {
        add_choices(m, false);
    }
}

// --- The request ---------------------------------------------------------------------------------

static void find_param(Maker *m)
{
    const NodeType *type = m->context.type;
    Str field = m->context.field;
    if (!type || field.length == 0 || (m->context.in_call && m->context.kind != CONTEXT_STRING)) {
        return;
    }
    int index = node_type_find_param(type, field);
    m->param = index >= 0 ? &type->params[index] : NULL;
    uint32_t common = category_common_fields(type->category);
    for (uint32_t bit = 1; index < 0 && bit <= common; bit <<= 1) {
        if ((common & bit) && str_equal(field, str_from(common_field_name((CommonField)bit)))) {
            m->common = (CommonField)bit;
        }
    }
}

cJSON *feature_completion(Server *server, Document *document, const cJSON *params)
{
    Maker m = {.server = server, .document = document};
    uint32_t offset = server_offset(server, document, json_at(params, "position"));
    m.analysis = document_analysis(server, document);
    m.items = cJSON_CreateArray();
    if (!m.analysis) {
        return m.items;
    }
    context_at(server, document, offset, &m.context);
    find_param(&m);
    static const char *const as[] = {"as"};
    switch (m.context.kind) {
    case CONTEXT_NOTHING:
        break;
    case CONTEXT_ITEM:
        add_items(&m);
        break;
    case CONTEXT_FIELD:
        add_fields(&m);
        break;
    case CONTEXT_VALUE:
        add_values(&m);
        break;
    case CONTEXT_MEMBER:
        add_members(&m);
        break;
    case CONTEXT_UNIT:
        add_units(&m);
        break;
    case CONTEXT_STRING:
        add_strings(&m, offset);
        break;
    case CONTEXT_TYPE:
        add_types(&m);
        break;
    case CONTEXT_AS:
        add_words(&m, as, 1, RANK_WANTED);
        break;
    }
    cJSON *list = cJSON_CreateObject();
    cJSON_AddBoolToObject(list, "isIncomplete", m.is_incomplete);
    if (server->client.edit_range) {
        cJSON_AddItemToObject(cJSON_AddObjectToObject(list, "itemDefaults"), "editRange",
                              json_range(server, &document->text, m.context.begin, m.context.end));
    }
    cJSON_AddItemToObject(list, "items", m.items);
    return list;
}

cJSON *feature_resolve_completion(Server *server, const cJSON *params)
{
    cJSON *item = cJSON_Duplicate(params, true);
    const char *entry = json_get_string(params, "data.entry");
    const char *name = json_get_string(params, "data.name");
    Memo memo;
    FILE *out = memo_begin(&memo);
    if (!entry || !name || !out) {
        memo_free(&memo);
        return item;
    }
    const Schema *schema = server->host->schema;
    int kind = strcmp(entry, "kind") == 0 ? schema_find(schema, str_from(name)) : -1;
    if (kind >= 0) {
        manual_write_kind(schema->types[kind], out, hover_style(server));
    }
    for (size_t i = 0; strcmp(entry, "builtin") == 0 && i < lang_builtin_count; ++i) {
        if (strcmp(lang_builtins[i].name, name) == 0) {
            hover_builtin(&lang_builtins[i], out, hover_style(server));
        }
    }
    Str text = memo_text(&memo);
    if (text.length > 0) {
        cJSON_DeleteItemFromObject(item, "documentation");
        add_documentation(server, item, text);
    }
    memo_free(&memo);
    return item;
}
