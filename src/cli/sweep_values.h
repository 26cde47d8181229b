// What `--sweep NAME=VALUES` says: "alpha=0.05,0.1,0.2", "ior=1.3..1.8:6", "tint=#f00,#00f".
#ifndef CLI_SWEEP_VALUES_H
#define CLI_SWEEP_VALUES_H

#include "base/arena.h"
#include "base/str.h"

#include <stdbool.h>
#include <stddef.h>

enum { SWEEP_MOST_VALUES = 10000 };

typedef struct Sweep {
    const char *name;
    const char *const *values; // as --set takes them
    size_t count;              // at least 1
} Sweep;

// Parses it: values with commas between them, but for those in brackets or strings. A..B:N, whose
// ends are numbers, perhaps with units, stands for N of them from A to B in equal steps; A..B of
// whole numbers for each from A to B. Other values are kept as they are. Strings are the arena's.
// False with a message.
bool sweep_parse(Arena *arena, const char *text, Sweep *out, char *message, size_t message_size);

#endif
