// Sample points: Owen-scrambled Sobol sequences, keyed by pixel and sample number, so that a
// picture's bytes depend on neither threads nor the order of tiles. Burley 2020, "Practical
// Hash-based Owen Scrambling" (JCGT 9/4): sets of four dimensions, each shuffled and scrambled by
// its own seed.
#ifndef RENDER_SAMPLER_H
#define RENDER_SAMPLER_H

#include <stdint.h>

typedef struct Sampler {
    uint32_t seed;      // of this pixel
    uint32_t index;     // number of the sample
    uint32_t dimension; // next dimension
    uint32_t set;       // the set of four that `values` holds + 1; 0: none
    float values[4];
} Sampler;

void sampler_start(Sampler *sampler, uint32_t seed, uint32_t pixel_x, uint32_t pixel_y,
                   uint32_t sample);
// The next dimension's number in [0, 1).
float sampler_1d(Sampler *sampler);
// Two numbers, from two dimensions of one set.
void sampler_2d(Sampler *sampler, float *u, float *v);
// Goes on at the given dimension, so that paths that took different turns agree on the dimensions
// of later bounces. Rounded up to a whole set.
void sampler_seek(Sampler *sampler, uint32_t dimension);

#endif
