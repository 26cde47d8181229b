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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_counted),
        cmocka_unit_test(failing_allocations_keep_their_block),
        cmocka_unit_test(an_arena_gives_an_address_for_nothing),
        cmocka_unit_test(an_arena_keeps_its_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
