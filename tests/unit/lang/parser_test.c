#include "base/mem.h"
#include "lang/ast.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

typedef struct Bench {
    Arena arena;
    Sources sources;
    Interner names;
    DiagSink sink;
    Ast ast;
    bool ok;
} Bench;

static void begin(Bench *bench, Str text, uint32_t nesting)
{
    *bench = (Bench){0};
    sources_init(&bench->sources, &bench->arena);
    interner_init(&bench->names, &bench->arena);
    diag_sink_init(&bench->sink, &bench->arena);
    uint32_t file = sources_add(&bench->sources, "test.scn", NULL, text, (Span){0});
    if (file) {
        bench->ok = parse(&bench->ast, &bench->sources, file, &bench->names, (ParseLimits){nesting},
                          true, &bench->sink);
    }
}

static void end(Bench *bench)
{
    ast_free(&bench->ast);
    diag_sink_free(&bench->sink);
    interner_free(&bench->names);
    sources_free(&bench->sources);
    arena_free(&bench->arena);
}

// The dump on one line, without the spans: `(let a (number 1))`.
static char *flat_dump(const Bench *bench)
{
    char *dump = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&dump, &size);
    ast_dump(&bench->ast, &bench->names, out);
    fclose(out);
    char *to = dump;
    for (const char *from = dump; *from; ++from) {
        if (*from == '\n') {
            while (from[1] == ' ') {
                ++from;
            }
            *to++ = ' ';
        } else if (*from == ' ' && from[1] >= '0' && from[1] <= '9' &&
                   strspn(from + 1, "0123456789:") > strspn(from + 1, "0123456789")) {
            from += strspn(from + 1, "0123456789:");
        } else {
            *to++ = *from;
        }
    }
    to[-1] = '\0'; // of the last newline
    return dump;
}

// `expected` is the inside of (file …).
static void check(const char *text, const char *expected)
{
    Bench bench;
    begin(&bench, str_from(text), 200);
    if (!bench.ok) {
        diag_write_text(&bench.sink, &bench.sources, stderr, DIAG_PLAIN);
        fail_msg("not accepted: %s", text);
    }
    char *dump = flat_dump(&bench);
    size_t length = strlen(expected);
    if (strncmp(dump, "(file ", 6) != 0 || strncmp(dump + 6, expected, length) != 0 ||
        strcmp(dump + 6 + length, ")") != 0) {
        fail_msg("%s\ngives    %s\nexpected (file %s)", text, dump, expected);
    }
    free(dump);
    end(&bench);
}

// An expression, as the value of a `let`.
static void check_value(const char *text, const char *expected)
{
    char source[512], tree[1024];
    snprintf(source, sizeof source, "let v = %s", text);
    snprintf(tree, sizeof tree, "(let v %s)", expected);
    check(source, tree);
}

static void operators(void **state)
{
    (void)state;
    check_value("a or b and not c == d",
                "(binary or (name a) (binary and (name b) (unary not (binary == (name c) (name "
                "d)))))");
    check_value("a + b * c ^ -d ^ e",
                "(binary + (name a) (binary * (name b) (binary ^ (name c) (unary - (binary ^ (name "
                "d) (name e))))))");
    check_value("-a ^ b", "(unary - (binary ^ (name a) (name b)))");
    check_value("a - b - c", "(binary - (binary - (name a) (name b)) (name c))");
    check_value("a ^ b ^ c", "(binary ^ (name a) (binary ^ (name b) (name c)))");
    check_value("a + 1 .. b * 2 == c",
                "(binary == (range .. (binary + (name a) (number 1)) (binary * (name b) (number "
                "2))) (name c))");
    check_value("0 ..< 5", "(range ..< (number 0) (number 5))");
    check_value("(a + b) * -c", "(binary * (binary + (name a) (name b)) (unary - (name c)))");
    check_value("not not a", "(unary not (unary not (name a)))");
    check_value("- -a", "(unary - (unary - (name a)))");
    check_value("a % b / c", "(binary / (binary % (name a) (name b)) (name c))");
    check_value("a < b and b <= c or c != d",
                "(binary or (binary and (binary < (name a) (name b)) (binary <= (name b) (name "
                "c))) (binary != (name c) (name d)))");
}

