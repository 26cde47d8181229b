// The choice among lights: the chances that it says are those with which it chooses, no light that
// shines is left out, and the noise is small where there are thousands.
#include "../test_support.h"

#include "../../render/scene_maker.h"
#include "../../render/statistics.h"
#include "render/world.h"

static const double LEVEL = 1e-3; // of the whole file
enum { TESTS = 60 };              // chi-squared tests in it, or a few less

static World *build(SceneMaker *maker)
{
    World *world = world_build(&maker->scene, 1, &maker->sink);
    assert_non_null(world);
    return world;
}

static void tear_down(SceneMaker *maker, World *world)
{
    world_free(world);
    maker_free(maker);
}

static double uniform(TestRandom *random)
{
    return ((double)test_random_u32(random) + 0.5) * 0x1p-32;
}

static Vec3 in_cube(TestRandom *random, double half)
{
    double x = uniform(random), y = uniform(random), z = uniform(random);
    return scale(vec3(2 * x - 1, 2 * y - 1, 2 * z - 1), half);
}

static Vec3 on_sphere(TestRandom *random)
{
    double z = 2 * uniform(random) - 1, phi = 2 * PI * uniform(random), r = sqrt(1 - z * z);
    return vec3(r * cos(phi), r * sin(phi), z);
}

// A scene with a bit of everything: points, spots, one-sided and two-sided rectangles, spheres,
// a mesh, suns and surroundings, a dark light, and a light that doesn't fall off.
static void put_everything(SceneMaker *maker, TestRandom *random, int rounds, bool far)
{
    uint32_t glow = PUT(maker, "emissive", {"radiance", {2}});
    uint32_t constant = PUT_DEFAULT(maker, "constant");
    uint32_t lobe = PUT(maker, "cosine_lobe", {"exponent", {10}});
    for (int i = 0; i < rounds; ++i) {
        Vec3 p = in_cube(random, 5), d = on_sphere(random), q = in_cube(random, 5);
        Vec3 u = on_sphere(random), v = cross(u, on_sphere(random)), r = in_cube(random, 5);
        PUT(maker, "point_light", {"position", {p.x, p.y, p.z}}, {"intensity", {uniform(random)}});
        PUT(maker, "spot_light", {"position", {q.x, q.y, q.z}}, {"direction", {d.x, d.y, d.z}},
            {"intensity", {3 * uniform(random)}});
        PUT(maker, "spot_light", {"position", {-q.x, q.y, q.z}}, {"direction", {d.x, d.y, -d.z}},
            {"intensity", {3 * uniform(random)}}, {"falloff", {lobe}});
        PUT(maker, "rectangle", {"corner", {r.x, r.y, r.z}}, {"u", {u.x, u.y, u.z}},
            {"v", {v.x, v.y, v.z}}, {"material", {glow}});
        uint32_t disc = PUT_LIGHT_SHAPE(maker, "disc", {"center", {p.z, p.x, p.y}},
                                        {"normal", {d.z, d.y, d.x}}, {"radius", {0.3}});
        PUT(maker, "area_light", {"shape", {disc}}, {"radiance", {1}}, {"two_sided", {i % 2}});
        PUT(maker, "sphere", {"center", {q.z, q.x, q.y}}, {"radius", {0.1}}, {"material", {glow}});
    }
    PUT(maker, "point_light", {"position", {9, 0, 0}}, {"intensity", {0}});
    PUT(maker, "point_light", {"position", {9, 1, 0}}, {"intensity", {0.01}},
        {"attenuation", {constant}});
    if (far) {
        PUT(maker, "directional_light", {"direction", {0, -1, 0.2}}, {"irradiance", {1}});
        PUT(maker, "directional_light", {"direction", {1, -1, 0.2}}, {"irradiance", {0.1}},
            {"angle", {0.1}});
        PUT(maker, "environment_light", {"radiance", {0.1}});
    }
    for (int i = 0; far && rounds == 40 && i < 20; ++i) {
        Vec3 d = on_sphere(random);
        PUT(maker, "directional_light", {"direction", {d.x, d.y, d.z}},
            {"irradiance", {uniform(random)}});
    }
}

