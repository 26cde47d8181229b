// The difference of two texts, line by line.
#ifndef CLI_DIFF_H
#define CLI_DIFF_H

#include "base/str.h"

#include <stdio.h>

// Writes a unified diff with three lines of context, as `patch` takes it; nothing where the texts
// are equal. False without memory.
bool diff_write(Str before, Str after, const char *name, FILE *out);

#endif
