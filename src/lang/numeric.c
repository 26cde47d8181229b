#include "lang/numeric.h"

#include "base/mem.h"
#include "lang/builtins.h"

enum {
    MOST_STEPS = 128, // of an expression
    MOST_INLINED = 8, // functions in one another
    FEWEST_STEPS = 3, // worth it
    MOST_MISSES = 64,
    MOST_TRIED = 1 << 20, // steps of a file
};

// Functions of one number whose result is a number for all that they take; what they don't take
// gives a number that isn't finite.
typedef struct NumericFunction {
    BuiltinFunction *builtin;
    double (*function)(double);
    bool takes_angle;
    uint8_t dim;
} NumericFunction;

static const NumericFunction functions[] = {
    {builtin_abs, fabs, false, DIM_NONE},       {builtin_floor, floor, false, DIM_NONE},
    {builtin_ceil, ceil, false, DIM_NONE},      {builtin_round, round, false, DIM_NONE},
    {builtin_fract, fraction, false, DIM_NONE}, {builtin_sqrt, sqrt, false, DIM_NONE},
    {builtin_exp, exp, false, DIM_NONE},        {builtin_log, log, false, DIM_NONE},
    {builtin_sin, sin, true, DIM_NONE},         {builtin_cos, cos, true, DIM_NONE},
    {builtin_tan, tan, true, DIM_NONE},         {builtin_atan, atan, false, DIM_ANGLE},
};

// --- Making ----------------------------------------------------------------------------------

// A function that is written out: where the values of its parameters are.
typedef struct Inlined {
    const struct Inlined *outer;
    const size_t *arguments; // steps
    uint32_t count;
} Inlined;

typedef struct Maker {
    Eval *ev;
    Module *module;
    struct Numeric *numeric;
    size_t begin;        // the first step of the expression
    uint32_t depth;      // of functions written out, here
    uint32_t call_depth; // the most of them so far
    uint32_t limited;    // steps that limits count
    size_t tried;        // steps that were made, whether of use or not
} Maker;

static const AstNode *node_of(const Maker *m, AstId id)
{
    return ast_node(&m->module->ast, id);
}

static uint8_t dim_of_last(const Maker *m)
{
    return m->numeric->steps.items[m->numeric->steps.count - 1].dim;
}

static bool add_step(Maker *m, NumericStep step)
{
    ++m->tried;
    return m->numeric->steps.count - m->begin < MOST_STEPS && array_push(&m->numeric->steps, step);
}

static bool add_expression(Maker *m, AstId id, const Inlined *inside, unsigned dims);

static bool add_number(Maker *m, Value v)
{
    return add_step(m, (NumericStep){.code = NUMERIC_NUMBER, .dim = v.dim, .number = v.number});
}

static bool add_slot(Maker *m, NumericCode code, const AstNode *node, unsigned dims)
{
    return add_step(m, (NumericStep){.code = (uint8_t)code,
                                     .a = code == NUMERIC_LOAD ? node->aux : 0,
                                     .b = (uint16_t)dims,
                                     .slot = node->a});
}

static bool add_parameter(Maker *m, const AstNode *node, const Inlined *inside)
{
    if (node->aux > 0 || node->a >= inside->count) { // excepted: nothing else has a name there
        return false;
    }
    const size_t at = inside->arguments[node->a], now = m->numeric->steps.count;
    return add_step(m, (NumericStep){.code = NUMERIC_COPY,
                                     .dim = m->numeric->steps.items[at].dim,
                                     .a = (uint16_t)(now - at)});
}

static bool add_name(Maker *m, const AstNode *node, const Inlined *inside, unsigned dims)
{
    switch ((NameKind)node->op) {
    case NAME_VARIABLE:
        return inside ? add_parameter(m, node, inside) : add_slot(m, NUMERIC_LOAD, node, dims);
    case NAME_LET:
        return !inside && // excepted: a body that is an expression has no `let`
               add_slot(m, NUMERIC_LOAD, node, dims);
    case NAME_GLOBAL:
        return node_of(m, node->b)->tag != AST_FN && add_slot(m, NUMERIC_GLOBAL, node, dims);
    case NAME_CONSTANT:
        return add_number(m, constant_value(m->ev, node->a));
    default:
        return false;
    }
}

