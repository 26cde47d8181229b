// Spot and directional lights against their formulas.
#include "../../trust.h"
#include "../test_support.h"

#include "../../render/scene_maker.h"
#include "../../render/statistics.h"
#include "render/attenuation.h"
#include "render/world.h"

static World *build(SceneMaker *maker)
{
    World *world = world_build(&maker->scene, 1, &maker->sink);
    for (uint32_t i = 0; i < maker->sink.count; ++i) {
        print_message("%s\n", maker->sink.items[i].message);
    }
    assert_non_null(world);
    return world;
}

static void tear_down(SceneMaker *maker, World *world)
{
    world_free(world);
    maker_free(maker);
}

static double radians(double degrees)
{
    return degrees * PI / 180;
}

// The slides' two functions g, written anew.
static double slides_lobe(double theta, double n)
{
    return theta < PI / 2 ? pow(cos(theta), n) : 0;
}
static double slides_cone(double theta, double theta0, double theta1)
{
    if (theta <= theta0) {
        return 1;
    }
    if (theta >= theta1) {
        return 0;
    }
    return (1 - (theta - theta0) / (theta1 - theta0)) * (1 - (theta - theta0) / (theta1 - theta0));
}

static void falloffs_follow_the_slides(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    const double exponents[] = {1, 2.5, 20, 1000};
    for (size_t i = 0; i < TEST_COUNT(exponents); ++i) {
        uint32_t lobe = PUT(&maker, "cosine_lobe", {"exponent", {exponents[i]}});
        for (double theta = 0; theta <= PI; theta += 0.01) {
            assert_true(NEAR(falloff_factor(&maker.scene, lobe, cos(theta)),
                             slides_lobe(theta, exponents[i]), 1e-12));
        }
    }
    const double cones[][2] = {{10, 20}, {1, 90}, {89, 90}, {25, 30}, {0.01, 0.02}};
    for (size_t i = 0; i < TEST_COUNT(cones); ++i) {
        double inner = radians(cones[i][0]), outer = radians(cones[i][1]);
        uint32_t cone = PUT(&maker, "smooth_cone", {"inner", {inner}}, {"outer", {outer}});
        for (double theta = 0; theta <= PI; theta += 0.01) {
            assert_true(NEAR(falloff_factor(&maker.scene, cone, cos(theta)),
                             slides_cone(theta, inner, outer), 1e-9));
        }
        assert_true(NEAR(falloff_reach(&maker.scene, cone), outer, 1e-15));
    }
    // Without a falloff: the default's 25 and 30 degrees.
    assert_true(NEAR(falloff_factor(&maker.scene, NONE_ID, cos(radians(27.5))), 0.25, 1e-9));
    maker_free(&maker);
}

// ∫ g dω = 2π ∫ g sin θ dθ by Simpson's rule, in pieces between the kinks.
static double quadrature(const Scene *scene, uint32_t falloff, const double *kinks, int count)
{
    enum { STEPS = 2000 };
    double sum = 0;
    for (int k = 0; k + 1 < count; ++k) {
        double width = (kinks[k + 1] - kinks[k]) / STEPS;
        for (int i = 0; i <= STEPS; ++i) {
            double theta = kinks[k] + width * i, weight = i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2;
            sum += weight * width / 3 * sin(theta) * falloff_factor(scene, falloff, cos(theta));
        }
    }
    return 2 * PI * sum;
}

