// Built-in functions of colors, transforms and shapes; noise and random numbers.
#include "base/blackbody.h"
#include "base/hash.h"
#include "base/noise.h"
#include "lang/builtins.h"
#include "lang/measure.h"

// --- Colors ----------------------------------------------------------------------------------

static bool three_numbers(Call *call, double out[3])
{
    if (call->count != 3) {
        report(call->ev, E0409, call->at, "`%s` takes three numbers, or one value to convert",
               call->name);
        return false;
    }
    for (uint32_t i = 0; i < 3; ++i) {
        if (!arg_bare(call, i, &out[i])) {
            return false;
        }
    }
    return true;
}

Value builtin_rgb(Call *call)
{
    double c[3];
    Value v = call->args[0];
    if (call->count == 1) {
        if (v.type != VALUE_VECTOR || v.small != 3 || v.dim != DIM_NONE) {
            return arg_wrong(call, 0, "three numbers or a vector of 3");
        }
        return make_color(call->ev, v.components[0], v.components[1], v.components[2]);
    }
    return three_numbers(call, c) ? make_color(call->ev, c[0], c[1], c[2]) : value_error();
}

double decode_srgb(double c)
{
    double a = fabs(c);
    return copysign(a <= 0.04045 ? a / 12.92 : pow((a + 0.055) / 1.055, 2.4), c);
}

Value builtin_srgb(Call *call)
{
    double c[3];
    Value v = call->args[0];
    if (call->count == 1) {
        if (v.type != VALUE_COLOR) {
            return arg_wrong(call, 0, "three numbers or a color");
        }
        memcpy(c, v.components, sizeof c);
    } else if (!three_numbers(call, c)) {
        return value_error();
    }
    return make_color(call->ev, decode_srgb(c[0]), decode_srgb(c[1]), decode_srgb(c[2]));
}

// Smith 1978: the hexcone.
Value builtin_hsv(Call *call)
{
    double hue, s, v;
    if (!arg_angle(call, 0, &hue) || !arg_bare(call, 1, &s) || !arg_bare(call, 2, &v)) {
        return value_error();
    }
    double sixths = hue / (PI / 3), c[3];
    for (int i = 0; i < 3; ++i) {
        double k = sixths + 5 - 2 * i;
        k -= 6 * floor(k / 6);
        c[i] = v - v * s * fmax(0, fmin(fmin(k, 4 - k), 1));
    }
    return make_color(call->ev, c[0], c[1], c[2]);
}

Value builtin_gray(Call *call)
{
    double x;
    return arg_bare(call, 0, &x) ? make_color(call->ev, x, x, x) : value_error();
}

Value builtin_blackbody(Call *call)
{
    double temperature, c[3];
    uint8_t dim;
    if (!arg_number(call, 0, &temperature, &dim)) {
        return value_error();
    }
    if (dim != DIM_NONE && dim != DIM_TEMPERATURE) {
        return arg_wrong(call, 0, "a temperature");
    }
    if (!(temperature >= 300 && temperature <= 1e6)) {
        return fail(
            report(call->ev, E0404, arg_span(call, 0), "`blackbody` takes 300K to 1000000K"));
    }
    blackbody_color(temperature, c);
    return make_color(call->ev, c[0], c[1], c[2]);
}

Value builtin_luminance(Call *call)
{
    Value v = call->args[0];
    if (v.type == VALUE_MEASURE && v.small == 3) {
        return measure_luminance(call->ev, v, call->at);
    }
    if (v.type != VALUE_COLOR) {
        return arg_wrong(call, 0, "a color");
    }
    const double *c = v.components;
    return value_number(0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2], DIM_NONE);
}

// --- Transforms ------------------------------------------------------------------------------

static bool is_length(uint8_t dim)
{
    return dim == DIM_NONE || dim == DIM_LENGTH;
}

