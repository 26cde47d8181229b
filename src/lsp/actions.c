// Quick fixes: what the diagnostics suggest, and little more.
#include "lsp/features.h"
#include "lsp/tree.h"

typedef struct Fix {
    const char *title;
    uint32_t begin, end;
    Str text;
} Fix;

static cJSON *edit_of(const Server *server, const Document *document, const cJSON *edits)
{
    (void)server;
    cJSON *edit = cJSON_CreateObject(), *changes = cJSON_AddObjectToObject(edit, "changes");
    cJSON_AddItemToObject(changes, document->uri, cJSON_Duplicate(edits, true));
    return edit;
}

static void add_action(const Server *server, const Document *document, const Fix *fix,
                       const char *kind, const cJSON *diagnostic, bool preferred, cJSON *list)
{
    cJSON *action = cJSON_CreateObject(), *edits = cJSON_CreateArray();
    json_add_text(action, "title", str_from(fix->title));
    cJSON_AddStringToObject(action, "kind", kind);
    if (diagnostic) {
        cJSON *fixed = cJSON_AddArrayToObject(action, "diagnostics");
        cJSON_AddItemToArray(fixed, cJSON_Duplicate(diagnostic, true));
    }
    if (preferred) {
        cJSON_AddTrueToObject(action, "isPreferred");
    }
    cJSON_AddItemToArray(edits,
                         json_edit(server, &document->text, fix->begin, fix->end, fix->text));
    cJSON_AddItemToObject(action, "edit", edit_of(server, document, edits));
    cJSON_Delete(edits);
    cJSON_AddItemToArray(list, action);
}

// The client's own copy of a diagnostic, to be named as mended.
static const cJSON *client_diagnostic(const cJSON *params, const char *code)
{
    const cJSON *item;
    cJSON_ArrayForEach(item, json_at(params, "context.diagnostics"))
    {
        const char *other = json_get_string(item, "code");
        if (other && strcmp(other, code) == 0) {
            return item;
        }
    }
    return NULL;
}

// --- Fixes that are no suggestions ---------------------------------------------------------------

// A required field is missing: it is added with nothing behind it, for the author to fill in.
static bool missing_fields(Server *server, const Document *document, const Analysis *analysis,
                           const ReportItem *item, Fix *fix)
{
    const Ast *ast = survey_ast(analysis->survey, 0);
    TreePath path;
    tree_path(ast, item->at.begin, &path);
    const AstNode *kind = NULL;
    for (size_t i = path.count; i-- > 0 && !kind;) {
        const AstNode *node = ast_node(ast, path.nodes[i]);
        kind = node->tag == AST_KIND && node->begin == item->at.begin ? node : NULL;
    }
    const NodeType *type = kind ? tree_kind(analysis, kind) : NULL;
    Memo memo = {0};
    FILE *out = type ? memo_begin(&memo) : NULL;
    if (!out) {
        return false;
    }
    bool any = false;
    for (size_t i = 0; i < type->param_count; ++i) {
        bool given = !(type->params[i].flags & PARAM_REQUIRED);
        for (uint32_t k = 0; k < ast_list_count(ast, kind->b); ++k) {
            const AstNode *field = ast_node(ast, ast_list_items(ast, kind->b)[k]);
            given = given || (field->tag == AST_FIELD && str_equal(tree_symbol(analysis, field->a),
                                                                   str_from(type->params[i].name)));
        }
        if (!given) {
            fprintf(out, "%s %s: ", any ? "," : "", type->params[i].name);
            any = true;
        }
    }
    if (any && ast_list_count(ast, kind->b) > 0) {
        fputc(',', out);
    }
    Str text = memo_text(&memo);
    Str source = buffer_content(&document->text);
    uint32_t brace = item->at.end;
    while (brace < source.length && source.at[brace] != '{') {
        ++brace;
    }
    char *kept = arena_copy_string(&server->scratch, text.at, text.length);
    *fix = (Fix){
        "Add the missing fields", brace + 1, brace + 1, {kept ? kept : "", kept ? text.length : 0}};
    memo_free(&memo);
    return kept && fix->text.length > 0 && brace < source.length;
}

static void add_more(Server *server, const Document *document, const ReportItem *item,
                     const cJSON *diagnostic, cJSON *list)
{
    Fix fix = {.begin = item->at.begin, .end = item->at.begin, .text = STR("_")};
    if (item->code == W0301) {
        fix.title = "Begin the name with `_`: it may stay unused";
        add_action(server, document, &fix, "quickfix", diagnostic, false, list);
    } else if (item->code == E0307 && document->analysis &&
               missing_fields(server, document, document->analysis, item, &fix)) {
        add_action(server, document, &fix, "quickfix", diagnostic, false, list);
    }
}

