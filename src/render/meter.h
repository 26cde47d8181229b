// Measuring what a scene expects of its light: means of radiance with confidence intervals, from as
// many samples as a verdict needs.
//
// A mean is estimated by METER_REPLICATES independent randomizations of the sampler (each a
// scrambled Sobol sequence of its own over the region), whose scatter gives its standard error. For
// formulas of several means it is that of the jackknife over the replicates (Tukey 1958; Owen,
// "Monte Carlo theory, methods and examples", 2.7), so that ratios are nearly unbiased and means of
// overlapping regions may depend on each other. The interval is Student's t with METER_REPLICATES -
// 1 degrees of freedom.
//
// The points of a sequence are so even that where samples take few values (seen or not, reflected
// or not) all replicates may well have the same mean by chance, and yet not the true one. So no
// error is taken to be less than twice the samples' range over their number: that of such a mean if
// one in all replicates were off by one sample.
//
// Samples are doubled until the interval lies wholly on one side of what is expected. Looking K
// times at C channels, each interval has the confidence 1 - α / (K C) (Bonferroni), so that all of
// a measurement's intervals hold at once with the confidence 1 - α: however often it looks, no more
// than α of all verdicts are wrong.
//
// What no sample has found can't be told: where light comes from so small a place that 8192 samples
// miss it, the scatter is none, too.
#ifndef RENDER_METER_H
#define RENDER_METER_H

#include "base/diag.h"
#include "scene/scene.h"

#include <stdatomic.h>

enum {
    METER_REPLICATES = 32,
    METER_FIRST = 256, // samples of each replicate before the first look
};

typedef struct TestParams { // the `test` kind
    double confidence;
    int64_t samples; // the most of one measurement
} TestParams;

// Of zero bytes, but for seed = -1, all is as the scene says.
typedef struct MeterOptions {
    unsigned threads;       // 0: all processors
    int64_t samples;        // 0: the scene's
    int64_t seed;           // -1: the scene's
    double confidence;      // 0: the scene's
    const atomic_int *stop; // non-zero: stop soon; may be NULL
} MeterOptions;

typedef enum MeterVerdict {
    METER_MET,
    METER_NOT_MET,
    METER_UNDECIDED, // the interval lies on both sides after the most samples, or at a stop
} MeterVerdict;

typedef struct MeterResult {
    MeterVerdict verdict;
    uint32_t channels;
    double mean[3], half[3]; // mean ± half holds the value, with `confidence`
    double confidence;
    uint64_t samples, bad_samples; // bad: negative or not finite, and taken as black
    double needed;                 // undecided: about how many samples decide; INFINITY: unknown
    bool stopped;
} MeterResult;

typedef struct Meter Meter;

// The settings of a scene: its own, or the defaults.
TestParams scene_test(const Scene *scene);

// Builds what rendering needs. NULL after reporting to `sink`. The scene and options->stop must
// outlive the meter.
Meter *meter_new(const Scene *scene, const MeterOptions *options, DiagSink *sink);
// What is measured from now on is of another seed.
void meter_reseed(Meter *meter, int64_t seed);
// False when memory runs out.
bool meter_measure(Meter *meter, const SceneMeasure *measure, MeterResult *result);
void meter_free(Meter *meter);

#endif
