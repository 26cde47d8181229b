// The accelerator's inside: the scene sorted into groups (accel_collect.c, without Embree), their
// hierarchies (accel_embree.c, nothing but Embree) and the surfaces at hits (accel_surface.c).
//
// A group is geometry that shares one space and one hierarchy: a prototype, the world being the
// first, or a pocket: a mesh so small beside its prototype that single precision would show there,
// or all that is of a smaller scale than a few outliers (a sun at its distance). Within a group
// Embree sees coordinates (p - center) / scale in [-1, 1], so that single precision is as good at
// every size and place. Instances and pockets are primitives of one user geometry each, through
// which the ray goes on in double precision: a million instances are one geometry.
//
// Single precision proposes, double precision decides. Embree holds every triangle a little larger
// than it is (FLAT_GROWTH), so that a ray aimed at a vertex, where single precision would miss all
// triangles around it now and then, is given one. Each triangle proposed is tested in double
// precision by accel_flat_hit, without gaps between neighbours: a ray that starts by rounding
// errors of double precision off a triangle doesn't hit it again. Where the line passes beside the
// triangle in double precision, the proposal is doubtful: either the ray does pass, or it runs so
// flat that single precision has taken a neighbour of the triangle that is hit. A doubtful hit
// counts where no certain one is found near it, and not near the ends of the ray; so closed
// surfaces stay closed, as Embree holds them. Curved shapes are intersected in double precision by
// their kinds, within boxes grown by BOX_MARGIN.
//
// What single precision can still do wrong, in parts of the group's size: a triangle may be hit by
// a ray that passes within FLAT_DOUBT of its edge, further from the ray's ends than FLAT_CERTAIN;
// of two surfaces nearer to each other than about 2^-21 the wrong one may come first; and a ray
// that meets a triangle at a cosine below RAY_LEAST_COSINE, or within FLAT_CERTAIN of its start,
// may pass through if it starts nearer to the triangle's plane, or meets it nearer to its edge,
// than about 2^-19.
#ifndef RENDER_ACCEL_PARTS_H
#define RENDER_ACCEL_PARTS_H

#include "render/accel.h"
#include "render/geometry.h"

// All in Embree's coordinates.
// By how much the edges of triangles are moved outwards: more than the rounding of vertices and of
// the ray's origin (2^-24 of at most 1 and 2), of its direction (over at most 2 sqrt(3)), and of
// the test (a few roundings of terms of that size).
#define FLAT_GROWTH 0x1p-19
// Corners sharper than this sine of half their angle are moved less than that asks.
#define FLAT_SHARPEST 0x1p-10
// A doubtful hit lies beside the ray by no more than this.
#define FLAT_DOUBT 0x1p-21
// A doubtful hit must be this far from both ends of the ray: a surface's neighbour, grown, stands
// in the way of a ray that starts beside it.
#define FLAT_CERTAIN (16 * FLAT_GROWTH)
// How far the float ray is begun before, and ended after, the true one: the distance along the ray
// that corresponds to an error across the triangle's plane of FLAT_GROWTH / 2 at the least cosine.
// What it meets on the way to the true beginning costs a test in double precision each.
#define RAY_LEAST_COSINE 0x1p-9
#define RAY_MARGIN       (FLAT_GROWTH / 2 / RAY_LEAST_COSINE)
// How much boxes are grown: the float ray's distance from the true one.
#define BOX_MARGIN 0x1p-21
// A mesh smaller than this part of its group gets a pocket.
#define POCKET_SIZE 0x1p-5
// Flat shapes with an edge shorter than this part of their group are intersected in double.
#define FLAT_SIZE 0x1p-10

typedef struct AccelGroup AccelGroup;

// Shapes of one kind in one group.
typedef struct AccelKind {
    const Accel *accel;
    const AccelGroup *group;
    const ShapeClass *class;
    const char *params;  // scene's table of the kind
    const uint32_t *ids; // shape ids
    uint32_t count;
    bool native;        // triangles of Embree's: flat shapes, or one mesh
    int corners;        // flat shapes: 3, or 4, which are two triangles
    const Mesh *mesh;   // the one mesh, or NULL
    uint32_t transform; // of the mesh
} AccelKind;

