// Where light comes from: one file a kind in lights/, one row in nodes.def; and the choice among a
// scene's lights.
//
// Every kind's sample says from which direction light may come to a reference point, how much, and
// with which density; integrators do the rest (visibility, scattering, weights), so that a light of
// any law (attenuation, cones, tables) is one function.
#ifndef RENDER_LIGHT_H
#define RENDER_LIGHT_H

#include "base/diag.h"
#include "render/accel.h"

struct World;
typedef struct LightClass LightClass;
typedef struct LightSet LightSet;

// Where a light shines (Conty Estevez and Kulla 2018): its surface's normals lie within an angle
// `normals` about `axis`, and from each point nothing is emitted farther than `emission` from the
// normal there. `normals` = π: in all directions. Of a light at infinity, which shines into one
// direction: where it is seen, `normals` about the direction `axis` to it.
typedef struct LightCone {
    Vec3 axis; // unit
    double normals, emission;
} LightCone;

// One source of light: a light node, or a shape (of an instance, perhaps) with an emitting
// material.
typedef struct Light {
    const LightClass *class;
    const void *params; // of the light node; NULL for a shape with an emitting material
    void *data;         // made by prepare, in the set's arena
    uint32_t node;      // light id, or NONE_ID
    uint32_t shape;     // shapes: id, else NONE_ID
    uint32_t instance;  // shapes: instance, or NONE_ID
    Affine to_world;    // the light node's or the shape's
    double power;       // luminance of the emitted flux in W; 0: never chosen for sampling
    Box3 bounds;        // of the emitting points, in the world; empty for infinite lights
    // For the choice among lights. Luminance of the intensity in its brightest direction, W/sr; of
    // infinite lights the irradiance, W/m².
    double intensity;
    LightCone cone;
    bool delta; // no ray finds it, though its class is one of infinite lights
    bool parts; // sample needs its third number, of more than 24 bits
    bool whole; // emitted asks of a surface more than accel_surface_plain gives
} Light;

// The point that is to be lit.
typedef struct LightReceiver {
    Vec3 p;
    Vec3 normal; // unit: only light from its side counts; (0, 0, 0): light from all around does
} LightReceiver;

// Whether all of a light's points lie where no light counts. Infinite lights have no points.
static inline bool light_is_behind(const Light *light, const LightReceiver *at)
{
    const Vec3 center = box3_center(light->bounds);
    const Vec3 half = sub(light->bounds.max, center);
    return dot(at->normal, sub(center, at->p)) + dot(vec3_abs(at->normal), half) < 0;
}

// What reaches a reference point from a light, were nothing in between.
typedef struct LightSample {
    Vec3 direction;  // unit, from the reference point
    double distance; // INFINITY for lights at infinity
    Vec3 point;      // on the light, where distance is finite
    double error;    // bound on that point's distance from the true surface
    uint32_t target; // 1 + that shape, where it is flat and in the world; else 0
    double facing;   // where that surface is flat: cosine between its normal and the way; else 0
    Rgb value;       // delta: irradiance on a surface facing the light, W/m²; else the radiance
    float pdf;       // by solid angle, of the direction given this light; 1 for delta
    bool delta;      // no ray hits this light by chance: it must be sampled
} LightSample;

// Where light leaves a light. Of an infinite light: in which direction it travels.
typedef struct LightOrigin {
    ShapeSample surface; // of a shape, in the world, else only .point.p is set
    bool point;          // has no surface
    bool infinite;
    Vec3 direction; // infinite: unit
    double pdf;     // by area; infinite: by solid angle; 1 where there is but one
} LightOrigin;

// What a light's prepare is given; it fills light->data, power, bounds, intensity and cone (which
// is in all directions if left alone).
typedef struct LightPrepare {
    struct World *world; // accelerator and textures are ready
    Light *light;
    Arena *arena;
    DiagSink *sink;
    Span at;
} LightPrepare;

struct LightClass {
    NodeType node; // first: a LightClass is a NodeType
    bool infinite; // rays that leave the scene see it: see `escaped`
    // False after a report.
    bool (*prepare)(const LightPrepare *prepare);
    // Chooses a direction from three numbers in [0, 1). False: nothing comes from there.
    bool (*sample)(const struct World *world, const Light *light, Vec3 reference, double u0,
                   double u1, double u2, LightSample *out);
    // The density with which sample, seen from `reference`, chooses the unit direction that was
    // found to lead to `hit` on this light (NULL: into infinity). NULL for delta lights.
    float (*pdf)(const struct World *world, const Light *light, Vec3 reference, Vec3 direction,
                 const Surface *hit);
    // The radiance seen at `hit`, on this light, by a ray. NULL where a ray can't hit it.
    Rgb (*emitted)(const struct World *world, const Light *light, const Surface *hit);
    // The radiance along a ray that leaves the scene; and in *pdf (unless that is NULL) what pdf
    // says of its direction. NULL unless infinite.
    Rgb (*escaped)(const struct World *world, const Light *light, Vec3 direction, float *pdf);
    // For paths that begin at lights: chooses an origin from three numbers in [0, 1). NULL: no path
    // begins at lights of this kind.
    bool (*begin)(const struct World *world, const Light *light, double u0, double u1, double u2,
                  LightOrigin *out);
    // What leaves it in a unit direction, in W/sr, per m² where the origin has a surface; of an
    // infinite light in W/m², per sr unless it is delta, whatever the direction.
    Rgb (*leaving)(const struct World *world, const Light *light, const LightOrigin *origin,
                   Vec3 direction);
};

// All lights of the world, and the tables for choosing. NULL after a report. `arena` keeps them.
LightSet *light_set_build(struct World *world, Arena *arena, DiagSink *sink);
void light_set_free(LightSet *set);
size_t light_set_count(const LightSet *set);
const Light *light_set_get(const LightSet *set, size_t index);
const Light *light_set_items(const LightSet *set);
// The light that light_choose chooses for all points; NONE_ID where there are none or several.
uint32_t light_set_only(const LightSet *set);
// The attenuation, falloff or shape of a light with these parameters (NULL: none): the node of its
// first field of that category, or NONE_ID.
uint32_t light_node_of(const NodeType *type, const void *params, Category category);
// The lights at infinity that rays can see, one after another: indices of lights; *count of them.
const uint32_t *light_set_infinite(const LightSet *set, uint32_t *count);

// Chooses a light for a point by a number in [0, 1), of more than 24 bits where there are many
// lights: its index, and the chance of it in *chance. NONE_ID where nothing shines on the point.
uint32_t light_choose(const LightSet *set, const LightReceiver *at, double u, float *chance);
// The chance with which light_choose takes `light`.
float light_chance(const LightSet *set, const LightReceiver *at, uint32_t light);
// The ray from a surface to the light's point, or into infinity. Filled in place: a copy would be
// waited for (vec3_apart).
static inline void light_sample_ray(const Surface *surface, const LightSample *sample, Ray *out);
// The part of it for lights at infinity.
void light_infinite_ray(const Surface *surface, const LightSample *sample, Ray *out);
// The index of the light that a hit surface is, or NONE_ID.
uint32_t light_of_surface(const struct World *world, const Surface *surface);

// --- Inline --------------------------------------------------------------------------------------

static inline void light_sample_ray(const Surface *surface, const LightSample *sample, Ray *out)
{
    if (!(sample->distance < INFINITY)) {
        light_infinite_ray(surface, sample, out);
        return;
    }
    *out =
        surface_spawn_to(surface, sample->point, sample->distance, sample->error, sample->facing);
    out->ends.target = sample->target;
}

#endif
