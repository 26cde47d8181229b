// Operators, and what they do to dimensions (language.md, section 4): + - < == want equal ones, a
// bare number scales anything, a ratio of equals is bare.
#include "lang/measure.h"

#include <stdio.h>

Value make_vector(Eval *ev, const double *components, int count, uint8_t dim)
{
    double *copy = arena_alloc(ev->arena, 4 * sizeof *copy);
    for (int i = 0; i < 4; ++i) {
        copy[i] = i < count ? components[i] : 0;
    }
    return (Value){.type = VALUE_VECTOR, .dim = dim, .small = (uint16_t)count, .components = copy};
}

Value make_color(Eval *ev, double r, double g, double b)
{
    Value color = make_vector(ev, (const double[]){r, g, b}, 3, DIM_NONE);
    color.type = VALUE_COLOR;
    return color;
}

Value make_transform(Eval *ev, const Affine *map)
{
    Affine *copy = arena_alloc(ev->arena, sizeof *copy);
    *copy = *map;
    return (Value){.type = VALUE_TRANSFORM, .transform = copy};
}

Value make_string(Eval *ev, Str text, uint32_t module)
{
    return (Value){.type = VALUE_STRING,
                   .small = (uint16_t)module,
                   .count = (uint32_t)text.length,
                   .string = arena_copy_string(ev->arena, text.at, text.length)};
}

// --- Reports ---------------------------------------------------------------------------------

static Value wrong_operands(Eval *ev, Operator op, Value a, Value b, Span at)
{
    char left[DESCRIBE_SIZE], right[DESCRIBE_SIZE];
    describe_value(ev, a, left, sizeof left);
    describe_value(ev, b, right, sizeof right);
    Diag *diag =
        report(ev, E0405, at, "`%s` doesn't take %s and %s", operator_text(op), left, right);
    bool vectors = a.type == VALUE_VECTOR && b.type == VALUE_VECTOR;
    bool mixed = (a.type == VALUE_VECTOR && b.type == VALUE_COLOR) ||
                 (a.type == VALUE_COLOR && b.type == VALUE_VECTOR);
    if (vectors && op == OP_MULTIPLY) {
        diag_label(ev->sink, diag, "dot(a, b) or cross(a, b)?");
    } else if (mixed) {
        diag_note(ev->sink, diag, "a vector is not a color; `rgb(v)` makes one of it");
    } else if (a.type == VALUE_LIST && b.type == VALUE_LIST && op == OP_ADD) {
        diag_label(ev->sink, diag, "concat(a, b) joins lists");
    } else if (op == OP_ADD && (a.type == VALUE_STRING || b.type == VALUE_STRING)) {
        diag_label(ev->sink, diag, "str(…) makes text of a value");
    }
    return fail(diag);
}

static Value wrong_dims(Eval *ev, Operator op, Value a, Value b, Span at)
{
    char left[DESCRIBE_SIZE], right[DESCRIBE_SIZE];
    describe_value(ev, a, left, sizeof left);
    describe_value(ev, b, right, sizeof right);
    bool is_product = op == OP_MULTIPLY || op == OP_DIVIDE || op == OP_POWER;
    Diag *diag = report(ev, E0402, at,
                        is_product ? "`%s` has no meaning for %s and %s"
                                   : "`%s` doesn't take %s and %s: their dimensions differ",
                        operator_text(op), left, right);
    if (op == OP_POWER) {
        diag_note(ev->sink, diag, "powers are of numbers without a unit");
    } else if (is_product) {
        diag_note(ev->sink, diag,
                  "a number without a unit scales anything, and a ratio of equals has no unit; "
                  "products of quantities have no meaning here");
    } else if (a.dim == DIM_NONE || b.dim == DIM_NONE) {
        Dim dim = (Dim)(a.dim + b.dim);
        diag_note(ev->sink, diag, "give both a unit, as in 1%s",
                  dim == DIM_ANGLE ? "deg" : dim_info(dim)->si_unit);
    }
    return fail(diag);
}

static Value not_finite(Eval *ev, Operator op, Value b, Span at)
{
    if ((op == OP_DIVIDE || op == OP_MODULO) && b.number == 0) { // by a number, always
        return fail(report(ev, E0501, at, "division by zero"));
    }
    return fail(
        report(ev, E0501, at, "the result of `%s` is not a finite number", operator_text(op)));
}