struct AccelGroup {
    const Accel *accel;
    Vec3 center;
    double scale;            // a power of 2
    double inverse_scale;    // thus exact
    Box3 bounds;             // of the bounded geometry, in the group's space
    AccelKind *kinds;        // a geometry each, numbered alike in Embree's scene
    uint32_t kind_count;     // then follow, where there are any, …
    uint32_t *pockets;       // … one geometry of the group's pockets: group numbers
    uint32_t pocket_count;   //
    uint32_t instance_count; // … and one of the world's instances: all of them, or none
    void *hierarchy;         // RTCScene; NULL: the group has no bounded geometry
};

// An unbounded shape, in the world or in an instance.
typedef struct AccelUnbounded {
    uint32_t shape, instance;
} AccelUnbounded;

struct Accel {
    const Scene *scene;
    void *device;   // RTCDevice
    SpaceMap *maps; // of the first map_count of the scene's transforms
    size_t map_count;
    AccelGroup *groups; // one for each prototype, then the pockets
    uint32_t group_count;
    uint32_t *order; // shape ids, by prototype and kind
    AccelUnbounded *unbounded;
    uint32_t unbounded_count;
    AccelIssues issues;
};

// Sorts the scene's shapes into groups. False when memory runs out.
bool accel_collect(Accel *accel);
// Fills accel->maps. False when memory runs out.
bool accel_keep_maps(Accel *accel);
void accel_collect_free(Accel *accel);

// Group coordinates of a box, grown by BOX_MARGIN and rounded outwards: {lower, upper}. False where
// the box is empty or not finite.
bool accel_float_box(const AccelGroup *group, Box3 box, float lower[3], float upper[3]);
// The box of a shape in its group's space.
Box3 accel_shape_box(const Scene *scene, const SceneNode *node);
// The box of an instance in the world; empty where the prototype has no bounded geometry.
Box3 accel_instance_box(const Accel *accel, uint32_t instance);

// The ray in the space of an instance, or of a shape: origin and direction mapped, t the same.
static inline Ray ray_map(const Affine *inverse, const Ray *ray)
{
    return (Ray){transform_point(inverse, ray->origin), transform_vector(inverse, ray->direction),
                 ray->tmin, ray->tmax};
}
static inline Ray accel_shape_ray(const Scene *scene, const SceneNode *node, const Ray *ray)
{
    return node->transform == 0 ? *ray : ray_map(&scene->inverses.items[node->transform], ray);
}

// The shape that a native triangle is of, and its primitive there.
static inline uint32_t accel_native_shape(const AccelKind *kind, uint32_t triangle,
                                          uint32_t *primitive)
{
    *primitive = kind->mesh ? triangle : 0;
    return kind->ids[kind->mesh ? 0 : kind->corners == 4 ? triangle / 2 : triangle];
}
// A ray made ready for flat shapes: in the space of all those with one transform.
typedef struct FlatRay {
    Ray ray;              // tmax is not used
    double slope[2];      // direction[next[i]] / direction[longest]
    int longest, next[2]; // axes
    uint32_t transform;   // NONE_ID: not made ready yet
} FlatRay;
void flat_ray_prepare(const Scene *scene, uint32_t transform, const Ray *ray, FlatRay *out);

// Whether the ray meets a native shape's primitive in double precision, with ray->tmin < t < tmax;
// or, where it meets the primitive's plane beside it, whether it comes within FLAT_DOUBT of it:
// *hit is then the nearest point of the primitive's edges, and the nearest t. `flat` is of the
// shape's transform.
typedef enum FlatHit { FLAT_MISSED, FLAT_BESIDE, FLAT_INSIDE } FlatHit;
FlatHit accel_flat_hit(const AccelKind *kind, uint32_t shape, uint32_t primitive,
                       const FlatRay *flat, double tmax, ShapeHit *hit);

// Tests the unbounded shapes; the nearest before ray->tmax.
bool accel_unbounded_hit(const Accel *accel, const Ray *ray, Hit *hit);

// The part of [tmin, tmax] of the ray inside the box grown by `margin`; false where there is none.
bool ray_clip(const Ray *ray, Box3 box, double margin, double *tmin, double *tmax);

#endif
