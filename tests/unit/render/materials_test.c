// phong, blinn_phong, burley, mirror, ggx, mix and lambert: against their expressions, and their
// sample, eval and pdf against each other (reference checks 17 to 22).
#include "base/fresnel.h"
#include "base/microfacet.h"
#include "bsdf_check.h"
#include "render/ggx_energy.h"

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

// Holds eval to an expression of f(wo, wi), on both sides.
static void check_expression(uint32_t material, double (*f)(Vec3 wo, Vec3 wi))
{
    Random random = {5};
    for (int i = 0; i < 10000; ++i) {
        Vec3 wo = random_hemisphere(&random), wi = random_hemisphere(&random);
        double expected = f(wo, wi) * wi.z;
        ShadingPoint point = bench_point(&bench, wo);
        double front = (double)material_eval(&point, material, wi).value.g;
        Vec3 wo_back = vec3(wo.x, wo.y, -wo.z), wi_back = vec3(wi.x, wi.y, -wi.z);
        point = bench_point(&bench, wo_back);
        double back = (double)material_eval(&point, material, wi_back).value.g;
        if (!near_relative(front, expected, 1e-5) || !near_relative(back, expected, 1e-5)) {
            fail_msg("f cos = %.9g in front, %.9g behind, not %.9g", front, back, expected);
        }
        assert_true(material_eval(&point, material, wi).pdf == 0);
    }
}

typedef struct AlbedoContext {
    ShadingPoint point;
    uint32_t material;
} AlbedoContext;
static double value_at(const void *context, Vec3 wi)
{
    const AlbedoContext *c = context;
    return (double)material_eval(&c->point, c->material, wi).value.g;
}
// By quadrature, in rings that narrow lobes about the normal don't slip through.
static double albedo(uint32_t material, double theta)
{
    AlbedoContext c = {bench_point(&bench, direction(theta, 0)), material};
    static const double RINGS[] = {0, 0.9, 0.99, 0.999, 1};
    double sum = 0;
    for (size_t i = 0; i + 1 < TEST_COUNT(RINGS); ++i) {
        sum += 2 * integrate_box(value_at, &c, RINGS[i], RINGS[i + 1], 0, PI, 1e-9, 12);
    }
    return sum;
}

// --- Expressions ------------------------------------------------------------------------------

static double lambert_f(Vec3 wo, Vec3 wi)
{
    (void)wo, (void)wi;
    return (double)0.7f / PI;
}
static double phong_f(Vec3 v, Vec3 l)
{
    Vec3 r = sub(vec3(0, 0, 2 * l.z), l);
    return 0.6 * 0.5 / PI + 0.3 * 0.8 * 12 / (2 * PI) * pow(fmax(0, dot(r, v)), 10);
}
static double blinn_f(Vec3 v, Vec3 l)
{
    Vec3 h = normalize(add(v, l));
    double norm = 12 * 14 / (8 * PI * (pow(2, -5) + 10));
    return 0.6 * 0.5 / PI + 0.3 * 0.8 * norm * pow(h.z, 10);
}
static double burley_f(Vec3 wo, Vec3 wi)
{
    double f90 = 0.5 + 2 * 0.8 * pow(dot(wi, normalize(add(wi, wo))), 2);
    return 0.4 / PI * (1 + (f90 - 1) * pow(1 - wi.z, 5)) * (1 + (f90 - 1) * pow(1 - wo.z, 5));
}

