// A contact sheet: the pictures of a sweep on one, each with its values.
#ifndef CLI_SHEET_H
#define CLI_SHEET_H

#include "cli/sweep_values.h"

typedef struct SheetCell {
    const char *picture; // a PNG; NULL: there is none,
    const char *why;     // and why: "not rendered"
} SheetCell;

// The first sweep's values are the columns, the second's the rows; for each value of the others
// there is another block of rows. A single sweep of many values is folded into several rows.
typedef struct Sheet {
    const char *title;
    const Sweep *sweeps;
    size_t sweep_count;     // at least 1
    const SheetCell *cells; // the first sweep's values follow one another
    size_t cell_count;      // product of the sweeps' counts; at least one has a picture
} Sheet;

// Writes it to the file `path`, a picture for display. Where it would be too large, all pictures
// are averaged down by the same whole number. An ExitCode, with a message if it isn't EXIT_OK.
int sheet_write(const Sheet *sheet, const char *path, char *message, size_t message_size);

#endif
