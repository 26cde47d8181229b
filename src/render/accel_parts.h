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
// Flat pieces of surface (triangles, parallelograms, plane quadrilaterals of meshes) stand in one
// table, but for those of large meshes. The few or the largest of a group, walls above all, are
// swept (accel_sweep.c): each ray is tried on all of them at once in vectors of single precision,
// whose errors are bounded, and what may be hit is decided in double precision. Neighbours overlap
// by their errors, so that no ray passes between them.
//
// All else goes through Embree, and most rays take the fast way there (accel_trace.c): Embree finds
// the nearest flat piece or curved shape in single precision, and what it finds is met again in
// double precision. Where that doesn't agree, and for rays that start too near to the edges of one
// of Embree's pieces or leave it too flat, the careful way is taken instead (accel_careful.c).
//
// The fast way. A ray that leaves a flat piece is lifted off it by FLAT_LIFT in single precision,
// so that it doesn't meet the piece again; it leaves at a cosine of at least LIFT_LEAST_COSINE, and
// from farther inside the piece's edges than FLAT_INSET, where no neighbour stands so near that the
// lift could bring the ray beyond it, or that its grown edge could stand in the way. A ray to a
// point on a surface ends before it by FLAT_LIFT along the surface's normal. All else starts and
// ends where it does.
//
// The careful way: single precision proposes, double precision decides. Embree holds every piece a
// little larger than it is (FLAT_GROWTH), so that a ray aimed at a vertex, where single precision
// would miss all pieces around it now and then, is given one. Each piece proposed is tested in
// double precision by accel_flat_hit, without gaps between neighbours: a ray that starts by
// rounding errors of double precision off a piece doesn't hit it again. Where the line passes
// beside the piece in double precision, the proposal is doubtful: either the ray does pass, or it
// runs so flat that single precision has taken a neighbour of the piece that is hit. A doubtful hit
// counts where no certain one is found near it, and not near the ends of the ray; so closed
// surfaces stay closed, as Embree holds them. Curved shapes are intersected in double precision by
// their kinds in both ways, within boxes grown by BOX_MARGIN.
//
// What single precision can still do wrong with Embree's pieces, in parts of the group's size: one
// may be hit, or may throw a shadow, where a ray passes within FLAT_GROWTH of its edge (within
// FLAT_DOUBT, and further from the ray's ends than FLAT_CERTAIN, where a hit is asked for); of two
// surfaces nearer to each other than about 2^-20 the wrong one may come first, and what lies nearer
// than that to a lamp's surface throws no shadow in its light; outlines are off by as much; and a
// ray that meets a piece at a cosine below RAY_LEAST_COSINE, or within FLAT_CERTAIN of its start,
// may pass through if it starts nearer to the piece's plane, or meets it nearer to its edge, than
// about 2^-19.
#ifndef RENDER_ACCEL_PARTS_H
#define RENDER_ACCEL_PARTS_H

#include "render/accel.h"
#include "render/geometry.h"
#include "render/sweep_kernel.h"

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
// How much boxes are grown: the float ray's distance from the true one, and the rounding of
// Embree's own test.
#define BOX_MARGIN 0x1p-19
// How far a ray is lifted off the flat piece that it leaves, along the piece's normal: more than
// the error of the distance from a plane in single precision, some 2^-22 times the piece's size, up
// to 2 sqrt(2).
#define FLAT_LIFT 0x1p-20
// The flattest rays that are lifted.
#define LIFT_LEAST_COSINE 0x1p-5
// The nearest to an edge: from there even the flattest such ray passes over the edge of a
// neighbour, grown by FLAT_GROWTH, that stands across.
#define FLAT_INSET (FLAT_GROWTH / LIFT_LEAST_COSINE)
// Thin pieces, of a smaller sine between two edges, are left to the careful way: their planes are
// less certain.
#define LIFT_LEAST_SINE 0x1p-2
// A mesh smaller than this part of its group gets a pocket.
#define POCKET_SIZE 0x1p-5
// Flat shapes with an edge shorter than this part of their group are intersected in double.
#define FLAT_SIZE 0x1p-10
// Meshes of no more triangles are kept in the table of flat pieces, and so many pieces in all.
#define TABLE_MESH  4096
#define TABLE_COUNT 65536
// Of a group of more than SWEEP_MOST pieces only the largest are swept, half as many at most, whose
// boxes' surfaces are no smaller than this part of the group's box.
#define SWEEP_AREA 0.0625
typedef struct AccelGroup AccelGroup;

