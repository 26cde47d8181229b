// What a diagnostic looks like, to the byte.
#include "base/diag.h"
#include "base/mem.h"
#include "base/utf8.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

typedef struct Bench {
    Arena arena;
    Sources sources;
    DiagSink sink;
    char *shown; // of the last show()
} Bench;

static void begin(Bench *bench)
{
    *bench = (Bench){0};
    sources_init(&bench->sources, &bench->arena);
    diag_sink_init(&bench->sink, &bench->arena);
}

static void end(Bench *bench)
{
    free(bench->shown);
    diag_sink_free(&bench->sink);
    sources_free(&bench->sources);
    arena_free(&bench->arena);
}

static uint32_t add(Bench *bench, const char *text)
{
    return sources_add(&bench->sources, "shelf.scn", NULL, str_from(text), (Span){0});
}

static Span find(const Bench *bench, uint32_t file, const char *needle)
{
    Str text = source_get(&bench->sources, file)->text;
    const char *at = strstr(text.at, needle);
    assert_non_null(at);
    uint32_t first = (uint32_t)(at - text.at);
    return (Span){file, first, first + (uint32_t)strlen(needle)};
}

typedef enum Format { TEXT, COLORED, JSON } Format;

static const char *show(Bench *bench, Format format)
{
    free(bench->shown);
    size_t size = 0;
    FILE *out = open_memstream(&bench->shown, &size);
    if (format == JSON) {
        diag_write_json(&bench->sink, &bench->sources, out);
    } else {
        diag_write_text(&bench->sink, &bench->sources, out,
                        format == COLORED ? DIAG_COLORED : DIAG_PLAIN);
    }
    fclose(out);
    return bench->shown;
}

// Reports one error at `needle` of `text` and compares.
static void check(const char *text, const char *needle, const char *label, const char *expected)
{
    Bench bench;
    begin(&bench);
    uint32_t file = add(&bench, text);
    Diag *diag = diag_report(&bench.sink, E0701, find(&bench, file, needle), "wrong");
    if (label) {
        diag_label(&bench.sink, diag, "%s", label);
    }
    assert_string_equal(show(&bench, TEXT), expected);
    end(&bench);
}

static void draws_what_the_language_promises(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    uint32_t file = add(&bench, "\n\n\n\n\n\n\n  base: burley { roughnes: 0.7 } }\n");
    Span at = find(&bench, file, "roughnes");
    Diag *diag = diag_report(&bench.sink, E0701, at, "`%s` is not a field", "roughnes");
    diag_suggest(&bench.sink, diag, at, "roughness");
    diag_note(&bench.sink, diag, "burley takes %s", "color, roughness");
    diag_note(&bench.sink, diag, "two\nlines");
    assert_string_equal(show(&bench, TEXT), "error[E0701]: `roughnes` is not a field\n"
                                            "  --> shelf.scn:8:18\n"
                                            "   |\n"
                                            " 8 |   base: burley { roughnes: 0.7 } }\n"
                                            "   |                  ^^^^^^^^ did you mean "
                                            "`roughness`?\n"
                                            "   = note: burley takes color, roughness\n"
                                            "   = note: two\n"
                                            "           lines\n");
    end(&bench);
}

static void carets_stand_under_the_span(void **state)
{
    (void)state;
    check("let é = 1\n", "=", "here",
          "error[E0701]: wrong\n"
          "  --> shelf.scn:1:7\n"
          "   |\n"
          " 1 | let é = 1\n"
          "   |       ^ here\n");
    // Wide characters take two columns of a terminal but count as one column of the file.
    check("\"球体\" x \"🙂\" y", "y", NULL,
          "error[E0701]: wrong\n"
          "  --> shelf.scn:1:12\n"
          "   |\n"
          " 1 | \"球体\" x \"🙂\" y\n"
          "   |               ^\n");
    check("\"e\xcc\x81\" x", "x", NULL, // a combining accent
          "error[E0701]: wrong\n"
          "  --> shelf.scn:1:6\n"
          "   |\n"
          " 1 | \"e\xcc\x81\" x\n"
          "   |     ^\n");
    check("a\tbc\tde", "de", NULL,
          "error[E0701]: wrong\n"
          "  --> shelf.scn:1:6\n"
          "   |\n"
          " 1 | a   bc  de\n"
          "   |         ^^\n");
    check("\t\tx\r\nnext", "x", NULL,
          "error[E0701]: wrong\n"
          "  --> shelf.scn:1:3\n"
          "   |\n"
          " 1 |         x\n"
          "   |         ^\n");
}

