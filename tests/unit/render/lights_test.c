#include "../test_support.h"

#include "../../render/scene_maker.h"
#include "../../render/statistics.h"
#include "render/attenuation.h"
#include "render/world.h"
#include "schema/photometry.h"

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

static void units_become_radiometric(void **state)
{
    (void)state;
    Rgb out;
    // 1 lm of any color: its luminance is 1/683 W.
    const Rgb colors[] = {{1, 1, 1}, {1, 0.5f, 0.2f}, {0, 0, 1}, {20, 3, 1}};
    const uint32_t dims[] = {DIM_LUMINOUS_FLUX, DIM_LUMINOUS_INTENSITY, DIM_ILLUMINANCE,
                             DIM_LUMINANCE};
    for (size_t i = 0; i < TEST_COUNT(colors); ++i) {
        for (size_t k = 0; k < TEST_COUNT(dims); ++k) {
            assert_true(quantity_to_rgb((Quantity){5, dims[k]}, colors[i], &out));
            double back = LUMENS_PER_WATT * (0.2126 * (double)out.r + 0.7152 * (double)out.g +
                                             0.0722 * (double)out.b);
            assert_true(NEAR(back, 5, 5e-6));
            assert_true(NEAR(out.g * colors[i].b, out.b * colors[i].g, 1e-7));
        }
    }
    // Watts spread over the colour as they are.
    assert_true(quantity_to_rgb((Quantity){2, DIM_POWER}, colors[1], &out));
    assert_true(out.r == 2 && out.g == 1 && NEAR(out.b, 0.4, 1e-7));
    assert_false(quantity_to_rgb((Quantity){2, DIM_LUMINANCE}, rgb(0, 0, 0), &out));
    // A color is taken as it is, whatever the light's.
    Emission emission = {{1, 2, 3}, DIM_NONE, NONE_ID, false};
    assert_true(emission_to_rgb(&emission, colors[1], &out));
    assert_true(out.r == 1 && out.g == 2 && out.b == 3);
}

static void point_light_follows_its_formula(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    Affine move = affine_translation(vec3(1, 0, 0));
    uint32_t transform = scene_add_transform(&maker.scene, &move);
    PUT(&maker, "point_light", {"position", {0, 2, 0}}, {"intensity", {3}});
    PUT(&maker, "point_light", {"position", {0, 2, 0}}, {"power", {100}, .dim = DIM_POWER},
        {"transform", {transform}}, {"color", {1, 0.5, 0.25}});
    PUT(&maker, "point_light", {"position", {0, 2, 0}}, {"power", {800}, .dim = DIM_LUMINOUS_FLUX},
        {"color", {1, 0.5, 0.25}});
    PUT(&maker, "point_light", {"position", {0, 2, 0}},
        {"intensity", {100}, .dim = DIM_LUMINOUS_INTENSITY});
    World *world = build(&maker);
    assert_int_equal(light_set_count(world->lights), 4);
    Vec3 p = vec3(0.3, -1, 2);
    LightSample s[4];
    for (size_t i = 0; i < 4; ++i) {
        const Light *light = light_set_get(world->lights, i);
        assert_true(light->class->sample(world, light, p, 0.1, 0.2, 0.3, &s[i]));
        assert_true(s[i].delta && s[i].pdf == 1);
        assert_true(NEAR(length(s[i].direction), 1, 1e-12));
    }
    double r2 = 0.3 * 0.3 + 9 + 4, moved = 0.7 * 0.7 + 9 + 4;
    assert_true(NEAR(s[0].value.r, 3 / r2, 1e-6) && NEAR(s[0].distance, sqrt(r2), 1e-12));
    assert_true(NEAR(s[1].value.r, 100 / (4 * PI) / moved, 1e-6));
    assert_true(NEAR(s[1].value.b, 25 / (4 * PI) / moved, 1e-6));
    assert_true(NEAR((double)luminance(s[2].value) * 683, 800 / (4 * PI) / r2, 1e-5));
    assert_true(NEAR((double)s[3].value.g * 683, 100 / r2, 1e-5));
    tear_down(&maker, world);
}

