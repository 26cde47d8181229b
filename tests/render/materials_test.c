// Materials in scenes, against numbers that were derived on paper: glass in slabs, stacks,
// overlapping bodies, absorption, radiance within glass (reference checks 5 and 23); cut-outs,
// normal maps without leaks.
#include "paired.h"

#include "base/fresnel.h"
#include "base/mem.h"

typedef struct Lab {
    SceneMaker maker;
    World *world;
} Lab;

static CheckTable table;

static void open_lab(Lab *lab)
{
    maker_init(&lab->maker);
    lab->world = NULL;
}

static World *build(Lab *lab, int64_t bounces)
{
    world_free(lab->world);
    lab->world = world_build(&lab->maker.scene, 1, &lab->maker.sink);
    if (!lab->world || lab->maker.errors) {
        fprintf(stderr, "the scene can't be built\n");
        abort();
    }
    lab->world->bounces = bounces;
    lab->world->russian_roulette = false;
    return lab->world;
}

static void close_lab(Lab *lab)
{
    world_free(lab->world);
    maker_free(&lab->maker);
}

static double single_ray(const void *context, const float n[4], Ray *ray)
{
    (void)n;
    const Ray *given = context;
    *ray = *given;
    return 1;
}

static Ray ray_from(Vec3 origin, double theta_degrees)
{
    double t = theta_degrees * PI / 180;
    return ray_make(origin, vec3(sin(t), -cos(t), 0), 0, INFINITY);
}

// A floor that emits 1 upwards, below everything.
static void put_floor(Lab *lab)
{
    uint32_t light = PUT(&lab->maker, "emissive", {"radiance", {1}});
    PUT(&lab->maker, "rectangle", {"corner", {-1e4, -3, 1e4}}, {"u", {2e4, 0, 0}},
        {"v", {0, 0, -2e4}}, {"material", {light}});
}

static void put_slab(Lab *lab, double y0, double y1, double ior, double absorption, int priority)
{
    uint32_t glass = PUT(&lab->maker, "fresnel", {"ior", {ior}}, {"absorption", {absorption}},
                         {"priority", {priority}});
    PUT(&lab->maker, "box", {"min", {-1e4, y0, -1e4}}, {"max", {1e4, y1, 1e4}},
        {"material", {glass}});
}

// --- Layers, by adding reflections between them --------------------------------------------------

typedef struct Layer {
    double ior, thickness, absorption;
} Layer;

// The part of light that a stack of layers in air lets through, at an angle in air.
static double stack_transmits(const Layer *layers, int count, double theta_degrees)
{
    double sin_air = sin(theta_degrees * PI / 180), r_below = 0, t_below = 1;
    for (int i = count; i >= 0; --i) { // interface i lies above layer i
        double above = i > 0 ? layers[i - 1].ior : 1, below = i < count ? layers[i].ior : 1;
        double cos_above = sqrt(1 - pow(sin_air / above, 2));
        if (i < count) {
            double cos_below = sqrt(1 - pow(sin_air / below, 2));
            double e = exp(-layers[i].absorption * layers[i].thickness / cos_below);
            r_below *= e * e;
            t_below *= e;
        }
        double f = fresnel_dielectric(cos_above, below / above, NULL);
        double many = 1 / (1 - f * r_below);
        t_below = (1 - f) * t_below * many;
        r_below = f + (1 - f) * (1 - f) * r_below * many;
    }
    return t_below;
}

static void check_through(Lab *lab, const char *name, const Layer *layers, int count, double theta)
{
    char text[64];
    snprintf(text, sizeof text, "%s, %g degrees", name, theta);
    Ray ray = ray_from(vec3(0, 5, 0), theta);
    check_mean(&table, text, stack_transmits(layers, count, theta),
               estimate(build(lab, 200), single_ray, &ray, theta > 60 ? 1 << 16 : 1 << 13, 1),
               2.5e-3);
}

