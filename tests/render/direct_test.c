// The integrator `direct` against `path`: where no material follows rays on, direct light is all
// that paths of one scattering bring, and the two have the same mean whatever the lights.
#include "paired.h"

extern const IntegratorClass direct_integrator;

static CheckTable table;

// Rays from a camera at (0, 2, 6) into a window about the origin: the balls' lower halves and the
// floor before them.
static double window(const void *context, const float n[4], Ray *ray)
{
    (void)context;
    ray->origin = vec3(0, 2, 6);
    ray->direction =
        normalize(vec3(2.5 * ((double)n[0] - 0.5), -1.6 + 0.5 * ((double)n[1] - 0.5), -6));
    return 1;
}

// A floor, a matt ball and a glossy one.
static void put_things(SceneMaker *m)
{
    uint32_t white = PUT(m, "lambert", {"color", {0.7}});
    uint32_t glossy = PUT(m, "ggx", {"f0", {0.6}}, {"alpha", {0.3, 0.1}});
    uint32_t half = PUT(m, "mix", {"a", {white}}, {"b", {glossy}}, {"weight", {0.5}});
    PUT(m, "plane", {"normal", {0, 1, 0}}, {"material", {half}});
    PUT(m, "sphere", {"center", {-0.7, 0.6, 0}}, {"radius", {0.6}}, {"material", {white}});
    PUT(m, "sphere", {"center", {0.7, 0.6, 0}}, {"radius", {0.6}}, {"material", {glossy}});
}

static void put_lamp(SceneMaker *m, double x, double y, double z, double radius, double radiance)
{
    uint32_t ball = PUT_LIGHT_SHAPE(m, "sphere", {"center", {x, y, z}}, {"radius", {radius}});
    PUT(m, "area_light", {"shape", {ball}}, {"radiance", {radiance}});
}

static void put_few(SceneMaker *m)
{
    put_lamp(m, 1, 3, 2, 1, 2);
    PUT(m, "point_light", {"position", {-3, 3, 1}}, {"intensity", {6}},
        {"attenuation", {PUT_DEFAULT(m, "inverse_square")}});
    PUT(m, "environment_light", {"color", {0.3, 0.3, 0.3}});
}

// A glowing rectangle, a box of glowing material, and a sun.
static void put_panels(SceneMaker *m)
{
    uint32_t panel = PUT_LIGHT_SHAPE(m, "rectangle", {"corner", {-2, 3, -1}}, {"u", {2, 0, 0}},
                                     {"v", {0, 0, 2}});
    PUT(m, "area_light", {"shape", {panel}}, {"radiance", {3}});
    uint32_t glow = PUT(m, "emissive", {"radiance", {2}});
    PUT(m, "box", {"min", {2, 0, -1}}, {"max", {2.5, 2, 1}}, {"material", {glow}});
    PUT(m, "directional_light", {"direction", {-1, -2, -1}}, {"irradiance", {1}}, {"angle", {0.3}});
}

// More than are all sampled at each surface, and a point of light among them.
static void put_many(SceneMaker *m)
{
    for (int i = 0; i < 40; ++i) {
        put_lamp(m, -3 + 6 * (i % 8) / 7.0, 2.5 + 0.2 * (i % 3), -2 + i / 8, 0.35, 1 + i % 4);
    }
    PUT(m, "point_light", {"position", {0, 4, 4}}, {"intensity", {4}},
        {"attenuation", {PUT_DEFAULT(m, "inverse_square")}});
}

// The path tracer of one bounce is the first; the ways of sampling are the integrator's.
static void compare(const char *name, void (*put_lights)(SceneMaker *), uint32_t samples)
{
    static const Way PATH = {"path", &path_integrator, SAMPLING_MIS, false};
    static const struct {
        Way way;
        double wanted;
    } WAYS[] = {{{"mis", &direct_integrator, SAMPLING_MIS, false}, 0.03},
                {{"light", &direct_integrator, SAMPLING_LIGHT, false}, 0.05},
                {{"bsdf", &direct_integrator, SAMPLING_BSDF, false}, 0.05}};
    static Rivals rivals;
    SceneMaker maker;
    maker_init(&maker);
    put_things(&maker);
    put_lights(&maker);
    World *world = world_build(&maker.scene, 1, &maker.sink);
    if (!world) {
        abort();
    }
    world->bounces = 1;
    rivals =
        (Rivals){.world = world, .ray = window, .first = PATH, .samples = samples, .seconds = 100};
    for (int i = 0; i < 3; ++i) {
        char text[64];
        snprintf(text, sizeof text, "7 %s, path = direct, %s", name, WAYS[i].way.name);
        rivals_compare(&table, &rivals, text, &WAYS[i].way, WAYS[i].wanted);
    }
    world_free(world);
    maker_free(&maker);
}

int main(void)
{
    compare("ball, point and sky", put_few, 8192);
    compare("panels and a sun", put_panels, 8192);
    compare("forty balls", put_many, 8192);
    return check_judge(&table, "direct") ? EXIT_FAILURE : EXIT_SUCCESS;
}
