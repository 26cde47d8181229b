// Walks over syntax trees, and what stands at a place of a document.
#ifndef LSP_TREE_H
#define LSP_TREE_H

#include "lsp/server.h"

// Calls visit(context, child) for each child of a node in the order of the text.
typedef void TreeVisit(void *context, AstId child);
void tree_children(const Ast *ast, AstId id, TreeVisit *visit, void *context);

// The nodes from the root to the innermost one that holds byte `offset`, or that ends there.
enum { TREE_DEEPEST = 4096 };
typedef struct TreePath {
    AstId nodes[TREE_DEEPEST];
    size_t count;
} TreePath;
void tree_path(const Ast *ast, uint32_t offset, TreePath *path);

static inline const uint32_t *tree_words(const Ast *ast, const AstNode *node)
{
    return &ast->extra.items[node->b];
}
// The text of a symbol in a node of a survey's tree.
static inline Str tree_symbol(const Analysis *analysis, uint32_t symbol)
{
    return symbol_name(&analysis->lang.names, symbol);
}
// The type of a KIND node, or NULL.
const NodeType *tree_kind(const Analysis *analysis, const AstNode *kind);
// The kind that an expression gives, as far as its text tells; or NULL.
const NodeType *tree_infer_kind(const Analysis *analysis, uint32_t file, AstId expression);
// The FN that a callee stands for: *file and the node, or 0.
AstId tree_function(const Analysis *analysis, uint32_t *file, AstId callee);
// The PARAMETER of a FN by name or place; 0 where there is none.
AstId tree_parameter(const Ast *ast, AstId fn, Symbol name);
AstId tree_parameter_at(const Ast *ast, AstId fn, uint32_t index);

// The source text of a file of the survey, and its path.
Str tree_text(const Analysis *analysis, uint32_t file);
const char *tree_file_path(const Analysis *analysis, uint32_t file);

typedef enum TargetKind {
    TARGET_NONE,
    TARGET_NAME,   // a use or a declaration of `meaning`
    TARGET_KIND,   // the name of a kind: `type`
    TARGET_FIELD,  // of `type`: `param`, or `common`, or neither
    TARGET_STRING, // `node`; the `param` that takes it, if it is a field's value
    TARGET_IMPORT, // the path of an import: `node` is the IMPORT
    TARGET_NUMBER, // `node`
    TARGET_COLOR,  // `node`
    TARGET_TYPE,   // of a param
} TargetKind;

typedef struct Target {
    TargetKind kind;
    uint32_t begin, end; // in the document
    AstId node;
    Meaning meaning;
    const NodeType *type;
    const Param *param;
    CommonField common;
} Target;

Target target_at(const Analysis *analysis, uint32_t offset);

#endif