// Reference check 14.
static void fluxes_are_integrals(void **state)
{
    (void)state;
    SceneMaker maker;
    double worst = 0, hard_worst = 0;
    maker_init(&maker);
    for (double n = 1; n < 3000; n *= 3) {
        uint32_t lobe = PUT(&maker, "cosine_lobe", {"exponent", {n}});
        const double kinks[] = {0, 0.1, 0.5, PI / 2, PI};
        double flux = falloff_integral(&maker.scene, lobe);
        assert_true(fabs(flux * (n + 1) / (2 * PI) - 1) < 1e-14);
        worst = fmax(worst, fabs(flux / quadrature(&maker.scene, lobe, kinks, 5) - 1));
    }
    const double cones[][2] = {{10, 20},   {1, 90}, {89, 90},     {25, 30},
                               {44.9, 45}, {5, 80}, {30, 30.057}, {30, 30.058}};
    for (size_t i = 0; i < TEST_COUNT(cones); ++i) {
        double kinks[] = {0, radians(cones[i][0]), radians(cones[i][1]), PI};
        uint32_t cone = PUT(&maker, "smooth_cone", {"inner", {kinks[1]}}, {"outer", {kinks[2]}});
        double flux = falloff_integral(&maker.scene, cone);
        worst = fmax(worst, fabs(flux / quadrature(&maker.scene, cone, kinks, 4) - 1));
    }
    assert_true(trust_at_most("14 spot flux against quadrature, relative", 1e-7, worst));
    // A hard cone: 2π (1 - cos θc).
    const double widths[] = {1.1e-3, 0.9e-3, 1e-6, 1e-9};
    for (size_t i = 0; i < TEST_COUNT(widths); ++i) {
        uint32_t hard = PUT(&maker, "smooth_cone", {"inner", {0.5}}, {"outer", {0.5 + widths[i]}});
        double expected = 2 * PI * (1 - cos(0.5));
        double flux = falloff_integral(&maker.scene, hard);
        hard_worst = fmax(hard_worst, fabs(flux / expected - 1) - 2 * widths[i]);
    }
    assert_true(trust_at_most("14 hard cone's flux, relative", 1e-12, hard_worst));
    maker_free(&maker);
}

static double irradiance(const World *world, size_t index, Vec3 p, Vec3 normal)
{
    const Light *light = light_set_get(world->lights, index);
    LightSample s;
    if (!light->class->sample(world, light, p, 0, 0, 0, &s)) {
        return 0;
    }
    assert_true(s.delta && s.pdf == 1 && NEAR(length(s.direction), 1, 1e-12));
    return (double)luminance(s.value) * fmax(dot(s.direction, normal), 0);
}

static void spots_follow_their_formula(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    Affine map = affine_translation(vec3(3, 0, 0));
    uint32_t moved = scene_add_transform(&maker.scene, &map);
    uint32_t lobe = PUT(&maker, "cosine_lobe", {"exponent", {8}});
    uint32_t cone = PUT(&maker, "smooth_cone", {"inner", {0.2}}, {"outer", {0.9}});
    uint32_t window = PUT(&maker, "window", {"start", {1}}, {"end", {4}});
    PUT(&maker, "spot_light", {"position", {0, 2, 0}}, {"target", {0, 0, 0}}, {"intensity", {5}},
        {"falloff", {cone}});
    PUT(&maker, "spot_light", {"position", {0, 2, 0}}, {"direction", {0, -3, 0}},
        {"power", {60}, .dim = DIM_POWER}, {"falloff", {lobe}}, {"color", {1, 0.5, 0.25}});
    PUT(&maker, "spot_light", {"position", {-3, 2, 0}}, {"target", {-3, 1, 0}},
        {"power", {800}, .dim = DIM_LUMINOUS_FLUX}, {"transform", {moved}});
    PUT(&maker, "spot_light", {"position", {0, 2, 0}}, {"direction", {0, -1, 0}},
        {"intensity", {100}, .dim = DIM_LUMINOUS_INTENSITY}, {"falloff", {lobe}},
        {"attenuation", {window}}, {"color", {1, 0.5, 0.25}});
    World *world = build(&maker);
    const double tint = 0.2126 + 0.7152 * 0.5 + 0.0722 * 0.25;
    double standard = falloff_integral(&maker.scene, NONE_ID);
    for (double x = 0; x < 4; x += 0.13) {
        Vec3 p = vec3(x * 0.6, 0, x * 0.8), up = vec3(0, 1, 0);
        double theta = atan(x / 2), r2 = x * x + 4, cosine = cos(theta), r = sqrt(r2);
        double rest = r >= 4 ? 0 : r <= 1 ? 1 : (4 - r) * (4 - r) / 9;
        assert_true(NEAR(irradiance(world, 0, p, up),
                         5 * slides_cone(theta, 0.2, 0.9) * cosine / r2, 1e-6));
        assert_true(NEAR(irradiance(world, 1, p, up),
                         tint * 60 * 9 / (2 * PI) * slides_lobe(theta, 8) * cosine / r2, 1e-5));
        double cone_factor = slides_cone(theta, radians(25), radians(30));
        assert_true(NEAR(683 * irradiance(world, 2, p, up),
                         800 / standard * cone_factor * cosine / r2, 1e-3));
        assert_true(NEAR(683 * irradiance(world, 3, p, up),
                         100 * slides_lobe(theta, 8) * cosine * rest, 1e-4));
    }
    assert_true(irradiance(world, 0, vec3(0, 3, 0), vec3(0, -1, 0)) == 0); // behind
    const double powers[] = {5 * falloff_integral(&maker.scene, cone), 60 * tint, 800 / 683.0,
                             100 / 683.0 * 2 * PI / 9};
    for (size_t i = 0; i < 4; ++i) {
        const Light *light = light_set_get(world->lights, i);
        assert_true(fabs(light->power / powers[i] - 1) < 1e-6);
        assert_true(dot(light->cone.axis, vec3(0, -1, 0)) > 1 - 1e-12);
    }
    tear_down(&maker, world);
}

