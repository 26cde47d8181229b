// layered: against a brute-force random walk between the layers, closed forms, and its parts
// against each other.
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

typedef struct Stack {
    const char *name;
    uint32_t coat, base, layered;
    double depth; // absorption times thickness
} Stack;

enum { STACKS = 9 };
static Stack stacks[STACKS];

static uint32_t make(const char *kind, const char *format, uint32_t a, uint32_t b)
{
    char text[128];
    snprintf(text, sizeof text, format, a, b);
    return bench_material(&bench, kind, text);
}

static void put_stack(Stack *stack, const char *name, uint32_t coat, uint32_t base, double depth)
{
    char text[128];
    snprintf(text, sizeof text, "coat=#%u base=#%u thickness=0.01 absorption=%g", coat, base,
             depth * 100);
    *stack = (Stack){name, coat, base, bench_material(&bench, "layered", text), depth};
    assert_int_not_equal(stack->layered, NONE_ID);
    assert_int_equal(bench.reports, 0);
}

static void make_stacks(void)
{
    uint32_t clear = bench_material(&bench, "fresnel", "ior=1.5");
    uint32_t frosted = bench_material(&bench, "fresnel", "ior=1.5 alpha=0.3");
    uint32_t varnish = bench_material(&bench, "ggx", "ior=1.7 alpha=0.1");
    uint32_t white = bench_material(&bench, "lambert", "color=0.8");
    uint32_t metal = bench_material(&bench, "ggx", "eta=0.2 k=3 alpha=0.25");
    uint32_t mirror = bench_material(&bench, "mirror", "color=0.9");
    uint32_t shiny = make("mix", "a=#%u b=#%u weight=0.6", mirror, white);
    uint32_t patchy = make("mix", "a=#%u b=#%u weight=0.5", clear, frosted);
    uint32_t flaking = make("mask", "opacity=0.6 base=#%u", frosted, 0);
    int i = 0;
    put_stack(&stacks[i++], "clear over white", clear, white, 0);
    put_stack(&stacks[i++], "clear over metal, absorbing", clear, metal, 0.3);
    put_stack(&stacks[i++], "frosted over white, absorbing", frosted, white, 0.2);
    put_stack(&stacks[i++], "frosted over mirror", frosted, mirror, 0);
    put_stack(&stacks[i++], "varnish over metal", varnish, metal, 0);
    put_stack(&stacks[i++], "clear over mirror and white", clear, shiny, 0.1);
    put_stack(&stacks[i++], "patchy over mirror and white", patchy, shiny, 0);
    put_stack(&stacks[i++], "flaking over white", flaking, white, 0.1);
    put_stack(&stacks[i++], "twice layered", varnish, stacks[0].layered, 0.1);
    assert_int_equal(i, STACKS);
}

// --- The brute-force walk -----------------------------------------------------------------------

static const ShadingPoint *point_from(ShadingPoint *point, Vec3 w, MaterialLayer layer)
{
    *point = bench_point(&bench, w);
    bench.surface.front = true;
    point->layer = layer;
    return point;
}

// One path by the layers' own sample functions, without any cleverness. False: it was absorbed.
static bool walk(const Stack *stack, Vec3 viewer, Random *random, Vec3 *exit, double *weight,
                 bool *delta)
{
    Vec3 w = viewer;
    *weight = 1;
    *delta = true;
    for (int i = 0; i < 10000; ++i) {
        bool at_coat = i % 2 == 0;
        ShadingPoint point;
        BsdfSample s;
        float a = random_next(random), b = random_next(random), c = random_next(random);
        if (!material_sample(point_from(&point, w, at_coat ? LAYER_COAT : LAYER_NONE),
                             at_coat ? stack->coat : stack->base, a, b, c, &s)) {
            return false;
        }
        *weight *= (double)s.weight.g;
        *delta = *delta && (s.lobes & LOBE_DELTA);
        if (at_coat && s.wi.z > 0) {
            *exit = s.wi;
            return true;
        }
        *weight *= exp(-stack->depth / fabs(s.wi.z));
        w = neg(s.wi);
    }
    return false;
}

// --- Moments ------------------------------------------------------------------------------------

// Light is counted by where it goes: six parts of the hemisphere, and delta lobes.
enum { PARTS = 7 };

static int part_of(Vec3 w, bool delta)
{
    int ring = w.z > 0.8 ? 0 : w.z > 0.45 ? 1 : 2;
    return delta ? PARTS - 1 : 2 * ring + (w.x > 0);
}

typedef struct Moments {
    double sum[PARTS], square[PARTS], count;
} Moments;

static void moments_add(Moments *m, int part, double weight)
{
    m->sum[part] += weight;
    m->square[part] += weight * weight;
}

static double mean_of(const Moments *m, int part)
{
    return m->sum[part] / m->count;
}
static double variance_of(const Moments *m, int part) // of the mean
{
    double mean = mean_of(m, part);
    return fmax(m->square[part] / m->count - mean * mean, 0) / m->count;
}

