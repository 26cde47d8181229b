#include "lang/aside.h"
#include "lang/measure.h"
#include "lang/numeric.h"

#include <stdio.h>

// --- Frames and names ------------------------------------------------------------------------

Env *env_new(Eval *ev, Env *parent, Module *module, uint32_t slot_count)
{
    Env *env = arena_alloc(ev->arena, sizeof *env + slot_count * sizeof(Value));
    env->parent = parent;
    env->module = module;
    env->serial = ++ev->serial;
    env->region = ev->region;
    env->slot_count = slot_count;
    memset(env->slots, 0, slot_count * sizeof(Value)); // all VALUE_UNSET
    return env;
}

static Env *env_up(Env *env, uint32_t frames)
{
    while (frames-- > 0) {
        env = env->parent;
    }
    return env;
}

static Value report_cycle(Eval *ev, const Env *env, AstId item)
{
    const Module *module = env->module;
    const char *name = symbol_name(ev->names, item_symbol(module, item)).at;
    Diag *diag = report(ev, E0502, item_name_span(module, item), "`%s` is defined by itself", name);
    // From the innermost outwards the chain reads "c is needed by b", "b is needed by a"; it ends
    // with the item itself, which is being evaluated.
    const ForceFrame *inner = ev->forcing;
    for (int shown = 0; shown < 8; inner = inner->outer, ++shown) {
        if (inner->env == env && inner->item == item) {
            break;
        }
        const char *by = symbol_name(ev->names, item_symbol(inner->env->module, inner->item)).at;
        Place place = source_place(&ev->lang->sources, inner->env->module->file,
                                   item_name_span(inner->env->module, inner->item).begin);
        diag_note(ev->sink, diag, "it is needed by `%s` of line %u", by, place.line);
    }
    return value_error();
}

static Value evaluate_item(Eval *ev, Env *env, AstId item)
{
    const AstNode *node = env_node(env, item);
    if (node->tag == AST_FN) {
        return eval(ev, env, item);
    }
    if (node->tag == AST_PARAM) {
        return observe(ev, env, item, eval_param(ev, env, item));
    }
    AstId expression = env_words(env, node->b)[2];
    Value v = eval(ev, env, expression);
    if (v.type == VALUE_NOTHING) {
        return fail(report(ev, E0509, env_span(env, expression), "this gives no value"));
    }
    return observe(ev, env, item, v);
}

Value force_slot(Eval *ev, Env *env, uint32_t slot, AstId item)
{
    Value *place = &env->slots[slot];
    if (place->type > VALUE_FORCING) {
        return *place;
    }
    if (env->region <= ev->aside_region) {
        must_be_alone(ev); // others may ask for it, too
    }
    if (place->type == VALUE_FORCING) {
        return report_cycle(ev, env, item);
    }
    if (env->serial < ev->oldest_forced) {
        ev->oldest_forced = env->serial;
    }
    uint32_t region = ev->region;
    ForceFrame frame = {ev->forcing, env, slot, item};
    place->type = VALUE_FORCING;
    ev->forcing = &frame;
    ev->region = env->region;
    ev->arena = &ev->regions[ev->region];
    Value v = evaluate_item(ev, env, item);
    ev->region = region;
    ev->arena = &ev->regions[region];
    ev->forcing = frame.outer;
    *place = v;
    return v;
}

// The default of a parameter reads one that has no value yet.
static Value report_unset(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    const char *name = symbol_name(ev->names, env_node(env, node->b)->a).at;
    Diag *diag = report(ev, E0502, env_span(env, id), "`%s` has no value yet", name);
    diag_note(ev->sink, diag, "a default may use the parameters to its left");
    return value_error();
}

static Value eval_name(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    switch ((NameKind)node->op) {
    case NAME_VARIABLE: {
        Value v = env_up(env, node->aux)->slots[node->a];
        return v.type == VALUE_UNSET ? report_unset(ev, env, id) : v;
    }
    case NAME_LET:
        return force_slot(ev, env_up(env, node->aux), node->a, node->b);
    case NAME_GLOBAL:
        return force_slot(ev, env->module->env, node->a, node->b);
    case NAME_BUILTIN:
        return (Value){.type = VALUE_BUILTIN, .count = node->a};
    case NAME_CONSTANT:
        return constant_value(ev, node->a);
    default:
        return value_error();
    }
}

