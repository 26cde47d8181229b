// Inlay hints: what a let comes to, the names of parameters, quantities in other units.
#include "lsp/features.h"
#include "lsp/tree.h"

#include "schema/photometry.h"

#include <ctype.h>

typedef struct Hints {
    Server *server;
    Document *document;
    const Analysis *analysis;
    const Ast *ast;
    uint32_t begin, end; // bytes that are asked for
    cJSON *list;
} Hints;

enum { HINT_TYPE = 1, HINT_PARAMETER = 2, FEW_PARAMETERS = 4 };

static void add_hint(Hints *h, uint32_t at, int kind, const char *label, const char *tooltip)
{
    if (at < h->begin || at > h->end) {
        return;
    }
    cJSON *hint = cJSON_CreateObject();
    cJSON_AddItemToObject(hint, "position", json_position(h->server, &h->document->text, at));
    json_add_text(hint, "label", str_from(label));
    cJSON_AddNumberToObject(hint, "kind", kind);
    cJSON_AddTrueToObject(hint, kind == HINT_PARAMETER ? "paddingRight" : "paddingLeft");
    if (tooltip) {
        json_add_text(hint, "tooltip", str_from(tooltip));
    }
    cJSON_AddItemToArray(h->list, hint);
}

// --- Values --------------------------------------------------------------------------------------

// What says itself what it is.
static bool is_plain(const Hints *h, AstId id)
{
    const AstNode *node = ast_node(h->ast, id);
    switch ((AstTag)node->tag) {
    case AST_NUMBER:
    case AST_STRING:
    case AST_COLOR:
    case AST_BOOL:
    case AST_KIND:
    case AST_WITH:
    case AST_FN:
    case AST_ERROR:
        return true;
    case AST_UNARY:
        return node->a && is_plain(h, node->a);
    case AST_VECTOR:
    case AST_LIST:
    case AST_RANGE:
    case AST_CALL: { // plain where its parts are; `rgb(1, 0, 0)` has nothing to be told
        bool list = node->tag == AST_LIST || node->tag == AST_VECTOR;
        if (node->tag == AST_RANGE) {
            return is_plain(h, node->a) && is_plain(h, node->b);
        }
        double color[3];
        if (!list) {
            return survey_color(h->analysis->survey, 0, id, color);
        }
        uint32_t count = ast_list_count(h->ast, node->a);
        for (uint32_t i = 0; i < count; ++i) {
            if (!is_plain(h, ast_list_items(h->ast, node->a)[i])) {
                return false;
            }
        }
        return true;
    }
    default:
        return false;
    }
}

static void hint_value(Hints *h, AstId item)
{
    AstId value = tree_words(h->ast, ast_node(h->ast, item))[2];
    Span name = survey_name_span(h->analysis->survey, 0, item);
    const ReportValue *found = report_value(&h->document->found, h->document->real, name.begin);
    if (!value || !found || is_plain(h, value)) {
        return;
    }
    char label[200];
    snprintf(label, sizeof label, found->varies ? "= %s, …" : "= %s", found->text);
    add_hint(h, ast_node(h->ast, value)->end, HINT_TYPE, label, found->type);
}

// --- Parameters ----------------------------------------------------------------------------------

// The name of parameter `index` in a signature like "f(a, b = 2)"; empty where it has no such.
static Str signature_name(const char *signature, uint32_t index, uint32_t *count)
{
    Str name = STR("");
    *count = 0;
    const char *at = strchr(signature, '(');
    while (at && *at && *at != ')') {
        at += 1;
        at += strspn(at, " ");
        size_t length = 0;
        while (isalnum((unsigned char)at[length]) || at[length] == '_') {
            ++length;
        }
        if (*count == index) {
            name = (Str){at, length};
        }
        *count += length > 0;
        at = strpbrk(at, ",)");
    }
    return name;
}

