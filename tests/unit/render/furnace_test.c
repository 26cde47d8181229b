// The furnace against albedos that are known (reference checks 20 to 23), and materials that break
// each law by a known amount.
#include "render/furnace.h"

#include "../../render/scene_maker.h"
#include "base/fresnel.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

typedef struct Lab {
    SceneMaker maker;
    World *world;
} Lab;

static void open_lab(Lab *lab)
{
    lab->world = NULL;
    maker_init(&lab->maker);
}

static void close_lab(Lab *lab)
{
    world_free(lab->world);
    maker_free(&lab->maker);
}

static void measure(Lab *lab, uint32_t material, FurnaceReport *out)
{
    if (!lab->world) {
        lab->world = world_build(&lab->maker.scene, 1, &lab->maker.sink);
        assert_non_null(lab->world);
    }
    assert_true(furnace_measure(lab->world, material, &(FurnaceOptions){.seed = 5}, out));
}

// The angles' numbers: every 2.5 degrees.
enum { AT_0 = 0, AT_60 = 24 };

// Within 4 standard errors (one in 10000 isn't, for 31 degrees of freedom about three), and those
// no more than `most`.
static void assert_albedo(const FurnacePoint *point, double expected, double most)
{
    for (int c = 0; c < 3; ++c) {
        double error = fmax(point->total_error[c], 1e-6);
        if (fabs(point->total[c] - expected) > 4 * error || error > most) {
            fail_msg("%.9g ± %.2g at %.3g degrees, not %.9g ± %.2g", point->total[c], error,
                     point->angle * 180 / PI, expected, most);
        }
    }
}

static void flat_ones(void **state)
{
    (void)state;
    Lab lab;
    FurnaceReport report;
    open_lab(&lab);
    uint32_t white = PUT(&lab.maker, "lambert", {"color", {0.8}});
    uint32_t mirror = PUT(&lab.maker, "mirror", {"color", {0.6}});
    measure(&lab, white, &report);
    for (int i = 0; i < FURNACE_ANGLES; ++i) {
        assert_albedo(&report.sides[0][i], 0.8, 1e-6);
        assert_true(report.sides[0][i].transmitted[0] == 0);
    }
    assert_false(report.both_sides);
    assert_int_equal(report.energy, FURNACE_HOLDS);
    assert_int_equal(report.reciprocity, FURNACE_HOLDS);
    assert_int_equal(report.sampling, FURNACE_HOLDS);
    assert_null(report.caveat);
    measure(&lab, mirror, &report);
    for (int i = 0; i < FURNACE_ANGLES; ++i) {
        assert_albedo(&report.sides[0][i], 0.6, 1e-6);
    }
    assert_int_equal(report.energy, FURNACE_HOLDS);
    assert_int_equal(report.reciprocity, FURNACE_NOT_ASKED);
    assert_int_equal(report.sampling, FURNACE_NOT_ASKED);
    close_lab(&lab);
}

// What Fresnel's equations say, from both sides; all of the light comes back or goes through.
static void glass(void **state)
{
    (void)state;
    Lab lab;
    FurnaceReport report;
    open_lab(&lab);
    measure(&lab, PUT(&lab.maker, "fresnel", {"ior", {1.5}}), &report);
    assert_true(report.both_sides);
    for (int side = 0; side < 2; ++side) {
        for (int i = 0; i < FURNACE_ANGLES; ++i) {
            const FurnacePoint *point = &report.sides[side][i];
            double f = fresnel_dielectric(cos(point->angle), side ? 1 / 1.5 : 1.5, NULL);
            double error = fmax(point->reflected_error[1], 1e-5);
            assert_true(fabs(point->reflected[1] - f) < 5 * error && error < 1e-3);
            assert_albedo(point, 1, 1e-5);
        }
    }
    assert_int_equal(report.energy, FURNACE_HOLDS);
    close_lab(&lab);
}

static void ggx(void **state)
{
    (void)state;
    static const struct {
        double alpha, at_0, at_60;
    } cases[] = {{0.1, 0.988304, 0}, {0.5, 0.687849, 0.69825}, {1, 0.30685281944, 0}};
    Lab lab;
    FurnaceReport report;
    open_lab(&lab);
    uint32_t materials[3];
    for (int i = 0; i < 3; ++i) {
        materials[i] = PUT(&lab.maker, "ggx", {"f0", {1}}, {"alpha", {cases[i].alpha}});
    }
    for (int i = 0; i < 3; ++i) {
        measure(&lab, materials[i], &report);
        assert_albedo(&report.sides[0][AT_0], cases[i].at_0, 1e-3);
        if (cases[i].at_60 > 0) {
            assert_albedo(&report.sides[0][AT_60], cases[i].at_60, 1e-3);
        }
        assert_int_equal(report.energy, FURNACE_HOLDS);
        assert_int_equal(report.reciprocity, FURNACE_HOLDS);
        assert_int_equal(report.sampling, FURNACE_HOLDS);
    }
    close_lab(&lab);
}

