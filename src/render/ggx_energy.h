// How much light single scattering by GGX facets gives back when the facets absorb nothing: the
// directional albedo of expression (10) with F = 1, for isotropic roughness. What is missing from 1
// has bounced between facets; Kulla and Conty 2017 put it back by these.
#ifndef RENDER_GGX_ENERGY_H
#define RENDER_GGX_ENERGY_H

#include "base/microfacet.h"

// The table's grid: rows for alpha = j/(rows - 1), columns for t = i/(columns - 1), where
// sin²(π t/2) = mu (1 + alpha)/(mu + alpha), which spreads the steep part at mu ~ alpha out and is
// dense at both ends.
enum { GGX_ENERGY_ROWS = 32, GGX_ENERGY_COLUMNS = 32 };

// Seen under cosine mu in [0, 1]; alpha in [0, 1]. Off by less than 1e-4, and by less than 3e-4
// where alpha is below 0.04.
double ggx_energy(double alpha, double mu);
// 2 ∫ ggx_energy mu dmu over [0, 1], of the same table, so that what is put back sums to what is
// missing.
double ggx_energy_mean(double alpha);

// The same for a pair of roughnesses, whose albedo depends on the direction around the normal, too:
// a table of its own, made at some 10 ms by quadrature. Off by less than 5e-3.
enum { GGX_PAIR_ROWS = 9, GGX_PAIR_COLUMNS = 12 };
typedef struct GgxPairEnergy {
    float table[GGX_PAIR_ROWS][GGX_PAIR_COLUMNS]; // rows: φ from 0 to π/2; columns as above
    double alpha;                                 // for the columns: the pair's geometric mean
    double mean;                                  // (1/π) ∫ albedo cos θ dω, of this table
} GgxPairEnergy;
void ggx_pair_energy_make(Ggx ggx, GgxPairEnergy *out);
// Seen from w (w.z > 0) in the facets' frame.
double ggx_pair_energy(const GgxPairEnergy *energy, Vec3 w);

#endif
