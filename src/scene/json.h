// JSON, written as a stream: values only; who calls puts the braces, commas and colons.
#ifndef SCENE_JSON_H
#define SCENE_JSON_H

#include "base/vec.h"

#include <stdio.h>

// The shortest decimal number that reads back as the same double (float). JSON knows no infinities
// and no NaN: they are written as the strings "inf", "-inf" and "nan".
void json_number(FILE *out, double value);
void json_float(FILE *out, float value);
// A string in quotes, escaped; NULL is written as null. Bytes that are not UTF-8 (in a file's name,
// say) become U+FFFD.
void json_string(FILE *out, const char *text);
// "key": with the colon.
void json_key(FILE *out, const char *key);
// [x, y, z]; [r, g, b]; three rows of four.
void json_vec3(FILE *out, Vec3 v);
void json_rgb(FILE *out, Rgb color);
void json_affine(FILE *out, const Affine *map);

#endif
