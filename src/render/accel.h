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
    uint32_t flat; // number + 1 of the flat piece of surface that was hit; 0: a curved one
    bool inside;   // so far from the piece's edges that rays may leave it the fast way
    Vec3 p;        // on a piece of the accelerator's table: the point, in its group's space
} Hit;

// Surface.material of an area light's shape that was given no material: it emits and reflects
// nothing, as lamps do in the programs that ours is compared with.
#define MATERIAL_BLACK (NONE_ID - 1)

// A point of a surface in the world, ready for shading.
typedef struct Surface {
    Vec3 p;
    Vec3 geometric; // unit, towards the shape's front side (outwards), whichever side was hit
    Vec3 shading;   // unit, on the same side as geometric
    double error;   // bound on the distance from p to the surface, in the world
    uint32_t shape, instance, primitive;
    // The shape's own, else its instance's; else NONE_ID, the default material, or MATERIAL_BLACK.
    uint32_t material;
    bool front;     // the ray came from the front side
    bool lamp;      // the shape stands in an area_light only
    bool bent;      // shading isn't geometric
    bool whole;     // what follows `ends` is filled in, too
    RayEnds ends;   // of rays that leave it to the front
    Vec3 tangent;   // dp/du in the world, not normalized
    Vec3 bitangent; // dp/dv in the world, not normalized
    Vec3 object_p;  // p in the shape's own space, for textures of object space
    Vec2 uv;
    Rgb color; // vertex color
} Surface;

// Geometry that can't be hit, counted when it was built: shapes and triangles that have no area
// where their transforms bring them, and shapes and instances that aren't finite there.
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
// The same without what textures and tangents need, which costs less.
void accel_surface_plain(const Accel *accel, const Ray *ray, const Hit *hit, Surface *out);

// A ray that leaves a surface towards a unit direction, to the side of `direction`. tmin = 0, tmax
// = INFINITY. Its origin is the surface's point moved along the geometric normal by the offset
//
//     4 surface->error, where error is about 8 * 2^-53 times the size of the numbers that the point
//     came from: its coordinates, the shape's size and place, and for shapes with a transform or in
//     an instance those on the way to the shape's own space and back; for thin triangles times the
//     ratio of two edges' product to their area.
//
// So on a shape of 1 m at the origin it is some 1e-14 m, at 1000 km some 1e-8 m. Nothing else keeps
// a ray from hitting the surface that it leaves: intersection decides in double precision, by the
// side on which the ray starts.
Ray surface_spawn(const Surface *surface, Vec3 direction);
// The same towards a point `target` at a distance from the surface's point (on a surface of
// position error `target_error`; 0 for a light's point): tmax ends before it by 4 times both errors
// and 1e-9 of the way. `facing` is the cosine between the way and the normal there where the
// target's surface is flat, else 0.
Ray surface_spawn_to(const Surface *surface, Vec3 target, double distance, double target_error,
                     double facing);

// The shape's (and its instance's) map from its own space to the world.
Affine accel_to_world(const Accel *accel, uint32_t shape, uint32_t instance);

#endif
