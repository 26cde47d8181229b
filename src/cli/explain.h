// The manual, from the tables that the program runs on: single entries as plain text, and all of it
// as Markdown.
#ifndef CLI_EXPLAIN_H
#define CLI_EXPLAIN_H

#include "schema/schema.h"

#include <stdio.h>

// What a field takes, in words: "length > 0", "one of \"a\", \"b\"", "material", "vector of 3".
void print_field_type(FILE *out, const Param *param);
// Writes text as paragraphs of at most `width` columns, each line after `indent` spaces; the first
// line begins at column `at`.
void print_wrapped(FILE *out, const char *text, int indent, int at, int width);

#endif