static void strength_is_said_once(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    const MakerField w = {"power", {1}, .dim = DIM_POWER};
    assert_int_equal(PUT(&maker, "point_light", {"position", {0}}), NONE_ID);
    assert_int_equal(PUT(&maker, "point_light", {"position", {0}}, {"intensity", {1}}, w), NONE_ID);
    assert_int_equal(PUT(&maker, "area_light", {"shape", {0}}), NONE_ID);
    assert_int_equal(PUT(&maker, "area_light", {"shape", {0}}, {"radiance", {1}}, w), NONE_ID);
    assert_int_equal(maker.errors, 4);
    for (uint32_t i = 0; i < maker.sink.count; ++i) {
        assert_int_equal(maker.sink.items[i].code, E0930);
    }
    assert_int_equal(PUT(&maker, "point_light", {"position", {0}}, {"color", {0, 0, 0}},
                         {"power", {1}, .dim = DIM_LUMINOUS_FLUX}),
                     NONE_ID);
    assert_int_equal(maker.sink.items[4].code, E0932);
    assert_int_equal(PUT(&maker, "window", {"start", {2}}, {"end", {1}}), NONE_ID);
    assert_int_equal(PUT(&maker, "polynomial", {"c", {0}}), NONE_ID);
    assert_int_equal(maker.sink.items[6].code, E0931);
    maker_free(&maker);
}

static void attenuation_follows_its_formulas(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    uint32_t natural = PUT_DEFAULT(&maker, "inverse_square");
    uint32_t constant = PUT_DEFAULT(&maker, "constant");
    uint32_t polynomial = PUT(&maker, "polynomial", {"a", {1}}, {"b", {0.5}}, {"c", {0.25}});
    uint32_t window = PUT(&maker, "window", {"start", {1}}, {"end", {3}});
    for (double r = 0.1; r < 5; r += 0.1) {
        double rest = 1 - (r - 1) / 2;
        double expected = r <= 1 ? 1 : r >= 3 ? 0 : rest * rest;
        assert_true(NEAR(attenuation_factor(&maker.scene, natural, r), 1 / (r * r), 1e-12));
        assert_true(NEAR(attenuation_factor(&maker.scene, NONE_ID, r), 1 / (r * r), 1e-12));
        assert_true(attenuation_factor(&maker.scene, constant, r) == 1);
        assert_true(NEAR(attenuation_factor(&maker.scene, polynomial, r),
                         1 / (1 + r / 2 + r * r / 4), 1e-12));
        assert_true(NEAR(attenuation_factor(&maker.scene, window, r), expected, 1e-12));
    }
    maker_free(&maker);
}

