#include "lang/format.h"

typedef struct Pair {
    const Ast *a, *b;
} Pair;

static bool equal_lists(Pair p, uint32_t a, uint32_t b)
{
    uint32_t count = ast_list_count(p.a, a);
    return count == ast_list_count(p.b, b) &&
           memcmp(ast_list_items(p.a, a), ast_list_items(p.b, b), count * sizeof(uint32_t)) == 0;
}

// Compares the words that aren't places: bit i of `mask` for word i.
static bool equal_words(Pair p, uint32_t a, uint32_t b, unsigned mask)
{
    for (uint32_t i = 0; mask >> i; ++i) {
        if (mask >> i & 1 && p.a->extra.items[a + i] != p.b->extra.items[b + i]) {
            return false;
        }
    }
    return true;
}

static bool equal_payload(Pair p, const AstNode *a, const AstNode *b)
{
    switch ((AstTag)a->tag) {
    case AST_FILE:
    case AST_BLOCK:
    case AST_VECTOR:
    case AST_LIST:
        return equal_lists(p, a->a, b->a);
    case AST_CALL:
    case AST_KIND:
    case AST_WITH:
        return a->a == b->a && equal_lists(p, a->b, b->b);
    case AST_IMPORT:
        return a->a == b->a && equal_words(p, a->b, b->b, 1);
    case AST_PARAM:
        return a->a == b->a && equal_words(p, a->b, b->b, 1 << 2 | 1 << 3 | 1 << 4 | 1 << 5);
    case AST_LET:
        return a->a == b->a && equal_words(p, a->b, b->b, 1 << 2);
    case AST_FN:
        return a->a == b->a && equal_words(p, a->b, b->b, 1 << 2) &&
               equal_lists(p, p.a->extra.items[a->b + 3], p.b->extra.items[b->b + 3]);
    case AST_FOR:
        return a->a == b->a && equal_words(p, a->b, b->b, 1 << 2 | 1 << 3);
    case AST_IF:
    case AST_EXPECT:
        return a->a == b->a && equal_words(p, a->b, b->b, 1 | 1 << 1);
    default:
        return a->a == b->a && a->b == b->b;
    }
}

// The parser numbers nodes in the order in which it reads them, so equal trees have equal numbers,
// and comparing them needs no recursion.
bool ast_equal(const Ast *a, const Ast *b)
{
    if (a->version != b->version || a->root != b->root || a->nodes.count != b->nodes.count) {
        return false;
    }
    for (size_t i = 1; i < a->nodes.count; ++i) {
        const AstNode *left = &a->nodes.items[i], *right = &b->nodes.items[i];
        if (left->tag != right->tag || left->op != right->op || left->aux != right->aux ||
            !equal_payload((Pair){a, b}, left, right)) {
            return false;
        }
    }
    return true;
}