static void slabs(void)
{
    for (int theta = 0; theta < 90; theta += 37) {
        Lab lab;
        open_lab(&lab);
        put_floor(&lab);
        put_slab(&lab, 0, 1, 1.5, 0, 0);
        Layer clear = {1.5, 1, 0};
        double f = fresnel_dielectric(cos(theta * PI / 180), 1.5, NULL);
        double t = stack_transmits(&clear, 1, theta);
        if (!NEAR(t, (1 - f) / (1 + f), 1e-12)) { // reference check 23
            fprintf(stderr, "a slab lets %g through, not %g\n", t, (1 - f) / (1 + f));
            abort();
        }
        check_through(&lab, "23 slab", &clear, 1, theta);
        close_lab(&lab);

        open_lab(&lab);
        put_floor(&lab);
        put_slab(&lab, -0.5, 1, 1.5, 0.4, 0);
        check_through(&lab, "absorbing slab", &(Layer){1.5, 1.5, 0.4}, 1, theta);
        close_lab(&lab);
    }
}

// Glass on water, made to overlap between y = 0 and 0.3: the priorities say whose that part is.
static void overlapping_slabs(void)
{
    static const Layer GLASS_WINS[] = {{1.5, 1, 0.3}, {1.33, 1, 0.2}};
    static const Layer WATER_WINS[] = {{1.5, 0.7, 0.3}, {1.33, 1.3, 0.2}};
    for (int glass_wins = 0; glass_wins < 2; ++glass_wins) {
        for (int turned = 0; turned < 2; ++turned) {
            Lab lab;
            open_lab(&lab);
            put_floor(&lab);
            // Seen from the other side the same part passes.
            double s = turned ? -1 : 1;
            put_slab(&lab, fmin(0, s), fmax(0, s), 1.5, 0.3, glass_wins);
            put_slab(&lab, fmin(-s, 0.3 * s), fmax(-s, 0.3 * s), 1.33, 0.2, 1 - glass_wins);
            check_through(&lab, turned ? "overlap, turned" : "overlap",
                          glass_wins ? GLASS_WINS : WATER_WINS, 2, 50);
            close_lab(&lab);
        }
    }
}

// A ball of water within a ball of glass, of equal priority: the inner one replaces the outer.
static void ball_in_ball(void)
{
    Lab lab;
    open_lab(&lab);
    put_floor(&lab);
    uint32_t glass = PUT(&lab.maker, "fresnel", {"ior", {1.5}}, {"absorption", {0.5}});
    uint32_t water = PUT(&lab.maker, "fresnel", {"ior", {1.33}}, {"absorption", {0.1}});
    PUT(&lab.maker, "sphere", {"radius", {1}}, {"material", {glass}});
    PUT(&lab.maker, "sphere", {"radius", {0.5}}, {"material", {water}});
    static const Layer LAYERS[] = {{1.5, 0.5, 0.5}, {1.33, 1, 0.1}, {1.5, 0.5, 0.5}};
    check_through(&lab, "water in glass", LAYERS, 3, 0);
    close_lab(&lab);
}

// A ray to the unit sphere from somewhere around.
static double towards_ball(const void *context, const float n[4], Ray *ray)
{
    (void)context;
    double z = 1 - 2 * (double)n[0], phi = 2 * PI * (double)n[1], s = sqrt(fmax(0, 1 - z * z));
    Frame frame = frame_from_normal(vec3(s * cos(phi), s * sin(phi), z));
    double r = sqrt((double)n[2]) * 0.9999, turn = 2 * PI * (double)n[3];
    ray->origin = from_local(&frame, vec3(r * cos(turn), r * sin(turn), 3));
    ray->direction = neg(frame.n);
    return 1;
}

