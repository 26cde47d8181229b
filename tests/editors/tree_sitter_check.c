// Holds the tree-sitter grammar to the program's own parser over .scn files: no error node where
// the parser finds no error, and for each token of the lexer a leaf with the same bytes and of the
// right kind, so that words, numbers and their units, strings and comments are highlighted as what
// they are. The queries must compile, and tell keywords, kinds, fields, numbers and units.
//
// usage: tree_sitter_check QUERIES GRAMMAR SENTENCES FILE...
#include "base/io.h"
#include "lang/lexer.h"
#include "schema/schema.h"

#include "../language/grammar/grammar.h"

#include <stdlib.h>
#include <tree_sitter/api.h>

const TSLanguage *tree_sitter_scn(void);

static int failures;

static void complain(const char *path, Str text, uint32_t at, const char *what, const char *more)
{
    uint32_t line = 1;
    for (uint32_t i = 0; i < at && i < text.length; ++i) {
        line += text.at[i] == '\n';
    }
    fprintf(stderr, "%s:%u: %s %s\n", path, line, what, more);
    ++failures;
}

// --- Leaves --------------------------------------------------------------------------------------

// The type that a node over a token must have; NULL: its text.
static const char *expected_type(uint8_t kind)
{
    switch (kind) {
    case TOKEN_NUMBER:
        return "number";
    case TOKEN_STRING:
        return "string";
    case TOKEN_COLOR:
        return "color";
    case TOKEN_TRUE:
    case TOKEN_FALSE:
        return "boolean";
    default:
        return NULL;
    }
}

static bool is_type(TSNode node, const char *type)
{
    return strcmp(ts_node_type(node), type) == 0;
}

static void check_token(const char *path, Str text, TSNode root, const Token *token)
{
    TSNode node = ts_node_descendant_for_byte_range(root, token->begin, token->end);
    const char *expected = expected_type(token->kind);
    char words[32];
    snprintf(words, sizeof words, "%.*s", (int)(token->end - token->begin), text.at + token->begin);
    bool same = ts_node_start_byte(node) == token->begin && ts_node_end_byte(node) == token->end;
    bool good;
    if (token->kind == TOKEN_NAME) {
        // `scn` and `of` are words in their places; the header's number is a version.
        good = is_type(node, "identifier") || is_type(node, "type") || is_type(node, words);
    } else if (expected) {
        good = is_type(node, expected) || is_type(node, words) ||
               (token->kind == TOKEN_NUMBER && is_type(node, "version"));
    } else {
        good = is_type(node, words);
    }
    if (!same || !good) {
        complain(path, text, token->begin, words, ts_node_type(node));
    }
    if (token->kind == TOKEN_NUMBER && token->unit && good) {
        TSNode unit = ts_node_named_child(node, 0);
        uint32_t length = (uint32_t)strlen(schema_units[token->unit - 1].name);
        if (ts_node_is_null(unit) || !is_type(unit, "unit") ||
            ts_node_end_byte(unit) - ts_node_start_byte(unit) != length) {
            complain(path, text, token->begin, words, "has no unit");
        }
    }
}

static void check_comment(const char *path, Str text, TSNode root, AstComment comment)
{
    TSNode node = ts_node_descendant_for_byte_range(root, comment.begin, comment.begin + 2);
    bool line = text.at[comment.begin + 1] == '/';
    uint32_t end = ts_node_end_byte(node);
    end -= line && end > comment.end; // the carriage return
    if (!is_type(node, line ? "line_comment" : "block_comment") || end != comment.end) {
        complain(path, text, comment.begin, "comment", ts_node_type(node));
    }
}

typedef struct Reader {
    Lexer lexer;
    Token token;
    AstCommentArray comments;
    jmp_buf on_oom;
} Reader;

static void check_tokens(const char *path, const Source *source, Interner *names, DiagSink *sink,
                         TSNode root)
{
    static Reader r;
    memset(&r, 0, sizeof r);
    if (setjmp(r.on_oom) != 0) {
        abort();
    }
    lexer_init(&r.lexer, source, 1, names, sink, &r.comments, &r.on_oom);
    for (lexer_next(&r.lexer, &r.token); r.token.kind != TOKEN_END;
         lexer_next(&r.lexer, &r.token)) {
        check_token(path, source->text, root, &r.token);
    }
    for (size_t i = 0; i < r.comments.count; ++i) {
        check_comment(path, source->text, root, r.comments.items[i]);
    }
    lexer_free(&r.lexer);
    array_free(&r.comments);
}

// --- Files ---------------------------------------------------------------------------------------

static TSNode find_error(TSNode node)
{
    for (uint32_t i = 0; i < ts_node_child_count(node); ++i) {
        TSNode child = ts_node_child(node, i);
        if (ts_node_has_error(child)) {
            return find_error(child);
        }
    }
    return node;
}

// 1 where the program's parser finds no error; then there must be no error node.
static int check_text(const char *path, Str text, TSParser *parser)
{
    Arena arena = {0};
    Sources sources;
    Interner names;
    DiagSink sink;
    Ast ast;
    sources_init(&sources, &arena);
    interner_init(&names, &arena);
    diag_sink_init(&sink, &arena);
    uint32_t file = sources_add(&sources, path, NULL, text, (Span){0});
    bool good = parse(&ast, &sources, file, &names, (ParseLimits){200}, false, &sink);
    TSTree *tree = ts_parser_parse_string(parser, NULL, text.at, (uint32_t)text.length);
    TSNode root = ts_tree_root_node(tree);
    if (good && ts_node_has_error(root)) {
        complain(path, text, ts_node_start_byte(find_error(root)), "an error node", "");
    } else if (good) {
        check_tokens(path, source_get(&sources, file), &names, &sink, root);
    }
    ts_tree_delete(tree);
    ast_free(&ast);
    diag_sink_free(&sink);
    interner_free(&names);
    sources_free(&sources);
    arena_free(&arena);
    return good;
}

