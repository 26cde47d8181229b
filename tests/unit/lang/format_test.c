#include "base/mem.h"
#include "lang/format.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

typedef struct Bench {
    Arena arena;
    Sources sources;
    Interner names;
    DiagSink sink;
    FormatText out;
    uint32_t file;
    bool ok;
} Bench;

static void begin(Bench *bench, const char *text)
{
    *bench = (Bench){0};
    sources_init(&bench->sources, &bench->arena);
    interner_init(&bench->names, &bench->arena);
    diag_sink_init(&bench->sink, &bench->arena);
    bench->file = sources_add(&bench->sources, "test.scn", NULL, str_from(text), (Span){0});
    bench->ok = bench->file && format_source(&bench->out, &bench->sources, bench->file,
                                             &bench->names, (ParseLimits){200}, &bench->sink);
}

static void end(Bench *bench)
{
    array_free(&bench->out);
    diag_sink_free(&bench->sink);
    interner_free(&bench->names);
    sources_free(&bench->sources);
    arena_free(&bench->arena);
}

static void check(const char *from, const char *to)
{
    Bench bench;
    begin(&bench, from);
    assert_true(bench.ok);
    assert_true(array_push(&bench.out, '\0'));
    assert_string_equal(bench.out.items, to);
    end(&bench);
}

// What is formatted stays, and each of `from` becomes `to`.
static void expect(const char *from, const char *to)
{
    check(from, to);
    check(to, to);
}

static void test_spaces(void **state)
{
    (void)state;
    expect("", "");
    expect(" \n\n", "");
    expect("sphere{radius:1}", "sphere { radius: 1 }\n");
    expect("sphere\n{\n}", "sphere {}\n");
    expect("let a=1+2*-b^-2", "let a = 1 + 2 * -b ^ -2\n");
    expect("let a = ( 1 ,-2,  - 3 )", "let a = (1, -2, -3)\n");
    expect("let a = x [ 1 ] . y ( 2, z : 3 )", "let a = x[1].y(2, z: 3)\n");
    expect("let a=not b and(c or d)==(e)", "let a = not b and (c or d) == (e)\n");
    expect("let a=if(b)-1 else(2,3)", "let a = if (b) -1 else (2, 3)\n");
    expect("fn f ( a , b=2 ) =fn (x)=x", "fn f(a, b = 2) = fn(x) = x\n");
    expect("param n:int=3 in 1 .. 9\"Text\"", "param n: int = 3 in 1..9 \"Text\"\n");
    expect("import\"a.scn\"as a", "import \"a.scn\" as a\n");
    expect("let a=b with{c:d}", "let a = b with { c: d }\n");
    expect("scn 1 sphere{}", "scn 1, sphere {}\n");
    expect("let a=[for(i in 0 ..< n)if(i>1)i]", "let a = [for (i in 0..<n) if (i > 1) i]\n");
}

static void test_ranges(void **state)
{
    (void)state;
    expect("let a = 0 .. -n", "let a = 0..-n\n");
    expect("let a = 0..<n-1", "let a = 0 ..< n - 1\n");
    expect("let a = (n+1)..f(n-1)", "let a = (n + 1)..f(n - 1)\n");
    expect("let a = 2*n..9", "let a = 2 * n .. 9\n");
    expect("let a = 1/*c*/.x", "let a = 1 /*c*/ .x\n");
}

static void test_expectations(void **state)
{
    (void)state;
    expect("expect  a==b", "expect a == b\n");
    expect("expect a within 0.1+b of -c", "expect a within 0.1 + b of -c\n");
    expect("expect a within 1 % of(b,c)", "expect a within 1% of (b, c)\n");
    expect("expect a within b%c % of of%d", "expect a within b % c% of of % d\n");
    expect("group{expect a within 1 of b sphere{}}",
           "group { expect a within 1 of b, sphere {} }\n");
    expect("sphere{} expect a\nwithin 1%\nof b\nsphere{}",
           "sphere {}, expect a\n  within 1%\n  of b\nsphere {}\n");
    expect("expect a..b within 1+c of d", "expect a..b within 1 + c of d\n");
    expect("instance{of:a%of,transform:t}", "instance { of: a % of, transform: t }\n");
}

static void test_commas(void **state)
{
    (void)state;
    expect("sphere{center:a radius:1,}", "sphere { center: a, radius: 1 }\n");
    expect("sphere {\n  center: a,\n  radius: 1,\n}", "sphere {\n  center: a\n  radius: 1\n}\n");
    expect("f(1,2,)", "f(1, 2)\n");
    expect("let a = [\n1,\n2,\n]", "let a = [\n  1,\n  2\n]\n");
    expect("a, b\nc", "a, b\nc\n");
    expect("light {\n  shape: s\n  power: p color: c\n}",
           "light {\n  shape: s\n  power: p, color: c\n}\n");
}