// --- Arithmetic ------------------------------------------------------------------------------

// The remainder has the sign of the divisor, so that i % n counts round for negative i, too.
static double modulo(double a, double b)
{
    double rest = fmod(a, b);
    return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
}

double operator_apply(Operator op, double a, double b)
{
    switch (op) {
    case OP_ADD:
        return a + b;
    case OP_SUBTRACT:
        return a - b;
    case OP_MULTIPLY:
        return a * b;
    case OP_DIVIDE:
        return a / b;
    case OP_MODULO:
        return modulo(a, b);
    default:
        return pow(a, b);
    }
}

bool operator_dim(Operator op, uint8_t a, uint8_t b, uint8_t *out)
{
    switch (op) {
    case OP_ADD:
    case OP_SUBTRACT:
    case OP_MODULO:
        *out = a;
        return a == b;
    case OP_MULTIPLY:
        *out = a ? a : b;
        return a == DIM_NONE || b == DIM_NONE;
    case OP_DIVIDE:
        *out = a == b ? DIM_NONE : a;
        return a == b || b == DIM_NONE;
    default: // power
        *out = DIM_NONE;
        return a == DIM_NONE && b == DIM_NONE;
    }
}

static Value number_operation(Eval *ev, Operator op, Value a, Value b, Span at)
{
    uint8_t dim;
    if (!operator_dim(op, a.dim, b.dim, &dim)) {
        return wrong_dims(ev, op, a, b, at);
    }
    double number = operator_apply(op, a.number, b.number);
    return isfinite(number) ? value_number(number, dim) : not_finite(ev, op, b, at);
}

// Vectors and colors: + and - with their like; * with a number on either side; / by a number;
// colors * colors, too.
static bool takes_components(Operator op, Value a, Value b)
{
    bool left = a.type != VALUE_NUMBER, right = b.type != VALUE_NUMBER;
    if (left && right) {
        bool alike = a.type == b.type && (a.type == VALUE_COLOR || a.small == b.small);
        return alike &&
               (op == OP_ADD || op == OP_SUBTRACT || (op == OP_MULTIPLY && a.type == VALUE_COLOR));
    }
    return op == OP_MULTIPLY || (op == OP_DIVIDE && left);
}

static Value component_operation(Eval *ev, Operator op, Value a, Value b, Span at)
{
    uint8_t dim;
    if (!takes_components(op, a, b)) {
        return wrong_operands(ev, op, a, b, at);
    }
    if (!operator_dim(op, a.dim, b.dim, &dim)) {
        return wrong_dims(ev, op, a, b, at);
    }
    Value like = a.type != VALUE_NUMBER ? a : b;
    if (like.type == VALUE_COLOR && dim != DIM_NONE) {
        return wrong_operands(ev, op, a, b, at);
    }
    double out[4] = {0};
    for (int i = 0; i < like.small; ++i) {
        double x = a.type == VALUE_NUMBER ? a.number : a.components[i];
        double y = b.type == VALUE_NUMBER ? b.number : b.components[i];
        out[i] = operator_apply(op, x, y);
        if (!isfinite(out[i])) {
            return not_finite(ev, op, b, at);
        }
    }
    Value result = make_vector(ev, out, like.small, dim);
    result.type = like.type;
    return result;
}

static bool is_texture(const Eval *ev, Value v)
{
    return v.type == VALUE_NODE &&
           ev->lang->schema->types[v.node->type]->category == CATEGORY_TEXTURE;
}

static bool is_texture_operand(const Eval *ev, Value v)
{
    return is_texture(ev, v) || is_bare(v) || v.type == VALUE_COLOR;
}

static bool has_components(Value v)
{
    return v.type == VALUE_VECTOR || v.type == VALUE_COLOR;
}

static Value join_strings(Eval *ev, Value a, Value b, Span at)
{
    size_t length = (size_t)a.count + b.count;
    if (!count_steps(ev, length / BYTES_A_STEP, at)) {
        return value_error();
    }
    char *text = arena_alloc(ev->arena, length + 1);
    memcpy(text, a.string, a.count);
    memcpy(text + a.count, b.string, b.count);
    text[length] = '\0';
    if (length > UINT32_MAX) { // excepted: that takes a string of 4 GiB
        out_of_memory(ev);
    }
    return (Value){
        .type = VALUE_STRING, .small = a.small, .count = (uint32_t)length, .string = text};
}

