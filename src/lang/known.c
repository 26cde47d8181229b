// What can be made sense of while the rest of the file is still text (see early.c).
#include "lang/builtins.h"
#include "lang/resolve.h"

static AstNode *node_at(const Resolver *r, AstId id)
{
    return &r->ast->nodes.items[id];
}

// Whether a name means the same whatever the rest of the file says. A built-in name does so long as
// the file doesn't declare it: that it is relied on is noted. `print` waits for what comes before.
static bool is_known_name(Resolver *r, Symbol name)
{
    const Eval *ev = r->ev;
    if (r->current[name]) {
        return r->bindings[r->current[name]].known;
    }
    const uint32_t builtin = name < ev->symbol_count ? ev->symbols[name].builtin : 0;
    const bool known = builtin ? builtins[builtin - 1].function != builtin_print
                               : constant_find(symbol_name(ev->names, name)) >= 0;
    r->relied[name] = r->relied[name] || known;
    return known;
}

static bool is_known_list(Resolver *r, uint32_t list)
{
    bool known = true;
    for (uint32_t i = 0; known && i < ast_list_count(r->ast, list); ++i) {
        known = resolver_knows(r, ast_list_items(r->ast, list)[i]);
    }
    return known;
}

bool resolver_knows(Resolver *r, AstId id)
{
    const AstNode *node = node_at(r, id);
    switch ((AstTag)node->tag) {
    case AST_NUMBER:
    case AST_STRING:
    case AST_COLOR:
    case AST_BOOL:
        return true;
    case AST_NAME:
        return node->a && is_known_name(r, node->a);
    case AST_VECTOR:
    case AST_LIST:
        return is_known_list(r, node->a);
    case AST_EMIT:
    case AST_UNARY:
    case AST_MEMBER:
        return resolver_knows(r, node->a);
    case AST_RANGE:
    case AST_BINARY:
    case AST_INDEX:
        return resolver_knows(r, node->a) && resolver_knows(r, node->b);
    case AST_IF: {
        const uint32_t *words = &r->ast->extra.items[node->b];
        return resolver_knows(r, node->a) && resolver_knows(r, words[0]) &&
               (words[1] == 0 || resolver_knows(r, words[1]));
    }
    case AST_CALL:
        return resolver_knows(r, node->a) && is_known_list(r, node->b);
    case AST_KIND:
        return is_known_list(r, node->b);
    case AST_FIELD:
    case AST_ARGUMENT:
        return resolver_knows(r, node->b);
    default: // what makes frames or functions, and what could not be parsed
        return false;
    }
}

bool resolver_learn(Resolver *r, AstId id)
{
    AstNode *node = node_at(r, id);
    const uint32_t *words = &r->ast->extra.items[node->b];
    const bool is_param = node->tag == AST_PARAM;
    const bool known =
        is_param ? resolver_knows(r, words[3]) && (words[4] == 0 || resolver_knows(r, words[4]))
                 : resolver_knows(r, words[2]);
    if (!known || !node->a) {
        return false;
    }
    resolver_resolve(r, id);
    node_at(r, id)->op = ITEM_RESOLVED;
    r->bindings[r->current[node->a]].known = true;
    return true;
}
