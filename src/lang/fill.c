// Filling the parameter struct of a kind from values, as the schema's table says.
#include "lang/eval.h"

#include <stdio.h>
#include <unistd.h>

const char *keep_string(Eval *ev, Str text)
{
    must_be_alone(ev);
    Symbol symbol = intern(&ev->strings, text);
    if (!symbol) {
        out_of_memory(ev);
    }
    return symbol_name(&ev->strings, symbol).at;
}

// --- Reports ---------------------------------------------------------------------------------

// The text of a short expression as it stands in the source; empty for long ones.
static Str source_text(Eval *ev, Where where)
{
    Span span = where_span(where);
    const Source *source = source_get(&ev->lang->sources, span.file);
    if (!source || span.end > source->text.length || span.end - span.begin > 60) {
        return (Str){0};
    }
    return (Str){source->text.at + span.begin, span.end - span.begin};
}

// A vector where a color is wanted: the author means rgb(…).
static bool vector_is_no_color(Eval *ev, const Param *param, Value v, Where where)
{
    Diag *diag = report(ev, E0406, where_span(where), "`%s` takes a color; a vector is not a color",
                        param->name);
    Str text = source_text(ev, where);
    char fix[80];
    if (v.small != 3) {
        diag_note(ev->sink, diag, "a color has three components: rgb(r, g, b)");
    } else if (where.module->ast.nodes.items[where.node].tag == AST_VECTOR && text.length) {
        snprintf(fix, sizeof fix, "rgb%.*s", (int)text.length, text.at);
        diag_suggest(ev->sink, diag, where_span(where), fix);
    } else if (text.length) {
        snprintf(fix, sizeof fix, "rgb(%.*s)", (int)text.length, text.at);
        diag_suggest(ev->sink, diag, where_span(where), fix);
    }
    return false;
}

static bool takes_color(const Param *param)
{
    return param->type == PARAM_COLOR || param->type == PARAM_COLOR_TEX ||
           param->type == PARAM_COLOR_LIST;
}

bool wrong_type(Eval *ev, const Param *param, Value v, Where where)
{
    if (v.type == VALUE_VECTOR && (takes_color(param) || param->type == PARAM_EMISSION)) {
        return vector_is_no_color(ev, param, v, where);
    }
    char wanted[DESCRIBE_SIZE * 2], found[DESCRIBE_SIZE], fix[80];
    Diag *diag = report(ev, E0401, where_span(where), "`%s` takes %s, not %s", param->name,
                        describe_param(param, wanted, sizeof wanted),
                        describe_value(ev, v, found, sizeof found));
    Str text = source_text(ev, where);
    if (is_bare(v) && takes_color(param) && text.length) {
        snprintf(fix, sizeof fix, "gray(%.*s)", (int)text.length, text.at);
        diag_suggest(ev->sink, diag, where_span(where), fix);
    }
    if (v.type == VALUE_COLOR && param->type == PARAM_VEC3) {
        diag_note(ev->sink, diag, "a color is not a vector; write (x, y, z)");
    }
    return false;
}

static bool wrong_dim(Eval *ev, const Param *param, Value v, Where where)
{
    char wanted[DESCRIBE_SIZE * 2], found[DESCRIBE_SIZE], fix[80];
    uint32_t named = param->dims & ~DIM_BIT(DIM_NONE);
    if (v.type == VALUE_VECTOR && named) {
        snprintf(wanted, sizeof wanted, "a vector with the dimension %s",
                 dim_info((Dim)__builtin_ctz(named))->name);
    } else {
        describe_param(param, wanted, sizeof wanted);
    }
    describe_value(ev, v, found, sizeof found);
    bool needs_angle = v.dim == DIM_NONE && (param->dims & DIM_BIT(DIM_ANGLE));
    Diag *diag =
        report(ev, E0403, where_span(where),
               needs_angle ? "`%s` takes %s: an angle needs a unit" : "`%s` takes %s, not %s",
               param->name, wanted, found);
    Str text = source_text(ev, where);
    const AstNode *node = &where.module->ast.nodes.items[where.node];
    bool is_literal = node->tag == AST_NUMBER || (node->tag == AST_UNARY && text.length < 12);
    if (needs_angle && is_literal && text.length) {
        snprintf(fix, sizeof fix, "%.*sdeg", (int)text.length, text.at);
        diag_suggest(ev->sink, diag, where_span(where), fix);
    } else if (needs_angle) {
        diag_note(ev->sink, diag, "multiply by 1deg or 1rad");
    }
    return false;
}