static void hides_what_must_not_reach_a_terminal(void **state)
{
    (void)state;
    check("a \033[31m \xff \xe2\x80\xae b", "b", NULL,
          "error[E0701]: wrong\n"
          "  --> shelf.scn:1:13\n"
          "   |\n"
          " 1 | a \xef\xbf\xbd[31m \xef\xbf\xbd \xef\xbf\xbd b\n"
          "   |             ^\n");
}

static void span_over_lines_shows_first_and_last(void **state)
{
    (void)state;
    check("a sphere {  \n  x\n  y\n  } b\n", "sphere {  \n  x\n  y\n  }", "all this",
          "error[E0701]: wrong\n"
          "  --> shelf.scn:1:3\n"
          "   |\n"
          " 1 | a sphere {\n"
          "   |   ^^^^^^^^\n"
          " ...\n"
          " 4 |   } b\n"
          "   |   ^ all this\n");
    check("one\ntwo", "one\ntwo", NULL,
          "error[E0701]: wrong\n"
          "  --> shelf.scn:1:1\n"
          "   |\n"
          " 1 | one\n"
          "   | ^^^\n"
          " 2 | two\n"
          "   | ^^^\n");
    check("one\ntwo", "\n", NULL,
          "error[E0701]: wrong\n"
          "  --> shelf.scn:1:4\n"
          "   |\n"
          " 1 | one\n"
          "   |    ^\n");
}

static void end_of_file(void **state)
{
    (void)state;
    static const struct {
        const char *text, *shown;
    } cases[] = {
        {"ab", "error[E0701]: wrong\n  --> shelf.scn:1:3\n   |\n 1 | ab\n   |   ^\n"},
        {"ab\n", "error[E0701]: wrong\n  --> shelf.scn:2:1\n   |\n 2 |\n   | ^\n"},
        {"", "error[E0701]: wrong\n  --> shelf.scn:1:1\n   |\n 1 |\n   | ^\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        for (uint32_t beyond = 0; beyond < 2; ++beyond) { // spans beyond the end are cut
            Bench bench;
            begin(&bench);
            uint32_t file = add(&bench, cases[i].text);
            uint32_t length = (uint32_t)strlen(cases[i].text) + beyond * 7;
            diag_report(&bench.sink, E0701, (Span){file, length, length + beyond}, "wrong");
            assert_string_equal(show(&bench, TEXT), cases[i].shown);
            end(&bench);
        }
    }
}

static void gutter_grows_with_the_line_number(void **state)
{
    (void)state;
    char text[512] = "";
    memset(text, '\n', 119);
    strcpy(text + 119, "last");
    check(text, "last", NULL,
          "error[E0701]: wrong\n"
          "    --> shelf.scn:120:1\n"
          "     |\n"
          " 120 | last\n"
          "     | ^^^^\n");
}

static void long_line_is_cut(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    char text[2001];
    memset(text, 'a', 2000);
    text[2000] = '\0';
    memcpy(text + 1000, "XYZ", 3);
    uint32_t file = add(&bench, text);
    diag_report(&bench.sink, E0701, find(&bench, file, "XYZ"), "wrong");
    const char *shown = show(&bench, TEXT);
    const char *x = strstr(shown, "XYZ"), *caret = strstr(shown, "^^^");
    assert_non_null(x);
    assert_non_null(caret);
    assert_null(strstr(caret, "^^^^"));
    const char *line = x, *mark = caret;
    while (line[-1] != '\n') {
        --line;
    }
    while (mark[-1] != '\n') {
        --mark;
    }
    // The sign for what is cut has three bytes and one column.
    assert_int_equal(x - line - 2, caret - mark);
    assert_true(strlen(shown) < 600);
    end(&bench);
}

