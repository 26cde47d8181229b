// scnrender lights FILE: what each light gives, as a table.
#include "cli/commands.h"
#include "cli/load.h"
#include "render/light_report.h"
#include "schema/photometry.h"

#include <string.h>

typedef struct Ledger {
    Loading *loading;
    const World *world;
    bool with_point;
} Ledger;

enum { WIDEST_NAME = 40 };

// --- Words ---------------------------------------------------------------------------------------

static const SceneNode *light_node(const Scene *scene, const Light *light)
{
    return light->node != NONE_ID ? scene_node(scene, CATEGORY_LIGHT, light->node)
                                  : scene_node(scene, CATEGORY_SHAPE, light->shape);
}

// "lamp (room.scn:12)", or "room.scn:12".
static void describe_place(const Ledger *ledger, const Light *light, char *text, size_t size)
{
    const Scene *scene = &ledger->loading->scene;
    const SceneNode *node = light_node(scene, light);
    const char *name = scene->names.items[node->name];
    Sources *sources = &ledger->loading->lang.sources;
    const Source *source = source_get(sources, node->at.file);
    Place place = source_place(sources, node->at.file, node->at.begin);
    const char *path = source ? source->path : "?", *slash = strrchr(path, '/');
    path = slash ? slash + 1 : path;
    int length = *name ? snprintf(text, size, "%s (%s:%u)", name, path, (unsigned)place.line)
                       : snprintf(text, size, "%s:%u", path, (unsigned)place.line);
    if (light->instance != NONE_ID && length > 0 && (size_t)length < size) {
        snprintf(text + length, size - (size_t)length, " #%u", (unsigned)light->instance + 1);
    }
}

static const char *describe_kind(const Scene *scene, const Light *light)
{
    return light->node != NONE_ID ? light->class->node.name
                                  : scene_node_type(scene, light_node(scene, light))->name;
}

// "smooth_cone { inner: 25deg, outer: 30deg }"
static void print_law(const Scene *scene, Category category, uint32_t id)
{
    const SceneNode *node = scene_node(scene, category, id);
    const NodeType *type = scene_node_type(scene, node);
    const char *params = scene_params(scene, node);
    printf("%s", type->name);
    for (size_t i = 0; i < type->param_count; ++i) {
        const Param *param = &type->params[i];
        if (param->type != PARAM_NUMBER) {
            continue;
        }
        double value;
        memcpy(&value, params + param->offset, sizeof value);
        bool angle = param->dims == DIM_BIT(DIM_ANGLE), metres = param->dims == DIM_BIT(DIM_LENGTH);
        printf("%s%s: %.6g%s", i == 0 ? " { " : ", ", param->name, angle ? value * 180 / PI : value,
               angle    ? "deg"
               : metres ? "m"
                        : "");
    }
    fputs(type->param_count ? " }" : "", stdout);
}

// The law of a light: falloff and attenuation where it has them, and whether it is physical.
static void print_laws(const Ledger *ledger, const Light *light)
{
    const Scene *scene = &ledger->loading->scene;
    const NodeType *type = &light->class->node;
    uint32_t falloff = light_node_of(type, light->params, CATEGORY_FALLOFF);
    uint32_t attenuation = light_node_of(type, light->params, CATEGORY_ATTENUATION);
    if (falloff != NONE_ID) {
        print_law(scene, CATEGORY_FALLOFF, falloff);
        fputs(", ", stdout);
    }
    if (attenuation != NONE_ID) {
        print_law(scene, CATEGORY_ATTENUATION, attenuation);
    } else {
        fputs(light->class->infinite ? "at infinity" : "emits diffusely", stdout);
    }
    puts(light_is_natural(scene, light) ? "" : ": not physical");
}

// --- Figures -------------------------------------------------------------------------------------

static void print_figure(double value)
{
    if (isfinite(value)) {
        printf("  %10.5g", value);
    } else {
        fputs("           -", stdout);
    }
}

static void print_row(const Ledger *ledger, const Light *light)
{
    char place[256];
    describe_place(ledger, light, place, sizeof place);
    double flux = light_flux(light);
    printf("%-*s  %-17s", WIDEST_NAME, place, describe_kind(&ledger->loading->scene, light));
    print_figure(flux);
    print_figure(LUMENS_PER_WATT * flux);
    if (ledger->with_point) {
        double irradiance = light_irradiance(ledger->world, light, ledger->loading->options->at);
        print_figure(irradiance);
        print_figure(LUMENS_PER_WATT * irradiance);
    }
    fputs("  ", stdout);
    print_laws(ledger, light);
}

static void print_ledger(const Ledger *ledger)
{
    const LightSet *lights = ledger->world->lights;
    size_t count = light_set_count(lights);
    printf("%-*s  %-17s  %10s  %10s", WIDEST_NAME, "light", "kind", "W", "lm");
    puts(ledger->with_point ? "        W/m2          lx  law" : "  law");
    double flux = 0;
    for (size_t i = 0; i < count; ++i) {
        const Light *light = light_set_get(lights, i);
        print_row(ledger, light);
        flux += isfinite(light_flux(light)) ? light_flux(light) : 0;
    }
    char total[64];
    snprintf(total, sizeof total, "%zu light%s", count, count == 1 ? "" : "s");
    printf("%-*s  %-17s", WIDEST_NAME, total, "");
    print_figure(flux);
    print_figure(LUMENS_PER_WATT * flux);
    putchar('\n');
}

int command_lights(const Options *options)
{
    Loading loading;
    World *world = NULL;
    int code = loading_begin(&loading, options);
    if (code == EXIT_OK) {
        if (loading_evaluate(&loading)) {
            world = world_build(&loading.scene, options->threads, &loading.lang.sink);
        }
        code = loading_report(&loading);
        if (world) {
            print_ledger(&(Ledger){&loading, world, options->has_at});
        } else if (code == EXIT_OK) {
            code = EXIT_DIAGNOSTICS;
        }
    }
    world_free(world);
    loading_free(&loading);
    return code;
}