// 41/42, 169/168 and 29/28 at normal incidence; the rougher two give back more than they get, as
// the kind says itself.
static void burley(void **state)
{
    (void)state;
    static const struct {
        double roughness, at_0, at_60;
        FurnaceVerdict energy;
    } cases[] = {{0, 41.0 / 42, 0.960937, FURNACE_HOLDS},
                 {0.5, 169.0 / 168, 1.008320, FURNACE_BROKEN},
                 {1, 29.0 / 28, 1.056904, FURNACE_BROKEN}};
    Lab lab;
    FurnaceReport report;
    open_lab(&lab);
    uint32_t materials[4];
    for (int i = 0; i < 3; ++i) {
        materials[i] =
            PUT(&lab.maker, "burley", {"color", {1}}, {"roughness", {cases[i].roughness}});
    }
    materials[3] =
        PUT(&lab.maker, "two_sided", {"front", {materials[2]}}, {"back", {materials[0]}});
    for (int i = 0; i < 3; ++i) {
        measure(&lab, materials[i], &report);
        assert_albedo(&report.sides[0][AT_0], cases[i].at_0, 1e-3);
        assert_albedo(&report.sides[0][AT_60], cases[i].at_60, 1e-3);
        assert_int_equal(report.energy, cases[i].energy);
        assert_int_equal(report.reciprocity, FURNACE_HOLDS);
        assert_non_null(strstr(report.caveat, "by construction"));
    }
    // Within another material it is known, too, and the sides are told apart.
    measure(&lab, materials[3], &report);
    assert_true(report.both_sides);
    assert_non_null(report.caveat);
    assert_albedo(&report.sides[0][AT_60], cases[2].at_60, 1e-3);
    assert_albedo(&report.sides[1][AT_60], cases[0].at_60, 1e-3);
    assert_true(report.most.front && !report.least.front);
    close_lab(&lab);
}

// The specular parts are what is reflected at normal incidence: Blinn's by
// 8π (2^(-n/2) + n)/((n+2)(n+4)), Phong's by (n+2)/2π, of which .504736 is left at 60 degrees for
// n = 10.
static void highlights(void **state)
{
    (void)state;
    Lab lab;
    FurnaceReport report;
    open_lab(&lab);
    uint32_t blinn = PUT(&lab.maker, "blinn_phong", {"color", {1}}, {"diffuse", {0}},
                         {"specular", {1}}, {"shininess", {20}});
    uint32_t phong = PUT(&lab.maker, "phong", {"color", {1}}, {"diffuse", {0}}, {"specular", {1}},
                         {"shininess", {10}});
    uint32_t too_much = PUT(&lab.maker, "phong", {"color", {1}}, {"diffuse", {1}},
                            {"specular", {0.01}}, {"shininess", {10}});
    measure(&lab, blinn, &report);
    assert_albedo(&report.sides[0][AT_0], 1, 2e-3);
    assert_int_equal(report.energy, FURNACE_HOLDS);
    measure(&lab, phong, &report);
    assert_albedo(&report.sides[0][AT_0], 1, 2e-3);
    assert_albedo(&report.sides[0][AT_60], 0.504736, 2e-3);
    assert_int_equal(report.energy, FURNACE_HOLDS);
    measure(&lab, too_much, &report);
    assert_albedo(&report.sides[0][AT_0], 1.01, 2e-3);
    assert_int_equal(report.energy, FURNACE_BROKEN);
    close_lab(&lab);
}

// Azimuths are averaged over; nothing is lost of the axes for that.
static void brushed_metal(void **state)
{
    (void)state;
    Lab lab;
    FurnaceReport report;
    open_lab(&lab);
    measure(&lab, PUT(&lab.maker, "ggx", {"f0", {1}}, {"alpha", {0.05, 0.5}}), &report);
    assert_int_equal(report.energy, FURNACE_HOLDS);
    assert_int_equal(report.reciprocity, FURNACE_HOLDS);
    assert_int_equal(report.sampling, FURNACE_HOLDS);
    assert_false(report.both_sides);
    close_lab(&lab);
}

