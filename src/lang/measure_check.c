// What is to be measured must be there: cameras and shapes of the names given, pixels of the
// picture. Known only when all of the scene is made.
#include "lang/measure.h"

static void report_nothing_called(Eval *ev, const Sight *sight, Category category, const char *name)
{
    const Scene *scene = ev->scene;
    const SceneNodeArray *nodes = &scene->nodes[category];
    Str best = {0};
    size_t distance = SIZE_MAX;
    for (size_t i = 0; i < nodes->count; ++i) {
        const char *other = scene->names.items[nodes->items[i].name];
        suggest_name(str_from(name), str_from(other), &best, &distance);
    }
    Diag *diag =
        report(ev, E0510, sight->at, "there is no %s called `%s`", category_name(category), name);
    if (best.length) {
        diag_label(ev->sink, diag, "did you mean `%s`?", best.at);
    }
}

// The first node of that name, or NONE_ID.
static uint32_t find_named(const Scene *scene, Category category, const char *name)
{
    const SceneNodeArray *nodes = &scene->nodes[category];
    for (uint32_t i = 0; i < nodes->count; ++i) {
        if (strcmp(scene->names.items[nodes->items[i].name], name) == 0) {
            return i;
        }
    }
    return NONE_ID;
}

// A whole number of the film, by the schema, whose films have it: as it was set, or its default.
static double film_number(Eval *ev, const char *field)
{
    int number = schema_find(ev->lang->schema, STR("film"));
    if (number < 0) {
        return 0; // a schema without pictures
    }
    const NodeType *type = ev->lang->schema->types[number];
    const char *params = scene_setting(ev->scene, "film");
    params = params ? params : kind_defaults(ev, (uint32_t)number);
    int64_t value;
    memcpy(&value, params + type->params[node_type_find_param(type, str_from(field))].offset,
           sizeof value);
    return (double)value;
}

static void check_region(Eval *ev, Sight *sight)
{
    double width = film_number(ev, "width"), height = film_number(ev, "height");
    if (!isfinite(sight->x1)) {
        sight->x1 = width;
        sight->y1 = height;
    } else if (sight->x0 < 0 || sight->y0 < 0 || sight->x1 > width || sight->y1 > height) {
        report(ev, E0510, sight->at,
               "this region isn't within the picture, which has %.0f × %.0f pixels", width, height);
    }
}

static void check_sight(Eval *ev, Sight *sight)
{
    if (sight->camera) {
        sight->camera_id = find_named(ev->scene, CATEGORY_CAMERA, sight->camera);
        if (sight->camera_id == NONE_ID) {
            report_nothing_called(ev, sight, CATEGORY_CAMERA, sight->camera);
        }
    }
    if (sight->object && find_named(ev->scene, CATEGORY_SHAPE, sight->object) == NONE_ID) {
        report_nothing_called(ev, sight, CATEGORY_SHAPE, sight->object);
    }
    if (sight->kind == SIGHT_CAMERA) {
        check_region(ev, sight);
    }
}

void check_measures(Eval *ev)
{
    const SceneExpectationArray *all = &ev->scene->expectations;
    for (size_t i = 0; i < all->count && !ev->stop; ++i) {
        const SceneMeasure *measure = all->items[i].measure;
        for (uint32_t k = 0; measure && k < measure->leaf_count; ++k) {
            check_sight(ev, &measure->leaves[k].sight);
        }
    }
}
