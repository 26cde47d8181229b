// fresnel: smooth and rough, against Snell, Fresnel and Walter et al., and its parts against each
// other.
#include "base/fresnel.h"
#include "bsdf_check.h"

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

// The slides' expressions for a smooth surface, seen from wo in a medium of index ni.
static void check_smooth(uint32_t material, Vec3 wo, double ni, double nt, double tint,
                         double outside)
{
    ShadingPoint point = bench_point(&bench, wo);
    point.outside = outside;
    double ci = fabs(wo.z), r = ni / nt, root = 1 - r * r * (1 - ci * ci);
    double f = 1;
    BsdfSample s;
    if (root > 0) {
        double ct = sqrt(root);
        f = 0.5 * (pow((ni * ci - nt * ct) / (ni * ci + nt * ct), 2) +
                   pow((ni * ct - nt * ci) / (ni * ct + nt * ci), 2));
        Vec3 n = vec3(0, 0, wo.z > 0 ? 1 : -1);
        Vec3 wt = sub(scale(n, r * ci - ct), scale(wo, r));
        assert_true(material_sample(&point, material, 0.9999f, 0.3f, 0.3f, &s));
        assert_near(length(sub(s.wi, wt)), 0, 1e-9);
        // Lt = (nt/ni)² (1 - F) Li with light coming from wi's side: there n is ni of the slide.
        assert_near((double)s.weight.g * (double)s.pdf, tint * (1 - f) * r * r, 1e-6);
        assert_near((double)s.eta, nt / ni, 1e-6);
        assert_true(s.lobes == (LOBE_TRANSMIT | LOBE_DELTA));
    } else {
        assert_true(material_sample(&point, material, 0.9999f, 0.3f, 0.3f, &s));
        assert_true(s.lobes == (LOBE_REFLECT | LOBE_DELTA)); // total internal reflection
    }
    assert_true(material_sample(&point, material, 0, 0.3f, 0.3f, &s));
    assert_near(length(sub(s.wi, vec3(-wo.x, -wo.y, wo.z))), 0, 1e-9);
    assert_near((double)s.weight.g * (double)s.pdf, f, 1e-6);
    assert_true(s.lobes == (LOBE_REFLECT | LOBE_DELTA) && s.eta == 1);
    // All at once.
    BsdfSample all[DELTA_ROOM];
    int count = material_deltas(&point, material, all, DELTA_ROOM);
    assert_int_equal(count, root > 0 ? 2 : 1);
    assert_near((double)all[0].weight.g, f, 1e-6);
    if (count == 2) {
        assert_near((double)all[1].weight.g, tint * (1 - f) * r * r, 1e-6);
    }
    assert_int_equal(material_deltas(&point, material, all, 0), -1);
}

static void smooth(void **state)
{
    (void)state;
    uint32_t glass = bench_material(&bench, "fresnel", "ior=1.5 color=0.8");
    uint32_t bubble = bench_material(&bench, "fresnel", "ior=1 outside=1.33");
    Random random = {2};
    for (int i = 0; i < 1000; ++i) {
        Vec3 wo = random_hemisphere(&random);
        check_smooth(glass, wo, 1, 1.5, (double)0.8f, 0);
        check_smooth(bubble, wo, 1.33, 1, 1, 0);
        check_smooth(glass, wo, 1.33, 1.5, (double)0.8f, 1.33); // in water
        wo.z = -wo.z;
        check_smooth(glass, wo, 1.5, 1, (double)0.8f, 0);
        check_smooth(bubble, wo, 1, 1.33, 1, 0);
        check_smooth(glass, wo, 1.5, 1.7, (double)0.8f, 1.7);
    }
}

static void schlick(void **state)
{
    (void)state;
    uint32_t glass = bench_material(&bench, "fresnel", "ior=1.5 approximation=schlick");
    BsdfSample s;
    for (double theta = 0; theta < 89; theta += 4) {
        Vec3 wo = direction(theta, 0);
        ShadingPoint point = bench_point(&bench, wo);
        assert_true(material_sample(&point, glass, 0, 0, 0, &s));
        double f = 0.04 + 0.96 * pow(1 - wo.z, 5);
        assert_near((double)s.pdf, f, 1e-6);
        // The same from inside along the same ray.
        assert_true(material_sample(&point, glass, 0.99999f, 0, 0, &s));
        point = bench_point(&bench, s.wi);
        assert_true(material_sample(&point, glass, 0, 0, 0, &s));
        assert_near((double)s.pdf, f, 1e-6);
    }
}

// Glass in a liquid of its own index, smooth or not, isn't there.
static void equal_media(void **state)
{
    (void)state;
    static const char *const ALPHAS[] = {"ior=1.5 outside=1.5", "ior=1.5 outside=1.5 alpha=0.3"};
    for (size_t i = 0; i < TEST_COUNT(ALPHAS); ++i) {
        uint32_t glass = bench_material(&bench, "fresnel", ALPHAS[i]);
        for (double theta = 0; theta < 90; theta += 7) {
            Vec3 wo = direction(theta, 50);
            ShadingPoint point = bench_point(&bench, wo);
            BsdfSample s;
            assert_true(material_sample(&point, glass, 0.5f, 0.7f, 0.2f, &s));
            assert_near(length(add(s.wi, wo)), 0, 1e-7);
            assert_near((double)s.weight.g, 1, 1e-6);
        }
    }
}

