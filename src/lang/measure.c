#include "lang/measure.h"

#include "lang/expect.h"

// Photometric units are of measured luminances, too.
#include "schema/photometry.h"

// --- Formulas ------------------------------------------------------------------------------------

static Value measure_value(const MeasureNode *node)
{
    return (Value){.type = VALUE_MEASURE, .small = (uint16_t)node->channels, .measure = node};
}

static Value add_node(Eval *ev, MeasureNode node, Span at)
{
    if (node.size > MEASURE_MOST_PARTS) {
        return fail(
            report(ev, E0415, at, "a measured value of more than %d parts", MEASURE_MOST_PARTS));
    }
    MeasureNode *copy = arena_alloc(ev->arena, sizeof *copy);
    *copy = node;
    return measure_value(copy);
}

Value measure_leaf(Eval *ev, const MeasureLeaf *leaf)
{
    return add_node(
        ev,
        (MeasureNode){
            .op = MEASURE_LEAF, .channels = leaf->coverage ? 1 : 3, .size = 1, .leaf = *leaf},
        leaf->sight.at);
}

static Value binary_node(Eval *ev, MeasureOp op, Value a, Value b, Span at)
{
    const MeasureNode *left = a.measure, *right = b.measure;
    return add_node(ev,
                    (MeasureNode){.op = op,
                                  .channels = left->channels > right->channels ? left->channels
                                                                               : right->channels,
                                  .size = left->size + right->size + 1,
                                  .a = left,
                                  .b = right},
                    at);
}

// A measured value, a number or a color as a formula; false for anything else.
static bool as_measure(Eval *ev, Value *v, Span at)
{
    MeasureNode node = {.op = MEASURE_CONSTANT, .channels = 1, .size = 1};
    if (v->type == VALUE_COLOR) {
        node.channels = 3;
        memcpy(node.constant, v->components, sizeof node.constant);
    } else if (is_bare(*v)) {
        node.constant[0] = node.constant[1] = node.constant[2] = v->number;
    } else {
        return v->type == VALUE_MEASURE;
    }
    *v = add_node(ev, node, at);
    return true;
}

Value measure_arithmetic(Eval *ev, Operator op, Value a, Value b, Span at)
{
    static const struct {
        Operator op;
        MeasureOp measure;
    } operators[] = {{OP_ADD, MEASURE_ADD},
                     {OP_SUBTRACT, MEASURE_SUBTRACT},
                     {OP_MULTIPLY, MEASURE_MULTIPLY},
                     {OP_DIVIDE, MEASURE_DIVIDE}};
    char left[DESCRIBE_SIZE], right[DESCRIBE_SIZE];
    describe_value(ev, a, left, sizeof left);
    describe_value(ev, b, right, sizeof right);
    for (size_t i = 0; i < sizeof operators / sizeof *operators; ++i) {
        bool sum = op == OP_ADD || op == OP_SUBTRACT;
        if (operators[i].op == op && as_measure(ev, &a, at) && as_measure(ev, &b, at) &&
            (!sum || a.small == b.small)) {
            return binary_node(ev, operators[i].measure, a, b, at);
        }
    }
    return fail(
        report(ev, E0405, at, "`%s` doesn't take %s and %s", operator_text(op), left, right));
}

Value measure_luminance(Eval *ev, Value v, Span at)
{
    return add_node(
        ev,
        (MeasureNode){
            .op = MEASURE_LUMINANCE, .channels = 1, .size = v.measure->size + 1, .a = v.measure},
        at);
}

Value measure_channel(Eval *ev, Value v, uint32_t channel)
{
    return add_node(ev,
                    (MeasureNode){.op = MEASURE_CHANNEL,
                                  .channels = 1,
                                  .size = v.measure->size + 1,
                                  .a = v.measure,
                                  .channel = channel},
                    (Span){0});
}

// --- As text -------------------------------------------------------------------------------------

