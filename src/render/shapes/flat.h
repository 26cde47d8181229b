// What triangles and parallelograms share.
#ifndef RENDER_SHAPES_FLAT_H
#define RENDER_SHAPES_FLAT_H

#include "render/geometry.h"

// Where the ray meets the plane of `corner`, `u`, `v`, in units of the edges; false where it is
// parallel. Möller, Trumbore 1997, with t from the plane alone, so that its sign is that of the
// origin's side of the plane.
static inline bool flat_meet(Vec3 corner, Vec3 u, Vec3 v, const Ray *ray, ShapeHit *hit)
{
    Vec3 normal = cross(u, v), from = sub(ray->origin, corner);
    double determinant = -dot(normal, ray->direction);
    Vec3 q = cross(from, ray->direction);
    *hit = (ShapeHit){.t = dot(normal, from) / determinant,
                      .u = dot(v, q) / determinant,
                      .v = -dot(u, q) / determinant};
    return isfinite(hit->t);
}

// The point corner + s u + t v with the plane's normal; uv = (s, t).
static inline void flat_point(Vec3 corner, Vec3 u, Vec3 v, double s, double t, ShapePoint *out)
{
    Vec3 normal = cross(u, v);
    double area = length(normal), lu = length(u), lv = length(v);
    normal = scale(normal, 1 / area);
    // The normal of a thin piece is uncertain by the rounding of its cross product.
    double size = (max_abs(corner) + lu + lv) * (lu * lv / area);
    *out = (ShapePoint){.p = add_scaled(add_scaled(corner, u, s), v, t),
                        .geometric = normal,
                        .shading = normal,
                        .tangent = u,
                        .bitangent = v,
                        .uv = {s, t},
                        .color = {1, 1, 1},
                        .error = rounding_error(size)};
}

// The area of the parallelogram under `to_world`.
static inline double flat_area(Vec3 u, Vec3 v, const Affine *to_world)
{
    return length(cross(transform_vector(to_world, u), transform_vector(to_world, v)));
}

// Solid angles below this are sampled by area: the sums of angles that give the solid angle are
// good to 1e-15.
#define FLAT_LEAST_SOLID_ANGLE 1e-6

#endif
