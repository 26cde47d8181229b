// Gradient noise, after Perlin, "Improving Noise", SIGGRAPH 2002: a gradient at each corner of the
// unit cell that p lies in, faded by 6t⁵ - 15t⁴ + 10t³. The gradients are the 12 edges of a cube
// (with 4 of them twice), chosen by a hash of the corner's whole coordinates instead of a table, so
// that the noise doesn't repeat. Smooth, 0 at whole coordinates, in [-1, 1].
#ifndef BASE_NOISE_H
#define BASE_NOISE_H

#include "base/vec.h"

double noise3(Vec3 p);

#endif
