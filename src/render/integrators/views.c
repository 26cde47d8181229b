// Views into a scene: what the first surface along a ray is like, as a color. Surfaces that let
// more than half of the light pass (cut-outs) are looked through; where nothing is hit, all are
// black.
#include "render/integrators/surface_hit.h"

#include "base/hash.h"

static bool look(const World *world, const Ray *ray, AovSample *aov, IntegratorStats *stats,
                 SurfaceHit *at)
{
    if (!surface_hit_visible(world, ray, stats, at)) {
        return false;
    }
    if (aov) {
        aov_fill(&at->hit, &at->point, aov);
    }
    return true;
}

// --- Normals -------------------------------------------------------------------------------------

static Rgb normals(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                   IntegratorStats *stats)
{
    (void)sampler;
    SurfaceHit at;
    if (!look(world, ray, aov, stats, &at)) {
        return rgb_gray(0);
    }
    Vec3 n = at.surface.front ? at.surface.shading : neg(at.surface.shading);
    return rgb((float)(0.5 * n.x + 0.5), (float)(0.5 * n.y + 0.5), (float)(0.5 * n.z + 0.5));
}

const IntegratorClass normals_integrator = {
    .name = "normals",
    .doc = "A view: the shading normal of the side that is seen, in the world, as the color "
           "(n + 1)/2: red grows with x, green with y, blue with z. `tone: \"linear\"` writes "
           "these numbers as they are.",
    .example =
        "render { integrator: \"normals\" }\n"
        "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
        "directional_light { direction: (-1, -1.5, -1), irradiance: 3 }\n"
        "environment_light { color: #a8c4e8, radiance: 0.3 }\n"
        "plane { material: phong { color: gray(0.5), ambient: 0.15 } }\n"
        "sphere {\n"
        "  center: (-0.8, 0.5, 0)\n"
        "  radius: 0.5\n"
        "  material: phong { color: #b03020, ambient: 0.15, diffuse: 0.6, specular: 0.3, "
        "shininess: 60 }\n"
        "}\n"
        "sphere { center: (0.3, 0.4, -0.6), radius: 0.4, material: mirror { color: gray(0.9) } }\n"
        "box { min: (0.6, 0, -0.2), max: (1.2, 0.6, 0.4), material: phong { color: #3060a0, "
        "ambient: 0.15 } }",
    .radiance = normals,
};

// --- Depth ---------------------------------------------------------------------------------------

// How bright the farthest shape is: not black, as nothing is.
static const double FARTHEST = 0.1;

static double depth_fraction(const World *world, double depth)
{
    if (!isfinite(world->far)) {
        return depth / (depth + 1);
    }
    double range = world->far - world->near;
    return range > 0 ? fmin(fmax((depth - world->near) / range, 0), 1) : 0;
}

static Rgb depth(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                 IntegratorStats *stats)
{
    (void)sampler;
    SurfaceHit at;
    if (!look(world, ray, aov, stats, &at)) {
        return rgb_gray(0);
    }
    double t = world->camera ? camera_depth(world->camera, at.surface.p) : at.hit.t;
    return rgb_gray((float)(1 - (1 - FARTHEST) * depth_fraction(world, t)));
}

const IntegratorClass depth_integrator = {
    .name = "depth",
    .doc = "A view: how deep what is seen lies, from 1 (white) at the nearest to 0.1 at the "
           "farthest corner of the box around all bounded shapes; linear in the depth along the "
           "camera's axis (fisheye and panorama: the distance). Metres are in the layer of "
           "`film { aovs: [\"depth\"] }`.",
    .example =
        "render { integrator: \"depth\" }\n"
        "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
        "directional_light { direction: (-1, -1.5, -1), irradiance: 3 }\n"
        "environment_light { color: #a8c4e8, radiance: 0.3 }\n"
        "disc { radius: 2, normal: (0, 1, 0), material: lambert {} }\n"
        "sphere {\n"
        "  center: (-0.8, 0.5, 0)\n"
        "  radius: 0.5\n"
        "  material: phong { color: #b03020, ambient: 0.15, diffuse: 0.6, specular: 0.3, "
        "shininess: 60 }\n"
        "}\n"
        "sphere { center: (0.3, 0.4, -0.6), radius: 0.4, material: mirror { color: gray(0.9) } }\n"
        "box { min: (0.6, 0, -0.2), max: (1.2, 0.6, 0.4), material: phong { color: #3060a0, "
        "ambient: 0.15 } }",
    .radiance = depth,
};

