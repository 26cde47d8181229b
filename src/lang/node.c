// Values of kinds: building, changing by `with`, keeping in the scene.
#include "lang/eval.h"

#include <stdarg.h>
#include <stdio.h>
#include <xxhash.h>

// --- `finish` --------------------------------------------------------------------------------

typedef struct FinishCall {
    Eval *ev;
    Module *module;
    uint32_t list; // FIELDs of the node
    uint32_t type;
    Span at;
} FinishCall;

static Span finish_span(const FinishCall *call, int param)
{
    const Ast *ast = &call->module->ast;
    for (uint32_t i = 0; param >= 0 && i < ast_list_count(ast, call->list); ++i) {
        const AstNode *field = &ast->nodes.items[ast_list_items(ast, call->list)[i]];
        if (field->tag == AST_FIELD && field_index(call->ev, call->type, field->a) == param + 1) {
            return ast_span(ast, field->b);
        }
    }
    return call->at;
}

__attribute__((format(printf, 4, 5))) static Diag *
finish_report(NodeFinish *self, int param, DiagCode code, const char *format, ...)
{
    const FinishCall *call = self->caller;
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return report(call->ev, code, finish_span(call, param), "%s", text);
}

static Span finish_place(NodeFinish *self, int param)
{
    return finish_span(self->caller, param);
}

// A light's shape stands in the scene while `finish` looks at it, and is taken out again: it is
// added for good with each light that is emitted.
static uint32_t lend_shape(Eval *ev, NodeValue *light, const KindInfo *kind)
{
    if (kind->shape_field < 0 || !light->of) {
        return NONE_ID;
    }
    uint32_t id = scene_add_node(
        ev->scene, light->of->type, light->of->params,
        (SceneNode){.flags = NODE_LIGHT_ONLY, .material = NONE_ID, .at = light->of->at});
    if (id == NONE_ID) {
        out_of_memory(ev);
    }
    memcpy((char *)light->params + kind->type->params[kind->shape_field].offset, &id, sizeof id);
    return id;
}

static void take_shape_back(Eval *ev, const NodeValue *light, uint32_t id)
{
    SceneNodeArray *shapes = &ev->scene->nodes[CATEGORY_SHAPE];
    if (id != NONE_ID && id + 1 == shapes->count) {
        --shapes->count;
        --ev->scene->tables[light->of->type].count;
        --ev->scene->prototypes.items[0].shape_count;
    }
}

// Runs the kind's own checks; with `keep_raw` the parameters before them are kept for `with`.
static bool finish_node(Eval *ev, NodeValue *node, Module *module, uint32_t list, bool keep_raw)
{
    const KindInfo *kind = &ev->kinds[node->type];
    const NodeType *type = kind->type;
    node->raw = node->params;
    if (!type->finish) {
        return true;
    }
    if (type->category != CATEGORY_SHAPE) { // lights look at their shapes in the scene
        must_be_alone(ev);
    }
    if (keep_raw) {
        node->params = arena_alloc(ev->arena, type->size);
        memcpy(node->params, node->raw, type->size);
    }
    FinishCall call = {ev, module, list, node->type, node->at};
    uint32_t errors = ev->sink->errors, from = ev->sink->count;
    uint32_t shape = lend_shape(ev, node, kind);
    NodeFinish finish = {.type = type,
                         .params = node->params,
                         .set = node->set,
                         .scene = ev->scene,
                         .color = node->color,
                         .report = finish_report,
                         .place = finish_place,
                         .sink = ev->sink,
                         .caller = &call};
    bool good = type->finish(&finish) && ev->sink->errors == errors;
    take_shape_back(ev, node, shape);
    attach_calls(ev, from);
    return good;
}

// --- Fields ----------------------------------------------------------------------------------

static bool is_item(const Eval *ev, Value v)
{
    if (v.type != VALUE_NODE) {
        return false;
    }
    Category category = ev->kinds[v.node->type].type->category;
    return category == CATEGORY_SHAPE || category == CATEGORY_LIGHT || category == CATEGORY_CAMERA;
}

static bool fill_items(Eval *ev, NodeValue *node, Value v, Where where)
{
    char found[DESCRIBE_SIZE];
    if (v.type != VALUE_LIST) {
        report(ev, E0401, where_span(where),
               "`items` takes a list of shapes, lights and cameras, "
               "not %s",
               describe_value(ev, v, found, sizeof found));
        return false;
    }
    if (!count_values(ev, v.count, where_span(where))) {
        return false;
    }
    for (uint32_t i = 0; i < v.count; ++i) {
        if (!is_item(ev, v.items[i])) {
            report(ev, E0401, where_span(where),
                   "`items` takes a list of shapes, lights and cameras; item %u is %s", i,
                   describe_value(ev, v.items[i], found, sizeof found));
            return false;
        }
    }
    node->items = v.items;
    node->item_count = v.count;
    return true;
}