// The sweep as one kind of processor has it: a ray against a group that has nothing else, the way
// to the group's coordinates and the kernel in one function (accel_sweep_ways.c).
typedef struct SweepWay {
    SweepKernel *kernel;
    // The nearest piece that is met before ray->tmax.
    bool (*intersect)(const AccelGroup *group, const Ray *ray, uint32_t instance, Hit *hit);
    bool (*occluded)(const AccelGroup *group, const Ray *ray, uint32_t instance);
} SweepWay;

// The balls of a run in Embree's coordinates, in single precision: what passes them by farther than
// BALL_MARGIN misses them for certain. Those that a run of fewer lacks are far away, and have a
// negative radius.
enum { RUN_LONGEST = 4 };
typedef struct BallRun {
    float x[RUN_LONGEST], y[RUN_LONGEST], z[RUN_LONGEST], radius[RUN_LONGEST];
} BallRun;
// As BOX_MARGIN, with the rounding of a distance of two points up to 4 apart.
#define BALL_MARGIN 0x1p-18

// Shapes of one kind in one group.
typedef struct AccelKind {
    const Accel *accel;
    const AccelGroup *group;
    const ShapeClass *class;
    const char *params;  // scene's table of the kind
    const uint32_t *ids; // shape ids
    uint32_t count;
    uint32_t *runs; // curved shapes: the first of each run (accel_runs.c), and `count`; NULL: none
    uint32_t run_count;
    // Balls in the group's space whose parameters follow one another as they do: `row` is the first
    // one's, and each run has a filter. NULL: they aren't.
    const char *row;
    BallRun *balls; // within balls_memory
    void *balls_memory;
    bool native;        // triangles of Embree's: flat shapes, or one mesh
    bool tabled;        // native, and in the table of flat pieces: it has no geometry of its own
    int corners;        // flat shapes: 3 or 4
    const Mesh *mesh;   // the one mesh, or NULL
    uint32_t transform; // of the mesh
    uint32_t first;     // number of the mesh's first triangle among all flat pieces
    double inset;       // FLAT_INSET in the mesh's own space
} AccelKind;

// The primitives of a kind of curved shapes, and their shapes: from the first to before the end.
static inline uint32_t accel_primitive_count(const AccelKind *kind)
{
    return kind->runs ? kind->run_count : kind->count;
}
static inline uint32_t accel_run_begin(const AccelKind *kind, uint32_t primitive)
{
    return kind->runs ? kind->runs[primitive] : primitive;
}

// A flat piece of surface in its group's space: the points corner + s u + t v with s, t,
// 1 - s - over_s t and 1 - t - over_t s >= 0. over_s = over_t = 0 makes a parallelogram, 1 a
// triangle.
typedef struct AccelFlat {
    Vec3 corner, u, v;
    Vec3 normal;           // unit, towards the front
    Vec3 along_u, along_v; // s = along_u · (p - corner), t = along_v · (p - corner)
    double over_s, over_t;
    double error; // bound on the distance of points so found from the true surface
    double steep; // how much, at most, one of the four numbers grows over a length of 1
    const AccelKind *kind;
    uint32_t shape, primitive;
    uint32_t material; // of surfaces in the world
    float inset;       // FLAT_INSET, in those numbers; INFINITY where the piece is too thin
    bool four;         // corners
    bool pair;         // four corners, of two triangles of a mesh: `primitive` and the next
    bool smooth;       // the shading normal isn't the piece's
    bool lamp;         // as in Surface
    bool swept;
} AccelFlat;

// The numbers of a group's geometries: its flat pieces that aren't swept, then those kinds that
// aren't tabled in their order, then the pockets and the instances.
enum { GEOMETRY_QUADS, GEOMETRY_TRIANGLES, GEOMETRY_KINDS };

struct AccelGroup {
    const Accel *accel;
    Vec3 center;
    double scale;         // a power of 2
    double inverse_scale; // thus exact
    Box3 bounds;          // of the bounded geometry, in the group's space
    void *hierarchy;      // RTCScene; NULL: the group has nothing for it
    // Its pieces in the accelerator's table: those that are swept, then quads, then triangles.
    uint32_t first_flat, sweep_count, quad_count, triangle_count;
    SweepBlock *sweep; // within sweep_memory
    void *sweep_memory;
    const SweepWay *way;                 // never NULL, whatever there is to sweep
    uint32_t first_mesh, mesh_triangles; // the numbers of its other meshes' triangles
    AccelKind *kinds;
    uint32_t kind_count;
    const AccelKind **geometries; // the kinds that aren't tabled
    uint32_t geometry_count;      // then follow, where there are any, …
    uint32_t *pockets;            // … one geometry of the group's pockets: group numbers
    uint32_t pocket_count;        //
    uint32_t instance_count;      // … and one of the world's instances: all of them, or none
};

