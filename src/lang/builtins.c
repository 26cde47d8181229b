#include "lang/builtins.h"

#include <stdio.h>

const Builtin builtins[] = {
#define BUILTIN(name, least, most, signature, doc) {#name, builtin_##name, least, most},
#include "lang/builtins.def"
};
const uint32_t builtin_count = sizeof builtins / sizeof builtins[0];

static const BuiltinInfo infos[] = {
#define BUILTIN(name, least, most, signature, doc) {#name, signature, doc},
#include "lang/builtins.def"
};
const BuiltinInfo *const lang_builtins = infos;
const size_t lang_builtin_count = sizeof infos / sizeof infos[0];

const ConstantInfo lang_constants[] = {
#define CONSTANT(name, dimension, value, doc) {#name, doc, DIM_##dimension, -1, value},
#define MOMENT(name, dimension, doc)          {#name, doc, DIM_##dimension, (int)offsetof(Moment, name), 0},
#include "lang/builtins.def"
};
const size_t lang_constant_count = sizeof lang_constants / sizeof lang_constants[0];

int constant_find(Str name)
{
    for (size_t i = 0; i < lang_constant_count; ++i) {
        if (str_equal(name, str_from(lang_constants[i].name))) {
            return (int)i;
        }
    }
    return -1;
}

Value constant_value(const Eval *ev, uint32_t number)
{
    const ConstantInfo *info = &lang_constants[number];
    double value = info->value;
    if (info->moment >= 0) {
        memcpy(&value, (const char *)&ev->lang->moment + info->moment, sizeof value);
    }
    return value_number(value, (uint8_t)info->dim);
}

Value call_builtin(Eval *ev, Env *env, AstId node, Span at, uint32_t builtin, const Value *args,
                   uint32_t count)
{
    const Builtin *b = &builtins[builtin];
    if (count < b->least || (b->most != ANY_COUNT && count > b->most)) {
        Diag *diag = report(ev, E0409, at, "`%s` doesn't take %u argument%s", b->name, count,
                            count == 1 ? "" : "s");
        diag_note(ev->sink, diag, "%s", infos[builtin].signature);
        return value_error();
    }
    Call call = {ev, env, node, at, b->name, args, count};
    return b->function(&call);
}

Span arg_span(const Call *call, uint32_t i)
{
    if (!call->env) {
        return call->at;
    }
    const uint32_t *words = env_words(call->env, env_node(call->env, call->node)->b);
    return env_span(call->env, words[1 + i]);
}

Value arg_wrong(Call *call, uint32_t i, const char *wanted)
{
    char found[DESCRIBE_SIZE];
    Diag *diag =
        report(call->ev, E0410, arg_span(call, i), "`%s` takes %s here, not %s", call->name, wanted,
               describe_value(call->ev, call->args[i], found, sizeof found));
    for (uint32_t k = 0; k < builtin_count; ++k) {
        if (builtins[k].name == call->name) {
            diag_note(call->ev->sink, diag, "%s", infos[k].signature);
        }
    }
    return value_error();
}

bool arg_bare(Call *call, uint32_t i, double *out)
{
    if (!is_bare(call->args[i])) {
        arg_wrong(call, i, "a number without a unit");
        return false;
    }
    *out = call->args[i].number;
    return true;
}

bool arg_number(Call *call, uint32_t i, double *out, uint8_t *dim)
{
    if (call->args[i].type != VALUE_NUMBER) {
        arg_wrong(call, i, "a number");
        return false;
    }
    *out = call->args[i].number;
    *dim = call->args[i].dim;
    return true;
}

bool arg_angle(Call *call, uint32_t i, double *radians)
{
    if (call->args[i].type != VALUE_NUMBER || call->args[i].dim != DIM_ANGLE) {
        arg_wrong(call, i, "an angle with a unit, as in 90deg,");
        return false;
    }
    *radians = call->args[i].number;
    return true;
}

bool arg_vector(Call *call, uint32_t i, int count, Value *out)
{
    static const char *const wanted[] = {"a vector", "", "a vector of 2", "a vector of 3",
                                         "a vector of 4"};
    *out = call->args[i];
    if (out->type != VALUE_VECTOR || (count && out->small != count)) {
        arg_wrong(call, i, wanted[count]);
        return false;
    }
    return true;
}

bool arg_vec3(Call *call, uint32_t i, Vec3 *out)
{
    Value v;
    if (!arg_vector(call, i, 3, &v)) {
        return false;
    }
    *out = vec3(v.components[0], v.components[1], v.components[2]);
    return true;
}

bool arg_list(Call *call, uint32_t i, Value *out)
{
    *out = call->args[i];
    if (out->type != VALUE_LIST && out->type != VALUE_RANGE) {
        arg_wrong(call, i, "a list");
        return false;
    }
    return count_values(call->ev, out->count, call->at); // whoever asks will walk through it
}

bool arg_function(Call *call, uint32_t i)
{
    if (call->args[i].type != VALUE_FUNCTION && call->args[i].type != VALUE_BUILTIN) {
        arg_wrong(call, i, "a function");
        return false;
    }
    return true;
}

Value number_result(Call *call, double number, uint8_t dim)
{
    if (!isfinite(number)) {
        return fail(report(call->ev, E0501, call->at, "the result of `%s` is not a finite number",
                           call->name));
    }
    return value_number(number, dim);
}

bool same_dim(Call *call, uint32_t i, uint8_t a, uint8_t b)
{
    if (a == b) {
        return true;
    }
    report(call->ev, E0402, arg_span(call, i),
           "`%s` takes arguments of one dimension, not %s and %s", call->name,
           dim_info((Dim)a)->name, dim_info((Dim)b)->name);
    return false;
}
