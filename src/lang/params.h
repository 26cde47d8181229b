// `param` items. See params.c; evaluation itself is declared in eval.h.
#ifndef LANG_PARAMS_H
#define LANG_PARAMS_H

#include "lang/eval.h"

typedef struct ParamRange {
    double min, max; // infinite where there is none
    bool exclude_max;
    Value choices; // a list; else unset
} ParamRange;

// What stands after `in`; `dim` is that of the param. False after a report.
bool param_range(Eval *ev, Env *env, AstId item, uint8_t dim, ParamRange *out);
// All params of a file as a JSON array, then those of the files that it imports itself, as
// `namespace.name`: what can be set from outside.
void params_write_json(Eval *ev, const Module *module, FILE *out);

#endif