static void test_line_ends(void **state)
{
    (void)state;
    expect("sphere { center: a\n radius: 1 }", "sphere {\n  center: a\n  radius: 1\n}\n");
    expect("quad(a,\n     b)", "quad(\n  a,\n  b\n)\n");
    expect("for (i in xs)\n{ f(i) }", "for (i in xs) { f(i) }\n");
    expect("if (a) {\n b } \n else {\n c }", "if (a) {\n  b\n} else {\n  c\n}\n");
    expect("let a = if (b) c\nelse d", "let a = if (b) c\n  else d\n");
    expect("let a =\nb +\nc\n- d", "let a =\n  b +\n  c\n  - d\n");
    expect("let\na = b\n.c", "let a = b.c\n");
    expect("let a = map(xs, fn(x) {\nball { at: x } })",
           "let a = map(xs, fn(x) {\n  ball { at: x }\n})\n");
    expect("a { b: c { d: 1\n}, e: 2 }", "a {\n  b: c {\n    d: 1\n  }\n  e: 2\n}\n");
    expect("\n\na\n\n\n\nb\n{\n\n}\n\n", "a\n\nb {}\n");
    expect("group {\n\n  a\n\n\n  b\n\n}", "group {\n  a\n\n  b\n}\n");
    expect("a\r\nb // c\r\n", "a\nb // c\n");
}

static void test_long_lines(void **state)
{
    (void)state;
    expect(
        "area_light { shape: disc { center: (1, 3.4, 1.5), normal: (-0.2, -1, -0.5), radius: 0.7 "
        "}, power: 2500lm }",
        "area_light {\n  shape: disc { center: (1, 3.4, 1.5), normal: (-0.2, -1, -0.5), radius: "
        "0.7 }\n  power: 2500lm\n}\n");
    expect("let numbers = [1000000001, 1000000002, 1000000003, 1000000004, 1000000005, 1000000006, "
           "1000000007, 1000000008, 1000000009]",
           "let numbers = [\n  1000000001, 1000000002, 1000000003, 1000000004, 1000000005, "
           "1000000006, 1000000007, 1000000008,\n  1000000009\n]\n");
    expect("a {\n  b: \"0123456789012345678901234567890123456789\", c: "
           "\"01234567890123456789012345678901234567890123456789\"\n}",
           "a {\n  b: \"0123456789012345678901234567890123456789\"\n  c: "
           "\"01234567890123456789012345678901234567890123456789\"\n}\n");
    // A comment on the line of what can't be broken.
    expect("a\n/* c */ print(\"01234567890123456789012345678901234567890123456789012345678901234567"
           "890123456789012345678901234567890123456789\")",
           "a\n/* c */ print(\"01234567890123456789012345678901234567890123456789012345678901234567"
           "890123456789012345678901234567890123456789\")\n");
    // A comment at the end doesn't count, and what can't be broken stays.
    expect(
        "a { b: 1 } // 01234567890123456789012345678901234567890123456789012345678901234567890123"
        "4567890123456789",
        "a { b: 1 } // 01234567890123456789012345678901234567890123456789012345678901234567890123"
        "4567890123456789\n");
    expect("print(\"0123456789012345678901234567890123456789012345678901234567890123456789012345678"
           "9012345678901234567890123456789\")",
           "print(\"0123456789012345678901234567890123456789012345678901234567890123456789012345678"
           "9012345678901234567890123456789\")\n");
}

static void test_comments(void **state)
{
    (void)state;
    expect("//only  ", "//only\n");
    expect("a   // one\n// two\n\n\n// three\nb", "a // one\n// two\n\n// three\nb\n");
    expect("sphere { radius: 1, // r\n center: c }",
           "sphere {\n  radius: 1 // r\n  center: c\n}\n");
    expect("f(a, // one\nb)", "f(\n  a, // one\n  b\n)\n");
    expect("f(a // one\n, b)", "f(\n  a, // one\n  b\n)\n");
    expect("group { // all\na }", "group { // all\n  a\n}\n");
    expect("group {\na\n// last\n}", "group {\n  a\n  // last\n}\n");
    expect("group { /* nothing */ }", "group { /* nothing */ }\n");
    expect("group {\n// nothing\n}", "group {\n  // nothing\n}\n");
    expect("f(/*a*/1,/*b*/2/*c*/)", "f(/*a*/ 1, /*b*/ 2 /*c*/)\n");
    expect("let a = /* x /* y */\n   z */ 1", "let a = /* x /* y */\n   z */ 1\n");
    expect("let a = 1 + // one\n2", "let a = 1 + // one\n  2\n");
    expect("let a = - /*c*/ b", "let a = - /*c*/ b\n");
}

#define COLUMNS_53 "i53_5678901234567890123456789012345678901234567890123"
#define COLUMNS_530                                                                                \
    COLUMNS_53 COLUMNS_53 COLUMNS_53 COLUMNS_53 COLUMNS_53 COLUMNS_53 COLUMNS_53 COLUMNS_53        \
        COLUMNS_53 COLUMNS_53

