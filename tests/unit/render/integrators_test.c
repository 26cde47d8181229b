// The integrators without noise, and the views, at points where their values are known on paper.
#include "../test_support.h"

#include "../../render/scene_maker.h"
#include "base/fresnel.h"
#include "render/integrator.h"
#include "render/world.h"

typedef struct Lab {
    SceneMaker maker;
    World *world;
} Lab;

static int setup(void **state)
{
    Lab *lab = calloc(1, sizeof *lab);
    if (!lab) {
        return 1;
    }
    maker_init(&lab->maker);
    *state = lab;
    return 0;
}

static int teardown(void **state)
{
    Lab *lab = *state;
    world_free(lab->world);
    maker_free(&lab->maker);
    free(lab);
    return 0;
}

static World *build(Lab *lab)
{
    world_free(lab->world);
    lab->world = world_build(&lab->maker.scene, 1, &lab->maker.sink);
    if (!lab->world) {
        fail_msg("%s", lab->maker.sink.items[0].message);
    }
    return lab->world;
}

static const IntegratorClass *integrator(const char *name)
{
    for (size_t i = 0; integrator_classes[i]; ++i) {
        if (strcmp(integrator_classes[i]->name, name) == 0) {
            return integrator_classes[i];
        }
    }
    fail_msg("no integrator %s", name);
    return NULL;
}

// The radiance along a ray from `from` towards `to`, with the numbers of sample `number`.
static Rgb seen(const World *world, const char *name, Vec3 from, Vec3 to, uint32_t number)
{
    Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
    Sampler sampler;
    IntegratorStats stats = {0};
    sampler_start(&sampler, 1, 2, 3, number);
    Rgb found = integrator(name)->radiance(world, &ray, &sampler, NULL, &stats);
    assert_true(rgb_is_finite(found));
    return found;
}

static void check_rgb(Rgb found, double r, double g, double b, double tolerance)
{
    double worst =
        fmax(fmax(fabs((double)found.r - r), fabs((double)found.g - g)), fabs((double)found.b - b));
    if (!(worst <= tolerance)) {
        fail_msg("(%.9g, %.9g, %.9g) is not (%.9g, %.9g, %.9g)", (double)found.r, (double)found.g,
                 (double)found.b, r, g, b);
    }
}

// --- local ---------------------------------------------------------------------------------------

// Equation (3) on a plane at a point under three lights: a directional one, a point and a spot, of
// which the last two are taken with their attenuation. All is written out here.
static void local_is_equation_3(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    uint32_t material = PUT(m, "phong", {"color", {0.8, 0.4, 0.2}}, {"ambient", {0.1}},
                            {"diffuse", {0.5}}, {"specular", {0.3}}, {"shininess", {7}});
    PUT(m, "plane", {"normal", {0, 1, 0}}, {"material", {material}});
    PUT(m, "directional_light", {"direction", {1, -2, 0.5}}, {"irradiance", {2}},
        {"color", {1, 0.5, 0.25}});
    uint32_t constant = PUT_DEFAULT(m, "constant");
    PUT(m, "point_light", {"position", {1, 2, 0}}, {"intensity", {3}}, {"attenuation", {constant}});
    uint32_t lobe = PUT(m, "cosine_lobe", {"exponent", {4}});
    uint32_t natural = PUT_DEFAULT(m, "inverse_square");
    PUT(m, "spot_light", {"position", {0, 2, 1}}, {"direction", {0, -1, 0}}, {"intensity", {10}},
        {"falloff", {lobe}}, {"attenuation", {natural}});
    World *world = build(lab);

    Vec3 p = {0.5, 0, -0.5}, eye = {-1, 3, 2}, n = {0, 1, 0}, v = normalize(sub(eye, p));
    Vec3 sun = normalize(vec3(-1, 2, -0.5));
    Vec3 to_point = sub(vec3(1, 2, 0), p), to_spot = sub(vec3(0, 2, 1), p);
    double r = length(to_spot), cosine = to_spot.y / r;
    const struct {
        Vec3 l;
        Rgb s;
    } lights[] = {
        {sun, {2, 1, 0.5f}},
        {normalize(to_point), {3, 3, 3}},
        {normalize(to_spot), rgb_gray((float)(10 * pow(cosine, 4) / (r * r)))},
    };
    double sum[3] = {0};
    const double color[3] = {0.8, 0.4, 0.2};
    for (size_t i = 0; i < TEST_COUNT(lights); ++i) {
        Vec3 l = lights[i].l, mirrored = sub(scale(n, 2 * dot(l, n)), l);
        double specular = 0.3 * pow(fmax(0, dot(mirrored, v)), 7);
        const double s[3] = {(double)lights[i].s.r, (double)lights[i].s.g, (double)lights[i].s.b};
        for (int c = 0; c < 3; ++c) {
            sum[c] += s[c] * (0.1 * color[c] + 0.5 * color[c] * dot(n, l) + specular);
        }
    }
    assert_true(sum[0] > 1 && sum[2] > 0.1);
    check_rgb(seen(world, "local", eye, p, 0), sum[0], sum[1], sum[2], 2e-6);
    assert_int_equal(m->sink.count, 0);
}

