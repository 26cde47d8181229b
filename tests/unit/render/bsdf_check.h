// A bench for materials: a world of materials alone, without shapes or accelerator, and the
// statistical tests that hold sample, eval and pdf to each other.
#ifndef BSDF_CHECK_H
#define BSDF_CHECK_H

#include "../../trust.h"
#include "../test_support.h"
#include "base/hash.h"
#include "base/statistics.h"
#include "render/render.h"
#include "render/world.h"
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

enum { BENCH_MATERIALS = 64 };

typedef struct Bench {
    Scene scene; // of nodes of textures; and what finishes are given
    Arena arena;
    DiagSink sink;
    World world;
    WorldMaterial materials[BENCH_MATERIALS + 1];
    Surface surface;
    DiagCode reported; // by the last bench_material
    int reports;
} Bench;

// --- Making materials -------------------------------------------------------------------------

static inline void bench_init(Bench *bench)
{
    *bench = (Bench){0};
    assert_true(scene_init(&bench->scene, render_schema(), NULL));
    diag_sink_init(&bench->sink, &bench->arena);
    bench->world.scene = &bench->scene;
    bench->world.materials = bench->materials;
    bench->surface = (Surface){.geometric = {0, 0, 1},
                               .shading = {0, 0, 1},
                               .tangent = {1, 0, 0},
                               .bitangent = {0, 1, 0},
                               .color = {1, 1, 1},
                               .front = true};
}

static inline void bench_free(Bench *bench)
{
    texture_set_free(bench->world.textures);
    scene_free(&bench->scene);
    diag_sink_free(&bench->sink);
    arena_free(&bench->arena);
}

static inline Diag *bench_report(NodeFinish *self, int param, DiagCode code, const char *format,
                                 ...)
{
    static Diag diag;
    (void)param, (void)format;
    Bench *bench = self->caller;
    bench->reported = code;
    ++bench->reports;
    return &diag;
}

// Sets a field from a text as in a scene, of numbers, colors, choices, and "#3" for node 3.
static inline void bench_set(const Param *param, void *params, const char *text)
{
    char *at = (char *)params + param->offset;
    uint32_t node = NONE_ID;
    if (*text == '#') {
        node = (uint32_t)strtoul(text + 1, NULL, 10);
    }
    double n[3] = {0, 0, 0};
    int count = 0;
    bool gray = strncmp(text, "gray", 4) == 0;
    for (const char *p = text + strcspn(text, "-.0123456789"); count < 3 && *p && *p != '"';) {
        char *end;
        n[count++] = strtod(p, &end) * (strncmp(end, "deg", 3) == 0 ? PI / 180 : 1);
        p = end + strcspn(end, "-.0123456789");
    }
    if (count == 1 || gray) {
        n[1] = n[2] = n[0];
    }
    Rgb color = node == NONE_ID ? rgb((float)n[0], (float)n[1], (float)n[2]) : rgb_gray(1);
    double number = node == NONE_ID ? n[0] : 1;
    Vec2 pair = node == NONE_ID ? (Vec2){n[0], n[1]} : (Vec2){1, 1};
    switch (param->type) {
    case PARAM_NUMBER:
        *(double *)(void *)at = n[0];
        break;
    case PARAM_PAIR:
    case PARAM_VEC2:
        *(Vec2 *)(void *)at = pair;
        break;
    case PARAM_INT:
        *(int64_t *)(void *)at = (int64_t)n[0];
        break;
    case PARAM_COLOR:
        *(Rgb *)(void *)at = color;
        break;
    case PARAM_NUMBER_TEX:
        *(NumberTex *)(void *)at = (NumberTex){number, node};
        break;
    case PARAM_PAIR_TEX:
        *(PairTex *)(void *)at = (PairTex){pair, node};
        break;
    case PARAM_COLOR_TEX:
        *(ColorTex *)(void *)at = (ColorTex){color, node};
        break;
    case PARAM_EMISSION:
        *(Emission *)(void *)at = (Emission){color, DIM_NONE, node, count == 1};
        break;
    case PARAM_FILE:
        *(const char **)(void *)at = text;
        break;
    case PARAM_NODE:
        *(uint32_t *)(void *)at = node;
        break;
    case PARAM_CHOICE:
        for (int32_t i = 0; param->choices[i]; ++i) {
            if (strstr(text, param->choices[i])) {
                *(int32_t *)(void *)at = i;
            }
        }
        break;
    default:
        fail_msg("field `%s` has a type that the bench doesn't know", param->name);
    }
}