// Frequencies against chances, from one point.
static void check_frequencies(const World *world, const LightReceiver *at, uint64_t seed)
{
    enum { SAMPLES = 200000 };
    size_t count = light_set_count(world->lights);
    double *observed = calloc(count + 1, sizeof *observed);
    double *expected = calloc(count + 1, sizeof *expected), sum = 0;
    TestRandom random = {seed};
    for (int i = 0; i < SAMPLES; ++i) {
        float chance;
        uint32_t light = light_choose(world->lights, at, uniform(&random), &chance);
        if (light == NONE_ID) {
            observed[count] += 1;
            continue;
        }
        assert_true(light < count && chance > 0);
        assert_true(chance == light_chance(world->lights, at, light));
        observed[light] += 1;
    }
    for (uint32_t i = 0; i < count; ++i) {
        double chance = (double)light_chance(world->lights, at, i);
        assert_true(chance >= 0 && (chance == 0) == (light_set_get(world->lights, i)->power == 0));
        expected[i] = SAMPLES * chance;
        sum += chance;
    }
    assert_true(sum < 1 + 1e-5);
    expected[count] = sum < 1 - 1e-6 ? SAMPLES * (1 - sum) : 0;
    double p = chi_squared_test(observed, expected, count + 1);
    if (!(p > sidak(LEVEL, TESTS))) {
        print_message("p = %g, sum of chances %.9g\n", p, sum);
    }
    assert_true(p > sidak(LEVEL, TESTS));
    free(observed);
    free(expected);
}

static void chances_are_frequencies(void **state)
{
    (void)state;
    for (int scene = 0; scene < 6; ++scene) {
        SceneMaker maker;
        TestRandom random = {(uint64_t)scene};
        maker_init(&maker);
        put_everything(&maker, &random, (const int[]){0, 1, 7, 40, 0, 7}[scene], scene < 4);
        World *world = build(&maker);
        for (int i = 0; i < 8; ++i) {
            LightReceiver at = {in_cube(&random, i < 6 ? 6 : 100), on_sphere(&random)};
            if (i % 2) {
                at.normal = vec3(0, 0, 0);
            }
            check_frequencies(world, &at, (uint64_t)(scene * 8 + i));
        }
        tear_down(&maker, world);
    }
}

// What a light gives at a point, at the middle of the light or at a few places of it.
static double contribution(const World *world, uint32_t index, const LightReceiver *at)
{
    const Light *light = light_set_get(world->lights, index);
    TestRandom random = {index};
    double sum = 0;
    enum { TRIES = 16 };
    for (int i = 0; i < TRIES; ++i) {
        LightSample s;
        double u = uniform(&random), v = uniform(&random), w = uniform(&random);
        if (light->class->sample(world, light, at->p, u, v, w, &s)) {
            bool all_around = length_squared(at->normal) == 0;
            double cosine = all_around ? 1 : fmax(dot(s.direction, at->normal), 0);
            sum += (double)luminance(s.value) * cosine / (double)s.pdf;
        }
    }
    return sum / TRIES;
}