static bool fill_of(Eval *ev, NodeValue *node, Value v, Where where)
{
    if (v.type == VALUE_NODE && ev->kinds[v.node->type].type->category == CATEGORY_SHAPE) {
        node->of = v.node;
        return true;
    }
    char found[DESCRIBE_SIZE];
    report(ev, E0401, where_span(where), "`of` takes a shape or a group, not %s",
           describe_value(ev, v, found, sizeof found));
    return false;
}

static bool fill_common(Eval *ev, NodeValue *node, CommonField field, Value v, Where where)
{
    char found[DESCRIBE_SIZE];
    const char *wanted = "a string";
    switch (field) {
    case COMMON_TRANSFORM: {
        Affine map;
        if (!fill_transform(ev, v, where, &map)) {
            return false;
        }
        node->transform = affine_is_identity(&map) ? NULL : make_transform(ev, &map).transform;
        return true;
    }
    case COMMON_MATERIAL:
        if (v.type == VALUE_NODE && ev->kinds[v.node->type].type->category == CATEGORY_MATERIAL) {
            node->material = v.node;
            return true;
        }
        wanted = "a material";
        break;
    case COMMON_NAME:
        if (v.type == VALUE_STRING) {
            if (!count_steps(ev, v.count / BYTES_A_STEP, where_span(where))) {
                return false;
            }
            node->name = (Str){v.string, v.count};
            return true;
        }
        break;
    default: // COMMON_COLOR
        if (v.type == VALUE_COLOR) {
            node->color =
                (Rgb){(float)v.components[0], (float)v.components[1], (float)v.components[2]};
            return true;
        }
        return wrong_type(ev, &(Param){.name = "color", .type = PARAM_COLOR}, v, where);
    }
    report(ev, E0401, where_span(where), "`%s` takes %s, not %s", common_field_name(field), wanted,
           describe_value(ev, v, found, sizeof found));
    return false;
}

static bool fill_field(Eval *ev, NodeValue *node, int field, Value v, Where where)
{
    if (is_error(v) || field == FIELD_BAD) {
        return false; // reported
    }
    if (v.type == VALUE_NOTHING) {
        report(ev, E0509, where_span(where), "this gives no value");
        return false;
    }
    if (field == FIELD_ITEMS) {
        return fill_items(ev, node, v, where);
    }
    if (field == FIELD_OF) {
        return fill_of(ev, node, v, where);
    }
    if (field & FIELD_COMMON) {
        return fill_common(ev, node, (CommonField)(field & 0xff), v, where);
    }
    return fill_param(ev, node, field - 1, v, where);
}

// --- Kinds -----------------------------------------------------------------------------------

// The items of a group; where statements are emitted at once, so are they, with the group's
// transform and material around them.
static bool build_items(Eval *ev, Env *env, uint32_t list, NodeValue *group, bool keep)
{
    const uint32_t *words = env_words(env, list);
    Value given = {.type = VALUE_LIST, .count = group->item_count, .items = group->items};
    if (!keep) {
        NodeValue around = *group; // the list given as `items`
        emit_node(ev, &around);
        Emitter *outer = ev->emitter;
        uint32_t material = group->material ? node_scene_id(ev, group->material) : NONE_ID;
        Emitter inner = nested_emitter(outer, group->transform, material);
        ev->emitter = &inner;
        run_items(ev, env, words + 1, words[0]);
        ev->emitter = outer;
        return true;
    }
    Value collected = collect_items(ev, env, words + 1, words[0]);
    if (is_error(collected)) {
        return false;
    }
    size_t base = ev->stack.count;
    for (uint32_t i = 0; i < given.count; ++i) {
        push_value(ev, given.items[i]);
    }
    for (uint32_t i = 0; i < collected.node->item_count; ++i) {
        push_value(ev, collected.node->items[i]);
    }
    Value all = pop_list(ev, base);
    group->items = all.items;
    group->item_count = all.count;
    return true;
}

static void begin_node(Eval *ev, NodeValue *out, uint32_t type, const char *defaults, Span at)
{
    size_t size = ev->kinds[type].type->size;
    *out = (NodeValue){
        .name = STR(""), .type = (uint16_t)type, .scene_id = NONE_ID, .color = {1, 1, 1}, .at = at};
    out->params = arena_alloc(ev->arena, size);
    memcpy(out->params, defaults, size);
    out->raw = out->params; // a group has no `finish` that would set it
}

bool build_node(Eval *ev, Env *env, AstId id, NodeValue *out, bool keep_raw)
{
    const AstNode *node = env_node(env, id);
    if (!node->aux) {
        return false; // reported by the resolver
    }
    uint32_t type = node->aux - 1u;
    const char *defaults = kind_defaults(ev, type);
    if (!defaults) {
        return false;
    }
    Span at = env_span(env, id);
    at.end = at.begin + (uint32_t)symbol_name(ev->names, node->a).length;
    if (!count_step(ev, at)) {
        return false;
    }
    begin_node(ev, out, type, defaults, at);
    const uint32_t *words = env_words(env, node->b);
    bool good = true;
    for (uint32_t i = 0; i < words[0]; ++i) {
        const AstNode *field = env_node(env, words[1 + i]);
        if (field->tag == AST_FIELD) {
            Value v = eval(ev, env, field->b);
            good = fill_field(ev, out, field->aux, v, (Where){env->module, field->b}) && good;
        }
    }
    if (ev->kinds[type].type->role == ROLE_GROUP) {
        return good && build_items(ev, env, node->b, out, keep_raw);
    }
    return good && finish_node(ev, out, env->module, node->b, keep_raw);
}