static Value arithmetic(Eval *ev, Operator op, Value a, Value b, Where where)
{
    Span at = where_span(where);
    if (a.type == VALUE_NUMBER && b.type == VALUE_NUMBER) {
        return number_operation(ev, op, a, b, at);
    }
    if ((has_components(a) || a.type == VALUE_NUMBER) &&
        (has_components(b) || b.type == VALUE_NUMBER)) {
        return component_operation(ev, op, a, b, at);
    }
    if (op == OP_ADD && a.type == VALUE_STRING && b.type == VALUE_STRING) {
        return join_strings(ev, a, b, at);
    }
    if (a.type == VALUE_MEASURE || b.type == VALUE_MEASURE) {
        return measure_arithmetic(ev, op, a, b, at);
    }
    bool textures = (is_texture(ev, a) || is_texture(ev, b)) && is_texture_operand(ev, a) &&
                    is_texture_operand(ev, b);
    if (textures && ev->texture_math >= 0 &&
        (op == OP_ADD || op == OP_SUBTRACT || op == OP_MULTIPLY)) {
        const char *name = op == OP_ADD ? "add" : op == OP_SUBTRACT ? "subtract" : "multiply";
        return texture_arithmetic(ev, name, a, b, where);
    }
    return wrong_operands(ev, op, a, b, at);
}

Value add_values(Eval *ev, Value a, Value b, Span at)
{
    if (a.type == VALUE_NUMBER && b.type == VALUE_NUMBER) {
        return number_operation(ev, OP_ADD, a, b, at);
    }
    return has_components(a) && has_components(b) ? component_operation(ev, OP_ADD, a, b, at)
                                                  : wrong_operands(ev, OP_ADD, a, b, at);
}

// --- Comparison ------------------------------------------------------------------------------

int compare_values(Value a, Value b)
{
    if (a.type == VALUE_NUMBER && b.type == VALUE_NUMBER && a.dim == b.dim) {
        return (a.number > b.number) - (a.number < b.number);
    }
    if (a.type == VALUE_STRING && b.type == VALUE_STRING) {
        uint32_t shorter = a.count < b.count ? a.count : b.count;
        int order = memcmp(a.string, b.string, shorter);
        order = order ? order : (a.count > b.count) - (a.count < b.count);
        return (order > 0) - (order < 0);
    }
    return 2;
}

bool count_comparison(Eval *ev, Value a, Value b, Span at)
{
    bool strings = a.type == VALUE_STRING && b.type == VALUE_STRING;
    uint32_t shorter = a.count < b.count ? a.count : b.count;
    return !strings || count_steps(ev, shorter / BYTES_A_STEP, at);
}

static bool sequences_equal(Eval *ev, Value a, Value b, Span at)
{
    if (stack_is_deep(ev)) {
        return report_deep_stack(ev, at);
    }
    if (a.count != b.count || !count_values(ev, a.count, at)) {
        return false;
    }
    for (uint32_t i = 0; i < a.count; ++i) {
        if (!values_equal(ev, sequence_item(a, i), sequence_item(b, i), at)) {
            return false;
        }
    }
    return true;
}

bool values_equal(Eval *ev, Value a, Value b, Span at)
{
    bool sequences = (a.type == VALUE_LIST || a.type == VALUE_RANGE) &&
                     (b.type == VALUE_LIST || b.type == VALUE_RANGE);
    if (sequences) {
        return sequences_equal(ev, a, b, at);
    }
    if (a.type != b.type || a.dim != b.dim) {
        return false;
    }
    switch ((ValueType)a.type) {
    case VALUE_BOOL:
        return a.boolean == b.boolean;
    case VALUE_VECTOR:
    case VALUE_COLOR:
        return a.small == b.small && a.components[0] == b.components[0] &&
               a.components[1] == b.components[1] && a.components[2] == b.components[2] &&
               a.components[3] == b.components[3];
    case VALUE_TRANSFORM:
        return memcmp(a.transform, b.transform, sizeof *a.transform) == 0;
    case VALUE_BOUNDS:
        return box3_equal(*a.bounds, *b.bounds);
    case VALUE_NODE:
        return a.node == b.node;
    default:
        return count_comparison(ev, a, b, at) && compare_values(a, b) == 0;
    }
}

