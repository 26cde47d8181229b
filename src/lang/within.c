// `a within 0.1 of b`: how far two values may be apart.
#include "lang/expect.h"

#include <stdio.h>

// How far a value is from its target, and what a percentage of the target is taken of.
typedef struct Gap {
    double off, whole;
} Gap;

// So much of the target may be off by rounding alone: 2 is within 0.1 of 2.1.
static const double ROUNDING = 0x1p-50;

static double largest(const double *c, int count)
{
    double most = 0;
    for (int i = 0; i < count; ++i) {
        most = fmax(most, fabs(c[i]));
    }
    return most;
}

static double length_of(const double *c, int count)
{
    double sum = 0;
    for (int i = 0; i < count; ++i) {
        sum = hypot(sum, c[i]);
    }
    return sum;
}

static Gap components_gap(Value a, Value b)
{
    double difference[4] = {0};
    for (int i = 0; i < a.small; ++i) {
        difference[i] = a.components[i] - b.components[i];
    }
    return a.type == VALUE_COLOR
               ? (Gap){largest(difference, 3), largest(b.components, 3)}
               : (Gap){length_of(difference, a.small), length_of(b.components, a.small)};
}

static Gap bounds_gap(const Box3 *a, const Box3 *b)
{
    double low = max_component(vec3_abs(sub(a->min, b->min)));
    double high = max_component(vec3_abs(sub(a->max, b->max)));
    return (Gap){fmax(low, high), length(sub(b->max, b->min))};
}

// False for values that have no distance.
static bool find_gap(Value a, Value b, Gap *gap)
{
    if (a.type != b.type) {
        return false;
    }
    switch ((ValueType)a.type) {
    case VALUE_NUMBER:
        *gap = (Gap){fabs(a.number - b.number), fabs(b.number)};
        return true;
    case VALUE_VECTOR:
    case VALUE_COLOR:
        *gap = components_gap(a, b);
        return a.small == b.small;
    case VALUE_BOUNDS:
        *gap = bounds_gap(a.bounds, b.bounds);
        return true;
    default:
        return false;
    }
}

// --- Checks --------------------------------------------------------------------------------------

bool tolerance_is_sound(Eval *ev, const Within *within)
{
    Value t = within->tolerance;
    char found[DESCRIBE_SIZE];
    if (t.type != VALUE_NUMBER) {
        report(ev, E0405, within->tolerance_at, "a tolerance is a number, not %s",
               describe_value(ev, t, found, sizeof found));
        return false;
    }
    if (within->is_percentage && t.dim != DIM_NONE) {
        report(ev, E0402, within->tolerance_at, "a percentage has no unit; this is %s",
               describe_value(ev, t, found, sizeof found));
        return false;
    }
    if (t.number < 0) {
        report(ev, E0404, within->tolerance_at, "a tolerance can't be below zero");
        return false;
    }
    return true;
}

static bool dims_agree(Eval *ev, const Within *within, Value a, Value b)
{
    char left[DESCRIBE_SIZE], right[DESCRIBE_SIZE];
    uint8_t dim = a.type == VALUE_BOUNDS ? DIM_NONE : a.dim, of = within->tolerance.dim;
    if (a.type != VALUE_BOUNDS && a.dim != b.dim) {
        report(ev, E0402, within->at, "`within` doesn't compare %s and %s",
               describe_value(ev, a, left, sizeof left),
               describe_value(ev, b, right, sizeof right));
        return false;
    }
    bool length_of_box = a.type == VALUE_BOUNDS && of == DIM_LENGTH; // boxes are in metres
    if (!within->is_percentage && of != dim && !length_of_box) {
        Diag *diag =
            report(ev, E0402, within->tolerance_at, "the tolerance is %s, but the values have %s%s",
                   describe_value(ev, within->tolerance, left, sizeof left),
                   dim == DIM_NONE ? "no unit" : "the dimension ",
                   dim == DIM_NONE ? "" : dim_info((Dim)dim)->name);
        diag_note(ev->sink, diag, "a percentage, as in `within 1%% of b`, suits all dimensions");
        return false;
    }
    return true;
}

// --- Verdict -------------------------------------------------------------------------------------

static const char *describe_gap(Eval *ev, const Within *within, Value a, Value b, Gap gap)
{
    TextBuffer text = {0};
    const char *left = short_value(ev, a), *right = short_value(ev, b);
    if (within->is_percentage && gap.whole > 0) {
        text_add(ev, &text, "%s is %.3g%% off %s, and %.3g%% is allowed", left,
                 100 * gap.off / gap.whole, right, within->tolerance.number);
    } else if (within->is_percentage) {
        text_add(ev, &text, "%s is not %s, and a part of 0 is 0: give the tolerance as a number",
                 left, right);
    } else {
        Value off = within->tolerance;
        off.number = gap.off;
        text_add(ev, &text, "%s is ", left);
        text_add_value(ev, &text, off, true);
        text_add(ev, &text, " off %s, and ", right);
        text_add_value(ev, &text, within->tolerance, true);
        text_add(ev, &text, " is allowed");
    }
    return text.text;
}

static Truth compare_pair(Eval *ev, const Within *within, Value a, Value b, const char **wrong);

static Truth compare_items(Eval *ev, const Within *within, Value a, Value b, const char **wrong)
{
    TextBuffer text = {0};
    if (stack_is_deep(ev)) {
        report_deep_stack(ev, within->at);
        return TRUTH_ERROR;
    }
    if (a.count != b.count) {
        text_add(ev, &text, "it has %u item%s, not %u", a.count, a.count == 1 ? "" : "s", b.count);
        *wrong = text.text;
        return TRUTH_FALSE;
    }
    for (uint32_t i = 0; i < a.count; ++i) {
        Truth truth = compare_pair(ev, within, sequence_item(a, i), sequence_item(b, i), wrong);
        if (truth == TRUTH_FALSE) {
            text_add(ev, &text, "item %u: %s", i, *wrong);
            *wrong = text.text;
        }
        if (truth != TRUTH_TRUE) {
            return truth;
        }
    }
    return TRUTH_TRUE;
}

static bool is_sequence(Value v)
{
    return v.type == VALUE_LIST || v.type == VALUE_RANGE;
}

static Truth compare_pair(Eval *ev, const Within *within, Value a, Value b, const char **wrong)
{
    Gap gap;
    if (is_sequence(a) && is_sequence(b)) {
        return compare_items(ev, within, a, b, wrong);
    }
    if (!find_gap(a, b, &gap)) {
        char left[DESCRIBE_SIZE], right[DESCRIBE_SIZE];
        report(ev, E0405, within->at, "`within` doesn't compare %s and %s",
               describe_value(ev, a, left, sizeof left),
               describe_value(ev, b, right, sizeof right));
        return TRUTH_ERROR;
    }
    if (!dims_agree(ev, within, a, b)) {
        return TRUTH_ERROR;
    }
    double part = within->tolerance.number / 100;
    double allowed = within->is_percentage ? part * gap.whole : within->tolerance.number;
    if (gap.off <= allowed + ROUNDING * gap.whole) {
        return TRUTH_TRUE;
    }
    *wrong = describe_gap(ev, within, a, b, gap);
    return TRUTH_FALSE;
}

Truth within_holds(Eval *ev, const Within *within, const char **wrong)
{
    return compare_pair(ev, within, within->value, within->target, wrong);
}