// A ball between the light and the plane takes away all but the ambient term, if shadows are asked
// for; a light behind the surface leaves the ambient term, too.
static void local_shadows(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    uint32_t material = PUT(m, "blinn_phong", {"color", {0.5}}, {"ambient", {0.2}},
                            {"diffuse", {0.6}}, {"specular", {0.4}}, {"shininess", {3}});
    uint32_t constant = PUT_DEFAULT(m, "constant");
    PUT(m, "plane", {"normal", {0, 1, 0}}, {"material", {material}});
    PUT(m, "sphere", {"center", {0, 2, 0}}, {"radius", {0.5}}, {"material", {material}});
    PUT(m, "point_light", {"position", {0, 4, 0}}, {"intensity", {2}}, {"attenuation", {constant}});
    World *world = build(lab);
    Vec3 eye = {3, 4, 0}, below = {0, 0, 0}, beside = {0, 0, 3};
    double h = normalize(add(normalize(eye), vec3(0, 1, 0))).y;
    double lit = 2 * (0.2 * 0.5 + 0.6 * 0.5 + 0.4 * pow(h, 3));

    assert_true(world->shadows); // the default
    check_rgb(seen(world, "local", eye, below, 0), 0.2, 0.2, 0.2, 1e-6);
    world->shadows = false;
    check_rgb(seen(world, "local", eye, below, 0), lit, lit, lit, 2e-6);
    Rgb without = seen(world, "local", eye, beside, 0);
    world->shadows = true;
    Rgb with = seen(world, "local", eye, beside, 0); // in no shadow
    assert_true(with.g == without.g && with.g > 0.25f);

    // From below, the light is behind the plane.
    check_rgb(seen(world, "local", vec3(1, -2, 0), below, 0), 0.2, 0.2, 0.2, 1e-6);
    check_rgb(seen(world, "local", eye, vec3(3, 9, 9), 0), 0, 0, 0, 0); // nothing is hit
}

// Emission is left out; surroundings are seen, but light nothing; a lamp counts as a small one.
static void local_knows_small_lights_only(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    uint32_t white = PUT(m, "lambert", {"color", {0.5}});
    uint32_t glowing = PUT(m, "emissive", {"radiance", {0.5}});
    PUT(m, "plane", {"normal", {0, 1, 0}}, {"material", {white}});
    // A ball of radius 1 and radiance 4/π at distance 8: as a point of 4 W/sr.
    uint32_t ball = PUT_LIGHT_SHAPE(m, "sphere", {"center", {0, 8, 0}}, {"material", {white}});
    PUT(m, "area_light", {"shape", {ball}}, {"radiance", {4 / PI}});
    PUT(m, "environment_light", {"color", {0.25, 0.5, 0.75}});
    World *world = build(lab);
    Vec3 eye = {4, 3, 0};
    double expected = 0.5 * 4 / 64;
    check_rgb(seen(world, "local", eye, vec3(0, 0, 0), 0), expected, expected, expected,
              2e-3 * expected);
    check_rgb(seen(world, "local", eye, vec3(8, 4, 0), 0), 0.25, 0.5, 0.75, 0);
    // The lamp's underside reflects nothing of its own light.
    check_rgb(seen(world, "local", vec3(0.1, 3, 0), vec3(0, 8, 0), 0), 0, 0, 0, 0);

    integrator("local")->check(world, &m->sink);
    assert_int_equal(m->sink.count, 2);
    assert_int_equal(m->sink.items[0].code, W0960);
    assert_int_equal(m->sink.items[1].code, W0961);

    uint32_t mirror = PUT_DEFAULT(m, "mirror");
    PUT(m, "sphere", {"center", {5, 1, 0}}, {"material", {glowing}});
    PUT(m, "sphere", {"center", {-5, 1, 0}}, {"material", {mirror}});
    world = build(lab);
    check_rgb(seen(world, "local", eye, vec3(5, 1, 0), 0), 0, 0, 0, 0);
    check_rgb(seen(world, "local", eye, vec3(-5, 1, 0), 0), 0, 0, 0, 0);
    integrator("local")->check(world, &m->sink);
    assert_int_equal(m->sink.items[m->sink.count - 1].code, W0962);
}

