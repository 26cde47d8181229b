// The outline of a scene: imports, params, lets, functions, and what it emits.
#include "lsp/features.h"
#include "lsp/hover.h"
#include "lsp/workspace.h"

// SymbolKind
enum {
    SYMBOL_MODULE = 2,
    SYMBOL_NAMESPACE = 3,
    SYMBOL_PROPERTY = 7,
    SYMBOL_FUNCTION = 12,
    SYMBOL_VARIABLE = 13,
    SYMBOL_CONSTANT = 14,
    SYMBOL_OBJECT = 19,
    SYMBOL_EVENT = 24,
};

typedef struct Outline {
    Server *server;
    const Document *document;
    const Analysis *analysis;
    const Ast *ast;
    cJSON *list;        // where the symbols go
    const char *around; // for flat lists
    bool flat;
    int depth;
} Outline;

enum { DEEPEST = 40 };

static void outline(void *context, AstId id);

// Adds a symbol, and those of the node's children below it.
static void add_symbol(Outline *o, AstId id, Str name, int kind, uint32_t begin, uint32_t end,
                       const char *detail)
{
    const AstNode *node = ast_node(o->ast, id);
    cJSON *symbol = cJSON_CreateObject();
    json_add_text(symbol, "name", name.length ? name : STR("?"));
    cJSON_AddNumberToObject(symbol, "kind", kind);
    Outline inner = *o;
    if (o->flat) {
        cJSON *location = cJSON_AddObjectToObject(symbol, "location");
        cJSON_AddStringToObject(location, "uri", o->document->uri);
        cJSON_AddItemToObject(location, "range",
                              json_range(o->server, &o->document->text, node->begin, node->end));
        if (o->around) {
            cJSON_AddStringToObject(symbol, "containerName", o->around);
        }
    } else {
        if (detail) {
            json_add_text(symbol, "detail", str_from(detail));
        }
        cJSON_AddItemToObject(symbol, "range",
                              json_range(o->server, &o->document->text, node->begin, node->end));
        cJSON_AddItemToObject(symbol, "selectionRange",
                              json_range(o->server, &o->document->text, begin, end));
        inner.list = cJSON_CreateArray();
    }
    cJSON_AddItemToArray(o->list, symbol);
    inner.around = json_get_string(symbol, "name");
    ++inner.depth;
    if (inner.depth < DEEPEST) {
        tree_children(o->ast, id, outline, &inner);
    }
    if (!o->flat && cJSON_GetArraySize(inner.list) > 0) {
        cJSON_AddItemToObject(symbol, "children", inner.list);
    } else if (!o->flat) {
        cJSON_Delete(inner.list);
    }
}

// The `name` that a kind is given, where it is a string written out.
static Str given_name(const Outline *o, const AstNode *kind)
{
    for (uint32_t i = 0; i < ast_list_count(o->ast, kind->b); ++i) {
        const AstNode *field = ast_node(o->ast, ast_list_items(o->ast, kind->b)[i]);
        if (field->tag == AST_FIELD && field->b &&
            str_equal(tree_symbol(o->analysis, field->a), STR("name")) &&
            ast_node(o->ast, field->b)->tag == AST_STRING) {
            return tree_symbol(o->analysis, ast_node(o->ast, field->b)->a);
        }
    }
    return STR("");
}

static void add_kind(Outline *o, AstId id)
{
    const AstNode *node = ast_node(o->ast, id);
    Str kind = tree_symbol(o->analysis, node->a), name = given_name(o, node);
    uint32_t end = node->begin + (uint32_t)kind.length;
    const NodeType *type = tree_kind(o->analysis, node);
    add_symbol(o, id, name.length ? name : kind, SYMBOL_OBJECT, node->begin, end,
               name.length ? kind.at
               : type      ? category_name(type->category)
                           : NULL);
}

static void add_declaration(Outline *o, AstId id, int kind)
{
    Span name = survey_name_span(o->analysis->survey, 0, id);
    const ReportValue *value = report_value(&o->document->found, o->document->real, name.begin);
    const NodeType *type = tree_infer_kind(o->analysis, 0, id);
    add_symbol(o, id, survey_name(o->analysis->survey, 0, id), kind, name.begin, name.end,
               type    ? type->name
               : value ? value->text
                       : NULL);
}

// A call or a name that stands as a statement.
static void add_emitted(Outline *o, AstId id)
{
    const AstNode *node = ast_node(o->ast, id);
    const AstNode *value = node->a ? ast_node(o->ast, node->a) : node;
    if (value->tag == AST_KIND) {
        add_kind(o, node->a);
        return;
    }
    const AstNode *callee = value;
    while ((callee->tag == AST_CALL || callee->tag == AST_WITH) && callee->a) {
        callee = ast_node(o->ast, callee->a);
    }
    Str text = tree_text(o->analysis, 0);
    Str name = {text.at + callee->begin, callee->end - callee->begin};
    if (callee->tag == AST_NAME || callee->tag == AST_MEMBER) {
        add_symbol(o, id, name, SYMBOL_EVENT, callee->begin, callee->end, "call");
    }
}