// An argument that says itself what it is for.
static bool names_it(const Hints *h, AstId argument, Str name)
{
    const AstNode *node = ast_node(h->ast, argument);
    Str text = tree_text(h->analysis, 0);
    Str written = {text.at + node->begin, node->end - node->begin};
    if (node->tag == AST_ARGUMENT) {
        return true;
    }
    return (node->tag == AST_NAME || node->tag == AST_MEMBER) && written.length >= name.length &&
           memcmp(written.at + written.length - name.length, name.at, name.length) == 0;
}

static Str parameter_name(const Hints *h, const AstNode *call, uint32_t index)
{
    Meaning meaning = survey_meaning(h->analysis->survey, 0, call->a);
    uint32_t file = 0, count;
    if (meaning.kind == MEANS_BUILTIN) {
        Str name = signature_name(lang_builtins[meaning.number].signature, index, &count);
        return count >= FEW_PARAMETERS ? name : STR("");
    }
    AstId fn = tree_function(h->analysis, &file, call->a);
    const Ast *ast = survey_ast(h->analysis->survey, file);
    AstId parameter = fn ? tree_parameter_at(ast, fn, index) : 0;
    return parameter ? tree_symbol(h->analysis, ast_node(ast, parameter)->a) : STR("");
}

static void hint_names(Hints *h, const AstNode *call)
{
    for (uint32_t i = 0; i < ast_list_count(h->ast, call->b); ++i) {
        AstId argument = ast_list_items(h->ast, call->b)[i];
        Str name = parameter_name(h, call, i);
        if (argument && name.length > 1 && !names_it(h, argument, name)) {
            char label[120];
            snprintf(label, sizeof label, "%.*s:", (int)(name.length < 100 ? name.length : 100),
                     name.at);
            add_hint(h, ast_node(h->ast, argument)->begin, HINT_PARAMETER, label, NULL);
        }
    }
}

// --- Quantities ----------------------------------------------------------------------------------

// Of white light, and of angles that nobody thinks in.
static void hint_unit(Hints *h, AstId id)
{
    Quantity quantity = survey_number(h->analysis->survey, 0, id);
    const AstNode *node = ast_node(h->ast, id);
    const char *unit = quantity.dim == DIM_LUMINOUS_FLUX        ? "W"
                       : quantity.dim == DIM_LUMINOUS_INTENSITY ? "W/sr"
                       : quantity.dim == DIM_ILLUMINANCE        ? "W/m²"
                       : quantity.dim == DIM_LUMINANCE          ? "W/m²/sr"
                                                                : NULL;
    Str text = tree_text(h->analysis, 0);
    char label[60];
    if (quantity.value == 1) {
        return; // a unit, to divide by
    }
    if (unit) {
        snprintf(label, sizeof label, "≙ %.4g %s", quantity.value / LUMENS_PER_WATT, unit);
        add_hint(h, node->end, HINT_TYPE, label, "of white light: divided by 683 lm/W");
    } else if (quantity.dim == DIM_ANGLE && node->end > 3 &&
               memcmp(text.at + node->end - 3, "deg", 3) != 0) {
        snprintf(label, sizeof label, "= %.6gdeg", quantity.value * (180 / PI));
        add_hint(h, node->end, HINT_TYPE, label, NULL);
    }
}

cJSON *feature_inlay_hints(Server *server, Document *document, const cJSON *params)
{
    Hints h = {.server = server, .document = document, .list = cJSON_CreateArray()};
    h.analysis = document_analysis(server, document);
    if (!h.analysis) {
        return h.list;
    }
    h.ast = survey_ast(h.analysis->survey, 0);
    server_range(server, document, json_at(params, "range"), &h.begin, &h.end);
    for (AstId id = 1; id < h.ast->nodes.count; ++id) {
        const AstNode *node = ast_node(h.ast, id);
        if (node->end < h.begin || node->begin > h.end) {
            continue;
        }
        if (node->tag == AST_LET && server->settings.hint_values) {
            hint_value(&h, id);
        } else if (node->tag == AST_CALL && server->settings.hint_names) {
            hint_names(&h, node);
        } else if (node->tag == AST_NUMBER && node->aux && server->settings.hint_units) {
            hint_unit(&h, id);
        }
    }
    return h.list;
}
