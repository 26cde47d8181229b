// The yardstick of rendering speed: the least that draws the Cornell box of
// examples/cornell_box.scn. One quad mesh, Lambert only, independent random numbers, lights chosen
// by area, Embree's single-ray calls in single precision; no scene, no materials, no error bounds,
// no film. What scnrender takes longer than this, its generality costs.
// Usage: prototype [SIZE [SAMPLES [BOUNCES]]]; prints samples per second and the mean radiance.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct V {
    float x, y, z;
} V;

static V v(float x, float y, float z)
{
    return (V){x, y, z};
}
static V add(V a, V b)
{
    return v(a.x + b.x, a.y + b.y, a.z + b.z);
}
static V sub(V a, V b)
{
    return v(a.x - b.x, a.y - b.y, a.z - b.z);
}
static V mul(V a, V b)
{
    return v(a.x * b.x, a.y * b.y, a.z * b.z);
}
static V scale(V a, float s)
{
    return v(a.x * s, a.y * s, a.z * s);
}
static float dot(V a, V b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static V cross(V a, V b)
{
    return v(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static V normalize(V a)
{
    return scale(a, 1 / sqrtf(dot(a, a)));
}

enum { WHITE, GREEN, RED, LAMP };
typedef struct Quad {
    V corner[4]; // millimetres
    int material;
} Quad;

static const Quad quads[] = {
    {{{552.8f, 0, 0}, {0, 0, 0}, {0, 0, 559.2f}, {549.6f, 0, 559.2f}}, WHITE},
    {{{549.6f, 0, 559.2f}, {0, 0, 559.2f}, {0, 548.8f, 559.2f}, {556, 548.8f, 559.2f}}, WHITE},
    {{{0, 0, 559.2f}, {0, 0, 0}, {0, 548.8f, 0}, {0, 548.8f, 559.2f}}, GREEN},
    {{{552.8f, 0, 0}, {549.6f, 0, 559.2f}, {556, 548.8f, 559.2f}, {556, 548.8f, 0}}, RED},
    {{{556, 548.8f, 0}, {556, 548.8f, 559.2f}, {343, 548.8f, 332}, {343, 548.8f, 227}}, WHITE},
    {{{556, 548.8f, 559.2f}, {0, 548.8f, 559.2f}, {213, 548.8f, 332}, {343, 548.8f, 332}}, WHITE},
    {{{0, 548.8f, 559.2f}, {0, 548.8f, 0}, {213, 548.8f, 227}, {213, 548.8f, 332}}, WHITE},
    {{{0, 548.8f, 0}, {556, 548.8f, 0}, {343, 548.8f, 227}, {213, 548.8f, 227}}, WHITE},
    {{{130, 165, 65}, {82, 165, 225}, {240, 165, 272}, {290, 165, 114}}, WHITE},
    {{{290, 0, 114}, {290, 165, 114}, {240, 165, 272}, {240, 0, 272}}, WHITE},
    {{{130, 0, 65}, {130, 165, 65}, {290, 165, 114}, {290, 0, 114}}, WHITE},
    {{{82, 0, 225}, {82, 165, 225}, {130, 165, 65}, {130, 0, 65}}, WHITE},
    {{{240, 0, 272}, {240, 165, 272}, {82, 165, 225}, {82, 0, 225}}, WHITE},
    {{{423, 330, 247}, {265, 330, 296}, {314, 330, 456}, {472, 330, 406}}, WHITE},
    {{{423, 0, 247}, {423, 330, 247}, {472, 330, 406}, {472, 0, 406}}, WHITE},
    {{{472, 0, 406}, {472, 330, 406}, {314, 330, 456}, {314, 0, 456}}, WHITE},
    {{{314, 0, 456}, {314, 330, 456}, {265, 330, 296}, {265, 0, 296}}, WHITE},
    {{{265, 0, 296}, {265, 330, 296}, {423, 330, 247}, {423, 0, 247}}, WHITE},
    {{{343, 548.8f, 227}, {343, 548.8f, 332}, {213, 548.8f, 332}, {213, 548.8f, 227}}, LAMP},
};
enum { QUADS = sizeof quads / sizeof *quads };

static const V albedos[] = {
    {0.725f, 0.71f, 0.68f}, {0.14f, 0.45f, 0.091f}, {0.63f, 0.065f, 0.05f}, {0.5f, 0.5f, 0.5f}};
static const V radiance = {18.4f, 14, 6.75f};
static const float pi = 3.14159265f;
static const float epsilon = 1e-4f; // metres: by which rays leave surfaces and end before lamps

typedef struct Random { // PCG-XSH-RR (O'Neill 2014)
    uint64_t state;
} Random;

static float uniform(Random *r)
{
    const uint64_t old = r->state;
    r->state = old * 6364136223846793005u + 1442695040888963407u;
    const uint32_t x = (uint32_t)(((old >> 18) ^ old) >> 27), turn = (uint32_t)(old >> 59);
    return (float)(((x >> turn) | (x << (-turn & 31))) >> 8) * 0x1p-24f;
}

static RTCScene build(RTCDevice device)
{
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
    float *vertices =
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 4 * QUADS);
    uint32_t *indices =
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 16, QUADS);
    for (uint32_t i = 0; i < 4 * QUADS; ++i) {
        const V p = scale(quads[i / 4].corner[i % 4], 0.001f);
        vertices[3 * i] = p.x;
        vertices[3 * i + 1] = p.y;
        vertices[3 * i + 2] = p.z;
        indices[i] = i;
    }
    rtcCommitGeometry(mesh);
    RTCScene scene = rtcNewScene(device);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(scene);
    return scene;
}

static struct RTCRay ray_make(V o, V d, float tfar)
{
    return (struct RTCRay){.org_x = o.x,
                           .org_y = o.y,
                           .org_z = o.z,
                           .tnear = epsilon,
                           .dir_x = d.x,
                           .dir_y = d.y,
                           .dir_z = d.z,
                           .tfar = tfar,
                           .mask = UINT32_MAX};
}

static void intersect(RTCScene scene, struct RTCRayHit *hit)
{
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene, hit, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, hit);
#endif
}