Value eval_kind(Eval *ev, Env *env, AstId id)
{
    NodeValue *node = arena_alloc(ev->arena, sizeof *node);
    return build_node(ev, env, id, node, true) ? value_node(node) : value_error();
}

Value eval_with(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    Value v = eval(ev, env, node->a);
    if (is_error(v) || !count_step(ev, env_span(env, id))) {
        return value_error();
    }
    if (v.type != VALUE_NODE) {
        char found[DESCRIBE_SIZE];
        return fail(report(ev, E0408, env_span(env, node->a),
                           "`with` changes a value of a kind, not %s",
                           describe_value(ev, v, found, sizeof found)));
    }
    NodeValue *copy = arena_alloc(ev->arena, sizeof *copy);
    size_t size = ev->kinds[v.node->type].type->size;
    *copy = *v.node;
    copy->scene_id = NONE_ID;
    copy->own = NULL;
    copy->params = arena_alloc(ev->arena, size);
    if (size) {
        memcpy(copy->params, v.node->raw, size);
    }
    const uint32_t *words = env_words(env, node->b);
    bool good = true;
    for (uint32_t i = 0; i < words[0]; ++i) {
        const AstNode *field = env_node(env, words[1 + i]);
        int index = field_index(ev, copy->type, field->a);
        if (index == FIELD_BAD) {
            Span at = env_span(env, words[1 + i]);
            at.end = at.begin + (uint32_t)symbol_name(ev->names, field->a).length;
            report_unknown_field(ev, copy->type, field->a, at);
        }
        Value part = eval(ev, env, field->b);
        good = fill_field(ev, copy, index, part, (Where){env->module, field->b}) && good;
    }
    return good && finish_node(ev, copy, env->module, node->b, true) ? value_node(copy)
                                                                     : value_error();
}

// --- Keeping nodes in the scene --------------------------------------------------------------

// Whether a node of the same type that is kept is the same.
static bool is_same_node(const Scene *scene, const NodeValue *node, Category category, uint32_t id)
{
    const SceneNode *other = scene_node(scene, category, id);
    const NodeType *type = scene->schema->types[node->type];
    return str_equal(node->name, str_from(scene->names.items[other->name])) &&
           memcmp(scene_params(scene, other), node->params, type->size) == 0;
}

uint32_t node_scene_id(Eval *ev, NodeValue *node)
{
    if (node->scene_id != NONE_ID) {
        return node->scene_id;
    }
    must_be_alone(ev);
    Scene *scene = ev->scene;
    const NodeType *type = ev->kinds[node->type].type;
    uint64_t hash = XXH3_64bits_withSeed(node->params, type->size, node->type);
    ConsSlot *slot = &ev->consed_nodes[hash % CONS_SLOTS];
    if (slot->type == node->type + 1 && slot->hash == hash &&
        is_same_node(scene, node, type->category, slot->id)) {
        return node->scene_id = slot->id;
    }
    uint32_t name = scene_add_name(scene, node->name);
    uint32_t id =
        name == NONE_ID
            ? NONE_ID
            : scene_add_node(scene, node->type, node->params,
                             (SceneNode){.material = NONE_ID, .name = name, .at = node->at});
    if (id == NONE_ID) {
        out_of_memory(ev);
    }
    *slot = (ConsSlot){hash, id, (uint16_t)(node->type + 1)};
    count_parts(ev, node, id);
    return node->scene_id = id;
}

static bool set_field(Eval *ev, NodeValue *node, Str name, Value v, Where where)
{
    int index = node_type_find_param(ev->kinds[node->type].type, name);
    return index >= 0 && fill_param(ev, node, index, v, where);
}

static Value gray_of(Eval *ev, Value v)
{
    return v.type == VALUE_NUMBER ? make_color(ev, v.number, v.number, v.number) : v;
}

Value texture_arithmetic(Eval *ev, const char *op, Value a, Value b, Where where)
{
    uint32_t type = (uint32_t)ev->texture_math;
    const char *defaults = kind_defaults(ev, type);
    if (!defaults) {
        return value_error();
    }
    NodeValue *node = arena_alloc(ev->arena, sizeof *node);
    begin_node(ev, node, type, defaults, where_span(where));
    Value op_name = {.type = VALUE_STRING, .count = (uint32_t)strlen(op), .string = op};
    bool good = set_field(ev, node, STR("op"), op_name, where) &&
                set_field(ev, node, STR("a"), gray_of(ev, a), where) &&
                set_field(ev, node, STR("b"), gray_of(ev, b), where);
    return good && finish_node(ev, node, where.module, 0, true) ? value_node(node) : value_error();
}
