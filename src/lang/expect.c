// `expect`: what a scene says must be so. The values of both sides and of the names are taken along
// for the report where it isn't.
#include "lang/expect.h"

#include <stdio.h>

enum { LONGEST_TEXT = 100, LONGEST_ITEMS = 60, MOST_PARTS = 12, MOST_MEASURES = 100000 };

// --- Values as short texts -----------------------------------------------------------------------

// The first items of a long list.
static void add_items(Eval *ev, TextBuffer *out, Value list)
{
    text_add(ev, out, "[");
    for (uint32_t i = 0; i < list.count; ++i) {
        if (out->length > LONGEST_ITEMS) {
            text_add(ev, out, "…] (%u items)", list.count);
            return;
        }
        text_add_value(ev, out, list.items[i], true);
        text_add(ev, out, i + 1 < list.count ? ", " : "");
    }
    text_add(ev, out, "]");
}

const char *short_value(Eval *ev, Value v)
{
    TextBuffer text = {0};
    if (v.type == VALUE_LIST) {
        add_items(ev, &text, v);
    } else {
        text_add_value(ev, &text, v, true);
    }
    if (text.length <= LONGEST_TEXT) {
        return text.text;
    }
    size_t end = LONGEST_TEXT;
    while (((unsigned char)text.text[end] & 0xc0) == 0x80) {
        --end;
    }
    text.length = end;
    text_add(ev, &text, "…");
    return text.text;
}

// The source of an expression, blanks run together.
static const char *source_text(Eval *ev, Span at)
{
    Str text = source_get(&ev->lang->sources, at.file)->text;
    char *copy = arena_alloc(ev->arena, (size_t)(at.end - at.begin) + 1), *to = copy;
    bool blank = true;
    for (uint32_t i = at.begin; i < at.end; ++i) {
        bool before = blank;
        blank = strchr(" \t\r\n", text.at[i]) != NULL;
        if (!blank || !before) {
            *to++ = blank ? ' ' : text.at[i];
        }
    }
    *to = '\0';
    return copy;
}

// --- Parts ---------------------------------------------------------------------------------------

static void add_part(Eval *ev, Finding *finding, const char *text, const char *value)
{
    bool known = strcmp(text, value) == 0 || finding->part_count == MOST_PARTS;
    for (uint32_t i = 0; i < finding->part_count; ++i) {
        known = known || strcmp(finding->parts[i].text, text) == 0;
    }
    if (!known) {
        if (!finding->parts) {
            finding->parts = arena_array(ev->arena, MOST_PARTS, sizeof *finding->parts);
        }
        finding->parts[finding->part_count++] = (ExpectationPart){text, value};
    }
}

static bool tells_something(Value v)
{
    return v.type > VALUE_NOTHING && v.type != VALUE_FUNCTION && v.type != VALUE_BUILTIN &&
           v.type != VALUE_NODE;
}

// An expression whose value is known; literals speak for themselves.
void add_side(Eval *ev, Env *env, AstId id, Value v, Finding *finding)
{
    AstTag tag = env_node(env, id)->tag;
    bool literal = tag == AST_NUMBER || tag == AST_STRING || tag == AST_COLOR || tag == AST_BOOL;
    if (!literal && tells_something(v) && v.type != VALUE_MEASURE) {
        add_part(ev, finding, source_text(ev, env_span(env, id)), short_value(ev, v));
    }
}

static void add_names(Eval *ev, Env *env, AstId id, Finding *finding);

static void add_names_of_list(Eval *ev, Env *env, uint32_t list, Finding *finding)
{
    const uint32_t *words = env_words(env, list);
    for (uint32_t i = 0; i < words[0]; ++i) {
        add_names(ev, env, words[1 + i], finding);
    }
}

