// The simplified illumination model of the slides, equation (3), to the letter:
//
//     L(p, v) = Σ_i S_i [f_am + f_dl + f_ph]
//
// No emission, no indirect light, opaque surfaces; shadows only where `shadows` asks for them, and
// never of the ambient term, which stands for indirect light. Nothing here is chosen at random.
//
// S_i is what the slides' radiance of a light becomes with its attenuation and falloff counted: the
// irradiance (W/m²) that the light gives to a surface that faces it. For a point of intensity I it
// is I f(r) g(θ), for a directional light its irradiance.
#include "render/integrators/surface_hit.h"

#include "render/lights/environment_light.h"

// One light as equation (3) sees it.
typedef struct LocalLight {
    Vec3 l;         // unit, to the light
    Rgb irradiance; // S_i
    LightSample at; // where a shadow ray goes
} LocalLight;

// --- Lights --------------------------------------------------------------------------------------

// A light with a size counts as one without: in the direction of its light vector (Gershun 1936),
// the sum of the radiance over its directions, and with the vector's length as irradiance. The sum
// is over a fixed lattice of places on the light, so that it is the same everywhere and always.
enum { LATTICE = 4 };

// Those places of the lattice that send light to p; returns how many.
static int lattice_samples(const World *world, const Light *light, Vec3 p, LightSample *out)
{
    const int all = LATTICE * LATTICE;
    int count = 0;
    for (int i = 0; i < all; ++i) {
        // The third number, which chooses a part of the light, goes through its values in another
        // order.
        double u = (i % LATTICE + 0.5) / LATTICE, v = ((double)(i / LATTICE) + 0.5) / LATTICE;
        double w = (i * 7 % all + 0.5) / all;
        LightSample *s = &out[count];
        if (light->class->sample(world, light, p, u, v, w, s) && s->pdf > 0) {
            s->value = rgb_scale(s->value, 1 / (s->pdf * (float)all));
            count += !rgb_is_black(s->value);
        }
    }
    return count;
}

static bool sized_light(const World *world, const Light *light, Vec3 p, LocalLight *out)
{
    LightSample samples[LATTICE * LATTICE];
    int count = light->power > 0 ? lattice_samples(world, light, p, samples) : 0;
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < count; ++i) {
        sum = add_scaled(sum, samples[i].direction, (double)luminance(samples[i].value));
    }
    double l = length(sum), nearest = -1;
    if (!(l > 0) || !isfinite(l)) {
        return false;
    }
    out->l = scale(sum, 1 / l);
    out->irradiance = rgb_gray(0);
    for (int i = 0; i < count; ++i) {
        double along = dot(samples[i].direction, out->l);
        out->irradiance = rgb_add(out->irradiance, rgb_scale(samples[i].value, (float)along));
        if (along > nearest) {
            nearest = along;
            out->at = samples[i];
        }
    }
    return true;
}

// What reaches p from a light, were nothing in between. False: nothing.
static bool local_light(const World *world, const Light *light, Vec3 p, LocalLight *out)
{
    if (light->class == &environment_light_light) {
        return false;
    }
    LightSample *s = &out->at;
    if (!light->class->sample(world, light, p, 0.5, 0.5, 0.5, s)) {
        return false;
    }
    if (!s->delta) {
        return sized_light(world, light, p, out);
    }
    out->l = s->direction;
    out->irradiance = s->value;
    return !rgb_is_black(s->value);
}

// --- Surfaces ------------------------------------------------------------------------------------

static Rgb light_passed(const ShadingPoint *point, const LightSample *to, IntegratorStats *stats)
{
    Ray shadow;
    light_sample_ray(point->surface, to, &shadow);
    ++stats->shadow_rays;
    return world_visibility(point->world, &shadow);
}

// Equation (3).
static Rgb reflected(const ShadingPoint *point, IntegratorStats *stats)
{
    const World *world = point->world;
    Rgb sum = rgb_gray(0);
    for (size_t i = 0; i < light_set_count(world->lights); ++i) {
        LocalLight light;
        if (!local_light(world, light_set_get(world->lights, i), point->surface->p, &light)) {
            continue;
        }
        LocalTerms f =
            material_local(point, point->surface->material, to_local(&point->frame, light.l));
        Rgb lit = rgb_add(f.diffuse, f.specular);
        if (world->shadows && !rgb_is_black(lit)) {
            lit = rgb_mul(lit, light_passed(point, &light.at, stats));
        }
        sum = rgb_add(sum, rgb_mul(light.irradiance, rgb_add(f.ambient, lit)));
    }
    return sum;
}