static void chain_of_calls_and_imports(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    uint32_t main_file = add(&bench, "import \"lib.scn\" as lib\nlib.lamp()\n");
    uint32_t library = sources_add(&bench.sources, "lib.scn", NULL, STR("fn lamp() = 1 + true"),
                                   find(&bench, main_file, "\"lib.scn\""));
    Diag *diag = diag_report(&bench.sink, E0701, find(&bench, library, "true"), "wrong");
    diag_frame(&bench.sink, diag, find(&bench, main_file, "lib.lamp()"), "in the call of `%s`",
               "lamp");
    assert_string_equal(show(&bench, TEXT), "error[E0701]: wrong\n"
                                            "  --> lib.scn:1:17\n"
                                            "   |\n"
                                            " 1 | fn lamp() = 1 + true\n"
                                            "   |                 ^^^^\n"
                                            "   = in the call of `lamp`\n"
                                            "  --> shelf.scn:2:1\n"
                                            "   = imported here\n"
                                            "  --> shelf.scn:1:8\n");
    assert_string_equal(
        show(&bench, JSON),
        "{\"code\":\"E0701\",\"severity\":\"error\",\"message\":\"wrong\",\"label\":null,"
        "\"file\":\"lib.scn\",\"line\":1,\"column\":17,\"end_line\":1,\"end_column\":21,"
        "\"begin\":16,\"end\":20,\"notes\":[],\"chain\":["
        "{\"file\":\"shelf.scn\",\"line\":2,\"column\":1,\"text\":\"in the call of `lamp`\"},"
        "{\"file\":\"shelf.scn\",\"line\":1,\"column\":8,\"text\":\"imported here\"}]}\n");
    end(&bench);
}

static void long_chain_is_cut(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    uint32_t file = add(&bench, "f()");
    Diag *diag = diag_report(&bench.sink, E0701, (Span){file, 0, 1}, "wrong");
    for (int i = 0; i < 1000; ++i) {
        diag_frame(&bench.sink, diag, (Span){file, 0, 3}, "in the call of `f%d`", i);
    }
    const char *shown = show(&bench, TEXT);
    assert_non_null(strstr(shown,
                           "`f7`\n  --> shelf.scn:1:1\n   = … 988 more …\n   = in the call of "
                           "`f996`"));
    assert_null(strstr(shown, "`f8`"));
    assert_non_null(strstr(shown, "`f999`"));
    end(&bench);
}

static void chain_of_the_sink_comes_last(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    uint32_t file = add(&bench, "f()");
    DiagFrame outer = {{file, 0, 3}, "outer", NULL};
    bench.sink.frames = &outer;
    Diag *diag = diag_report(&bench.sink, E0701, (Span){file, 0, 1}, "wrong");
    diag_frame(&bench.sink, diag, (Span){file, 0, 1}, "inner");
    assert_string_equal(diag->frames->text, "inner");
    assert_ptr_equal(diag->frames->next, &outer);
    end(&bench);
}

static void nowhere(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    Diag *diag = diag_report(&bench.sink, E0702, (Span){0}, "wrong");
    diag_label(&bench.sink, diag, "a \"label\"");
    diag_note(&bench.sink, diag, "tab\tbell\a");
    assert_string_equal(show(&bench, TEXT), "error[E0702]: wrong\n"
                                            "   = a \"label\"\n"
                                            "   = note: tab bell\xef\xbf\xbd\n");
    assert_string_equal(
        show(&bench, JSON),
        "{\"code\":\"E0702\",\"severity\":\"error\",\"message\":\"wrong\",\"label\":"
        "\"a \\\"label\\\"\",\"file\":null,\"line\":0,\"column\":0,\"end_line\":0,"
        "\"end_column\":0,\"begin\":0,\"end\":0,\"notes\":[\"tab\\u0009bell"
        "\\u0007\"],\"chain\":[]}\n");
    end(&bench);
}

static void fix_in_json(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    uint32_t file = add(&bench, "é\nfov: 40");
    Span at = find(&bench, file, "40");
    Diag *diag = diag_report(&bench.sink, E0701, at, "wrong");
    diag_label(&bench.sink, diag, "write it");
    diag_suggest(&bench.sink, diag, at, "40deg");
    assert_string_equal(diag->label, "write it");
    const char *fix = strstr(show(&bench, JSON), ",\"fix\"");
    assert_non_null(fix);
    assert_string_equal(fix,
                        ",\"fix\":{\"file\":\"shelf.scn\",\"line\":2,\"column\":6,\"end_line\":"
                        "2,\"end_column\":8,\"begin\":8,\"end\":10,\"text\":\"40deg\"}}\n");
    end(&bench);
}

