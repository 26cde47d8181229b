// What the built-in functions share: arguments taken and checked, each with its report.
#ifndef LANG_BUILTINS_H
#define LANG_BUILTINS_H

#include "lang/eval.h"

#define BUILTIN(name, least, most, signature, doc) Value builtin_##name(Call *call);
#include "lang/builtins.def"

// Where argument `i` was written.
Span arg_span(const Call *call, uint32_t i);
Value arg_wrong(Call *call, uint32_t i, const char *wanted);
// Each gives false after a report.
bool arg_bare(Call *call, uint32_t i, double *out);
bool arg_number(Call *call, uint32_t i, double *out, uint8_t *dim);
bool arg_angle(Call *call, uint32_t i, double *radians);
// Of 2 to 4 components; a wanted count, or 0 for any.
bool arg_vector(Call *call, uint32_t i, int count, Value *out);
bool arg_vec3(Call *call, uint32_t i, Vec3 *out);
bool arg_list(Call *call, uint32_t i, Value *out); // or range
bool arg_function(Call *call, uint32_t i);
// A number that is no finite number is an error at the call.
Value number_result(Call *call, double number, uint8_t dim);
// x - floor(x), in [0, 1).
double fraction(double x);
bool same_dim(Call *call, uint32_t i, uint8_t a, uint8_t b);

#endif
