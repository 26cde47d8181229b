// Estimates of radiance with their standard errors, and the table in which a family of them is
// judged.
//
// An estimate is the mean of REPLICATES independent runs of an integrator (each with its own seed
// of the sampler), whose scatter gives the standard error; deviations are then Student's t with
// REPLICATES - 1 degrees of freedom. A family of K checks fails with a chance of ALPHA if nothing
// is wrong: each at Šidák's level. "bias found" is the smallest relative bias that a check would
// have found in 99 of 100 runs.
//
// In an ordinary run each estimate has a fixed number of samples, and each check says which bias
// may go unfound. A full run (SCN_TRUST=full, as by tools/trust) takes as many samples as it takes
// to find a bias of 0.1 % (full_bias): numbers grow until a trial is good enough, and then another
// run with its own seeds counts, so that what decides on the number is not what is averaged.
#ifndef TEST_ESTIMATE_H
#define TEST_ESTIMATE_H

#include "../trust.h"
#include "base/thread.h"
#include "render/integrator.h"
#include "scene_maker.h"
#include "statistics.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

extern const IntegratorClass path_integrator;

enum { REPLICATES = 32, MAX_CHECKS = 2048 };
static const double ALPHA = 1e-3;
// The bias that checks find in a full run; a test may say another for some of its own.
static double full_bias = 1e-3;

// How many standard errors make the smallest bias that one of `checks` checks finds in 99 of 100
// runs: those to be significant, and those that chance may take away.
static inline double errors_found(double checks, double freedom)
{
    return student_quantile(sidak(ALPHA, checks), freedom) + student_quantile(0.02, freedom);
}

// Chooses a ray from four numbers in [0, 1) and returns the weight of its radiance.
typedef double RayMaker(const void *context, const float numbers[4], Ray *ray);

typedef struct Estimate {
    const World *world;
    const IntegratorClass *integrator;
    RayMaker *ray;
    const void *context;
    uint32_t samples, seed;
    bool fixed; // each replicate has one ray, the same for all seeds
    double means[REPLICATES];
    uint64_t rays[REPLICATES], bad[REPLICATES];
} Estimate;

// Numbers of a replicate's one ray, evenly spread over the replicates (Roberts 2018: R4).
static inline void estimate_place(uint64_t item, float numbers[4])
{
    double power = 1; // of the root of x^5 = x + 1
    for (int i = 0; i < 4; ++i) {
        power /= 1.16730397826141868;
        numbers[i] = (float)fmod(0.5 + (double)(item + 1) * power, 1);
    }
}

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
        if (e->fixed) {
            estimate_place(item, numbers);
        } else {
            sampler_2d(&sampler, &numbers[0], &numbers[1]);
            sampler_2d(&sampler, &numbers[2], &numbers[3]);
        }
        Ray ray = {.tmax = INFINITY};
        double weight = e->ray(e->context, numbers, &ray);
        sum += weight * (double)e->integrator->radiance(e->world, &ray, &sampler, NULL, &stats).g;
    }
    e->means[item] = sum / e->samples;
    e->rays[item] = stats.rays + stats.shadow_rays;
    e->bad[item] = stats.bad_samples;
}

static inline Running estimate_once(Estimate *e)
{
    parallel_for(REPLICATES, 0, estimate_replicate, e, NULL);
    Running mean = {0};
    for (int i = 0; i < REPLICATES; ++i) {
        running_add(&mean, e->means[i]);
        if (e->bad[i]) {
            fprintf(stderr, "%llu samples were not finite\n", (unsigned long long)e->bad[i]);
            abort();
        }
    }
    return mean;
}

// In a full run: estimates are compared with one another, which both have errors, or (false) with
// numbers that have none.
static bool estimate_pairs = false;
// Seconds of processor time that a full run gives to one estimate, about; and its most samples.
static double full_seconds = 300;
static const uint32_t FULL_SAMPLES = 1u << 24;