// A sun with an angle gives the same light as one without.
static void local_sun(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    PUT(m, "plane", {"normal", {0, 1, 0}}, {"material", {PUT(m, "lambert", {"color", {0.5}})}});
    PUT(m, "directional_light", {"direction", {1, -1, 0}}, {"irradiance", {3}},
        {"angle", {2 * PI / 180}});
    World *world = build(lab);
    double expected = 0.5 * 3 * sqrt(0.5);
    check_rgb(seen(world, "local", vec3(0, 3, 1), vec3(0, 0, 0), 0), expected, expected, expected,
              1e-3);
}

// --- No noise ------------------------------------------------------------------------------------

// Lights without a size, a mirror, glass, and materials that scatter: other numbers of the sampler
// change nothing.
static void no_noise(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    uint32_t shiny = PUT(m, "phong", {"color", {0.6}}, {"diffuse", {0.6}}, {"specular", {0.4}});
    uint32_t mirror = PUT(m, "mirror", {"color", {0.9}});
    uint32_t glass = PUT(m, "fresnel", {"ior", {1.5}});
    uint32_t half = PUT(m, "mix", {"a", {shiny}}, {"b", {mirror}}, {"weight", {0.3}});
    uint32_t metal = PUT(m, "ggx", {"f0", {0.9}}, {"alpha", {0.3, 0.1}});
    uint32_t natural = PUT_DEFAULT(m, "inverse_square");
    PUT(m, "plane", {"normal", {0, 1, 0}}, {"material", {half}});
    PUT(m, "sphere", {"center", {-2, 1, 0}}, {"material", {mirror}});
    PUT(m, "sphere", {"center", {0, 1, 0}}, {"material", {glass}});
    PUT(m, "sphere", {"center", {2, 1, 0}}, {"material", {metal}});
    PUT(m, "point_light", {"position", {1, 4, 3}}, {"intensity", {20}}, {"attenuation", {natural}});
    PUT(m, "directional_light", {"direction", {1, -1, -0.3}}, {"irradiance", {2}});
    World *world = build(lab);
    const char *const names[] = {"local", "direct", "normals", "depth", "uv", "object_id"};
    int bright = 0;
    for (size_t k = 0; k < TEST_COUNT(names); ++k) {
        for (int i = 0; i < 300; ++i) {
            Vec3 eye = {0.3, 2, 7}, to = {-3 + 0.02 * i, 0.37 * (i % 7), 0.2};
            Rgb a = seen(world, names[k], eye, to, 0), b = seen(world, names[k], eye, to, 12345);
            if (a.r != b.r || a.g != b.g || a.b != b.b) {
                fail_msg("%s has noise: %.9g and %.9g", names[k], (double)a.g, (double)b.g);
            }
            bright += luminance(a) > 0.01f;
        }
    }
    assert_true(bright > 1000);
}

// --- direct --------------------------------------------------------------------------------------

