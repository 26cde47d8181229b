// Reports with the chain of calls, limits, and the guard of the C stack.
#include "lang/eval.h"

#include <stdarg.h>
#include <stdio.h>

void out_of_memory(Eval *ev)
{
    longjmp(ev->on_oom, 1);
}

// A recursion's chain is shown by its ends.
enum { CHAIN_INNER = 6, CHAIN_OUTER = 2 };

static void add_calls(Eval *ev, Diag *diag)
{
    uint32_t depth = 0, index = 0;
    for (const CallFrame *call = ev->calls; call; call = call->outer) {
        ++depth;
    }
    for (const CallFrame *call = ev->calls; call; call = call->outer, ++index) {
        bool is_hidden = index >= CHAIN_INNER && index + CHAIN_OUTER < depth;
        uint32_t hidden = depth - CHAIN_INNER - CHAIN_OUTER;
        if (is_hidden && hidden > 1) {
            if (index == CHAIN_INNER) {
                diag_frame(ev->sink, diag, call->at, "… %u more calls …", hidden);
            }
        } else if (call->name) {
            diag_frame(ev->sink, diag, call->at, "in the call of `%s`",
                       symbol_name(ev->names, call->name).at);
        } else {
            diag_frame(ev->sink, diag, call->at, "in the call of a function");
        }
    }
}

enum { STEPS_A_REPORT = 32 };

Diag *report(Eval *ev, DiagCode code, Span at, const char *format, ...)
{
    must_be_alone(ev);
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ev->steps +=
        STEPS_A_REPORT; // a loop may make the same one, which is kept once, again and again
    Diag *diag = diag_report(ev->sink, code, at, "%s", text);
    if (diag_is_kept(ev->sink, diag)) {
        add_calls(ev, diag);
    }
    // Enough of them; but for warnings alone the scene is made all the same.
    if ((ev->sink->dropped && ev->sink->errors) || ev->sink->out_of_memory) {
        stop_evaluation(ev, STOP_RUN);
    }
    return diag;
}

void attach_calls(Eval *ev, uint32_t from)
{
    for (uint32_t i = from; i < ev->sink->count; ++i) {
        if (!ev->sink->items[i].frames) {
            add_calls(ev, &ev->sink->items[i]);
        }
    }
}

bool report_deep_stack(Eval *ev, Span at)
{
    if (!ev->stop) {
        Diag *diag = report(ev, E0704, at, "this is nested too deeply to be evaluated");
        diag_note(ev->sink, diag, "calls are %u deep here", ev->call_depth);
    }
    stop_evaluation(ev, STOP_STATEMENT);
    return false;
}

bool count_steps(Eval *ev, uint64_t steps, Span at)
{
    if (ev->stop) {
        return false;
    }
    if (ev->lang->stop && atomic_load_explicit(ev->lang->stop, memory_order_relaxed)) {
        stop_evaluation(ev, STOP_RUN);
        return false;
    }
    ev->steps += steps;
    if (ev->steps > ev->lang->limits.steps) {
        Diag *diag = report(ev, E0708, at, "more than %llu steps",
                            (unsigned long long)ev->lang->limits.steps);
        diag_note(ev->sink, diag, "--limit steps=N raises this");
        stop_evaluation(ev, STOP_RUN);
        return false;
    }
    return true;
}

void suggest_name(Str name, Str candidate, Str *best, size_t *distance)
{
    size_t limit = str_suggestion_limit(name);
    size_t found = str_distance(name, candidate, limit);
    size_t shorter = name.length < candidate.length ? name.length : candidate.length;
    if (found > limit && shorter >= 3 && memcmp(name.at, candidate.at, shorter) == 0) {
        found = limit; // one abbreviates the other
    }
    if (found <= limit && found < *distance && found < candidate.length) {
        *distance = found;
        *best = candidate;
    }
}

void stop_evaluation(Eval *ev, Stop stop)
{
    ev->stop = stop > ev->stop ? stop : ev->stop;
}

bool go_on(Eval *ev)
{
    ev->stop = ev->stop == STOP_RUN ? STOP_RUN : STOP_NOT;
    return ev->stop == STOP_NOT;
}
