#include "base/mem.h"
#include "base/source.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

static void check_place(Sources *sources, uint32_t file, uint32_t offset, uint32_t line,
                        uint32_t column)
{
    Place place = source_place(sources, file, offset);
    assert_int_equal(place.line, line);
    assert_int_equal(place.column, column);
}

static void check_line(Sources *sources, uint32_t file, uint32_t line, const char *expected)
{
    Str text = source_line(sources, file, line);
    assert_int_equal(text.length, strlen(expected));
    assert_memory_equal(text.at, expected, text.length);
}

static void places(void **state)
{
    (void)state;
    Arena arena = {0};
    Sources sources;
    sources_init(&sources, &arena);
    uint32_t file = sources_add(&sources, "a.scn", "/a.scn", STR("é=1\r\n\nπ x"), (Span){0});
    assert_int_equal(file, 1);
    assert_string_equal(source_get(&sources, file)->path, "a.scn");
    assert_null(source_get(&sources, 0));
    assert_null(source_get(&sources, 2));
    check_place(&sources, file, 0, 1, 1);
    check_place(&sources, file, 2, 1, 2);
    check_place(&sources, file, 5, 1, 5);
    check_place(&sources, file, 6, 2, 1);
    check_place(&sources, file, 7, 3, 1);
    check_place(&sources, file, 10, 3, 3);
    check_place(&sources, file, 999, 3, 4);
    check_place(&sources, 9, 0, 0, 0);
    check_line(&sources, file, 1, "é=1");
    check_line(&sources, file, 2, "");
    check_line(&sources, file, 3, "π x");
    check_line(&sources, file, 4, "");
    check_line(&sources, file, 0, "");
    sources_free(&sources);
    arena_free(&arena);
}

static void places_without_memory_for_the_lines(void **state)
{
    (void)state;
    Arena arena = {0};
    Sources sources;
    sources_init(&sources, &arena);
    uint32_t file = sources_add(&sources, "a.scn", NULL, STR("one\ntwo\nthree"), (Span){0});
    mem_fail_after(0);
    check_place(&sources, file, 9, 3, 2);
    check_line(&sources, file, 1, "");
    assert_int_equal(sources_add(&sources, "b.scn", NULL, STR("x"), (Span){0}), 2);
    mem_fail_after(UINT64_MAX);
    sources_free(&sources);
    arena_free(&arena);
}

static void release(Str text)
{
    mem_free((void *)(uintptr_t)text.at);
}

static void owned_text_is_given_back(void **state)
{
    (void)state;
    Arena arena = {0};
    Sources sources;
    sources_init(&sources, &arena);
    for (uint32_t i = 1; i <= 20; ++i) { // the sanitizer would see a leak
        char *text = mem_alloc(10, 1);
        memset(text, '\n', 10);
        assert_int_equal(sources_add(&sources, "a", NULL, (Str){text, 10}, (Span){0}), i);
        sources.items[i].release = release;
        check_place(&sources, i, 10, 11, 1);
    }
    sources_free(&sources);
    arena_free(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places),
        cmocka_unit_test(places_without_memory_for_the_lines),
        cmocka_unit_test(owned_text_is_given_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