static void wrong_beams_are_refused(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    const MakerField at = {"position", {0, 2, 0}}, bright = {"intensity", {1}};
    const MakerField down = {"direction", {0, -1, 0}};
    uint32_t texture = PUT(&maker, "checker", {"a", {3}}, {"b", {0.05}});
    assert_int_equal(PUT(&maker, "spot_light", at, bright), NONE_ID);
    assert_int_equal(PUT(&maker, "spot_light", at, bright, down, {"target", {0, 1, 0}}), NONE_ID);
    assert_int_equal(PUT(&maker, "spot_light", at, bright, {"target", {0, 2, 0}}), NONE_ID);
    assert_int_equal(PUT(&maker, "spot_light", at, down), NONE_ID);
    assert_int_equal(PUT(&maker, "smooth_cone", {"inner", {0.5}}, {"outer", {0.5}}), NONE_ID);
    assert_int_equal(
        PUT(&maker, "directional_light", down, {"irradiance", {texture}, .texture = true}),
        NONE_ID);
    assert_int_equal(PUT(&maker, "directional_light", down, {"color", {0, 0, 0}},
                         {"irradiance", {1}, .dim = DIM_ILLUMINANCE}),
                     NONE_ID);
    const DiagCode codes[] = {E0937, E0937, E0937, E0930, E0936, E0401, E0932};
    for (size_t i = 0; i < TEST_COUNT(codes); ++i) {
        assert_int_equal(maker.sink.items[i].code, codes[i]);
    }
    maker_free(&maker);
}

// The mean irradiance of a surface, of a light sampled `count` times.
static Running mean_irradiance(const World *world, const Light *light, Vec3 normal, int count)
{
    Running mean = {0};
    TestRandom random = {1};
    for (int i = 0; i < count; ++i) {
        LightSample s;
        double u = (double)test_random(&random), v = (double)test_random(&random);
        assert_true(light->class->sample(world, light, vec3(1, 2, 3), u, v, 0, &s));
        running_add(&mean, (double)s.value.g * fmax(dot(s.direction, normal), 0) / (double)s.pdf);
    }
    return mean;
}

