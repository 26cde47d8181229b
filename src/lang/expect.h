// What the files of `expect` share.
#ifndef LANG_EXPECT_H
#define LANG_EXPECT_H

#include "lang/measure.h"

// What was found about an expectation, beside whether it is met; all but the measure lies in the
// evaluator's arena.
typedef struct Finding {
    SceneMeasure *measure; // it is to be measured; NULL: it is known
    // Where it isn't met:
    Span at;           // the part that doesn't hold
    const char *wrong; // "4 is not 3"
    ExpectationPart *parts;
    uint32_t part_count;
} Finding;

// The value as it would be written, cut where it is long.
const char *short_value(Eval *ev, Value v);
// Takes an expression and its value along.
void add_side(Eval *ev, Env *env, AstId id, Value v, Finding *finding);

// `value within tolerance of target`, all evaluated.
struct Within {
    Value value, tolerance, target;
    bool is_percentage;
    Span at, tolerance_at;
};

// Whether the tolerance is one; reports.
bool tolerance_is_sound(Eval *ev, const Within *within);
// Whether it holds; where not, *wrong says why. For numbers |a - b|; for vectors the length of the
// difference; for colors the largest difference of a component; for bounds that of a coordinate;
// for lists item by item. A percentage is of |b|, of the length, of the largest component, of the
// diagonal.
Truth within_holds(Eval *ev, const Within *within, const char **wrong);

#endif