static void lossless_glass(void)
{
    Lab lab;
    open_lab(&lab);
    uint32_t white = PUT(&lab.maker, "fresnel", {"ior", {1.5}});
    PUT(&lab.maker, "sphere", {"material", {white}});
    PUT(&lab.maker, "environment_light", {"radiance", {1}});
    check_mean(&table, "5 glass ball in a white world", 1,
               estimate(build(&lab, 1000), towards_ball, NULL, 1 << 8, 1), 1e-3);
    build(&lab, 1000)->russian_roulette = true;
    check_mean(&table, "5 the same with roulette", 1,
               estimate(lab.world, towards_ball, NULL, 1 << 8, 1), 1e-3);
    // Within glass all radiance is eta² times as great.
    Ray inside = ray_from(vec3(0.1, 0.1, 0.2), 40);
    check_mean(&table, "radiance within glass", 2.25,
               estimate(build(&lab, 1000), single_ray, &inside, 1 << 8, 1), 1e-3);
    close_lab(&lab);
}

// The first way of a ray that begins in glass is absorbed, too: whether the camera's place is known
// to lie in it or not.
static void camera_in_glass(bool known)
{
    Lab lab;
    open_lab(&lab);
    uint32_t glass = PUT(&lab.maker, "fresnel", {"ior", {1.5}}, {"absorption", {0.7}});
    uint32_t water = PUT(&lab.maker, "fresnel", {"ior", {1.33}}, {"absorption", {0.4}});
    PUT(&lab.maker, "sphere", {"radius", {1}}, {"material", {glass}});
    if (known) {
        PUT(&lab.maker, "sphere", {"radius", {0.5}}, {"material", {water}});
        lab.maker.scene.camera = PUT(&lab.maker, "camera", {"position", {0, 0, 0}},
                                     {"direction", {0, 0, -1}}, {"fov", {1}});
    }
    PUT(&lab.maker, "environment_light", {"radiance", {1}});
    Ray ray = ray_from(vec3(0, 0, 0), 20);
    double f = 0.04, e = exp(-0.7), expected = 2.25 * (1 - f) * e / (1 - f * e * e);
    if (known) {
        // From the centre outwards and back: reflections at both interfaces.
        double g = fresnel_f0(1.5 / 1.33), ew = exp(-0.2), eg = exp(-0.35);
        double r = f * eg * eg, many = 1 / (1 - g * r);
        double t = (1 - g) * eg * (1 - f) * many, back = g + (1 - g) * (1 - g) * r * many;
        expected = 1.33 * 1.33 * ew * t / (1 - back * ew * ew);
    }
    check_mean(&table, known ? "camera in water in glass" : "ray from within glass", expected,
               estimate(build(&lab, 1000), single_ray, &ray, 1 << 10, 1), 1e-3);
    close_lab(&lab);
}

// A lamp and a floor in a body that absorbs but doesn't refract; hidden surfaces stop no light.
static void light_in_a_medium(void)
{
    Lab lab;
    open_lab(&lab);
    uint32_t fog =
        PUT(&lab.maker, "fresnel", {"ior", {1}}, {"absorption", {0.3}}, {"priority", {2}});
    uint32_t hidden =
        PUT(&lab.maker, "fresnel", {"ior", {1.8}}, {"absorption", {5}}, {"priority", {1}});
    uint32_t white = PUT(&lab.maker, "lambert", {"color", {0.8}});
    PUT(&lab.maker, "sphere", {"radius", {30}}, {"material", {fog}});
    PUT(&lab.maker, "box", {"min", {-20, 0.5, -20}}, {"max", {20, 1, 20}}, {"material", {hidden}});
    PUT(&lab.maker, "rectangle", {"corner", {-9, 0, 9}}, {"u", {18, 0, 0}}, {"v", {0, 0, -18}},
        {"material", {white}});
    lab.maker.scene.camera = PUT(&lab.maker, "camera", {"position", {0, 3, 0}},
                                 {"direction", {0, -1, 0.1}}, {"fov", {1}});
    uint32_t lamp = PUT(&lab.maker, "point_light", {"position", {0, 2, 0}}, {"intensity", {1}});
    (void)lamp;
    Ray ray = ray_from(vec3(0, 3, 0), 25);
    double x = 3 * tan(25 * PI / 180), r2 = 4 + x * x, way = hypot(3, x) + sqrt(r2);
    double lit = 0.8 / PI * 2 / pow(r2, 1.5) * exp(-0.3 * way);
    check_mean(&table, "point light in fog", lit, estimate(build(&lab, 1), single_ray, &ray, 1, 1),
               1e-3);
    close_lab(&lab);
}

