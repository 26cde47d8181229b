// Strings that name files, as links.
#include "lsp/features.h"
#include "lsp/tree.h"
#include "lsp/uri.h"

#include <unistd.h>

typedef struct Links {
    Server *server;
    const Document *document;
    const Analysis *analysis;
    const Ast *ast;
    const NodeType *kind; // around
    cJSON *list;
    int depth;
} Links;

static void add_link(const Links *links, AstId string)
{
    const AstNode *node = ast_node(links->ast, string);
    const char *path, *uri = NULL;
    if (node->tag == AST_STRING &&
        sandbox_resolve(&links->analysis->sandbox, &links->server->scratch, links->document->real,
                        tree_symbol(links->analysis, node->a), &path) == IO_OK &&
        access(path, R_OK) == 0) {
        uri = uri_from_path(&links->server->scratch, path);
    }
    if (uri && node->end - node->begin > 2) {
        cJSON *link = cJSON_CreateObject();
        cJSON_AddItemToObject(
            link, "range",
            json_range(links->server, &links->document->text, node->begin + 1, node->end - 1));
        cJSON_AddStringToObject(link, "target", uri);
        cJSON_AddItemToArray(links->list, link);
    }
}

static void look(void *context, AstId id)
{
    const Links *links = context;
    const AstNode *node = ast_node(links->ast, id);
    Links inner = *links;
    enum { DEEPEST = 3000 };
    if (++inner.depth > DEEPEST) {
        return;
    }
    if (node->tag == AST_IMPORT && node->a) {
        add_link(links, node->a);
    } else if (node->tag == AST_KIND) {
        inner.kind = tree_kind(links->analysis, node);
    } else if (node->tag == AST_FIELD && node->b && links->kind) {
        CommonField common;
        const Param *param = survey_field(links->analysis->survey, links->kind, node, &common);
        if (param && param->type == PARAM_FILE) {
            add_link(links, node->b);
        }
    }
    tree_children(links->ast, id, look, &inner);
}

cJSON *feature_links(Server *server, Document *document, const cJSON *params)
{
    (void)params;
    const Analysis *analysis = document_analysis(server, document);
    Links links = {.server = server, .document = document, .list = cJSON_CreateArray()};
    if (analysis) {
        links.analysis = analysis;
        links.ast = survey_ast(analysis->survey, 0);
        if (links.ast->root) {
            look(&links, links.ast->root);
        }
    }
    return links.list;
}
