// How surfaces scatter and emit light: one file a kind in materials/, one row in nodes.def.
//
// The contract is that of Nori (Jakob): sample, eval and pdf, which a chi-squared test holds to
// each other. Directions are unit, point away from the surface and are given in the shading frame:
// z along the shading normal, which lies on the front side of the surface whichever side is seen.
// So wo.z > 0 means that the front is seen, and a material tells its sides by signs.
//
// Opaque materials (lambert and all that say nothing else) look the same from both sides. Which
// side `emissive`, `two_sided` and glass mean is decided by the geometric normal.
#ifndef RENDER_MATERIAL_H
#define RENDER_MATERIAL_H

#include "render/accel.h"
#include "render/disc.h"
#include "render/medium.h"

struct World;

// What a material may do; the union over its lobes and those of the materials inside it.
typedef enum MaterialLobes {
    LOBE_REFLECT = 1,  // to the viewer's side
    LOBE_TRANSMIT = 2, // to the other side
    LOBE_SMOOTH = 4,   // spread over directions: eval and pdf are not zero, lights can be sampled
    LOBE_DELTA = 8,    // single directions: only sample finds them
    LOBE_PASS = 16,    // lets light pass as if nothing were there: see MaterialClass.pass
    LOBE_EMIT = 32,    // emits: shapes of this material are lights
} MaterialLobes;

// Room that is always enough for the delta lobes of one surface in practice.
enum { DELTA_ROOM = 8 };

// The part of a material in a stack of layers.
typedef enum MaterialLayer {
    LAYER_NONE, // alone, or at the bottom
    // A coat, seen from either of its sides: `ggx` lets through what it doesn't reflect.
    LAYER_COAT,
    // The same, and sample and pdf concern the one part alone, where the material can do so.
    LAYER_REFLECT,
    LAYER_TRANSMIT,
} MaterialLayer;

// A point to be shaded, seen from a direction.
typedef struct ShadingPoint {
    const struct World *world;
    const Surface *surface;
    Frame frame;    // world; n the shading normal (bent where wo would see its back), s along dp/du
    Vec3 geometric; // the geometric normal, in the frame
    Vec3 wo;        // to the viewer, in the frame
    double wo_side; // wo · geometric: > 0 from the front
    bool bent;      // the frame's n isn't the geometric normal
    double outside; // index of refraction on the front side, as the integrator's MediumStack knows
                    // it; 0: what the material says
    MaterialLayer layer;
} ShadingPoint;

typedef struct BsdfEval {
    Rgb value; // f(wo, wi) |wi.z|, 1/sr
    float pdf; // with which sample chooses wi, 1/sr
} BsdfEval;

typedef struct BsdfSample {
    Vec3 wi;        // in the frame
    Rgb weight;     // f |wi.z| / pdf; for a delta lobe its albedo over the chance to choose it
    float pdf;      // 1/sr; for a delta lobe the chance that it was chosen
    float eta;      // index of refraction on wi's side over that on wo's side; 1 when reflected
    uint32_t lobes; // the MaterialLobes of the lobe chosen
} BsdfSample;

// The three terms of the slides' simplified model (equation 3) for one light: what a light of
// brightness 1 in direction l adds to what the viewer sees.
typedef struct LocalTerms {
    Rgb ambient, diffuse, specular; // f_am, f_dl, f_ph: equations (4) to (7)
} LocalTerms;

typedef struct MaterialClass {
    NodeType node; // first: a MaterialClass is a NodeType
    bool whole; // asks of the surface more than accel_surface_plain gives, whatever its parameters
    // The lobes of a material with these parameters. Materials inside are asked by material_lobes.
    uint32_t (*lobes)(const struct World *world, const void *params);
    // Smooth lobes only; no side test is needed here, material_eval has made it.
    void (*eval)(const ShadingPoint *point, const void *params, Vec3 wi, BsdfEval *out);
    // Chooses wi from three numbers in [0, 1): `lobe` for choosing among lobes, u and v for the
    // direction. False: nothing is scattered.
    bool (*sample)(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out);
    // All delta lobes at once, for integrators that follow each of them: weight is then the lobe's
    // albedo and pdf 1. At most `room` (DELTA_ROOM); returns how many, or -1 where there are more
    // or they aren't known. NULL: none, or they have to be found by `sample`.
    int (*deltas)(const ShadingPoint *point, const void *params, BsdfSample *out, int room);
    // About how much of the light from all around is reflected, for the albedo picture.
    Rgb (*albedo)(const ShadingPoint *point, const void *params);
    // Radiance (W/m²/sr) that the surface emits to the side given by surface->front. NULL: none.
    Rgb (*emitted)(const struct World *world, const void *params, const Surface *surface);
    // About the mean over the surface of what is emitted from the front, for choosing lights. NULL:
    // none.
    Rgb (*emitted_mean)(const struct World *world, const void *params);
    // The part of light that passes straight through, for shadow rays (cut-outs). NULL: none.
    Rgb (*pass)(const struct World *world, const void *params, const Surface *surface);
    // What fills the back side, for closed surfaces of glass. False (or NULL): nothing.
    bool (*medium)(const struct World *world, const void *params, Medium *out);
    // For the `local` integrator; l is unit, in the frame. NULL: see material_local.
    LocalTerms (*local)(const ShadingPoint *point, const void *params, Vec3 l);
    // A law (of energy, or reciprocity) that the model breaks by construction: for who tests it.
    // NULL: none.
    const char *caveat;
} MaterialClass;