// An area light in frosted glass and fog: light sampling and BSDF sampling agree, also across the
// frosted surface and hidden ones.
static void strategies_agree(void)
{
    Lab lab;
    open_lab(&lab);
    uint32_t frosted = PUT(&lab.maker, "fresnel", {"ior", {1.5}}, {"alpha", {0.5}},
                           {"absorption", {0.3}}, {"priority", {2}});
    uint32_t hidden =
        PUT(&lab.maker, "fresnel", {"ior", {1.8}}, {"absorption", {5}}, {"priority", {1}});
    uint32_t white = PUT(&lab.maker, "lambert", {"color", {0.8}});
    uint32_t lit = PUT(&lab.maker, "emissive", {"radiance", {1}});
    PUT(&lab.maker, "sphere", {"radius", {2}}, {"material", {frosted}});
    PUT(&lab.maker, "sphere", {"radius", {1.2}}, {"material", {hidden}});
    PUT(&lab.maker, "sphere", {"center", {0.3, -0.2, 0}}, {"radius", {0.5}}, {"material", {white}});
    PUT(&lab.maker, "sphere", {"center", {0, 1.2, 0.3}}, {"radius", {0.7}}, {"material", {lit}});
    Ray ray = ray_make(vec3(1, 1, 5), normalize(vec3(-0.2, -0.21, -1)), 0, INFINITY);
    static Rivals rivals;
    rivals = (Rivals){.world = build(&lab, 4),
                      .ray = single_ray,
                      .context = &ray,
                      .first = MIS,
                      .samples = 1 << 13,
                      .seconds = 400};
    rivals_compare(&table, &rivals, "7 frosted glass: light = mis", &LIGHT, 3e-2);
    rivals_compare(&table, &rivals, "7 frosted glass: bsdf = mis", &BSDF, 6e-2);
    close_lab(&lab);
}

// Light falls through cut-outs onto a floor that is seen through another: what two masks leave.
static void cut_outs(void)
{
    Lab lab;
    open_lab(&lab);
    uint32_t white = PUT(&lab.maker, "lambert", {"color", {0.8}});
    uint32_t black = PUT(&lab.maker, "lambert", {"color", {0}});
    uint32_t lace = PUT(&lab.maker, "mask", {"opacity", {0.3}}, {"base", {black}});
    uint32_t both = PUT(&lab.maker, "two_sided", {"front", {lace}}, {"back", {lace}});
    PUT(&lab.maker, "plane", {"material", {white}});
    PUT(&lab.maker, "disc", {"center", {0, 1, 0}}, {"normal", {0, 1, 0}}, {"radius", {20}},
        {"material", {lace}});
    PUT(&lab.maker, "disc", {"center", {0, 1.5, 0}}, {"normal", {0, 1, 0}}, {"radius", {20}},
        {"material", {both}});
    PUT(&lab.maker, "point_light", {"position", {0, 2, 0}}, {"intensity", {1}});
    Ray ray = ray_from(vec3(0, 5, 0), 30);
    double x = 5 * tan(PI / 6), lit = 0.8 / PI * 2 / pow(4 + x * x, 1.5);
    check_mean(&table, "light through two masks", pow(0.7, 4) * lit,
               estimate(build(&lab, 1), single_ray, &ray, 1 << 17, 1), 2e-3);
    close_lab(&lab);
}

