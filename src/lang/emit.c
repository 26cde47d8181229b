// Items that emit: statements write their shapes, lights, cameras and settings straight into the
// scene's arrays, groups around them flattened on the way. Only where a group is wanted as a value
// (in a let, as an argument) are the items collected first.
#include "base/hash.h"
#include "lang/aside.h"

#include <stdio.h>

// --- Regions ---------------------------------------------------------------------------------

// Nothing that outlives the statement can lie in its region: lets are evaluated in the region of
// their frame, and while values are collected no region is entered.
RegionMark region_enter(Eval *ev)
{
    RegionMark mark = {.region = ev->region};
    if (!ev->emitter->collecting && ev->region + 1 < REGION_COUNT) {
        ev->arena = &ev->regions[++ev->region];
        if (!ev->arena->last) {
            arena_alloc(ev->arena, 1); // so that rewinding keeps the first block
        }
        mark.mark = arena_mark(ev->arena);
        mark.entered = true;
    }
    return mark;
}

void region_leave(Eval *ev, RegionMark mark)
{
    if (mark.entered) {
        arena_rewind(ev->arena, mark.mark);
        ev->region = mark.region;
        ev->arena = &ev->regions[ev->region];
    }
}

// --- Transforms ------------------------------------------------------------------------------

static uint64_t hash_words(const void *bytes, size_t count)
{
    uint64_t hash = count;
    for (size_t i = 0; i < count; ++i) {
        uint64_t word;
        memcpy(&word, (const char *)bytes + i * sizeof word, sizeof word);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
    }
    return hash;
}

uint32_t add_transform(Eval *ev, const Affine *transform, Span at)
{
    Scene *scene = ev->scene;
    uint64_t hash = hash_words(transform, sizeof *transform / sizeof(uint64_t));
    ConsSlot *slot = &ev->consed_transforms[hash % CONS_SLOTS];
    if (slot->type && slot->hash == hash &&
        memcmp(&scene->transforms.items[slot->id], transform, sizeof *transform) == 0) {
        return slot->id;
    }
    uint32_t id = scene_add_transform(scene, transform);
    if (id == NONE_ID) {
        Affine inverse;
        if (affine_inverse(transform, &inverse)) {
            out_of_memory(ev);
        }
        report(ev, E0507, at,
               "the transforms around this can't be undone: their product is "
               "flat, or too large or small");
        return NONE_ID;
    }
    if (id == 0) {
        return 0;
    }
    if (ev->aside && !slot->type) {
        ev->first_transforms[ev->first_transform_count++] =
            (FirstTransform){hash, (uint32_t)(slot - ev->consed_transforms), id};
    }
    *slot = (ConsSlot){hash, id, 1};
    return id;
}

Emitter nested_emitter(const Emitter *outer, const Affine *transform, uint32_t material)
{
    Emitter inner = *outer;
    inner.material = material == NONE_ID ? outer->material : material;
    if (transform) {
        inner.transform =
            outer->is_identity ? *transform : affine_multiply(&outer->transform, transform);
        inner.is_identity = false;
    }
    return inner;
}

static uint32_t emitted_transform(Eval *ev, const Affine *own, Span at)
{
    const Emitter *emitter = ev->emitter;
    if (emitter->is_identity) {
        return own ? add_transform(ev, own, at) : 0;
    }
    if (!own) {
        return add_transform(ev, &emitter->transform, at);
    }
    Affine product = affine_multiply(&emitter->transform, own);
    return add_transform(ev, &product, at);
}

static uint32_t material_id(Eval *ev, NodeValue *material)
{
    return material ? node_scene_id(ev, material) : NONE_ID;
}

// --- Nodes -----------------------------------------------------------------------------------

static bool count_object(Eval *ev, Span at)
{
    if (ev->stop) {
        return false;
    }
    if (++ev->objects > ev->lang->limits.objects) {
        Diag *diag = report(ev, E0707, at, "more than %llu objects",
                            (unsigned long long)ev->lang->limits.objects);
        diag_note(ev->sink, diag, "--limit objects=N raises this");
        stop_evaluation(ev, STOP_RUN);
        return false;
    }
    return true;
}