static void suffixes(void **state)
{
    (void)state;
    check_value("a.b[1](2, c: 3).d", "(member d (call (index (member b (name a)) (number 1)) "
                                     "(number 2) (argument c (number 3))))");
    check_value("a with { b: 1 c: 2, } with {}.d",
                "(member d (with (with (name a) (field b (number 1)) (field c (number 2)))))");
}

static void values(void **state)
{
    (void)state;
    check_value("[1, 2,]", "(list (number 1) (number 2))");
    check_value("[]", "(list)");
    check_value("(1, 2)", "(vector (number 1) (number 2))");
    check_value("(1, 2, 3, 4,)", "(vector (number 1) (number 2) (number 3) (number 4))");
    check_value("((a))", "(name a)");
    check_value("\"a\\\"b\\n\"", "(string \"a\\\"b\\n\")");
    check_value("#1a2", "(color #11aa22)");
    check_value("true", "(bool true)");
    check_value("60W", "(number 60 W)");
    check_value("if (a) b else if (c) d else e",
                "(if (name a) (name b) (if (name c) (name d) (name e)))");
    check_value("if (a) 1 else 2 + 3", "(if (name a) (number 1) (binary + (number 2) (number 3)))");
    check_value("fn(x, y = 2) = x * y",
                "(fn - (parameter x) (parameter y (number 2)) (binary * (name x) (name y)))");
    check_value("fn() { sphere {} }", "(fn - (block (emit (kind sphere))))");
    check_value("f()", "(call (name f))");
    check_value("f(a, b,)", "(call (name f) (name a) (name b))");
    check_value("f(a: 1)", "(call (name f) (argument a (number 1)))");
    check_value("f(a + 1, b.c)", "(call (name f) (binary + (name a) (number 1)) (member c (name "
                                 "b)))");
    check_value("f(sphere { radius: 2 })", "(call (name f) (kind sphere (field radius (number "
                                           "2))))");
}

static void comprehensions(void **state)
{
    (void)state;
    check_value("[for (i in 0..<9) f(i)]",
                "(list (for i (range ..< (number 0) (number 9)) (call (name f) (name i))))");
    check_value("[for (i in a) for (j in b) if (c) d]",
                "(list (for i (name a) (for j (name b) (if (name c) (name d)))))");
    check_value("[if (c) d else e, 1]", "(list (if (name c) (name d) (name e)) (number 1))");
    check_value("[if (a) if (b) c else d]", "(list (if (name a) (if (name b) (name c) (name d))))");
    check_value("[for (i in a) if (b) c else for (j in d) j]",
                "(list (for i (name a) (if (name b) (name c) (for j (name d) (name j)))))");
    check_value("[for (i in a) [for (j in b) i * j]]",
                "(list (for i (name a) (list (for j (name b) (binary * (name i) (name j))))))");
}

static void tolerances(void **state)
{
    (void)state;
    check("expect a within 1 + b of c + d",
          "(expect (name a) (binary + (number 1) (name b)) (binary + (name c) (name d)))");
    check("expect a within 1% of b", "(expect (name a) % (number 1) (name b))");
    check("expect a within b % /* of */\nof c", "(expect (name a) % (name b) (name c))");
    check("expect a within b % c % of d",
          "(expect (name a) % (binary % (name b) (name c)) (name d))");
    check("expect a within -b ^ c % of of", "(expect (name a) % (unary - (binary ^ (name b) "
                                            "(name c))) (name of))");
    // Within brackets, `of` is a name like any other.
    check("expect a within (b % of) of c",
          "(expect (name a) (binary % (name b) (name of)) (name c))");
    check("expect a within f(b % of, k { of: b % of }) of c",
          "(expect (name a) (call (name f) (binary % (name b) (name of)) "
          "(kind k (field of (binary % (name b) (name of))))) (name c))");
    check("expect if (a) b else c within 1% of d",
          "(expect (if (name a) (name b) (name c)) % (number 1) (name d))");
}