// The parameters of a kind from fields like "ior=1.5 alpha=0.1,0.4 base=#2", defaults and finish
// included; NULL where finish refused.
static inline void *bench_params(Bench *bench, const char *kind, const char *fields, int *type_out)
{
    int index = schema_find(render_schema(), str_from(kind));
    assert_true(index >= 0);
    const NodeType *type = render_schema()->types[index];
    void *params = arena_alloc_zeroed(&bench->arena, type->size + 1);
    uint64_t set = 0;
    for (size_t i = 0; i < type->param_count; ++i) {
        const Param *param = &type->params[i];
        if (param->default_text) {
            bench_set(param, params, param->default_text);
        }
        for (const char *at = fields; (at = strstr(at, param->name)); ++at) {
            size_t length = strlen(param->name);
            if ((at == fields || at[-1] == ' ') && at[length] == '=') {
                const char *from = at + length + 1;
                char *text = arena_copy_string(&bench->arena, from, strcspn(from, " "));
                bench_set(param, params, text);
                set |= (uint64_t)1 << i;
            }
        }
    }
    *type_out = index;
    bench->reports = 0;
    NodeFinish finish = {.type = type,
                         .params = params,
                         .set = set,
                         .scene = &bench->scene,
                         .report = bench_report,
                         .sink = &bench->sink,
                         .caller = bench};
    return !type->finish || type->finish(&finish) ? params : NULL;
}

// A new material, its id; NONE_ID where its finish refused it.
static inline uint32_t bench_material(Bench *bench, const char *kind, const char *fields)
{
    int type;
    void *params = bench_params(bench, kind, fields, &type);
    if (!params) {
        return NONE_ID;
    }
    const MaterialClass *class = (const MaterialClass *)(const void *)render_schema()->types[type];
    uint32_t id = bench->world.material_count++;
    assert_true(id < BENCH_MATERIALS);
    assert_int_equal(
        scene_add_node(&bench->scene, (uint16_t)type, params, (SceneNode){.material = NONE_ID}),
        id);
    bench->materials[id] = (WorldMaterial){.class = class, .params = params};
    bench->materials[id].lobes = class->lobes(&bench->world, params);
    bench->world.all_lobes |= bench->materials[id].lobes;
    return id;
}

// A new texture, its id.
static inline uint32_t bench_texture(Bench *bench, const char *kind, const char *fields)
{
    int type;
    void *params = bench_params(bench, kind, fields, &type);
    assert_non_null(params);
    uint32_t id = scene_add_node(&bench->scene, (uint16_t)type, params, (SceneNode){0});
    texture_set_free(bench->world.textures);
    bench->world.textures = texture_set_build(&bench->scene, &bench->sink);
    assert_non_null(bench->world.textures);
    return id;
}

// The bench's surface seen from wo (in the frame of its normal).
static inline ShadingPoint bench_point(Bench *bench, Vec3 wo)
{
    bench->surface.front = wo.z > 0;
    return (ShadingPoint){.world = &bench->world,
                          .surface = &bench->surface,
                          .frame = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                          .geometric = {0, 0, 1},
                          .wo = wo,
                          .wo_side = wo.z};
}

static inline Vec3 direction(double theta_degrees, double phi_degrees)
{
    double t = theta_degrees * PI / 180, p = phi_degrees * PI / 180;
    return vec3(sin(t) * cos(p), sin(t) * sin(p), cos(t));
}

// --- Numbers ------------------------------------------------------------------------------------

typedef struct Random {
    uint64_t state;
} Random;
static inline float random_next(Random *r)
{
    return (float)(hash_u64(r->state++) >> 40) * 0x1p-24f;
}
// Uniform over the sphere.
static inline Vec3 random_direction(Random *r)
{
    double z = 2 * (double)random_next(r) - 1, phi = 2 * PI * (double)random_next(r);
    double s = sqrt(1 - z * z);
    return vec3(s * cos(phi), s * sin(phi), z);
}
static inline Vec3 random_hemisphere(Random *r)
{
    Vec3 w = random_direction(r);
    w.z = fmax(fabs(w.z), 1e-4);
    return normalize(w);
}

static inline double relative_difference(double a, double b)
{
    return a == b ? 0 : fabs(a - b) / fmax(fabs(a), fabs(b));
}
static inline bool near_relative(double a, double b, double tolerance)
{
    return fabs(a - b) <= tolerance * fmax(fabs(a), fabs(b));
}