static uint32_t add_name(Eval *ev, Str name)
{
    if (name.length) {
        must_be_alone(ev);
    }
    uint32_t id = scene_add_name(ev->scene, name);
    if (id == NONE_ID) {
        out_of_memory(ev);
    }
    return id;
}

static uint32_t add_scene_node(Eval *ev, const NodeValue *node, const void *params, SceneNode place)
{
    uint32_t id = scene_add_node(ev->scene, node->type, params, place);
    if (id == NONE_ID) {
        out_of_memory(ev);
    }
    return id;
}

static void emit_shape(Eval *ev, const NodeValue *node)
{
    uint32_t transform = emitted_transform(ev, node->transform, node->at);
    if (!count_object(ev, node->at) || transform == NONE_ID) {
        return;
    }
    uint32_t material = material_id(ev, node->material);
    add_scene_node(ev, node, node->params,
                   (SceneNode){.transform = transform,
                               .material = material == NONE_ID ? ev->emitter->material : material,
                               .prototype = ev->emitter->prototype,
                               .name = add_name(ev, node->name),
                               .at = node->at});
}

// A light's shape is there for that light only, so each light that is emitted gets its own, with
// the whole transform to the world.
static uint32_t add_light_shape(Eval *ev, const NodeValue *light)
{
    Emitter *outer = ev->emitter;
    Emitter inner = nested_emitter(outer, light->transform, NONE_ID);
    ev->emitter = &inner;
    const NodeValue *shape = light->of;
    uint32_t transform = emitted_transform(ev, shape->transform, light->at);
    ev->emitter = outer;
    if (transform == NONE_ID) {
        return NONE_ID;
    }
    return add_scene_node(ev, shape, shape->params,
                          (SceneNode){.flags = NODE_LIGHT_ONLY,
                                      .transform = transform,
                                      .material = material_id(ev, shape->material),
                                      .name = add_name(ev, shape->name),
                                      .at = shape->at});
}

static void emit_light(Eval *ev, const NodeValue *node)
{
    must_be_alone(ev);
    uint32_t transform = emitted_transform(ev, node->transform, node->at);
    if (!count_object(ev, node->at) || transform == NONE_ID) {
        return;
    }
    const KindInfo *kind = &ev->kinds[node->type];
    void *params = node->params;
    if (node->of && kind->shape_field >= 0) {
        uint32_t shape = add_light_shape(ev, node);
        if (shape == NONE_ID) {
            return;
        }
        params = arena_alloc(ev->arena, kind->type->size);
        memcpy(params, node->params, kind->type->size);
        memcpy((char *)params + kind->type->params[kind->shape_field].offset, &shape, sizeof shape);
    }
    uint32_t id = add_scene_node(ev, node, params,
                                 (SceneNode){.transform = transform,
                                             .material = NONE_ID,
                                             .name = add_name(ev, node->name),
                                             .at = node->at});
    ev->scene->light_colors.items[id] = node->color;
}

static void emit_camera(Eval *ev, const NodeValue *node)
{
    must_be_alone(ev);
    uint32_t transform = emitted_transform(ev, node->transform, node->at);
    if (transform != NONE_ID && count_object(ev, node->at)) {
        add_scene_node(ev, node, node->params,
                       (SceneNode){.transform = transform,
                                   .material = NONE_ID,
                                   .name = add_name(ev, node->name),
                                   .at = node->at});
    }
}

