// Values that only light can tell: means of radiance, and what is calculated with them. The
// evaluator handles them as formulas; `expect` puts them into the scene, to be measured by
// `scnrender test`.
#ifndef LANG_MEASURE_H
#define LANG_MEASURE_H

#include "lang/eval.h"

enum { MEASURE_MOST_PARTS = 200 }; // of one formula

struct MeasureNode {
    MeasureOp op;
    uint32_t channels; // 1 or 3
    uint32_t size;     // how many nodes the formula has
    const MeasureNode *a, *b;
    uint32_t channel;   // CHANNEL
    double constant[3]; // CONSTANT
    MeasureLeaf leaf;   // LEAF
};

Value measure_leaf(Eval *ev, const MeasureLeaf *leaf);
// a + b, a - b, a * b, a / b where one of them at least is measured; the other may be a number or a
// color. A number goes with each channel of a color in products and quotients.
Value measure_arithmetic(Eval *ev, Operator op, Value a, Value b, Span at);
Value measure_luminance(Eval *ev, Value v, Span at);
// One of r, g, b.
Value measure_channel(Eval *ev, Value v, uint32_t channel);
void text_add_measure(Eval *ev, TextBuffer *out, const MeasureNode *node);
void text_add_sight(Eval *ev, TextBuffer *out, const Sight *sight);

// The two sides of a comparison, one of which at least is measured, as what is to be found out; it
// lies in the scene. NULL after a report at `at`.
SceneMeasure *measure_comparison(Eval *ev, Operator op, Value a, Value b, Span at);
typedef struct Within Within; // expect.h
SceneMeasure *measure_within(Eval *ev, const Within *within);

#endif
