// Checks that hold any material's sample, eval and pdf to each other.
#ifndef TEST_BSDF_CHECK_H
#define TEST_BSDF_CHECK_H

#include "render/world.h"
#include "statistics.h"

#include <stdlib.h>

enum { BSDF_ROWS = 80, BSDF_COLUMNS = 160, BSDF_CELLS = BSDF_ROWS * BSDF_COLUMNS };

// A flat piece of surface at the origin whose frame is the world's, seen from wo.
typedef struct FlatPoint {
    Surface surface;
    ShadingPoint point;
} FlatPoint;

static inline void flat_point(const World *world, uint32_t material, Vec3 wo, FlatPoint *out)
{
    out->surface = (Surface){.geometric = {0, 0, 1},
                             .shading = {0, 0, 1},
                             .tangent = {1, 0, 0},
                             .uv = {0.3, 0.6},
                             .color = {1, 1, 1},
                             .shape = 0,
                             .instance = NONE_ID,
                             .material = material,
                             .front = wo.z > 0};
    shading_point(world, &out->surface, neg(wo), &out->point);
}

static inline Vec3 spherical(double cos_theta, double phi)
{
    double s = sqrt(fmax(0, 1 - cos_theta * cos_theta));
    return vec3(s * cos(phi), s * sin(phi), cos_theta);
}

// The pdf's integral over a cell of equal θ and φ, by the midpoint rule on `steps`² parts.
static inline double bsdf_cell_mass(const ShadingPoint *point, uint32_t material, int row,
                                    int column, int steps)
{
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        double theta = PI * (row + (i + 0.5) / steps) / BSDF_ROWS;
        for (int j = 0; j < steps; ++j) {
            double phi = 2 * PI * (column + (j + 0.5) / steps) / BSDF_COLUMNS;
            sum +=
                sin(theta) * (double)material_eval(point, material, spherical(cos(theta), phi)).pdf;
        }
    }
    return sum * (PI / BSDF_ROWS) * (2 * PI / BSDF_COLUMNS) / (steps * steps);
}

// Chi-squared of `samples` sampled directions against the pdf, on 80 × 160 cells of θ and φ, with
// one more for "nothing is scattered" (delta lobes count there). The p-value.
static inline double bsdf_chi_squared(const World *world, uint32_t material, Vec3 wo, int samples,
                                      int steps, uint64_t seed)
{
    double *observed = calloc(BSDF_CELLS + 1, sizeof *observed);
    double *expected = calloc(BSDF_CELLS + 1, sizeof *expected);
    FlatPoint flat;
    flat_point(world, material, wo, &flat);
    TestRandom random = {seed};
    for (int i = 0; i < samples; ++i) {
        BsdfSample s;
        float lobe = test_random(&random), u = test_random(&random), v = test_random(&random);
        int cell = BSDF_CELLS;
        if (material_sample(&flat.point, material, lobe, u, v, &s) && !(s.lobes & LOBE_DELTA)) {
            double phi = atan2(s.wi.y, s.wi.x);
            int row = (int)(acos(fmin(fmax(s.wi.z, -1), 1)) / PI * BSDF_ROWS);
            int column = (int)((phi < 0 ? phi + 2 * PI : phi) / (2 * PI) * BSDF_COLUMNS);
            row = row < BSDF_ROWS ? row : BSDF_ROWS - 1;
            column = column < BSDF_COLUMNS ? column : BSDF_COLUMNS - 1;
            cell = row * BSDF_COLUMNS + column;
        }
        observed[cell] += 1;
    }
    double rest = samples;
    for (int i = 0; i < BSDF_CELLS; ++i) {
        expected[i] = samples * bsdf_cell_mass(&flat.point, material, i / BSDF_COLUMNS,
                                               i % BSDF_COLUMNS, steps);
        rest -= expected[i];
    }
    expected[BSDF_CELLS] = fmax(rest, 1e-9);
    double p = chi_squared_test(observed, expected, BSDF_CELLS + 1);
    free(observed);
    free(expected);
    return p;
}

// The largest relative difference between a sample's weight and pdf and what eval says of its
// direction; delta lobes are passed over.
static inline double bsdf_sample_mismatch(const World *world, uint32_t material, Vec3 wo,
                                          int samples, uint64_t seed)
{
    FlatPoint flat;
    flat_point(world, material, wo, &flat);
    TestRandom random = {seed};
    double worst = 0;
    for (int i = 0; i < samples; ++i) {
        BsdfSample s;
        float lobe = test_random(&random), u = test_random(&random), v = test_random(&random);
        if (!material_sample(&flat.point, material, lobe, u, v, &s) || (s.lobes & LOBE_DELTA)) {
            continue;
        }
        BsdfEval e = material_eval(&flat.point, material, s.wi);
        double pdf = (double)s.pdf, value = (double)(s.weight.g * s.pdf);
        worst = fmax(worst, fabs((double)e.pdf - pdf) / pdf);
        worst = fmax(worst, fabs((double)e.value.g - value) / fmax(value, 1e-6 * pdf));
    }
    return worst;
}

// The largest relative difference of f(wo, wi) and f(wi, wo), for pairs on the same side.
static inline double bsdf_asymmetry(const World *world, uint32_t material, int pairs, uint64_t seed)
{
    TestRandom random = {seed};
    double worst = 0;
    for (int i = 0; i < pairs; ++i) {
        Vec3 a = spherical(0.02 + 0.98 * (double)test_random(&random),
                           2 * PI * (double)test_random(&random));
        Vec3 b = spherical(0.02 + 0.98 * (double)test_random(&random),
                           2 * PI * (double)test_random(&random));
        FlatPoint from_a, from_b;
        flat_point(world, material, a, &from_a);
        flat_point(world, material, b, &from_b);
        double ab = (double)material_eval(&from_a.point, material, b).value.g / b.z;
        double ba = (double)material_eval(&from_b.point, material, a).value.g / a.z;
        worst = fmax(worst, fabs(ab - ba) / fmax(fmax(ab, ba), 1e-12));
    }
    return worst;
}

// The mean weight of samples: the part of light from all around that is scattered, delta lobes
// included; with its standard error.
static inline Running bsdf_albedo(const World *world, uint32_t material, Vec3 wo, int samples,
                                  uint64_t seed)
{
    FlatPoint flat;
    flat_point(world, material, wo, &flat);
    TestRandom random = {seed};
    Running mean = {0};
    for (int i = 0; i < samples; ++i) {
        BsdfSample s;
        float lobe = test_random(&random), u = test_random(&random), v = test_random(&random);
        bool found = material_sample(&flat.point, material, lobe, u, v, &s);
        running_add(&mean, found ? (double)s.weight.g : 0);
    }
    return mean;
}

#endif