static void items(void **state)
{
    (void)state;
    check("import \"a.scn\" as a, param n: int = 5 in 1..40 \"text\" param s: string = \"x\"",
          "(import a (string \"a.scn\")) (param n int (number 5) (range .. (number 1) (number 40)) "
          "(string \"text\")) (param s string (string \"x\"))");
    check("fn f(a, b = 2) { g(a) let c = b h {} }",
          "(fn f (parameter a) (parameter b (number 2)) (block (emit (call (name g) (name a))) "
          "(let c (name b)) (emit (kind h))))");
    check("for (i in xs) { sphere {} }", "(for i (name xs) (block (emit (kind sphere))))");
    check("if (a) { b } else if (c) { d } else { e }",
          "(if (name a) (block (emit (name b))) (if (name c) (block (emit (name d))) (block (emit "
          "(name e)))))");
    check("if (a) b else c", "(emit (if (name a) (name b) (name c)))");
    check("a.b() tree with { transform: t }",
          "(emit (call (member b (name a)))) (emit (with (name tree) (field transform (name t))))");
    check("expect a == b expect c", "(expect (binary == (name a) (name b))) (expect (name c))");
    check("scn 1\nscn {}", "(emit (kind scn))");
    check("scn {}", "(emit (kind scn))");
    check("scn", "(emit (name scn))");
}

static void kinds(void **state)
{
    (void)state;
    check("group { material: m, sphere {} transform: t let a = 1 for (i in a) { b } if (c) { d } }",
          "(emit (kind group (field material (name m)) (emit (kind sphere)) (field transform "
          "(name t)) (let a (number 1)) (for i (name a) (block (emit (name b)))) (if (name c) "
          "(block (emit (name d))))))");
    // These are ordinary names.
    check("box { min: a, max: b file: c from: d, of: e, scale: f, to: g }",
          "(emit (kind box (field min (name a)) (field max (name b)) (field file (name c)) (field "
          "from (name d)) (field of (name e)) (field scale (name f)) (field to (name g))))");
}

static void version_of_the_header(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench, STR("/* first */ scn 1, let a = 2"), 200);
    assert_true(bench.ok);
    assert_int_equal(bench.ast.version, 1);
    assert_int_equal(bench.ast.comments.count, 1);
    end(&bench);
    begin(&bench, STR("let a = 2"), 200);
    assert_int_equal(bench.ast.version, 0);
    end(&bench);
}

static void spans(void **state)
{
    (void)state;
    const char *text = "let  v = ( a + b ) * c . d\nlet w = 1 // end\n";
    Bench bench;
    begin(&bench, str_from(text), 200);
    char *dump = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&dump, &size);
    ast_dump(&bench.ast, &bench.names, out);
    fclose(out);
    assert_string_equal(dump, "(file 0:44\n"
                              "  (let 0:26 v\n"
                              "    (binary 9:26 *\n"
                              "      (binary 11:16 +\n"
                              "        (name 11:12 a)\n"
                              "        (name 15:16 b))\n"
                              "      (member 21:26 d\n"
                              "        (name 21:22 c))))\n"
                              "  (let 27:36 w\n"
                              "    (number 35:36 1)))\n");
    free(dump);
    end(&bench);
}

static void node_is_small(void **state)
{
    (void)state;
    assert_int_equal(sizeof(AstNode), 20);
}

// --- Limits --------------------------------------------------------------------------------------

typedef struct Deep {
    const char *before, *open, *middle, *close, *after;
} Deep;

