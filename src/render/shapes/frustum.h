// A cone cut off at both ends, or a cylinder: what both kinds are to the renderer.
#ifndef RENDER_SHAPES_FRUSTUM_H
#define RENDER_SHAPES_FRUSTUM_H

#include "render/geometry.h"

// Primitives.
enum { FRUSTUM_SIDE, FRUSTUM_FROM, FRUSTUM_TO };

typedef struct Frustum {
    Vec3 from;
    Frame frame; // n along the axis
    double height;
    double r0, r1; // at `from` and at the other end
    bool caps;
} Frustum;

// The ends must differ.
Frustum frustum_make(Vec3 from, Vec3 to, double r0, double r1, bool caps);
Box3 frustum_bounds(const Frustum *f);
bool frustum_intersect(const Frustum *f, const Ray *ray, ShapeHit *hit);
void frustum_point(const Frustum *f, const Ray *ray, const ShapeHit *hit, ShapePoint *out);

// Areas under a transform: side, cap at `from`, cap at the other end.
typedef struct FrustumTable {
    double area[3], total;
    double most; // largest factor by which the side's area grows
    bool similar;
} FrustumTable;
FrustumTable frustum_table(const Frustum *f, const Affine *to_world);
void frustum_sample_area(const Frustum *f, const Affine *to_world, const FrustumTable *table,
                         double u0, double u1, double u2, ShapeSample *out);

#endif
