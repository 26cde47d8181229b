// Memory: blocks that are counted, allocations that fail when they are told to, arenas.
#include "../test_support.h"

#include "base/arena.h"
#include "base/mem.h"

#include <string.h>

static void blocks_are_counted(void **state)
{
    (void)state;
    const uint64_t before = mem_live_count();
    char *a = mem_alloc(3, 5), *b = mem_alloc_zeroed(2, 8), *c = mem_realloc(NULL, 1, 7);
    assert_true(a && b && c);
    assert_int_equal(mem_live_count(), before + 3);
    c = mem_realloc(c, 100, 1);
    assert_non_null(c);
    assert_int_equal(mem_live_count(), before + 3);
    mem_free(a);
    mem_free(b);
    mem_free(c);
    mem_free(NULL);
    assert_int_equal(mem_live_count(), before);
}

static void failing_allocations_keep_their_block(void **state)
{
    (void)state;
    const uint64_t before = mem_live_count();
    char *block = mem_alloc(4, 1);
    memcpy(block, "abc", 4);
    mem_fail_after(0);
    assert_null(mem_alloc(1, 1));
    assert_null(mem_alloc_zeroed(1, 1));
    assert_null(mem_realloc(block, 8, 1));
    assert_null(mem_realloc(NULL, 8, 1));
    mem_fail_after(UINT64_MAX);
    assert_string_equal(block, "abc");
    mem_free(block);
    assert_null(mem_alloc(SIZE_MAX, 2)); // the product wraps
    assert_int_equal(mem_live_count(), before);
}

// NULL means that memory has run out, and nothing else.
static void an_arena_gives_an_address_for_nothing(void **state)
{
    (void)state;
    Arena arena = {0};
    void *first = arena_alloc(&arena, 0), *second = arena_array(&arena, 0, 16);
    assert_true(first && second && first != second);
    assert_string_equal(arena_copy_string(&arena, "", 0), "");
    arena_free(&arena);
}

static void an_arena_keeps_its_limit(void **state)
{
    (void)state;
    Arena arena = {.limit = 10000};
    assert_non_null(arena_alloc(&arena, 3000));
    assert_null(arena_alloc(&arena, 9000));
    assert_true(arena.reserved <= arena.limit);
    assert_null(arena_alloc(&arena, SIZE_MAX - 8));
    assert_null(arena_array(&arena, SIZE_MAX / 2, 4));
    arena_free(&arena);
    assert_int_equal(arena.reserved, 0);
}

// What is adopted counts as newer than what was there: rewinding to a mark gives it back.
static void an_arena_takes_over_what_another_holds(void **state)
{
    (void)state;
    const uint64_t live = mem_live_count();
    ArenaFamily family = {.limit = SIZE_MAX}, others = {.limit = SIZE_MAX};
    Arena arena = {.family = &family}, other = {.family = &others}, empty = {0};
    char *first = arena_copy_string(&arena, "first", 5);
    const ArenaMark mark = arena_mark(&arena);
    const size_t reserved = arena.reserved;
    char *texts[3];
    for (int i = 0; i < 3; ++i) {
        texts[i] = arena_copy_string(&other, "other", 5);
        arena_alloc(&other, 5000); // so that there are several blocks
    }
    arena_adopt(&arena, &empty);
    assert_int_equal(arena.reserved, reserved);
    const size_t adopted = other.reserved;
    arena_adopt(&arena, &other);
    assert_int_equal(arena.reserved, reserved + adopted);
    assert_int_equal(family.reserved, reserved + adopted);
    assert_int_equal(others.reserved, 0);
    assert_int_equal(other.reserved, 0);
    assert_string_equal(arena_copy_string(&other, "again", 5), "again");
    assert_string_equal(arena_copy_string(&arena, "last", 4), "last");
    assert_string_equal(first, "first");
    assert_string_equal(texts[0], "other");
    assert_string_equal(texts[2], "other");
    arena_rewind(&arena, mark);
    assert_int_equal(arena.reserved, reserved);
    assert_int_equal(family.reserved, reserved);
    assert_string_equal(first, "first");
    arena_free(&arena);
    arena_free(&other);
    assert_int_equal(mem_live_count(), live);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_counted),
        cmocka_unit_test(failing_allocations_keep_their_block),
        cmocka_unit_test(an_arena_gives_an_address_for_nothing),
        cmocka_unit_test(an_arena_keeps_its_limit),
        cmocka_unit_test(an_arena_takes_over_what_another_holds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