static const Deep deep[] = {
    {"let a = ", "(", "1", ")", ""},
    {"let a = ", "[", "", "]", ""},
    {"let a = ", "-", "1", "", ""},
    {"let a = ", "not ", "b", "", ""},
    {"let a = ", "2 ^ ", "2", "", ""},
    {"let a = ", "f(", "", ")", ""},
    {"let a = ", "f(x: ", "1", ")", ""},
    {"let a = ", "b[", "1", "]", ""},
    {"let a = ", "fn() = ", "1", "", ""},
    {"let a = ", "fn(x = ", "1", ") = 1", ""},
    {"let a = ", "if (b) c else ", "1", "", ""},
    {"let a = ", "if (", "b", ") c else d", ""},
    {"let a = [", "for (i in x) ", "1", "", "]"},
    {"let a = [", "if (b) ", "1", "", "]"},
    {"let a = ", "k { f: ", "1", "}", ""},
    {"let a = b", " with { f: c", "", "}", ""},
    {"", "k { ", "", "}", ""},
    {"", "if (a) {", "", "}", ""},
    {"", "if (a) {} else ", "{}", "", ""},
    {"", "for (i in x) {", "", "}", ""},
    {"", "fn f() {", "", "}", ""},
    {"let a = ", "1 or 1 and 1 == 1 .. 1 + 1 * (", "1", ")", ""},
    {"let a = ", "(1, k { let b = [for (i in x) fn(y) = f(z: ", "1", ")]})", ""},
};

static Str repeat(const Deep *shape, size_t count)
{
    size_t size = strlen(shape->before) + strlen(shape->middle) + strlen(shape->after) +
                  count * (strlen(shape->open) + strlen(shape->close));
    char *text = malloc(size + 1), *at = text;
    at = stpcpy(at, shape->before);
    for (size_t i = 0; i < count; ++i) {
        at = stpcpy(at, shape->open);
    }
    at = stpcpy(at, shape->middle);
    for (size_t i = 0; i < count; ++i) {
        at = stpcpy(at, shape->close);
    }
    stpcpy(at, shape->after);
    return (Str){text, size};
}

static unsigned depth_of(const Bench *bench)
{
    char *dump = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&dump, &size);
    ast_dump(&bench->ast, &bench->names, out);
    fclose(out);
    unsigned depth = 0, deepest = 0;
    for (const char *c = dump; *c; ++c) {
        depth += *c == '(';
        depth -= *c == ')';
        deepest = depth > deepest ? depth : deepest;
    }
    free(dump);
    return deepest;
}

static void nesting_is_limited(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof deep / sizeof *deep; ++i) {
        for (int hard = 0; hard < 2; ++hard) {
            uint32_t nesting = hard ? UINT32_MAX : 200;
            Str text = repeat(&deep[i], 100000);
            Bench bench;
            begin(&bench, text, nesting);
            assert_false(bench.ok);
            assert_int_equal(bench.sink.errors, 1); // and nothing that follows from it
            assert_int_equal(bench.sink.items[0].code, E0701);
            assert_true(depth_of(&bench) <= ast_deepest((ParseLimits){nesting}));
            end(&bench);
            free((char *)(uintptr_t)text.at);
        }
        Str text = repeat(&deep[i], 20);
        Bench bench;
        begin(&bench, text, 200);
        if (!bench.ok) {
            diag_write_text(&bench.sink, &bench.sources, stderr, DIAG_PLAIN);
            fail_msg("not accepted: %s", text.at);
        }
        end(&bench);
        free((char *)(uintptr_t)text.at);
    }
}

