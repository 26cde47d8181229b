// Built-in functions of lists, and text.
#include "lang/builtins.h"

#include "base/utf8.h"

#include <stdio.h>

static Value *new_items(Call *call, uint32_t count)
{
    return arena_array(call->ev->arena, count, sizeof(Value));
}

static Value list_of(const Value *items, uint32_t count)
{
    return (Value){.type = VALUE_LIST, .count = count, .items = items};
}

Value builtin_len(Call *call)
{
    Value v = call->args[0];
    if (v.type == VALUE_STRING) {
        if (!count_steps(call->ev, v.count / BYTES_A_STEP, call->at)) {
            return value_error();
        }
        double count = 0;
        const char *at = v.string, *end = at + v.count;
        for (uint32_t code; at < end; ++count) {
            at += utf8_decode(at, end, &code);
        }
        return value_number(count, DIM_NONE);
    }
    if (v.type != VALUE_LIST && v.type != VALUE_RANGE) {
        return arg_wrong(call, 0, "a list");
    }
    return value_number(v.count, DIM_NONE);
}

Value builtin_sum(Call *call)
{
    Value list;
    if (!arg_list(call, 0, &list)) {
        return value_error();
    }
    Value total = list.count ? sequence_item(list, 0) : value_number(0, DIM_NONE);
    if (total.type != VALUE_NUMBER && total.type != VALUE_VECTOR && total.type != VALUE_COLOR) {
        return arg_wrong(call, 0, "a list of numbers, vectors or colors");
    }
    for (uint32_t i = 1; i < list.count && !is_error(total); ++i) {
        total = add_values(call->ev, total, sequence_item(list, i), arg_span(call, 0));
    }
    return total;
}

Value builtin_range(Call *call)
{
    double x[3] = {0, 0, 1};
    uint8_t dims[3] = {0};
    for (uint32_t i = 0; i < call->count; ++i) {
        if (!arg_number(call, i, &x[i], &dims[i]) || !same_dim(call, i, dims[0], dims[i])) {
            return value_error();
        }
    }
    if (call->count == 1) {
        x[1] = x[0];
        x[0] = 0;
    }
    if (x[2] == 0 || (call->count < 3 && dims[0] != DIM_NONE)) {
        return fail(report(call->ev, E0410, call->at,
                           x[2] == 0 ? "the step of `range` can't be zero"
                                     : "a range of quantities needs a step"));
    }
    // A last step that misses the end by rounding only would reach it.
    double count = fmax(0, ceil((x[1] - x[0]) / x[2] - 1e-9));
    if (!check_list_length(call->ev, "list", count, call->at)) {
        return value_error();
    }
    if (!count_values(call->ev, (uint64_t)count, call->at)) {
        return value_error();
    }
    Value *items = new_items(call, (uint32_t)count);
    for (uint32_t i = 0; i < (uint32_t)count; ++i) {
        items[i] = value_number(x[0] + i * x[2], dims[0]);
    }
    return list_of(items, (uint32_t)count);
}

Value builtin_reverse(Call *call)
{
    Value list;
    if (!arg_list(call, 0, &list)) {
        return value_error();
    }
    Value *items = new_items(call, list.count);
    for (uint32_t i = 0; i < list.count; ++i) {
        items[i] = sequence_item(list, list.count - 1 - i);
    }
    return list_of(items, list.count);
}

// --- Sorting: a merge sort, so that equal items keep their order -----------------------------

static void merge(Value *keys, Value *items, Value *spare_keys, Value *spare_items, uint32_t begin,
                  uint32_t middle, uint32_t end)
{
    uint32_t left = begin, right = middle;
    for (uint32_t i = begin; i < end; ++i) {
        bool take_left =
            right >= end || (left < middle && compare_values(keys[left], keys[right]) <= 0);
        uint32_t from = take_left ? left++ : right++;
        spare_keys[i] = keys[from];
        spare_items[i] = items[from];
    }
    memcpy(keys + begin, spare_keys + begin, (end - begin) * sizeof *keys);
    memcpy(items + begin, spare_items + begin, (end - begin) * sizeof *items);
}

Value builtin_sort(Call *call)
{
    Value list;
    if (!arg_list(call, 0, &list) || (call->count > 1 && !arg_function(call, 1))) {
        return value_error();
    }
    uint32_t count = list.count;
    uint64_t bytes = 0; // of all keys that are strings
    Value *items = new_items(call, count), *keys = new_items(call, count);
    for (uint32_t i = 0; i < count; ++i) {
        items[i] = sequence_item(list, i);
        keys[i] = call->count > 1 ? call_value(call->ev, call->args[1], &items[i], 1, call->at)
                                  : items[i];
        if (is_error(keys[i]) || !count_comparison(call->ev, keys[i], keys[i], call->at)) {
            return value_error();
        }
        bytes += keys[i].type == VALUE_STRING ? keys[i].count : 0;
        if (compare_values(keys[0], keys[i]) == 2) {
            return arg_wrong(call, 0,
                             call->count > 1
                                 ? "keys that are all numbers of one dimension, or all strings"
                                 : "a list of numbers of one dimension, or of strings");
        }
    }
    Value *spare_items = new_items(call, count), *spare_keys = new_items(call, count);
    for (uint64_t width = 1; width < count; width *= 2) {
        if (!count_values(call->ev, count, call->at) ||
            !count_steps(call->ev, bytes / BYTES_A_STEP, call->at)) {
            return value_error();
        }
        for (uint64_t begin = 0; begin + width < count; begin += 2 * width) {
            uint64_t end = begin + 2 * width < count ? begin + 2 * width : count;
            merge(keys, items, spare_keys, spare_items, (uint32_t)begin, (uint32_t)(begin + width),
                  (uint32_t)end);
        }
    }
    return list_of(items, count);
}

