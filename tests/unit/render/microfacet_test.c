// GGX's parts against their expressions (reference check 20), and the table of its albedo.
#include "base/microfacet.h"
#include "bsdf_check.h"
#include "render/ggx_energy.h"

static const Ggx SURFACES[] = {{0.1, 0.1}, {0.5, 0.5}, {1, 1}, {0.1, 0.6}, {0.9, 0.25}};

// The slides' expression, term by term.
static double expected_d(Ggx g, Vec3 m)
{
    double sum = pow(m.x / g.alpha_x, 2) + pow(m.y / g.alpha_y, 2) + pow(m.z, 2);
    return m.z < 0 ? 0 : 1 / (PI * g.alpha_x * g.alpha_y * pow(sum, 2));
}

static void expressions(void **state)
{
    (void)state;
    Random random = {3};
    for (int i = 0; i < 10000; ++i) {
        Ggx g = SURFACES[(size_t)i % TEST_COUNT(SURFACES)];
        Vec3 m = random_direction(&random), w = random_hemisphere(&random);
        Vec3 wi = random_hemisphere(&random);
        assert_true(near_relative(ggx_d(g, m), expected_d(g, m), 1e-12));
        double ax = g.alpha_x, ay = g.alpha_y;
        double lambda =
            0.5 * (-1 + sqrt(1 + (ax * ax * w.x * w.x + ay * ay * w.y * w.y) / (w.z * w.z)));
        assert_near(ggx_lambda(g, w), lambda, 1e-9 * (1 + lambda));
        double both = 1 / (1 + lambda + ggx_lambda(g, wi));
        assert_true(near_relative(ggx_g2(g, w, wi), both, 1e-9));
        assert_true(ggx_g2(g, w, wi) == ggx_g2(g, wi, w));
        assert_true(near_relative(ggx_g1(g, w), 1 / (1 + lambda), 1e-9));
    }
    for (size_t i = 0; i < TEST_COUNT(SURFACES); ++i) {
        Ggx g = SURFACES[i];
        assert_true(
            near_relative(ggx_d(g, vec3(0, 0, 1)), 1 / (PI * g.alpha_x * g.alpha_y), 1e-12));
    }
}

typedef struct Lobe {
    Ggx g;
    Vec3 wo;
} Lobe;

static double projected(const void *context, Vec3 m)
{
    const Lobe *lobe = context;
    return ggx_d(lobe->g, m) * fmax(0, m.z);
}
static double visible(const void *context, Vec3 m)
{
    const Lobe *lobe = context;
    return ggx_visible_pdf(lobe->g, lobe->wo, m);
}
// The weak white furnace: every visible facet reflects, and only masking towards wo counts.
// w is in a frame about wo, so that -wo, where h turns over the whole hemisphere, is a pole.
static double weak_furnace(const void *context, Vec3 w)
{
    const Lobe *lobe = context;
    Frame frame = frame_from_normal(lobe->wo);
    Vec3 wi = from_local(&frame, w);
    Vec3 h = add(wi, lobe->wo);
    if (length(h) < 1e-12) {
        return 0;
    }
    return ggx_d(lobe->g, normalize(h)) * ggx_g1(lobe->g, lobe->wo) / (4 * fabs(lobe->wo.z));
}
// Expression (10) with F = 1, times the cosine.
static double reflected(const void *context, Vec3 wi)
{
    const Lobe *lobe = context;
    if (wi.z <= 0) {
        return 0;
    }
    return ggx_d(lobe->g, normalize(add(wi, lobe->wo))) * ggx_g2(lobe->g, wi, lobe->wo) /
           (4 * lobe->wo.z);
}

// The edge i of Z + 1 in [-1, 1], close together near the poles, where boxes could slip past what
// is narrow.
enum { Z = 64, SECTORS = 64 };
static double edge(int i)
{
    double t = 1 - fabs(2.0 * i / Z - 1);
    return copysign(1 - t * t * t, i - 0.5 * Z);
}

static double integrate(Spherical f, const Lobe *lobe, double tolerance)
{
    double sum = 0;
    for (int i = 0; i < Z; ++i) {
        for (int k = 0; k < SECTORS; ++k) {
            sum += integrate_box(f, lobe, edge(i), edge(i + 1), k * 2 * PI / SECTORS,
                                 (k + 1) * 2 * PI / SECTORS, tolerance, 13);
        }
    }
    return sum;
}

