#include "lang/lexer.h"

#include "base/mem.h"
#include "schema/schema.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

typedef struct Bench {
    Arena arena;
    Sources sources;
    Interner names;
    DiagSink sink;
    uint32_t file;
    char *text; // a copy of just the right size
} Bench;

static void begin(Bench *bench, Str text)
{
    *bench = (Bench){0};
    sources_init(&bench->sources, &bench->arena);
    interner_init(&bench->names, &bench->arena);
    diag_sink_init(&bench->sink, &bench->arena);
    bench->text = malloc(text.length + !text.length);
    memcpy(bench->text, text.at, text.length);
    bench->file =
        sources_add(&bench->sources, "test.scn", NULL, (Str){bench->text, text.length}, (Span){0});
}

static void end(Bench *bench)
{
    diag_sink_free(&bench->sink);
    interner_free(&bench->names);
    sources_free(&bench->sources);
    arena_free(&bench->arena);
    free(bench->text);
}

// Compares the dump of `text`, which must have no errors.
static void check(Str text, const char *expected)
{
    Bench bench;
    begin(&bench, text);
    char *dump = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&dump, &size);
    assert_true(lexer_dump(&bench.sources, bench.file, &bench.names, &bench.sink, out));
    fclose(out);
    assert_string_equal(dump, expected);
    free(dump);
    end(&bench);
}

static void marks_and_names(void **state)
{
    (void)state;
    check(STR(""), "0:0 end\n");
    check(STR("a{}()[]:,.+-*/%^"),
          "0:1 name a\n1:2 {\n2:3 }\n3:4 (\n4:5 )\n5:6 [\n6:7 ]\n7:8 :\n8:9 "
          ",\n9:10 .\n10:11 +\n11:12 -\n12:13 *\n13:14 /\n14:15 %\n15:16 "
          "^\n16:16 end\n");
    check(STR("= == != < <= > >= .. ..<"),
          "0:1 =\n2:4 ==\n5:7 !=\n8:9 <\n10:12 <=\n13:14 >\n15:17 >=\n18:20 ..\n21:24 ..<\n24:24 "
          "end\n");
    check(STR("for fort _for FOR"),
          "0:3 for\n4:8 name fort\n9:13 name _for\n14:17 name FOR\n17:17 end\n");
    check(STR("\xef\xbb\xbf"
              "a"),
          "3:4 name a\n4:4 end\n");
}

static void numbers(void **state)
{
    (void)state;
    check(STR("1 2.5 1e-3 1_000_000 007"),
          "0:1 number 1\n2:5 number 2.5\n6:10 number 0.001\n11:20 number 1000000\n21:24 number "
          "7\n24:24 end\n");
    check(STR("0..5 1..<2 1.5..2"),
          "0:1 number 0\n1:3 ..\n3:4 number 5\n5:6 number 1\n6:9 ..<\n9:10 "
          "number 2\n11:14 number 1.5\n14:16 ..\n16:17 number 2\n17:17 "
          "end\n");
    check(STR("40deg 5W 1e3kW 2.5m"),
          "0:5 number 40 deg\n6:8 number 5 W\n9:14 number 1000 kW\n15:19 "
          "number 2.5 m\n19:19 end\n");
    check(STR("0.1 12345678901234567890 1.7976931348623157e308"),
          "0:3 number 0.10000000000000001\n4:24 number 1.2345678901234567e+19\n25:47 number "
          "1.7976931348623157e+308\n47:47 end\n");
    check(STR("3.x"), "0:1 number 3\n1:2 .\n2:3 name x\n3:3 end\n");
}

static void every_unit(void **state)
{
    (void)state;
    for (size_t i = 0; i < schema_unit_count; ++i) {
        char text[32];
        snprintf(text, sizeof text, "1%s", schema_units[i].name);
        Bench bench;
        begin(&bench, str_from(text));
        jmp_buf jump;
        Lexer lexer;
        Token token;
        lexer_init(&lexer, source_get(&bench.sources, bench.file), bench.file, &bench.names,
                   &bench.sink, NULL, &jump);
        lexer_next(&lexer, &token);
        assert_int_equal(token.kind, TOKEN_NUMBER);
        assert_int_equal(token.unit, i + 1);
        assert_int_equal(bench.sink.errors, 0);
        lexer_free(&lexer);
        end(&bench);
    }
}

static void strings_and_colors(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench, STR("\"\" \"a\\n\\t\\\"\\\\\\u{e9}\\u{1F600}b\" #fff #C0392b #1a2"));
    jmp_buf jump;
    Lexer lexer;
    Token token;
    lexer_init(&lexer, source_get(&bench.sources, bench.file), bench.file, &bench.names,
               &bench.sink, NULL, &jump);
    lexer_next(&lexer, &token);
    assert_int_equal(token.kind, TOKEN_STRING);
    assert_string_equal(symbol_name(&bench.names, token.symbol).at, "");
    lexer_next(&lexer, &token);
    assert_string_equal(symbol_name(&bench.names, token.symbol).at,
                        "a\n\t\"\\\xc3\xa9\xf0\x9f\x98\x80"
                        "b");
    lexer_next(&lexer, &token);
    assert_int_equal(token.kind, TOKEN_COLOR);
    assert_int_equal(token.color, 0xffffff);
    lexer_next(&lexer, &token);
    assert_int_equal(token.color, 0xc0392b);
    lexer_next(&lexer, &token);
    assert_int_equal(token.color, 0x11aa22);
    assert_int_equal(bench.sink.errors, 0);
    lexer_free(&lexer);
    end(&bench);
}