static inline Running estimate_fully(Estimate *e)
{
    const double errors = errors_found(MAX_CHECKS, REPLICATES - 1) * (estimate_pairs ? sqrt(2) : 1);
    for (;; e->seed += 1000) {
        const clock_t began = clock();
        const Running trial = estimate_once(e);
        const double seconds = (double)(clock() - began) / CLOCKS_PER_SEC;
        const double ratio = errors * running_error(&trial) / (full_bias * fabs(trial.mean));
        if (!(ratio > 0.75) || e->samples >= FULL_SAMPLES || seconds > full_seconds / 4) {
            break;
        }
        e->samples *= ratio > 2 ? 8 : ratio > 1.2 ? 4 : 2;
    }
    // A trial may have missed what is rare, and thought too well of its error.
    e->samples *= 2;
    e->seed += 1000;
    return estimate_once(e);
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
    return full_run() ? estimate_fully(&e) : estimate_once(&e);
}

// By the path tracer.
static inline Running estimate(const World *world, RayMaker *ray, const void *context,
                               uint32_t samples, uint32_t seed)
{
    return estimate_by(&path_integrator, world, ray, context, samples, seed);
}

typedef struct Check {
    char name[64];
    double expected, mean, error,
        freedom;   // freedom = 0: an exact check, whose error is a tolerance
    double wanted; // largest relative bias that may go unfound in an ordinary run, and in a full
    double wanted_fully;
    double seconds; // of CPU time since the check before
} Check;

typedef struct CheckTable {
    Check checks[MAX_CHECKS];
    int count;
    int family; // of how many checks this table is a part; 0: of its own
    clock_t last;
} CheckTable;

static inline void check_add(CheckTable *table, const char *name, Check check)
{
    if (table->count == MAX_CHECKS) {
        abort();
    }
    clock_t now = clock();
    check.wanted_fully = full_bias;
    check.seconds = (double)(now - table->last) / CLOCKS_PER_SEC;
    table->last = now;
    snprintf(check.name, sizeof check.name, "%s", name);
    table->checks[table->count++] = check;
}

static inline void check_mean(CheckTable *table, const char *name, double expected, Running mean,
                              double wanted)
{
    check_add(table, name,
              (Check){.expected = expected,
                      .mean = mean.mean,
                      .error = running_error(&mean),
                      .freedom = REPLICATES - 1,
                      .wanted = wanted});
}

// Two estimates of one unknown mean: their difference, of which the worse one's degrees of freedom
// are taken (on the safe side of Welch's).
static inline void check_equal(CheckTable *table, const char *name, Running a, Running b,
                               double wanted)
{
    check_add(table, name,
              (Check){.expected = a.mean,
                      .mean = b.mean,
                      .error = hypot(running_error(&a), running_error(&b)),
                      .freedom = REPLICATES - 1,
                      .wanted = wanted});
}

// One line of the table. False where the check failed, or couldn't have found what it should.
static inline bool check_line(const Check *c, int family)
{
    printf("%-44s %13.9g %13.9g ", c->name, c->expected, c->mean);
    // Results are sums of floats: a millionth is never significant.
    const double error = fmax(c->error, 1e-7 * fabs(c->expected));
    const double z = (c->mean - c->expected) / error;
    const double found = errors_found(family, c->freedom) * error / fabs(c->expected);
    const double wanted = full_run() ? fmin(c->wanted, c->wanted_fully) : c->wanted;
    const bool wrong = !(fabs(z) <= student_quantile(sidak(ALPHA, family), c->freedom));
    const bool weak = !(found <= wanted);
    printf("%10.2g %7.2f %10.4f%% %6.2f%s%s\n", c->error, z, 100 * found, c->seconds,
           wrong ? "  WRONG" : "", weak ? "  TOO WEAK" : "");
    return !wrong && !weak;
}

static inline void check_trust(const Check *c)
{
    trust_mean(c->name, c->expected, c->mean, fmax(c->error, 1e-7 * fabs(c->expected)), c->freedom,
               c->wanted_fully);
}

// Prints the table; the number of checks that failed, or that couldn't have found what they should.
static inline int check_judge(const CheckTable *table, const char *name)
{
    int failures = 0;
    const int family = table->family > table->count ? table->family : table->count;
    printf("%s: %d checks; family-wise alpha %g of %d%s\n", name, table->count, ALPHA, family,
           full_run() ? "; full run" : "");
    printf("%-44s %13s %13s %10s %7s %11s %6s\n", "check", "expected", "measured", "std.error", "z",
           "bias found", "cpu s");
    for (int i = 0; i < table->count; ++i) {
        failures += !check_line(&table->checks[i], family);
        check_trust(&table->checks[i]);
    }
    return failures;
}

#endif
