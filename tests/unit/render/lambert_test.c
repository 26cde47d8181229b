#include "bsdf_check.h"

static Bench bench;
static uint32_t lambert, black, emissive, over_lambert;

static int set_up(void **state)
{
    (void)state;
    bench_init(&bench);
    lambert = bench_material(&bench, "lambert", "color=0.6");
    black = bench_material(&bench, "lambert", "color=1e-30");
    emissive = bench_material(&bench, "emissive", "radiance=3");
    over_lambert = bench_material(&bench, "emissive", "radiance=rgb(1,2,3) base=#0");
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    bench_free(&bench);
    return 0;
}

static void samples_follow_the_pdf(void **state)
{
    (void)state;
    check_chi2(&bench, "lambert", lambert, 1000000, false, 2);
    check_chi2(&bench, "lambert", lambert, 1000000, true, 2);
}

// The tests themselves find a density that is off by a per cent.
static void chi_squared_finds_a_wrong_pdf(void **state)
{
    (void)state;
    enum { CELLS = 100 };
    double observed[CELLS], expected[CELLS];
    static Chi2 chi2; // the first of its cells
    Random random = {5};
    for (int i = 0; i < CELLS; ++i) {
        observed[i] = 0;
        expected[i] = 10000 * (1 + 0.02 * sin(i));
    }
    for (int i = 0; i < 10000 * CELLS; ++i) {
        observed[(int)(random_next(&random) * CELLS)] += 1;
    }
    assert_true(chi_squared_test(observed, expected, CELLS) < 1e-6);
    memcpy(chi2.observed, observed, sizeof observed);
    memcpy(chi2.expected, expected, sizeof expected);
    int freedom;
    assert_true(chi2_p_value(&chi2, &freedom) < 1e-6);
    assert_int_equal(freedom, CELLS - 1);
}

static const double ANGLES[] = {0, 20, 45, 70, 85, 110, 180};

static void eval_is_the_formula(void **state)
{
    (void)state;
    ShadingPoint point = bench_point(&bench, direction(45, 40));
    for (double theta = 3; theta < 180; theta += 6) {
        Vec3 wi = direction(theta, 115);
        BsdfEval e = material_eval(&point, lambert, wi);
        assert_near((double)e.value.r, wi.z > 0 ? 0.6 * wi.z / PI : 0, 1e-7);
        assert_near((double)e.pdf, wi.z > 0 ? wi.z / PI : 0, 1e-7);
    }
}

static void sample_agrees_with_eval(void **state)
{
    (void)state;
    check_weights(&bench, "lambert", lambert, 1000000);
    check_weights(&bench, "emissive over lambert", over_lambert, 10000);
    check_reciprocity(&bench, "lambert", lambert, 1000000, 1, 1);
}

static void albedo_is_the_color(void **state)
{
    (void)state;
    for (size_t i = 0; i < TEST_COUNT(ANGLES); ++i) {
        Vec3 wo = direction(ANGLES[i], 40);
        assert_near((double)albedo_by_sampling(&bench, lambert, wo, 1000, NULL).g, 0.6, 1e-6);
        ShadingPoint point = bench_point(&bench, wo);
        assert_near((double)material_albedo(&point, lambert).g, 0.6, 1e-7);
        assert_near((double)material_albedo(&point, black).g, 0, 1e-7);
    }
}

static void without_a_material_it_is_grey(void **state)
{
    (void)state;
    World world = {.scene = &bench.scene};
    assert_true(world_resolve_materials(&world));
    ShadingPoint point = bench_point(&bench, direction(30, 0));
    point.world = &world;
    assert_near((double)material_albedo(&point, NONE_ID).g, 0.5, 1e-7);
    arena_free(&world.arena);
}

static void emissive_emits_in_front(void **state)
{
    (void)state;
    Surface front = {.front = true}, back = {.front = false};
    const World *world = &bench.world;
    assert_true(material_emitted(world, emissive, &front).r == 3);
    assert_true(material_emitted(world, emissive, &back).r == 0);
    assert_true(material_emitted(world, over_lambert, &front).b == 3);
    assert_true(material_emitted(world, lambert, &front).r == 0);
    BsdfSample s;
    ShadingPoint point = bench_point(&bench, direction(20, 40));
    assert_false(material_sample(&point, emissive, 0.5f, 0.5f, 0.5f, &s));
    assert_true(material_eval(&point, emissive, vec3(0, 0, 1)).value.r == 0);
    assert_int_equal(material_lobes(world, emissive), LOBE_EMIT);
    assert_int_equal(material_lobes(world, over_lambert), LOBE_EMIT | LOBE_REFLECT | LOBE_SMOOTH);
}

// Whatever the shading normal, light goes neither through the surface nor out of its back; and a
// shading normal that the viewer can't see is bent.
static void no_light_leaks(void **state)
{
    (void)state;
    Random random = {9};
    for (int i = 0; i < 200000; ++i) {
        Vec3 shading = random_direction(&random), wo = random_direction(&random);
        shading.z = fabs(shading.z);
        Surface surface = {.geometric = {0, 0, 1},
                           .shading = shading,
                           .tangent = {1, 0, 0},
                           .instance = NONE_ID,
                           .front = wo.z > 0};
        ShadingPoint point;
        shading_point(&bench.world, &surface, neg(wo), &point);
        assert_near(length(point.frame.n), 1, 1e-9);
        assert_true(point.wo.z * wo.z > 0);
        BsdfSample s;
        float u = random_next(&random), v = random_next(&random);
        if (material_sample(&point, lambert, 0.5f, u, v, &s)) {
            assert_true(from_local(&point.frame, s.wi).z * wo.z > 0);
        }
        Vec3 wi = random_direction(&random);
        BsdfEval e = material_eval(&point, lambert, to_local(&point.frame, wi));
        assert_true(e.value.r >= 0 && (wi.z * wo.z > 0 || e.value.r == 0));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_follow_the_pdf),  cmocka_unit_test(chi_squared_finds_a_wrong_pdf),
        cmocka_unit_test(eval_is_the_formula),     cmocka_unit_test(sample_agrees_with_eval),
        cmocka_unit_test(albedo_is_the_color),     cmocka_unit_test(without_a_material_it_is_grey),
        cmocka_unit_test(emissive_emits_in_front), cmocka_unit_test(no_light_leaks),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