// The names in an expression, but for those that are bound inside of it.
static void add_names(Eval *ev, Env *env, AstId id, Finding *finding)
{
    const AstNode *node = env_node(env, id);
    Value known = peek_name(ev, env, id);
    if (stack_is_deep(ev)) {
        return;
    }
    if (tells_something(known)) {
        add_part(ev, finding, source_text(ev, env_span(env, id)), short_value(ev, known));
        return;
    }
    switch ((AstTag)node->tag) {
    case AST_BINARY:
    case AST_INDEX:
    case AST_RANGE:
        add_names(ev, env, node->a, finding);
        add_names(ev, env, node->b, finding);
        break;
    case AST_UNARY:
    case AST_MEMBER:
        add_names(ev, env, node->a, finding);
        break;
    case AST_ARGUMENT:
    case AST_FIELD:
        add_names(ev, env, node->b, finding);
        break;
    case AST_VECTOR:
    case AST_LIST:
        add_names_of_list(ev, env, node->a, finding);
        break;
    case AST_CALL:
    case AST_WITH:
        add_names(ev, env, node->a, finding);
        add_names_of_list(ev, env, node->b, finding);
        break;
    case AST_KIND:
        add_names_of_list(ev, env, node->b, finding);
        break;
    case AST_IF:
        add_names(ev, env, node->a, finding);
        add_names(ev, env, env_words(env, node->b)[0], finding);
        add_names(ev, env, env_words(env, node->b)[1], finding);
        break;
    case AST_FOR:
        add_names(ev, env, env_words(env, node->b)[2], finding);
        break;
    default: // literals, and what has frames of its own
        break;
    }
}

// --- What doesn't hold ---------------------------------------------------------------------------

static const char *first_difference(Eval *ev, Value a, Value b)
{
    TextBuffer text = {0};
    for (uint32_t i = 0; i < a.count && i < b.count; ++i) {
        Value left = sequence_item(a, i), right = sequence_item(b, i);
        if (!values_equal(ev, left, right, (Span){0})) {
            text_add(ev, &text, "item %u is %s, not %s", i, short_value(ev, left),
                     short_value(ev, right));
            return text.text;
        }
    }
    text_add(ev, &text, "it has %u item%s, not %u", a.count, a.count == 1 ? "" : "s", b.count);
    return text.text;
}

static bool is_sequence(Value v)
{
    return v.type == VALUE_LIST || v.type == VALUE_RANGE;
}

static const char *describe_comparison(Eval *ev, Operator op, Value a, Value b)
{
    const char *left = short_value(ev, a), *right = short_value(ev, b);
    TextBuffer text = {0};
    switch (op) {
    case OP_EQUAL:
        if (is_sequence(a)) {
            return first_difference(ev, a, b);
        }
        text_add(ev, &text, "%s is not %s", left, right);
        if (a.type == VALUE_NUMBER && strcmp(left, right) == 0) {
            text_add(ev, &text, ": they differ by %.3g", a.number - b.number);
        }
        break;
    case OP_NOT_EQUAL:
        text_add(ev, &text, "both are %s", left);
        break;
    case OP_LESS:
        text_add(ev, &text, "%s is not below %s", left, right);
        break;
    case OP_LESS_EQUAL:
        text_add(ev, &text, "%s is above %s", left, right);
        break;
    case OP_GREATER:
        text_add(ev, &text, "%s is not above %s", left, right);
        break;
    default:
        text_add(ev, &text, "%s is below %s", left, right);
    }
    return text.text;
}

static bool is_comparison(const AstNode *node)
{
    return node->tag == AST_BINARY && node->op >= OP_EQUAL && node->op <= OP_GREATER_EQUAL;
}