#define assert_near(a, b, tolerance)                                                               \
    do {                                                                                           \
        double near_a = (a), near_b = (b);                                                         \
        if (!(fabs(near_a - near_b) <= (tolerance))) {                                             \
            fail_msg("%s = %.9g, not %.9g", #a, near_a, near_b);                                   \
        }                                                                                          \
    } while (0)

// A function of the direction.
typedef double (*Spherical)(const void *context, Vec3 w);

static inline double gauss_box(Spherical f, const void *context, double z0, double z1, double p0,
                               double p1)
{
    static const double X[2] = {0.2113248654051871, 0.7886751345948129};
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
        double z = z0 + (z1 - z0) * X[i / 2], p = p0 + (p1 - p0) * X[i % 2];
        double s = sqrt(fmax(0, 1 - z * z));
        sum += f(context, vec3(s * cos(p), s * sin(p), z));
    }
    return 0.25 * sum * (z1 - z0) * (p1 - p0);
}

// Its integral over a box in (cos θ, φ), estimated as `whole`: split into four until that changes
// it by no more than `tolerance` (some fifteen times the error that is left).
static inline double integrate_parts(Spherical f, const void *context, double z0, double z1,
                                     double p0, double p1, double tolerance, int depth,
                                     double whole)
{
    double z[3] = {z0, 0.5 * (z0 + z1), z1}, p[3] = {p0, 0.5 * (p0 + p1), p1}, part[4], sum = 0;
    for (int i = 0; i < 4; ++i) {
        part[i] = gauss_box(f, context, z[i / 2], z[i / 2 + 1], p[i % 2], p[i % 2 + 1]);
        sum += part[i];
    }
    if (depth == 0 || fabs(sum - whole) <= tolerance) {
        return sum;
    }
    sum = 0;
    for (int i = 0; i < 4; ++i) {
        sum += integrate_parts(f, context, z[i / 2], z[i / 2 + 1], p[i % 2], p[i % 2 + 1],
                               tolerance, depth - 1, part[i]);
    }
    return sum;
}

static inline double integrate_box(Spherical f, const void *context, double z0, double z1,
                                   double p0, double p1, double tolerance, int depth)
{
    return integrate_parts(f, context, z0, z1, p0, p1, tolerance, depth,
                           gauss_box(f, context, z0, z1, p0, p1));
}

// --- Chi-squared: does sample follow pdf? --------------------------------------------------------

enum { CHI2_Z = 80, CHI2_PHI = 160, CHI2_CELLS = CHI2_Z * CHI2_PHI };

typedef struct PdfContext {
    ShadingPoint point;
    uint32_t material;
} PdfContext;

static inline double pdf_at(const void *context, Vec3 w)
{
    const PdfContext *c = context;
    return (double)material_eval(&c->point, c->material, w).pdf;
}

// What sample does beside smooth directions: delta reflection, delta transmission, nothing.
enum { CELL_DELTA_REFLECT = CHI2_CELLS, CELL_DELTA_TRANSMIT, CELL_NOTHING, CELL_COUNT };

typedef struct Chi2 {
    double observed[CELL_COUNT], expected[CELL_COUNT];
} Chi2;

static inline int compare_cells(const void *a, const void *b)
{
    const double *x = *(const double *const *)a, *y = *(const double *const *)b;
    return (*x > *y) - (*x < *y);
}

// The p value, cells pooled where fewer than 5 are expected.
static inline double chi2_p_value(const Chi2 *chi2, int *freedom)
{
    static const double *cells[CELL_COUNT];
    for (int i = 0; i < CELL_COUNT; ++i) {
        cells[i] = &chi2->expected[i];
    }
    qsort(cells, CELL_COUNT, sizeof *cells, compare_cells);
    double sum = 0, pooled_expected = 0, pooled_observed = 0;
    int degrees = -1;
    *freedom = 0;
    for (int i = 0; i < CELL_COUNT; ++i) {
        double e = *cells[i], o = chi2->observed[cells[i] - chi2->expected];
        if (e < 5 || (pooled_expected > 0 && pooled_expected < 5)) {
            pooled_expected += e, pooled_observed += o;
        } else {
            sum += (o - e) * (o - e) / e;
            ++degrees;
        }
    }
    if (pooled_expected >= 5) {
        sum += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) /
               pooled_expected;
        ++degrees;
    } else if (pooled_observed > pooled_expected + 5 * sqrt(pooled_expected) + 5) {
        *freedom = degrees;
        return 0; // samples where the density is zero
    }
    *freedom = degrees;
    return degrees > 0 ? gamma_q(0.5 * degrees, 0.5 * sum) : 1;
}