// --- Checks ----------------------------------------------------------------------------------

bool check_dim(Eval *ev, const Param *param, Value v, Where where)
{
    uint32_t dims = param->dims ? param->dims : DIM_BIT(DIM_NONE);
    // A bare number is in the field's SI unit, except where only an angle will do.
    bool fits = v.dim == DIM_NONE ? dims != DIM_BIT(DIM_ANGLE) : (dims & DIM_BIT(v.dim)) != 0;
    return fits || wrong_dim(ev, param, v, where);
}

static void format_limit(double number, uint8_t dim, char *text, size_t size)
{
    char digits[40];
    format_number(dim == DIM_ANGLE ? number * (180 / PI) : number, digits, sizeof digits);
    snprintf(text, size, "%s%s", digits, dim == DIM_ANGLE ? "deg" : dim_info((Dim)dim)->si_unit);
}

static bool out_of_range(Eval *ev, const Param *param, double number, uint8_t dim, Where where)
{
    char is[64], min[64], max[64];
    format_limit(number, dim, is, sizeof is);
    format_limit(param->min, dim, min, sizeof min);
    format_limit(param->max, dim, max, sizeof max);
    const char *above = param->flags & PARAM_EXCLUDE_MIN ? "greater than" : "at least";
    const char *below = param->flags & PARAM_EXCLUDE_MAX ? "less than" : "at most";
    if (!isinf(param->min) && !isinf(param->max)) {
        report(ev, E0404, where_span(where), "`%s` must be %s %s and %s %s, this is %s",
               param->name, above, min, below, max, is);
    } else if (!isinf(param->min)) {
        report(ev, E0404, where_span(where), "`%s` must be %s %s, this is %s", param->name, above,
               min, is);
    } else {
        report(ev, E0404, where_span(where), "`%s` must be %s %s, this is %s", param->name, below,
               max, is);
    }
    return false;
}

bool check_range(Eval *ev, const Param *param, const double *numbers, size_t count, uint8_t dim,
                 Where where)
{
    double min = param->min, max = param->max;
    if (min == 0 && max == 0) {
        return true;
    }
    for (size_t i = 0; i < count; ++i) {
        double number = numbers[i];
        bool low = param->flags & PARAM_EXCLUDE_MIN ? number <= min : number < min;
        bool high = param->flags & PARAM_EXCLUDE_MAX ? number >= max : number > max;
        if (low || high) {
            uint8_t unit = dim == DIM_NONE && param->dims && (param->dims & (param->dims - 1)) == 0
                               ? (uint8_t)__builtin_ctz(param->dims)
                               : dim;
            return out_of_range(ev, param, number, unit, where);
        }
    }
    return true;
}

// --- Single values ---------------------------------------------------------------------------

static bool take_number(Eval *ev, const Param *param, Value v, Where where, double *out)
{
    if (v.type != VALUE_NUMBER) {
        return wrong_type(ev, param, v, where);
    }
    *out = v.number;
    return check_dim(ev, param, v, where) && check_range(ev, param, &v.number, 1, v.dim, where);
}

// A vector of `count` components.
static bool take_vector(Eval *ev, const Param *param, Value v, int count, Where where, double *out)
{
    if (v.type != VALUE_VECTOR || v.small != count) {
        return wrong_type(ev, param, v, where);
    }
    memcpy(out, v.components, (size_t)count * sizeof *out);
    return check_dim(ev, param, v, where) &&
           check_range(ev, param, out, (size_t)count, v.dim, where);
}