static void compare(const char *what, const char *name, double theta, const Moments *a,
                    const Moments *b, bool with_delta)
{
    for (int part = 0; part < PARTS - !with_delta; ++part) {
        double difference = mean_of(a, part) - mean_of(b, part);
        double error = sqrt(variance_of(a, part) + variance_of(b, part));
        // 9 stacks, 2 angles, 2 x 7 parts: family-wise 1e-3 by Šidák.
        if (fabs(difference) > 5.0 * error + 1e-6) {
            fail_msg("%s, %s at %g degrees, part %d: %.6f, walk %.6f, z = %.2f", name, what, theta,
                     part, mean_of(a, part), mean_of(b, part), difference / error);
        }
    }
}

// Where light goes: by the walk, by the material's samples, and by its values at random directions.
static void agrees_with_the_walk(void **state)
{
    (void)state;
    make_stacks();
    enum { N = 30000 };
    static const double ANGLES[] = {20, 70};
    Random random = {77};
    for (int i = 0; i < STACKS; ++i) {
        for (int k = 0; k < 2; ++k) {
            const Stack *stack = &stacks[i];
            Vec3 wo = direction(ANGLES[k], 180); // light goes to +x
            Moments brute = {.count = N}, samples = {.count = N}, values = {.count = N};
            for (int n = 0; n < N; ++n) {
                Vec3 exit;
                double weight;
                bool delta;
                if (walk(stack, wo, &random, &exit, &weight, &delta)) {
                    moments_add(&brute, part_of(exit, delta), weight);
                }
                // The place seeds the material's walks.
                bench.surface.p = vec3((double)n, (double)i, (double)k);
                ShadingPoint point = bench_point(&bench, wo);
                float a = random_next(&random), b = random_next(&random);
                BsdfSample s;
                if (material_sample(&point, stack->layered, a, b, random_next(&random), &s)) {
                    moments_add(&samples, part_of(s.wi, s.lobes & LOBE_DELTA), (double)s.weight.g);
                }
                Vec3 wi = random_hemisphere(&random);
                moments_add(&values, part_of(wi, false),
                            2 * PI * (double)material_eval(&point, stack->layered, wi).value.g);
            }
            compare("samples", stack->name, ANGLES[k], &samples, &brute, true);
            compare("values", stack->name, ANGLES[k], &values, &brute, false);
            double found = 0, error = 0;
            for (int part = 0; part < PARTS; ++part) {
                found += mean_of(&samples, part);
                error += variance_of(&samples, part);
            }
            if (i == 0 || i == 4) {
                print_message("  %s at %g degrees: albedo %.4f +- %.4f\n", stack->name, ANGLES[k],
                              found, sqrt(error));
            }
            assert_true(found <= 1 + 4 * sqrt(error)); // energy
        }
    }
}

// --- Closed forms -------------------------------------------------------------------------------

// A smooth coat over Lambert: light that isn't reflected enters, is spread evenly below, and leaves
// by what of it isn't reflected down again:
//   f = F δ + (1 - F(o)) (1 - F(i))/η² · (k/π)/(1 - k Fin)
static void coat_over_lambert(void **state)
{
    (void)state;
    bench_material(&bench, "fresnel", "ior=1.5");
    bench_material(&bench, "lambert", "color=0.8");
    uint32_t lacquer = bench_material(&bench, "layered", "coat=#0 base=#1");
    static const double ANGLES[][2] = {{0, 0}, {30, 60}, {75, 20}, {80, 85}};
    for (size_t i = 0; i < TEST_COUNT(ANGLES); ++i) {
        Vec3 wo = direction(ANGLES[i][0], 10), wi = direction(ANGLES[i][1], 120);
        double passed = (1 - fresnel_dielectric(wo.z, 1.5, NULL)) *
                        (1 - fresnel_dielectric(wi.z, 1.5, NULL)) / (1.5 * 1.5);
        double inside = fresnel_dielectric_mean(1 / 1.5), k = (double)0.8f;
        double expected = passed * k / PI / (1 - k * inside) * wi.z;
        enum { N = 60000 };
        double sum = 0, square = 0;
        for (int n = 0; n < N; ++n) {
            bench.surface.p.x = n;
            ShadingPoint point = bench_point(&bench, wo);
            double v = (double)material_eval(&point, lacquer, wi).value.g;
            sum += v / N, square += v * v / N;
        }
        double error = sqrt((square - sum * sum) / N);
        if (fabs(sum - expected) > 4.5 * error || error > 1e-2 * expected) {
            fail_msg("%g, %g degrees: %.6f +- %.6f, not %.6f", ANGLES[i][0], ANGLES[i][1], sum,
                     error, expected);
        }
    }
}