// --- Suggestions ---------------------------------------------------------------------------------

static bool is_here(const ReportItem *item, const Document *document)
{
    return !item->gone && item->at.path && strcmp(item->at.path, document->real) == 0;
}

static bool has_fix(const ReportItem *item, const Document *document)
{
    return item->fix_text && item->fix_at.path && strcmp(item->fix_at.path, document->real) == 0 &&
           item->fix_at.end <= document->text.bytes.count;
}

static const char *title_of(Server *server, const Document *document, const ReportItem *item)
{
    Str text = buffer_content(&document->text);
    int length = (int)(item->fix_at.end - item->fix_at.begin);
    const char *old = text.at + item->fix_at.begin;
    length = length < 60 ? length : 60;
    const char *title =
        !*item->fix_text ? arena_printf(&server->scratch, "Remove `%.*s`", length, old)
        : length == 0
            ? arena_printf(&server->scratch, "Insert `%s`", item->fix_text)
            : arena_printf(&server->scratch, "Change `%.*s` to `%s`", length, old, item->fix_text);
    return title ? title : "Apply the suggestion";
}

static void add_fixes(Server *server, const Document *document, const Report *report,
                      uint32_t begin, uint32_t end, const cJSON *params, cJSON *list)
{
    for (size_t i = 0; i < report->items.count; ++i) {
        const ReportItem *item = &report->items.items[i];
        if (!is_here(item, document) || item->at.end < begin || item->at.begin > end) {
            continue;
        }
        const cJSON *diagnostic = client_diagnostic(params, diag_info(item->code)->name);
        if (has_fix(item, document)) {
            Fix fix = {title_of(server, document, item), item->fix_at.begin, item->fix_at.end,
                       str_from(item->fix_text)};
            add_action(server, document, &fix, "quickfix", diagnostic, true, list);
        }
        add_more(server, document, item, diagnostic, list);
    }
}

// All suggestions whose places don't overlap, at once.
static uint32_t collect_all(const Server *server, const Document *document, const Report *report,
                            cJSON *edits, const ReportItem **taken, uint32_t count, uint32_t most)
{
    for (size_t i = 0; i < report->items.count && count < most; ++i) {
        const ReportItem *item = &report->items.items[i];
        bool good = is_here(item, document) && has_fix(item, document);
        for (uint32_t k = 0; good && k < count; ++k) {
            good = item->fix_at.end < taken[k]->fix_at.begin ||
                   item->fix_at.begin > taken[k]->fix_at.end;
        }
        if (good) {
            taken[count++] = item;
            cJSON_AddItemToArray(edits, json_edit(server, &document->text, item->fix_at.begin,
                                                  item->fix_at.end, str_from(item->fix_text)));
        }
    }
    return count;
}

static void add_fix_all(const Server *server, const Document *document, cJSON *list)
{
    enum { MOST = 200 };
    const ReportItem *taken[MOST];
    cJSON *edits = cJSON_CreateArray();
    uint32_t count = collect_all(server, document, &document->said, edits, taken, 0, MOST);
    count = collect_all(server, document, &document->found, edits, taken, count, MOST);
    if (count > 0) {
        cJSON *action = cJSON_CreateObject();
        cJSON_AddStringToObject(action, "title", "Apply all suggestions");
        cJSON_AddStringToObject(action, "kind", "source.fixAll.scnrender");
        cJSON_AddItemToObject(action, "edit", edit_of(server, document, edits));
        cJSON_AddItemToArray(list, action);
    }
    cJSON_Delete(edits);
}

// Whether actions of a kind are asked for: "source" asks for all that begin with "source.".
static bool wanted(const cJSON *params, const char *kind)
{
    const cJSON *only = json_at(params, "context.only"), *item;
    if (!cJSON_IsArray(only)) {
        return true;
    }
    cJSON_ArrayForEach(item, only)
    {
        const char *asked = cJSON_GetStringValue(item);
        size_t length = asked ? strlen(asked) : 0;
        if (asked && strncmp(kind, asked, length) == 0 &&
            (kind[length] == '\0' || kind[length] == '.' || length == 0)) {
            return true;
        }
    }
    return false;
}

cJSON *feature_code_actions(Server *server, Document *document, const cJSON *params)
{
    cJSON *list = cJSON_CreateArray();
    uint32_t begin, end;
    server_range(server, document, json_at(params, "range"), &begin, &end);
    document_analysis(server, document);
    if (wanted(params, "quickfix")) {
        add_fixes(server, document, &document->said, begin, end, params, list);
        add_fixes(server, document, &document->found, begin, end, params, list);
    }
    bool asked = cJSON_IsArray(json_at(params, "context.only"));
    if (asked && wanted(params, "source.fixAll.scnrender")) {
        add_fix_all(server, document, list);
    }
    return list;
}
