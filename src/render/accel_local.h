// Rays in a group's coordinates; see accel_parts.h.
#ifndef RENDER_ACCEL_LOCAL_H
#define RENDER_ACCEL_LOCAL_H

#include "render/accel_parts.h"

// The distance from a group's middle within which all of it lies, and more.
#define GROUP_RADIUS 1.75

// A ray in a group's coordinates.
typedef struct LocalRay {
    Vec3 origin, direction; // direction of unit length
    double speed;           // length for t = 1
    double begin, end;      // lengths from the origin: where the ray begins and ends near the group
} LocalRay;

// False where the ray never comes near the group.
static inline bool local_ray(const AccelGroup *group, const Ray *ray, uint32_t instance,
                             LocalRay *out)
{
    out->origin = scale(sub(vec3_apart(&ray->origin), group->center), group->inverse_scale);
    out->direction = vec3_apart(&ray->direction);
    out->speed = group->inverse_scale;
    if (instance != NONE_ID) { // else of unit length
        const double size = length(ray->direction);
        out->direction = scale(ray->direction, 1 / size);
        out->speed *= size;
    }
    out->begin = ray->tmin > 0 ? ray->tmin * out->speed : 0;
    out->end = ray->tmax * out->speed;
    if (max_abs(out->origin) > 2) {
        // The sphere about the unit cube, and a little more.
        const double middle = -dot(out->origin, out->direction);
        const double aside = length_squared(add_scaled(out->origin, out->direction, middle));
        out->begin = larger(out->begin, middle - GROUP_RADIUS);
        return aside < GROUP_RADIUS * GROUP_RADIUS && out->begin < out->end;
    }
    return true;
}

// Single precision is relative to the point where the ray comes near the group.
static inline Vec3 local_start(const LocalRay *local)
{
    return local->begin > 0 ? add_scaled(local->origin, local->direction, local->begin)
                            : local->origin;
}

static inline SweepRay sweep_ray(const LocalRay *local)
{
    const Vec3 o = local_start(local), d = local->direction;
    return (SweepRay){{(float)o.x, (float)o.y, (float)o.z},
                      {(float)d.x, (float)d.y, (float)d.z},
                      (float)(local->end - local->begin)};
}

#endif
