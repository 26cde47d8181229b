// Estimates of radiance with their standard errors, and the table in which a family of them is
// judged.
//
// An estimate is the mean of REPLICATES independent runs of an integrator (each with its own seed
// of the sampler), whose scatter gives the standard error; deviations are then Student's t with
// REPLICATES - 1 degrees of freedom. A family of K checks fails with a chance of ALPHA if nothing
// is wrong: each at Šidák's level. "bias found" is the smallest relative bias that a check would
// have found in 99 of 100 runs.
#ifndef TEST_ESTIMATE_H
#define TEST_ESTIMATE_H

#include "base/thread.h"
#include "render/integrator.h"
#include "scene_maker.h"
#include "statistics.h"

#include <time.h>

extern const IntegratorClass path_integrator;

enum { REPLICATES = 32, MAX_CHECKS = 128 };
static const double ALPHA = 1e-3;

// Chooses a ray from four numbers in [0, 1) and returns the weight of its radiance.
typedef double RayMaker(const void *context, const float numbers[4], Ray *ray);

typedef struct Estimate {
    const World *world;
    const IntegratorClass *integrator;
    RayMaker *ray;
    const void *context;
    uint32_t samples, seed;
    double means[REPLICATES];
    uint64_t rays[REPLICATES], bad[REPLICATES];
} Estimate;

static inline void estimate_replicate(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    Estimate *e = context;
    IntegratorStats stats = {0};
    double sum = 0;
    for (uint32_t i = 0; i < e->samples; ++i) {
        Sampler sampler;
        float numbers[4];
        sampler_start(&sampler, e->seed, (uint32_t)item, 0, i);
        sampler_2d(&sampler, &numbers[0], &numbers[1]);
        sampler_2d(&sampler, &numbers[2], &numbers[3]);
        Ray ray = {.tmax = INFINITY};
        double weight = e->ray(e->context, numbers, &ray);
        sum += weight * (double)e->integrator->radiance(e->world, &ray, &sampler, NULL, &stats).g;
    }
    e->means[item] = sum / e->samples;
    e->rays[item] = stats.rays + stats.shadow_rays;
    e->bad[item] = stats.bad_samples;
}

// The mean of the green radiance along the chosen rays. `samples` is per replicate, a power of two.
static inline Running estimate_by(const IntegratorClass *integrator, const World *world,
                                  RayMaker *ray, const void *context, uint32_t samples,
                                  uint32_t seed)
{
    Estimate e = {.world = world,
                  .integrator = integrator,
                  .ray = ray,
                  .context = context,
                  .samples = samples,
                  .seed = seed};
    parallel_for(REPLICATES, 0, estimate_replicate, &e, NULL);
    Running mean = {0};
    for (int i = 0; i < REPLICATES; ++i) {
        running_add(&mean, e.means[i]);
        if (e.bad[i]) {
            fprintf(stderr, "%llu samples were not finite\n", (unsigned long long)e.bad[i]);
            abort();
        }
    }
    return mean;
}

// By the path tracer.
static inline Running estimate(const World *world, RayMaker *ray, const void *context,
                               uint32_t samples, uint32_t seed)
{
    return estimate_by(&path_integrator, world, ray, context, samples, seed);
}

typedef struct Check {
    char name[64];
    double expected, mean, error, freedom;
    double wanted;  // largest relative bias that may go unfound
    double seconds; // of CPU time since the check before
} Check;

typedef struct CheckTable {
    Check checks[MAX_CHECKS];
    int count;
    clock_t last;
} CheckTable;

static inline void check_add(CheckTable *table, Check check)
{
    if (table->count == MAX_CHECKS) {
        abort();
    }
    clock_t now = clock();
    check.seconds = (double)(now - table->last) / CLOCKS_PER_SEC;
    table->last = now;
    table->checks[table->count++] = check;
}

static inline void check_mean(CheckTable *table, const char *name, double expected, Running mean,
                              double wanted)
{
    Check check = {"", expected, mean.mean, running_error(&mean), REPLICATES - 1, wanted, 0};
    snprintf(check.name, sizeof check.name, "%s", name);
    check_add(table, check);
}

// Two estimates of one unknown mean: their difference, of which the worse one's degrees of freedom
// are taken (on the safe side of Welch's).
static inline void check_equal(CheckTable *table, const char *name, Running a, Running b,
                               double wanted)
{
    double error = hypot(running_error(&a), running_error(&b));
    Check check = {"", a.mean, b.mean, error, REPLICATES - 1, wanted, 0};
    snprintf(check.name, sizeof check.name, "%s", name);
    check_add(table, check);
}

// Prints the table; the number of checks that failed, or that couldn't have found what they should.
static inline int check_judge(const CheckTable *table)
{
    double level = sidak(ALPHA, table->count);
    int failures = 0;
    printf("%d checks, family-wise alpha %g\n", table->count, ALPHA);
    printf("%-44s %13s %13s %10s %7s %11s %6s\n", "check", "expected", "mean", "std.error", "z",
           "bias found", "cpu s");
    for (int i = 0; i < table->count; ++i) {
        const Check *c = &table->checks[i];
        double critical = student_quantile(level, c->freedom);
        double power = student_quantile(0.02, c->freedom); // one-sided 1 %
        // Results are sums of floats: a millionth is never significant.
        double error = fmax(c->error, 1e-7 * fabs(c->expected));
        double z = (c->mean - c->expected) / error;
        double found = (critical + power) * error / fabs(c->expected);
        bool wrong = !(fabs(z) <= critical), weak = !(found <= c->wanted);
        failures += wrong || weak;
        printf("%-44s %13.9g %13.9g %10.2g %7.2f %10.4f%% %6.2f%s%s\n", c->name, c->expected,
               c->mean, c->error, z, 100 * found, c->seconds, wrong ? "  WRONG" : "",
               weak ? "  TOO WEAK" : "");
    }
    return failures;
}

#endif