// Two mirrors face each other across a corridor of height 1 and length 10, with a lamp at its end:
// the kth image is L R^k, to the last bit where R = 1/2 (reference check 8).
static void mirror_corridor(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    uint32_t mirror = PUT(m, "mirror", {"color", {0.5}});
    uint32_t lamp = PUT(m, "emissive", {"radiance", {3}});
    PUT(m, "plane", {"point", {0, 0, 0}}, {"normal", {0, 1, 0}}, {"material", {mirror}});
    PUT(m, "plane", {"point", {0, 1, 0}}, {"normal", {0, -1, 0}}, {"material", {mirror}});
    PUT(m, "rectangle", {"corner", {10, 0, -1}}, {"u", {0, 0, 2}}, {"v", {0, 1, 0}},
        {"material", {lamp}});
    World *world = build(lab);
    world->bounces = 20;
    world->russian_roulette = false;
    const char *const names[] = {"direct", "path"};
    for (size_t i = 0; i < TEST_COUNT(names); ++i) {
        for (int k = 0; k <= 13; ++k) {
            // Unfolded, the ray climbs k storeys on its way to the middle of the lamp.
            Vec3 from = {0, 0.5, 0}, to = {10, 0.5 + k, 0};
            double expected = 3 * pow(0.5, k);
            check_rgb(seen(world, names[i], from, to, 5), expected, expected, expected, 0);
        }
    }
    // What carries less than a ten-thousandth is cut off by `direct` alone.
    assert_true(seen(world, "direct", vec3(0, 0.5, 0), vec3(10, 14.5, 0), 5).g == 0);
    assert_true(seen(world, "path", vec3(0, 0.5, 0), vec3(10, 14.5, 0), 5).g > 0);
    // Each reflection is a bounce.
    world->bounces = 4;
    assert_true(seen(world, "direct", vec3(0, 0.5, 0), vec3(10, 4.5, 0), 5).g > 0);
    assert_true(seen(world, "direct", vec3(0, 0.5, 0), vec3(10, 5.5, 0), 5).g == 0);
}

// Through a pane of glass: T = (1 - F)/(1 + F) (reference check 23), all the light that goes to and
// fro inside counted; and its reflection is the rest, R = 2F/(1 + F).
static void pane_of_glass(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    uint32_t glass = PUT(m, "fresnel", {"ior", {1.5}});
    uint32_t lamp = PUT(m, "emissive", {"radiance", {1}});
    PUT(m, "box", {"min", {-5, -5, 0}}, {"max", {5, 5, 0.1}}, {"material", {glass}});
    PUT(m, "rectangle", {"corner", {-9, -9, -4}}, {"u", {18, 0, 0}}, {"v", {0, 18, 0}},
        {"material", {lamp}});
    World *world = build(lab);
    double straight = 0.96 / 1.04;
    // What was cut off: less than F⁴.
    check_rgb(seen(world, "direct", vec3(0, 0, 3), vec3(0, 0, 0), 0), straight, straight, straight,
              3e-6);
    double f = 0.0502399, slant = (1 - f) / (1 + f); // at 45 degrees
    check_rgb(seen(world, "direct", vec3(0, 0, 3), vec3(3, 0, 0), 0), slant, slant, slant, 1e-5);
    double back = 2 * f / (1 + f);
    check_rgb(seen(world, "direct", vec3(-2, 0, -2), vec3(0, 0, 0), 0), back, back, back, 1e-4);
}

// Absorbed on its way through 0.1 m: each crossing has its factor t, T = (1 - F)² t/(1 - F² t²).
static void pane_of_tinted_glass(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    uint32_t glass = PUT(m, "fresnel", {"ior", {1.5}}, {"absorption", {5, 10, 20}});
    uint32_t lamp = PUT(m, "emissive", {"radiance", {1}});
    PUT(m, "box", {"min", {-5, -5, 0}}, {"max", {5, 5, 0.1}}, {"material", {glass}});
    PUT(m, "rectangle", {"corner", {-9, -9, -4}}, {"u", {18, 0, 0}}, {"v", {0, 18, 0}},
        {"material", {lamp}});
    World *world = build(lab);
    double through[3];
    for (int c = 0; c < 3; ++c) {
        double t = exp(-0.5 * (1 << c));
        through[c] = 0.96 * 0.96 * t / (1 - 0.0016 * t * t);
    }
    check_rgb(seen(world, "direct", vec3(0, 0, 3), vec3(0, 0, 0), 0), through[0], through[1],
              through[2], 1e-4);
}