static bool occluded(RTCScene scene, struct RTCRay *ray)
{
#if RTC_VERSION_MAJOR >= 4
    rtcOccluded1(scene, ray, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, ray);
#endif
    return ray->tfar < 0;
}

// Light from a point of the lamp, chosen by area, over the surface's albedo.
static V direct(RTCScene scene, V p, V n, Random *r)
{
    const V *lamp = quads[QUADS - 1].corner;
    const V u = scale(sub(lamp[1], lamp[0]), 0.001f), w = scale(sub(lamp[3], lamp[0]), 0.001f);
    const float s = uniform(r), t = uniform(r);
    const V way = sub(add(add(scale(lamp[0], 0.001f), scale(u, s)), scale(w, t)), p);
    const float square = dot(way, way), distance = sqrtf(square);
    const V d = scale(way, 1 / distance), area = cross(u, w);
    const float cosines = dot(d, n) * fmaxf(-dot(d, area), 0);
    if (!(cosines > 0)) {
        return v(0, 0, 0);
    }
    struct RTCRay shadow = ray_make(p, d, distance - epsilon);
    return occluded(scene, &shadow) ? v(0, 0, 0) : scale(radiance, cosines / (square * pi));
}

static V scatter(V n, Random *r)
{
    const float sign = copysignf(1, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    const V s = v(1 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    const V t = v(b, sign + n.y * n.y * a, -n.y);
    const float angle = 2 * pi * uniform(r), square = uniform(r), radius = sqrtf(square);
    return add(add(scale(s, radius * cosf(angle)), scale(t, radius * sinf(angle))),
               scale(n, sqrtf(1 - square)));
}

static V trace(RTCScene scene, V o, V d, int bounces, Random *r)
{
    V found = v(0, 0, 0), throughput = v(1, 1, 1);
    for (int depth = 0;; ++depth) {
        struct RTCRayHit hit = {.ray = ray_make(o, d, INFINITY)};
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        intersect(scene, &hit);
        if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
            return found;
        }
        const int material = quads[hit.hit.primID].material;
        V n = normalize(v(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z));
        const bool front = dot(n, d) < 0;
        if (material == LAMP && depth == 0 && d.y > 0) {
            found = add(found, radiance);
        }
        if (depth == bounces) {
            return found;
        }
        n = front ? n : scale(n, -1);
        o = add(o, scale(d, hit.ray.tfar));
        throughput = mul(throughput, albedos[material]);
        found = add(found, mul(throughput, direct(scene, o, n, r)));
        if (depth + 1 >= 4) {
            const float survival = sqrtf(fmaxf(throughput.x, fmaxf(throughput.y, throughput.z)));
            if (uniform(r) >= survival) {
                return found;
            }
            throughput = scale(throughput, 1 / survival);
        }
        d = scatter(n, r);
    }
}

int main(int argc, char **argv)
{
    const int size = argc > 1 ? atoi(argv[1]) : 256, samples = argc > 2 ? atoi(argv[2]) : 64;
    const int bounces = argc > 3 ? atoi(argv[3]) : 8;
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = build(device);
    const float half = tanf(39.3077f / 360 * pi);
    struct timespec from, to;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &from);
    V sum = v(0, 0, 0);
    for (int i = 0; i < size * size; ++i) {
        Random random = {(uint64_t)i * 0x9e3779b97f4a7c15u};
        for (int k = 0; k < samples; ++k) {
            const float x = ((float)(i % size) + uniform(&random)) / (float)size;
            const float y = ((float)(i / size) + uniform(&random)) / (float)size;
            const V d = normalize(v((1 - 2 * x) * half, (1 - 2 * y) * half, 1));
            sum = add(sum, scale(trace(scene, v(0.278f, 0.273f, -0.8f), d, bounces, &random),
                                 1 / ((float)size * (float)size * (float)samples)));
        }
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &to);
    const double seconds =
        (double)(to.tv_sec - from.tv_sec) + 1e-9 * (double)(to.tv_nsec - from.tv_nsec);
    printf("%.3f Msamples/s of one processor; mean radiance %.4f %.4f %.4f\n",
           1e-6 * size * size * samples / seconds, (double)sum.x, (double)sum.y, (double)sum.z);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    return 0;
}
