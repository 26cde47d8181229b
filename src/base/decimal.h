// Decimal text to the nearest double.
#ifndef BASE_DECIMAL_H
#define BASE_DECIMAL_H

#include <stdbool.h>
#include <stdint.h>

// mantissa * 10^exponent rounded to nearest, into *out, by exact arithmetic alone (Clinger 1990,
// "How to read floating point numbers accurately"). False where that can't be: then the text must
// be read by decimal_read.
bool decimal_from_parts(uint64_t mantissa, int exponent, double *out);

// The number written at [text, end): digits with an optional point, exponent, and `_` between
// digits, already known to be well formed. Any length; rounded to nearest; INFINITY on overflow, 0
// on underflow. Independent of the locale.
double decimal_read(const char *text, const char *end);

#endif