Value builtin_concat(Call *call)
{
    double total = 0;
    Value list;
    for (uint32_t i = 0; i < call->count; ++i) {
        if (!arg_list(call, i, &list)) {
            return value_error();
        }
        total += list.count;
    }
    if (!check_list_length(call->ev, "list", total, call->at)) {
        return value_error();
    }
    Value *items = new_items(call, (uint32_t)total);
    uint32_t at = 0;
    for (uint32_t i = 0; i < call->count; ++i) {
        for (uint32_t k = 0; k < call->args[i].count; ++k) {
            items[at++] = sequence_item(call->args[i], k);
        }
    }
    return list_of(items, at);
}

// --- Functions over lists --------------------------------------------------------------------

Value builtin_map(Call *call)
{
    Value list;
    if (!arg_list(call, 0, &list) || !arg_function(call, 1)) {
        return value_error();
    }
    Value *items = new_items(call, list.count);
    for (uint32_t i = 0; i < list.count; ++i) {
        Value v = sequence_item(list, i);
        items[i] = call_value(call->ev, call->args[1], &v, 1, call->at);
        if (items[i].type == VALUE_NOTHING || is_error(items[i])) {
            return value_error();
        }
    }
    return list_of(items, list.count);
}

Value builtin_filter(Call *call)
{
    Value list;
    if (!arg_list(call, 0, &list) || !arg_function(call, 1)) {
        return value_error();
    }
    Value *items = new_items(call, list.count);
    uint32_t count = 0;
    for (uint32_t i = 0; i < list.count; ++i) {
        Value v = sequence_item(list, i);
        Value keep = call_value(call->ev, call->args[1], &v, 1, call->at);
        if (is_error(keep)) {
            return keep;
        }
        if (keep.type != VALUE_BOOL) {
            return arg_wrong(call, 1, "a function that gives true or false");
        }
        if (keep.boolean) {
            items[count++] = v;
        }
    }
    return list_of(items, count);
}

Value builtin_fold(Call *call)
{
    Value list;
    if (!arg_list(call, 0, &list) || !arg_function(call, 2)) {
        return value_error();
    }
    Value pair[2] = {call->args[1]};
    for (uint32_t i = 0; i < list.count && !is_error(pair[0]); ++i) {
        pair[1] = sequence_item(list, i);
        pair[0] = call_value(call->ev, call->args[2], pair, 2, call->at);
    }
    return pair[0];
}

Value builtin_zip(Call *call)
{
    Value a, b;
    if (!arg_list(call, 0, &a) || !arg_list(call, 1, &b)) {
        return value_error();
    }
    uint32_t count = a.count < b.count ? a.count : b.count;
    Value *items = new_items(call, count);
    for (uint32_t i = 0; i < count; ++i) {
        Value *pair = new_items(call, 2);
        pair[0] = sequence_item(a, i);
        pair[1] = sequence_item(b, i);
        items[i] = list_of(pair, 2);
    }
    return list_of(items, count);
}

// --- Text ------------------------------------------------------------------------------------

static TextBuffer join(Call *call, const char *between)
{
    TextBuffer text = {.at = call->at};
    for (uint32_t i = 0; i < call->count; ++i) {
        text_add(call->ev, &text, "%s", i ? between : "");
        text_add_value(call->ev, &text, call->args[i], false);
    }
    return text;
}

// The number of the module where a call stands; one that a `map` makes stands where the `map` does.
static uint32_t calling_module(const Call *call)
{
    uint32_t i = (uint32_t)call->ev->modules.count - 1;
    while (i > 0 && call->ev->modules.items[i]->file != call->at.file) {
        --i;
    }
    return i;
}

Value builtin_str(Call *call)
{
    TextBuffer text = join(call, "");
    if (call->ev->stop || !count_steps(call->ev, text.length / BYTES_A_STEP, call->at)) {
        return value_error();
    }
    return make_string(call->ev, (Str){text.text, text.length}, calling_module(call));
}

Value builtin_print(Call *call)
{
    must_be_alone(call->ev);
    if (call->ev->early) { // what is printed can't be taken back
        call->ev->refused = true;
        stop_evaluation(call->ev, STOP_RUN);
        return value_nothing();
    }
    TextBuffer text = join(call, " ");
    if (call->ev->lang->print_to && !call->ev->stop) {
        fprintf(call->ev->lang->print_to, "%s\n", text.text);
    }
    return value_nothing();
}

Value builtin_assert(Call *call)
{
    Value condition = call->args[0];
    if (condition.type != VALUE_BOOL) {
        return arg_wrong(call, 0, "true or false");
    }
    if (call->count > 1 && call->args[1].type != VALUE_STRING) {
        return arg_wrong(call, 1, "a string");
    }
    if (!condition.boolean) {
        return fail(report(call->ev, E0506, call->at, "%s",
                           call->count > 1 ? call->args[1].string : "the assertion doesn't hold"));
    }
    return value_nothing();
}
