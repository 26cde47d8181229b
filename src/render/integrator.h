// What finds the radiance along a ray: one file a kind in integrators/, chosen by
// `render { integrator: … }`.
#ifndef RENDER_INTEGRATOR_H
#define RENDER_INTEGRATOR_H

#include "render/accel.h"
#include "render/sampler.h"
#include "render/world.h"

// What the first hit says, for the arbitrary output variables; left as it is when nothing is hit.
typedef struct AovSample {
    Rgb albedo;
    Vec3 normal, position;
    double depth;              // along the camera's axis is the camera's business; here: distance
    uint32_t object, material; // id + 1; 0: nothing
} AovSample;

typedef struct IntegratorStats {
    uint64_t rays, shadow_rays, bad_samples; // bad: not finite or negative; counted and left out
} IntegratorStats;

typedef struct IntegratorClass {
    const char *name; // as in render { integrator: "path" }
    const char *doc;
    const char *example; // a scene
    // Incoming radiance along `ray` (W/m²/sr, linear Rec.709).  `aov` may be NULL. Thread-safe.
    Rgb (*radiance)(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                    IntegratorStats *stats);
    // It in parts, for films. `lamps` is what lights emit along the ray themselves; `for_film` is
    // the whole, or what remains without that, for pixels in which lamps' edges are seen (lamps.h),
    // and *indirect what of it comes by chance from afar (share.h). NULL: it isn't found in parts.
    Rgb (*lamps)(const World *world, const Ray *ray, Sampler *sampler, IntegratorStats *stats);
    Rgb (*for_film)(const World *world, const Ray *ray, Sampler *sampler, bool lamps_apart,
                    AovSample *aov, Rgb *indirect, IntegratorStats *stats);
    bool photons; // it leaves to photons (photons.h) what World.photon_lights tells it to
    // Reports what the integrator leaves out of this world, before anything is rendered; NULL:
    // nothing.
    void (*check)(const World *world, DiagSink *sink);
} IntegratorClass;

// INTEGRATOR(id) rows of nodes.def, NULL at the end.
extern const IntegratorClass *const integrator_classes[];

#endif