// Expression (10) in the author's tangent frame, turned by 30 degrees.
static double ggx_part(Vec3 wo, Vec3 wi, double ax, double ay, double angle)
{
    Vec3 tx = vec3(cos(angle), sin(angle), 0), ty = vec3(-sin(angle), cos(angle), 0);
    Vec3 h = normalize(add(wi, wo));
    double s = pow(dot(h, tx) / ax, 2) + pow(dot(h, ty) / ay, 2) + h.z * h.z;
    double d = 1 / (PI * ax * ay * s * s);
    double li =
        0.5 *
        (-1 + sqrt(1 + (pow(ax * dot(wi, tx), 2) + pow(ay * dot(wi, ty), 2)) / (wi.z * wi.z)));
    double lo =
        0.5 *
        (-1 + sqrt(1 + (pow(ax * dot(wo, tx), 2) + pow(ay * dot(wo, ty), 2)) / (wo.z * wo.z)));
    return d / (1 + li + lo) / (4 * wi.z * wo.z);
}
static double half_angle(Vec3 wo, Vec3 wi)
{
    return dot(wi, normalize(add(wi, wo)));
}
static double ggx_schlick_f(Vec3 wo, Vec3 wi)
{
    double f = 0.25 + 0.75 * pow(1 - half_angle(wo, wi), 5);
    return f * ggx_part(wo, wi, 0.15, 0.6, PI / 6);
}
static double ggx_exact_f(Vec3 wo, Vec3 wi)
{
    double ci = half_angle(wo, wi), ct = sqrt(1 - (1 - ci * ci) / (1.7 * 1.7));
    double f = 0.5 * (pow((ci - 1.7 * ct) / (ci + 1.7 * ct), 2) +
                      pow((ct - 1.7 * ci) / (ct + 1.7 * ci), 2));
    return f * ggx_part(wo, wi, 0.3, 0.3, 0);
}
static double ggx_metal_f(Vec3 wo, Vec3 wi)
{
    return fresnel_conductor(half_angle(wo, wi), (double)0.375f, (double)2.386f) *
           ggx_part(wo, wi, 0.3, 0.3, 0);
}
static double ggx_preserve_f(Vec3 wo, Vec3 wi)
{
    double mean = ggx_energy_mean(0.7), f = 0.5 + 0.5 / 21;
    double between = f * f * mean / (1 - f * (1 - mean));
    double spread = (1 - ggx_energy(0.7, wo.z)) * (1 - ggx_energy(0.7, wi.z)) / (PI * (1 - mean));
    return (0.5 + 0.5 * pow(1 - half_angle(wo, wi), 5)) * ggx_part(wo, wi, 0.7, 0.7, 0) +
           between * spread;
}
static double mix_f(Vec3 wo, Vec3 wi)
{
    return 0.75 * lambert_f(wo, wi) + 0.25 * burley_f(wo, wi);
}

static void expressions(void **state)
{
    (void)state;
    uint32_t lambert = bench_material(&bench, "lambert", "color=0.7");
    uint32_t burley = bench_material(&bench, "burley", "color=0.4 roughness=0.8");
    const char *phong = "color=0.5 diffuse=0.6 specular=0.3 specular_color=0.8 shininess=10";
    check_expression(lambert, lambert_f);
    check_expression(burley, burley_f);
    check_expression(bench_material(&bench, "phong", phong), phong_f);
    check_expression(bench_material(&bench, "blinn_phong", phong), blinn_f);
    check_expression(
        bench_material(&bench, "ggx", "f0=0.25 alpha=0.15,0.6 rotation=0.5235987755982988"),
        ggx_schlick_f);
    check_expression(bench_material(&bench, "ggx", "ior=1.7 alpha=0.3"), ggx_exact_f);
    check_expression(
        bench_material(&bench, "ggx", "eta=0.143,0.375,1.442 k=3.983,2.386,1.603 alpha=0.3"),
        ggx_metal_f);
    check_expression(bench_material(&bench, "ggx", "f0=0.5 alpha=0.7 energy=preserve"),
                     ggx_preserve_f);
    char text[64];
    snprintf(text, sizeof text, "a=#%u b=#%u weight=0.25", lambert, burley);
    check_expression(bench_material(&bench, "mix", text), mix_f);
}

// The slides' raw expressions, for the `local` integrator.
static void local_expressions(void **state)
{
    (void)state;
    const char *fields =
        "color=0.5,0.4,0.3 ambient=0.1 diffuse=0.6 specular=0.3 specular_color=0.8 shininess=10";
    uint32_t phong = bench_material(&bench, "phong", fields);
    uint32_t blinn = bench_material(&bench, "blinn_phong", fields);
    uint32_t lambert = bench_material(&bench, "lambert", "color=0.5");
    uint32_t burley = bench_material(&bench, "burley", "color=0.4 roughness=0.8");
    Random random = {9};
    for (int i = 0; i < 1000; ++i) {
        Vec3 v = random_hemisphere(&random), l = random_direction(&random);
        ShadingPoint point = bench_point(&bench, v);
        double d = l.z > 0 ? 1 : 0;
        Vec3 r = sub(vec3(0, 0, 2 * l.z), l);
        LocalTerms t = material_local(&point, phong, l);
        assert_near((double)t.ambient.g, 0.1 * 0.4, 1e-6);
        assert_near((double)t.diffuse.r, 0.6 * 0.5 * fmax(0, l.z), 1e-6);
        assert_near((double)t.specular.b, 0.3 * 0.8 * d * pow(fmax(0, dot(r, v)), 10), 1e-6);
        t = material_local(&point, blinn, l);
        Vec3 h = normalize(add(v, l));
        assert_near((double)t.ambient.r, 0.1 * 0.5, 1e-6);
        assert_near((double)t.diffuse.b, 0.6 * 0.3 * fmax(0, l.z), 1e-6);
        assert_near((double)t.specular.g, 0.3 * 0.8 * d * pow(fmax(h.z, 0), 10), 1e-6);
        t = material_local(&point, lambert, l);
        assert_near((double)t.diffuse.g, 0.5 * fmax(0, l.z), 1e-6);
        assert_true(rgb_is_black(t.ambient) && rgb_is_black(t.specular));
        t = material_local(&point, burley, l);
        double f = l.z > 0 ? PI * burley_f(v, l) * l.z : 0;
        assert_near((double)t.specular.g, f, 1e-5);
    }
}