// A vector of 3, or three numbers; lengths where `lengths`.
static bool vector_or_three(Call *call, bool lengths, Vec3 *out)
{
    double x[3];
    uint8_t dim;
    if (call->count == 1) {
        if (!arg_vec3(call, 0, out)) {
            return false;
        }
        dim = call->args[0].dim;
        if (dim != DIM_NONE && !(lengths && is_length(dim))) {
            arg_wrong(call, 0, lengths ? "lengths" : "numbers without a unit");
            return false;
        }
        return true;
    }
    if (call->count != 3) {
        report(call->ev, E0409, call->at, "`%s` takes a vector or three numbers", call->name);
        return false;
    }
    for (uint32_t i = 0; i < 3; ++i) {
        if (!arg_number(call, i, &x[i], &dim)) {
            return false;
        }
        if (dim != DIM_NONE && !(lengths && is_length(dim))) {
            arg_wrong(call, i, lengths ? "a length" : "a number without a unit");
            return false;
        }
    }
    *out = vec3(x[0], x[1], x[2]);
    return true;
}

// An invertible map, or an error.
static Value transform_result(Call *call, Affine map)
{
    Affine inverse;
    if (!affine_inverse(&map, &inverse)) {
        return fail(
            report(call->ev, E0507, call->at, "this transform is flat: it can't be undone"));
    }
    return make_transform(call->ev, &map);
}

Value builtin_translate(Call *call)
{
    Vec3 by;
    return vector_or_three(call, true, &by) ? transform_result(call, affine_translation(by))
                                            : value_error();
}

Value builtin_scale(Call *call)
{
    Vec3 by;
    if (call->count == 1 && call->args[0].type == VALUE_NUMBER) {
        double s;
        if (!arg_bare(call, 0, &s)) {
            return value_error();
        }
        by = vec3(s, s, s);
    } else if (call->count == 1 && call->args[0].type != VALUE_VECTOR) {
        return arg_wrong(call, 0, "a number or a vector of 3");
    } else if (!vector_or_three(call, false, &by)) {
        return value_error();
    }
    return transform_result(call, affine_scaling(by));
}

// Multiples of 90° are meant to be exact: cos(90°) is 6e-17 otherwise.
static Affine exact_rotation(Vec3 axis, double angle)
{
    double quarters = angle / (PI / 2);
    Affine map = affine_rotation(axis, angle);
    if (fabs(quarters - round(quarters)) < 1e-14 * fmax(1, fabs(quarters))) {
        for (int i = 0; i < 3; ++i) {
            for (int k = 0; k < 3; ++k) {
                bool whole = fabs(map.m[i][k] - round(map.m[i][k])) < 1e-14;
                map.m[i][k] = whole ? round(map.m[i][k]) : map.m[i][k];
            }
        }
    }
    return map;
}

static Value rotation_about(Call *call, Vec3 axis)
{
    double angle;
    if (!arg_angle(call, 0, &angle)) {
        return value_error();
    }
    Affine map = exact_rotation(axis, angle);
    return make_transform(call->ev, &map);
}

Value builtin_rotate_x(Call *call)
{
    return rotation_about(call, vec3(1, 0, 0));
}

Value builtin_rotate_y(Call *call)
{
    return rotation_about(call, vec3(0, 1, 0));
}

Value builtin_rotate_z(Call *call)
{
    return rotation_about(call, vec3(0, 0, 1));
}

Value builtin_rotate(Call *call)
{
    Vec3 axis;
    if (!arg_vec3(call, 1, &axis)) {
        return value_error();
    }
    double most = max_component(vec3_abs(axis));
    if (!(most > 0)) {
        return fail(report(call->ev, E0501, arg_span(call, 1), "an axis can't be zero"));
    }
    return rotation_about(call, scale(axis, 1 / most));
}

Value builtin_look_at(Call *call)
{
    Vec3 eye, target, up = {0, 1, 0};
    Affine map;
    if (!arg_vec3(call, 0, &eye) || !arg_vec3(call, 1, &target) ||
        (call->count > 2 && !arg_vec3(call, 2, &up))) {
        return value_error();
    }
    if (!affine_look_at(eye, target, up, &map)) {
        return fail(
            report(call->ev, E0507, call->at, "eye and target must differ, and not lie along up"));
    }
    return make_transform(call->ev, &map);
}