static void outline(void *context, AstId id)
{
    Outline *o = context;
    switch ((AstTag)ast_node(o->ast, id)->tag) {
    case AST_IMPORT:
        add_declaration(o, id, SYMBOL_NAMESPACE);
        break;
    case AST_PARAM:
        add_declaration(o, id, SYMBOL_PROPERTY);
        break;
    case AST_LET:
        add_declaration(o, id, SYMBOL_CONSTANT);
        break;
    case AST_FN:
        if (ast_node(o->ast, id)->a) {
            add_declaration(o, id, SYMBOL_FUNCTION);
        }
        break;
    case AST_FOR: {
        Str text = hover_declaration(o->analysis, 0, id);
        char name[80];
        int size = snprintf(name, sizeof name, "for (%.*s)",
                            (int)(text.length < 60 ? text.length : 60), text.at);
        Span at = survey_name_span(o->analysis->survey, 0, id);
        add_symbol(o, id, (Str){name, (size_t)size}, SYMBOL_MODULE, at.begin, at.end, NULL);
        break;
    }
    case AST_EMIT:
        add_emitted(o, id);
        break;
    case AST_FILE:
    case AST_BLOCK:
    case AST_IF:
    case AST_KIND: // of a let, or below an emitted one: its items
        tree_children(o->ast, id, outline, o);
        break;
    default:
        break;
    }
}

cJSON *feature_document_symbols(Server *server, Document *document, const cJSON *params)
{
    (void)params;
    const Analysis *analysis = document_analysis(server, document);
    cJSON *list = cJSON_CreateArray();
    if (analysis) {
        Outline o = {.server = server,
                     .document = document,
                     .analysis = analysis,
                     .ast = survey_ast(analysis->survey, 0),
                     .list = list,
                     .flat = !server->client.symbol_trees};
        if (o.ast->root) {
            outline(&o, o.ast->root);
        }
    }
    return list;
}

// --- All files -----------------------------------------------------------------------------------

typedef struct Everywhere {
    Server *server;
    Places places;
    const char *query;
    cJSON *list;
} Everywhere;

enum { MOST_SYMBOLS = 500 };

// The letters of the query in their order, as editors match.
static bool matches(const char *query, Str name)
{
    for (size_t i = 0; *query; ++query) {
        while (i < name.length && (name.at[i] | 0x20) != (*query | 0x20)) {
            ++i;
        }
        if (i++ >= name.length) {
            return false;
        }
    }
    return true;
}

static void add_globals(void *context, const Analysis *analysis)
{
    Everywhere *e = context;
    const Ast *ast = survey_ast(analysis->survey, 0);
    uint32_t list = ast->root ? ast_node(ast, ast->root)->a : 0;
    for (uint32_t i = 0; i < ast_list_count(ast, list); ++i) {
        AstId item = ast_list_items(ast, list)[i];
        AstTag tag = (AstTag)ast_node(ast, item)->tag;
        bool named = tag == AST_LET || tag == AST_FN || tag == AST_PARAM;
        Str name = named ? survey_name(analysis->survey, 0, item) : STR("");
        if (!named || name.length == 0 || !matches(e->query, name) ||
            cJSON_GetArraySize(e->list) >= MOST_SYMBOLS) {
            continue;
        }
        Span at = survey_name_span(analysis->survey, 0, item);
        FilePlace place = {tree_file_path(analysis, 0), at.begin, at.end};
        cJSON *location = places_location(&e->places, &place);
        if (location) {
            cJSON *symbol = cJSON_CreateObject();
            json_add_text(symbol, "name", name);
            cJSON_AddNumberToObject(symbol, "kind",
                                    tag == AST_FN      ? SYMBOL_FUNCTION
                                    : tag == AST_PARAM ? SYMBOL_PROPERTY
                                                       : SYMBOL_CONSTANT);
            cJSON_AddItemToObject(symbol, "location", location);
            cJSON_AddItemToArray(e->list, symbol);
        }
    }
}

cJSON *feature_workspace_symbols(Server *server, const cJSON *params)
{
    const char *query = json_get_string(params, "query");
    Everywhere e = {.server = server,
                    .places = {.server = server},
                    .query = query ? query : "",
                    .list = cJSON_CreateArray()};
    for (size_t i = 0; i < server->documents.count; ++i) {
        const Analysis *analysis = document_analysis(server, server->documents.items[i]);
        if (analysis) {
            add_globals(&e, analysis);
        }
    }
    workspace_surveys(server, NULL, add_globals, &e);
    places_end(&e.places);
    return e.list;
}