// A number for both, or a vector of 2.
static bool take_pair(Eval *ev, const Param *param, Value v, Where where, double *out)
{
    if (v.type == VALUE_NUMBER) {
        bool good = take_number(ev, param, v, where, out);
        out[1] = out[0];
        return good;
    }
    return take_vector(ev, param, v, 2, where, out);
}

static bool take_color(Eval *ev, const Param *param, Value v, Where where, Rgb *out)
{
    if (v.type != VALUE_COLOR) {
        return wrong_type(ev, param, v, where);
    }
    *out = (Rgb){(float)v.components[0], (float)v.components[1], (float)v.components[2]};
    if (!rgb_is_finite(*out)) {
        report(ev, E0404, where_span(where), "`%s` is too large", param->name);
        return false;
    }
    return check_range(ev, param, v.components, 3, DIM_NONE, where);
}

static bool unit_vector(Eval *ev, const Param *param, Where where, Vec3 *out)
{
    double most = max_component(vec3_abs(*out));
    if (!(most > 0)) {
        report(ev, E0404, where_span(where), "`%s` is a direction and can't be zero", param->name);
        return false;
    }
    *out = normalize(scale(*out, 1 / most)); // no overflow or underflow of the squares
    return true;
}

static bool take_whole(Eval *ev, const Param *param, Value v, Where where, int64_t *out)
{
    double number = 0;
    if (!take_number(ev, param, v, where, &number)) {
        return false;
    }
    if (number != floor(number) || fabs(number) > 0x1p53) {
        char text[40];
        format_number(number, text, sizeof text);
        report(ev, E0412, where_span(where), "`%s` takes a whole number, not %s", param->name,
               text);
        return false;
    }
    *out = (int64_t)number;
    return true;
}

static bool take_choice(Eval *ev, const Param *param, Value v, Where where, int32_t *out)
{
    if (v.type != VALUE_STRING) {
        return wrong_type(ev, param, v, where);
    }
    Str given = {v.string, v.count}, best = {0};
    size_t distance = SIZE_MAX;
    for (int32_t i = 0; param->choices[i]; ++i) {
        Str choice = str_from(param->choices[i]);
        if (str_equal(choice, given)) {
            *out = i;
            return true;
        }
        suggest_name(given, choice, &best, &distance);
    }
    char wanted[DESCRIBE_SIZE * 2], fix[80];
    Diag *diag =
        report(ev, E0407, where_span(where), "`%s` can't be \"%.60s\"", param->name, v.string);
    if (best.length) {
        snprintf(fix, sizeof fix, "\"%s\"", best.at);
        diag_suggest(ev->sink, diag, where_span(where), fix);
    }
    diag_note(ev->sink, diag, "%s takes %s", param->name,
              describe_param(param, wanted, sizeof wanted));
    return false;
}

// Whether the file is there and may be read; once for each.
static IoError check_file(Eval *ev, const char *path)
{
    int fd;
    uint64_t size;
    if (interned(&ev->strings, str_from(path))) {
        return IO_OK; // it was checked
    }
    IoError error = sandbox_open(ev->lang->sandbox, path, &fd, &size);
    if (error == IO_OK) {
        close(fd);
    }
    return error;
}

// A name in a file is relative to that file, wherever the string was passed on to.
static bool take_file(Eval *ev, const Param *param, Value v, Where where, const char **out)
{
    if (v.type != VALUE_STRING) {
        return wrong_type(ev, param, v, where);
    }
    must_be_alone(ev);
    const Module *origin = ev->modules.items[v.small];
    const char *from = source_get(&ev->lang->sources, origin->file)->real;
    const char *path;
    IoError error =
        sandbox_resolve(ev->lang->sandbox, ev->arena, from, (Str){v.string, v.count}, &path);
    error = error == IO_OK ? check_file(ev, path) : error;
    if (error == IO_NO_MEMORY) {
        out_of_memory(ev);
    }
    if (error != IO_OK) {
        Diag *diag = report(ev, E0603, where_span(where), "`%s`: \"%.200s\" can't be read: %s",
                            param->name, v.string, io_error_text(error));
        if (error == IO_OUTSIDE) {
            diag_note(ev->sink, diag, "--allow-path FOLDER lets scenes read there");
        }
        return false;
    }
    *out = keep_string(ev, str_from(path));
    return true;
}