Value builtin_matrix(Call *call)
{
    Affine map;
    if (call->count != 3 && call->count != 12) {
        return fail(
            report(call->ev, E0409, call->at, "`matrix` takes three rows of 4, or 12 numbers"));
    }
    for (uint32_t i = 0; i < 3 && call->count == 3; ++i) {
        Value row;
        if (!arg_vector(call, i, 4, &row)) {
            return value_error();
        }
        memcpy(map.m[i], row.components, sizeof map.m[i]);
    }
    for (uint32_t i = 0; i < 12 && call->count == 12; ++i) {
        if (!arg_bare(call, i, &map.m[i / 4][i % 4])) {
            return value_error();
        }
    }
    return transform_result(call, map);
}

// --- Bounds ----------------------------------------------------------------------------------

typedef enum BoundsResult { BOUNDS_GOOD, BOUNDS_UNKNOWN, BOUNDS_DEEP, BOUNDS_STOPPED } BoundsResult;

static BoundsResult add_bounds(Eval *ev, const NodeValue *node, const Affine *outer, Box3 *box,
                               Span at)
{
    const NodeType *type = ev->kinds[node->type].type;
    if (stack_is_deep(ev)) {
        return BOUNDS_DEEP;
    }
    if (!count_step(ev, at)) {
        return BOUNDS_STOPPED;
    }
    Affine map = node->transform ? affine_multiply(outer, node->transform) : *outer;
    if (type->role == ROLE_INSTANCE) {
        return add_bounds(ev, node->of, &map, box, at);
    }
    for (uint32_t i = 0; type->role == ROLE_GROUP && i < node->item_count; ++i) {
        BoundsResult result = add_bounds(ev, node->items[i].node, &map, box, at);
        if (result != BOUNDS_GOOD) {
            return result;
        }
    }
    if (type->role != ROLE_PLAIN || type->category != CATEGORY_SHAPE) {
        return BOUNDS_GOOD; // lights and cameras take no room
    }
    must_be_alone(ev); // a mesh lies in the scene
    Box3 own = type->bounds ? type->bounds(ev->scene, node->params) : box3_empty();
    bool finite = vec3_is_finite(own.min) && vec3_is_finite(own.max);
    if (!finite) {
        return BOUNDS_UNKNOWN;
    }
    *box = box3_union(*box, transform_box(&map, own));
    return BOUNDS_GOOD;
}

static Value make_bounds(Eval *ev, Box3 box)
{
    Box3 *copy = arena_alloc(ev->arena, sizeof *copy);
    *copy = box;
    return (Value){.type = VALUE_BOUNDS, .bounds = copy};
}

static Value bounds_between(Call *call)
{
    Box3 box;
    if (!arg_vec3(call, 0, &box.min) || !arg_vec3(call, 1, &box.max)) {
        return value_error();
    }
    for (uint32_t i = 0; i < 2; ++i) {
        if (!is_length(call->args[i].dim)) {
            return arg_wrong(call, i, "lengths");
        }
    }
    if (box3_is_empty(box)) {
        return fail(report(call->ev, E0404, call->at,
                           "no coordinate of the first corner may be above the second's"));
    }
    return make_bounds(call->ev, box);
}

Value builtin_contains(Call *call)
{
    Value outer = call->args[0], x = call->args[1];
    if (outer.type != VALUE_BOUNDS) {
        return arg_wrong(call, 0, "bounds");
    }
    Box3 inner;
    if (x.type == VALUE_BOUNDS) {
        inner = *x.bounds;
    } else if (x.type == VALUE_VECTOR && x.small == 3 && is_length(x.dim)) {
        const double *c = x.components;
        inner.min = inner.max = vec3(c[0], c[1], c[2]);
    } else {
        return arg_wrong(call, 1, "a point or bounds");
    }
    return value_bool(box3_equal(box3_union(*outer.bounds, inner), *outer.bounds));
}