static void add_place(Eval *ev, TextBuffer *out, const Sight *sight)
{
    const char *comma = isfinite(sight->x1) ? ", " : "";
    if (isfinite(sight->x1)) {
        text_add(ev, out, "region((%.15g, %.15g), (%.15g, %.15g)", sight->x0, sight->y0, sight->x1,
                 sight->y1);
    } else {
        text_add(ev, out, "picture(");
    }
    if (sight->camera) {
        text_add(ev, out, "%s\"%s\"", comma, sight->camera);
    }
    text_add(ev, out, ")");
}

void text_add_sight(Eval *ev, TextBuffer *out, const Sight *sight)
{
    if (sight->object) {
        text_add(ev, out, "object(\"%s\"", sight->object);
    }
    if (sight->kind == SIGHT_RAY) {
        Vec3 o = sight->origin, d = sight->direction;
        text_add(ev, out, "%sray((%.15g, %.15g, %.15g), (%.15g, %.15g, %.15g))",
                 sight->object ? ", " : "", o.x, o.y, o.z, d.x, d.y, d.z);
    } else if (!sight->object || isfinite(sight->x1) || sight->camera) {
        text_add(ev, out, "%s", sight->object ? ", " : "");
        add_place(ev, out, sight);
    }
    text_add(ev, out, "%s", sight->object ? ")" : "");
}

static void add_constant(Eval *ev, TextBuffer *out, const MeasureNode *node)
{
    Value v = value_number(node->constant[0], DIM_NONE);
    if (node->channels == 3) {
        v = (Value){.type = VALUE_COLOR, .small = 3, .components = node->constant};
    }
    text_add_value(ev, out, v, true);
}

void text_add_measure(Eval *ev, TextBuffer *out, const MeasureNode *node)
{
    static const char *const operators[] = {[MEASURE_ADD] = "+",
                                            [MEASURE_SUBTRACT] = "-",
                                            [MEASURE_MULTIPLY] = "*",
                                            [MEASURE_DIVIDE] = "/"};
    switch (node->op) {
    case MEASURE_LEAF:
        text_add(ev, out, node->leaf.coverage ? "coverage(" : "radiance(");
        text_add_sight(ev, out, &node->leaf.sight);
        text_add(ev, out, ")");
        break;
    case MEASURE_CONSTANT:
        add_constant(ev, out, node);
        break;
    case MEASURE_LUMINANCE:
        text_add(ev, out, "luminance(");
        text_add_measure(ev, out, node->a);
        text_add(ev, out, ")");
        break;
    case MEASURE_CHANNEL:
        text_add_measure(ev, out, node->a);
        text_add(ev, out, ".%c", "rgb"[node->channel]);
        break;
    default:
        text_add(ev, out, "(");
        text_add_measure(ev, out, node->a);
        text_add(ev, out, " %s ", operators[node->op]);
        text_add_measure(ev, out, node->b);
        text_add(ev, out, ")");
    }
}

// --- Into the scene ------------------------------------------------------------------------------

typedef struct Flattener {
    Eval *ev;
    SceneMeasure *measure;
} Flattener;

static const char *keep_name(Flattener *f, const char *name)
{
    return name ? keep_string(f->ev, str_from(name)) : NULL;
}

static bool same_name(const char *a, const char *b)
{
    return a == b || (a && b && strcmp(a, b) == 0);
}

static bool same_leaf(const MeasureLeaf *a, const MeasureLeaf *b)
{
    const Sight *s = &a->sight, *t = &b->sight;
    return a->coverage == b->coverage && s->kind == t->kind && s->x0 == t->x0 && s->y0 == t->y0 &&
           s->x1 == t->x1 && s->y1 == t->y1 && same_name(s->camera, t->camera) &&
           same_name(s->object, t->object) &&
           memcmp(&s->origin, &t->origin, sizeof s->origin) == 0 &&
           memcmp(&s->direction, &t->direction, sizeof s->direction) == 0;
}

static uint32_t flatten_leaf(Flattener *f, const MeasureLeaf *leaf)
{
    SceneMeasure *measure = f->measure;
    for (uint32_t i = 0; i < measure->leaf_count; ++i) {
        if (same_leaf(&measure->leaves[i], leaf)) {
            return i;
        }
    }
    MeasureLeaf *copy = &measure->leaves[measure->leaf_count];
    *copy = *leaf;
    copy->sight.camera = keep_name(f, leaf->sight.camera);
    copy->sight.object = keep_name(f, leaf->sight.object);
    return measure->leaf_count++;
}

