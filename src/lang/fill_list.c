// Parameters that are lists: numbers, vectors, colors, faces, strings. They lie in the scene's
// arena.
#include "lang/eval.h"

#include <stdio.h>

static bool wrong_item(Eval *ev, const Param *param, Value v, uint32_t i, const char *wanted,
                       Where where)
{
    char found[DESCRIBE_SIZE];
    // The item itself, where the list is written out.
    const AstNode *list = &where.module->ast.nodes.items[where.node];
    const Ast *ast = &where.module->ast;
    if (list->tag == AST_LIST && i < ast_list_count(ast, list->a)) {
        AstId item = ast_list_items(ast, list->a)[i];
        if (ast->nodes.items[item].tag != AST_FOR && ast->nodes.items[item].tag != AST_IF) {
            where.node = item;
        }
    }
    report(ev, E0401, where_span(where), "`%s` takes a list of %s; item %u is %s", param->name,
           wanted, i, describe_value(ev, v, found, sizeof found));
    return false;
}

static bool item_fits(Eval *ev, const Param *param, Value v, ValueType type, int components)
{
    bool has_type = v.type == type && (components == 0 || v.small == components);
    uint32_t dims = param->dims ? param->dims : DIM_BIT(DIM_NONE);
    (void)ev;
    return has_type && (type == VALUE_STRING || v.dim == DIM_NONE || (dims & DIM_BIT(v.dim)) != 0);
}

static bool fill_numbers(Eval *ev, const Param *param, NumberList *out, Value v, Where where)
{
    out->count = v.count;
    out->items = arena_array(&ev->scene->arena, v.count, sizeof *out->items);
    for (uint32_t i = 0; i < v.count; ++i) {
        Value item = sequence_item(v, i);
        if (!item_fits(ev, param, item, VALUE_NUMBER, 0)) {
            return wrong_item(ev, param, item, i, "numbers", where);
        }
        out->items[i] = item.number;
        if (!check_range(ev, param, &item.number, 1, item.dim, where)) {
            return false;
        }
    }
    return true;
}

static bool fill_vectors(Eval *ev, const Param *param, Vec3List *out, Value v, Where where)
{
    out->count = v.count;
    out->items = arena_array(&ev->scene->arena, v.count, sizeof *out->items);
    for (uint32_t i = 0; i < v.count; ++i) {
        Value item = sequence_item(v, i);
        if (!item_fits(ev, param, item, VALUE_VECTOR, 3)) {
            return wrong_item(ev, param, item, i, "vectors of 3", where);
        }
        const double *c = item.components;
        out->items[i] = vec3(c[0], c[1], c[2]);
    }
    return true;
}

static bool fill_pairs(Eval *ev, const Param *param, Vec2List *out, Value v, Where where)
{
    out->count = v.count;
    out->items = arena_array(&ev->scene->arena, v.count, sizeof *out->items);
    for (uint32_t i = 0; i < v.count; ++i) {
        Value item = sequence_item(v, i);
        if (!item_fits(ev, param, item, VALUE_VECTOR, 2)) {
            return wrong_item(ev, param, item, i, "vectors of 2", where);
        }
        out->items[i] = (Vec2){item.components[0], item.components[1]};
    }
    return true;
}

static bool fill_colors(Eval *ev, const Param *param, RgbList *out, Value v, Where where)
{
    out->count = v.count;
    out->items = arena_array(&ev->scene->arena, v.count, sizeof *out->items);
    for (uint32_t i = 0; i < v.count; ++i) {
        Value item = sequence_item(v, i);
        if (item.type != VALUE_COLOR) {
            return wrong_item(ev, param, item, i, "colors", where);
        }
        const double *c = item.components;
        out->items[i] = (Rgb){(float)c[0], (float)c[1], (float)c[2]};
    }
    return true;
}

static bool fill_strings(Eval *ev, const Param *param, StringList *out, Value v, Where where)
{
    out->count = v.count;
    out->items = arena_array(&ev->scene->arena, v.count, sizeof *out->items);
    for (uint32_t i = 0; i < v.count; ++i) {
        Value item = sequence_item(v, i);
        if (item.type != VALUE_STRING) {
            return wrong_item(ev, param, item, i, "strings", where);
        }
        if (!count_steps(ev, item.count / BYTES_A_STEP, where_span(where))) {
            return false;
        }
        out->items[i] = keep_string(ev, (Str){item.string, item.count});
    }
    return true;
}

// A face: a list of indices, or a vector of them. The mesh says whether they are enough.
static bool is_face(Value face)
{
    return face.type == VALUE_LIST || face.type == VALUE_RANGE ||
           (face.type == VALUE_VECTOR && face.dim == DIM_NONE);
}

static uint32_t face_size(Value face)
{
    return face.type == VALUE_VECTOR ? face.small : face.count;
}

static bool face_index(Value face, uint32_t i, uint32_t *out)
{
    Value item = face.type == VALUE_VECTOR ? value_number(face.components[i], DIM_NONE)
                                           : sequence_item(face, i);
    bool good = is_bare(item) && item.number >= 0 && item.number < UINT32_MAX &&
                item.number == floor(item.number);
    *out = good ? (uint32_t)item.number : 0;
    return good;
}

static bool fill_faces(Eval *ev, const Param *param, FaceList *out, Value v, Where where)
{
    uint64_t total = 0;
    for (uint32_t i = 0; i < v.count; ++i) {
        Value face = sequence_item(v, i);
        if (!is_face(face)) {
            return wrong_item(ev, param, face, i, "lists of indices", where);
        }
        total += face_size(face);
    }
    if (total > UINT32_MAX) { // excepted: that takes 2^32 indices
        report(ev, E0706, where_span(where), "`%s` has too many indices", param->name);
        return false;
    }
    out->count = v.count;
    out->index_count = (uint32_t)total;
    out->sizes = arena_array(&ev->scene->arena, v.count, sizeof *out->sizes);
    out->indices = arena_array(&ev->scene->arena, total, sizeof *out->indices);
    uint32_t at = 0;
    for (uint32_t i = 0; i < v.count; ++i) {
        Value face = sequence_item(v, i);
        out->sizes[i] = face_size(face);
        for (uint32_t k = 0; k < out->sizes[i]; ++k) {
            if (!face_index(face, k, &out->indices[at++])) {
                report(ev, E0412, where_span(where),
                       "`%s`: index %u of face %u is not a whole number from 0 on", param->name, k,
                       i);
                return false;
            }
        }
    }
    return true;
}

bool fill_list(Eval *ev, const Param *param, void *out, Value v, Where where)
{
    if (v.type != VALUE_LIST && v.type != VALUE_RANGE) {
        return wrong_type(ev, param, v, where);
    }
    must_be_alone(ev); // it goes into the scene's arena
    if (!count_values(ev, v.count, where_span(where))) {
        return false;
    }
    switch (param->type) {
    case PARAM_NUMBER_LIST:
        return fill_numbers(ev, param, out, v, where);
    case PARAM_VEC2_LIST:
        return fill_pairs(ev, param, out, v, where);
    case PARAM_VEC3_LIST:
        return fill_vectors(ev, param, out, v, where);
    case PARAM_COLOR_LIST:
        return fill_colors(ev, param, out, v, where);
    case PARAM_FACE_LIST:
        return fill_faces(ev, param, out, v, where);
    default:
        return fill_strings(ev, param, out, v, where);
    }
}
