// The formulas that authors call (base/shading_models.h) and the materials that are rendered say
// the same; and the delta lobes that a material lists are those that it samples.
#include "bsdf_check.h"

#include "base/shading_models.h"

enum { PAIRS = 20000 };

static Bench bench;

static int setup(void **state)
{
    (void)state;
    bench_init(&bench);
    return 0;
}
static int teardown(void **state)
{
    (void)state;
    bench_free(&bench);
    return 0;
}

// A frame anywhere: the author's functions know no preferred axes.
static Frame random_frame(Random *random)
{
    return frame_from_tangent(random_direction(random), random_direction(random));
}

static void highlights_are_the_materials(void **state)
{
    (void)state;
    const char *fields = "color=0 specular=0.7 shininess=12";
    uint32_t phong = bench_material(&bench, "phong", fields);
    uint32_t blinn = bench_material(&bench, "blinn_phong", fields);
    Random random = {1};
    int lit = 0;
    for (int i = 0; i < PAIRS; ++i) {
        Frame f = random_frame(&random);
        Vec3 v = random_hemisphere(&random), l = random_direction(&random);
        ShadingPoint point = bench_point(&bench, v);
        Vec3 world_v = from_local(&f, v), world_l = from_local(&f, l);
        double p = phong_model(f.n, world_v, world_l, 12, 0.7);
        double b = blinn_phong_model(f.n, world_v, world_l, 12, 0.7);
        assert_near((double)material_local(&point, phong, l).specular.g, p, 1e-7);
        assert_near((double)material_local(&point, blinn, l).specular.g, b, 1e-7);
        lit += p > 0.01;
    }
    assert_true(lit > PAIRS / 20);
}

static void brdfs_are_the_materials(void **state)
{
    (void)state;
    uint32_t burley = bench_material(&bench, "burley", "color=0.8 roughness=0.4");
    uint32_t ggx = bench_material(&bench, "ggx", "f0=0.25 alpha=0.2,0.7");
    Random random = {2};
    for (int i = 0; i < PAIRS; ++i) {
        Frame f = random_frame(&random);
        Vec3 wo = random_hemisphere(&random), wi = random_direction(&random);
        ShadingPoint point = bench_point(&bench, wo);
        Vec3 world_o = from_local(&f, wo), world_i = from_local(&f, wi);
        double b = burley_model(f.n, world_i, world_o, (double)0.4f, 0.8) * fmax(0, wi.z);
        Ggx roughness = {0.2, 0.7};
        double g = ggx_model(world_i, world_o, f, roughness, 0.25) * fmax(0, wi.z);
        double rendered_b = (double)material_eval(&point, burley, wi).value.g;
        double rendered_g = (double)material_eval(&point, ggx, wi).value.g;
        if (!near_relative(rendered_b, b, 1e-6) || !near_relative(rendered_g, g, 1e-6)) {
            fail_msg("burley %.9g and %.9g, ggx %.9g and %.9g", rendered_b, b, rendered_g, g);
        }
    }
}

// --- Delta lobes ---------------------------------------------------------------------------------

// The mean weight that `sample` gives to delta lobes in direction `wi`, over evenly spread numbers.
static double sampled_share(const ShadingPoint *point, uint32_t material, Vec3 wi)
{
    enum { DRAWS = 20000 };
    double sum = 0;
    for (int i = 0; i < DRAWS; ++i) {
        BsdfSample s;
        float lobe = ((float)i + 0.5f) / DRAWS;
        if (material_sample(point, material, lobe, 0.3f, 0.7f, &s) && (s.lobes & LOBE_DELTA) &&
            length(sub(s.wi, wi)) < 1e-9) {
            sum += (double)s.weight.g / DRAWS;
        }
    }
    return sum;
}

static void check_deltas(const char *name, uint32_t material, int wanted)
{
    Random random = {3};
    for (int i = 0; i < 20; ++i) {
        ShadingPoint point = bench_point(&bench, random_hemisphere(&random));
        BsdfSample lobes[DELTA_ROOM];
        int count = material_deltas(&point, material, lobes, DELTA_ROOM);
        if (count != wanted) {
            fail_msg("%s: %d delta lobes, not %d", name, count, wanted);
        }
        for (int k = 0; k < count; ++k) {
            assert_true(lobes[k].lobes & LOBE_DELTA);
            assert_true(lobes[k].pdf == 1);
            double share = 0; // lobes in one direction count together
            for (int j = 0; j < count; ++j) {
                share +=
                    length(sub(lobes[j].wi, lobes[k].wi)) < 1e-9 ? (double)lobes[j].weight.g : 0;
            }
            assert_near(share, sampled_share(&point, material, lobes[k].wi), 2e-4);
        }
    }
}

static void deltas_are_what_is_sampled(void **state)
{
    (void)state;
    char text[64];
    uint32_t lambert = bench_material(&bench, "lambert", "color=0.5");
    uint32_t mirror = bench_material(&bench, "mirror", "color=0.8");
    uint32_t metal = bench_material(&bench, "mirror", "eta=0.143,0.375,1.442 k=3.983,2.386,1.603");
    uint32_t polished = bench_material(&bench, "ggx", "ior=1.5 alpha=0");
    uint32_t rough = bench_material(&bench, "ggx", "ior=1.5 alpha=0.3");
    check_deltas("lambert", lambert, 0);
    check_deltas("mirror", mirror, 1);
    check_deltas("metal", metal, 1);
    check_deltas("polished ggx", polished, 1);
    check_deltas("rough ggx", rough, 0);
    snprintf(text, sizeof text, "a=#%u b=#%u weight=0.25", mirror, lambert);
    uint32_t half = bench_material(&bench, "mix", text);
    check_deltas("mix", half, 1);
    snprintf(text, sizeof text, "a=#%u b=#%u weight=0.4", half, polished);
    uint32_t nested = bench_material(&bench, "mix", text);
    check_deltas("nested mix", nested, 2);
    snprintf(text, sizeof text, "radiance=1 base=#%u", nested);
    check_deltas("emissive", bench_material(&bench, "emissive", text), 2);
    check_deltas("emissive alone", bench_material(&bench, "emissive", "radiance=1"), 0);

    snprintf(text, sizeof text, "opacity=0.3 base=#%u", nested);
    check_deltas("mask", bench_material(&bench, "mask", text), 2);
    snprintf(text, sizeof text, "front=#%u back=#%u", mirror, lambert);
    check_deltas("two_sided", bench_material(&bench, "two_sided", text), 1);
    check_deltas("glass", bench_material(&bench, "fresnel", "ior=1.5"), 2);

    // Too little room is said, not overrun.
    ShadingPoint point = bench_point(&bench, vec3(0, 0, 1));
    BsdfSample one[1];
    assert_int_equal(material_deltas(&point, nested, one, 1), -1);
    assert_int_equal(material_deltas(&point, mirror, one, 0), -1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(highlights_are_the_materials, setup, teardown),
        cmocka_unit_test_setup_teardown(brdfs_are_the_materials, setup, teardown),
        cmocka_unit_test_setup_teardown(deltas_are_what_is_sampled, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