static bool can_be_equal(Value v)
{
    return v.type != VALUE_FUNCTION && v.type != VALUE_BUILTIN && v.type != VALUE_NODE;
}

static Value equality(Eval *ev, Operator op, Value a, Value b, Span at)
{
    bool sequences = (a.type == VALUE_LIST || a.type == VALUE_RANGE) &&
                     (b.type == VALUE_LIST || b.type == VALUE_RANGE);
    if (!can_be_equal(a) || (a.type != b.type && !sequences)) {
        return wrong_operands(ev, op, a, b, at);
    }
    if (a.dim != b.dim) {
        return wrong_dims(ev, op, a, b, at);
    }
    bool equal = values_equal(ev, a, b, at);
    return ev->stop ? value_error() : value_bool(equal == (op == OP_EQUAL));
}

static Value ordering(Eval *ev, Operator op, Value a, Value b, Span at)
{
    if (!count_comparison(ev, a, b, at)) {
        return value_error();
    }
    int order = compare_values(a, b);
    if (order == 2) {
        return a.type == VALUE_NUMBER && b.type == VALUE_NUMBER ? wrong_dims(ev, op, a, b, at)
                                                                : wrong_operands(ev, op, a, b, at);
    }
    return value_bool(op == OP_LESS         ? order < 0
                      : op == OP_LESS_EQUAL ? order <= 0
                      : op == OP_GREATER    ? order > 0
                                            : order >= 0);
}

Value compare_operands(Eval *ev, Operator op, Value a, Value b, Span at)
{
    if (a.type == VALUE_MEASURE || b.type == VALUE_MEASURE) {
        Diag *diag = report(ev, E0415, at, "what is measured is not known while the scene is made");
        diag_note(ev->sink, diag, "an `expect` may compare it, by itself: `expect a < b`");
        return fail(diag);
    }
    return op == OP_EQUAL || op == OP_NOT_EQUAL ? equality(ev, op, a, b, at)
                                                : ordering(ev, op, a, b, at);
}

// --- Evaluation of the nodes -----------------------------------------------------------------

static Value logic(Eval *ev, Env *env, const AstNode *node)
{
    const char *what = node->op == OP_AND ? "`and`" : "`or`";
    Truth left = eval_condition(ev, env, node->a, what);
    if (left == TRUTH_ERROR) {
        return value_error();
    }
    if (left == (node->op == OP_AND ? TRUTH_FALSE : TRUTH_TRUE)) {
        return value_bool(left == TRUTH_TRUE);
    }
    Truth right = eval_condition(ev, env, node->b, what);
    return right == TRUTH_ERROR ? value_error() : value_bool(right == TRUTH_TRUE);
}

Value eval_binary(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    Operator op = (Operator)node->op;
    if (op == OP_AND || op == OP_OR) {
        return logic(ev, env, node);
    }
    Value a = eval(ev, env, node->a), b = eval(ev, env, node->b);
    if (is_error(a) || is_error(b)) {
        return value_error();
    }
    if (is_bare(a) && is_bare(b)) { // by far the most frequent
        double number = op == OP_ADD        ? a.number + b.number
                        : op == OP_SUBTRACT ? a.number - b.number
                        : op == OP_MULTIPLY ? a.number * b.number
                                            : NAN;
        if (isfinite(number)) {
            return value_number(number, DIM_NONE);
        }
    }
    switch (op) {
    case OP_EQUAL:
    case OP_NOT_EQUAL:
    case OP_LESS:
    case OP_LESS_EQUAL:
    case OP_GREATER:
    case OP_GREATER_EQUAL:
        return compare_operands(ev, op, a, b, env_span(env, id));
    default:
        return arithmetic(ev, op, a, b, (Where){env->module, id});
    }
}

