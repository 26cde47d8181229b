// Rays against single flat pieces of the accelerator's table, in double precision.
#ifndef RENDER_ACCEL_MEET_H
#define RENDER_ACCEL_MEET_H

#include "render/accel_parts.h"

typedef struct Meeting {
    double distance, s, t; // the ray's t, and the place on the piece
    double least;          // of the four numbers that are positive inside
} Meeting;

static inline double least_inside(const AccelFlat *flat, double s, double t)
{
    return smaller(smaller(s, t), smaller(1 - s - flat->over_s * t, 1 - t - flat->over_t * s));
}

// Moves a point that lies beside the piece onto its edge, if it is no further from it than rounding
// errors may bring it: those of the piece, and of a point at such a distance.
bool accel_pull_inside(const AccelFlat *flat, Vec3 from, Meeting *met);

// True where the ray meets the piece before tmax; with `edges`, also where it passes no further
// beside it than rounding errors may bring it.
static inline bool meet(const AccelFlat *flat, const Ray *ray, double tmax, bool edges,
                        Meeting *out)
{
    const Vec3 from = sub(flat->corner, ray->origin);
    // That of the plane, so that its sign is that of the origin's side.
    const double distance = dot(flat->normal, from) / dot(flat->normal, ray->direction);
    const Vec3 at = sub(scale(ray->direction, distance), from);
    out->distance = distance;
    out->s = dot(flat->along_u, at);
    out->t = dot(flat->along_v, at);
    out->least = least_inside(flat, out->s, out->t);
    if (!(distance > ray->tmin && distance < tmax)) {
        return false;
    }
    if (out->least >= 0 || !edges) {
        return out->least >= 0;
    }
    Meeting pulled = *out; // whose address is known, so that *out can stay in registers
    if (!accel_pull_inside(flat, from, &pulled)) {
        return false;
    }
    *out = pulled;
    return true;
}

// Fills all of a hit on the piece of that number.
static inline void complete_hit(const AccelFlat *flat, uint32_t number, const Meeting *met,
                                uint32_t instance, Hit *hit)
{
    hit->t = met->distance;
    hit->shape = flat->shape;
    hit->instance = instance;
    hit->local.t = met->distance;
    hit->local.primitive = flat->primitive;
    hit->local.u = met->s;
    hit->local.v = met->t;
    hit->flat = number + 1;
    hit->inside = met->least >= (double)flat->inset;
    hit->p = add(flat->corner, add(scale(flat->u, met->s), scale(flat->v, met->t)));
}

#endif
