#include "bench.h"

void bench_begin(ParseBench *bench, const char *text, size_t length)
{
    *bench = (ParseBench){0};
    sources_init(&bench->sources, &bench->arena);
    interner_init(&bench->names, &bench->arena);
    diag_sink_init(&bench->sink, &bench->arena);
    uint32_t file = sources_add(&bench->sources, "test.scn", NULL, (Str){text, length}, (Span){0});
    if (file) {
        bench->ok = parse(&bench->ast, &bench->sources, file, &bench->names, (ParseLimits){200},
                          true, &bench->sink);
    }
}

void bench_end(ParseBench *bench)
{
    ast_free(&bench->ast);
    diag_sink_free(&bench->sink);
    interner_free(&bench->names);
    sources_free(&bench->sources);
    arena_free(&bench->arena);
}

typedef struct Check {
    const Ast *ast;
    uint32_t length;
    const char *wrong;
} Check;

static void check_node(Check *check, AstId id, const AstNode *parent, uint32_t parent_id,
                       unsigned depth);

static void check_child(Check *check, AstId id, AstId parent, unsigned depth)
{
    if (id) {
        check_node(check, id, ast_node(check->ast, parent), parent, depth + 1);
    }
}

static void check_list(Check *check, uint32_t list, AstId parent, unsigned depth)
{
    if (list >= check->ast->extra.count ||
        ast_list_count(check->ast, list) > check->ast->extra.count - list - 1) {
        check->wrong = "a list beyond the end of the extra words";
        return;
    }
    for (uint32_t i = 0; i < ast_list_count(check->ast, list); ++i) {
        check_child(check, ast_list_items(check->ast, list)[i], parent, depth);
    }
}

static void check_words(Check *check, AstId id, unsigned mask, unsigned depth)
{
    uint32_t first = ast_node(check->ast, id)->b;
    for (uint32_t i = 0; mask >> i && !check->wrong; ++i) {
        if (first + i >= check->ast->extra.count) {
            check->wrong = "a word beyond the end";
        } else if (mask >> i & 1) {
            check_child(check, check->ast->extra.items[first + i], id, depth);
        }
    }
}

static void check_children(Check *check, AstId id, unsigned depth)
{
    const AstNode *node = ast_node(check->ast, id);
    switch (node->tag) {
    case AST_FILE:
    case AST_BLOCK:
    case AST_VECTOR:
    case AST_LIST:
        check_list(check, node->a, id, depth);
        break;
    case AST_IMPORT:
    case AST_UNARY:
    case AST_EMIT:
    case AST_MEMBER:
        check_child(check, node->a, id, depth);
        break;
    case AST_PARAM:
        check_words(check, id, 1 << 3 | 1 << 4 | 1 << 5, depth);
        break;
    case AST_LET:
        check_words(check, id, 1 << 2, depth);
        break;
    case AST_FN:
        check_words(check, id, 1 << 2, depth);
        check_list(check, check->ast->extra.items[node->b + 3], id, depth);
        break;
    case AST_FOR:
        check_words(check, id, 1 << 2 | 1 << 3, depth);
        break;
    case AST_EXPECT:
    case AST_IF:
        check_child(check, node->a, id, depth);
        check_words(check, id, 1 | 2, depth);
        break;
    case AST_RANGE:
    case AST_BINARY:
    case AST_INDEX:
        check_child(check, node->a, id, depth);
        check_child(check, node->b, id, depth);
        break;
    case AST_CALL:
    case AST_WITH:
        check_child(check, node->a, id, depth);
        check_list(check, node->b, id, depth);
        break;
    case AST_KIND:
        check_list(check, node->b, id, depth);
        break;
    case AST_PARAMETER:
    case AST_ARGUMENT:
    case AST_FIELD:
        check_child(check, node->b, id, depth);
        break;
    default:
        break;
    }
}

static void check_node(Check *check, AstId id, const AstNode *parent, uint32_t parent_id,
                       unsigned depth)
{
    if (check->wrong) {
        return;
    }
    if (id >= check->ast->nodes.count || id >= parent_id) {
        check->wrong = "a child that does not come before its parent";
        return;
    }
    const AstNode *node = ast_node(check->ast, id);
    if (node->tag >= AST_TAG_COUNT || node->tag == AST_NONE) {
        check->wrong = "an unknown tag";
    } else if (node->begin > node->end || node->end > check->length) {
        check->wrong = "a node that does not lie in the text";
    } else if (parent && (node->begin < parent->begin || node->end > parent->end)) {
        check->wrong = "a child that does not lie in its parent";
    } else if (depth > ast_deepest((ParseLimits){200})) {
        check->wrong = "a tree deeper than promised";
    } else {
        check_children(check, id, depth);
    }
}

static bool lies_inside(const ParseBench *bench, Span at)
{
    const Source *source = source_get(&bench->sources, at.file);
    return source && at.begin <= at.end && at.end <= source->text.length;
}

static void write_everything(ParseBench *bench)
{
    FILE *out = fopen("/dev/null", "w");
    diag_write_text(&bench->sink, &bench->sources, out, DIAG_COLORED);
    diag_write_json(&bench->sink, &bench->sources, out);
    ast_dump(&bench->ast, &bench->names, out);
    fclose(out);
}

const char *bench_check(ParseBench *bench)
{
    write_everything(bench);
    return bench_check_tree(bench);
}

const char *bench_check_tree(const ParseBench *bench)
{
    if (bench->ok != (bench->sink.errors == 0)) {
        return "success and reported errors don't agree";
    }
    for (uint32_t i = 0; i < bench->sink.count; ++i) {
        const Diag *diag = &bench->sink.items[i];
        if (!lies_inside(bench, diag->at) ||
            (diag->fix_text && !lies_inside(bench, diag->fix_at))) {
            return "a diagnostic that does not lie in the text";
        }
    }
    const Source *source = source_get(&bench->sources, bench->ast.file);
    if (!bench->ast.root) {
        return bench->ok ? "success without a tree" : NULL;
    }
    Check check = {&bench->ast, (uint32_t)source->text.length, NULL};
    check_node(&check, bench->ast.root, NULL, UINT32_MAX, 0);
    for (size_t i = 1; i < bench->ast.nodes.count && bench->ok && !check.wrong; ++i) {
        if (bench->ast.nodes.items[i].tag == AST_ERROR) {
            check.wrong = "an ERROR node without an error";
        }
    }
    return check.wrong;
}