// --- Exact values -----------------------------------------------------------------------------

static void burley_albedo(void **state)
{
    (void)state;
    static const double EXPECTED[3][2] = {
        {41.0 / 42, 0.960937}, {169.0 / 168, 1.008320}, {29.0 / 28, 1.056904}};
    for (int i = 0; i < 3; ++i) {
        char text[64];
        snprintf(text, sizeof text, "color=1 roughness=%g", i * 0.5);
        uint32_t material = bench_material(&bench, "burley", text);
        for (int k = 0; k < 2; ++k) {
            snprintf(text, sizeof text, "21 Burley's albedo, roughness %g, %d degrees", i * 0.5,
                     60 * k);
            assert_true(trust_near(text, EXPECTED[i][k], albedo(material, 60 * k), 1e-6));
        }
    }
}

static void phong_albedos(void **state)
{
    (void)state;
    static const double EXPONENTS[] = {0, 1, 5, 10, 80, 1000};
    for (size_t i = 0; i < TEST_COUNT(EXPONENTS); ++i) {
        char text[64];
        snprintf(text, sizeof text, "diffuse=0 specular=1 shininess=%g", EXPONENTS[i]);
        uint32_t blinn = bench_material(&bench, "blinn_phong", text);
        uint32_t phong = bench_material(&bench, "phong", text);
        snprintf(text, sizeof text, "22 Blinn-Phong's albedo, n = %g, 0 degrees", EXPONENTS[i]);
        assert_true(trust_near(text, 1, albedo(blinn, 0), 2e-6));
        snprintf(text, sizeof text, "22 Phong's albedo, n = %g, 0 degrees", EXPONENTS[i]);
        assert_true(trust_near(text, 1, albedo(phong, 0), 2e-6));
        for (double theta = 0; theta < 90; theta += 9.7) {
            assert_true(albedo(blinn, theta) < 1 + 1e-5);
            assert_true(albedo(phong, theta) < 1 + 1e-5);
        }
    }
    uint32_t phong = bench_material(&bench, "phong", "diffuse=0 specular=1 shininess=10");
    assert_true(
        trust_near("22 Phong's albedo, n = 10, 60 degrees", 0.504736, albedo(phong, 60), 1e-6));
}

static void ggx_albedos(void **state)
{
    (void)state;
    static const struct {
        double alpha, theta, albedo, tolerance;
    } KNOWN[] = {{0.1, 0, 0.988304, 2e-6},
                 {0.5, 0, 0.687849, 2e-6},
                 {1, 0, 1 - 0.6931471805599453, 2e-6},
                 {0.5, 60, 0.69825, 5e-6}};
    for (size_t i = 0; i < TEST_COUNT(KNOWN); ++i) {
        char text[64];
        snprintf(text, sizeof text, "f0=1 alpha=%g", KNOWN[i].alpha);
        uint32_t material = bench_material(&bench, "ggx", text);
        snprintf(text, sizeof text, "20 GGX's albedo, alpha %g, %g degrees", KNOWN[i].alpha,
                 KNOWN[i].theta);
        assert_true(trust_near(text, KNOWN[i].albedo, albedo(material, KNOWN[i].theta),
                               KNOWN[i].tolerance));
    }
}