static void test_columns(void **state)
{
    (void)state;
    expect("film   { a: 1 }\ncamera { b: 2 }", "film   { a: 1 }\ncamera { b: 2 }\n");
    expect("film     {a:1}\ncamera   {b:2}", "film   { a: 1 }\ncamera { b: 2 }\n");
    expect("let white = a\nlet red   = b", "let white = a\nlet red   = b\n");
    expect("let white = a\n\nlet red   = b", "let white = a\n\nlet red = b\n");
    expect("s {\n  center:   a\n  radius:   1\n  material: m\n}",
           "s {\n  center:   a\n  radius:   1\n  material: m\n}\n");
    expect("a      // one\nbcd    // two", "a   // one\nbcd // two\n");
    expect("a      // one\nlonger.name\n", "a // one\nlonger.name\n");
    expect("a(1,  2)\na(10, 3)", "a(1,  2)\na(10, 3)\n");
    // Beyond column 512, too.
    expect(COLUMNS_530 "  // one\nlet b = 1\na" COLUMNS_530 " // two",
           COLUMNS_530 "  // one\nlet b = 1\na" COLUMNS_530 " // two\n");
    // A byte order mark takes no column.
    expect("\xef\xbb\xbfhe  // one\nshe // two", "\xef\xbb\xbfhe  // one\nshe // two\n");
    expect("\xef\xbb\xbfhe // one\nshe  // two", "\xef\xbb\xbfhe // one\nshe // two\n");
    expect("e(\"ü\")   // one\nabcdef   // two", "e(\"ü\") // one\nabcdef // two\n");
}

static void test_errors(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench, "sphere { radius: }");
    assert_false(bench.ok);
    assert_int_equal(bench.sink.errors, 1);
    assert_int_equal(bench.sink.items[0].code, E0201);
    end(&bench);
}

static void test_out_of_memory(void **state)
{
    (void)state;
    bool done = false;
    for (uint64_t i = 0; i < 500 && !done; ++i) {
        Bench bench;
        mem_fail_after(i);
        begin(&bench, "// c\nlet a   = [1, 2] // d\nlet bcd = f(a, k {x: 1}) /* e */");
        mem_fail_after(UINT64_MAX);
        done = bench.ok;
        assert_true(bench.ok || bench.sink.errors > 0 || bench.sink.out_of_memory || !bench.file);
        end(&bench);
    }
    assert_true(done);
}

static Ast parsed(Bench *bench, const char *text)
{
    uint32_t file = sources_add(&bench->sources, "test.scn", NULL, str_from(text), (Span){0});
    Ast ast;
    assert_true(
        parse(&ast, &bench->sources, file, &bench->names, (ParseLimits){200}, false, &bench->sink));
    return ast;
}

static void test_equal_trees(void **state)
{
    (void)state;
    static const struct {
        const char *a, *b;
        bool equal;
    } pairs[] = {
        {"let a = 1", "let  a=1 // same", true},
        {"let a = 1", "let b = 1", false},
        {"let a = 1", "let a = 2", false},
        {"let a = 1m", "let a = 1cm", false},
        {"let a = -(1)", "let a = -1", true},
        {"let a = b - c", "let a = b + c", false},
        {"let a = b - (c - d)", "let a = b - c - d", false},
        {"s { a: 1, b: 2 }", "s { a: 1\n b: 2, }", true},
        {"s { a: 1, b: 2 }", "s { b: 2, a: 1 }", false},
        {"f(a, b)", "f(a, b, c)", false},
        {"fn f(a) = a", "fn f(a, b) = a", false},
        {"scn 1 let a = 1", "let a = 1", false},
        {"param a: int = 1", "param a: number = 1", false},
        {"param a: int = 1 in 0..2", "param a: int = 1", false},
        {"let a = 0..1", "let a = 0..<1", false},
        {"let a = \"x\"", "let a = \"\\u{78}\"", true},
        {"if (a) { b } else { c }", "if (a) { b }", false},
        {"import \"a\" as b", "import \"a\" as c", false},
        {"for (i in a) { i }", "for (i in b) { i }", false},
    };
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; ++i) {
        Bench bench;
        begin(&bench, "");
        Ast a = parsed(&bench, pairs[i].a), b = parsed(&bench, pairs[i].b);
        if (ast_equal(&a, &b) != pairs[i].equal || ast_equal(&b, &a) != pairs[i].equal) {
            fail_msg("`%s` and `%s`", pairs[i].a, pairs[i].b);
        }
        ast_free(&a);
        ast_free(&b);
        end(&bench);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_spaces),       cmocka_unit_test(test_ranges),
        cmocka_unit_test(test_expectations), cmocka_unit_test(test_commas),
        cmocka_unit_test(test_line_ends),    cmocka_unit_test(test_long_lines),
        cmocka_unit_test(test_comments),     cmocka_unit_test(test_columns),
        cmocka_unit_test(test_errors),       cmocka_unit_test(test_out_of_memory),
        cmocka_unit_test(test_equal_trees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