static bool add_operator(Maker *m, const AstNode *node, const Inlined *inside)
{
    const Operator op = (Operator)node->op;
    if (op < OP_ADD) {
        return false;
    }
    if (!add_expression(m, node->a, inside, DIM_BIT(DIM_NONE))) {
        return false;
    }
    const size_t left = m->numeric->steps.count - 1;
    const uint8_t dim = dim_of_last(m);
    NumericStep step = {.code = op == OP_ADD        ? NUMERIC_ADD
                                : op == OP_SUBTRACT ? NUMERIC_SUBTRACT
                                : op == OP_MULTIPLY ? NUMERIC_MULTIPLY
                                                    : NUMERIC_OPERATOR,
                        .op = (uint8_t)op,
                        .b = 1};
    if (!add_expression(m, node->b, inside, DIM_BIT(DIM_NONE)) ||
        !operator_dim(op, dim, dim_of_last(m), &step.dim)) {
        return false;
    }
    step.a = (uint16_t)(m->numeric->steps.count - left);
    return add_step(m, step);
}

static bool add_builtin(Maker *m, uint32_t builtin, const uint32_t *arguments, uint32_t count,
                        const Inlined *inside)
{
    const NumericFunction *f = NULL;
    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; ++i) {
        f = functions[i].builtin == builtins[builtin].function ? &functions[i] : f;
    }
    if (!f || count != 1) {
        return false;
    }
    const unsigned dims = DIM_BIT(DIM_NONE) | (f->takes_angle ? DIM_BIT(DIM_ANGLE) : 0);
    if (!add_expression(m, arguments[0], inside, dims) || !(dims & DIM_BIT(dim_of_last(m)))) {
        return false;
    }
    ++m->limited;
    return add_step(
        m, (NumericStep){.code = NUMERIC_FUNCTION, .dim = f->dim, .a = 1, .function = f->function});
}

// The arguments, and then the body.
static bool add_inlined(Maker *m, AstId fn, const uint32_t *arguments, uint32_t count,
                        const Inlined *inside)
{
    enum { MOST_ARGUMENTS = 8 };
    size_t at[MOST_ARGUMENTS];
    const Ast *ast = &m->module->ast;
    const uint32_t parameters = ast->extra.items[ast_node(ast, fn)->b + 3];
    if (count > MOST_ARGUMENTS || ast_list_count(ast, parameters) != count ||
        m->depth == MOST_INLINED) {
        return false;
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (!add_expression(m, arguments[i], inside, DIM_BIT(DIM_NONE))) {
            return false;
        }
        at[i] = m->numeric->steps.count - 1;
    }
    const Inlined inlined = {inside, at, count};
    ++m->limited;
    ++m->depth;
    m->call_depth = m->depth > m->call_depth ? m->depth : m->call_depth;
    const bool good = add_expression(m, fn_body(m->module, fn), &inlined, DIM_BIT(DIM_NONE));
    --m->depth;
    return good;
}

static bool add_call(Maker *m, const AstNode *node, const Inlined *inside)
{
    const Ast *ast = &m->module->ast;
    const AstNode *callee = ast_node(ast, node->a);
    const uint32_t *arguments = ast_list_items(ast, node->b);
    const uint32_t count = ast_list_count(ast, node->b);
    if (callee->tag != AST_NAME) {
        return false;
    }
    if (callee->op == NAME_BUILTIN) {
        return add_builtin(m, callee->a, arguments, count, inside);
    }
    return callee->op == NAME_GLOBAL && ast_node(ast, callee->b)->tag == AST_FN &&
           add_inlined(m, callee->b, arguments, count, inside);
}

// The steps of an expression; what is a name may have one of `dims`.
static bool add_expression(Maker *m, AstId id, const Inlined *inside, unsigned dims)
{
    const AstNode *node = node_of(m, id);
    switch ((AstTag)node->tag) {
    case AST_NUMBER:
        return add_number(m, value_number(ast_number(node), node->op));
    case AST_NAME:
        return add_name(m, node, inside, dims);
    case AST_UNARY:
        return node->op == OP_NEGATE && add_expression(m, node->a, inside, DIM_BIT(DIM_NONE)) &&
               add_step(m, (NumericStep){.code = NUMERIC_NEGATE, .dim = dim_of_last(m), .a = 1});
    case AST_BINARY:
        return add_operator(m, node, inside);
    case AST_CALL:
        return add_call(m, node, inside);
    default:
        return false;
    }
}