Value builtin_bounds(Call *call)
{
    Eval *ev = call->ev;
    Value v = call->args[0];
    if (call->count == 2) {
        return bounds_between(call);
    }
    if (v.type != VALUE_NODE || ev->kinds[v.node->type].type->category != CATEGORY_SHAPE) {
        return arg_wrong(call, 0, "a shape");
    }
    Affine identity = affine_identity();
    Box3 box = box3_empty();
    BoundsResult result = add_bounds(ev, v.node, &identity, &box, call->at);
    if (result == BOUNDS_STOPPED) {
        return value_error();
    }
    if (result == BOUNDS_DEEP) {
        report_deep_stack(ev, call->at);
        return value_error();
    }
    if (result == BOUNDS_UNKNOWN || box3_is_empty(box)) {
        return fail(report(ev, E0508, arg_span(call, 0),
                           result == BOUNDS_UNKNOWN ? "a part of this shape has no end, so there "
                                                      "is no box around it"
                                                    : "there is no shape in this"));
    }
    return make_bounds(ev, box);
}

// --- Noise and random numbers ----------------------------------------------------------------

Value builtin_noise(Call *call)
{
    Value v = call->args[0];
    if (!count_step(call->ev, call->at)) {
        return value_error();
    }
    if (is_bare(v)) {
        return value_number(noise3(vec3(v.number, 0, 0)), DIM_NONE);
    }
    if (v.type != VALUE_VECTOR || v.small > 3 || !is_length(v.dim)) {
        return arg_wrong(call, 0, "a number or a vector of 2 or 3");
    }
    const double *c = v.components;
    return value_number(noise3(vec3(c[0], c[1], v.small > 2 ? c[2] : 0)), DIM_NONE);
}

static uint64_t hash_double(uint64_t hash, double number)
{
    uint64_t bits;
    number = number == 0 ? 0 : number; // -0 is 0
    memcpy(&bits, &number, sizeof bits);
    return hash_u64(hash ^ bits);
}

// False for values that have no content to hash, and when the limit of steps is crossed.
static bool hash_value(Eval *ev, Value v, Span at, uint64_t *hash)
{
    *hash = hash_u64(*hash ^ ((uint64_t)v.type << 8 | v.dim));
    switch ((ValueType)v.type) {
    case VALUE_NUMBER:
        *hash = hash_double(*hash, v.number);
        return true;
    case VALUE_BOOL:
        *hash = hash_u64(*hash ^ v.boolean);
        return true;
    case VALUE_STRING:
        if (!count_steps(ev, v.count / BYTES_A_STEP, at)) {
            return false;
        }
        for (uint32_t i = 0; i < v.count; ++i) {
            *hash = hash_u64(*hash ^ (unsigned char)v.string[i]);
        }
        return true;
    case VALUE_VECTOR:
    case VALUE_COLOR:
        for (int i = 0; i < v.small; ++i) {
            *hash = hash_double(*hash, v.components[i]);
        }
        return true;
    case VALUE_LIST:
        for (uint32_t i = 0; i < v.count; ++i) {
            if (stack_is_deep(ev)) {
                return report_deep_stack(ev, at);
            }
            if (!count_step(ev, at) || !hash_value(ev, v.items[i], at, hash)) {
                return false;
            }
        }
        return true;
    default:
        return false;
    }
}

Value builtin_random(Call *call)
{
    uint64_t hash = call->count;
    for (uint32_t i = 0; i < call->count; ++i) {
        if (!hash_value(call->ev, call->args[i], call->at, &hash)) {
            return call->ev->stop
                       ? value_error()
                       : arg_wrong(call, i, "numbers, strings, vectors, colors or lists of them");
        }
    }
    return value_number((double)(hash >> 11) * 0x1p-53, DIM_NONE);
}