// An unbounded shape, in the world or in an instance.
typedef struct AccelUnbounded {
    uint32_t shape, instance;
} AccelUnbounded;

struct Accel {
    const Scene *scene;
    unsigned threads; // that build
    void *device;     // RTCDevice; NULL: that of all small scenes
    SpaceMap *maps;   // of the first map_count of the scene's transforms
    size_t map_count;
    AccelGroup *groups; // one for each prototype, then the pockets
    uint32_t group_count;
    AccelFlat *flats;
    uint32_t flat_count;
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
    return ray_make(transform_point(inverse, ray->origin),
                    transform_vector(inverse, ray->direction), ray->tmin, ray->tmax);
}
static inline Ray accel_shape_ray(const Scene *scene, const SceneNode *node, const Ray *ray)
{
    return node->transform == 0 ? *ray : ray_map(&scene->inverses.items[node->transform], ray);
}

// Makes runs of the group's curved shapes, where that pays (accel_runs.c). Without memory there are
// none. Shapes that aren't finite, which Embree leaves out, have to stay alone: then there are
// none.
void accel_make_runs(AccelGroup *group);

// --- Flat pieces (accel_flats.c) ----------------------------------------------------------------

// Makes the table of flat pieces and numbers the triangles of other meshes. False when memory runs
// out.
bool accel_tabulate(Accel *accel);
// The number of the first piece of one of a group's geometries.
static inline uint32_t accel_first_flat(const AccelGroup *group, uint32_t geometry)
{
    return group->first_flat + group->sweep_count +
           (geometry == GEOMETRY_TRIANGLES ? group->quad_count : 0);
}
// The test in double precision of a piece that Embree has found: fills all of *hit where the ray
// meets it between its ends.
bool accel_meet_flat(const Accel *accel, uint32_t number, const Ray *ray, uint32_t instance,
                     Hit *hit);
// The same for a triangle of a mesh outside the table.
bool accel_meet_mesh(const AccelKind *kind, uint32_t triangle, const Ray *ray, uint32_t instance,
                     Hit *hit);
// Brings a hit on a piece, as its shape's primitive has it, to the piece's own coordinates, and
// fills what it lacks.
void accel_complete_hit(const Accel *accel, Hit *hit);
// The way back.
ShapeHit accel_primitive_hit(const AccelFlat *flat, const ShapeHit *hit);

// --- The sweep (accel_sweep.c, accel_sweep_ways.c) -----------------------------------------------

// Fills group->sweep from its pieces, and group->way. False when memory runs out.
bool accel_make_sweep(AccelGroup *group);
// The nearest piece that is met before ray->tmax; `local` is the ray in the group's coordinates
// from `begin` on, where t = 1 is `speed`.
bool accel_sweep_intersect(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                           double begin, double speed, uint32_t instance, Hit *hit);
bool accel_sweep_occluded(const AccelGroup *group, const Ray *ray, const SweepRay *local,
                          uint32_t instance);
// All ways that this processor can go, the best last; returns how many.
int accel_sweep_ways(const SweepWay *out[4]);

// --- The careful way (accel_surface.c) ----------------------------------------------------------

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

static inline Vec3 accel_ends_normal(const RayEnds *ends)
{
    return vec3((double)ends->normal[0], (double)ends->normal[1], (double)ends->normal[2]);
}
// Whether the ray leaves one of Embree's flat pieces of this group, as it stands in this instance.
static inline bool accel_leaves_piece(const AccelGroup *group, const Ray *ray, uint32_t instance)
{
    const uint32_t number = ray->ends.flat - 1;
    return ray->ends.flat != 0 && ray->ends.instance == instance &&
           (number - accel_first_flat(group, GEOMETRY_QUADS) <
                group->quad_count + group->triangle_count ||
            number - group->first_mesh < group->mesh_triangles);
}

// Brings a point of a shape's or an instance's space to the next, its error grown by that of the
// way there and back.
void accel_map_out(const Accel *accel, uint32_t transform, ShapePoint *point);

// Surface.material of a shape, in an instance or (NULL) the world.
uint32_t accel_node_material(const SceneNode *node, const SceneInstance *instance);

// Tests the unbounded shapes; the nearest before ray->tmax.
bool accel_unbounded_hit(const Accel *accel, const Ray *ray, Hit *hit);

// The part of [tmin, tmax] of the ray inside the box grown by `margin`; false where there is none.
bool ray_clip(const Ray *ray, Box3 box, double margin, double *tmin, double *tmax);

#endif
