// Source files and places in them.
#ifndef BASE_SOURCE_H
#define BASE_SOURCE_H

#include "base/arena.h"
#include "base/str.h"

// Bytes [begin, end) of source `file`. file = 0 is nowhere (the command line, a default).
typedef struct Span {
    uint32_t file, begin, end;
} Span;

typedef struct Source {
    const char *path; // as shown in diagnostics
    const char *real; // absolute, links resolved; names the file uniquely
    Str text;         // whole content
    Span imported_at; // the import that first brought it; file = 0 for the scene itself
    uint32_t *lines;  // byte offset of each line's start, made on first need
    uint32_t line_count;
    struct SourceMark *marks; // where characters were counted up to; for long lines, on first need
    uint32_t mark_count;
    void (*release)(Str text); // how sources_free gives the text back; NULL: it isn't owned
} Source;

// All sources of one run; numbers count from 1. Owned by the caller; the arena keeps the entries.
typedef struct Sources {
    Arena *arena;
    Source *items; // items[0] is unused
    uint32_t count, capacity;
} Sources;

// Line and column count from 1; the column counts Unicode characters (code points), not bytes.
typedef struct Place {
    uint32_t line, column;
} Place;

void sources_init(Sources *sources, Arena *arena);
void sources_free(Sources *sources);
// Adds a source; its number, or 0 when memory runs out. The text must live as long as `sources`,
// or be owned: then set items[number].release. The strings are copied.
uint32_t sources_add(Sources *sources, const char *path, const char *real, Str text,
                     Span imported_at);
// Forgets the sources beyond the first `count`.
void sources_rewind(Sources *sources, uint32_t count);
// NULL for 0 and for numbers that were never given.
const Source *source_get(const Sources *sources, uint32_t file);
// Where byte `offset` lies (beyond the end: the end). {0, 0} for an unknown file. An invalid byte
// counts as a character.
Place source_place(Sources *sources, uint32_t file, uint32_t offset);
// The text of line `line` (from 1), without its end ("\n" or "\r\n"). Empty beyond the last.
Str source_line(Sources *sources, uint32_t file, uint32_t line);

#endif
