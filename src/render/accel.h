// Ray against scene. Embree stands behind it, in accel_embree.c and nowhere else.
#ifndef RENDER_ACCEL_H
#define RENDER_ACCEL_H

#include "render/shape.h"

typedef struct Accel Accel;

typedef struct Hit {
    double t;
    uint32_t shape;    // id of the shape's node
    uint32_t instance; // index into scene->instances, or NONE_ID in the world
    ShapeHit local;    // in the coordinates of `flat`, where that is of the accelerator's table
    uint32_t flat;     // number + 1 of the flat piece of surface that was hit; 0: a curved one
    bool inside;       // so far from the piece's edges that rays may leave it the fast way
    Vec3 p;            // on a piece of the accelerator's table: the point, in its group's space
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
    bool front; // the ray came from the front side
    bool lamp;  // the shape stands in an area_light only
    bool bent;  // shading isn't geometric
    bool whole; // what follows `own_normal` is filled in, too
    // For rays that leave it: see RayEnds and accel_parts.h.
    bool near_edge, lifts;
    uint32_t flat;
    float own_normal[3]; // where lifts
    Vec3 tangent;        // dp/du in the world, not normalized
    Vec3 bitangent;      // dp/dv in the world, not normalized
    Vec3 object_p;       // p in the shape's own space, for textures of object space
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
// Surface.material of a hit.
uint32_t accel_material(const Accel *accel, const Hit *hit);

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
static inline Ray surface_spawn(const Surface *surface, Vec3 direction);
// The same towards a point `target` at a distance from the surface's point (on a surface of
// position error `target_error`; 0 for a light's point): tmax ends before it by 4 times both errors
// and 1e-9 of the way. `facing` is the cosine between the way and the normal there where the
// target's surface is flat, else 0.
static inline Ray surface_spawn_to(const Surface *surface, Vec3 target, double distance,
                                   double target_error, double facing);

// The shape's (and its instance's) map from its own space to the world.
Affine accel_to_world(const Accel *accel, uint32_t shape, uint32_t instance);

// --- Inline --------------------------------------------------------------------------------------

// A ray leaves a surface at this many times the bound on the point's error.
#define SPAWN_FACTOR 4

// The ray from `origin` to the side of `side`, with what follows from the surface.
static inline Ray surface_ray(const Surface *surface, Vec3 origin, Vec3 direction, double tmax,
                              bool front)
{
    Ray ray;
    ray.origin = origin;
    ray.direction = direction;
    ray.tmin = 0;
    ray.tmax = tmax;
    ray.ends.flat = surface->flat;
    ray.ends.instance = surface->instance;
    ray.ends.near_edge = surface->near_edge;
    ray.ends.facing = 0;
    ray.ends.target = 0;
    for (int i = 0; i < 3; ++i) {
        ray.ends.normal[i] = !surface->lifts ? 0
                             : front         ? surface->own_normal[i]
                                             : -surface->own_normal[i];
    }
    return ray;
}

// The surface's point, moved to the side that `side` has the sign of. No branch: of a scene's
// surfaces, chance takes either side.
static inline Vec3 surface_beside(const Surface *surface, double side)
{
    return add_scaled(surface->p, surface->geometric,
                      copysign(SPAWN_FACTOR * surface->error, side));
}

static inline Ray surface_spawn(const Surface *surface, Vec3 direction)
{
    const double side = dot(direction, surface->geometric);
    return surface_ray(surface, surface_beside(surface, side), direction, INFINITY, side >= 0);
}

static inline Ray surface_spawn_to(const Surface *surface, Vec3 target, double distance,
                                   double target_error, double facing)
{
    const double side = dot(sub(target, surface->p), surface->geometric);
    const double offset = SPAWN_FACTOR * surface->error;
    const Vec3 origin = surface_beside(surface, side);
    const Vec3 way = sub(target, origin);
    // But for the offset, the length is known.
    const double size = distance < 0x1p26 * offset ? length(way) : distance;
    const Vec3 direction = size > 0 ? scale(way, 1 / size) : surface->geometric;
    const double margin = offset + SPAWN_FACTOR * target_error + 1e-9 * size;
    Ray ray =
        surface_ray(surface, origin, renormalize(direction), larger(0, size - margin), side >= 0);
    ray.ends.facing = (float)facing;
    return ray;
}

#endif