static Rgb radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                    IntegratorStats *stats)
{
    (void)sampler;
    Rgb sum = rgb_gray(0), seen = rgb_gray(1); // seen: what cut-outs have let pass so far
    Ray rest = *ray;
    for (int i = 0; i < MAX_PASSES; ++i) {
        SurfaceHit at;
        if (!surface_hit(world, &rest, stats, &at)) {
            return rgb_add(sum, rgb_mul(seen, world_escaped(world, ray->direction)));
        }
        if (aov && i == 0) {
            aov_fill(&at.hit, &at.point, aov);
        }
        sum = rgb_add(sum, rgb_mul(seen, reflected(&at.point, stats)));
        if (!(surface_lobes(world, &at.surface) & LOBE_PASS)) {
            return sum;
        }
        seen = rgb_mul(seen, material_pass(world, at.surface.material, &at.surface));
        if (rgb_is_black(seen)) {
            return sum;
        }
        rest = surface_spawn(&at.surface, ray->direction);
    }
    return sum;
}

// --- What the model leaves out -------------------------------------------------------------------

static Span light_at(const World *world, const Light *light)
{
    bool node = light->node != NONE_ID;
    return scene_node(world->scene, node ? CATEGORY_LIGHT : CATEGORY_SHAPE,
                      node ? light->node : light->shape)
        ->at;
}

static void report_lights(const World *world, DiagSink *sink)
{
    const Light *sized = NULL, *around = NULL;
    size_t count = 0;
    for (size_t i = 0; i < light_set_count(world->lights); ++i) {
        const Light *light = light_set_get(world->lights, i);
        if (light->class == &environment_light_light) {
            around = light;
        } else if (light->shape != NONE_ID) {
            sized = sized ? sized : light;
            ++count;
        }
    }
    if (sized) {
        Diag *diag = diag_report(sink, W0960, light_at(world, sized),
                                 "the integrator `local` takes this light for one without a size");
        if (diag && count > 1) {
            diag_note(sink, diag, "there are %zu lights with a size", count);
        }
    }
    if (around) {
        diag_report(sink, W0961, light_at(world, around),
                    "in the integrator `local` an `environment_light` is seen, but lights nothing");
    }
}

static void report_materials(const World *world, DiagSink *sink)
{
    for (uint32_t id = 0; id < world->material_count; ++id) {
        const WorldMaterial *m = &world->materials[id];
        if (!m->class->local && !(m->lobes & (LOBE_SMOOTH | LOBE_PASS))) {
            const SceneNode *node = scene_node(world->scene, CATEGORY_MATERIAL, id);
            diag_report(sink, W0962, node->at, "the integrator `local` shows `%s` black",
                        m->class->node.name);
            return;
        }
    }
}

static void check(const World *world, DiagSink *sink)
{
    report_lights(world, sink);
    report_materials(world, sink);
}

const IntegratorClass local_integrator = {
    .name = "local",
    .doc = "The slides' simplified model (equation 3): L = Σ S (f_am + f_dl + f_ph) over the "
           "lights, without indirect light, emission or noise. S is the irradiance that a light "
           "gives to a surface facing it, so I f(r) g(θ) for a point. `phong`, `blinn_phong` and "
           "`lambert` are the raw expressions (4) to (7); any other material shows π times its "
           "BRDF and cosine; mirrors and glass are black. `shadows: false` leaves out shadows, as "
           "the slides do; the ambient term never has any. An area light counts as a small light "
           "in its middle direction; surroundings are seen but light nothing, and where there are "
           "none, rays that miss everything are black.",
    .example =
        "render { integrator: \"local\" }\n"
        "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
        "directional_light { direction: (-1, -1.5, -1), irradiance: 1 }\n"
        "plane { material: phong { color: gray(0.5), ambient: 0.15 } }\n"
        "sphere {\n"
        "  center: (-0.8, 0.5, 0)\n"
        "  radius: 0.5\n"
        "  material: phong { color: #b03020, ambient: 0.15, diffuse: 0.6, specular: 0.3, "
        "shininess: 60 }\n"
        "}\n"
        "sphere {\n"
        "  center: (0.3, 0.4, -0.6)\n"
        "  radius: 0.4\n"
        "  material: blinn_phong { color: #d0a030, ambient: 0.15, diffuse: 0.6, specular: 0.3 }\n"
        "}\n"
        "box { min: (0.6, 0, -0.2), max: (1.2, 0.6, 0.4), material: phong { color: #3060a0, "
        "ambient: 0.15 } }",
    .radiance = radiance,
    .check = check,
};