static void emit_setting(Eval *ev, const NodeValue *node)
{
    must_be_alone(ev);
    const SceneNodeArray *settings = &ev->scene->nodes[CATEGORY_SETTING];
    for (size_t i = 0; i < settings->count; ++i) {
        if (settings->items[i].type == node->type) {
            Span first = settings->items[i].at;
            Place place = source_place(&ev->lang->sources, first.file, first.begin);
            Diag *diag =
                report(ev, E0505, node->at, "`%s` is set twice", ev->kinds[node->type].type->name);
            diag_label(ev->sink, diag, "already set on line %u", place.line);
            return;
        }
    }
    add_scene_node(ev, node, node->params, (SceneNode){.material = NONE_ID, .at = node->at});
}

// --- Prototypes ------------------------------------------------------------------------------

static void add_part(Eval *ev, const NodeValue *node)
{
    PrototypeRecord *record = ev->emitter->record;
    if (record->part_count == record->part_capacity) {
        uint32_t capacity = record->part_capacity ? record->part_capacity * 2 : 4;
        PrototypePart *grown = arena_array(&ev->regions[0], capacity, sizeof *grown);
        if (record->part_count) {
            memcpy(grown, record->parts, record->part_count * sizeof *grown);
        }
        record->parts = grown;
        record->part_capacity = capacity;
    }
    record->parts[record->part_count++] =
        (PrototypePart){node, ev->emitter->is_identity ? affine_identity() : ev->emitter->transform,
                        ev->emitter->material};
}

// The prototype of an instanced shape, made on first need. Its record and parts lie in the lowest
// region; they point to values of the shape itself, which live as long as it does.
static const PrototypeRecord *prototype_of(Eval *ev, NodeValue *shape)
{
    if (shape->own) {
        return shape->own;
    }
    must_be_alone(ev);
    PrototypeRecord *record = ARENA_NEW(&ev->regions[0], PrototypeRecord);
    Scene *scene = ev->scene;
    record->prototype = scene_add_prototype(scene, add_name(ev, shape->name), shape->at);
    if (record->prototype == NONE_ID) {
        out_of_memory(ev);
    }
    Emitter *outer = ev->emitter;
    Emitter emitter = {
        .is_identity = true, .material = NONE_ID, .prototype = record->prototype, .record = record};
    ev->emitter = &emitter;
    emit_node(ev, shape);
    ev->emitter = outer;
    if (scene->prototypes.items[record->prototype].shape_count == 0) {
        if (record->prototype + 1 == scene->prototypes.count) {
            --scene->prototypes.count;
        }
        record->prototype = 0;
    }
    shape->own = record;
    return record;
}

static void emit_scene_instance(Eval *ev, uint32_t prototype, const NodeValue *instance)
{
    uint32_t transform = emitted_transform(ev, NULL, instance->at);
    if (!count_object(ev, instance->at) || transform == NONE_ID) {
        return;
    }
    SceneInstance item = {.prototype = prototype,
                          .transform = transform,
                          .material = ev->emitter->material,
                          .name = add_name(ev, instance->name),
                          .at = instance->at};
    if (!array_push(&ev->scene->instances, item)) {
        out_of_memory(ev);
    }
}

// Instances of instances are flattened: the accelerator has one level.
static void emit_instance(Eval *ev, const NodeValue *node)
{
    if (stack_is_deep(ev)) {
        report_deep_stack(ev, node->at);
        return;
    }
    const PrototypeRecord *record = prototype_of(ev, node->of);
    Emitter *outer = ev->emitter;
    Emitter inner = nested_emitter(outer, node->transform, material_id(ev, node->material));
    ev->emitter = &inner;
    if (record->prototype) {
        emit_scene_instance(ev, record->prototype, node);
    }
    for (uint32_t i = 0; i < record->part_count && !ev->stop; ++i) {
        Emitter around =
            nested_emitter(&inner, &record->parts[i].transform, record->parts[i].material);
        ev->emitter = &around;
        emit_node(ev, record->parts[i].node);
    }
    ev->emitter = outer;
}

