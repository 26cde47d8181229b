// Built-in functions of what is measured: where to look, and what is to be seen there.
#include "lang/builtins.h"
#include "lang/measure.h"

static bool arg_string(Call *call, uint32_t i, const char *wanted, const char **out)
{
    if (call->args[i].type != VALUE_STRING) {
        arg_wrong(call, i, wanted);
        return false;
    }
    *out = call->args[i].string;
    return true;
}

static bool arg_corner(Call *call, uint32_t i, double *x, double *y)
{
    Value v;
    if (!arg_vector(call, i, 2, &v)) {
        return false;
    }
    if (v.dim != DIM_NONE) {
        arg_wrong(call, i, "pixels, without a unit,");
        return false;
    }
    *x = v.components[0];
    *y = v.components[1];
    return true;
}

static Value make_sight(Call *call, Sight sight)
{
    Sight *copy = arena_alloc(call->ev->arena, sizeof *copy);
    *copy = sight;
    return (Value){.type = VALUE_SIGHT, .sight = copy};
}

static Sight whole_picture(const Call *call)
{
    return (Sight){
        .kind = SIGHT_CAMERA, .x1 = INFINITY, .y1 = INFINITY, .camera_id = NONE_ID, .at = call->at};
}

Value builtin_picture(Call *call)
{
    Sight sight = whole_picture(call);
    if (call->count > 0 && !arg_string(call, 0, "the name of a camera", &sight.camera)) {
        return value_error();
    }
    return make_sight(call, sight);
}

Value builtin_region(Call *call)
{
    Sight sight = whole_picture(call);
    if (!arg_corner(call, 0, &sight.x0, &sight.y0) || !arg_corner(call, 1, &sight.x1, &sight.y1) ||
        (call->count > 2 && !arg_string(call, 2, "the name of a camera", &sight.camera))) {
        return value_error();
    }
    if (!(sight.x0 < sight.x1 && sight.y0 < sight.y1)) {
        return fail(report(call->ev, E0404, call->at,
                           "the first corner of a region is its upper left one, the second its "
                           "lower right one"));
    }
    return make_sight(call, sight);
}

Value builtin_object(Call *call)
{
    const char *name;
    if (!arg_string(call, 0, "the name of a shape", &name)) {
        return value_error();
    }
    Sight sight = whole_picture(call);
    if (call->count > 1) {
        if (call->args[1].type != VALUE_SIGHT || call->args[1].sight->object) {
            return arg_wrong(call, 1, "a region or a picture");
        }
        sight = *call->args[1].sight;
    }
    sight.object = name;
    return make_sight(call, sight);
}

Value builtin_ray(Call *call)
{
    Sight sight = {.kind = SIGHT_RAY, .camera_id = NONE_ID, .at = call->at};
    if (!arg_vec3(call, 0, &sight.origin) || !arg_vec3(call, 1, &sight.direction)) {
        return value_error();
    }
    double most = max_component(vec3_abs(sight.direction));
    if (!(most > 0)) {
        return fail(report(call->ev, E0501, arg_span(call, 1), "a direction can't be zero"));
    }
    sight.direction = normalize(scale(sight.direction, 1 / most));
    return make_sight(call, sight);
}

Value builtin_radiance(Call *call)
{
    MeasureLeaf leaf = {.sight = whole_picture(call)};
    if (call->count > 0) {
        if (call->args[0].type != VALUE_SIGHT) {
            return arg_wrong(call, 0, "a region, a picture, an object or a ray");
        }
        leaf.sight = *call->args[0].sight;
    }
    return measure_leaf(call->ev, &leaf);
}

Value builtin_coverage(Call *call)
{
    Value v = call->args[0];
    if (v.type != VALUE_SIGHT || !v.sight->object) {
        return arg_wrong(call, 0, "an object");
    }
    return measure_leaf(call->ev, &(MeasureLeaf){.sight = *v.sight, .coverage = true});
}