static void comments(void **state)
{
    (void)state;
    check(STR("a // b\nc/*d/*e*/f*/g//"), "0:1 name a\n7:8 name c\n19:20 name g\n22:22 end\n");
    check(STR("a/**/b/***/c"), "0:1 name a\n5:6 name b\n11:12 name c\n12:12 end\n");
    check(STR("a /"), "0:1 name a\n2:3 /\n3:3 end\n");
    Bench bench;
    begin(&bench, STR("a // one\r\nb /* two\n */ c"));
    jmp_buf jump;
    Lexer lexer;
    AstCommentArray kept = {0};
    lexer_init(&lexer, source_get(&bench.sources, bench.file), bench.file, &bench.names,
               &bench.sink, &kept, &jump);
    Token token;
    bool on_new_line[4];
    for (int i = 0; i < 4; ++i) {
        lexer_next(&lexer, &token);
        on_new_line[i] = token.on_new_line;
    }
    assert_true(on_new_line[0] && on_new_line[1] && on_new_line[2] && !on_new_line[3]);
    assert_int_equal(kept.count, 2);
    assert_int_equal(kept.items[0].begin, 2);
    assert_int_equal(kept.items[0].end, 8); // without the line's end
    assert_int_equal(kept.items[1].begin, 12);
    assert_int_equal(kept.items[1].end, 22);
    array_free(&kept);
    lexer_free(&lexer);
    end(&bench);
}

static void peeking(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        char next;
    } cases[] = {{"a:", ':'},    {"a // b\n /* : */ {", '{'},
                 {"a", '\0'},    {"a /* b", '\0'},
                 {"a / b", '/'}, {"a // b", '\0'}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        Bench bench;
        begin(&bench, str_from(cases[i].text));
        jmp_buf jump;
        Lexer lexer;
        Token token;
        lexer_init(&lexer, source_get(&bench.sources, bench.file), bench.file, &bench.names,
                   &bench.sink, NULL, &jump);
        lexer_next(&lexer, &token);
        assert_int_equal(lexer_peek(&lexer), cases[i].next);
        lexer_free(&lexer);
        end(&bench);
    }
}

// Names of every length around the sizes that are handled apart, many times over.
static void names_of_all_lengths(void **state)
{
    (void)state;
    char text[4096];
    size_t length = 0;
    for (size_t round = 0; round < 2; ++round) {
        for (size_t size = 1; size <= 40; ++size) {
            memset(text + length, 'x', size);
            text[length] = (char)('a' + size % 26);
            length += size;
            text[length++] = '\n';
        }
    }
    Bench bench;
    begin(&bench, (Str){text, length - 1});
    jmp_buf jump;
    Lexer lexer;
    Token token;
    lexer_init(&lexer, source_get(&bench.sources, bench.file), bench.file, &bench.names,
               &bench.sink, NULL, &jump);
    for (uint32_t round = 0; round < 2; ++round) {
        for (uint32_t size = 1; size <= 40; ++size) {
            lexer_next(&lexer, &token);
            assert_int_equal(token.kind, TOKEN_NAME);
            assert_int_equal(token.end - token.begin, size);
            assert_int_equal(token.symbol, size); // in the order of first appearance
            Str name = symbol_name(&bench.names, token.symbol);
            assert_int_equal(name.length, size);
            assert_memory_equal(name.at, bench.text + token.begin, size);
        }
    }
    lexer_next(&lexer, &token);
    assert_int_equal(token.kind, TOKEN_END);
    lexer_free(&lexer);
    end(&bench);
}

// A text is looked through many bytes at once for what isn't plain: a bad byte is found wherever it
// stands.
static void bad_bytes_anywhere(void **state)
{
    (void)state;
    enum { LENGTH = 400 };
    static const struct {
        char byte;
        DiagCode code;
    } bad[] = {{'\0', E0102}, {'\xff', E0101}, {'\x80', E0101}, {'\x7f', DIAG_CODE_COUNT}};
    for (size_t kind = 0; kind < sizeof bad / sizeof *bad; ++kind) {
        for (size_t at = 0; at < LENGTH; ++at) {
            char text[LENGTH];
            memset(text, 'a', sizeof text);
            text[at] = bad[kind].byte;
            Bench bench;
            begin(&bench, (Str){text, sizeof text});
            jmp_buf jump;
            Lexer lexer;
            lexer_init(&lexer, source_get(&bench.sources, bench.file), bench.file, &bench.names,
                       &bench.sink, NULL, &jump);
            const bool found = bench.sink.count == 1 && bench.sink.items[0].code == bad[kind].code;
            assert_int_equal(found, bad[kind].code != DIAG_CODE_COUNT);
            lexer_free(&lexer);
            end(&bench);
        }
    }
}

static void dump_without_memory(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 20; ++i) {
        Bench bench;
        begin(&bench, STR("let a = \"x\\n\" + some_name_of_some_length"));
        FILE *out = fopen("/dev/null", "w");
        mem_fail_after(i);
        bool ok = lexer_dump(&bench.sources, bench.file, &bench.names, &bench.sink, out);
        mem_fail_after(UINT64_MAX);
        assert_true(ok == (bench.sink.errors == 0));
        assert_true(ok || bench.sink.out_of_memory || bench.sink.items[0].code == E0001);
        fclose(out);
        end(&bench);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(marks_and_names),
        cmocka_unit_test(numbers),
        cmocka_unit_test(every_unit),
        cmocka_unit_test(bad_bytes_anywhere),
        cmocka_unit_test(strings_and_colors),
        cmocka_unit_test(comments),
        cmocka_unit_test(peeking),
        cmocka_unit_test(names_of_all_lengths),
        cmocka_unit_test(dump_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