static void chains_are_limited(void **state)
{
    (void)state;
    static const Deep chains[] = {
        {"let a = 1", " + 1", "", "", ""},
        {"let a = 1", " or 1", "", "", ""},
        {"let a = b", ".c", "", "", ""},
        {"let a = b", "[0]", "", "", ""},
        {"let a = b", "()", "", "", ""},
        {"let a = b", " with {}", "", "", ""},
        {"b", "()", "", "", ""},
        {"let a = f(b", ".c", "", "", ")"},
        {"let a = 1", " * 2 + 1", "", "", ""},
    };
    for (size_t i = 0; i < sizeof chains / sizeof *chains; ++i) {
        Str text = repeat(&chains[i], 1000000);
        Bench bench;
        begin(&bench, text, 200);
        assert_false(bench.ok);
        assert_int_equal(bench.sink.errors, 1);
        assert_int_equal(bench.sink.items[0].code, E0701);
        assert_true(depth_of(&bench) <= ast_deepest((ParseLimits){200}));
        end(&bench);
        free((char *)(uintptr_t)text.at);
        text = repeat(&chains[i], 900);
        begin(&bench, text, 200);
        assert_true(bench.ok);
        end(&bench);
        free((char *)(uintptr_t)text.at);
    }
}

// A wide file is no deep one.
static void long_files_are_fine(void **state)
{
    (void)state;
    static const Deep shape = {"", "sphere { center: (1.5, 2, 3) radius: 0.25 material: m }\n", "",
                               "", ""};
    Str text = repeat(&shape, 20000);
    Bench bench;
    begin(&bench, text, 200);
    assert_true(bench.ok);
    assert_int_equal(ast_list_count(&bench.ast, ast_node(&bench.ast, bench.ast.root)->a), 20000);
    end(&bench);
    free((char *)(uintptr_t)text.at);
}

static void survives_every_failed_allocation(void **state)
{
    (void)state;
    Str text = STR("import \"a\" as b /* c */ let d = [for (i in 0..9) f(i, g: \"\\n\")] "
                   "fn h(x = 1) { k { l: (1, 2) m {} } if (n) { o } else { p } } q = 1");
    uint64_t before = mem_allocation_count();
    Bench bench;
    begin(&bench, text, 200);
    uint64_t needed = mem_allocation_count() - before;
    assert_int_equal(bench.sink.errors, 1);
    end(&bench);
    assert_true(needed > 8);
    for (uint64_t i = 0; i < needed; ++i) {
        mem_fail_after(i);
        begin(&bench, text, 200);
        mem_fail_after(UINT64_MAX);
        assert_false(bench.ok);
        end(&bench);
    }
}

// The caller's own jump for its arena stays in place and isn't taken.
static void leaves_the_jump_alone(void **state)
{
    (void)state;
    Bench bench = {0};
    jmp_buf jump;
    sources_init(&bench.sources, &bench.arena);
    interner_init(&bench.names, &bench.arena);
    diag_sink_init(&bench.sink, &bench.arena);
    uint32_t file = sources_add(&bench.sources, "a", NULL, STR("let a = b"), (Span){0});
    if (setjmp(jump)) {
        fail_msg("jumped");
    }
    bench.arena.on_oom = &jump;
    mem_fail_after(2);
    bool ok = parse(&bench.ast, &bench.sources, file, &bench.names, (ParseLimits){200}, false,
                    &bench.sink);
    mem_fail_after(UINT64_MAX);
    assert_false(ok);
    assert_ptr_equal(bench.arena.on_oom, &jump);
    end(&bench);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(operators),
        cmocka_unit_test(suffixes),
        cmocka_unit_test(values),
        cmocka_unit_test(comprehensions),
        cmocka_unit_test(items),
        cmocka_unit_test(tolerances),
        cmocka_unit_test(kinds),
        cmocka_unit_test(version_of_the_header),
        cmocka_unit_test(spans),
        cmocka_unit_test(node_is_small),
        cmocka_unit_test(nesting_is_limited),
        cmocka_unit_test(chains_are_limited),
        cmocka_unit_test(long_files_are_fine),
        cmocka_unit_test(survives_every_failed_allocation),
        cmocka_unit_test(leaves_the_jump_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
