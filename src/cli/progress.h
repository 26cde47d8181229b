// What is shown while a picture is rendered: a bar on a terminal, redrawn at most ten times a
// second; and the lines at its end.
#ifndef CLI_PROGRESS_H
#define CLI_PROGRESS_H

#include "render/render.h"

#include <stdbool.h>

typedef struct Bar {
    bool shown;      // on a terminal, and wanted
    bool drawn;      // there is a line to be wiped
    double drawn_at; // seconds since the start of rendering
    const char *label;
} Bar;

// `label` stands before it; NULL: nothing.
void bar_begin(Bar *bar, bool wanted, const char *label);
void bar_draw(Bar *bar, const RenderProgress *progress);
// Wipes it, so that something else can be printed.
void bar_end(Bar *bar);

// Writes the bar's text, at most `width` columns, to `text`.
void bar_text(const RenderProgress *progress, int width, char *text, size_t size);
// "0.4 s", "12 s", "3:05", "2:13:05"
void duration_text(double seconds, char *text, size_t size);
// "950", "12.3 k", "4.56 M"
void count_text(double count, char *text, size_t size);

#endif
