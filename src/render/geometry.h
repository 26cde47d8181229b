// What the kinds of shapes share: maps of normals and areas, bounds on rounding errors, sampling by
// rejection.
#ifndef RENDER_GEOMETRY_H
#define RENDER_GEOMETRY_H

#include "render/shape.h"

// Half the distance from 1 to the next double: no sum or product of doubles is off by a larger
// fraction.
#define ROUNDING 0x1p-53

// The cofactor matrix of the linear part: det(M) M^-T, which carries area vectors (cross products).
// It exists for singular maps, too, and |C n| is the factor by which areas normal to n grow.
Affine affine_cofactors(const Affine *a);
// The map of unit normals, of the cofactors and the determinant's sign. Unit.
Vec3 map_normal(const Affine *cofactors, bool mirrored, Vec3 normal);
// True where the linear part is a rotation (or reflection) times a uniform scale, which goes to
// *scale_out; to relative 1e-9.
bool affine_is_similarity(const Affine *a, double *scale_out);
// A bound on how much the linear part can stretch a vector (its Frobenius norm).
double affine_stretch(const Affine *a);

// What a map does to points of surfaces, besides moving them.
typedef struct SpaceMap {
    Affine normals; // the map of normals but for their length: see map_normal
    double stretch;
    // The rounding error, as a length in the target space, of bringing a point back by the inverse
    // and of the way there, what the map's condition does included, is at most
    // fixed + before |p| + after |p'|, in the maximum norm, p being the point and p' where it goes.
    double fixed, before, after;
} SpaceMap;
SpaceMap space_map(const Affine *a, const Affine *inverse);
// Brings all fields of a point to the target space of `a`, with its error, that of a ray's way to
// the point's space and back included.
void space_map_point(const SpaceMap *map, const Affine *a, ShapePoint *point);

// Brings all fields of a point to the space that `to_world` leads to, with its error.
void shape_point_map(const Affine *to_world, ShapePoint *point);

// An estimate, on the safe side, of the rounding error of a point that was found by a few
// operations on numbers not larger than `size`.
static inline double rounding_error(double size)
{
    return 8 * ROUNDING * size;
}
static inline double max_abs(Vec3 p)
{
    return max_component(vec3_abs(p));
}

// A cheap stream of further random numbers that follows from given ones, for rejection sampling:
// the first tries use the given, well-stratified numbers, which suffice where nothing is rejected.
typedef struct Rejection {
    uint64_t state;
} Rejection;
Rejection rejection_begin(double u0, double u1, double u2);
// In [0, 1).
double rejection_next(Rejection *rejection);
// Tries after which the last is taken: where at least a tenth of them are accepted, one in 1e9
// samples is affected.
enum { REJECTION_TRIES = 200 };

static inline bool shape_is_closed(const void *params)
{
    (void)params;
    return true;
}
static inline bool shape_is_open(const void *params)
{
    (void)params;
    return false;
}

// --- For shapes that enclose a quadric or need integrals --------------------------------------

// Carlson's symmetric elliptic integral R_G(x, y, z) by duplication (Carlson 1995, "Numerical
// computation of real or complex elliptic integrals"); all >= 0. The area of an ellipsoid of half
// axes a, b, c is 4 pi R_G(a^2 b^2, a^2 c^2, b^2 c^2).
double carlson_rg(double x, double y, double z);
// The eigenvalues of the symmetric matrix M^T M of the linear part, in no order (Jacobi).
Vec3 affine_gram_eigenvalues(const Affine *a);

#endif