// Unbiased: what shines on a point can be chosen for it by the tree alone, so that it isn't left to
// the part of the choices that is by power (which is at most 1/16 · 1 here).
static void no_shining_light_is_left_out(void **state)
{
    (void)state;
    SceneMaker maker;
    TestRandom random = {42};
    maker_init(&maker);
    put_everything(&maker, &random, 30, false);
    World *world = build(&maker);
    size_t count = light_set_count(world->lights);
    int shining = 0;
    for (int i = 0; i < 1000; ++i) {
        LightReceiver at = {in_cube(&random, 6), on_sphere(&random)};
        if (i % 2) {
            at.normal = vec3(0, 0, 0);
        }
        double least = INFINITY, chances[256];
        for (uint32_t k = 0; k < count; ++k) {
            const Light *light = light_set_get(world->lights, k);
            chances[k] = (double)light_chance(world->lights, &at, k);
            if (light->power > 0 && chances[k] < least) {
                least = chances[k];
            }
        }
        // Lights that don't shine are chosen by power and evenly: half of half over their number.
        for (uint32_t k = 0; k < count; ++k) {
            const Light *light = light_set_get(world->lights, k);
            double total = 0;
            for (uint32_t j = 0; j < count; ++j) {
                total += light_set_get(world->lights, j)->power;
            }
            double plain = 0.5 * 0.5 * (light->power / total + 1.0 / (double)(count - 1));
            if (contribution(world, k, &at) > 1e-9) {
                assert_true(chances[k] > plain * (1 + 1e-6));
                ++shining;
            }
        }
    }
    print_message("%d lights that shine\n", shining);
    assert_true(shining > 10000);
    tear_down(&maker, world);
}

// The relative variance of one sample of the light at a point, exactly: Σ c²/p / (Σ c)² - 1, by the
// chances and by a choice half by power and half even. Over many points.
static void compare_noise(const World *world, int points, double half, double *ours,
                          double *by_power)
{
    size_t count = light_set_count(world->lights);
    double total = 0;
    for (uint32_t k = 0; k < count; ++k) {
        total += light_set_get(world->lights, k)->power;
    }
    TestRandom random = {7};
    *ours = *by_power = 0;
    for (int i = 0; i < points; ++i) {
        Vec3 p = in_cube(&random, half);
        LightReceiver at = {vec3(p.x, 0, p.z), vec3(0, 1, 0)};
        double sum = 0, a = 0, b = 0;
        for (uint32_t k = 0; k < count; ++k) {
            double c = contribution(world, k, &at);
            double plain =
                0.5 * (light_set_get(world->lights, k)->power / total + 1 / (double)count);
            sum += c;
            a += c > 0 ? c * c / (double)light_chance(world->lights, &at, k) : 0;
            b += c * c / plain;
        }
        *ours += (a / (sum * sum) - 1) / points;
        *by_power += (b / (sum * sum) - 1) / points;
    }
}

static void thousands_of_lights_are_quiet(void **state)
{
    (void)state;
    // A street: 2500 lamps of many strengths over a plain, most of them spots that point down.
    SceneMaker maker;
    TestRandom random = {5};
    maker_init(&maker);
    for (int i = 0; i < 2500; ++i) {
        double x = 2 * (i % 50) - 49 + uniform(&random), z = 2 * (i / 50) - 49 + uniform(&random);
        double y = 1 + 2 * uniform(&random), power = exp(2 * uniform(&random));
        if (i % 3) {
            PUT(&maker, "spot_light", {"position", {x, y, z}}, {"direction", {0.1, -1, 0}},
                {"intensity", {power}});
        } else {
            PUT(&maker, "point_light", {"position", {x, y, z}}, {"intensity", {power}});
        }
    }
    World *world = build(&maker);
    double ours, by_power;
    compare_noise(world, 100, 45, &ours, &by_power);
    print_message("2500 lamps: relative variance %.3g, by power %.4g\n", ours, by_power);
    assert_true(ours < 2 && ours < by_power / 100);
    tear_down(&maker, world);
}

// A sun that the surface faces, a sun behind it, and dim surroundings.
static void suns_are_weighed_by_their_height(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    PUT(&maker, "directional_light", {"direction", {0, -1, 0}}, {"irradiance", {2}});
    PUT(&maker, "directional_light", {"direction", {0, 1, 0}}, {"irradiance", {20}});
    PUT(&maker, "environment_light", {"radiance", {0.1}});
    World *world = build(&maker);
    LightReceiver at = {{0, 0, 0}, {0, 1, 0}};
    assert_true(light_chance(world->lights, &at, 0) > 0.7f);
    assert_true(light_chance(world->lights, &at, 1) < 0.1f);
    at.normal = vec3(0, -1, 0);
    assert_true(light_chance(world->lights, &at, 1) > 0.8f);
    at.normal = vec3(0, 0, 0);
    assert_true(light_chance(world->lights, &at, 1) > 0.7f);
    tear_down(&maker, world);
}