static void make_part(Maker *m, AstId id)
{
    struct Numeric *numeric = m->numeric;
    m->begin = numeric->steps.count;
    m->depth = m->call_depth = m->limited = 0;
    const bool good = add_expression(m, id, NULL, DIM_BIT(DIM_NONE));
    const size_t count = numeric->steps.count - m->begin;
    const NumericPart part = {.first = (uint32_t)m->begin,
                              .count = (uint16_t)count,
                              .call_depth = (uint16_t)m->call_depth,
                              .limited = m->limited};
    if (!good || count < FEWEST_STEPS || numeric->parts.count >= UINT16_MAX ||
        !array_push(&numeric->parts, part)) {
        numeric->steps.count = m->begin;
        return;
    }
    m->module->ast.nodes.items[id].aux = (uint16_t)numeric->parts.count;
}

void numeric_make(Eval *ev, Module *module)
{
    if (ev->lang->walked) {
        return;
    }
    module->numeric = mem_alloc_zeroed(1, sizeof *module->numeric);
    if (!module->numeric) {
        return;
    }
    Maker m = {.ev = ev, .module = module, .numeric = module->numeric};
    for (size_t id = module->ast.nodes.count; id-- > 1 && m.tried < MOST_TRIED;) {
        const AstTag tag = (AstTag)module->ast.nodes.items[id].tag;
        if (tag == AST_BINARY || tag == AST_CALL) {
            make_part(&m, (AstId)id);
        }
    }
}

void numeric_free(Module *module)
{
    if (module->numeric) {
        array_free(&module->numeric->steps);
        array_free(&module->numeric->parts);
        mem_free(module->numeric);
    }
}

// --- Running ---------------------------------------------------------------------------------

static const Value *slot_of(const Env *env, uint32_t up, uint32_t slot)
{
    while (up-- > 0) {
        env = env->parent;
    }
    return &env->slots[slot];
}

// Where there is room for its steps and calls. (Who wants an end meanwhile waits for a
// microsecond.)
static bool may_run(const Eval *ev, const NumericPart *part)
{
    const Lang *lang = ev->lang;
    return !ev->stop && ev->steps + part->limited <= lang->limits.steps &&
           ev->call_depth + part->call_depth <= lang->limits.call_depth &&
           __atomic_load_n(&part->misses, __ATOMIC_RELAXED) < MOST_MISSES;
}

bool numeric_run(Eval *ev, Env *env, uint32_t number, Value *out)
{
    struct Numeric *numeric = env->module->numeric;
    NumericPart *part = &numeric->parts.items[number];
    if (!may_run(ev, part)) {
        return false;
    }
    const NumericStep *steps = numeric->steps.items + part->first;
    double values[MOST_STEPS];
    for (uint32_t i = 0; i < part->count; ++i) {
        const NumericStep *step = &steps[i];
        double x;
        switch ((NumericCode)step->code) {
        case NUMERIC_NUMBER:
            values[i] = step->number;
            continue;
        case NUMERIC_LOAD:
        case NUMERIC_GLOBAL: {
            const Value *v =
                slot_of(step->code == NUMERIC_LOAD ? env : env->module->env, step->a, step->slot);
            if (v->type != VALUE_NUMBER || !(DIM_BIT(v->dim) & step->b)) {
                __atomic_fetch_add(&part->misses, 1, __ATOMIC_RELAXED);
                return false;
            }
            values[i] = v->number;
            continue;
        }
        case NUMERIC_COPY:
            values[i] = values[i - step->a];
            continue;
        case NUMERIC_NEGATE:
            values[i] = -values[i - step->a];
            continue;
        case NUMERIC_ADD:
            x = values[i - step->a] + values[i - step->b];
            break;
        case NUMERIC_SUBTRACT:
            x = values[i - step->a] - values[i - step->b];
            break;
        case NUMERIC_MULTIPLY:
            x = values[i - step->a] * values[i - step->b];
            break;
        case NUMERIC_OPERATOR:
            x = operator_apply((Operator)step->op, values[i - step->a], values[i - step->b]);
            break;
        default:
            x = step->function(values[i - step->a]);
        }
        if (!isfinite(x)) {
            return false; // the tree says of what
        }
        values[i] = x;
    }
    ev->steps += part->limited;
    *out = value_number(values[part->count - 1], steps[part->count - 1].dim);
    return true;
}
