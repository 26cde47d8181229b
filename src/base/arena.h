// Arenas: memory that is given back all at once. One for each phase: program (tokens, AST), scene,
// scratch for each worker.
#ifndef BASE_ARENA_H
#define BASE_ARENA_H

#include <setjmp.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ArenaBlock ArenaBlock;

// Arenas that have a limit together.
typedef struct ArenaFamily {
    size_t reserved, limit; // bytes; no more than `limit` are reserved
    bool refused;           // something was, for the limit's sake
} ArenaFamily;

typedef struct Arena {
    ArenaBlock *last;    // newest block; blocks are chained from new to old
    char *next, *end;    // free part of the newest block
    size_t reserved;     // bytes taken from the system, all blocks together
    size_t limit;        // no more than this many bytes are reserved; 0 = no limit
    ArenaFamily *family; // not owned; NULL: none
    jmp_buf *on_oom;     // where arena_alloc jumps (with value 1) when memory runs out; NULL: it
                         // returns NULL instead. Not owned.
} Arena;

typedef struct ArenaMark {
    ArenaBlock *last;
    char *next, *end;
} ArenaMark;

// An arena of zero bytes is a valid, empty one: `Arena a = {0};` needs no init.

// `size` bytes (0 gives an address, too), aligned to 16, not cleared. NULL (or the jump) when
// memory runs out.
void *arena_alloc(Arena *arena, size_t size);
void *arena_alloc_zeroed(Arena *arena, size_t size);
// An array: checks the multiplication.
void *arena_array(Arena *arena, size_t count, size_t size);
// A NUL-terminated copy of `length` bytes.
char *arena_copy_string(Arena *arena, const char *text, size_t length);
// printf into the arena.
char *arena_printf(Arena *arena, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Everything allocated after a mark is given back by arena_rewind to that mark.
ArenaMark arena_mark(const Arena *arena);
void arena_rewind(Arena *arena, ArenaMark mark);
// Puts all that lies in `from` behind what lies in `arena`, as if it had been allocated there just
// now; nothing moves. `from` is empty then. Limits aren't looked at.
void arena_adopt(Arena *arena, Arena *from);
// Gives everything back; the arena is empty and usable again.
void arena_free(Arena *arena);

#define ARENA_NEW(arena, Type) ((Type *)arena_alloc_zeroed((arena), sizeof(Type)))

#endif
