// Sample points: Owen-scrambled Sobol sequences, keyed by pixel and sample number, so that a
// picture's bytes depend on neither threads nor the order of tiles. Burley 2020, "Practical
// Hash-based Owen Scrambling" (JCGT 9/4): sets of four dimensions, each shuffled and scrambled by
// its own seed.
//
// Within a set, dimensions 0 and 1 are a (0, 2)-sequence: any 2^m samples that begin at a multiple
// of 2^m hold one point in each elementary interval. So two numbers that matter together are best
// drawn by sampler_2d at the start of a set.
//
// Neighbouring pixels of a picture complete one another: the 16 × 16 pixels of a patch share their
// scrambles and differ in a digital shift each, chosen such that 4^b samples of each aligned square
// of 2^a × 2^a pixels are one net, too (sobol_tables.h). A pixel's own points are as good and as
// random as without; but where a pixel has a little too much light its neighbours have too little,
// so that what is left of noise is fine-grained and goes when it is seen from afar (the idea: Ahmed
// and Wonka 2020, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical
// Ordering of Pixels"; theirs has to know the number of samples from the start).
#ifndef RENDER_SAMPLER_H
#define RENDER_SAMPLER_H

#include "base/hash.h"

#include <stdint.h>
#include <string.h>

// The most dimensions that are made at once.
enum { SAMPLER_AHEAD = 32 };

// Private but for sampler_*(); a few words, to live on the stack.
typedef struct Sampler {
    uint32_t seed;           // of this pixel, or of its patch
    uint32_t place, places;  // in the patch: reversed Morton number, and its bits; 0, 0: no patch
    uint32_t reversed_index; // number of the sample, its bits reversed
    uint32_t dimension;      // next dimension
    uint32_t first, held;    // `values` are of so many dimensions from this one on
    float values[SAMPLER_AHEAD];
} Sampler;

// The seed of a pixel's or a patch's sequences: with the place in it all of the screen and of the
// picture's seed that enters.
uint32_t sampler_pixel_seed(uint32_t seed, uint32_t pixel_x, uint32_t pixel_y);

// Begins at dimension 0 of sample number `sample` of a pixel; all pixels are independent.
void sampler_start(Sampler *sampler, uint32_t seed, uint32_t pixel_x, uint32_t pixel_y,
                   uint32_t sample);
// The same for pixels of a picture, of which neighbours complete one another.
void sampler_start_neighbour(Sampler *sampler, uint32_t seed, uint32_t pixel_x, uint32_t pixel_y,
                             uint32_t sample);
// Fills `values` with as many dimensions, eight or more, as cost little together, from `dimension`
// on, rounded down to a whole set.
void sampler_fill(Sampler *sampler, uint32_t dimension);
// The functions that this processor has for it, which differ in how many; for tests. Returns how
// many functions there are.
typedef void SamplerFill(Sampler *sampler, uint32_t dimension);
int sampler_fills(SamplerFill *out[2]);
// Goes on at the given dimension, so that paths that took different turns agree on the dimensions
// of later bounces. Rounded up to a whole set.
void sampler_seek(Sampler *sampler, uint32_t dimension);

// The next dimension's number in [0, 1), a multiple of 2^-24.
static inline float sampler_1d(Sampler *sampler)
{
    const uint32_t dimension = sampler->dimension++;
    if (dimension - sampler->first >= sampler->held) {
        sampler_fill(sampler, dimension);
    }
    return sampler->values[dimension - sampler->first];
}

// The bits beyond the first 24 of dimension `dimension`, for sampler_1d_fine.
static inline double sampler_finer(const Sampler *sampler, uint32_t dimension)
{
    const uint32_t pixel = sampler->seed ^ sampler->place << 24;
    const uint32_t more = hash_combine(hash_combine(pixel, sampler->reversed_index), dimension);
    return 0x1p-24 * ((double)(more >> 3) * 0x1p-29);
}

// The same with 53 bits, those beyond the first 24 hashed: for a choice among very many things.
static inline double sampler_1d_fine(Sampler *sampler)
{
    const uint32_t dimension = sampler->dimension;
    const double coarse = (double)sampler_1d(sampler);
    return coarse + sampler_finer(sampler, dimension);
}

// The numbers of the eight dimensions from `dimension` on, a multiple of 4; goes on after them.
// They stay where they are until others are asked for.
static inline const float *sampler_eight(Sampler *sampler, uint32_t dimension)
{
    const uint32_t at = dimension - sampler->first;
    if (at >= sampler->held || sampler->held - at < 8) {
        sampler_fill(sampler, dimension);
    }
    sampler->dimension = dimension + 8;
    return sampler->values + (dimension - sampler->first);
}

// Two numbers, from two dimensions of one set (a fourth dimension left over is passed over).
static inline void sampler_2d(Sampler *sampler, float *u, float *v)
{
    if ((sampler->dimension & 3) == 3) {
        ++sampler->dimension;
    }
    *u = sampler_1d(sampler);
    *v = sampler_1d(sampler);
}

// Passes over the two that sampler_2d would give.
static inline void sampler_skip_2d(Sampler *sampler)
{
    sampler->dimension += (sampler->dimension & 3) == 3 ? 3 : 2;
}

#endif
