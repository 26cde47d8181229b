// What can be folded, and what grows around a selection.
#include "lsp/features.h"
#include "lsp/tree.h"

#include "lang/lexer.h"

// --- Folding -------------------------------------------------------------------------------------

static void add_fold(cJSON *list, uint32_t first, uint32_t last, const char *kind)
{
    if (last <= first) {
        return;
    }
    cJSON *fold = cJSON_CreateObject();
    cJSON_AddNumberToObject(fold, "startLine", first);
    cJSON_AddNumberToObject(fold, "endLine", last);
    if (kind) {
        cJSON_AddStringToObject(fold, "kind", kind);
    }
    cJSON_AddItemToArray(list, fold);
}

typedef struct Run { // of lines that fold as one: comments, imports
    uint32_t first, last;
    bool any;
} Run;

static void end_run(Run *run, cJSON *list, const char *kind)
{
    if (run->any) {
        add_fold(list, run->first, run->last, kind);
    }
    run->any = false;
}

static void extend_run(Run *run, uint32_t line, cJSON *list, const char *kind)
{
    if (run->any && line > run->last + 1) {
        end_run(run, list, kind);
    }
    if (!run->any) {
        *run = (Run){line, line, true};
    }
    run->last = line;
}

cJSON *feature_folding_ranges(Server *server, Document *document, const cJSON *params)
{
    (void)params;
    enum { DEEPEST = 1000 };
    const DocumentTokens *tokens = document_tokens(server, document);
    const Buffer *text = &document->text;
    cJSON *list = cJSON_CreateArray();
    uint32_t open[DEEPEST], depth = 0, line = 0;
    Run comments = {0}, imports = {0};
    for (size_t i = 0; i < tokens->count; ++i) {
        const DocumentToken *token = &tokens->items[i];
        while (line + 1 < text->lines.count && text->lines.items[line + 1] <= token->begin) {
            ++line;
        }
        switch (token->kind) {
        case TOKEN_LEFT_BRACE:
        case TOKEN_LEFT_PAREN:
        case TOKEN_LEFT_BRACKET:
            if (depth < DEEPEST) {
                open[depth] = line;
            }
            ++depth;
            break;
        case TOKEN_RIGHT_BRACE:
        case TOKEN_RIGHT_PAREN:
        case TOKEN_RIGHT_BRACKET:
            depth -= depth > 0;
            // The line of the closing bracket stays in sight.
            if (depth < DEEPEST && line > open[depth] + 1) {
                add_fold(list, open[depth], line - 1, NULL);
            }
            break;
        case TOKEN_KIND_COUNT:
            if (text->bytes.items[token->begin + 1] == '*') {
                add_fold(list, line, buffer_line(text, token->end), "comment");
            } else {
                extend_run(&comments, line, list, "comment");
            }
            break;
        case TOKEN_IMPORT:
            extend_run(&imports, line, list, "imports");
            break;
        default:
            break;
        }
    }
    end_run(&comments, list, "comment");
    end_run(&imports, list, "imports");
    return list;
}

// --- Selections ----------------------------------------------------------------------------------

static cJSON *add_selection(const Server *server, const Document *document, uint32_t begin,
                            uint32_t end, cJSON *parent)
{
    cJSON *selection = cJSON_CreateObject();
    cJSON_AddItemToObject(selection, "range", json_range(server, &document->text, begin, end));
    if (parent) {
        cJSON_AddItemToObject(selection, "parent", parent);
    }
    return selection;
}

// From the file inwards to the word.
static cJSON *selection_at(Server *server, Document *document, const Analysis *analysis,
                           uint32_t offset)
{
    enum { MOST = 200 }; // the innermost
    const Ast *ast = survey_ast(analysis->survey, 0);
    TreePath path;
    tree_path(ast, offset, &path);
    uint32_t begin = 0, end = (uint32_t)document->text.bytes.count;
    cJSON *selection = add_selection(server, document, begin, end, NULL);
    for (size_t i = path.count > MOST ? path.count - MOST : 0; i < path.count; ++i) {
        const AstNode *node = ast_node(ast, path.nodes[i]);
        bool inside = node->begin >= begin && node->end <= end && node->end > node->begin;
        if (inside && (node->begin != begin || node->end != end)) {
            begin = node->begin;
            end = node->end;
            selection = add_selection(server, document, begin, end, selection);
        }
    }
    Target target = target_at(analysis, offset);
    bool word = target.kind != TARGET_NONE && target.begin >= begin && target.end <= end &&
                (target.begin != begin || target.end != end);
    return word ? add_selection(server, document, target.begin, target.end, selection) : selection;
}

cJSON *feature_selection_ranges(Server *server, Document *document, const cJSON *params)
{
    const Analysis *analysis = document_analysis(server, document);
    const cJSON *position;
    cJSON *list = cJSON_CreateArray();
    cJSON_ArrayForEach(position, json_at(params, "positions"))
    {
        uint32_t offset = server_offset(server, document, position);
        cJSON_AddItemToArray(list, analysis
                                       ? selection_at(server, document, analysis, offset)
                                       : add_selection(server, document, offset, offset, NULL));
    }
    return list;
}
