// Built-in functions of numbers and vectors.
#include "lang/builtins.h"

// --- Numbers ---------------------------------------------------------------------------------

static Value unary(Call *call, double (*f)(double))
{
    double x;
    return arg_bare(call, 0, &x) ? number_result(call, f(x), DIM_NONE) : value_error();
}

Value builtin_abs(Call *call)
{
    double x;
    uint8_t dim;
    return arg_number(call, 0, &x, &dim) ? value_number(fabs(x), dim) : value_error();
}

Value builtin_sign(Call *call)
{
    double x;
    uint8_t dim;
    return arg_number(call, 0, &x, &dim) ? value_number((x > 0) - (x < 0), DIM_NONE)
                                         : value_error();
}

Value builtin_floor(Call *call)
{
    return unary(call, floor);
}

Value builtin_ceil(Call *call)
{
    return unary(call, ceil);
}

Value builtin_round(Call *call)
{
    return unary(call, round);
}

double fraction(double x)
{
    double f = x - floor(x);
    return f < 1 ? f : 0; // -1e-20 rounds to 1
}

Value builtin_fract(Call *call)
{
    return unary(call, fraction);
}

Value builtin_sqrt(Call *call)
{
    double x;
    if (!arg_bare(call, 0, &x)) {
        return value_error();
    }
    if (x < 0) {
        return fail(
            report(call->ev, E0501, arg_span(call, 0), "the square root of a negative number"));
    }
    return value_number(sqrt(x), DIM_NONE);
}

Value builtin_exp(Call *call)
{
    return unary(call, exp);
}

Value builtin_log(Call *call)
{
    return unary(call, log);
}

Value builtin_log2(Call *call)
{
    return unary(call, log2);
}

Value builtin_log10(Call *call)
{
    return unary(call, log10);
}

Value builtin_pow(Call *call)
{
    double x, y;
    return arg_bare(call, 0, &x) && arg_bare(call, 1, &y) ? number_result(call, pow(x, y), DIM_NONE)
                                                          : value_error();
}

Value builtin_mod(Call *call)
{
    double x, y;
    uint8_t a, b;
    if (!arg_number(call, 0, &x, &a) || !arg_number(call, 1, &y, &b) || !same_dim(call, 1, a, b)) {
        return value_error();
    }
    double rest = fmod(x, y);
    return number_result(call, rest != 0 && (rest < 0) != (y < 0) ? rest + y : rest, a);
}

// The least (sign = 1) or greatest (-1) of the arguments, or of the items of the only one.
static Value extreme(Call *call, double sign)
{
    const Value *items = call->args;
    uint32_t count = call->count;
    Value list = call->args[0];
    bool is_list = count == 1 && (list.type == VALUE_LIST || list.type == VALUE_RANGE);
    if (is_list && list.count == 0) {
        arg_wrong(call, 0, "at least one number");
        return value_error();
    }
    count = is_list ? list.count : count;
    if (!count_values(call->ev, count, call->at)) {
        return value_error();
    }
    Value best = {0};
    for (uint32_t i = 0; i < count; ++i) {
        Value v = is_list ? sequence_item(list, i) : items[i];
        if (v.type != VALUE_NUMBER) {
            return arg_wrong(call, is_list ? 0 : i, is_list ? "a list of numbers" : "a number");
        }
        if (i > 0 && !same_dim(call, is_list ? 0 : i, best.dim, v.dim)) {
            return value_error();
        }
        best = i == 0 || (v.number - best.number) * sign < 0 ? v : best;
    }
    return best;
}

Value builtin_min(Call *call)
{
    return extreme(call, 1);
}

Value builtin_max(Call *call)
{
    return extreme(call, -1);
}

// Three numbers of one dimension.
static bool three(Call *call, double x[3], uint8_t *dim)
{
    uint8_t dims[3];
    for (uint32_t i = 0; i < 3; ++i) {
        if (!arg_number(call, i, &x[i], &dims[i]) ||
            (i > 0 && !same_dim(call, i, dims[0], dims[i]))) {
            return false;
        }
    }
    *dim = dims[0];
    return true;
}