// A glass ball in front of an evenly bright sky is invisible, but for what is cut off.
static void glass_ball_in_the_sky(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    PUT(m, "sphere", {"material", {PUT(m, "fresnel", {"ior", {1.5}})}});
    PUT(m, "environment_light", {"color", {1, 1, 1}});
    World *world = build(lab);
    for (int i = 0; i < 99; ++i) {
        Rgb found = seen(world, "direct", vec3(0, 0, 5), vec3(0, 0.01 * i, 0), 0);
        check_rgb(found, 1, 1, 1, 1e-3);
        assert_true(found.g <= 1 + 1e-6f);
    }
}

// --- Cut-outs ------------------------------------------------------------------------------------

// A curtain that lets through a quarter of the light, before a wall, both lit from the viewer's
// side: what is seen, and what is lit, through it.
static void cut_outs(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    uint32_t white = PUT(m, "lambert", {"color", {0.5}});
    uint32_t curtain = PUT(m, "mask", {"opacity", {0.75}}, {"base", {white}});
    PUT(m, "plane", {"normal", {0, 0, 1}}, {"material", {white}});
    PUT(m, "rectangle", {"corner", {-9, -9, 1}}, {"u", {18, 0, 0}}, {"v", {0, 18, 0}},
        {"material", {curtain}});
    PUT(m, "directional_light", {"direction", {0, 0, -1}}, {"irradiance", {2}});
    World *world = build(lab);
    Vec3 eye = {0, 0, 5}, to = {0, 0, 0};
    double slide = 0.75 * 0.5 * 2 + 0.25 * 0.5 * 2 * 0.25, brdf = slide / PI;
    check_rgb(seen(world, "local", eye, to, 0), slide, slide, slide, 1e-6);
    check_rgb(seen(world, "direct", eye, to, 0), brdf, brdf, brdf, 1e-6);
    world->shadows = false;
    double all = 0.75 * 0.5 * 2 + 0.25 * 0.5 * 2;
    check_rgb(seen(world, "local", eye, to, 0), all, all, all, 1e-6);
    // Views stop at what is more there than not; and crossing is no bounce.
    Vec3 behind = {0, 0, 0.5};
    Rgb wall = seen(world, "object_id", behind, to, 0);
    assert_false(seen(world, "object_id", eye, to, 0).r == wall.r);
    world->bounces = 1;
    check_rgb(seen(world, "direct", eye, to, 0), brdf, brdf, brdf, 1e-6);
}

static void views_look_through_cut_outs(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    uint32_t white = PUT(m, "lambert", {"color", {0.5}});
    uint32_t curtain = PUT(m, "mask", {"opacity", {0.25}}, {"base", {white}});
    PUT(m, "plane", {"normal", {0, 0, 1}}, {"material", {white}});
    for (int i = 1; i <= 3; ++i) {
        PUT(m, "rectangle", {"corner", {-9, -9, i}}, {"u", {18, 0, 0}}, {"v", {0, 18, 0}},
            {"material", {curtain}});
    }
    World *world = build(lab);
    Rgb wall = seen(world, "object_id", vec3(0, 0, 0.5), vec3(0, 0, 0), 0);
    Rgb far = seen(world, "object_id", vec3(0, 0, 5), vec3(0, 0, 0), 0);
    assert_true(wall.r == far.r && wall.g == far.g && wall.b == far.b);
    // The box of bounded shapes reaches from z = 1 to 3; without a camera depths are distances.
    world->near = 0;
    world->far = 10;
    check_rgb(seen(world, "depth", vec3(0, 0, 5), vec3(0, 0, 0), 0), 0.55, 0.55, 0.55, 1e-6);
    // The sky through all three, for one ray; those that pass beside the curtains see more of it.
    float least = 1;
    for (uint32_t i = 0; i < 64; ++i) {
        least = fminf(least, seen(world, "ambient_occlusion", vec3(0, 0, 0.5), vec3(0, 0, 0), i).g);
    }
    assert_true(least == 0.421875f); // 0.75³
}

// --- Ambient occlusion ---------------------------------------------------------------------------