// Sampled directions against the pdf of those directions, on cells of latitude and longitude: both
// the counts and the integral of the pdf.
static void check_environment(const World *world, size_t index, int samples, double level)
{
    enum { ROWS = 64, COLUMNS = 128, STEPS = 32 };
    const Light *light = light_set_get(world->lights, index);
    double *observed = calloc(ROWS * COLUMNS, sizeof *observed);
    double *expected = calloc(ROWS * COLUMNS, sizeof *expected);
    TestRandom random = {index + 1};
    Vec3 origin = vec3(0, 0, 0);
    Running flux = {0};
    for (int i = 0; i < samples; ++i) {
        LightSample s;
        double u = (double)test_random(&random), v = (double)test_random(&random);
        assert_true(light->class->sample(world, light, origin, u, v, 0, &s));
        assert_true(NEAR(length(s.direction), 1, 1e-9));
        double pdf = (double)light->class->pdf(world, light, origin, s.direction, NULL);
        Rgb seen = light->class->escaped(world, light, s.direction, NULL);
        // A direction on the border of two cells may count to the other.
        running_add(&flux, fabs(pdf - (double)s.pdf) > 1e-4 * pdf);
        assert_true(NEAR(seen.g, s.value.g, 1e-3 * (1 + (double)seen.g)));
        int row = (int)(acos(s.direction.y) / PI * ROWS);
        int column = (int)((atan2(s.direction.x, s.direction.z) / (2 * PI) + 0.5) * COLUMNS);
        observed[(row < ROWS ? row : ROWS - 1) * COLUMNS +
                 (column < COLUMNS ? column : COLUMNS - 1)] += 1;
    }
    assert_true(flux.mean < 1e-4);
    double total = 0;
    for (int i = 0; i < ROWS * COLUMNS * STEPS * STEPS; ++i) {
        int row = i / (COLUMNS * STEPS), column = i % (COLUMNS * STEPS);
        double a = cos(PI * row / (ROWS * STEPS)), b = cos(PI * (row + 1) / (ROWS * STEPS));
        double y = (a + b) / 2, phi = 2 * PI * ((column + 0.5) / (COLUMNS * STEPS) - 0.5);
        Vec3 d = vec3(sqrt(1 - y * y) * sin(phi), y, sqrt(1 - y * y) * cos(phi));
        double mass = (a - b) * 2 * PI / (COLUMNS * STEPS) *
                      (double)light->class->pdf(world, light, origin, d, NULL);
        expected[row / STEPS * COLUMNS + column / STEPS] += samples * mass;
        total += mass;
    }
    double p = chi_squared_test(observed, expected, ROWS * COLUMNS);
    print_message("environment %zu: integral of the pdf %.6f, p = %.3g\n", index, total, p);
    assert_true(NEAR(total, 1, 2e-3));
    assert_true(p > level);
    free(observed);
    free(expected);
}

static void environment_sampling_follows_its_pdf(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    uint32_t checker = PUT(&maker, "checker", {"a", {3}}, {"b", {0.05}}, {"scale", {8, 4, 0}});
    Affine turn = affine_rotation(vec3(1, 2, 3), 0.7);
    PUT(&maker, "environment_light", {"radiance", {2}});
    PUT(&maker, "environment_light", {"radiance", {checker}, .texture = true});
    PUT(&maker, "environment_light", {"radiance", {checker}, .texture = true}, {"rotation", {0.5}},
        {"transform", {scene_add_transform(&maker.scene, &turn)}});
    World *world = build(&maker);
    uint32_t infinite;
    light_set_infinite(world->lights, &infinite);
    assert_int_equal(infinite, 3);
    for (size_t i = 0; i < 3; ++i) {
        check_environment(world, i, 1000000, sidak(0.01, 3));
    }
    tear_down(&maker, world);
}

static void environment_lies_as_documented(void **state)
{
    (void)state;
    // u in [0, 1/2) is bright: left of -z, so -x is bright, +x dark; turned by 90°
    // counter-clockwise seen from above, -x goes to +z.
    SceneMaker maker;
    maker_init(&maker);
    uint32_t checker = PUT(&maker, "checker", {"a", {5}}, {"b", {1}}, {"scale", {2, 1, 0}});
    PUT(&maker, "environment_light", {"radiance", {checker}, .texture = true});
    PUT(&maker, "environment_light", {"radiance", {checker}, .texture = true},
        {"rotation", {PI / 2}});
    World *world = build(&maker);
    const Light *plain = light_set_get(world->lights, 0), *turned = light_set_get(world->lights, 1);
    assert_true(plain->class->escaped(world, plain, vec3(-1, 0, 0), NULL).r == 5);
    assert_true(plain->class->escaped(world, plain, vec3(1, 0, 0), NULL).r == 1);
    assert_true(turned->class->escaped(world, turned, vec3(0, 0, 1), NULL).r == 5);
    assert_true(turned->class->escaped(world, turned, vec3(0, 0, -1), NULL).r == 1);
    tear_down(&maker, world);
}

