// The tree as S-expressions: (tag begin:end payload children…).
#include "lang/ast.h"

#include "schema/schema.h"

#include <inttypes.h>
#include <stdlib.h>

const char *ast_tag_name(AstTag tag)
{
    static const char *const names[] = {
#define AST(tag, doc) #tag,
        AST_NODES(AST)
#undef AST
    };
    return names[tag];
}

typedef struct Dumper {
    const Ast *ast;
    const Interner *names;
    FILE *out;
} Dumper;

static void dump_node(const Dumper *d, AstId id, int depth);

static void put_string(FILE *out, Str text)
{
    putc('"', out);
    for (size_t i = 0; i < text.length; ++i) {
        char c = text.at[i];
        if (c == '"' || c == '\\') {
            fprintf(out, "\\%c", c);
        } else if (c == '\n') {
            fputs("\\n", out);
        } else if (c == '\t') {
            fputs("\\t", out);
        } else if ((unsigned char)c < 0x20) {
            fprintf(out, "\\u{%x}", (unsigned)(unsigned char)c);
        } else {
            putc(c, out);
        }
    }
    putc('"', out);
}

// The shortest decimal that reads back as the same double.
static void put_number(FILE *out, double value)
{
    char text[40];
    for (int digits = 15; digits <= 17; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value) {
            break;
        }
    }
    fputs(text, out);
}

static void put_symbol(const Dumper *d, Symbol symbol)
{
    fprintf(d->out, " %s", symbol ? symbol_name(d->names, symbol).at : "-");
}

static void dump_child(const Dumper *d, AstId id, int depth)
{
    putc('\n', d->out);
    for (int i = 0; i < depth; ++i) {
        fputs("  ", d->out);
    }
    dump_node(d, id, depth);
}

static void dump_list(const Dumper *d, uint32_t list, int depth)
{
    const uint32_t *items = ast_list_items(d->ast, list);
    for (uint32_t i = 0; i < ast_list_count(d->ast, list); ++i) {
        dump_child(d, items[i], depth);
    }
}

// The words of `mask` (bit i: words[i]) that are there, as children.
static void dump_words(const Dumper *d, const uint32_t *words, unsigned mask, int depth)
{
    for (int i = 0; mask >> i; ++i) {
        if ((mask >> i & 1) && words[i]) {
            dump_child(d, words[i], depth);
        }
    }
}

static void dump_leaf(const Dumper *d, const AstNode *node)
{
    switch (node->tag) {
    case AST_NUMBER:
        putc(' ', d->out);
        put_number(d->out, ast_number(node));
        if (node->aux) {
            fprintf(d->out, " %s", schema_units[node->aux - 1].name);
        }
        break;
    case AST_STRING:
        putc(' ', d->out);
        put_string(d->out, symbol_name(d->names, node->a));
        break;
    case AST_COLOR:
        fprintf(d->out, " #%06" PRIx32, node->a);
        break;
    case AST_BOOL:
        fputs(node->a ? " true" : " false", d->out);
        break;
    default:
        break;
    }
}

static void dump_declaration(const Dumper *d, const AstNode *node, int depth)
{
    const uint32_t *words = d->ast->extra.items + node->b;
    switch (node->tag) {
    case AST_IMPORT:
        put_symbol(d, words[0]);
        dump_child(d, node->a, depth);
        break;
    case AST_PARAM:
        put_symbol(d, node->a);
        put_symbol(d, words[2]);
        dump_words(d, words, 1 << 3 | 1 << 4 | 1 << 5, depth);
        break;
    case AST_LET:
        put_symbol(d, node->a);
        dump_words(d, words, 1 << 2, depth);
        break;
    case AST_FN:
        put_symbol(d, node->a);
        dump_list(d, words[3], depth);
        dump_words(d, words, 1 << 2, depth);
        break;
    default: // FOR
        put_symbol(d, node->a);
        dump_words(d, words, 1 << 2 | 1 << 3, depth);
    }
}

static void dump_inner(const Dumper *d, const AstNode *node, int depth)
{
    const uint32_t pair[] = {node->a, node->b};
    switch (node->tag) {
    case AST_FILE:
    case AST_BLOCK:
    case AST_VECTOR:
    case AST_LIST:
        dump_list(d, node->a, depth);
        break;
    case AST_NAME:
        put_symbol(d, node->a);
        break;
    case AST_PARAMETER:
    case AST_ARGUMENT:
    case AST_FIELD:
        put_symbol(d, node->a);
        dump_words(d, pair, 2, depth);
        break;
    case AST_IF:
        dump_words(d, pair, 1, depth);
        dump_words(d, d->ast->extra.items + node->b, 3, depth);
        break;
    case AST_UNARY:
    case AST_BINARY:
        fprintf(d->out, " %s", operator_text((Operator)node->op));
        dump_words(d, pair, node->tag == AST_UNARY ? 1 : 3, depth);
        break;
    case AST_RANGE:
        fputs(node->aux ? " ..<" : " ..", d->out);
        dump_words(d, pair, 3, depth);
        break;
    case AST_EMIT:
        dump_words(d, pair, 1, depth);
        break;
    case AST_EXPECT:
        dump_words(d, pair, 1, depth);
        fputs(node->aux ? " %" : "", d->out);
        dump_words(d, d->ast->extra.items + node->b, 3, depth);
        break;
    case AST_INDEX:
        dump_words(d, pair, 3, depth);
        break;
    case AST_MEMBER:
        put_symbol(d, node->b);
        dump_words(d, pair, 1, depth);
        break;
    case AST_KIND:
        put_symbol(d, node->a);
        dump_list(d, node->b, depth);
        break;
    case AST_CALL:
    case AST_WITH:
        dump_words(d, pair, 1, depth);
        dump_list(d, node->b, depth);
        break;
    default:
        break;
    }
}

static void dump_node(const Dumper *d, AstId id, int depth)
{
    const AstNode *node = ast_node(d->ast, id);
    putc('(', d->out);
    for (const char *c = ast_tag_name((AstTag)node->tag); *c; ++c) {
        putc(*c | 0x20, d->out);
    }
    fprintf(d->out, " %u:%u", node->begin, node->end);
    switch (node->tag) {
    case AST_NUMBER:
    case AST_STRING:
    case AST_COLOR:
    case AST_BOOL:
        dump_leaf(d, node);
        break;
    case AST_IMPORT:
    case AST_PARAM:
    case AST_LET:
    case AST_FN:
    case AST_FOR:
        dump_declaration(d, node, depth + 1);
        break;
    default:
        dump_inner(d, node, depth + 1);
    }
    putc(')', d->out);
}

void ast_dump(const Ast *ast, const Interner *names, FILE *out)
{
    if (ast->root) {
        dump_node(&(Dumper){ast, names, out}, ast->root, 0);
        putc('\n', out);
    }
}