// `whole`: the comparison is all that is expected, so that its sides may be measured.
static Truth compare_sides(Eval *ev, Env *env, AstId id, bool whole, Finding *finding)
{
    const AstNode *node = env_node(env, id);
    Operator op = (Operator)node->op;
    Value a = eval(ev, env, node->a), b = eval(ev, env, node->b);
    if (is_error(a) || is_error(b)) {
        return TRUTH_ERROR;
    }
    if (whole && (a.type == VALUE_MEASURE || b.type == VALUE_MEASURE)) {
        finding->measure = measure_comparison(ev, op, a, b, env_span(env, id));
        add_names(ev, env, id, finding);
        return finding->measure ? TRUTH_TRUE : TRUTH_ERROR;
    }
    Value v = compare_operands(ev, op, a, b, env_span(env, id));
    if (v.type != VALUE_BOOL) {
        return TRUTH_ERROR;
    }
    if (!v.boolean) {
        finding->at = env_span(env, id);
        finding->wrong = describe_comparison(ev, op, a, b);
        add_side(ev, env, node->a, a, finding);
        add_side(ev, env, node->b, b, finding);
        add_names(ev, env, id, finding);
    }
    return v.boolean ? TRUTH_TRUE : TRUTH_FALSE;
}

// What a call was given is worth more than that it gave false.
static void add_arguments(Eval *ev, Env *env, const AstNode *call, Finding *finding)
{
    const uint32_t *words = env_words(env, call->b);
    for (uint32_t i = 0; i < words[0]; ++i) {
        const AstNode *argument = env_node(env, words[1 + i]);
        AstId id = argument->tag == AST_ARGUMENT ? argument->b : words[1 + i];
        if (env_node(env, id)->tag == AST_CALL) {
            add_side(ev, env, id, eval(ev, env, id), finding);
        }
    }
}

// An expression that must be true; of several with `and` between them, the first that isn't.
static Truth holds(Eval *ev, Env *env, AstId id, bool whole, Finding *finding)
{
    const AstNode *node = env_node(env, id);
    if (stack_is_deep(ev)) {
        report_deep_stack(ev, env_span(env, id));
        return TRUTH_ERROR;
    }
    if (node->tag == AST_BINARY && node->op == OP_AND) {
        Truth left = holds(ev, env, node->a, false, finding);
        return left == TRUTH_TRUE ? holds(ev, env, node->b, false, finding) : left;
    }
    if (is_comparison(node)) {
        return compare_sides(ev, env, id, whole, finding);
    }
    Truth truth = eval_condition(ev, env, id, "`expect`");
    if (truth == TRUTH_FALSE) {
        finding->at = env_span(env, id);
        finding->wrong = "it is false";
        if (node->tag == AST_CALL) {
            add_arguments(ev, env, node, finding);
        }
        add_names(ev, env, id, finding);
    }
    return truth;
}

static Truth holds_within(Eval *ev, Env *env, AstId id, Finding *finding)
{
    const AstNode *node = env_node(env, id);
    const uint32_t *words = env_words(env, node->b);
    Within within = {.is_percentage = node->aux != 0,
                     .value = eval(ev, env, node->a),
                     .tolerance = eval(ev, env, words[0]),
                     .target = eval(ev, env, words[1]),
                     .at = env_span(env, id),
                     .tolerance_at = env_span(env, words[0])};
    Value sides[] = {within.value, within.target};
    bool bad = is_error(sides[0]) || is_error(within.tolerance) || is_error(sides[1]) ||
               !tolerance_is_sound(ev, &within);
    Truth truth = TRUTH_ERROR;
    if (!bad && (sides[0].type == VALUE_MEASURE || sides[1].type == VALUE_MEASURE)) {
        finding->measure = measure_within(ev, &within);
        truth = finding->measure ? TRUTH_TRUE : TRUTH_ERROR;
    } else if (!bad) {
        truth = within_holds(ev, &within, &finding->wrong);
    }
    if (truth == TRUTH_FALSE || finding->measure) {
        finding->at = env_span(env, id);
        add_side(ev, env, node->a, within.value, finding);
        add_side(ev, env, words[0], within.tolerance, finding);
        add_side(ev, env, words[1], within.target, finding);
        add_names(ev, env, node->a, finding);
        add_names(ev, env, words[0], finding);
        add_names(ev, env, words[1], finding);
    }
    return truth;
}

// --- Keeping -------------------------------------------------------------------------------------