static void environment_is_not_stretched(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    Affine stretch = affine_scaling(vec3(1, 2, 1));
    PUT(&maker, "environment_light", {"radiance", {2}},
        {"transform", {scene_add_transform(&maker.scene, &stretch)}});
    assert_null(world_build(&maker.scene, 1, &maker.sink));
    assert_int_equal(maker.sink.items[0].code, E0934);
    maker_free(&maker);
}

// For every shape light: the mean of 1/pdf over sampled directions, where something is emitted, is
// the solid angle; and pdf() agrees with sample().
static void area_lights_know_their_pdf(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    Affine stretch = affine_scaling(vec3(1, 2, 1.5));
    uint32_t transform = scene_add_transform(&maker.scene, &stretch);
    uint32_t glow = PUT(&maker, "emissive", {"radiance", {1}});
    PUT(&maker, "sphere", {"center", {0, -3, 0}}, {"material", {glow}});
    PUT(&maker, "sphere", {"center", {-4, 0, 0}}, {"material", {glow}}, {"transform", {transform}});
    PUT(&maker, "rectangle", {"corner", {-0.5, 2, -0.5}}, {"u", {1, 0, 0}}, {"v", {0, 0, 1}},
        {"material", {glow}});
    PUT(&maker, "disc", {"center", {1, 2, 0}}, {"normal", {-0.5, -1, 0}}, {"material", {glow}});
    World *world = build(&maker);
    assert_int_equal(light_set_count(world->lights), 4);
    Vec3 here = vec3(0.2, 0.1, 0.3);
    for (size_t i = 0; i < light_set_count(world->lights); ++i) {
        const Light *light = light_set_get(world->lights, i);
        TestRandom random = {i};
        int checked = 0;
        for (int k = 0; k < 20000; ++k) {
            LightSample s;
            double u = (double)test_random(&random), v = (double)test_random(&random);
            if (!light->class->sample(world, light, here, u, v, (double)test_random(&random), &s) ||
                rgb_is_black(s.value)) {
                continue;
            }
            // What a ray in that direction meets is the sampled point, or hides it.
            Ray ray = ray_make(here, s.direction, 0, s.distance * (1 + 1e-6));
            Hit hit;
            if (!accel_intersect(world->accel, &ray, &hit) || hit.shape != light->shape ||
                hit.t < s.distance * (1 - 1e-6)) {
                continue;
            }
            Surface surface;
            accel_surface(world->accel, &ray, &hit, &surface);
            assert_int_equal(light_of_surface(world, &surface), i);
            double pdf = (double)light->class->pdf(world, light, here, s.direction, &surface);
            double cosine = fabs(dot(surface.geometric, s.direction));
            assert_true(fabs(pdf / (double)s.pdf - 1) < 1e-4 / fmax(cosine, 1e-3));
            ++checked;
        }
        assert_true(checked > 2000);
    }
    tear_down(&maker, world);
}

static void power_spreads_over_the_area(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    for (int sides = 1; sides <= 2; ++sides) {
        uint32_t shape = PUT_LIGHT_SHAPE(&maker, "rectangle", {"corner", {0, 3.0 * sides, 0}},
                                         {"u", {2, 0, 0}}, {"v", {0, 0, 3}});
        PUT(&maker, "area_light", {"shape", {shape}}, {"power", {100}, .dim = DIM_POWER},
            {"two_sided", {sides == 2}});
    }
    World *world = build(&maker);
    for (size_t i = 0; i < 2; ++i) {
        const Light *light = light_set_get(world->lights, i);
        Surface front = {.front = true, .lamp = true, .shape = light->shape, .instance = NONE_ID};
        Surface back = {.front = false, .lamp = true, .shape = light->shape, .instance = NONE_ID};
        assert_int_equal(light_of_surface(world, &front), i);
        double radiance = 100 / (PI * 6) / (double)(i + 1);
        assert_true(NEAR(light->class->emitted(world, light, &front).r, radiance, 1e-6));
        assert_true(
            NEAR(light->class->emitted(world, light, &back).r, i == 0 ? 0 : radiance, 1e-6));
        assert_true(NEAR(light->power, 100, 1e-4));
    }
    tear_down(&maker, world);
}

