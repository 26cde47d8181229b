// Calls of functions: binding of arguments, the chain of calls for diagnostics, limits.
#include "lang/eval.h"

#include <stdio.h>

typedef struct Parameters {
    const Module *module;
    const uint32_t *items; // PARAMETER nodes
    uint32_t count;
} Parameters;

static Parameters parameters_of(const Closure *closure)
{
    const Module *module = closure->env->module;
    const AstNode *fn = &module->ast.nodes.items[closure->fn];
    uint32_t list = module->ast.extra.items[fn->b + 3];
    return (Parameters){module, ast_list_items(&module->ast, list),
                        ast_list_count(&module->ast, list)};
}

static const AstNode *parameter(const Parameters *parameters, uint32_t i)
{
    return &parameters->module->ast.nodes.items[parameters->items[i]];
}

static const char *parameter_name(const Eval *ev, const Parameters *parameters, uint32_t i)
{
    return symbol_name(ev->names, parameter(parameters, i)->a).at;
}

AstId fn_body(const Module *module, AstId fn)
{
    return module->ast.extra.items[module->ast.nodes.items[fn].b + 2];
}

static Symbol closure_name(const Closure *closure)
{
    return closure->env->module->ast.nodes.items[closure->fn].a;
}

// "`lamp`" or "this function".
static const char *callee_text(const Eval *ev, const Closure *closure, char *buffer, size_t size)
{
    Symbol name = closure_name(closure);
    snprintf(buffer, size, name ? "`%.100s`" : "this function", symbol_name(ev->names, name).at);
    return buffer;
}

static void note_signature(Eval *ev, Diag *diag, const Closure *closure)
{
    Parameters parameters = parameters_of(closure);
    enum { LONGEST = 256 };
    TextBuffer text = {0};
    text_add(ev, &text, "%.100s(", symbol_name(ev->names, closure_name(closure)).at);
    for (uint32_t i = 0; i < parameters.count; ++i) {
        if (text.length > LONGEST) {
            text_add(ev, &text, ", …");
            break;
        }
        text_add(ev, &text, "%s%.100s%s", i ? ", " : "", parameter_name(ev, &parameters, i),
                 parameter(&parameters, i)->b ? " = …" : "");
    }
    diag_note(ev->sink, diag, "it is declared as fn %s)", text.text);
}

// --- Binding ---------------------------------------------------------------------------------

static int64_t find_parameter(const Parameters *parameters, Symbol name)
{
    for (uint32_t i = 0; i < parameters->count; ++i) {
        if (parameter(parameters, i)->a == name) {
            return i;
        }
    }
    return -1;
}

static void report_unknown_argument(Eval *ev, const Closure *closure, Symbol name, Span at)
{
    Parameters parameters = parameters_of(closure);
    char callee[DESCRIBE_SIZE];
    Str text = symbol_name(ev->names, name), best = {0};
    size_t distance = SIZE_MAX;
    for (uint32_t i = 0; i < parameters.count; ++i) {
        suggest_name(text, str_from(parameter_name(ev, &parameters, i)), &best, &distance);
    }
    at.end = at.begin + (uint32_t)text.length;
    Diag *diag = report(ev, E0409, at, "%s has no parameter `%s`",
                        callee_text(ev, closure, callee, sizeof callee), text.at);
    if (best.length) {
        diag_suggest(ev->sink, diag, at, best.at);
    }
    note_signature(ev, diag, closure);
}