static double mean_openness(const World *world, Vec3 from, Vec3 to, uint32_t samples)
{
    double sum = 0;
    for (uint32_t i = 0; i < samples; ++i) {
        sum += (double)seen(world, "ambient_occlusion", from, to, i).g;
    }
    return sum / samples;
}

static void occlusion(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    PUT(m, "plane", {"normal", {0, 1, 0}});
    World *world = build(lab);
    for (uint32_t i = 0; i < 200; ++i) { // under nothing: every sample is 1
        check_rgb(seen(world, "ambient_occlusion", vec3(1, 2, 3), vec3(0.2, 0, 0), i), 1, 1, 1, 0);
    }
    check_rgb(seen(world, "ambient_occlusion", vec3(1, 2, 3), vec3(0, 9, 0), 0), 0, 0, 0, 0);

    // A wall at distance 1, without end, takes away half; looking no farther than 2, what lies
    // within the segment x >= 1/2 of the unit disc onto which the hemisphere is projected.
    PUT(m, "plane", {"point", {1, 0, 0}}, {"normal", {-1, 0, 0}});
    world = build(lab);
    check_rgb(rgb_gray((float)mean_openness(world, vec3(0, 2, 0), vec3(0, 0, 0), 4096)), 0.5, 0.5,
              0.5, 2e-3);
    world->ao_distance = 2;
    double open = 1 - (acos(0.5) - 0.5 * sqrt(0.75)) / PI;
    check_rgb(rgb_gray((float)mean_openness(world, vec3(0, 2, 0), vec3(0, 0, 0), 4096)), open, open,
              open, 2e-3);
    world->ao_distance = 0.99;
    check_rgb(rgb_gray((float)mean_openness(world, vec3(0, 2, 0), vec3(0, 0, 0), 64)), 1, 1, 1, 0);
}

// --- Views ---------------------------------------------------------------------------------------

static void views(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    PUT(m, "rectangle", {"corner", {-1, -1, 0}}, {"u", {2, 0, 0}}, {"v", {0, 4, 0}});
    PUT(m, "sphere", {"center", {10, 0, 0}}, {"radius", {2}});
    PUT(m, "sphere", {"center", {20, 0, 0}}, {"radius", {2}});
    World *world = build(lab);
    Vec3 front = {0.5, 0, 5}, behind = {0.5, 0, -5}, to = {0.5, 0, 0};
    Vec3 nothing = {0.5, 0, 9};

    check_rgb(seen(world, "normals", front, to, 0), 0.5, 0.5, 1, 1e-7);
    check_rgb(seen(world, "normals", behind, to, 0), 0.5, 0.5, 0, 1e-7); // of the side seen
    check_rgb(seen(world, "normals", vec3(10, 9, 0), vec3(10, 0, 0), 0), 0.5, 1, 0.5, 1e-7);
    check_rgb(seen(world, "normals", front, nothing, 0), 0, 0, 0, 0);

    check_rgb(seen(world, "uv", front, to, 0), 0.75, 0.25, 0.25, 1e-7);
    check_rgb(seen(world, "uv", front, nothing, 0), 0, 0, 0, 0);

    Rgb a = seen(world, "object_id", front, to, 0);
    Rgb b = seen(world, "object_id", behind, vec3(0.2, 0.3, 0), 0);
    Rgb c = seen(world, "object_id", vec3(10, 9, 0), vec3(10, 0, 0), 0);
    Rgb d = seen(world, "object_id", vec3(20, 9, 0), vec3(20, 0, 0), 0);
    check_rgb(b, (double)a.r, (double)a.g, (double)a.b, 0);
    assert_true(fabsf(a.r - c.r) + fabsf(a.g - c.g) + fabsf(a.b - c.b) > 0.1f);
    assert_true(fabsf(d.r - c.r) + fabsf(d.g - c.g) + fabsf(d.b - c.b) > 0.1f);
    assert_true(rgb_max(a) >= 0.5f && rgb_max(c) >= 0.5f);
    check_rgb(seen(world, "object_id", front, nothing, 0), 0, 0, 0, 0);

    // Along the axis of a camera at z = 10 looking down it: the box of shapes reaches from z = 2 to
    // z = -2, depths 8 to 12.
    CameraParams params = {.fov = PI / 4, .projection = CAMERA_PERSPECTIVE};
    params.frame = affine_translation(vec3(0, 0, 10));
    Affine identity = affine_identity();
    Camera camera;
    camera_setup(&camera, &params, &identity, 100, 100);
    world_set_camera(world, &camera);
    double middle = 1 - 0.9 * 0.5;
    check_rgb(seen(world, "depth", vec3(0, 0, 10), vec3(0.5, 1, 0), 0), middle, middle, middle,
              1e-6);
    check_rgb(seen(world, "depth", vec3(10, 0, 20), vec3(10, 0, 0), 0), 1, 1, 1, 1e-6);
    check_rgb(seen(world, "depth", vec3(0, 0, 10), vec3(9, 9, 10), 0), 0, 0, 0, 0);
}

