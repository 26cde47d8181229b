// Positions of the protocol: lines and columns in UTF-8, UTF-16 and UTF-32 units, there and back,
// and lines kept right under changes.
#include "lsp/buffer.h"
#include "lsp/uri.h"

#include "../test_support.h"

#include <stdio.h>
#include <stdlib.h>

// a (1 byte), ö (2), € (3), 𝒔 (4, two units of UTF-16)
#define MIXED "aö€𝒔b"

static void columns_count_the_units_of_the_encoding(void **state)
{
    (void)state;
    static const struct {
        PositionEncoding encoding;
        uint32_t columns[6]; // of a, ö, €, 𝒔, b and the end
    } cases[] = {
        {POSITIONS_UTF8, {0, 1, 3, 6, 10, 11}},
        {POSITIONS_UTF16, {0, 1, 2, 3, 5, 6}},
        {POSITIONS_UTF32, {0, 1, 2, 3, 4, 5}},
    };
    static const uint32_t offsets[] = {0, 1, 3, 6, 10, 11};
    Buffer text = {0};
    assert_true(buffer_set(&text, STR("first\n" MIXED "\nlast")));
    for (size_t i = 0; i < TEST_COUNT(cases); ++i) {
        for (size_t k = 0; k < TEST_COUNT(offsets); ++k) {
            uint32_t offset = 6 + offsets[k];
            Position at = buffer_position(&text, offset, cases[i].encoding);
            assert_int_equal(at.line, 1);
            assert_int_equal(at.column, cases[i].columns[k]);
            assert_int_equal(buffer_offset(&text, at, cases[i].encoding), offset);
        }
    }
    // Between the two units of a character: its begin.
    assert_int_equal(buffer_offset(&text, (Position){1, 4}, POSITIONS_UTF16), 6 + 6);
    assert_int_equal(buffer_offset(&text, (Position){1, 7}, POSITIONS_UTF8), 6 + 6);
    buffer_free(&text);
}

static void positions_beyond_a_line_or_the_text_are_their_ends(void **state)
{
    (void)state;
    Buffer text = {0};
    assert_int_equal(buffer_offset(&text, (Position){3, 3}, POSITIONS_UTF16), 0);
    assert_int_equal(buffer_position(&text, 9, POSITIONS_UTF16).line, 0);
    assert_true(buffer_set(&text, STR("ab\r\ncd\n")));
    assert_int_equal(buffer_offset(&text, (Position){0, 99}, POSITIONS_UTF16), 2);
    assert_int_equal(buffer_offset(&text, (Position){1, 99}, POSITIONS_UTF16), 6);
    assert_int_equal(buffer_offset(&text, (Position){2, 0}, POSITIONS_UTF16), 7);
    assert_int_equal(buffer_offset(&text, (Position){9, 0}, POSITIONS_UTF16), 7);
    assert_int_equal(buffer_position(&text, 99, POSITIONS_UTF16).line, 2);
    buffer_free(&text);
}

static void bytes_that_are_no_utf8_count_one_each(void **state)
{
    (void)state;
    Buffer text = {0};
    assert_true(buffer_set(&text, STR("\xff\xf0\x9dx")));
    for (uint32_t i = 0; i <= 4; ++i) {
        assert_int_equal(buffer_position(&text, i, POSITIONS_UTF16).column, i);
        assert_int_equal(buffer_offset(&text, (Position){0, i}, POSITIONS_UTF16), i);
    }
    buffer_free(&text);
}

// The lines after random changes are those of the same text set at once.
static void lines_follow_changes(void **state)
{
    (void)state;
    static const char *const parts[] = {"\n", "\r", "\r\n", "a", "ö", "", "x\ny", "\r\r\n\n"};
    unsigned seed = 7;
    printf("seed %u\n", seed);
    srand(seed);
    Buffer text = {0};
    assert_true(buffer_set(&text, STR("")));
    for (int i = 0; i < 20000; ++i) {
        uint32_t count = (uint32_t)text.bytes.count;
        uint32_t begin = (uint32_t)rand() % (count + 1);
        uint32_t end = begin + (uint32_t)rand() % (count - begin < 3 ? count - begin + 1 : 4);
        const char *part = parts[(size_t)rand() % TEST_COUNT(parts)];
        assert_true(buffer_replace(&text, begin, end, str_from(part)));
        Buffer whole = {0};
        assert_true(buffer_set(&whole, buffer_content(&text)));
        assert_int_equal(whole.lines.count, text.lines.count);
        assert_memory_equal(whole.lines.items, text.lines.items,
                            whole.lines.count * sizeof(uint32_t));
        buffer_free(&whole);
        if (count > 60) {
            assert_true(buffer_set(&text, STR("")));
        }
    }
    buffer_free(&text);
}

static void uris_name_paths(void **state)
{
    (void)state;
    Arena arena = {0};
    assert_string_equal(uri_to_path(&arena, STR("file:///a/b%20c/%C3%B6.scn")), "/a/b c/ö.scn");
    assert_string_equal(uri_to_path(&arena, STR("file://localhost/a?q#f")), "/a");
    assert_string_equal(uri_to_path(&arena, STR("FILE:/a")), "/a");
    assert_null(uri_to_path(&arena, STR("file://elsewhere/a")));
    assert_null(uri_to_path(&arena, STR("untitled:Untitled-1")));
    assert_null(uri_to_path(&arena, STR("file:///a%0")));
    assert_null(uri_to_path(&arena, STR("file:///a%00b")));
    assert_null(uri_to_path(&arena, STR("file://")));
    assert_null(uri_to_path(&arena, STR("")));
    assert_string_equal(uri_from_path(&arena, "/a b/ö#?%.scn"),
                        "file:///a%20b/%C3%B6%23%3F%25.scn");
    arena_free(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(columns_count_the_units_of_the_encoding),
        cmocka_unit_test(positions_beyond_a_line_or_the_text_are_their_ends),
        cmocka_unit_test(bytes_that_are_no_utf8_count_one_each),
        cmocka_unit_test(lines_follow_changes),
        cmocka_unit_test(uris_name_paths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