static const char *keep_text(Eval *ev, const char *text)
{
    return arena_copy_string(&ev->scene->arena, text, strlen(text));
}

static void keep_parts(Eval *ev, SceneExpectation *expectation, const Finding *finding)
{
    expectation->parts =
        arena_array(&ev->scene->arena, finding->part_count, sizeof *expectation->parts);
    for (uint32_t i = 0; i < finding->part_count; ++i) {
        expectation->parts[i] = (ExpectationPart){keep_text(ev, finding->parts[i].text),
                                                  keep_text(ev, finding->parts[i].value)};
    }
    expectation->part_count = finding->part_count;
}

static SceneExpectation *new_record(Eval *ev, Module *module, AstId id)
{
    SceneExpectationArray *all = &ev->scene->expectations;
    if (!array_push(all, (SceneExpectation){.at = ast_span(&module->ast, id)})) {
        out_of_memory(ev);
    }
    module->ast.extra.items[module->ast.nodes.items[id].b + 2] = (uint32_t)all->count;
    return &all->items[all->count - 1];
}

static SceneExpectation *find_record(Eval *ev, Module *module, AstId id)
{
    uint32_t record = module->ast.extra.items[module->ast.nodes.items[id].b + 2];
    SceneExpectation *found = record ? &ev->scene->expectations.items[record - 1] : NULL;
    return found && !found->measure ? found : new_record(ev, module, id);
}

void keep_unrun_expectations(Eval *ev, Module *module)
{
    for (AstId id = 1; id < module->ast.nodes.count; ++id) {
        const AstNode *node = &module->ast.nodes.items[id];
        if (node->tag == AST_EXPECT && !module->ast.extra.items[node->b + 2]) {
            new_record(ev, module, id);
        }
    }
}

static void warn(Eval *ev, const Finding *finding)
{
    Diag *diag = report(ev, W0501, finding->at, "this expectation isn't met");
    diag_label(ev->sink, diag, "%s", finding->wrong);
    for (uint32_t i = 0; i < finding->part_count; ++i) {
        diag_note(ev->sink, diag, "%s is %s", finding->parts[i].text, finding->parts[i].value);
    }
}

static void keep_verdict(Eval *ev, Env *env, AstId id, bool met, const Finding *finding)
{
    SceneExpectation *expectation = find_record(ev, env->module, id);
    ++expectation->times;
    if (!met && ++expectation->fails == 1) {
        expectation->wrong_at = finding->at;
        expectation->wrong = keep_text(ev, finding->wrong);
        keep_parts(ev, expectation, finding);
    }
    if (!met && !ev->lang->testing) {
        warn(ev, finding);
    }
}

// What is to be measured is kept each time that it is met with.
static void keep_measure(Eval *ev, Env *env, AstId id, const Finding *finding)
{
    if (ev->measures == MOST_MEASURES) {
        report(ev, E0707, env_span(env, id), "more than %d measured expectations", MOST_MEASURES);
        stop_evaluation(ev, STOP_RUN);
        return;
    }
    SceneExpectation *expectation = new_record(ev, env->module, id);
    ++ev->measures;
    expectation->times = 1;
    expectation->measure = finding->measure;
    keep_parts(ev, expectation, finding);
}

void run_expect(Eval *ev, Env *env, AstId id)
{
    must_be_alone(ev);
    if (!count_step(ev, env_span(env, id))) {
        return;
    }
    TidyMark mark = tidy_begin(ev);
    Finding finding = {0};
    const AstNode *node = env_node(env, id);
    Truth truth = env_words(env, node->b)[0] ? holds_within(ev, env, id, &finding)
                                             : holds(ev, env, node->a, true, &finding);
    if (finding.measure) {
        keep_measure(ev, env, id, &finding);
    } else if (truth != TRUTH_ERROR) {
        keep_verdict(ev, env, id, truth == TRUTH_TRUE, &finding);
    }
    tidy_end(ev, mark, value_nothing());
}
