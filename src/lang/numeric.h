// Expressions of numbers alone as straight code, beside the tree.
//
// `fract(sin(i * 12.9898 + k * 78.233) * 43758.5453)` is a few dozen nanoseconds of arithmetic, and
// ten times that as a walk through a tree of values that may be anything. So operators and calls of
// which everything can be foreseen, if the names in it stand for bare numbers, get a list of steps
// on plain doubles, calls of the file's own functions written out. Where a name stands for
// something else after all, a result isn't finite, or a limit is near, the tree is evaluated as
// ever: nothing was done meanwhile that could be seen, so values, limits and diagnostics are the
// tree's.
#ifndef LANG_NUMERIC_H
#define LANG_NUMERIC_H

#include "lang/eval.h"

typedef enum NumericCode {
    NUMERIC_NUMBER, // as it stands there, or a built-in quantity
    NUMERIC_LOAD,   // a slot, `up` frames further out
    NUMERIC_GLOBAL, // a slot of the file's frame
    NUMERIC_COPY,   // a parameter of a function that was written out
    NUMERIC_NEGATE,
    NUMERIC_ADD,
    NUMERIC_SUBTRACT,
    NUMERIC_MULTIPLY,
    NUMERIC_OPERATOR, // another
    NUMERIC_FUNCTION,
} NumericCode;

// One step. Operands are told by how many steps ago they were computed, so that the steps of a part
// of an expression are a part of its steps.
typedef struct NumericStep {
    uint8_t code; // NumericCode
    uint8_t op;   // Operator
    uint8_t dim;  // of the result
    uint8_t pad;
    uint16_t a, b; // operands; slots: a: frames up, and DIM_BIT()s that are taken
    union {
        double number;
        uint32_t slot;
        double (*function)(double);
    };
} NumericStep;

// The steps of a BINARY or CALL node; its number + 1 is the node's aux.
typedef struct NumericPart {
    uint32_t first;         // of Numeric.steps
    uint16_t count, misses; // misses: times that a name wasn't a number; after many it isn't tried
                            // any more. Threads share it: by __atomic functions only
    uint16_t call_depth;    // of functions in it
    uint32_t limited;       // steps that limits count
} NumericPart;

struct Numeric {
    ARRAY(NumericStep) steps;
    ARRAY(NumericPart) parts;
};

// Makes the steps of all of a module that has been resolved. Without memory there are none.
void numeric_make(Eval *ev, Module *module);
void numeric_free(Module *module);
// The value of a part; false where the tree is to be evaluated.
bool numeric_run(Eval *ev, Env *env, uint32_t part, Value *out);

#endif