Value eval_unary(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    if (node->op == OP_NOT) {
        Truth truth = eval_condition(ev, env, node->a, "`not`");
        return truth == TRUTH_ERROR ? value_error() : value_bool(truth == TRUTH_FALSE);
    }
    Value v = eval(ev, env, node->a);
    if (v.type == VALUE_NUMBER) {
        v.number = -v.number;
        return v;
    }
    if (v.type == VALUE_VECTOR) {
        const double *c = v.components;
        return make_vector(ev, (const double[]){-c[0], -c[1], -c[2], -c[3]}, v.small, v.dim);
    }
    if (v.type == VALUE_MEASURE) {
        return measure_arithmetic(ev, OP_MULTIPLY, v, value_number(-1, DIM_NONE),
                                  env_span(env, id));
    }
    if (is_error(v)) {
        return v;
    }
    char found[DESCRIBE_SIZE];
    return fail(report(ev, E0405, env_span(env, id), "`-` doesn't take %s",
                       describe_value(ev, v, found, sizeof found)));
}

void report_not_whole(Eval *ev, Span at, const char *rule, Value v)
{
    char found[DESCRIBE_SIZE];
    TextBuffer text = {0};
    if (v.type == VALUE_NUMBER) {
        text_add_value(ev, &text, v, true);
    } else {
        text_add(ev, &text, "%s", describe_value(ev, v, found, sizeof found));
    }
    report(ev, E0412, at, "%s, this is %s", rule, text.text);
}

static bool range_end(Eval *ev, Env *env, AstId id, double *out)
{
    Value v = eval(ev, env, id);
    if (is_bare(v) && v.number == floor(v.number) && fabs(v.number) <= 0x1p53) {
        *out = v.number;
        return true;
    }
    if (!is_error(v)) {
        report_not_whole(ev, env_span(env, id), "the ends of a range are whole numbers", v);
    }
    return false;
}

bool check_list_length(Eval *ev, const char *what, double count, Span at)
{
    const uint64_t limit = ev->lang->limits.list_length;
    if (count <= (double)limit && count < UINT32_MAX) {
        return true;
    }
    Diag *diag = report(ev, E0706, at, "a %s of %.15g items is too long", what, count);
    if (limit < UINT32_MAX) {
        diag_note(ev->sink, diag, "--limit list_length=N raises the limit of %llu",
                  (unsigned long long)limit);
    }
    return false;
}

Value eval_range(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    double first, last;
    bool ends = range_end(ev, env, node->a, &first);
    if (!range_end(ev, env, node->b, &last) || !ends) {
        return value_error();
    }
    double count = fmax(0, last - first + (node->aux ? 0 : 1));
    if (!check_list_length(ev, "range", count, env_span(env, id))) {
        return value_error();
    }
    return (Value){.type = VALUE_RANGE, .count = (uint32_t)count, .number = first};
}

static Value wrong_component(Eval *ev, Env *env, AstId id, Value v)
{
    char found[DESCRIBE_SIZE];
    return fail(report(ev, E0405, env_span(env, id), "a vector is made of numbers, this is %s",
                       describe_value(ev, v, found, sizeof found)));
}

// All components have one dimension; a bare 0 takes that of the others, since nothing is nothing
// in any unit.
Value eval_vector(Eval *ev, Env *env, AstId id)
{
    uint32_t list = env_node(env, id)->a;
    uint32_t count = *env_words(env, list);
    double components[4] = {0};
    Value first = {0}; // the first that says a dimension
    bool bad = false;
    for (uint32_t i = 0; i < count; ++i) { // at most 4, by the parser
        AstId item = env_words(env, list)[1 + i];
        Value v = eval(ev, env, item);
        if (v.type != VALUE_NUMBER) {
            bad = true;
            if (!is_error(v)) {
                wrong_component(ev, env, item, v);
            }
            continue;
        }
        components[i] = v.number;
        if (v.dim == DIM_NONE && v.number == 0) {
            continue;
        }
        if (first.type == VALUE_UNSET) {
            first = v;
        } else if (v.dim != first.dim) {
            char one[DESCRIBE_SIZE], two[DESCRIBE_SIZE];
            report(ev, E0402, env_span(env, item),
                   "the components of a vector have one dimension, not %s and %s",
                   describe_value(ev, first, one, sizeof one),
                   describe_value(ev, v, two, sizeof two));
            bad = true;
        }
    }
    return bad ? value_error() : make_vector(ev, components, (int)count, first.dim);
}