// --- Texture coordinates -------------------------------------------------------------------------

static float fraction(double x)
{
    return (float)(x - floor(x));
}

static Rgb uv(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
              IntegratorStats *stats)
{
    (void)sampler;
    SurfaceHit at;
    if (!look(world, ray, aov, stats, &at)) {
        return rgb_gray(0);
    }
    return rgb(fraction(at.surface.uv.x), fraction(at.surface.uv.y), 0.25f);
}

const IntegratorClass uv_integrator = {
    .name = "uv",
    .doc = "A view: the texture coordinates, u as red and v as green, each modulo 1, with blue "
           "0.25. A jump to black-blue is where a texture is repeated.",
    .example =
        "render { integrator: \"uv\" }\n"
        "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
        "directional_light { direction: (-1, -1.5, -1), irradiance: 3 }\n"
        "environment_light { color: #a8c4e8, radiance: 0.3 }\n"
        "plane { material: phong { color: gray(0.5), ambient: 0.15 } }\n"
        "sphere {\n"
        "  center: (-0.8, 0.5, 0)\n"
        "  radius: 0.5\n"
        "  material: phong { color: #b03020, ambient: 0.15, diffuse: 0.6, specular: 0.3, "
        "shininess: 60 }\n"
        "}\n"
        "sphere { center: (0.3, 0.4, -0.6), radius: 0.4, material: mirror { color: gray(0.9) } }\n"
        "box { min: (0.6, 0, -0.2), max: (1.2, 0.6, 0.4), material: phong { color: #3060a0, "
        "ambient: 0.15 } }",
    .radiance = uv,
};

// --- Objects -------------------------------------------------------------------------------------

// A vivid color that follows from a hash: hue h in [0, 1), saturation s, value v.
static Rgb hue_color(float h, float s, float v)
{
    float c[3];
    for (int i = 0; i < 3; ++i) {
        float k = fmodf((float)(5 - 2 * i) + 6 * h, 6);
        float ramp = fminf(fminf(k, 4 - k), 1);
        c[i] = v - v * s * fmaxf(ramp, 0);
    }
    return rgb(c[0], c[1], c[2]);
}

static Rgb object_id(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                     IntegratorStats *stats)
{
    (void)sampler;
    SurfaceHit at;
    if (!look(world, ray, aov, stats, &at)) {
        return rgb_gray(0);
    }
    // Neighbours in the list are often neighbours in the picture: their hues lie a golden section
    // of the circle apart. Instances begin anywhere.
    double turn = 0.6180339887498949 * ((double)at.surface.shape + 1);
    uint32_t key = hash_combine(hash_u32(at.surface.shape), at.surface.instance);
    if (at.surface.instance != NONE_ID) {
        turn += (double)hash_to_float(hash_u32(at.surface.instance));
    }
    float h = fraction(turn), s = hash_to_float(hash_u32(key)),
          v = hash_to_float(hash_u32(key ^ 1));
    return hue_color(h, 0.5f + 0.4f * s, 0.5f + 0.5f * v);
}

const IntegratorClass object_id_integrator = {
    .name = "object_id",
    .doc = "A view: each shape, and each shape of each instance, in a color of its own that "
           "depends on its number only. Exact numbers are in the layer of "
           "`film { aovs: [\"object_id\"] }`.",
    .example =
        "render { integrator: \"object_id\" }\n"
        "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
        "directional_light { direction: (-1, -1.5, -1), irradiance: 3 }\n"
        "environment_light { color: #a8c4e8, radiance: 0.3 }\n"
        "plane { material: phong { color: gray(0.5), ambient: 0.15 } }\n"
        "sphere {\n"
        "  center: (-0.8, 0.5, 0)\n"
        "  radius: 0.5\n"
        "  material: phong { color: #b03020, ambient: 0.15, diffuse: 0.6, specular: 0.3, "
        "shininess: 60 }\n"
        "}\n"
        "sphere { center: (0.3, 0.4, -0.6), radius: 0.4, material: mirror { color: gray(0.9) } }\n"
        "box { min: (0.6, 0, -0.2), max: (1.2, 0.6, 0.4), material: phong { color: #3060a0, "
        "ambient: 0.15 } }",
    .radiance = object_id,
};
