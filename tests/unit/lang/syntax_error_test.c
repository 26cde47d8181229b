// Mistakes and the exact text that a user sees for each.
#include "lang/ast.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

typedef struct Case {
    const char *name, *text;
    size_t length;
    const char *expected;
} Case;

static const Case cases[] = {
#define CASE(name, text, length, expected) {#name, text, length, expected},
#include "syntax_errors.def"
#undef CASE
};

enum { CASE_COUNT = sizeof cases / sizeof *cases };

static void check_case(void **state)
{
    const Case *test = *state;
    Arena arena = {0};
    Sources sources;
    Interner names;
    DiagSink sink;
    sources_init(&sources, &arena);
    interner_init(&names, &arena);
    diag_sink_init(&sink, &arena);
    // A copy of just this size, so that the sanitizer sees a read beyond the end.
    char *text = malloc(test->length);
    memcpy(text, test->text, test->length);
    uint32_t file = sources_add(&sources, "test.scn", NULL, (Str){text, test->length}, (Span){0});
    Ast ast;
    assert_false(parse(&ast, &sources, file, &names, (ParseLimits){200}, false, &sink));
    char *shown = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&shown, &size);
    diag_write_text(&sink, &sources, out, DIAG_PLAIN);
    fclose(out);
    assert_string_equal(shown, test->expected);
    free(shown);
    free(text);
    ast_free(&ast);
    diag_sink_free(&sink);
    interner_free(&names);
    sources_free(&sources);
    arena_free(&arena);
}

// What `explain` shows for a lexical or syntax error is an example of just that error.
static void examples_of_explain(void **state)
{
    (void)state;
    for (DiagCode code = E0101; code < DIAG_CODE_COUNT && diag_info(code)->name[2] <= '2'; ++code) {
        const char *example = diag_info(code)->example;
        if (!*example) {
            continue;
        }
        Arena arena = {0};
        Sources sources;
        Interner names;
        DiagSink sink;
        sources_init(&sources, &arena);
        interner_init(&names, &arena);
        diag_sink_init(&sink, &arena);
        uint32_t file = sources_add(&sources, "test.scn", NULL, str_from(example), (Span){0});
        Ast ast;
        parse(&ast, &sources, file, &names, (ParseLimits){200}, false, &sink);
        bool found = false, other = false;
        for (uint32_t i = 0; i < sink.count; ++i) {
            found = found || sink.items[i].code == code;
            other = other || sink.items[i].code != code;
        }
        if (!found || other) {
            diag_write_text(&sink, &sources, stderr, DIAG_PLAIN);
            fail_msg("%s: its example does not show it, or shows more", diag_info(code)->name);
        }
        ast_free(&ast);
        diag_sink_free(&sink);
        interner_free(&names);
        sources_free(&sources);
        arena_free(&arena);
    }
}

int main(void)
{
    struct CMUnitTest tests[CASE_COUNT + 1];
    for (size_t i = 0; i < CASE_COUNT; ++i) {
        tests[i] = (struct CMUnitTest){cases[i].name, check_case, NULL, NULL,
                                       (void *)(uintptr_t)&cases[i]};
    }
    tests[CASE_COUNT] = (struct CMUnitTest)cmocka_unit_test(examples_of_explain);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