Value peek_name(const Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    if (node->tag == AST_MEMBER && node->op == MEMBER_GLOBAL) {
        return ev->modules.items[node->aux]->env->slots[node->b];
    }
    switch (node->tag == AST_NAME ? (NameKind)node->op : NAME_BAD) {
    case NAME_VARIABLE:
    case NAME_LET:
        return env_up(env, node->aux)->slots[node->a];
    case NAME_GLOBAL:
        return env->module->env->slots[node->a];
    default:
        return (Value){0};
    }
}

static Value eval_global_member(Eval *ev, const AstNode *node)
{
    Module *module = ev->modules.items[node->aux];
    return force_slot(ev, module->env, node->b, module->globals.items[node->b].item);
}

// --- Lists -----------------------------------------------------------------------------------

void push_value(Eval *ev, Value v)
{
    if (!array_push(&ev->stack, v)) {
        out_of_memory(ev);
    }
}

Value pop_list(Eval *ev, size_t base)
{
    size_t count = ev->stack.count - base;
    Value *items = arena_array(ev->arena, count, sizeof *items);
    if (count) {
        memcpy(items, ev->stack.items + base, count * sizeof *items);
    }
    ev->stack.count = base;
    return (Value){.type = VALUE_LIST, .count = (uint32_t)count, .items = items};
}

static void add_item(Eval *ev, Env *env, AstId id, ListMaker *list);

TidyMark tidy_begin(Eval *ev)
{
    TidyMark mark = {arena_mark(ev->arena), ev->oldest_forced, ev->serial + 1};
    ev->oldest_forced = UINT64_MAX;
    return mark;
}

void tidy_end(Eval *ev, TidyMark mark, Value v)
{
    if (is_unboxed(v) && ev->oldest_forced >= mark.first) {
        arena_rewind(ev->arena, mark.mark);
    }
    if (mark.oldest_forced < ev->oldest_forced) {
        ev->oldest_forced = mark.oldest_forced;
    }
}

static bool add_iteration(Eval *ev, const Loop *loop, uint32_t i)
{
    Env *env = loop->env;
    const AstNode *node = env_node(env, loop->id);
    if (!count_step(ev, env_span(env, loop->id))) {
        loop->list->failed = true;
        return false;
    }
    Env *frame = env_new(ev, env, env->module, node->aux);
    frame->slots[0] = sequence_item(loop->sequence, i);
    add_item(ev, frame, env_words(env, node->b)[3], loop->list);
    return true;
}

static void add_loop(Eval *ev, Env *env, AstId id, ListMaker *list)
{
    Loop loop = {.env = env, .id = id, .iteration = add_iteration, .list = list};
    loop.sequence = eval_sequence(ev, env, env_words(env, env_node(env, id)->b)[2]);
    if (is_error(loop.sequence)) {
        list->failed = true;
    } else {
        loop_run(ev, &loop);
    }
}

static void add_if(Eval *ev, Env *env, AstId id, ListMaker *list)
{
    const AstNode *node = env_node(env, id);
    const uint32_t *words = env_words(env, node->b);
    Truth truth = eval_condition(ev, env, node->a, "`if`");
    if (truth == TRUTH_ERROR) {
        list->failed = true;
    } else if (truth == TRUTH_TRUE) {
        add_item(ev, env, words[0], list);
    } else if (words[1]) {
        add_item(ev, env, words[1], list);
    }
}

static void add_item(Eval *ev, Env *env, AstId id, ListMaker *list)
{
    const AstNode *node = env_node(env, id);
    if (node->tag == AST_FOR) {
        add_loop(ev, env, id, list);
        return;
    }
    if (node->tag == AST_IF) {
        add_if(ev, env, id, list);
        return;
    }
    TidyMark mark = tidy_begin(ev);
    Value v = eval(ev, env, id);
    tidy_end(ev, mark, v);
    if (v.type == VALUE_NOTHING) {
        v = fail(report(ev, E0509, env_span(env, id), "this gives no value"));
    }
    if (is_error(v)) {
        list->failed = true;
    } else if (ev->stack.count - list->base >= ev->lang->limits.list_length) {
        report(ev, E0706, env_span(env, id), "the list has more than %llu items",
               (unsigned long long)ev->lang->limits.list_length);
        list->failed = true;
        stop_evaluation(ev, STOP_STATEMENT);
    } else {
        push_value(ev, v);
    }
}

static Value eval_list(Eval *ev, Env *env, AstId id)
{
    uint32_t list = env_node(env, id)->a;
    const uint32_t *words = env_words(env, list);
    ListMaker maker = {.base = ev->stack.count};
    for (uint32_t i = 0; i < words[0]; ++i) {
        add_item(ev, env, words[1 + i], &maker);
    }
    Value v = pop_list(ev, maker.base);
    maker.failed = maker.failed || !count_step(ev, env_span(env, id));
    return maker.failed ? value_error() : v;
}

