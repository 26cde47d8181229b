// What lies at hits on the commonest surfaces, inline: paths spare the call, and find its numbers
// in registers.
#ifndef RENDER_ACCEL_PLAIN_H
#define RENDER_ACCEL_PLAIN_H

#include "render/accel_parts.h"

// How rays start that leave the surface. `normal` is that of Embree's flat piece, in its group's
// space.
static inline void accel_set_leaving(const Hit *hit, bool swept, Vec3 normal, Surface *out)
{
    out->flat = hit->flat;
    out->near_edge = !hit->inside;
    out->lifts = hit->flat && !swept;
    if (out->lifts) {
        out->own_normal[0] = (float)normal.x;
        out->own_normal[1] = (float)normal.y;
        out->own_normal[2] = (float)normal.z;
    }
}

// What is known of a hit on a piece of the table in the world. No copies through memory.
static inline void accel_fill_plain(const AccelFlat *flat, const Ray *ray, const Hit *hit,
                                    Surface *out)
{
    const Vec3 n = flat->normal;
    out->p = hit->p;
    out->geometric = n;
    out->shading = n;
    out->error = flat->error;
    out->shape = flat->shape;
    out->instance = NONE_ID;
    out->primitive = flat->primitive;
    out->material = flat->material;
    out->front = dot(ray->direction, n) < 0;
    out->lamp = flat->lamp;
    out->bent = false;
    out->whole = false;
    accel_set_leaving(hit, flat->swept, n, out);
}

// The piece of the table that was hit, where it stands in the world and has one normal; else NULL.
static inline const AccelFlat *accel_plain_flat(const Accel *accel, const Hit *hit)
{
    if (hit->flat - 1 >= accel->flat_count || hit->instance != NONE_ID) {
        return NULL;
    }
    const AccelFlat *flat = &accel->flats[hit->flat - 1];
    return flat->smooth ? NULL : flat;
}

#endif