// The radiance where an object is seen is that of all rays over the part of them that see it.
static uint32_t flatten_object(Flattener *f, const MeasureLeaf *leaf)
{
    MeasureLeaf seen = *leaf;
    seen.coverage = true;
    SceneMeasure *measure = f->measure;
    uint32_t first = measure->step_count;
    measure->steps[first] = (MeasureStep){.op = MEASURE_LEAF, .a = flatten_leaf(f, leaf)};
    measure->steps[first + 1] = (MeasureStep){.op = MEASURE_LEAF, .a = flatten_leaf(f, &seen)};
    measure->steps[first + 2] = (MeasureStep){.op = MEASURE_DIVIDE, .a = first, .b = first + 1};
    measure->step_count += 3;
    return first + 2;
}

// Returns the number of the node's step. Depth: at most MEASURE_MOST_PARTS.
static uint32_t flatten(Flattener *f, const MeasureNode *node)
{
    MeasureStep step = {.op = node->op};
    memcpy(step.constant, node->constant, sizeof step.constant);
    if (node->op == MEASURE_LEAF && node->leaf.sight.object && !node->leaf.coverage) {
        return flatten_object(f, &node->leaf);
    }
    if (node->op == MEASURE_LEAF) {
        step.a = flatten_leaf(f, &node->leaf);
    } else if (node->op != MEASURE_CONSTANT) {
        step.a = flatten(f, node->a);
        step.b = node->b ? flatten(f, node->b) : node->channel;
    }
    f->measure->steps[f->measure->step_count] = step;
    return f->measure->step_count++;
}

static SceneMeasure *to_scene(Eval *ev, Value value)
{
    Arena *arena = &ev->scene->arena;
    SceneMeasure *measure = ARENA_NEW(arena, SceneMeasure);
    uint32_t size = value.measure->size;
    measure->leaves = arena_array(arena, 2 * (size_t)size, sizeof *measure->leaves);
    measure->steps = arena_array(arena, 3 * (size_t)size, sizeof *measure->steps);
    measure->channels = value.measure->channels;
    measure->unit = "";
    flatten(&(Flattener){ev, measure}, value.measure);
    return measure;
}

// --- Comparisons ---------------------------------------------------------------------------------

// The target of a measured value, and the value in its unit.
typedef struct Aim {
    Value value;
    double target[3];
    const char *unit, *what;
} Aim;

// Of a measured value and what can't be held against it.
static bool wrong_sides(Eval *ev, const char *what, Value measured, Value target, Span at)
{
    char left[DESCRIBE_SIZE], right[DESCRIBE_SIZE];
    Diag *diag = report(ev, E0405, at, "`%s` doesn't compare %s and %s", what,
                        describe_value(ev, measured, left, sizeof left),
                        describe_value(ev, target, right, sizeof right));
    if (measured.small == 3) {
        diag_note(ev->sink, diag, "`luminance(…)`, or .r, .g or .b, makes a number of it");
    }
    return false;
}

// Of a measured value and a number or color. A luminance may be compared with one in nits.
static bool aim_at_constant(Eval *ev, const char *what, Value value, Value target, Span at,
                            Aim *aim)
{
    *aim = (Aim){.value = value, .unit = ""};
    if (target.type == VALUE_COLOR && value.small == 3) {
        memcpy(aim->target, target.components, sizeof aim->target);
        return true;
    }
    bool nits = target.type == VALUE_NUMBER && target.dim == DIM_LUMINANCE && value.small == 1;
    if (!is_bare(target) && !nits) {
        return wrong_sides(ev, what, value, target, at);
    }
    aim->target[0] = aim->target[1] = aim->target[2] = target.number;
    if (nits) {
        Value factor = value_number(LUMENS_PER_WATT, DIM_NONE);
        aim->value = measure_arithmetic(ev, OP_MULTIPLY, value, factor, at);
        aim->unit = dim_info(DIM_LUMINANCE)->si_unit;
    }
    return !is_error(aim->value);
}