Value builtin_clamp(Call *call)
{
    double x[3];
    uint8_t dim;
    if (!three(call, x, &dim)) {
        return value_error();
    }
    if (x[1] > x[2]) {
        return fail(report(call->ev, E0410, call->at, "`clamp` takes low before high"));
    }
    return value_number(fmin(fmax(x[0], x[1]), x[2]), dim);
}

Value builtin_mix(Call *call)
{
    double t;
    Value a = call->args[0], b = call->args[1];
    bool alike = a.type == b.type && (a.type == VALUE_NUMBER || a.type == VALUE_COLOR ||
                                      (a.type == VALUE_VECTOR && a.small == b.small));
    if (!alike) {
        return arg_wrong(call, 1, "two numbers, vectors or colors");
    }
    if (!arg_bare(call, 2, &t) || !same_dim(call, 1, a.dim, b.dim)) {
        return value_error();
    }
    if (a.type == VALUE_NUMBER) {
        return number_result(call, a.number * (1 - t) + b.number * t, a.dim);
    }
    double out[4] = {0};
    for (int i = 0; i < a.small; ++i) {
        out[i] = a.components[i] * (1 - t) + b.components[i] * t;
    }
    Value v = make_vector(call->ev, out, a.small, a.dim);
    v.type = a.type;
    return v;
}

Value builtin_lerp(Call *call)
{
    return builtin_mix(call);
}

Value builtin_step(Call *call)
{
    double edge, x;
    uint8_t a, b;
    if (!arg_number(call, 0, &edge, &a) || !arg_number(call, 1, &x, &b) ||
        !same_dim(call, 1, a, b)) {
        return value_error();
    }
    return value_number(x < edge ? 0 : 1, DIM_NONE);
}

Value builtin_smoothstep(Call *call)
{
    double x[3];
    uint8_t dim;
    if (!three(call, x, &dim)) {
        return value_error();
    }
    if (x[0] == x[1]) {
        return fail(report(call->ev, E0501, call->at, "`smoothstep` takes two different edges"));
    }
    double t = fmin(fmax((x[2] - x[0]) / (x[1] - x[0]), 0), 1);
    return value_number(t * t * (3 - 2 * t), DIM_NONE);
}

Value builtin_hypot(Call *call)
{
    double x[3] = {0};
    uint8_t dims[3] = {0};
    for (uint32_t i = 0; i < call->count; ++i) {
        if (!arg_number(call, i, &x[i], &dims[i]) || !same_dim(call, i, dims[0], dims[i])) {
            return value_error();
        }
    }
    return number_result(call, hypot(hypot(x[0], x[1]), x[2]), dims[0]);
}

// --- Angles ----------------------------------------------------------------------------------

static Value of_angle(Call *call, double (*f)(double))
{
    double x;
    uint8_t dim;
    if (!arg_number(call, 0, &x, &dim)) {
        return value_error();
    }
    if (dim != DIM_NONE && dim != DIM_ANGLE) {
        return arg_wrong(call, 0, "an angle, or a bare number in radians,");
    }
    return number_result(call, f(x), DIM_NONE);
}

Value builtin_sin(Call *call)
{
    return of_angle(call, sin);
}

Value builtin_cos(Call *call)
{
    return of_angle(call, cos);
}

Value builtin_tan(Call *call)
{
    return of_angle(call, tan);
}

static Value arc(Call *call, double (*f)(double), bool limited)
{
    double x;
    if (!arg_bare(call, 0, &x)) {
        return value_error();
    }
    if (limited && !(x >= -1 && x <= 1)) {
        return fail(report(call->ev, E0501, arg_span(call, 0), "`%s` takes a number in -1 … 1",
                           call->name));
    }
    return value_number(f(x), DIM_ANGLE);
}

Value builtin_asin(Call *call)
{
    return arc(call, asin, true);
}

Value builtin_acos(Call *call)
{
    return arc(call, acos, true);
}

Value builtin_atan(Call *call)
{
    return arc(call, atan, false);
}