static void suns_give_their_irradiance(void **state)
{
    (void)state;
    const double angles[] = {0, 1e-8, 1e-6, 0.00925, 0.3, 1, PI};
    for (size_t i = 0; i < TEST_COUNT(angles); ++i) {
        SceneMaker maker;
        maker_init(&maker);
        Affine map = affine_multiply(&(Affine){{{0, 0, 1, 5}, {1, 0, 0, 6}, {0, 1, 0, 7}}},
                                     &(Affine){{{2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 2, 0}}});
        PUT(&maker, "directional_light", {"direction", {0, -3, 0}}, {"irradiance", {2}},
            {"angle", {angles[i]}}, {"color", {0.25, 0.5, 1}});
        PUT(&maker, "directional_light", {"direction", {-1, 0, 0}}, // (0, -1, 0) in the world
            {"irradiance", {683}, .dim = DIM_ILLUMINANCE}, {"angle", {angles[i]}},
            {"transform", {scene_add_transform(&maker.scene, &map)}});
        World *world = build(&maker);
        uint32_t seen;
        light_set_infinite(world->lights, &seen);
        bool delta = angles[i] < 1e-7;
        assert_int_equal(seen, delta ? 0 : 2);
        for (size_t k = 0; k < 2; ++k) {
            const Light *light = light_set_get(world->lights, k);
            assert_true(light->delta == delta);
            // Facing it, and tilted by 60° where the whole disc is above the horizon.
            Running facing = mean_irradiance(world, light, vec3(0, 1, 0), 20000);
            assert_true(fabs(facing.mean - 1) < 4 * running_error(&facing) + 1e-5);
            if (angles[i] <= 1) {
                Vec3 tilted = vec3(sqrt(0.75), 0.5, 0);
                Running part = mean_irradiance(world, light, tilted, 20000);
                assert_true(fabs(part.mean - 0.5) < 4 * running_error(&part) + 1e-5);
            }
        }
        tear_down(&maker, world);
    }
}

// Samples lie in the disc, uniform; rays find the same radiance there, and nothing outside.
static void suns_are_seen_as_discs(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    Vec3 travel = normalize(vec3(1, -2, 0.5));
    PUT(&maker, "directional_light", {"direction", {1, -2, 0.5}}, {"irradiance", {2}},
        {"angle", {0.3}});
    World *world = build(&maker);
    const Light *light = light_set_get(world->lights, 0);
    TestRandom random = {3};
    enum { RINGS = 16, SECTORS = 16, SAMPLES = 200000 };
    double observed[RINGS * SECTORS] = {0}, expected[RINGS * SECTORS];
    Frame frame = frame_from_normal(neg(travel));
    double rise = 1 - cos(0.15);
    for (int i = 0; i < SAMPLES; ++i) {
        LightSample s;
        double u = (double)test_random(&random), v = (double)test_random(&random);
        assert_true(light->class->sample(world, light, vec3(0, 0, 0), u, v, 0, &s));
        assert_true(isinf(s.distance) && !s.delta);
        double height = (1 - dot(s.direction, frame.n)) / rise;
        assert_true(height <= 1 + 1e-9);
        double phi = atan2(dot(s.direction, frame.t), dot(s.direction, frame.s)) + PI;
        int ring = (int)fmin(height * RINGS, RINGS - 1);
        int sector = (int)fmin(phi / (2 * PI) * SECTORS, SECTORS - 1);
        observed[ring * SECTORS + sector] += 1;
        if (height < 1 - 1e-6) {
            assert_true(light->class->pdf(world, light, vec3(0, 0, 0), s.direction, NULL) == s.pdf);
            assert_true(light->class->escaped(world, light, s.direction, NULL).g == s.value.g);
        }
    }
    for (int i = 0; i < RINGS * SECTORS; ++i) {
        expected[i] = (double)SAMPLES / (RINGS * SECTORS);
    }
    assert_true(chi_squared_test(observed, expected, RINGS * SECTORS) > 1e-3);
    for (double angle = 0.005; angle < PI; angle += 0.01) {
        Vec3 d = add(scale(frame.n, cos(angle)), scale(frame.s, sin(angle)));
        bool inside = light->class->escaped(world, light, d, NULL).g > 0;
        assert_true(inside == (angle < 0.15));
        assert_true((light->class->pdf(world, light, vec3(0, 0, 0), d, NULL) > 0) == inside);
    }
    double radiance = 2 / (PI * pow(sin(0.15), 2));
    assert_true(fabs((double)light->class->escaped(world, light, frame.n, NULL).g / radiance - 1) <
                1e-6);
    tear_down(&maker, world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(falloffs_follow_the_slides), cmocka_unit_test(fluxes_are_integrals),
        cmocka_unit_test(spots_follow_their_formula), cmocka_unit_test(wrong_beams_are_refused),
        cmocka_unit_test(suns_give_their_irradiance), cmocka_unit_test(suns_are_seen_as_discs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