static void set_aim(SceneMeasure *measure, const Aim *aim, MeasureRelation relation)
{
    memcpy(measure->target, aim->target, sizeof measure->target);
    measure->unit = aim->unit;
    measure->what = aim->what;
    measure->relation = relation;
}

SceneMeasure *measure_comparison(Eval *ev, Operator op, Value a, Value b, Span at)
{
    if (op == OP_EQUAL || op == OP_NOT_EQUAL) {
        Diag *diag = report(ev, E0415, at, "a measured value is never known exactly");
        diag_note(ev->sink, diag, "write `expect a within 1%% of b`");
        return NULL;
    }
    bool below = op == OP_LESS || op == OP_LESS_EQUAL;
    Aim aim;
    if (a.type == VALUE_MEASURE && b.type == VALUE_MEASURE) {
        aim = (Aim){.value = measure_arithmetic(ev, OP_SUBTRACT, a, b, at),
                    .unit = "",
                    .what = "the difference"};
        if (is_error(aim.value)) {
            return NULL;
        }
    } else if (b.type == VALUE_MEASURE) {
        below = !below;
        if (!aim_at_constant(ev, operator_text(op), b, a, at, &aim)) {
            return NULL;
        }
    } else if (!aim_at_constant(ev, operator_text(op), a, b, at, &aim)) {
        return NULL;
    }
    SceneMeasure *measure = to_scene(ev, aim.value);
    set_aim(measure, &aim, below ? MEASURE_BELOW : MEASURE_ABOVE);
    return measure;
}

// Both sides, or the target alone, are measured: their ratio is held against 1, or their difference
// against 0.
static bool aim_at_measure(Eval *ev, const Within *within, Aim *aim)
{
    Operator op = within->is_percentage ? OP_DIVIDE : OP_SUBTRACT;
    *aim = (Aim){.value = measure_arithmetic(ev, op, within->value, within->target, within->at),
                 .unit = "",
                 .what = within->is_percentage ? "the ratio" : "the difference"};
    for (int i = 0; i < 3; ++i) {
        aim->target[i] = within->is_percentage ? 1 : 0;
    }
    return !is_error(aim->value);
}

static bool tolerance_suits(Eval *ev, const Within *within)
{
    uint8_t wanted = within->target.type == VALUE_NUMBER ? within->target.dim : DIM_NONE;
    if (!within->is_percentage && within->tolerance.dim != wanted) {
        char found[DESCRIBE_SIZE];
        report(ev, E0402, within->tolerance_at, "the tolerance is %s, but the values have %s%s",
               describe_value(ev, within->tolerance, found, sizeof found),
               wanted == DIM_NONE ? "no unit" : "the dimension ",
               wanted == DIM_NONE ? "" : dim_info((Dim)wanted)->name);
        return false;
    }
    if (!(within->tolerance.number > 0)) {
        report(ev, E0404, within->tolerance_at,
               "the tolerance of a measured value must be above zero");
        return false;
    }
    return true;
}

SceneMeasure *measure_within(Eval *ev, const Within *within)
{
    Aim aim;
    bool good =
        within->target.type == VALUE_MEASURE
            ? aim_at_measure(ev, within, &aim)
            : aim_at_constant(ev, "within", within->value, within->target, within->at, &aim);
    if (!good || !tolerance_suits(ev, within)) {
        return NULL;
    }
    double whole = fmax(fabs(aim.target[0]), fmax(fabs(aim.target[1]), fabs(aim.target[2])));
    if (within->is_percentage && whole == 0) {
        report(ev, E0404, within->at, "a part of 0 is 0: give the tolerance as a number");
        return NULL;
    }
    SceneMeasure *measure = to_scene(ev, aim.value);
    set_aim(measure, &aim, MEASURE_WITHIN);
    measure->allowed = within->tolerance.number;
    if (within->is_percentage) {
        measure->percentage = within->tolerance.number;
        measure->allowed *= whole / 100;
    }
    return measure;
}