// The white furnace: facets that absorb nothing give all light back, at every roughness and angle.
static void white_furnace(void **state)
{
    (void)state;
    static const double ALPHAS[] = {0.05, 0.11, 0.29, 0.5, 0.77, 1};
    for (size_t i = 0; i < TEST_COUNT(ALPHAS); ++i) {
        char text[64];
        snprintf(text, sizeof text, "f0=1 alpha=%g energy=preserve", ALPHAS[i]);
        uint32_t material = bench_material(&bench, "ggx", text);
        for (double theta = 0; theta < 89; theta += 11) {
            assert_near(albedo(material, theta), 1, 5e-4);
        }
    }
    // A pair has a coarser table of its own.
    static const char *const PAIRS[] = {"0.2,0.4", "0.1,0.9", "0.5,0.05", "1,0.3"};
    for (size_t i = 0; i < TEST_COUNT(PAIRS); ++i) {
        char text[64];
        snprintf(text, sizeof text, "f0=1 alpha=%s energy=preserve", PAIRS[i]);
        uint32_t pair = bench_material(&bench, "ggx", text);
        for (double theta = 0; theta < 80; theta += 13) {
            AlbedoContext c = {bench_point(&bench, direction(theta, 8 * theta)), pair};
            double sum = 0;
            for (int k = 0; k < 64; ++k) {
                double z = k / 8 / 8.0, phi = k % 8 * PI / 4;
                sum += integrate_box(value_at, &c, z, z + 0.125, phi, phi + PI / 4, 1e-7, 12);
            }
            assert_near(sum, 1, 5e-3);
        }
    }
}

static void mirrors(void **state)
{
    (void)state;
    uint32_t mirror = bench_material(&bench, "mirror", "color=0.9,0.8,0.7");
    uint32_t gold = bench_material(&bench, "mirror", "eta=0.143,0.375,1.442 k=3.983,2.386,1.603");
    uint32_t polished = bench_material(&bench, "ggx", "f0=0.25 alpha=0");
    Random random = {4};
    for (int i = 0; i < 100; ++i) {
        Vec3 wo = random_direction(&random);
        ShadingPoint point = bench_point(&bench, wo);
        BsdfSample s;
        assert_true(material_sample(&point, mirror, 0.5f, 0.5f, 0.5f, &s));
        // Slides, section 3.1: wi = 2 (wr·n) n - wr.
        assert_near(length(sub(s.wi, vec3(-wo.x, -wo.y, wo.z))), 0, 1e-15);
        assert_true(s.weight.g == 0.8f && s.pdf == 1 && s.eta == 1 &&
                    s.lobes == (LOBE_REFLECT | LOBE_DELTA));
        assert_true(material_sample(&point, gold, 0.5f, 0.5f, 0.5f, &s));
        assert_near((double)s.weight.b,
                    fresnel_conductor(fabs(wo.z), (double)1.442f, (double)1.603f), 1e-6);
        assert_true(material_sample(&point, polished, 0.5f, 0.5f, 0.5f, &s));
        assert_near((double)s.weight.b, fresnel_schlick(0.25, fabs(wo.z)), 1e-6);
        assert_true(s.lobes & LOBE_DELTA);
        assert_true(material_eval(&point, polished, s.wi).pdf == 0);
    }
}

// --- Consistency ------------------------------------------------------------------------------

static const struct {
    const char *name, *kind, *fields;
    double least; // albedo that no angle falls below
    bool energetic;
} LOBES[] = {
    {"lambert", "lambert", "color=0.9", 0.89, false},
    {"phong 3", "phong", "color=1 diffuse=0.4 specular=0.6 shininess=3", 0.3, false},
    {"phong 400", "phong", "diffuse=0 specular=1 shininess=400", 0, false},
    {"blinn 7", "blinn_phong", "color=1 diffuse=0.2 specular=0.8 shininess=7", 0.15, false},
    {"blinn 900", "blinn_phong", "diffuse=0 specular=1 shininess=900", 0, false},
    {"burley", "burley", "color=0.9 roughness=0.9", 0, true},
    {"ggx 0.04", "ggx", "f0=1 alpha=0.04", 0.7, false},
    {"ggx 0.3", "ggx", "f0=1 alpha=0.3", 0.7, false},
    {"ggx 1", "ggx", "ior=1.5 alpha=1", 0, false},
    {"ggx pair", "ggx", "f0=1 alpha=0.05,0.5 rotation=0.7", 0.5, false},
    {"ggx preserve", "ggx", "f0=1 alpha=0.6 energy=preserve", 0.999, false},
    {"ggx pair preserve", "ggx", "f0=0.9 alpha=0.2,0.7 energy=preserve", 0.8, false},
};

