// Which lines of two texts differ.
#ifndef BASE_LINE_DIFF_H
#define BASE_LINE_DIFF_H

#include "base/array.h"
#include "base/str.h"

typedef struct DiffLines {
    Str *items; // with their ends
    int count;
} DiffLines;

typedef struct LineDiff {
    DiffLines before, after;
    bool *removed, *added; // of each line
    int head, tail;        // equal lines at both ends
    ARRAY(int) reached;    // for the search
} LineDiff;

// The fewest lines that must be removed and added; one large change where they are very many. False
// without memory. The lines point into the texts. To be given back with line_diff_free in any case.
bool line_diff(LineDiff *diff, Str before, Str after);
void line_diff_free(LineDiff *diff);

// A run of changed lines: those of `before` in [before, before_end) became [after, after_end).
typedef struct LineChange {
    int before, before_end, after, after_end;
} LineChange;
// The first change at or behind line *before of the one text and line *after of the other, which
// are moved behind it (begin with zeros). False where there is none.
bool line_diff_next(const LineDiff *diff, int *before, int *after, LineChange *change);

#endif