// Suggests the text of a short expression, in `format`, for what stands at `whole`.
__attribute__((format(printf, 4, 0))) static void suggest_around(Eval *ev, Span whole, Span value,
                                                                 const char *format, Diag *diag)
{
    const Source *source = source_get(&ev->lang->sources, whole.file);
    char fix[100];
    int length = (int)(value.end - value.begin);
    if (length < 60) {
        snprintf(fix, sizeof fix, format, length, source->text.at + value.begin);
        diag_suggest(ev->sink, diag, whole, fix);
    }
}

Value eval_sequence(Eval *ev, Env *env, AstId id)
{
    Value v = eval(ev, env, id);
    if (v.type == VALUE_LIST || v.type == VALUE_RANGE || is_error(v)) {
        return v;
    }
    char found[DESCRIBE_SIZE];
    Diag *diag = report(ev, E0408, env_span(env, id), "`for` goes over a list or a range, not %s",
                        describe_value(ev, v, found, sizeof found));
    if (is_bare(v)) {
        char number[32];
        format_number(v.number, number, sizeof number);
        diag_label(ev->sink, diag, "did you mean `0..<%s`?", number);
        suggest_around(ev, env_span(env, id), env_span(env, id), "0..<%.*s", diag);
    }
    return fail(diag);
}

Truth eval_condition(Eval *ev, Env *env, AstId id, const char *what)
{
    Value v = eval(ev, env, id);
    if (v.type == VALUE_BOOL) {
        return v.boolean ? TRUTH_TRUE : TRUTH_FALSE;
    }
    if (!is_error(v)) {
        char found[DESCRIBE_SIZE];
        report(ev, E0408, env_span(env, id), "%s takes true or false, not %s", what,
               describe_value(ev, v, found, sizeof found));
    }
    return TRUTH_ERROR;
}

// --- Parts of values -------------------------------------------------------------------------

static Value part(Eval *ev, Value v, uint32_t i)
{
    switch ((ValueType)v.type) {
    case VALUE_VECTOR:
        return value_number(v.components[i], v.dim);
    case VALUE_COLOR:
        return value_number(v.components[i], DIM_NONE);
    case VALUE_BOUNDS: {
        Vec3 p = i == 0   ? v.bounds->min
                 : i == 1 ? v.bounds->max
                 : i == 2 ? box3_center(*v.bounds)
                          : sub(v.bounds->max, v.bounds->min);
        return make_vector(ev, (const double[]){p.x, p.y, p.z}, 3, DIM_NONE);
    }
    case VALUE_MEASURE:
        return measure_channel(ev, v, i);
    default:
        return sequence_item(v, i);
    }
}

Value eval_index(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    Value v = eval(ev, env, node->a), index = eval(ev, env, node->b);
    if (is_error(v) || is_error(index)) {
        return value_error();
    }
    char found[DESCRIBE_SIZE];
    bool has_parts = v.type == VALUE_LIST || v.type == VALUE_RANGE || v.type == VALUE_VECTOR;
    if (!has_parts) {
        return fail(report(ev, E0408, env_span(env, node->a),
                           "only lists, ranges and vectors have numbered items, not %s",
                           describe_value(ev, v, found, sizeof found)));
    }
    if (!is_bare(index) || index.number != floor(index.number)) {
        report_not_whole(ev, env_span(env, node->b), "an index is a whole number", index);
        return value_error();
    }
    uint32_t count = v.type == VALUE_VECTOR ? v.small : v.count;
    if (!(index.number >= 0 && index.number < count)) {
        Diag *diag =
            report(ev, E0504, env_span(env, node->b), "there is no item %.0f", index.number);
        diag_label(ev->sink, diag, count ? "the items are numbered 0 to %u" : "the list is empty",
                   count - 1);
        return fail(diag);
    }
    return part(ev, v, (uint32_t)index.number);
}