static int check_file(const char *path, TSParser *parser)
{
    FileBytes bytes;
    if (file_read(path, 1 << 26, &bytes) != IO_OK) {
        fprintf(stderr, "%s can't be read\n", path);
        ++failures;
        return 0;
    }
    int good = check_text(path, (Str){bytes.bytes, bytes.size}, parser);
    file_bytes_free(&bytes);
    return good;
}

// Random sentences of the grammar's file.
static void check_sentences(const char *path, unsigned long count, TSParser *parser)
{
    uint64_t seed = 20261126;
    printf("%lu sentences, seed %llu\n", count, (unsigned long long)seed);
    Grammar grammar = grammar_read(path);
    for (unsigned long i = 0; i < count && failures < 5; ++i) {
        Random random = {seed + i * 0x9e3779b97f4a7c15u};
        Bounds bounds = {8 + random_below(&random, 40), 20 + random_below(&random, 600)};
        size_t length;
        char *text = grammar_sentence(&grammar, &random, bounds, &length);
        int before = failures;
        check_text("sentence", (Str){text, length}, parser);
        if (failures > before) {
            fprintf(stderr, "----\n%s\n----\n", text);
        }
        free(text);
    }
    grammar_free(&grammar);
}

// --- Queries -------------------------------------------------------------------------------------

static TSQuery *read_query(const char *folder, const char *name)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FileBytes bytes;
    uint32_t at;
    TSQueryError error;
    if (file_read(path, 1 << 20, &bytes) != IO_OK) {
        fprintf(stderr, "%s can't be read\n", path);
        exit(1);
    }
    TSQuery *query =
        ts_query_new(tree_sitter_scn(), bytes.bytes, (uint32_t)bytes.size, &at, &error);
    if (!query) {
        fprintf(stderr, "%s: error %d at byte %u\n", path, (int)error, at);
        exit(1);
    }
    file_bytes_free(&bytes);
    return query;
}

// Whether `word` of the text is captured as `capture`.
static bool captures(const TSQuery *query, TSNode root, Str text, const char *word,
                     const char *capture)
{
    TSQueryCursor *cursor = ts_query_cursor_new();
    TSQueryMatch match;
    uint32_t index;
    bool found = false;
    ts_query_cursor_exec(cursor, query, root);
    while (ts_query_cursor_next_capture(cursor, &match, &index)) {
        TSNode node = match.captures[index].node;
        uint32_t length, begin = ts_node_start_byte(node);
        const char *name =
            ts_query_capture_name_for_id(query, match.captures[index].index, &length);
        Str is = {text.at + begin, ts_node_end_byte(node) - begin};
        found = found || (str_equal(is, str_from(word)) &&
                          str_equal((Str){name, length}, str_from(capture)));
    }
    ts_query_cursor_delete(cursor);
    return found;
}

static void check_queries(const char *folder, TSParser *parser)
{
    static const char *const others[] = {"locals.scm", "folds.scm", "indents.scm",
                                         "injections.scm"};
    static const char *const expected[][2] = {
        {"import", "keyword.import"},
        {"let", "keyword"},
        {"for", "keyword.repeat"},
        {"if", "keyword.conditional"},
        {"not", "keyword.operator"},
        {"sphere", "type"},
        {"radius", "property"},
        {"2.5cm", "number"},
        {"cm", "type.qualifier"},
        {"#c0704a", "constant"},
        {"\"a.scn\"", "string.special.path"},
        {"true", "boolean"},
        {"f", "function"},
        {"max", "function.builtin"},
        {"int", "type.builtin"},
        {"// end", "comment"},
        {"/* /* a */ */", "comment"},
    };
    static const char scene[] =
        "import \"a.scn\" as a\nparam n: int = 3\nlet b = not true\nfn f(x) = max(x, 1)\n"
        "for (i in 0..<n) { if (b) { sphere { radius: 2.5cm, material: f(#c0704a) } } }\n"
        "/* /* a */ */ // end\n";
    TSQuery *query = read_query(folder, "highlights.scm");
    TSTree *tree = ts_parser_parse_string(parser, NULL, scene, sizeof scene - 1);
    for (size_t i = 0; i < sizeof expected / sizeof *expected; ++i) {
        if (!captures(query, ts_tree_root_node(tree), (Str){scene, sizeof scene - 1},
                      expected[i][0], expected[i][1])) {
            fprintf(stderr, "`%s` is not highlighted as %s\n", expected[i][0], expected[i][1]);
            ++failures;
        }
    }
    ts_tree_delete(tree);
    ts_query_delete(query);
    for (size_t i = 0; i < sizeof others / sizeof *others; ++i) {
        ts_query_delete(read_query(folder, others[i]));
    }
}

int main(int argc, char **argv)
{
    TSParser *parser = ts_parser_new();
    if (argc < 5 || !ts_parser_set_language(parser, tree_sitter_scn())) {
        fprintf(stderr, "usage: tree_sitter_check QUERIES GRAMMAR SENTENCES FILE...\n");
        return 2;
    }
    check_queries(argv[1], parser);
    check_sentences(argv[2], strtoul(argv[3], NULL, 10), parser);
    int good = 0;
    for (int i = 4; i < argc; ++i) {
        good += check_file(argv[i], parser);
    }
    ts_parser_delete(parser);
    printf("%d files, %d without errors of syntax, %d complaints\n", argc - 4, good, failures);
    return failures > 0 || good * 2 < argc - 4;
}