static void few_lights_are_no_worse(void **state)
{
    (void)state;
    for (int count = 2; count <= 6; ++count) {
        SceneMaker maker;
        TestRandom random = {(uint64_t)count};
        maker_init(&maker);
        for (int i = 0; i < count; ++i) {
            double x = 4 * uniform(&random) - 2, z = 4 * uniform(&random) - 2;
            uint32_t shape = PUT_LIGHT_SHAPE(&maker, "rectangle", {"corner", {x, 2.5, z}},
                                             {"u", {0.5, 0, 0}}, {"v", {0, 0, 0.5}});
            PUT(&maker, "area_light", {"shape", {shape}}, {"radiance", {1 + uniform(&random)}});
            PUT(&maker, "point_light", {"position", {z, 1, x}}, {"intensity", {uniform(&random)}});
        }
        World *world = build(&maker);
        double ours, by_power;
        compare_noise(world, 200, 3, &ours, &by_power);
        print_message("%d lights: relative variance %.3g, by power %.3g\n", 2 * count, ours,
                      by_power);
        assert_true(ours < by_power);
        tear_down(&maker, world);
    }
}

// Odd crowds: all in one place, all in a row, two far apart, no extent at all.
static void odd_crowds_make_a_tree(void **state)
{
    (void)state;
    for (int crowd = 0; crowd < 4; ++crowd) {
        SceneMaker maker;
        maker_init(&maker);
        for (int i = 0; i < 300; ++i) {
            double x = crowd == 1 ? i : crowd == 2 ? 1e6 * (i % 2) : crowd == 3 ? exp2(i) : 1;
            PUT(&maker, "point_light", {"position", {x, 2, 3}}, {"intensity", {1e-20}});
        }
        World *world = build(&maker);
        LightReceiver at = {{1, 1, 1}, {0, 0, 0}};
        double sum = 0;
        for (uint32_t i = 0; i < 300; ++i) {
            sum += (double)light_chance(world->lights, &at, i);
        }
        assert_true(NEAR(sum, 1, 1e-5));
        check_frequencies(world, &at, (uint64_t)crowd);
        at.p = vec3(1, 2, 3); // where a light is
        check_frequencies(world, &at, (uint64_t)crowd);
        tear_down(&maker, world);
    }
}

static void one_light_is_certain(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    LightReceiver at = {{0, 0, 0}, {0, 0, 0}};
    float chance;
    World *dark = build(&maker);
    assert_int_equal(light_choose(dark->lights, &at, 0.5, &chance), NONE_ID);
    world_free(dark);
    PUT(&maker, "point_light", {"position", {9}}, {"intensity", {0}});
    PUT(&maker, "spot_light", {"position", {0, 1, 0}}, {"direction", {0, 1, 0}},
        {"intensity", {1}});
    World *world = build(&maker);
    assert_int_equal(light_choose(world->lights, &at, 0.999, &chance), 1);
    assert_true(chance == 1 && light_chance(world->lights, &at, 1) == 1);
    assert_true(light_chance(world->lights, &at, 0) == 0);
    tear_down(&maker, world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chances_are_frequencies),
        cmocka_unit_test(no_shining_light_is_left_out),
        cmocka_unit_test(thousands_of_lights_are_quiet),
        cmocka_unit_test(suns_are_weighed_by_their_height),
        cmocka_unit_test(few_lights_are_no_worse),
        cmocka_unit_test(odd_crowds_make_a_tree),
        cmocka_unit_test(one_light_is_certain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