// --- path ---------------------------------------------------------------------------------------

// A lamp that a ray of 45 degrees sees reflected in a ball: F L in glass, whatever way the path
// itself takes, and w L where a material is a mirror by the part w, and else black or a hole.
static void lamps_in_delta_lobes(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    PUT(m, "render", {"bounces", {1}});
    const uint32_t glass = PUT(m, "fresnel", {"ior", {1.5}});
    const uint32_t mirror = PUT(m, "mirror", {"color", {1}});
    const uint32_t black = PUT(m, "lambert", {"color", {0}});
    const uint32_t mixed = PUT(m, "mix", {"a", {black}}, {"b", {mirror}}, {"weight", {0.25}});
    const uint32_t masked = PUT(m, "mask", {"base", {mirror}}, {"opacity", {0.25}});
    const uint32_t lamp = PUT(m, "emissive", {"radiance", {7}});
    PUT(m, "sphere", {"material", {glass}});
    PUT(m, "sphere", {"center", {0, 10, 0}}, {"material", {mixed}});
    PUT(m, "disc", {"center", {0, 20, 0}}, {"normal", {1, 0, 1}}, {"material", {masked}});
    for (int i = 0; i < 3; ++i) {
        PUT(m, "sphere", {"center", {8, 10.0 * i, i < 2 ? sqrt(0.5) : 0}}, {"radius", {0.5}},
            {"material", {lamp}});
    }
    World *world = build(lab);
    const double s = sqrt(0.5);
    double refracted;
    const double reflected = fresnel_dielectric(s, 1.5, &refracted);
    assert_true(reflected > 0.05 && reflected < 0.0503); // 0.0502399
    const double expected[] = {7 * reflected, 7 * 0.25, 7 * 0.25};
    for (int i = 0; i < 3; ++i) {
        const double x = i < 2 ? s : 0, y = 10.0 * i;
        for (uint32_t number = 0; number < 64; ++number) {
            check_rgb(seen(world, "path", vec3(x, y, 5), vec3(x, y, 0), number), expected[i],
                      expected[i], expected[i], 1e-5);
        }
    }
}

static void depth_without_bounds(void **state)
{
    Lab *lab = *state;
    SceneMaker *m = &lab->maker;
    PUT(m, "plane", {"normal", {0, 1, 0}}); // without end, so that there is no farthest
    World *world = build(lab);
    double expected = 1 - 0.9 * 3.0 / 4;
    check_rgb(seen(world, "depth", vec3(0, 3, 0), vec3(0, 0, 0), 0), expected, expected, expected,
              1e-6);
}

#define WITH_LAB(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_LAB(local_is_equation_3),
        WITH_LAB(local_shadows),
        WITH_LAB(local_knows_small_lights_only),
        WITH_LAB(local_sun),
        WITH_LAB(no_noise),
        WITH_LAB(mirror_corridor),
        WITH_LAB(pane_of_glass),
        WITH_LAB(pane_of_tinted_glass),
        WITH_LAB(glass_ball_in_the_sky),
        WITH_LAB(cut_outs),
        WITH_LAB(views_look_through_cut_outs),
        WITH_LAB(occlusion),
        WITH_LAB(views),
        WITH_LAB(depth_without_bounds),
        WITH_LAB(lamps_in_delta_lobes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
