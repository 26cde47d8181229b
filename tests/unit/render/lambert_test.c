#include "../test_support.h"

#include "../../render/bsdf_check.h"
#include "../../render/scene_maker.h"

static const double ANGLES[] = {0, 20, 45, 70, 85, 110, 180};

static Vec3 viewer(size_t i)
{
    double a = ANGLES[i] * PI / 180;
    return vec3(sin(a) * cos(0.7), sin(a) * sin(0.7), cos(a));
}

typedef struct Lab {
    SceneMaker maker;
    World *world;
    uint32_t lambert, black, emissive, over_lambert;
} Lab;

static int set_up(void **state)
{
    Lab *lab = calloc(1, sizeof *lab);
    maker_init(&lab->maker);
    lab->lambert = PUT(&lab->maker, "lambert", {"color", {0.6}});
    lab->black = PUT(&lab->maker, "lambert", {"color", {1e-30}});
    lab->emissive = PUT(&lab->maker, "emissive", {"radiance", {3}});
    lab->over_lambert =
        PUT(&lab->maker, "emissive", {"radiance", {1, 2, 3}}, {"base", {lab->lambert}});
    lab->world = world_build(&lab->maker.scene, 1, &lab->maker.sink);
    *state = lab;
    return lab->world ? 0 : -1;
}

static int tear_down(void **state)
{
    Lab *lab = *state;
    world_free(lab->world);
    maker_free(&lab->maker);
    free(lab);
    return 0;
}

static void samples_follow_the_pdf(void **state)
{
    Lab *lab = *state;
    double level = sidak(0.01, TEST_COUNT(ANGLES));
    for (size_t i = 0; i < TEST_COUNT(ANGLES); ++i) {
        double p = bsdf_chi_squared(lab->world, lab->lambert, viewer(i), 1000000, 4, 100 + i);
        print_message("lambert at %g degrees: p = %.3g (fails below %.3g)\n", ANGLES[i], p, level);
        assert_true(p > level);
    }
}

// The test itself finds a pdf that is off: a view from the side with cells turned by one column.
static void chi_squared_finds_a_wrong_pdf(void **state)
{
    (void)state;
    enum { CELLS = 100 };
    double observed[CELLS], expected[CELLS];
    TestRandom random = {5};
    for (int i = 0; i < CELLS; ++i) {
        observed[i] = 0;
        expected[i] = 10000 * (1 + 0.02 * sin(i));
    }
    for (int i = 0; i < 10000 * CELLS; ++i) {
        observed[(int)(test_random(&random) * CELLS)] += 1;
    }
    assert_true(chi_squared_test(observed, expected, CELLS) < 1e-6);
}

static void eval_is_the_formula(void **state)
{
    Lab *lab = *state;
    FlatPoint flat;
    flat_point(lab->world, lab->lambert, viewer(2), &flat);
    for (double z = -0.95; z < 1; z += 0.1) {
        BsdfEval e = material_eval(&flat.point, lab->lambert, spherical(z, 2));
        double expected = z > 0 ? 0.6 * z / PI : 0;
        assert_true(NEAR(e.value.r, expected, 1e-7));
        assert_true(NEAR(e.pdf, z > 0 ? z / PI : 0, 1e-7));
    }
}

static void sample_agrees_with_eval(void **state)
{
    Lab *lab = *state;
    for (size_t i = 0; i < TEST_COUNT(ANGLES); ++i) {
        assert_true(bsdf_sample_mismatch(lab->world, lab->lambert, viewer(i), 100000, i) < 1e-5);
        assert_true(bsdf_sample_mismatch(lab->world, lab->over_lambert, viewer(i), 1000, i) < 1e-5);
    }
    assert_true(bsdf_asymmetry(lab->world, lab->lambert, 1000000, 3) < 1e-5);
}

static void albedo_is_the_color(void **state)
{
    Lab *lab = *state;
    for (size_t i = 0; i < TEST_COUNT(ANGLES); ++i) {
        Running mean = bsdf_albedo(lab->world, lab->lambert, viewer(i), 1000, i);
        assert_true(NEAR(mean.mean, 0.6, 1e-3));
        FlatPoint flat;
        flat_point(lab->world, lab->lambert, viewer(i), &flat);
        assert_true(NEAR(material_albedo(&flat.point, lab->lambert).g, 0.6, 1e-7));
        assert_true(NEAR(material_albedo(&flat.point, lab->black).g, 0, 1e-7));
        assert_true(NEAR(material_albedo(&flat.point, NONE_ID).g, 0.5, 1e-7));
    }
}

static void emissive_emits_in_front(void **state)
{
    Lab *lab = *state;
    Surface front = {.front = true}, back = {.front = false};
    assert_true(material_emitted(lab->world, lab->emissive, &front).r == 3);
    assert_true(material_emitted(lab->world, lab->emissive, &back).r == 0);
    assert_true(material_emitted(lab->world, lab->over_lambert, &front).b == 3);
    assert_true(material_emitted(lab->world, lab->lambert, &front).r == 0);
    FlatPoint flat;
    BsdfSample s;
    flat_point(lab->world, lab->emissive, viewer(1), &flat);
    assert_false(material_sample(&flat.point, lab->emissive, 0.5f, 0.5f, 0.5f, &s));
    assert_true(material_eval(&flat.point, lab->emissive, vec3(0, 0, 1)).value.r == 0);
    assert_int_equal(material_lobes(lab->world, lab->emissive), LOBE_EMIT);
    assert_int_equal(material_lobes(lab->world, lab->over_lambert),
                     LOBE_EMIT | LOBE_REFLECT | LOBE_SMOOTH);
}

// Whatever the shading normal, light goes neither through the surface nor out of its back; and a
// shading normal that the viewer can't see is bent.
static void no_light_leaks(void **state)
{
    Lab *lab = *state;
    TestRandom random = {9};
    for (int i = 0; i < 200000; ++i) {
        Vec3 shading =
            spherical((double)test_random(&random), 2 * PI * (double)test_random(&random));
        Vec3 wo =
            spherical(2 * (double)test_random(&random) - 1, 2 * PI * (double)test_random(&random));
        Surface surface = {.geometric = {0, 0, 1},
                           .shading = shading,
                           .tangent = {1, 0, 0},
                           .instance = NONE_ID,
                           .front = wo.z > 0};
        ShadingPoint point;
        shading_point(lab->world, &surface, neg(wo), &point);
        assert_true(NEAR(length(point.frame.n), 1, 1e-9));
        assert_true(point.wo.z * wo.z > 0);
        BsdfSample s;
        if (material_sample(&point, lab->lambert, 0.5f, test_random(&random), test_random(&random),
                            &s)) {
            assert_true(from_local(&point.frame, s.wi).z * wo.z > 0);
        }
        Vec3 wi =
            spherical(2 * (double)test_random(&random) - 1, 2 * PI * (double)test_random(&random));
        BsdfEval e = material_eval(&point, lab->lambert, to_local(&point.frame, wi));
        assert_true(e.value.r >= 0 && (wi.z * wo.z > 0 || e.value.r == 0));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_follow_the_pdf), cmocka_unit_test(chi_squared_finds_a_wrong_pdf),
        cmocka_unit_test(eval_is_the_formula),    cmocka_unit_test(sample_agrees_with_eval),
        cmocka_unit_test(albedo_is_the_color),    cmocka_unit_test(emissive_emits_in_front),
        cmocka_unit_test(no_light_leaks),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