// A MaterialClass.eval of a function that returns what it finds: four floats in two registers are
// packed by way of memory, which stalls the processor, where they aren't inlined.
#define MATERIAL_EVAL(function)                                                                    \
    static void function##_into(const ShadingPoint *point, const void *params, Vec3 wi,            \
                                BsdfEval *out)                                                     \
    {                                                                                              \
        *out = function(point, params, wi);                                                        \
    }

// A material of the world, resolved: world->materials[id], and [material_count] the default one.
typedef struct WorldMaterial {
    const MaterialClass *class;
    const void *params;
    uint32_t lobes;
    bool whole;           // needs whole surfaces: textures, directions along them
    bool is_even;         // matt, of the same albedo everywhere: `albedo`
    Rgb albedo;           // in [0, 1]
    const Medium *medium; // on the back side; or NULL
} WorldMaterial;

// Makes the point ready; `direction` is the ray's, unit, in the world. A shading normal whose back
// faces the viewer while the surface's front does (at a grazing angle on a coarse smooth mesh) is
// bent until it just faces the viewer, so that no black specks appear there.
static inline void shading_point(const struct World *world, const Surface *surface, Vec3 direction,
                                 ShadingPoint *out);
// The same point in another shading frame (normal and bump maps): `normal` and `tangent` are in the
// world, normal is unit and on the geometric front.
void shading_point_bend(const ShadingPoint *point, Vec3 normal, Vec3 tangent, ShadingPoint *out);

// The material `id` (NONE_ID: the default). These are also what nested materials call for theirs.
//
// Light leaks: where a direction's side of the surface by the shading normal and by the geometric
// normal differ, the material neither reflects nor transmits (Veach 1997, 5.3).
uint32_t material_lobes(const struct World *world, uint32_t id);
// Whether the material asks of surfaces what accel_surface_plain doesn't give.
bool material_needs_whole(const struct World *world, uint32_t id);
BsdfEval material_eval(const ShadingPoint *point, uint32_t id, Vec3 wi);
bool material_sample(const ShadingPoint *point, uint32_t id, float lobe, float u, float v,
                     BsdfSample *out);
// The same for a material that is known already.
void material_evaluate(const ShadingPoint *point, const WorldMaterial *material, Vec3 wi,
                       BsdfEval *out);
bool material_choose(const ShadingPoint *point, const WorldMaterial *material, float lobe, float u,
                     float v, BsdfSample *out);
// The delta lobes as MaterialClass.deltas gives them: 0 for a material without any, -1 where only
// `sample` can tell.
int material_deltas(const ShadingPoint *point, uint32_t id, BsdfSample *out, int room);
Rgb material_albedo(const ShadingPoint *point, uint32_t id);
Rgb material_emitted(const struct World *world, uint32_t id, const Surface *surface);
Rgb material_emitted_mean(const struct World *world, uint32_t id);
Rgb material_pass(const struct World *world, uint32_t id, const Surface *surface);
bool material_medium(const struct World *world, uint32_t id, Medium *out);
// The terms of the slides' simplified model. A material that doesn't say otherwise has no ambient
// term there, and π times its BRDF and cosine as the specular one, so that Lambert's k/π is the
// slides' k C max(0, n·l); delta lobes show nothing.
LocalTerms material_local(const ShadingPoint *point, uint32_t id, Vec3 l);

// The part of shading_point for surfaces whose shading normal is bent.
void shading_point_bent(const Surface *surface, Vec3 direction, ShadingPoint *out);

static inline void shading_point(const struct World *world, const Surface *surface, Vec3 direction,
                                 ShadingPoint *out)
{
    out->world = world;
    out->surface = surface;
    out->outside = 0;
    out->layer = LAYER_NONE;
    if (surface->bent) {
        shading_point_bent(surface, direction, out);
        return;
    }
    out->frame = surface->whole ? frame_from_tangent(surface->geometric, surface->tangent)
                                : frame_from_normal(surface->geometric);
    out->wo = to_local(&out->frame, neg(direction));
    out->geometric = vec3(0, 0, 1);
    out->wo_side = out->wo.z;
    out->bent = false;
}

#endif