// A smooth coat over a mirror: all light leaves in one direction, F + (1-F)² R A²/(1 - F R A²).
static void coat_over_mirror(void **state)
{
    (void)state;
    bench_material(&bench, "fresnel", "ior=1.5");
    bench_material(&bench, "mirror", "color=0.9");
    uint32_t m =
        bench_material(&bench, "layered", "coat=#0 base=#1 thickness=0.002 absorption=100");
    for (double theta = 0; theta < 89; theta += 11) {
        Vec3 wo = direction(theta, 40);
        double ct, f = fresnel_dielectric(wo.z, 1.5, &ct), a = exp(-0.2 / ct);
        double expected = f + (1 - f) * (1 - f) * 0.9 * a * a / (1 - f * 0.9 * a * a);
        for (int back = 0; back < 2; ++back) {
            wo.z = back ? -fabs(wo.z) : fabs(wo.z);
            ShadingPoint point = bench_point(&bench, wo);
            BsdfSample s, all[DELTA_ROOM];
            assert_true(material_sample(&point, m, 0.3f, 0.5f, 0.5f, &s));
            assert_near((double)s.weight.g, expected, 1e-5);
            assert_near(length(sub(s.wi, vec3(-wo.x, -wo.y, wo.z))), 0, 1e-6);
            assert_int_equal(material_deltas(&point, m, all, DELTA_ROOM), 1);
            assert_near((double)all[0].weight.g, expected, 1e-5);
            assert_true(material_eval(&point, m, s.wi).pdf == 0);
        }
    }
}

// A coat of no index, no roughness, no thickness is nothing.
static void coat_of_nothing(void **state)
{
    (void)state;
    bench_material(&bench, "fresnel", "ior=1");
    bench_material(&bench, "burley", "color=0.7 roughness=0.9");
    uint32_t same = bench_material(&bench, "layered", "coat=#0 base=#1");
    Random random = {3};
    for (int i = 0; i < 1000; ++i) {
        Vec3 wo = random_hemisphere(&random), wi = random_hemisphere(&random);
        ShadingPoint point = bench_point(&bench, wo);
        double bare = (double)material_eval(&point, 1, wi).value.g;
        assert_near((double)material_eval(&point, same, wi).value.g, bare, 1e-5 * bare);
    }
}

// Nothing is lost: a clear coat over white gives all light back, the sooner or later.
static void nothing_is_lost(void **state)
{
    (void)state;
    bench_material(&bench, "fresnel", "ior=1.5");
    bench_material(&bench, "lambert", "color=1");
    uint32_t white = bench_material(&bench, "layered", "coat=#0 base=#1");
    for (double theta = 0; theta < 90; theta += 22) {
        double error;
        Vec3 wo = direction(theta, 70);
        Rgb albedo = albedo_by_sampling(&bench, white, wo, 40000, &error);
        assert_true(error < 8e-3);
        assert_near((double)albedo.g, 1, 4 * error);
    }
}

static void is_consistent(void **state)
{
    (void)state;
    make_stacks();
    static const int CHOSEN[] = {6};
    int family = (int)TEST_COUNT(CHOSEN);
    for (size_t i = 0; i < TEST_COUNT(CHOSEN); ++i) {
        const Stack *stack = &stacks[CHOSEN[i]];
        check_chi2(&bench, stack->name, stack->layered, 100000, false, family);
        check_weights(&bench, stack->name, stack->layered, 20000);
    }
    for (int i = 0; i < STACKS; ++i) {
        check_reciprocity(&bench, stacks[i].name, stacks[i].layered, 10000, 1, 1);
    }
}

static void finishes(void **state)
{
    (void)state;
    bench_material(&bench, "fresnel", "");
    bench_material(&bench, "lambert", "");
    bench_material(&bench, "ggx", "eta=0.2 k=3");
    bench_material(&bench, "mix", "a=#0 b=#1");
    assert_int_equal(bench_material(&bench, "layered", "coat=#0 base=#0"), NONE_ID);
    assert_int_equal(bench.reported, E0952);
    assert_int_equal(bench_material(&bench, "layered", "coat=#0 base=#3"), NONE_ID);
    assert_int_not_equal(bench_material(&bench, "layered", "coat=#2 base=#1"), NONE_ID);
    assert_true(bench.reports == 1 && bench.reported == W0952);
    assert_int_not_equal(bench_material(&bench, "layered", "coat=#3 base=#2"), NONE_ID);
    assert_int_equal(bench.reports, 0);
    // An opaque coat is all there is to see.
    Vec3 wo = direction(30, 0), wi = direction(35, 170);
    ShadingPoint point = bench_point(&bench, wo);
    assert_near((double)material_eval(&point, 4, wi).value.g,
                (double)material_eval(&point, 2, wi).value.g, 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(finishes, setup, teardown),
        cmocka_unit_test_setup_teardown(coat_of_nothing, setup, teardown),
        cmocka_unit_test_setup_teardown(coat_over_mirror, setup, teardown),
        cmocka_unit_test_setup_teardown(coat_over_lambert, setup, teardown),
        cmocka_unit_test_setup_teardown(nothing_is_lost, setup, teardown),
        cmocka_unit_test_setup_teardown(agrees_with_the_walk, setup, teardown),
        cmocka_unit_test_setup_teardown(is_consistent, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