static void colors(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    uint32_t file = add(&bench, "x");
    diag_report(&bench.sink, E0701, (Span){file, 0, 1}, "wrong");
    assert_string_equal(show(&bench, COLORED),
                        "\033[1;31merror[E0701]\033[0m\033[1m: wrong\033[0m\n"
                        "  \033[1;34m-->\033[0m shelf.scn:1:1\n"
                        "\033[1;34m   |\033[0m\n"
                        "\033[1;34m 1 |\033[0m x\n"
                        "\033[1;34m   |\033[0m \033[1;31m^\033[0m\n");
    end(&bench);
}

static void sorted_and_without_doubles(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    uint32_t file = add(&bench, "0123456789");
    for (uint32_t round = 0; round < 2; ++round) {
        for (uint32_t i = 0; i < 10; ++i) {
            uint32_t at = i * 7 % 10;
            Diag *diag = diag_report(&bench.sink, E0701, (Span){file, at, at + 1}, "no %u.", at);
            diag_note(&bench.sink, diag, "round %u", round);
        }
    }
    assert_int_equal(bench.sink.count, 10);
    assert_int_equal(bench.sink.errors, 10);
    const char *shown = show(&bench, TEXT);
    assert_null(strstr(shown, "round 1"));
    for (int i = 0; i < 10; ++i) {
        char needle[16];
        snprintf(needle, sizeof needle, "no %d.", i);
        shown = strstr(shown, needle);
        assert_non_null(shown);
    }
    end(&bench);
}

static void limit(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    bench.sink.limit = 2;
    uint32_t file = add(&bench, "0123456789");
    for (uint32_t i = 0; i < 10; ++i) {
        Diag *diag = diag_report(&bench.sink, E0701, (Span){file, i, i + 1}, "wrong");
        assert_non_null(diag);
        diag_note(&bench.sink, diag, "note");
        diag_suggest(&bench.sink, diag, (Span){file, i, i + 1}, "x");
        diag_frame(&bench.sink, diag, (Span){file, i, i + 1}, "x");
    }
    assert_int_equal(bench.sink.count, 2);
    assert_int_equal(bench.sink.dropped, 8);
    assert_int_equal(bench.sink.errors, 10);
    assert_non_null(strstr(show(&bench, TEXT), "\n8 more diagnostics are not shown\n"));
    end(&bench);
}

// Errors are what must be seen: beyond the limit they take the places of warnings.
static void errors_before_warnings(void **state)
{
    (void)state;
    Bench bench;
    begin(&bench);
    bench.sink.limit = 3;
    uint32_t file = add(&bench, "0123456789");
    for (uint32_t i = 0; i < 5; ++i) {
        diag_report(&bench.sink, W0301, (Span){file, i, i + 1}, "unused");
    }
    for (uint32_t i = 5; i < 9; ++i) {
        Diag *diag = diag_report(&bench.sink, E0701, (Span){file, i, i + 1}, "wrong");
        assert_int_equal(diag_is_kept(&bench.sink, diag), i < 8);
    }
    diag_report(&bench.sink, E0701, (Span){file, 5, 6}, "wrong"); // was reported
    diag_report(&bench.sink, W0301, (Span){file, 9, 10}, "unused");
    assert_int_equal(bench.sink.count, 3);
    assert_int_equal(bench.sink.errors, 4);
    assert_int_equal(bench.sink.warnings, 6);
    assert_int_equal(bench.sink.dropped, 7);
    for (uint32_t i = 0; i < 3; ++i) {
        assert_int_equal(bench.sink.items[i].severity, SEVERITY_ERROR);
    }
    end(&bench);
}

// Reports a good deal; used with every allocation failing in turn.
static bool report_much(void)
{
    Bench bench;
    begin(&bench);
    jmp_buf jump;
    bench.arena.on_oom = &jump; // must not be taken
    uint32_t file = 0;
    if (setjmp(jump) == 0) {
        bench.arena.on_oom = NULL;
        file = add(&bench, "one\ntwo\nthree");
        bench.arena.on_oom = &jump;
        for (uint32_t i = 0; i < 40; ++i) {
            Diag *diag = diag_report(&bench.sink, E0701, (Span){file, i % 13, i}, "%*u", 300, i);
            diag_note(&bench.sink, diag, "note");
            diag_suggest(&bench.sink, diag, (Span){file, 0, 1}, "x");
            diag_frame(&bench.sink, diag, (Span){file, 0, 1}, "x");
        }
        assert_int_equal(bench.sink.errors, 40);
        FILE *out = fopen("/dev/null", "w");
        diag_write_text(&bench.sink, &bench.sources, out, DIAG_PLAIN);
        diag_write_json(&bench.sink, &bench.sources, out);
        fclose(out);
    } else {
        fail_msg("a diagnostic took the arena's jump");
    }
    bool whole = !bench.sink.out_of_memory && file;
    end(&bench);
    return whole;
}

