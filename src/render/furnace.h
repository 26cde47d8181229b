// The white furnace: a flat piece of a material in light of radiance 1 from all around. What it
// gives back is its albedo, for each angle of view; beside it, whether it keeps three laws.
//
// - Energy: no more light leaves than falls on it, R + T <= 1 at each angle, in each channel. What
// is
//   transmitted is counted as power: radiance that is squeezed into glass counts eta² times less.
// - Reciprocity: f(o, i) / eta_o² = f(i, o) / eta_i² (Veach 1997, 5.2).
// - Sampling: the directions that `sample` chooses have the density `pdf`, by Pearson's test.
//
// Albedos are means of the weights of sampled directions over FURNACE_REPLICATES randomizations of
// the sampler, with the standard error of these (and no less than meter.h's grain); averaged over
// azimuths, and over the unit square of uv where textures need it.
#ifndef RENDER_FURNACE_H
#define RENDER_FURNACE_H

#include "render/world.h"

#include <stdatomic.h>

enum {
    FURNACE_ANGLES = 37, // every 2.5 degrees, and 89 in place of 90
    FURNACE_REPLICATES = 32,
    FURNACE_SAMPLES = 16384, // of each angle, unless told otherwise
    FURNACE_PAIRS = 8192,    // of directions, for reciprocity
};

typedef struct FurnaceOptions {
    unsigned threads; // 0: all processors
    int64_t samples;  // of each angle; 0: FURNACE_SAMPLES
    uint32_t seed;
    const atomic_int *stop; // non-zero: stop soon; may be NULL
} FurnaceOptions;

// What is given back, seen from one angle. Errors are standard errors.
typedef struct FurnacePoint {
    double angle; // radians from the normal
    double reflected[3], transmitted[3], total[3];
    double reflected_error[3], transmitted_error[3], total_error[3];
} FurnacePoint;

typedef enum FurnaceVerdict {
    FURNACE_NOT_ASKED, // nothing to be tested: no smooth lobe
    FURNACE_HOLDS,
    FURNACE_BROKEN,
} FurnaceVerdict;

typedef struct FurnaceExtreme {
    double value, error, angle; // error: standard error
    bool front;
} FurnaceExtreme;

typedef struct FurnaceReport {
    uint32_t lobes;  // MaterialLobes
    bool both_sides; // the back differs from the front: sides[1] is of the back
    FurnacePoint sides[2][FURNACE_ANGLES];
    FurnaceVerdict energy; // at the level 1e-4 over all angles and channels
    // Of the channel that gives back most: where that is most, and least.
    FurnaceExtreme most, least;
    FurnaceVerdict reciprocity;
    double asymmetry; // the largest relative difference of the two sides of the equation
    FurnaceVerdict sampling;
    double sampling_p; // the family-wise p-value; broken below 1e-4
    // What the kind itself says of laws that it breaks by construction; NULL: nothing.
    const char *caveat;
    bool stopped;
} FurnaceReport;

// False when memory runs out.
bool furnace_measure(const World *world, uint32_t material, const FurnaceOptions *options,
                     FurnaceReport *out);

#endif
