// Ray against scene. Embree stands behind it, in accel_embree.c and nowhere else.
#ifndef RENDER_ACCEL_H
#define RENDER_ACCEL_H

#include "render/shape.h"

typedef struct Accel Accel;

typedef struct Hit {
    double t;
    uint32_t shape;    // id of the shape's node
    uint32_t instance; // index into scene->instances, or NONE_ID in the world
    ShapeHit local;
} Hit;

// A point of a surface in the world, ready for shading.
typedef struct Surface {
    Vec3 p;
    Vec3 geometric; // unit, towards the shape's front side (outwards), whichever side was hit
    Vec3 shading;   // unit, on the same side as geometric
    Vec3 tangent;   // dp/du in the world, not normalized
    Vec3 bitangent; // dp/dv in the world, not normalized
    Vec3 object_p;  // p in the shape's own space, for textures of object space
    Vec2 uv;
    Rgb color;    // vertex color
    double error; // bound on the distance from p to the surface, in the world
    uint32_t shape, instance, primitive;
    uint32_t material; // the shape's own, else its instance's; NONE_ID: the default material
    bool front;        // the ray came from the front side
} Surface;

// What is wrong with geometry, counted when it was built: see accel_report.
typedef struct AccelIssues {
    uint64_t degenerate, not_finite;
} AccelIssues;

// Builds for `threads` threads (0: all). NULL when memory runs out. The scene must not change while
// the accelerator lives.
Accel *accel_build(const Scene *scene, unsigned threads);
void accel_free(Accel *accel);
AccelIssues accel_issues(const Accel *accel);
// The box of all bounded shapes in the world; empty if there are none.
Box3 accel_bounds(const Accel *accel);

// The nearest hit with tmin < t < tmax. ray->direction is of unit length. Thread-safe, as all
// below.
bool accel_intersect(const Accel *accel, const Ray *ray, Hit *hit);
// True when anything is hit.
bool accel_occluded(const Accel *accel, const Ray *ray);
void accel_surface(const Accel *accel, const Ray *ray, const Hit *hit, Surface *out);

// A ray that leaves a surface towards a unit direction, its origin moved off the surface by the
// documented offset: proportional to surface->error and to |p| in float precision, along the
// geometric normal, to the side of `direction`. tmin = 0, tmax = INFINITY.
Ray surface_spawn(const Surface *surface, Vec3 direction);
// The same towards a point `target` (on a surface of position error `target_error`; 0 for a light's
// point): tmax ends just before it. *distance is from the surface to the target.
Ray surface_spawn_to(const Surface *surface, Vec3 target, double target_error, double *distance);

// The shape's (and its instance's) map from its own space to the world.
Affine accel_to_world(const Accel *accel, uint32_t shape, uint32_t instance);

#endif