static void survives_every_failed_allocation(void **state)
{
    (void)state;
    uint64_t before = mem_allocation_count();
    assert_true(report_much());
    uint64_t needed = mem_allocation_count() - before;
    for (uint64_t i = 0; i < needed; ++i) {
        mem_fail_after(i);
        report_much();
        mem_fail_after(UINT64_MAX);
    }
    assert_true(needed > 10);
}

static void codes(void **state)
{
    (void)state;
    assert_int_equal(diag_find(STR("e0001")), E0001);
    assert_int_equal(diag_find(STR("E0701")), E0701);
    assert_int_equal(diag_find(STR("E070")), DIAG_CODE_COUNT);
    assert_int_equal(diag_find(STR("E07011")), DIAG_CODE_COUNT);
    assert_int_equal(diag_find(STR("")), DIAG_CODE_COUNT);
    for (int code = 0; code < DIAG_CODE_COUNT; ++code) {
        const DiagInfo *info = diag_info((DiagCode)code);
        assert_true(info->title[0] && strlen(info->paragraph) > 20);
        char letter = info->severity == SEVERITY_ERROR     ? 'E'
                      : info->severity == SEVERITY_WARNING ? 'W'
                                                           : 'N';
        assert_int_equal(info->name[0], letter);
        assert_int_equal(strlen(info->name), 5);
        if (code > 0) {
            assert_true(strcmp(diag_info((DiagCode)(code - 1))->name, info->name) < 0);
        }
    }
}

static void utf8(void **state)
{
    (void)state;
    static const uint32_t good[] = {0,      0x7f,   0x80,   0x7ff,   0x800,
                                    0xd7ff, 0xe000, 0xffff, 0x10000, 0x10ffff};
    for (size_t i = 0; i < sizeof good / sizeof *good; ++i) {
        char bytes[4];
        uint32_t code;
        int length = utf8_encode(good[i], bytes);
        assert_int_equal(utf8_decode(bytes, bytes + length, &code), length);
        assert_int_equal(code, good[i]);
        if (length > 1) {
            assert_int_equal(utf8_decode(bytes, bytes + length - 1, &code), 1);
            assert_int_equal(code, UTF8_INVALID);
        }
    }
    static const char *const bad[] = {"\x80",         "\xc0\x80",         "\xc1\xbf",
                                      "\xe0\x9f\xbf", "\xed\xa0\x80",     "\xf0\x8f\xbf\xbf",
                                      "\xff",         "\xf4\x90\x80\x80", "\xe2\x28\xa1"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        uint32_t code;
        assert_int_equal(utf8_decode(bad[i], bad[i] + strlen(bad[i]), &code), 1);
        assert_int_equal(code, UTF8_INVALID);
    }
    assert_int_equal(utf8_width('a'), 1);
    assert_int_equal(utf8_width(0x7403), 2);
    assert_int_equal(utf8_width(0x301), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(draws_what_the_language_promises),
        cmocka_unit_test(carets_stand_under_the_span),
        cmocka_unit_test(hides_what_must_not_reach_a_terminal),
        cmocka_unit_test(span_over_lines_shows_first_and_last),
        cmocka_unit_test(end_of_file),
        cmocka_unit_test(gutter_grows_with_the_line_number),
        cmocka_unit_test(long_line_is_cut),
        cmocka_unit_test(chain_of_calls_and_imports),
        cmocka_unit_test(long_chain_is_cut),
        cmocka_unit_test(chain_of_the_sink_comes_last),
        cmocka_unit_test(nowhere),
        cmocka_unit_test(fix_in_json),
        cmocka_unit_test(colors),
        cmocka_unit_test(sorted_and_without_doubles),
        cmocka_unit_test(limit),
        cmocka_unit_test(errors_before_warnings),
        cmocka_unit_test(survives_every_failed_allocation),
        cmocka_unit_test(codes),
        cmocka_unit_test(utf8),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