static void lobes_are_consistent(void **state)
{
    (void)state;
    int family = 2 * (int)TEST_COUNT(LOBES) + 2;
    for (size_t i = 0; i < TEST_COUNT(LOBES); ++i) {
        uint32_t material = bench_material(&bench, LOBES[i].kind, LOBES[i].fields);
        check_chi2(&bench, LOBES[i].name, material, 1000000, false, family);
        check_chi2(&bench, LOBES[i].name, material, 20000, true, family);
        check_weights(&bench, LOBES[i].name, material, 100000);
        check_reciprocity(&bench, LOBES[i].name, material, 1000000, 1, 1);
        if (!LOBES[i].energetic) {
            check_energy(&bench, LOBES[i].name, material, LOBES[i].least, 4000);
        }
    }
    // A sum of a delta lobe and two smooth ones, nested.
    uint32_t mirror = bench_material(&bench, "mirror", "");
    char text[64];
    snprintf(text, sizeof text, "a=#%u b=#1 weight=0.3", mirror);
    uint32_t inner = bench_material(&bench, "mix", text);
    snprintf(text, sizeof text, "a=#%u b=#6 weight=0.4", inner);
    uint32_t outer = bench_material(&bench, "mix", text);
    check_chi2(&bench, "mix", outer, 1000000, false, family);
    check_weights(&bench, "mix", outer, 100000);
    check_reciprocity(&bench, "mix", outer, 1000000, 1, 1);
    check_energy(&bench, "mix", outer, 0.5, 4000);
}

// weight 0 is all a, 1 all b; a texture may say how much.
static void mix_weights(void **state)
{
    (void)state;
    bench_material(&bench, "lambert", "color=0.2");
    bench_material(&bench, "lambert", "color=0.8");
    uint32_t texture = bench_texture(&bench, "vertex_color", "");
    char text[64];
    snprintf(text, sizeof text, "a=#0 b=#1 weight=#%u", texture);
    uint32_t zero = bench_material(&bench, "mix", "a=#0 b=#1 weight=0");
    uint32_t one = bench_material(&bench, "mix", "a=#0 b=#1 weight=1");
    uint32_t textured = bench_material(&bench, "mix", text);
    ShadingPoint point = bench_point(&bench, direction(20, 0));
    Vec3 wi = direction(50, 90);
    double unit = wi.z / PI;
    for (float w = 0; w <= 1; w += 0.25f) {
        bench.surface.color = rgb_gray(w);
        assert_near((double)material_eval(&point, zero, wi).value.g, 0.2 * unit, 1e-6);
        assert_near((double)material_eval(&point, one, wi).value.g, 0.8 * unit, 1e-6);
        assert_near((double)material_eval(&point, textured, wi).value.g,
                    (0.2 + 0.6 * (double)w) * unit, 1e-6);
    }
    bench.surface.color = rgb_gray(1);
}

// Base colour tints ambient and diffuse only.
static void base_color_leaves_highlights_white(void **state)
{
    (void)state;
    uint32_t texture = bench_texture(&bench, "vertex_color", "");
    char text[96];
    snprintf(text, sizeof text, "color=#%u diffuse=0.5 specular=0.5 shininess=50", texture);
    uint32_t material = bench_material(&bench, "phong", text);
    bench.surface.color = rgb(1, 0, 0);
    ShadingPoint point = bench_point(&bench, direction(30, 0));
    Rgb value = material_eval(&point, material, direction(30, 180)).value;
    assert_true(value.g > 0 && value.g == value.b && value.r > value.g);
    bench.surface.color = rgb_gray(1);
}

