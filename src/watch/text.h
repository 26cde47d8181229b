// Text that grows, also under a FILE, for what is written by code that wants one.
#ifndef WATCH_TEXT_H
#define WATCH_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef struct Text {
    char *bytes; // `length` bytes and a NUL; NULL while nothing was written
    size_t length, capacity;
    bool failed; // memory ran out: what came after is missing
} Text;

void text_write(Text *text, const char *bytes, size_t length);
void text_print(Text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
// A word of a POSIX shell's command line, with a blank before it unless it is the first: quoted
// where it has to be.
void text_shell_word(Text *text, const char *word);
// What is printed to it is appended to `text`, at the latest by fclose. NULL without memory.
FILE *text_stream(Text *text);
void text_free(Text *text);

#endif