// The slot that an argument goes to, or -1 after a report.
static int64_t argument_slot(Eval *ev, const Env *env, AstId argument, uint32_t position,
                             const Closure *closure, const Env *frame)
{
    Parameters parameters = parameters_of(closure);
    const AstNode *node = env_node(env, argument);
    char callee[DESCRIBE_SIZE];
    if (node->tag != AST_ARGUMENT) {
        if (position < parameters.count) {
            return position;
        }
        Diag *diag = report(ev, E0409, env_span(env, argument), "%s takes %u argument%s, not more",
                            callee_text(ev, closure, callee, sizeof callee), parameters.count,
                            parameters.count == 1 ? "" : "s");
        note_signature(ev, diag, closure);
        return -1;
    }
    int64_t slot = find_parameter(&parameters, node->a);
    if (slot < 0) {
        report_unknown_argument(ev, closure, node->a, env_span(env, argument));
    } else if (frame->slots[slot].type != VALUE_UNSET) {
        report(ev, E0409, env_span(env, argument), "`%s` is given twice",
               parameter_name(ev, &parameters, (uint32_t)slot));
        return -1;
    }
    return slot;
}

static bool bind_given(Eval *ev, Env *env, AstId call, const Closure *closure, Env *frame)
{
    const uint32_t *words = env_words(env, env_node(env, call)->b);
    bool good = true;
    for (uint32_t i = 0; i < words[0]; ++i) {
        AstId argument = words[1 + i];
        const AstNode *node = env_node(env, argument);
        int64_t slot = argument_slot(ev, env, argument, i, closure, frame);
        AstId expression = node->tag == AST_ARGUMENT ? node->b : argument;
        Value v = eval(ev, env, expression);
        if (v.type == VALUE_NOTHING) {
            v = fail(report(ev, E0509, env_span(env, expression), "this gives no value"));
        }
        if (slot < 0) {
            good = false;
        } else {
            frame->slots[slot] = v;
        }
    }
    return good;
}

// Parameters that were not given take their defaults, evaluated in the new frame, where those to
// their left are already set.
static bool bind_defaults(Eval *ev, Env *frame, const Closure *closure, Span at)
{
    Parameters parameters = parameters_of(closure);
    char callee[DESCRIBE_SIZE];
    for (uint32_t i = 0; i < parameters.count; ++i) {
        if (frame->slots[i].type != VALUE_UNSET) {
            continue;
        }
        AstId expression = parameter(&parameters, i)->b;
        if (!expression) {
            Diag *diag = report(ev, E0409, at, "%s needs an argument for `%s`",
                                callee_text(ev, closure, callee, sizeof callee),
                                parameter_name(ev, &parameters, i));
            note_signature(ev, diag, closure);
            return false;
        }
        frame->slots[i] = eval(ev, frame, expression);
    }
    return true;
}

static Env *closure_frame(Eval *ev, const Closure *closure)
{
    Module *module = closure->env->module;
    return env_new(ev, closure->env, module, module->ast.nodes.items[closure->fn].aux);
}

Env *bind_arguments(Eval *ev, Env *env, AstId call, const Closure *closure)
{
    Env *frame = closure_frame(ev, closure);
    bool good = bind_given(ev, env, call, closure, frame);
    return good && bind_defaults(ev, frame, closure, env_span(env, call)) ? frame : NULL;
}

// --- The chain -------------------------------------------------------------------------------

bool enter_call(Eval *ev, CallFrame *frame, const Closure *closure, Span at)
{
    if (!count_step(ev, at)) {
        return false;
    }
    if (ev->call_depth >= ev->lang->limits.call_depth) {
        Diag *diag = report(ev, E0703, at, "calls are nested more than %llu deep",
                            (unsigned long long)ev->lang->limits.call_depth);
        diag_note(ev->sink, diag, "does a recursion not end? --limit call_depth=N allows more");
        stop_evaluation(ev, STOP_STATEMENT);
        return false;
    }
    *frame = (CallFrame){ev->calls, at, closure_name(closure)};
    ev->calls = frame;
    ++ev->call_depth;
    return true;
}

void leave_call(Eval *ev)
{
    ev->calls = ev->calls->outer;
    --ev->call_depth;
}