static void normalisations(void **state)
{
    (void)state;
    double worst[3] = {0};
    for (size_t i = 0; i < TEST_COUNT(SURFACES); ++i) {
        for (double theta = 0; theta < 90; theta += 29) {
            Lobe lobe = {SURFACES[i], direction(theta, 20)};
            worst[0] = fmax(worst[0], fabs(integrate(projected, &lobe, 1e-10) - 1));
            // The densities have edges (a kink where wo leaves a facet's front, a jump where h
            // leaves the hemisphere), which cost the quadrature digits.
            worst[1] = fmax(worst[1], fabs(integrate(visible, &lobe, 1e-10) - 1));
            worst[2] = fmax(worst[2], fabs(integrate(weak_furnace, &lobe, 1e-10) - 1));
        }
    }
    assert_true(trust_at_most("20 GGX, integral of D (m.n) off 1 by", 1e-6, worst[0]));
    assert_true(trust_at_most("20 GGX, integral of the visible normals off 1 by", 2e-5, worst[1]));
    assert_true(trust_at_most("20 GGX, weak white furnace off 1 by", 3e-4, worst[2]));
}

static void albedo_of_mirror_facets(void **state)
{
    (void)state;
    static const struct {
        double alpha, theta, albedo, tolerance;
    } KNOWN[] = {{0.1, 0, 0.988304, 1e-6}, {0.5, 0, 0.687849, 1e-6}, {0.5, 60, 0.69825, 5e-6}};
    for (size_t i = 0; i < TEST_COUNT(KNOWN); ++i) {
        Lobe lobe = {{KNOWN[i].alpha, KNOWN[i].alpha}, direction(KNOWN[i].theta, 0)};
        char name[64];
        snprintf(name, sizeof name, "20 GGX's expression, alpha %g, %g degrees", KNOWN[i].alpha,
                 KNOWN[i].theta);
        assert_true(trust_near(name, KNOWN[i].albedo, integrate(reflected, &lobe, 1e-9),
                               KNOWN[i].tolerance));
    }
    Lobe roughest = {{1, 1}, {0, 0, 1}};
    assert_true(trust_near("20 GGX's expression, alpha 1, 0 degrees", 1 - log(2),
                           integrate(reflected, &roughest, 1e-9), 1e-6));
}

// The table against integration, beside its grid, and its mean against itself.
static void table(void **state)
{
    (void)state;
    Random random = {11};
    for (int i = 0; i < 60; ++i) {
        double alpha = 0.04 + 0.96 * (double)random_next(&random);
        double mu = 0.02 + 0.98 * (double)random_next(&random);
        Lobe lobe = {{alpha, alpha}, {sqrt(1 - mu * mu), 0, mu}};
        assert_near(ggx_energy(alpha, mu), integrate(reflected, &lobe, 1e-7), 1e-4);
    }
    for (double alpha = 0; alpha <= 1; alpha += 0.0371) {
        enum { N = 20000 };
        double sum = 0;
        for (int i = 0; i < N; ++i) {
            sum += 2 * (i + 0.5) / N * ggx_energy(alpha, (i + 0.5) / N) / N;
        }
        assert_near(ggx_energy_mean(alpha), sum, 1e-4);
    }
}

static void samples_follow_their_density(void **state)
{
    (void)state;
    enum { N = 200000, ROWS = 20, COLUMNS = 16 };
    for (size_t i = 0; i < TEST_COUNT(SURFACES); ++i) {
        for (double theta = 0; theta < 90; theta += 42) {
            Lobe lobe = {SURFACES[i], direction(theta, -70)};
            static double observed[ROWS * COLUMNS];
            memset(observed, 0, sizeof observed);
            Random random = {i << 40};
            for (int k = 0; k < N; ++k) {
                double u = (double)random_next(&random), v = (double)random_next(&random);
                Vec3 m = ggx_sample_visible(lobe.g, lobe.wo, u, v);
                assert_true(m.z >= 0 && dot(m, lobe.wo) >= -1e-12);
                double phi = atan2(m.y, m.x);
                int zi = (int)fmin(m.z * ROWS, ROWS - 1);
                int pi = (int)fmin((phi + PI) / (2 * PI) * COLUMNS, COLUMNS - 1);
                ++observed[zi * COLUMNS + pi];
            }
            double sum = 0;
            int cells = 0;
            for (int k = 0; k < ROWS * COLUMNS; ++k) {
                double z = k / COLUMNS / (double)ROWS, phi = -PI + k % COLUMNS * 2 * PI / COLUMNS;
                double e = N * integrate_box(visible, &lobe, z, z + 1.0 / ROWS, phi,
                                             phi + 2 * PI / COLUMNS, 1e-8, 14);
                if (e >= 5) {
                    sum += (observed[k] - e) * (observed[k] - e) / e;
                    ++cells;
                }
            }
            // 15 tests; some cells are left out, so the last degree isn't lost.
            assert_true(gamma_q(0.5 * cells, 0.5 * sum) > 1 - pow(0.99, 1.0 / 15));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(expressions),
        cmocka_unit_test(normalisations),
        cmocka_unit_test(albedo_of_mirror_facets),
        cmocka_unit_test(table),
        cmocka_unit_test(samples_follow_their_density),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