// Expression 21 of Walter et al. with the half vector of their equation 16, in their own terms:
// light from i (index ni) to o (index no).
static double walter(Vec3 o, Vec3 i, double no, double ni, double alpha)
{
    Vec3 ht = normalize(neg(add(scale(i, ni), scale(o, no))));
    ht = ht.z < 0 ? neg(ht) : ht;
    double ih = fabs(dot(i, ht)), oh = fabs(dot(o, ht));
    if (dot(i, ht) * i.z <= 0 || dot(o, ht) * o.z <= 0) {
        return 0; // χ⁺ of G: seen from the wrong side
    }
    double tan2 = (1 - ht.z * ht.z) / (ht.z * ht.z);
    double d = alpha * alpha / (PI * pow(ht.z, 4) * pow(alpha * alpha + tan2, 2));
    double tan_i = sqrt(1 - i.z * i.z) / fabs(i.z), tan_o = sqrt(1 - o.z * o.z) / fabs(o.z);
    double g =
        2 / (1 + sqrt(1 + pow(alpha * tan_i, 2))) * 2 / (1 + sqrt(1 + pow(alpha * tan_o, 2)));
    double f = fresnel_dielectric(oh, ni / no, NULL);
    double root = ni * dot(i, ht) + no * dot(o, ht);
    return ih * oh / fabs(i.z * o.z) * no * no * (1 - f) * g * d / (root * root);
}

static void rough_expression(void **state)
{
    (void)state;
    uint32_t glass = bench_material(&bench, "fresnel", "ior=1.5 alpha=0.4");
    Random random = {8};
    int seen = 0;
    for (int k = 0; k < 20000; ++k) {
        Vec3 o = random_direction(&random), i = random_direction(&random);
        if (o.z * i.z > 0) {
            i = neg(i);
        }
        if (fabs(o.z) < 1e-3 || fabs(i.z) < 1e-3) {
            continue;
        }
        double no = o.z > 0 ? 1 : 1.5, ni = i.z > 0 ? 1 : 1.5;
        ShadingPoint point = bench_point(&bench, o);
        double value = (double)material_eval(&point, glass, i).value.g;
        double expected = walter(o, i, no, ni, 0.4) * fabs(i.z);
        seen += expected > 0;
        if (!near_relative(value, expected, 1e-5)) {
            fail_msg("f cos = %.9g, not %.9g", value, expected);
        }
    }
    assert_true(seen > 2000);
}

static const struct {
    const char *name, *fields;
    double front, back; // indices
} ROUGH[] = {
    {"glass 0.08", "ior=1.5 alpha=0.08", 1, 1.5},
    {"glass 0.4", "ior=1.5 alpha=0.4 color=0.9", 1, 1.5},
    {"glass pair", "ior=1.8 alpha=0.2,0.6 rotation=0.5 approximation=schlick", 1, 1.8},
    {"bubble 1", "ior=1 outside=1.33 alpha=1", 1.33, 1},
};

static void rough_is_consistent(void **state)
{
    (void)state;
    int family = 2 * (int)TEST_COUNT(ROUGH) + 1;
    for (size_t i = 0; i < TEST_COUNT(ROUGH); ++i) {
        uint32_t glass = bench_material(&bench, "fresnel", ROUGH[i].fields);
        check_chi2(&bench, ROUGH[i].name, glass, 1000000, false, family);
        check_chi2(&bench, ROUGH[i].name, glass, 200000, true, family);
        check_weights(&bench, ROUGH[i].name, glass, 200000);
        check_reciprocity(&bench, ROUGH[i].name, glass, 1000000, ROUGH[i].front, ROUGH[i].back);
        check_energy(&bench, ROUGH[i].name, glass, 0.3, 4000);
    }
    uint32_t clear = bench_material(&bench, "fresnel", "ior=1.5");
    check_energy(&bench, "clear glass", clear, 0.9999, 2000);
    // Partly frosted, by a texture: delta lobes and smooth ones.
    uint32_t rough = bench_material(&bench, "fresnel", "ior=1.5 alpha=0.3");
    char text[64];
    snprintf(text, sizeof text, "a=#%u b=#%u weight=0.4", clear, rough);
    uint32_t both = bench_material(&bench, "mix", text);
    check_chi2(&bench, "partly frosted", both, 200000, false, family);
}

// As alpha falls, frosted glass becomes clear glass.
static void roughness_falls_to_clear(void **state)
{
    (void)state;
    uint32_t frosted = bench_material(&bench, "fresnel", "ior=1.5 alpha=0.0005");
    for (double theta = 0; theta < 80; theta += 13) {
        for (int back = 0; back < 2; ++back) {
            Vec3 wo = direction(theta, 0);
            wo.z = back ? -wo.z : wo.z;
            double f = fresnel_dielectric(fabs(wo.z), back ? 1 / 1.5 : 1.5, NULL);
            double reflected = 0, passed = 0;
            enum { N = 20000 };
            Random random = {1};
            ShadingPoint point = bench_point(&bench, wo);
            for (int i = 0; i < N; ++i) {
                BsdfSample s;
                float lobe = random_next(&random), u = random_next(&random);
                if (!material_sample(&point, frosted, lobe, u, random_next(&random), &s)) {
                    continue;
                }
                if (s.wi.z * wo.z > 0) {
                    reflected += (double)s.weight.g / N;
                    continue;
                }
                passed += (double)(s.weight.g * s.eta * s.eta) / N;
            }
            // Five standard deviations of a binomial; near the critical angle F is steep.
            double e = 5 * sqrt(f * (1 - f) / N) + 2e-3;
            assert_near(reflected, f, e);
            assert_near(passed, 1 - f, e);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(smooth, setup, teardown),
        cmocka_unit_test_setup_teardown(schlick, setup, teardown),
        cmocka_unit_test_setup_teardown(equal_media, setup, teardown),
        cmocka_unit_test_setup_teardown(rough_expression, setup, teardown),
        cmocka_unit_test_setup_teardown(rough_is_consistent, setup, teardown),
        cmocka_unit_test_setup_teardown(roughness_falls_to_clear, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
