// String slices and interned names.
#ifndef BASE_STR_H
#define BASE_STR_H

#include "base/arena.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

// A run of bytes that somebody else owns; not NUL-terminated.
typedef struct Str {
    const char *at;
    size_t length;
} Str;

#define STR(literal) ((Str){"" literal, sizeof(literal) - 1})

static inline Str str_from(const char *text)
{
    return (Str){text, strlen(text)};
}

static inline bool str_equal(Str a, Str b)
{
    return a.length == b.length && memcmp(a.at, b.at, a.length) == 0;
}

// A name's number: equal names have equal symbols, so that comparing names is comparing integers.
// Symbols count up from 1 in the order of first appearance; 0 is no name.
typedef uint32_t Symbol;

typedef struct Interner {
    Arena *arena;     // owns the names' bytes; not owned
    Str *names;       // by symbol
    uint32_t *slots;  // open addressing; 0 = free
    uint32_t *hashes; // by symbol
    uint32_t count, capacity, slot_mask;
} Interner;

// `arena` keeps the names and must outlive the interner.
void interner_init(Interner *interner, Arena *arena);
void interner_free(Interner *interner);
// The symbol of a name, made on first sight (its bytes are copied). 0 when memory runs out (or the
// arena's jump).
Symbol intern(Interner *interner, Str name);
// The symbol of a name that was seen before, or 0.
Symbol interned(const Interner *interner, Str name);
// The name of a symbol; NUL-terminated, owned by the arena.
Str symbol_name(const Interner *interner, Symbol symbol);

// Damerau-Levenshtein distance of two names, for suggestions; at most `limit` + 1.
size_t str_distance(Str a, Str b, size_t limit);
// How far a name may lie from a suggestion for it: a third of its letters, but few for short names
// and no more than five.
size_t str_suggestion_limit(Str name);

#endif