static Value run_closure(Eval *ev, const Closure *closure, Env *frame, Span at)
{
    CallFrame link;
    if (!enter_call(ev, &link, closure, at)) {
        return value_error();
    }
    Value v = eval(ev, frame, fn_body(frame->module, closure->fn));
    leave_call(ev);
    return v;
}

// --- Calls -----------------------------------------------------------------------------------

static Value report_not_callable(Eval *ev, Env *env, AstId callee, Value v)
{
    char found[DESCRIBE_SIZE];
    Diag *diag = report(ev, E0411, env_span(env, callee), "only a function can be called, not %s",
                        describe_value(ev, v, found, sizeof found));
    if (v.type == VALUE_LIST || v.type == VALUE_RANGE) {
        diag_label(ev->sink, diag, "items are chosen by `[…]`");
    }
    return fail(diag);
}

static Value call_builtin_node(Eval *ev, Env *env, AstId id, uint32_t builtin)
{
    enum { FEW = 6 };
    const uint32_t *words = env_words(env, env_node(env, id)->b);
    uint32_t count = words[0];
    Value few[FEW];
    Value *args = count <= FEW ? few : arena_array(ev->arena, count, sizeof *args);
    bool good = true;
    for (uint32_t i = 0; i < count; ++i) {
        AstId argument = words[1 + i];
        if (env_node(env, argument)->tag == AST_ARGUMENT) {
            Span at = env_span(env, argument);
            at.end = at.begin + (uint32_t)symbol_name(ev->names, env_node(env, argument)->a).length;
            report(ev, E0409, at, "`%s` takes its arguments by position", builtins[builtin].name);
            argument = env_node(env, argument)->b;
            good = false;
        }
        args[i] = eval(ev, env, argument);
        if (args[i].type == VALUE_NOTHING) {
            args[i] = fail(report(ev, E0509, env_span(env, argument), "this gives no value"));
        }
        good = good && !is_error(args[i]);
    }
    if (!good || !count_step(ev, env_span(env, id))) {
        return value_error();
    }
    return call_builtin(ev, env, id, env_span(env, id), builtin, args, count);
}

static Value call_closure_node(Eval *ev, Env *env, AstId id, const Closure *closure)
{
    TidyMark mark = tidy_begin(ev);
    Env *frame = bind_arguments(ev, env, id, closure);
    Value v = frame ? run_closure(ev, closure, frame, env_span(env, id)) : value_error();
    tidy_end(ev, mark, v);
    return v;
}

Value eval_call(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    const AstNode *callee = env_node(env, node->a);
    if (callee->tag == AST_NAME && callee->op == NAME_BUILTIN) {
        return call_builtin_node(ev, env, id, callee->a);
    }
    Value f = eval(ev, env, node->a);
    if (f.type == VALUE_FUNCTION) {
        return call_closure_node(ev, env, id, f.function);
    }
    if (f.type == VALUE_BUILTIN) {
        return call_builtin_node(ev, env, id, f.count);
    }
    return is_error(f) ? f : report_not_callable(ev, env, node->a, f);
}

Value call_value(Eval *ev, Value function, const Value *args, uint32_t count, Span at)
{
    if (function.type == VALUE_BUILTIN) {
        return count_step(ev, at) ? call_builtin(ev, NULL, 0, at, function.count, args, count)
                                  : value_error();
    }
    const Closure *closure = function.function;
    Parameters parameters = parameters_of(closure);
    char callee[DESCRIBE_SIZE];
    if (count > parameters.count) {
        Diag *diag =
            report(ev, E0409, at, "%s is called with %u argument%s here",
                   callee_text(ev, closure, callee, sizeof callee), count, count == 1 ? "" : "s");
        note_signature(ev, diag, closure);
        return value_error();
    }
    Env *frame = closure_frame(ev, closure);
    for (uint32_t i = 0; i < count; ++i) {
        frame->slots[i] = args[i];
    }
    return bind_defaults(ev, frame, closure, at) ? run_closure(ev, closure, frame, at)
                                                 : value_error();
}