// --- Nodes and textures ----------------------------------------------------------------------

static bool is_of(const Eval *ev, Value v, Category category)
{
    return v.type == VALUE_NODE && ev->kinds[v.node->type].type->category == category;
}

// A function with a block body gives a group: one shape in it, and nothing done to it, is meant.
static NodeValue *only_shape(const Eval *ev, NodeValue *node)
{
    while (ev->kinds[node->type].type->role == ROLE_GROUP && node->item_count == 1 &&
           !node->transform && !node->material) {
        node = node->items[0].node;
    }
    return node;
}

static bool take_node(Eval *ev, NodeValue *owner, const Param *param, Value v, Where where,
                      uint32_t *out)
{
    if (!is_of(ev, v, param->category)) {
        return wrong_type(ev, param, v, where);
    }
    if (param->category != CATEGORY_SHAPE) {
        *out = node_scene_id(ev, v.node);
        return true;
    }
    NodeValue *shape = only_shape(ev, v.node);
    if (ev->kinds[shape->type].type->role != ROLE_PLAIN ||
        ev->kinds[shape->type].type->category != CATEGORY_SHAPE) {
        char found[DESCRIBE_SIZE];
        report(ev, E0401, where_span(where), "`%s` takes a single shape, not %s", param->name,
               describe_value(ev, v, found, sizeof found));
        return false;
    }
    owner->of = shape; // goes into the scene with its owner
    return true;
}

static bool take_number_texture(Eval *ev, const Param *param, Value v, Where where, NumberTex *out)
{
    if (is_of(ev, v, CATEGORY_TEXTURE)) {
        out->value = 1;
        out->texture = node_scene_id(ev, v.node);
        return true;
    }
    out->texture = NONE_ID;
    return take_number(ev, param, v, where, &out->value);
}

static bool take_pair_texture(Eval *ev, const Param *param, Value v, Where where, PairTex *out)
{
    if (is_of(ev, v, CATEGORY_TEXTURE)) {
        *out = (PairTex){{1, 1}, node_scene_id(ev, v.node)};
        return true;
    }
    double pair[2] = {0};
    bool good = take_pair(ev, param, v, where, pair);
    *out = (PairTex){{pair[0], pair[1]}, NONE_ID};
    return good;
}

static bool take_color_texture(Eval *ev, const Param *param, Value v, Where where, ColorTex *out)
{
    if (is_of(ev, v, CATEGORY_TEXTURE)) {
        *out = (ColorTex){{1, 1, 1}, node_scene_id(ev, v.node)};
        return true;
    }
    out->texture = NONE_ID;
    return take_color(ev, param, v, where, &out->value);
}

static bool take_emission(Eval *ev, const Param *param, Value v, Where where, Emission *out)
{
    memset(out, 0, sizeof *out); // padding too: equal parameters are equal bytes
    out->texture = NONE_ID;
    if (is_of(ev, v, CATEGORY_TEXTURE)) {
        out->value = (Rgb){1, 1, 1};
        out->texture = node_scene_id(ev, v.node);
        return true;
    }
    if (v.type == VALUE_COLOR) {
        return take_color(ev, param, v, where, &out->value);
    }
    double number = 0;
    if (!take_number(ev, param, v, where, &number)) {
        return false;
    }
    out->value = rgb_gray((float)number);
    out->dim = v.dim;
    out->is_number = true;
    if (!isfinite((float)number)) {
        report(ev, E0404, where_span(where), "`%s` is too large", param->name);
        return false;
    }
    return true;
}