static inline double chi2_test(Bench *bench, uint32_t material, Vec3 wo, int samples, uint64_t seed,
                               int *freedom)
{
    static Chi2 chi2;
    memset(&chi2, 0, sizeof chi2);
    PdfContext context = {bench_point(bench, wo), material};
    double z_step = 2.0 / CHI2_Z, phi_step = 2 * PI / CHI2_PHI, total = 0;
    for (int i = 0; i < CHI2_CELLS; ++i) {
        double z = -1 + i / CHI2_PHI * z_step, phi = i % CHI2_PHI * phi_step;
        chi2.expected[i] =
            samples * integrate_box(pdf_at, &context, z, z + z_step, phi, phi + phi_step, 2e-8, 7);
        total += chi2.expected[i];
    }
    Random random = {seed << 32};
    for (int i = 0; i < samples; ++i) {
        float lobe = random_next(&random), u = random_next(&random), v = random_next(&random);
        BsdfSample s;
        if (!material_sample(&context.point, material, lobe, u, v, &s)) {
            ++chi2.observed[CELL_NOTHING];
        } else if (s.lobes & LOBE_DELTA) {
            int cell = s.wi.z * wo.z > 0 ? CELL_DELTA_REFLECT : CELL_DELTA_TRANSMIT;
            ++chi2.observed[cell];
            chi2.expected[cell] = samples * (double)s.pdf;
        } else {
            double phi = atan2(s.wi.y, s.wi.x);
            int zi = (int)fmin((s.wi.z + 1) / z_step, CHI2_Z - 1);
            int pi = (int)fmin((phi < 0 ? phi + 2 * PI : phi) / phi_step, CHI2_PHI - 1);
            ++chi2.observed[zi * CHI2_PHI + pi];
        }
    }
    total += chi2.expected[CELL_DELTA_REFLECT] + chi2.expected[CELL_DELTA_TRANSMIT];
    if (total > samples * (1 + 1e-3)) {
        fail_msg("the density integrates to %.6f", total / samples);
    }
    chi2.expected[CELL_NOTHING] = fmax(0, samples - total);
    return chi2_p_value(&chi2, freedom);
}

// At five angles, from behind at one; `family` is the number of such calls in a test program:
// together they fail by chance once in 100.
static inline void check_chi2(Bench *bench, const char *what, uint32_t material, int samples,
                              bool from_back, int family)
{
    static const double ANGLES[5][2] = {{0, 0}, {25, 40}, {50, -100}, {70, 160}, {85, 10}};
    double level = 1 - pow(1 - 0.01, 1.0 / (5 * family));
    for (uint64_t i = from_back ? 2 : 0; i < (from_back ? 3 : 5); ++i) {
        Vec3 wo = direction(ANGLES[i][0], ANGLES[i][1]);
        wo.z = from_back ? -wo.z : wo.z;
        int freedom;
        double p = chi2_test(bench, material, wo, samples, i + 1, &freedom);
        char name[64];
        snprintf(name, sizeof name, "17 %s, %g degrees", what,
                 from_back ? 180 - ANGLES[i][0] : ANGLES[i][0]);
        if (freedom > 0) { // something has a density
            trust_chi2(name, p, samples, freedom);
        }
        if (p < level) {
            fail_msg("%s at %g degrees%s: p = %.3g", what, ANGLES[i][0],
                     from_back ? " from behind" : "", p);
        }
    }
}

// --- Other properties ----------------------------------------------------------------------------

// The weight and pdf of samples are those of eval; values are finite and not negative.
static inline void check_weights(Bench *bench, const char *what, uint32_t material, int samples)
{
    Random random = {1};
    double worst = 0;
    for (int i = 0; i < samples; ++i) {
        Vec3 wo = random_direction(&random);
        float lobe = random_next(&random), u = random_next(&random), v = random_next(&random);
        ShadingPoint point = bench_point(bench, wo);
        BsdfSample s;
        if (!material_sample(&point, material, lobe, u, v, &s)) {
            continue;
        }
        if (!rgb_is_finite(s.weight) || s.weight.r < 0 || !(s.pdf > 0) ||
            fabs(length(s.wi) - 1) > 1e-9) {
            fail_msg("%s: bad sample of weight %g, pdf %g, length %.12g", what, (double)s.weight.r,
                     (double)s.pdf, length(s.wi));
        }
        if (s.lobes & LOBE_DELTA) {
            continue;
        }
        BsdfEval e = material_eval(&point, material, s.wi);
        const double off =
            fmax(relative_difference((double)e.pdf, (double)s.pdf),
                 relative_difference((double)(e.value.g / e.pdf), (double)s.weight.g));
        if (!(off <= 1e-3)) {
            fail_msg("%s: pdf %g and weight %g, but eval says %g and %g", what, (double)s.pdf,
                     (double)s.weight.g, (double)e.pdf, (double)(e.value.g / e.pdf));
        }
        worst = fmax(worst, off);
    }
    char name[64];
    snprintf(name, sizeof name, "18 %s, sample against eval, relative", what);
    assert_true(trust_at_most(name, 1e-3, worst));
}

