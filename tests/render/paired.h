// Ways to estimate one radiance, held against each other.
//
// Each replicate looks along a ray of its own, the same for all ways, with the same numbers of the
// sampler: what is judged is the mean of their differences against their scatter (Student's t with
// REPLICATES - 1 degrees of freedom), from which the places' own differences and much of the common
// noise have gone. With a fixed ray the samples are few-dimensional, and so even that errors fall
// much faster than by the root of their number.
#ifndef TEST_PAIRED_H
#define TEST_PAIRED_H

#include "estimate.h"

typedef struct Way {
    const char *name;
    const IntegratorClass *integrator;
    int sampling;
    bool roulette;
} Way;

// Of the path tracer.
static const Way MIS = {"mis", &path_integrator, SAMPLING_MIS, false};
static const Way LIGHT = {"light", &path_integrator, SAMPLING_LIGHT, false};
static const Way BSDF = {"bsdf", &path_integrator, SAMPLING_BSDF, false};

enum { MOST_DOUBLINGS = 26, TRIAL = 0, FINAL = 1 };

typedef struct Rivals {
    World *world;
    World *light_world; // the same, made for light sampling alone: its tables for surroundings are
                        // others; NULL: `world` is used for that, too
    RayMaker *ray;
    const void *context;
    Way first;        // which the others are held against
    uint32_t samples; // of a replicate, a power of two: in an ordinary run, and where a full begins
    double seconds;   // of processor time that a full run gives to a comparison, about
    bool known[2][MOST_DOUBLINGS];
    double means[2][MOST_DOUBLINGS][REPLICATES]; // of the first way, by log2 of the samples
} Rivals;

static inline void rivals_run(const Rivals *r, const Way *way, int stage, int doublings,
                              double means[REPLICATES])
{
    World *world = r->light_world && way->sampling == SAMPLING_LIGHT ? r->light_world : r->world;
    Estimate e = {.world = world,
                  .integrator = way->integrator,
                  .ray = r->ray,
                  .context = r->context,
                  .samples = 1u << doublings,
                  .seed = stage == FINAL ? 1001 : 1,
                  .fixed = true};
    world->sampling = way->sampling;
    world->russian_roulette = way->roulette;
    estimate_once(&e);
    memcpy(means, e.means, sizeof e.means);
}

static inline const double *rivals_first(Rivals *r, int stage, int doublings)
{
    if (!r->known[stage][doublings]) {
        rivals_run(r, &r->first, stage, doublings, r->means[stage][doublings]);
        r->known[stage][doublings] = true;
    }
    return r->means[stage][doublings];
}

static inline double mean_of(const double means[REPLICATES])
{
    double sum = 0;
    for (int i = 0; i < REPLICATES; ++i) {
        sum += means[i] / REPLICATES;
    }
    return sum;
}

// The standard error of mean(other) / mean(first), to first order. Of a choice with two outcomes, N
// even samples have one as often as N times its chance says, rounded: where that is next to a whole
// number all replicates may round alike, and their scatter doesn't show it. So the error is taken
// to be half a sample at least. (Which is more than the rounding of sums of floats, too.)
static inline double ratio_error(const double first[REPLICATES], const double other[REPLICATES],
                                 int doublings)
{
    const double ratio = mean_of(other) / mean_of(first);
    Running rest = {0};
    for (int i = 0; i < REPLICATES; ++i) {
        running_add(&rest, other[i] - ratio * first[i]);
    }
    return fmax(running_error(&rest) / fabs(mean_of(first)), ldexp(0.5, -doublings));
}

static inline void rivals_check(CheckTable *table, const char *name, const double *first,
                                const double *other, int doublings, double wanted)
{
    if (mean_of(first) == 0 && mean_of(other) == 0) {
        return; // a mirror shows no light without size
    }
    check_add(table, name,
              (Check){.expected = 1,
                      .mean = mean_of(other) / mean_of(first),
                      .error = ratio_error(first, other, doublings),
                      .freedom = REPLICATES - 1,
                      .wanted = wanted});
}

static inline int doublings_of(uint32_t samples)
{
    int n = 0;
    while (1u << n < samples) {
        ++n;
    }
    return n;
}

// In a full run: numbers grow until a trial tells how many will do, and then another run with its
// own seed counts. The first way is cut short where its noise hardly matters.
static inline void rivals_compare_fully(CheckTable *table, Rivals *r, const char *name,
                                        const Way *way)
{
    enum { SHORTER = 4 }; // doublings
    const double allowed = full_bias / errors_found(MAX_CHECKS, REPLICATES - 1);
    const int least = doublings_of(r->samples);
    double other[REPLICATES], error = 0, seconds = 0;
    int n = least, shorter = 0;
    for (;; n += 2) {
        const clock_t began = clock();
        rivals_run(r, way, TRIAL, n, other);
        seconds = (double)(clock() - began) / CLOCKS_PER_SEC;
        error = ratio_error(rivals_first(r, TRIAL, n), other, n);
        if (mean_of(other) == 0 || !(error > 2.2 * allowed) || 4 * seconds > r->seconds / 4 ||
            n + 5 > MOST_DOUBLINGS) {
            break;
        }
    }
    if (n - SHORTER >= least) {
        const double less = ratio_error(rivals_first(r, TRIAL, n - SHORTER), other, n - SHORTER);
        shorter = less < 1.1 * error ? SHORTER : 0;
        error = shorter ? less : error;
    }
    for (double ratio = 1.25 * error / allowed; ratio > 1 && n + 1 < MOST_DOUBLINGS; ++n) {
        ratio /= sqrt(2);
        seconds *= 2;
        if (seconds > r->seconds) {
            break;
        }
    }
    rivals_run(r, way, FINAL, n, other);
    rivals_check(table, name, rivals_first(r, FINAL, n - shorter), other, n - shorter, full_bias);
}

// Holds a way against the first; a relative bias larger than `wanted` may not go unfound in an
// ordinary run, than full_bias in a full one.
static inline void rivals_compare(CheckTable *table, Rivals *r, const char *name, const Way *way,
                                  double wanted)
{
    if (full_run()) {
        rivals_compare_fully(table, r, name, way);
        return;
    }
    double other[REPLICATES];
    const int n = doublings_of(r->samples);
    rivals_run(r, way, FINAL, n, other);
    rivals_check(table, name, rivals_first(r, FINAL, n), other, n, wanted);
}

#endif