// --- Liars ---------------------------------------------------------------------------------------

typedef struct Liar {
    double gain;     // of energy: Lambert's BRDF times 1 + gain
    double tilt;     // f times 1 + tilt wo.z
    double pdf_tilt; // the density said is off by so much between the middle and the rim
} Liar;

static uint32_t liar_lobes(const World *world, const void *params)
{
    (void)world, (void)params;
    return LOBE_REFLECT | LOBE_SMOOTH;
}

static BsdfEval liar_eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    const Liar *liar = params;
    if (wi.z * point->wo.z <= 0) {
        return (BsdfEval){{0, 0, 0}, 0};
    }
    double c = fabs(wi.z), f = c / PI * (1 + liar->gain) * (1 + liar->tilt * fabs(point->wo.z));
    // ∫ c/π (c - 2/3) over the hemisphere is 0.
    double pdf = c / PI * (1 + liar->pdf_tilt * (c - 2.0 / 3));
    return (BsdfEval){rgb_gray((float)f), (float)pdf};
}

static bool liar_sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                        BsdfSample *out)
{
    (void)lobe;
    Vec3 wi = sample_cosine_hemisphere(u, v);
    wi.z = copysign(wi.z, point->wo.z);
    BsdfEval e = liar_eval(point, params, wi);
    *out = (BsdfSample){wi, rgb_scale(e.value, 1 / e.pdf), e.pdf, 1, LOBE_REFLECT | LOBE_SMOOTH};
    return e.pdf > 0;
}

MATERIAL_EVAL(liar_eval)

static const MaterialClass liar_material = {
    .node = {.name = "liar", .category = CATEGORY_MATERIAL, .size = sizeof(Liar)},
    .lobes = liar_lobes,
    .eval = liar_eval_into,
    .sample = liar_sample,
};

// Each law broken by little: a gain of 0.1 %, an asymmetry of 1 %, a density that is off by 0.25
// times the cosine's distance from its mean (6 % as its root mean square).
static void liars_are_found(void **state)
{
    (void)state;
    static const struct {
        Liar liar;
        FurnaceVerdict energy, reciprocity, sampling;
    } cases[] = {
        {{0, 0, 0}, FURNACE_HOLDS, FURNACE_HOLDS, FURNACE_HOLDS},
        {{0.001, 0, 0}, FURNACE_BROKEN, FURNACE_HOLDS, FURNACE_HOLDS},
        {{-0.5, 0.01, 0}, FURNACE_HOLDS, FURNACE_BROKEN, FURNACE_HOLDS},
        {{-0.5, 0, 0.25}, FURNACE_HOLDS, FURNACE_HOLDS, FURNACE_BROKEN},
    };
    Lab lab;
    FurnaceReport report;
    open_lab(&lab);
    measure(&lab, PUT(&lab.maker, "lambert", {"color", {1}}), &report);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        WorldMaterial material = {
            .class = &liar_material, .params = &cases[i].liar, .lobes = LOBE_REFLECT | LOBE_SMOOTH};
        World world = *lab.world;
        world.materials = &material;
        world.material_count = 1;
        assert_true(furnace_measure(&world, 0, &(FurnaceOptions){.seed = 1}, &report));
        print_message("case %zu: most %.6f, asymmetry %.2g, p %.2g\n", i, report.most.value,
                      report.asymmetry, report.sampling_p);
        assert_int_equal(report.energy, cases[i].energy);
        assert_int_equal(report.reciprocity, cases[i].reciprocity);
        assert_int_equal(report.sampling, cases[i].sampling);
    }
    close_lab(&lab);
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    static FurnaceReport one, three;
    Lab lab;
    open_lab(&lab);
    uint32_t material = PUT(&lab.maker, "ggx", {"f0", {0.9}}, {"alpha", {0.3}});
    measure(&lab, material, &one);
    FurnaceOptions options = {.seed = 5, .threads = 3};
    assert_true(furnace_measure(lab.world, material, &options, &three));
    assert_memory_equal(one.sides, three.sides, sizeof one.sides);
    assert_true(one.most.value == three.most.value && one.asymmetry == three.asymmetry &&
                one.sampling_p == three.sampling_p);
    close_lab(&lab);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flat_ones),
        cmocka_unit_test(glass),
        cmocka_unit_test(ggx),
        cmocka_unit_test(burley),
        cmocka_unit_test(highlights),
        cmocka_unit_test(brushed_metal),
        cmocka_unit_test(liars_are_found),
        cmocka_unit_test(threads_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