static void emit_group(Eval *ev, const NodeValue *node)
{
    if (stack_is_deep(ev)) {
        report_deep_stack(ev, node->at);
        return;
    }
    Emitter *outer = ev->emitter;
    Emitter inner = nested_emitter(outer, node->transform, material_id(ev, node->material));
    ev->emitter = &inner;
    for (uint32_t i = 0; i < node->item_count && !ev->stop; ++i) {
        emit_node(ev, node->items[i].node);
    }
    ev->emitter = outer;
}

void emit_node(Eval *ev, const NodeValue *node)
{
    if (!count_steps(ev, 1 + node->name.length / BYTES_A_STEP, node->at)) {
        return;
    }
    const NodeType *type = ev->kinds[node->type].type;
    bool is_part = type->role == ROLE_INSTANCE || type->category == CATEGORY_LIGHT ||
                   type->category == CATEGORY_CAMERA;
    if (ev->emitter->record && is_part) {
        add_part(ev, node);
    } else if (type->role == ROLE_INSTANCE) {
        emit_instance(ev, node);
    } else if (type->role == ROLE_GROUP) {
        emit_group(ev, node);
    } else if (type->category == CATEGORY_SHAPE) {
        emit_shape(ev, node);
    } else if (type->category == CATEGORY_LIGHT) {
        emit_light(ev, node);
    } else if (type->category == CATEGORY_CAMERA) {
        emit_camera(ev, node);
    } else {
        emit_setting(ev, node);
    }
}

// --- Items -----------------------------------------------------------------------------------

static bool can_stand_alone(const NodeType *type)
{
    return type->category == CATEGORY_SHAPE || type->category == CATEGORY_LIGHT ||
           type->category == CATEGORY_CAMERA || type->category == CATEGORY_SETTING;
}

static void report_standing_alone(Eval *ev, Env *env, AstId id, Value v)
{
    char found[DESCRIBE_SIZE];
    Diag *diag = report(ev, E0503, env_span(env, id), "%s standing alone does nothing",
                        describe_value(ev, v, found, sizeof found));
    if (v.type == VALUE_LIST) {
        diag_note(ev->sink, diag,
                  "items of a list are emitted by a group: "
                  "`group { items: list }`, or by `for`");
    } else if (v.type == VALUE_FUNCTION) {
        diag_label(ev->sink, diag, "to call it, write `(…)` after it");
    } else {
        diag_note(ev->sink, diag,
                  "only a shape, light, camera or setting stands as an item; "
                  "`let` names any other value");
    }
}

static void emit_value(Eval *ev, Env *env, AstId id, Value v)
{
    if (is_error(v) || v.type == VALUE_NOTHING) {
        return;
    }
    if (v.type != VALUE_NODE || !can_stand_alone(ev->kinds[v.node->type].type)) {
        report_standing_alone(ev, env, id, v);
    } else if (ev->emitter->collecting) {
        push_value(ev, v);
    } else {
        emit_node(ev, v.node);
    }
}

static bool is_emitted_kind(const Eval *ev, const AstNode *node)
{
    return node->tag == AST_KIND && node->aux && can_stand_alone(ev->kinds[node->aux - 1].type);
}

static void emit_call(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    const AstNode *callee = env_node(env, node->a);
    if (callee->tag == AST_NAME && callee->op == NAME_BUILTIN) {
        emit_value(ev, env, id, eval_call(ev, env, id));
        return;
    }
    Value f = eval(ev, env, node->a);
    if (f.type != VALUE_FUNCTION) {
        emit_value(ev, env, id, is_error(f) ? f : eval_call(ev, env, id));
        return;
    }
    Env *frame = bind_arguments(ev, env, id, f.function);
    CallFrame link;
    if (frame && enter_call(ev, &link, f.function, env_span(env, id))) {
        AstId body = fn_body(frame->module, f.function->fn);
        const AstNode *body_node = env_node(frame, body);
        if (body_node->tag == AST_BLOCK) {
            const uint32_t *words = env_words(frame, body_node->a);
            run_items(ev, frame, words + 1, words[0]);
        } else {
            emit_expression(ev, frame, body);
        }
        leave_call(ev);
    }
}

