// What the renderer knows of a kind of shape: one file a kind in shapes/, one row in nodes.def. Its
// bounds are those of the NodeType.
//
// A shape lives in its own space, where its parameters are. Its node's transform leads from there
// to the space of its prototype (the world, for prototype 0). Everything here is in the shape's own
// space, in double.
#ifndef RENDER_SHAPE_H
#define RENDER_SHAPE_H

#include "base/vec.h"
#include "scene/scene.h"
#include "schema/schema.h"

// What the accelerator knows of a ray's ends, so that single precision can be trusted there: see
// accel_parts.h. All zero: nothing is known.
typedef struct RayEnds {
    uint32_t flat;     // number + 1 of the flat piece of surface that the ray leaves; 0: none
    uint32_t instance; // that it is in
    float normal[3];   // of the piece in its group's space, unit, on the ray's side
    float facing;    // cosine between the ray and the normal of the surface just beyond tmax, which
                     // doesn't count; 0: no such surface
    uint32_t target; // 1 + the shape, flat and in the world, of a point at tmax; 0: none
    bool near_edge;  // the ray starts so near to the piece's edges that it has to take care
} RayEnds;

typedef struct Ray {
    Vec3 origin, direction; // direction: unit length in the world; any length in other spaces
    double tmin, tmax;      // in lengths of the direction
    RayEnds ends;
} Ray;

static inline Ray ray_make(Vec3 origin, Vec3 direction, double tmin, double tmax)
{
    return (Ray){.origin = origin, .direction = direction, .tmin = tmin, .tmax = tmax};
}

// Where a ray meets a shape, in the shape's own space and parametrisation.
typedef struct ShapeHit {
    double t;
    uint32_t primitive; // triangle of a mesh, face of a box, part of a capped cylinder, …
    double u, v;        // barycentric or the shape's own
} ShapeHit;

// Geometry at a point of a surface, in the shape's own space.
typedef struct ShapePoint {
    Vec3 p;         // on the surface (projected back onto it, not origin + t direction)
    Vec3 geometric; // unit normal, outwards; the front side
    Vec3 shading;   // unit; differs from geometric on smooth meshes
    Vec3 tangent;   // dp/du, not normalized; any tangent where uv is degenerate
    Vec3 bitangent; // dp/dv, likewise
    Vec2 uv;
    Rgb color;    // vertex color; white where there is none
    double error; // bound on the distance from p to the true surface
} ShapePoint;

// A point chosen on a shape's surface.
typedef struct ShapeSample {
    ShapePoint point;
    uint32_t primitive;
    double pdf; // by area, or by solid angle seen from the reference point, as the function says
} ShapeSample;

// A point chosen for lighting a reference point. All in the world.
typedef struct ShapeAim {
    Vec3 p, normal; // unit
    double error;   // bound on the distance from p to the surface
    double pdf;     // by solid angle or by area
    bool by_angle;
} ShapeAim;

// How the accelerator holds a kind.
typedef enum ShapeHolding {
    HOLD_USER,      // through bounds and intersect
    HOLD_TRIANGLES, // a triangle mesh (mesh)
    HOLD_FLAT,      // one or two triangles or a quad: `corners` (triangle, rectangle)
    HOLD_UNBOUNDED, // tested apart from the hierarchy, through intersect (plane)
} ShapeHolding;

typedef struct ShapeClass {
    NodeType node; // first: a ShapeClass is a NodeType
    ShapeHolding holding;
    bool flat; // has one normal
    // True where it encloses a volume (for glass, media, CSG, "light inside" warnings).
    bool (*closed)(const void *params);
    // The nearest hit with ray->tmin < t < ray->tmax; the direction need not be of unit length.
    bool (*intersect)(const void *params, const Ray *ray, ShapeHit *hit);
    // The middle and the radius of a shape that is a ball. NULL: it isn't one.
    Vec3 (*ball)(const void *params, double *radius);
    // The geometry at a hit; that of kinds held as triangles doesn't ask for the ray.
    void (*point)(const Scene *scene, const void *params, const Ray *ray, const ShapeHit *hit,
                  ShapePoint *out);
    // The same without tangents, texture coordinates and color, where that costs less. May be NULL.
    void (*place)(const void *params, const Ray *ray, const ShapeHit *hit, ShapePoint *out);
    // HOLD_FLAT: 3 or 4 corners, in order; returns how many.
    int (*corners)(const void *params, Vec3 out[4]);
    // Surface area under `to_world` (its linear part; non-uniform scaling counts), for emitters.
    double (*area)(const Scene *scene, const void *params, const Affine *to_world);
    // A point uniform by area in the world under `to_world`, from three numbers in [0,1); pdf by
    // world area, thus 1 / area; the point's fields are in the world. `table` is what
    // prepare_sampling made (NULL: the same, more slowly; not for meshes).
    void (*sample_area)(const Scene *scene, const void *params, const Affine *to_world,
                        const void *table, double u0, double u1, double u2, ShapeSample *out);
    // Better than by area where it can be: by solid angle seen from `reference` (world). NULL, or
    // false where it doesn't apply (reference on or inside, non-uniform transform): the caller then
    // uses sample_area. pdf by solid angle.
    // `table` as there.
    bool (*sample_solid_angle)(const void *params, const Affine *to_world, const void *table,
                               Vec3 reference, double u0, double u1, ShapeSample *out);
    // What the two above choose for a light that emits alike everywhere: the point alone, by solid
    // angle where sample_solid_angle would, else by area. `table` is there. NULL, or false where it
    // can't: the same, by way of them.
    bool (*aim)(const void *params, const Affine *to_world, const void *table, Vec3 reference,
                double u0, double u1, ShapeAim *out);
    // The solid-angle pdf with which sample_solid_angle would choose `direction` (unit, world) that
    // hits the shape; 0 where it wouldn't apply.
    double (*solid_angle_pdf)(const void *params, const Affine *to_world, const void *table,
                              Vec3 reference, Vec3 direction);
    // A table for sampling (areas of a mesh's triangles, a rectangle in the world), in `arena`;
    // NULL when memory runs out. NULL function: none needed.
    void *(*prepare_sampling)(const Scene *scene, const void *params, const Affine *to_world,
                              Arena *arena);
} ShapeClass;

// The class of a shape node.
const ShapeClass *shape_class(const Scene *scene, const SceneNode *node);

#endif