// The part called `name`, or -1; *names lists what there is.
static int find_part(Value v, Str name, const char **names)
{
    static const char *const box[] = {"min", "max", "center", "size"};
    *names = NULL;
    if (v.type == VALUE_BOUNDS) {
        *names = "min, max, center and size";
        for (int i = 0; i < 4; ++i) {
            if (str_equal(name, str_from(box[i]))) {
                return i;
            }
        }
        return -1;
    }
    bool color = v.type == VALUE_COLOR || (v.type == VALUE_MEASURE && v.small == 3);
    const char *letters = color ? "rgb" : "xyzw";
    int count = color ? 3 : v.small;
    if (color || v.type == VALUE_VECTOR) {
        *names = color        ? "r, g and b"
                 : count == 2 ? "x and y"
                 : count == 3 ? "x, y and z"
                              : "x, y, z and w";
        for (int i = 0; i < count && name.length == 1; ++i) {
            if (name.at[0] == letters[i]) {
                return i;
            }
        }
    }
    return -1;
}

Value eval_member(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    if (node->op == MEMBER_GLOBAL) {
        return eval_global_member(ev, node);
    }
    Value v = node->op == MEMBER_BAD ? value_error() : eval(ev, env, node->a);
    if (is_error(v)) {
        return v;
    }
    Str name = symbol_name(ev->names, node->b);
    const char *names;
    int found = find_part(v, name, &names);
    if (found >= 0) {
        return part(ev, v, (uint32_t)found);
    }
    char text[DESCRIBE_SIZE];
    Span at = env_span(env, id);
    at.begin = at.end - (uint32_t)name.length;
    Diag *diag = report(ev, E0308, at, "`%s` is not a member of %s", name.at,
                        describe_value(ev, v, text, sizeof text));
    if (names) {
        diag_label(ev->sink, diag, "it has %s", names);
    } else if (v.type == VALUE_NODE) {
        diag_note(ev->sink, diag, "the fields of a kind can't be read; `with` changes them");
    } else if (str_equal(name, STR("length")) || str_equal(name, STR("count"))) {
        diag_label(ev->sink, diag, "did you mean `len(…)`?");
        suggest_around(ev, env_span(env, id), env_span(env, node->a), "len(%.*s)", diag);
    }
    return fail(diag);
}

// --- Expressions -----------------------------------------------------------------------------

static Value eval_string(const Eval *ev, const Env *env, const AstNode *node)
{
    Str text = symbol_name(ev->names, node->a);
    return (Value){.type = VALUE_STRING,
                   .small = (uint16_t)env->module->number,
                   .count = (uint32_t)text.length,
                   .string = text.at};
}

static Value eval_if(Eval *ev, Env *env, const AstNode *node)
{
    const uint32_t *words = env_words(env, node->b);
    Truth truth = eval_condition(ev, env, node->a, "`if`");
    if (truth == TRUTH_ERROR) {
        return value_error();
    }
    return eval(ev, env, words[truth == TRUTH_TRUE ? 0 : 1]); // which a value always has
}

static Value eval_fn(Eval *ev, Env *env, AstId id)
{
    Closure *closure = arena_alloc(ev->arena, sizeof *closure);
    *closure = (Closure){env, id};
    return (Value){.type = VALUE_FUNCTION, .function = closure};
}

Value eval(Eval *ev, Env *env, AstId id)
{
    if (stack_is_deep(ev)) {
        report_deep_stack(ev, env_span(env, id));
        return value_error();
    }
    const AstNode *node = env_node(env, id);
    Value v;
    switch ((AstTag)node->tag) {
    case AST_NUMBER:
        return value_number(ast_number(node), node->op);
    case AST_STRING:
        return eval_string(ev, env, node);
    case AST_COLOR:
        return env->module->constants.items[node->a];
    case AST_BOOL:
        return value_bool(node->a != 0);
    case AST_NAME:
        return eval_name(ev, env, id);
    case AST_VECTOR:
        return eval_vector(ev, env, id);
    case AST_LIST:
        return eval_list(ev, env, id);
    case AST_RANGE:
        return eval_range(ev, env, id);
    case AST_UNARY:
        return eval_unary(ev, env, id);
    case AST_BINARY:
        return node->aux && numeric_run(ev, env, node->aux - 1u, &v) ? v : eval_binary(ev, env, id);
    case AST_INDEX:
        return eval_index(ev, env, id);
    case AST_MEMBER:
        return eval_member(ev, env, id);
    case AST_CALL:
        return node->aux && numeric_run(ev, env, node->aux - 1u, &v) ? v : eval_call(ev, env, id);
    case AST_KIND:
        return eval_kind(ev, env, id);
    case AST_WITH:
        return eval_with(ev, env, id);
    case AST_IF:
        return eval_if(ev, env, node);
    case AST_FN:
        return eval_fn(ev, env, id);
    default: { // a block
        const uint32_t *words = env_words(env, node->a);
        return collect_items(ev, env, words + 1, words[0]);
    }
    }
}