// Cut-outs scatter nothing: what `bounces` ends goes on through them. A glowing floor seen through
// two of them, directly and in a mirror.
static void bounces_through_cut_outs(void)
{
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        Lab lab;
        open_lab(&lab);
        uint32_t black = PUT(&lab.maker, "lambert", {"color", {0}});
        uint32_t lace = PUT(&lab.maker, "mask", {"opacity", {0.3}}, {"base", {black}});
        uint32_t silver = PUT(&lab.maker, "mirror", {"color", {0.5}});
        put_floor(&lab);
        for (int i = 0; i < 2; ++i) {
            PUT(&lab.maker, "disc", {"center", {0, 1 + i, 0}}, {"normal", {0, 1, 0}},
                {"radius", {20}}, {"material", {lace}});
        }
        if (mirrored) {
            PUT(&lab.maker, "disc", {"center", {0, 4, 0}}, {"normal", {0, 1, 0}}, {"radius", {20}},
                {"material", {silver}});
        }
        Ray ray = {vec3(0, 3, 0), vec3(0, mirrored ? 1 : -1, 0), 0, INFINITY};
        check_mean(&table, mirrored ? "mirrored cut-outs, 1 bounce" : "cut-outs, no bounce",
                   (mirrored ? 0.5 : 1) * 0.49,
                   estimate(build(&lab, mirrored), single_ray, &ray, 1 << 4, 1), 1e-3);
        close_lab(&lab);
    }
}

// A floor with steep bumps, lit from below only, stays black; lit from all around by 1 it is never
// brighter than 1.
static double over_the_floor(const void *context, const float n[4], Ray *ray)
{
    (void)context;
    double phi = 2 * PI * (double)n[0], z = (double)n[1], s = sqrt(1 - z * z);
    *ray = ray_make(vec3(0, 0, 0), vec3(-s * cos(phi), -fmax(z, 1e-3), -s * sin(phi)), 0, INFINITY);
    ray->origin = scale(ray->direction, -2);
    return 1;
}

static void steep_normals(void)
{
    static const char *const BASES[] = {"lambert", "ggx"};
    for (int i = 0; i < 2; ++i) {
        Lab lab;
        open_lab(&lab);
        uint32_t base = i == 0 ? PUT(&lab.maker, "lambert", {"color", {1}})
                               : PUT(&lab.maker, "ggx", {"f0", {1}}, {"alpha", {0.2}});
        uint32_t steep = PUT(&lab.maker, "normal_map", {"base", {base}}, {"map", {0.95, 0.2, 0.6}});
        PUT(&lab.maker, "disc", {"normal", {0, 1, 0}}, {"radius", {10}}, {"material", {steep}});
        uint32_t lamp = PUT(&lab.maker, "emissive", {"radiance", {1}});
        PUT(&lab.maker, "disc", {"center", {0, -1, 0}}, {"normal", {0, 1, 0}}, {"radius", {10}},
            {"material", {lamp}});
        PUT(&lab.maker, "point_light", {"position", {1, -0.5, 0}}, {"intensity", {1}});
        Running dark = estimate(build(&lab, 3), over_the_floor, NULL, 1 << 10, 1);
        PUT(&lab.maker, "environment_light", {"radiance", {1}});
        Running bright = estimate(build(&lab, 3), over_the_floor, NULL, 1 << 10, 1);
        printf("steep normals on %s: %g from below, %.4f from all around\n", BASES[i], dark.mean,
               bright.mean);
        if (dark.mean != 0 || bright.mean > 1 || bright.mean < 0.3) {
            fprintf(stderr, "light leaks, or is made\n");
            abort();
        }
        close_lab(&lab);
    }
}

int main(void)
{
    slabs();
    overlapping_slabs();
    ball_in_ball();
    lossless_glass();
    camera_in_glass(false);
    camera_in_glass(true);
    light_in_a_medium();
    strategies_agree();
    cut_outs();
    bounces_through_cut_outs();
    steep_normals();
    return check_judge(&table, "materials") ? EXIT_FAILURE : EXIT_SUCCESS;
}