// f(wo, wi) eta_wi² = f(wi, wo) eta_wo², to relative 1e-5, where eta belongs to the side.
static inline void check_reciprocity(Bench *bench, const char *what, uint32_t material, int pairs,
                                     double eta_front, double eta_back)
{
    Random random = {7};
    bool transmits = material_lobes(&bench->world, material) & LOBE_TRANSMIT;
    int found = 0;
    double worst = 0;
    for (int i = 0; i < pairs; ++i) {
        Vec3 wo = random_direction(&random), wi = random_direction(&random);
        if (!transmits && wo.z * wi.z < 0) {
            wi.z = -wi.z;
        }
        if (fabs(wo.z) < 1e-3 || fabs(wi.z) < 1e-3) {
            continue;
        }
        ShadingPoint a = bench_point(bench, wo);
        double there = (double)material_eval(&a, material, wi).value.g / fabs(wi.z);
        ShadingPoint b = bench_point(bench, wi);
        double back = (double)material_eval(&b, material, wo).value.g / fabs(wo.z);
        double eta_i = wi.z > 0 ? eta_front : eta_back, eta_o = wo.z > 0 ? eta_front : eta_back;
        found += there > 0;
        const double off = fabs(there - back) > 1e-12
                               ? relative_difference(there * eta_i * eta_i, back * eta_o * eta_o)
                               : 0;
        if (!(off <= 1e-5)) {
            fail_msg("%s: f = %.9g there and %.9g back, wo.z %g, wi.z %g", what, there, back, wo.z,
                     wi.z);
        }
        worst = fmax(worst, off);
    }
    char name[64];
    snprintf(name, sizeof name, "18 %s, reciprocity, relative", what);
    assert_true(trust_at_most(name, 1e-5, worst));
    assert_true(found > pairs / 100);
}

// The part of light from all around that goes to wo, in each channel: the mean of the weights. A
// weight counts eta² times where light is squeezed, so that glass gives back 1.
static inline Rgb albedo_by_sampling(Bench *bench, uint32_t material, Vec3 wo, int samples,
                                     double *error)
{
    ShadingPoint point = bench_point(bench, wo);
    double sum[3] = {0}, squares = 0;
    for (int i = 0; i < samples; ++i) {
        // A Kronecker sequence (Roberts 2018: R3).
        float n[3];
        static const double STEP[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
        for (int k = 0; k < 3; ++k) {
            double x = 0.5 + (i + 1) * STEP[k];
            n[k] = fminf((float)(x - floor(x)), 0x1.fffffep-1f);
        }
        BsdfSample s;
        if (material_sample(&point, material, n[0], n[1], n[2], &s)) {
            double e2 = (double)(s.eta * s.eta);
            sum[0] += (double)s.weight.r * e2;
            sum[1] += (double)s.weight.g * e2;
            sum[2] += (double)s.weight.b * e2;
            squares += (double)s.weight.g * e2 * (double)s.weight.g * e2;
        }
    }
    double mean = sum[1] / samples;
    if (error) {
        *error = sqrt(fmax(0, squares / samples - mean * mean) / samples);
    }
    return rgb((float)(sum[0] / samples), (float)(sum[1] / samples), (float)(sum[2] / samples));
}

// No angle gives back more than arrives, nor less than `least`.
static inline void check_energy(Bench *bench, const char *what, uint32_t material, double least,
                                int samples)
{
    double most = -INFINITY;
    for (double theta = 0; theta < 90; theta += 5.97) {
        for (int back = 0; back < 2; ++back) {
            Vec3 wo = direction(theta, 30);
            wo.z = back ? -wo.z : wo.z;
            double error;
            Rgb albedo = albedo_by_sampling(bench, material, wo, samples, &error);
            if ((double)rgb_max(albedo) > 1 + 3 * error + 1e-4 ||
                (double)albedo.g < least - 3 * error) {
                fail_msg("%s at %g degrees: albedo %g +- %g", what, theta, (double)albedo.g, error);
            }
            most = fmax(most, (double)rgb_max(albedo) - 3 * error);
        }
    }
    char name[64];
    snprintf(name, sizeof name, "19 %s, albedo less 3 errors, the most", what);
    assert_true(trust_at_most(name, 1 + 1e-4, most));
}

#endif