Value builtin_atan2(Call *call)
{
    double y, x;
    uint8_t a, b;
    if (!arg_number(call, 0, &y, &a) || !arg_number(call, 1, &x, &b) || !same_dim(call, 1, a, b)) {
        return value_error();
    }
    return value_number(atan2(y, x), DIM_ANGLE);
}

// --- Vectors ---------------------------------------------------------------------------------

static bool two_vectors(Call *call, int count, Value *a, Value *b)
{
    return arg_vector(call, 0, count, a) && arg_vector(call, 1, a->small, b);
}

// Products have a dimension only where one of the factors has none.
static bool product_dim(Call *call, Value a, Value b, uint8_t *dim)
{
    *dim = a.dim ? a.dim : b.dim;
    return same_dim(call, 1, b.dim ? a.dim : DIM_NONE, DIM_NONE);
}

static double dot_product(Value a, Value b)
{
    double sum = 0;
    for (int i = 0; i < a.small; ++i) {
        sum += a.components[i] * b.components[i];
    }
    return sum;
}

static double vector_length(Value v)
{
    double sum = 0;
    for (int i = 0; i < v.small; ++i) {
        sum = hypot(sum, v.components[i]);
    }
    return sum;
}

Value builtin_dot(Call *call)
{
    Value a, b;
    uint8_t dim;
    return two_vectors(call, 0, &a, &b) && product_dim(call, a, b, &dim)
               ? number_result(call, dot_product(a, b), dim)
               : value_error();
}

Value builtin_cross(Call *call)
{
    Value a, b;
    uint8_t dim;
    if (!two_vectors(call, 3, &a, &b) || !product_dim(call, a, b, &dim)) {
        return value_error();
    }
    const double *p = a.components, *q = b.components;
    return make_vector(call->ev,
                       (const double[]){p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2],
                                        p[0] * q[1] - p[1] * q[0]},
                       3, dim);
}

Value builtin_length(Call *call)
{
    Value v;
    if (call->args[0].type == VALUE_LIST || call->args[0].type == VALUE_STRING) {
        Diag *diag =
            report(call->ev, E0410, call->at, "`length` measures vectors; `len` counts items");
        return fail(diag);
    }
    return arg_vector(call, 0, 0, &v) ? number_result(call, vector_length(v), v.dim)
                                      : value_error();
}

Value builtin_distance(Call *call)
{
    Value a, b;
    if (!two_vectors(call, 0, &a, &b) || !same_dim(call, 1, a.dim, b.dim)) {
        return value_error();
    }
    double sum = 0;
    for (int i = 0; i < a.small; ++i) {
        sum = hypot(sum, a.components[i] - b.components[i]);
    }
    return number_result(call, sum, a.dim);
}

Value builtin_normalize(Call *call)
{
    Value v;
    if (!arg_vector(call, 0, 0, &v)) {
        return value_error();
    }
    double length = vector_length(v), out[4] = {0};
    if (!(length > 0) || !isfinite(length)) {
        return fail(report(call->ev, E0501, arg_span(call, 0),
                           length > 0 ? "this vector is too long to find its direction"
                                      : "a vector of length zero has no direction"));
    }
    for (int i = 0; i < v.small; ++i) {
        out[i] = v.components[i] / length;
    }
    return make_vector(call->ev, out, v.small, DIM_NONE);
}

Value builtin_reflect(Call *call)
{
    Value v, n;
    if (!two_vectors(call, 0, &v, &n)) {
        return value_error();
    }
    double square = dot_product(n, n), out[4] = {0};
    if (!(square > 0) || !isfinite(square)) {
        return fail(report(call->ev, E0501, arg_span(call, 1),
                           vector_length(n) > 0 ? "this normal is too long or too short"
                                                : "a normal can't be zero"));
    }
    double k = 2 * dot_product(v, n) / square;
    for (int i = 0; i < v.small; ++i) {
        out[i] = v.components[i] - k * n.components[i];
    }
    return make_vector(call->ev, out, v.small, v.dim);
}