static bool store(Eval *ev, NodeValue *node, const Param *param, void *out, Value v, Where where)
{
    double numbers[3] = {0};
    switch (param->type) {
    case PARAM_BOOL:
        if (v.type != VALUE_BOOL) {
            return wrong_type(ev, param, v, where);
        }
        *(bool *)out = v.boolean;
        return true;
    case PARAM_INT:
        return take_whole(ev, param, v, where, out);
    case PARAM_NUMBER:
        return take_number(ev, param, v, where, out);
    case PARAM_QUANTITY:
        ((Quantity *)out)->dim = v.dim;
        return take_number(ev, param, v, where, &((Quantity *)out)->value);
    case PARAM_PAIR:
    case PARAM_VEC2: {
        bool good = param->type == PARAM_PAIR ? take_pair(ev, param, v, where, numbers)
                                              : take_vector(ev, param, v, 2, where, numbers);
        *(Vec2 *)out = (Vec2){numbers[0], numbers[1]};
        return good;
    }
    case PARAM_VEC3: {
        bool good = take_vector(ev, param, v, 3, where, numbers);
        Vec3 *place = out;
        *place = vec3(numbers[0], numbers[1], numbers[2]);
        return good &&
               (!(param->flags & PARAM_UNIT_VECTOR) || unit_vector(ev, param, where, place));
    }
    case PARAM_COLOR:
        return take_color(ev, param, v, where, out);
    case PARAM_EMISSION:
        return take_emission(ev, param, v, where, out);
    case PARAM_NUMBER_TEX:
        return take_number_texture(ev, param, v, where, out);
    case PARAM_PAIR_TEX:
        return take_pair_texture(ev, param, v, where, out);
    case PARAM_COLOR_TEX:
        return take_color_texture(ev, param, v, where, out);
    case PARAM_STRING:
        if (v.type != VALUE_STRING) {
            return wrong_type(ev, param, v, where);
        }
        if (!count_steps(ev, v.count / BYTES_A_STEP, where_span(where))) {
            return false;
        }
        *(const char **)out = keep_string(ev, (Str){v.string, v.count});
        return true;
    case PARAM_CHOICE:
        return take_choice(ev, param, v, where, out);
    case PARAM_FILE:
        return take_file(ev, param, v, where, out);
    case PARAM_NODE:
        return take_node(ev, node, param, v, where, out);
    default:
        return fill_list(ev, param, out, v, where);
    }
}

bool fill_param(Eval *ev, NodeValue *node, int index, Value v, Where where)
{
    const Param *param = &ev->kinds[node->type].type->params[index];
    node->set |= (uint64_t)1 << index;
    return store(ev, node, param, (char *)node->params + param->offset, v, where);
}

// --- Transforms ------------------------------------------------------------------------------

static bool multiply_transforms(Eval *ev, Value v, Where where, Affine *product)
{
    if (v.type == VALUE_TRANSFORM) { // what comes later in the list is applied later
        *product = affine_multiply(v.transform, product);
        return true;
    }
    if (v.type == VALUE_LIST && stack_is_deep(ev)) {
        return report_deep_stack(ev, where_span(where));
    }
    if (v.type == VALUE_LIST) {
        if (!count_values(ev, v.count, where_span(where))) {
            return false;
        }
        for (uint32_t i = 0; i < v.count; ++i) {
            if (!multiply_transforms(ev, v.items[i], where, product)) {
                return false;
            }
        }
        return true;
    }
    char found[DESCRIBE_SIZE];
    Diag *diag = report(ev, E0401, where_span(where),
                        "`transform` takes a transform or a list of transforms, not %s",
                        describe_value(ev, v, found, sizeof found));
    if (v.type == VALUE_VECTOR) {
        diag_note(ev->sink, diag, "translate(v) moves by a vector");
    }
    return false;
}

bool fill_transform(Eval *ev, Value v, Where where, Affine *out)
{
    *out = affine_identity();
    return multiply_transforms(ev, v, where, out);
}
