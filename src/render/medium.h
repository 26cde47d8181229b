// What fills the inside of transparent bodies, and which of them a ray is in: nested dielectrics
// after Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced Images".
//
// A closed surface of glass has a medium on its back side. Bodies may overlap, as a drink and its
// glass are best modelled; where they do, the one of the highest priority fills the place, and of
// equal ones the one that the ray entered last (an inner ball replaces what is around it). A
// surface whose medium is not what fills the place, on either side, is not there: rays pass it as
// if there were nothing.
#ifndef RENDER_MEDIUM_H
#define RENDER_MEDIUM_H

#include "render/accel.h"

struct World;

typedef struct Medium {
    double ior;
    double outside; // index of refraction where no other medium is known to be
    Rgb absorption; // per metre: light falls off as exp(-absorption distance)
    int64_t priority;
} Medium;

// The bodies that a ray is in, in the order in which it entered them. All zero: none.
enum { MEDIUM_DEPTH = 16 }; // a ray in more forgets the oldest
typedef struct MediumStack {
    struct {
        const Medium *medium;
        uint32_t shape, instance;
    } items[MEDIUM_DEPTH];
    uint32_t count;
} MediumStack;

// What fills the place; NULL: nothing.
const Medium *medium_current(const MediumStack *stack);

// What a ray on the stack's way meets in a surface.
typedef struct MediumBoundary {
    const Medium *medium; // behind the surface; NULL: an opaque one, the rest is then not set
    bool hidden;          // covered by another medium: as if not there
    double outside;       // index of refraction on its front side
} MediumBoundary;
MediumBoundary medium_boundary(const struct World *world, const MediumStack *stack,
                               const Surface *surface);
// The stack beyond the surface, for a ray that crosses it. Nothing for opaque ones.
void medium_cross(const struct World *world, MediumStack *stack, const Surface *surface);

// Beer and Lambert: what is left of light after `distance` metres, INFINITY included. NULL: all.
Rgb medium_transmittance(const Medium *medium, double distance);

// The part of light that passes along `ray`, which starts within `stack`: as world_visibility, but
// absorbed on the way, and not stopped by hidden surfaces.
Rgb medium_visibility(const struct World *world, const MediumStack *stack, const Ray *ray);

// The bodies that a point lies in, found by a ray that leaves it.
MediumStack medium_around(const struct World *world, Vec3 point);

#endif
