// The manual of kinds, fields and units, from the table that the program runs on: as plain text for
// a terminal, and as Markdown for docs/reference.md.
#ifndef SCHEMA_MANUAL_H
#define SCHEMA_MANUAL_H

#include "schema/schema.h"

#include <stdio.h>

typedef enum ManualStyle { MANUAL_TEXT, MANUAL_MARKDOWN } ManualStyle;

// A kind: what it is, its fields with what they take, their defaults and ranges, the formula behind
// it and an example.
void manual_write_kind(const NodeType *type, FILE *out, ManualStyle style);
// What a field takes, in a line: "length, bare in m; above 0; default 1".
void manual_write_takes(const Param *param, FILE *out);
// The same for a field that every kind of a category has.
const char *manual_common_takes(CommonField field);
// The fields that every kind of the category takes; nothing where there are none.
void manual_write_common_fields(Category category, FILE *out, ManualStyle style);
// MANUAL_TEXT: the names of the category's kinds; MANUAL_MARKDOWN: its chapter, all kinds whole.
void manual_write_category(const Schema *schema, Category category, FILE *out, ManualStyle style);
// The table of all units.
void manual_write_units(FILE *out, ManualStyle style);

// Text in paragraphs of at most `width` columns, each line after `indent` blanks; the first line
// begins at column `at`. Ends with a newline.
void manual_write_wrapped(FILE *out, const char *text, int indent, int at, int width);
// Lines as they are, set in by four blanks, or in a fence of the given language.
void manual_write_code(FILE *out, const char *text, const char *language, ManualStyle style);
// The picture of the example of the kind or integrator called `name`, for Markdown. tools/docs
// makes the picture.
void manual_write_picture(FILE *out, const char *name);
// A cell of a Markdown table: `|` would end it.
void manual_write_cell(FILE *out, const char *text);

enum { MANUAL_WIDTH = 80, MANUAL_NAME_COLUMN = 18 };

#endif