// A texture for a constant gives what the constant gives.
static void textures_stand_for_constants(void **state)
{
    (void)state;
    static const struct {
        const char *kind, *constant, *textured; // %u: the texture
        double value;
    } CASES[] = {
        {"ggx", "ior=1.7 alpha=0.3", "ior=#%u alpha=0.3", 1.7},
        {"ggx", "ior=1.7 alpha=0.3 fresnel=schlick", "ior=#%u alpha=0.3 fresnel=schlick", 1.7},
        {"ggx", "ior=1.7 alpha=0.6 energy=preserve", "ior=#%u alpha=0.6 energy=preserve", 1.7},
        {"ggx", "eta=0.2 k=3 alpha=0.3", "eta=#%u k=3 alpha=0.3", 0.2},
        {"ggx", "eta=0.2 k=3 alpha=0.3", "eta=0.2 k=#%u alpha=0.3", 3},
        {"ggx", "eta=0.2 k=3 alpha=0.6 energy=preserve", "eta=0.2 k=#%u alpha=0.6 energy=preserve",
         3},
        {"ggx", "f0=0.3 alpha=0.3", "f0=#%u alpha=0.3", 0.3},
        {"mirror", "eta=0.2 k=3", "eta=#%u k=3", 0.2},
        {"mirror", "eta=0.2 k=3", "eta=0.2 k=#%u", 3},
        {"burley", "color=0.3 roughness=0.8", "color=0.3 roughness=#%u", 0.8},
    };
    for (size_t i = 0; i < TEST_COUNT(CASES); ++i) {
        uint32_t texture = bench_texture(&bench, "vertex_color", "");
        char text[96];
        snprintf(text, sizeof text, CASES[i].textured, texture);
        uint32_t plain = bench_material(&bench, CASES[i].kind, CASES[i].constant);
        uint32_t textured = bench_material(&bench, CASES[i].kind, text);
        bench.surface.color = rgb_gray((float)CASES[i].value);
        ShadingPoint point = bench_point(&bench, direction(50, 20));
        for (int angle = 5; angle < 90; angle += 14) {
            Vec3 wi = direction(angle, 190);
            double expected = (double)material_eval(&point, plain, wi).value.r;
            double found = (double)material_eval(&point, textured, wi).value.r;
            if (!near_relative(found, expected, 1e-5)) {
                fail_msg("%s %s: %.9g, not %.9g", CASES[i].kind, text, found, expected);
            }
        }
        double expected = (double)material_albedo(&point, plain).r;
        assert_true(near_relative((double)material_albedo(&point, textured).r, expected, 1e-5));
    }
    bench.surface.color = rgb_gray(1);
}

static void finishes_refuse(void **state)
{
    (void)state;
    static const struct {
        const char *kind, *fields;
        DiagCode code;
    } BAD[] = {
        {"ggx", "alpha=0.2", E0950},
        {"ggx", "f0=0.5 ior=1.5", E0950},
        {"ggx", "eta=0.2", E0950},
        {"ggx", "k=0.2", E0950},
        {"ggx", "eta=0.2 k=3 ior=1.5", E0950},
        {"ggx", "f0=0.5 fresnel=exact", E0951},
        {"mirror", "eta=0.2", E0950},
        {"mirror", "color=0.5 eta=0.2 k=3", E0950},
    };
    for (size_t i = 0; i < TEST_COUNT(BAD); ++i) {
        assert_int_equal(bench_material(&bench, BAD[i].kind, BAD[i].fields), NONE_ID);
        assert_int_equal(bench.reports, 1);
        assert_int_equal(bench.reported, BAD[i].code);
    }
    // Only a note.
    assert_int_not_equal(bench_material(&bench, "phong", "color=1 specular=0.5"), NONE_ID);
    assert_int_equal(bench.reported, N0950);
    assert_int_not_equal(bench_material(&bench, "phong", "color=1 diffuse=0.5 specular=0.5"),
                         NONE_ID);
    assert_int_equal(bench.reports, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(expressions, setup, teardown),
        cmocka_unit_test_setup_teardown(local_expressions, setup, teardown),
        cmocka_unit_test_setup_teardown(burley_albedo, setup, teardown),
        cmocka_unit_test_setup_teardown(phong_albedos, setup, teardown),
        cmocka_unit_test_setup_teardown(ggx_albedos, setup, teardown),
        cmocka_unit_test_setup_teardown(white_furnace, setup, teardown),
        cmocka_unit_test_setup_teardown(mirrors, setup, teardown),
        cmocka_unit_test_setup_teardown(lobes_are_consistent, setup, teardown),
        cmocka_unit_test_setup_teardown(mix_weights, setup, teardown),
        cmocka_unit_test_setup_teardown(base_color_leaves_highlights_white, setup, teardown),
        cmocka_unit_test_setup_teardown(textures_stand_for_constants, setup, teardown),
        cmocka_unit_test_setup_teardown(finishes_refuse, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