static void shape_has_one_light(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    uint32_t shape = PUT_LIGHT_SHAPE(&maker, "sphere", {"radius", {1}});
    PUT(&maker, "area_light", {"shape", {shape}}, {"radiance", {1}});
    PUT(&maker, "area_light", {"shape", {shape}}, {"radiance", {1}});
    assert_null(world_build(&maker.scene, 1, &maker.sink));
    assert_int_equal(maker.sink.items[0].code, E0935);
    maker_free(&maker);
}

// Emitting shapes of prototypes are lights in each instance; a shape without material takes its
// instance's.
static void instances_bring_their_lights(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    uint32_t glow = PUT(&maker, "emissive", {"radiance", {1}});
    uint32_t matt = PUT(&maker, "lambert", {"color", {0.5}});
    maker.prototype = scene_add_prototype(&maker.scene, 0, (Span){0});
    uint32_t lamp = PUT(&maker, "sphere", {"center", {0, 1, 0}}, {"material", {glow}});
    uint32_t bare = PUT(&maker, "sphere", {"center", {0, 4, 0}});
    PUT(&maker, "sphere", {"center", {0, 7, 0}}, {"material", {matt}});
    PUT(&maker, "point_light", {"position", {0, 0, 0}}, {"intensity", {1}});
    maker.scene.nodes[CATEGORY_LIGHT].items[0].prototype = maker.prototype;
    for (uint32_t i = 0; i < 3; ++i) {
        Affine move = affine_translation(vec3(10.0 * i, 0, 0));
        SceneInstance instance = {.prototype = maker.prototype,
                                  .transform = scene_add_transform(&maker.scene, &move),
                                  .material = i == 2 ? glow : NONE_ID};
        assert_true(array_push(&maker.scene.instances, instance));
    }
    World *world = build(&maker);
    // Three point lights, three lamps, and the bare sphere of the glowing instance.
    assert_int_equal(light_set_count(world->lights), 7);
    for (uint32_t i = 0; i < 3; ++i) {
        Ray ray = ray_make(vec3(10.0 * i, 1, 8), vec3(0, 0, -1), 0, INFINITY);
        Hit hit;
        Surface surface;
        assert_true(accel_intersect(world->accel, &ray, &hit));
        accel_surface(world->accel, &ray, &hit, &surface);
        assert_true(surface.shape == lamp && surface.instance == i);
        uint32_t index = light_of_surface(world, &surface);
        assert_true(index != NONE_ID);
        const Light *light = light_set_get(world->lights, index);
        assert_true(light->shape == lamp && light->instance == i);
        assert_true(NEAR(light->power, 4 * PI * PI, 1e-4));
        ray.origin.y = 4;
        assert_true(accel_intersect(world->accel, &ray, &hit));
        accel_surface(world->accel, &ray, &hit, &surface);
        assert_int_equal(surface.shape, bare);
        assert_true((light_of_surface(world, &surface) != NONE_ID) == (i == 2));
    }
    tear_down(&maker, world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(units_become_radiometric),
        cmocka_unit_test(point_light_follows_its_formula),
        cmocka_unit_test(strength_is_said_once),
        cmocka_unit_test(attenuation_follows_its_formulas),
        cmocka_unit_test(environment_sampling_follows_its_pdf),
        cmocka_unit_test(environment_lies_as_documented),
        cmocka_unit_test(environment_is_not_stretched),
        cmocka_unit_test(area_lights_know_their_pdf),
        cmocka_unit_test(power_spreads_over_the_area),
        cmocka_unit_test(shape_has_one_light),
        cmocka_unit_test(instances_bring_their_lights),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
