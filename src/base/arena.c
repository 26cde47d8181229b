#include "base/arena.h"

#include "base/mem.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { ALIGNMENT = 16, FIRST_BLOCK = 4096, LARGEST_BLOCK = 1 << 20 };

struct ArenaBlock {
    _Alignas(ALIGNMENT) ArenaBlock *before;
    size_t size; // with this header
};

static void *out_of_memory(Arena *arena)
{
    if (arena->on_oom) {
        longjmp(*arena->on_oom, 1);
    }
    return NULL;
}

static bool add_block(Arena *arena, size_t size)
{
    size_t wanted = arena->last ? arena->last->size * 2 : FIRST_BLOCK;
    if (wanted > LARGEST_BLOCK) {
        wanted = LARGEST_BLOCK;
    }
    if (wanted < size + sizeof(ArenaBlock)) {
        wanted = size + sizeof(ArenaBlock);
    }
    if (arena->limit && (wanted > arena->limit || arena->reserved > arena->limit - wanted)) {
        return false;
    }
    ArenaFamily *family = arena->family;
    if (family && (wanted > family->limit || family->reserved > family->limit - wanted)) {
        family->refused = true;
        return false;
    }
    ArenaBlock *block = mem_alloc(1, wanted);
    if (!block) {
        return false;
    }
    if (family) {
        family->reserved += wanted;
    }
    block->before = arena->last;
    block->size = wanted;
    arena->last = block;
    arena->next = (char *)block + sizeof *block;
    arena->end = (char *)block + wanted;
    arena->reserved += wanted;
    return true;
}

void *arena_alloc(Arena *arena, size_t size)
{
    if (size > PTRDIFF_MAX - 2 * sizeof(ArenaBlock)) {
        return out_of_memory(arena);
    }
    if (size == 0) {
        size = 1; // an address of its own: NULL would say that memory has run out
    }
    size = (size + ALIGNMENT - 1) & ~(size_t)(ALIGNMENT - 1);
    if ((size_t)(arena->end - arena->next) < size && !add_block(arena, size)) {
        return out_of_memory(arena);
    }
    void *memory = arena->next;
    arena->next += size;
    return memory;
}

void *arena_alloc_zeroed(Arena *arena, size_t size)
{
    void *memory = arena_alloc(arena, size);
    return memory ? memset(memory, 0, size) : NULL;
}

void *arena_array(Arena *arena, size_t count, size_t size)
{
    size_t bytes;
    return __builtin_mul_overflow(count, size, &bytes) ? out_of_memory(arena)
                                                       : arena_alloc(arena, bytes);
}

char *arena_copy_string(Arena *arena, const char *text, size_t length)
{
    char *copy = arena_alloc(arena, length + 1);
    if (copy) {
        memcpy(copy, text, length);
        copy[length] = '\0';
    }
    return copy;
}

char *arena_printf(Arena *arena, const char *format, ...)
{
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    char *text = length < 0 ? NULL : arena_alloc(arena, (size_t)length + 1);
    if (text) {
        vsnprintf(text, (size_t)length + 1, format, again);
    }
    va_end(again);
    return text;
}

ArenaMark arena_mark(const Arena *arena)
{
    return (ArenaMark){arena->last, arena->next, arena->end};
}

void arena_rewind(Arena *arena, ArenaMark mark)
{
    while (arena->last != mark.last) {
        ArenaBlock *before = arena->last->before;
        arena->reserved -= arena->last->size;
        if (arena->family) {
            arena->family->reserved -= arena->last->size;
        }
        mem_free(arena->last);
        arena->last = before;
    }
    arena->next = mark.next;
    arena->end = mark.end;
}

void arena_adopt(Arena *arena, Arena *from)
{
    if (!from->last) {
        return;
    }
    ArenaBlock *oldest = from->last;
    while (oldest->before) {
        oldest = oldest->before;
    }
    oldest->before = arena->last;
    arena->last = from->last;
    arena->next = from->next;
    arena->end = from->end;
    arena->reserved += from->reserved;
    if (arena->family) {
        arena->family->reserved += from->reserved;
    }
    if (from->family) {
        from->family->reserved -= from->reserved;
    }
    from->last = NULL;
    from->next = from->end = NULL;
    from->reserved = 0;
}

void arena_free(Arena *arena)
{
    arena_rewind(arena, (ArenaMark){0});
}
