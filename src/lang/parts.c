// What a material or a texture is made of: others, which are made of others. As values they share
// what is equal, but to find a color the renderer walks through all of it: a text of three lines,
// `fn more(m, n) = if (n == 0) m else more(mix { a: m, b: m }, n - 1)`, can ask for 2^60 steps at
// every ray. So the walk is measured where a node goes into the scene.
#include "lang/eval.h"

// The renderer's stack of a worker thread holds this many levels of the widest material.
enum { DEEPEST = 256 };

// The node that a parameter refers to, or NONE_ID; *category is its category.
static uint32_t referred(const Param *param, const char *params, Category *category)
{
    const void *value = params + param->offset;
    uint32_t id = NONE_ID;
    *category = CATEGORY_TEXTURE;
    switch (param->type) {
    case PARAM_NODE:
        *category = param->category;
        memcpy(&id, value, sizeof id);
        return id;
    case PARAM_NUMBER_TEX:
        return ((const NumberTex *)value)->texture;
    case PARAM_PAIR_TEX:
        return ((const PairTex *)value)->texture;
    case PARAM_COLOR_TEX:
        return ((const ColorTex *)value)->texture;
    case PARAM_EMISSION:
        return ((const Emission *)value)->texture;
    default:
        return NONE_ID;
    }
}

static NodePartsArray *parts_of(Eval *ev, Category category)
{
    return category == CATEGORY_MATERIAL  ? &ev->material_parts
           : category == CATEGORY_TEXTURE ? &ev->texture_parts
                                          : NULL;
}

static NodeParts measure(Eval *ev, const NodeValue *node)
{
    const NodeType *type = ev->kinds[node->type].type;
    NodeParts whole = {.parts = 1, .depth = 1};
    for (size_t i = 0; i < type->param_count; ++i) {
        Category category;
        uint32_t id = referred(&type->params[i], node->params, &category);
        const NodePartsArray *array = parts_of(ev, category);
        if (id != NONE_ID && array && id < array->count) {
            NodeParts part = array->items[id];
            whole.parts += part.parts;
            whole.depth = part.depth + 1 > whole.depth ? part.depth + 1 : whole.depth;
        }
    }
    return whole;
}

void count_parts(Eval *ev, const NodeValue *node, uint32_t id)
{
    const NodeType *type = ev->kinds[node->type].type;
    NodePartsArray *array = parts_of(ev, type->category);
    if (!array) {
        return;
    }
    NodeParts whole = measure(ev, node);
    const uint64_t most = ev->lang->limits.parts;
    if (whole.parts > most || whole.depth > DEEPEST) {
        Diag *diag = whole.depth > DEEPEST
                         ? report(ev, E0712, node->at, "a %s of more than %d others in each other",
                                  category_name(type->category), DEEPEST)
                         : report(ev, E0712, node->at, "a %s of more than %llu parts",
                                  category_name(type->category), (unsigned long long)most);
        if (whole.depth <= DEEPEST) {
            diag_note(ev->sink, diag, "--limit parts=N raises this");
        }
        whole = (NodeParts){1, 1}; // one report is enough
    }
    while (array->count <= id) { // ids are given one after another
        if (!array_push(array, ((NodeParts){1, 1}))) {
            out_of_memory(ev);
        }
    }
    array->items[id] = whole;
}