void emit_expression(Eval *ev, Env *env, AstId id)
{
    if (stack_is_deep(ev)) {
        report_deep_stack(ev, env_span(env, id));
        return;
    }
    const AstNode *node = env_node(env, id);
    if (is_emitted_kind(ev, node) && !ev->emitter->collecting) {
        NodeValue built;
        if (build_node(ev, env, id, &built, false) &&
            ev->kinds[built.type].type->role != ROLE_GROUP) {
            emit_node(ev, &built);
        }
        return;
    }
    if (node->tag == AST_CALL) {
        emit_call(ev, env, id);
        return;
    }
    if (node->tag == AST_IF) {
        const uint32_t *words = env_words(env, node->b);
        Truth truth = eval_condition(ev, env, node->a, "`if`");
        AstId chosen = truth == TRUTH_ERROR ? 0 : words[truth == TRUTH_TRUE ? 0 : 1];
        if (chosen) {
            emit_expression(ev, env, chosen);
        }
        return;
    }
    if (node->tag == AST_BLOCK) {
        const uint32_t *words = env_words(env, node->a);
        run_items(ev, env, words + 1, words[0]);
        return;
    }
    emit_value(ev, env, id, eval(ev, env, id));
}

// False where the run is to stop.
static bool run_iteration(Eval *ev, const Loop *loop, uint32_t i)
{
    Env *env = loop->env;
    const AstNode *node = env_node(env, loop->id);
    if (!count_step(ev, env_span(env, loop->id))) {
        return false;
    }
    RegionMark region = region_enter(ev);
    Env *frame = env_new(ev, env, env->module, node->aux);
    frame->slots[0] = sequence_item(loop->sequence, i);
    emit_expression(ev, frame, env_words(env, node->b)[3]);
    region_leave(ev, region);
    return true;
}

static void run_for(Eval *ev, Env *env, AstId id)
{
    Loop loop = {.env = env, .id = id, .iteration = run_iteration};
    loop.sequence = eval_sequence(ev, env, env_words(env, env_node(env, id)->b)[2]);
    if (!is_error(loop.sequence)) {
        loop_run(ev, &loop);
    }
}

static void run_item(Eval *ev, Env *env, AstId id)
{
    const AstNode *node = env_node(env, id);
    switch ((AstTag)node->tag) {
    case AST_EMIT:
        emit_expression(ev, env, node->a);
        break;
    case AST_FOR:
        run_for(ev, env, id);
        break;
    case AST_EXPECT:
        run_expect(ev, env, id);
        break;
    case AST_IF:
    case AST_BLOCK:
        emit_expression(ev, env, id);
        break;
    default: // declarations are evaluated when they are read; fields belong to their kind
        break;
    }
}

void run_items(Eval *ev, Env *env, const uint32_t *items, uint32_t count)
{
    for (uint32_t i = 0; i < count && !ev->stop; ++i) {
        run_item(ev, env, items[i]);
    }
}

Value collect_items(Eval *ev, Env *env, const uint32_t *items, uint32_t count)
{
    Emitter *outer = ev->emitter;
    Emitter emitter = {.collecting = true, .material = NONE_ID};
    size_t base = ev->stack.count;
    uint32_t errors = ev->sink->errors;
    ev->emitter = &emitter;
    run_items(ev, env, items, count);
    ev->emitter = outer;
    Value list = pop_list(ev, base);
    if (ev->sink->errors != errors) {
        return value_error();
    }
    if (ev->group_type < 0) {
        return value_error();
    }
    NodeValue *group = ARENA_NEW(ev->arena, NodeValue);
    group->type = (uint16_t)ev->group_type;
    group->scene_id = NONE_ID;
    group->name = STR("");
    group->raw = group->params = (void *)(uintptr_t)kind_defaults(ev, group->type);
    group->items = list.items;
    group->item_count = list.count;
    return value_node(group);
}
