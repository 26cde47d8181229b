// Reading and making the protocol's JSON. All of cJSON's own functions take NULL where memory ran
// out, so that what is made then is only incomplete.
#ifndef LSP_JSON_H
#define LSP_JSON_H

#include "base/str.h"

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

// The member at a path of names, "textDocument.uri"; NULL where there is none.
const cJSON *json_at(const cJSON *object, const char *path);
// Its text (NULL where it is no string), number (`other` where it is none) or truth.
const char *json_get_string(const cJSON *object, const char *path);
double json_get_number(const cJSON *object, const char *path, double other);
bool json_get_true(const cJSON *object, const char *path);
// Whether the list at `path` has the string.
bool json_lists(const cJSON *object, const char *path, const char *string);

// A string of any bytes: those that aren't UTF-8 become U+FFFD.
cJSON *json_text(Str text);
void json_add_text(cJSON *object, const char *name, Str text);

// Text in the making. memo_begin gives the stream to print to, or NULL without memory; memo_text
// ends it and gives what was printed (nothing without memory); memo_free gives all back.
typedef struct Memo {
    FILE *out;
    char *text;
    size_t length;
} Memo;

FILE *memo_begin(Memo *memo);
Str memo_text(Memo *memo);
void memo_free(Memo *memo);

#endif
