#include "render/materials/bent.h"

#include "render/world.h"

// The least cosine between a bent normal and the geometric one.
static const double LEAST_COSINE = 1e-3;

Frame texture_frame(const Surface *surface)
{
    Frame frame = frame_from_tangent(surface->shading, surface->tangent);
    if (dot(frame.t, surface->bitangent) < 0) {
        frame.t = neg(frame.t);
    }
    return frame;
}

static void bend(const ShadingPoint *point, const Bent *bent, ShadingPoint *out)
{
    const Surface *surface = point->surface;
    Vec3 normal = bent->normal(point->world, bent, surface);
    double l = length(normal);
    normal = l > 0 && isfinite(l) ? scale(normal, 1 / l) : surface->shading;
    double side = dot(normal, surface->geometric);
    if (side < LEAST_COSINE) {
        normal = normalize(add_scaled(normal, surface->geometric, LEAST_COSINE - side));
    }
    shading_point_bend(point, normal, surface->tangent, out);
}

static Vec3 to_bent(const ShadingPoint *from, const ShadingPoint *to, Vec3 w)
{
    return to_local(&to->frame, from_local(&from->frame, w));
}

uint32_t bent_lobes(const World *world, const void *params)
{
    const Bent *bent = params;
    return material_lobes(world, bent->base);
}

BsdfEval bent_eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    const Bent *bent = params;
    ShadingPoint at;
    bend(point, bent, &at);
    return material_eval(&at, bent->base, to_bent(point, &at, wi));
}

bool bent_sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                 BsdfSample *out)
{
    const Bent *bent = params;
    ShadingPoint at;
    bend(point, bent, &at);
    if (!material_sample(&at, bent->base, lobe, u, v, out)) {
        return false;
    }
    out->wi = to_bent(&at, point, out->wi);
    return true;
}

int bent_deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room)
{
    const Bent *bent = params;
    ShadingPoint at;
    bend(point, bent, &at);
    int count = material_deltas(&at, bent->base, out, room);
    for (int i = 0; i < count; ++i) {
        out[i].wi = to_bent(&at, point, out[i].wi);
    }
    return count;
}

Rgb bent_albedo(const ShadingPoint *point, const void *params)
{
    const Bent *bent = params;
    ShadingPoint at;
    bend(point, bent, &at);
    return material_albedo(&at, bent->base);
}

Rgb bent_emitted(const World *world, const void *params, const Surface *surface)
{
    const Bent *bent = params;
    return material_emitted(world, bent->base, surface);
}

Rgb bent_emitted_mean(const World *world, const void *params)
{
    const Bent *bent = params;
    return material_emitted_mean(world, bent->base);
}

Rgb bent_pass(const World *world, const void *params, const Surface *surface)
{
    const Bent *bent = params;
    return material_pass(world, bent->base, surface);
}

bool bent_medium(const World *world, const void *params, Medium *out)
{
    const Bent *bent = params;
    return material_medium(world, bent->base, out);
}

LocalTerms bent_local(const ShadingPoint *point, const void *params, Vec3 l)
{
    const Bent *bent = params;
    ShadingPoint at;
    bend(point, bent, &at);
    return material_local(&at, bent->base, to_bent(point, &at, l));
}
