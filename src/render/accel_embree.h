// Embree 3 or 4 behind accel.h: included by accel_build.c, accel_trace.c and accel_careful.c, and
// nowhere else.
#ifndef RENDER_ACCEL_EMBREE_H
#define RENDER_ACCEL_EMBREE_H

#include "render/accel_parts.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext QueryContext;
#define query_context_init  rtcInitRayQueryContext
#define SCENE_FLAG_FILTERED RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS
#else
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext QueryContext;
#define query_context_init  rtcInitIntersectContext
#define SCENE_FLAG_FILTERED RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION
#endif

// One ray on its way through one group. The first member is what Embree hands to callbacks.
typedef struct Query {
    QueryContext embree;
    const AccelGroup *group;
    const Ray *ray; // in the group's space
    double tmax;    // the ray's, then that of the nearest hit found by callbacks so far
    double speed;   // Embree's length for t = 1
    double start;   // Embree's length from the ray's origin to where the float ray begins
    uint32_t instance;
    bool careful;
    float reported; // Embree's length up to the nearest hit that a callback has told of
    Hit *hit;       // the nearest found by callbacks so far; NULL: any will do
} Query;

// The nearest hit in a group before ray->tmax, and whether there is any; by the fast way where that
// can be trusted.
bool group_intersect(const AccelGroup *group, const Ray *ray, uint32_t instance, Hit *hit);
bool group_occluded(const AccelGroup *group, const Ray *ray, uint32_t instance);
// The same by the careful way.
bool careful_intersect(const AccelGroup *group, const Ray *ray, uint32_t instance, Hit *hit);
bool careful_occluded(const AccelGroup *group, const Ray *ray, uint32_t instance);

// Callbacks of the geometries of shapes (user data: their AccelKind), of pockets and of instances
// (their AccelGroup), for both ways.
void intersect_shape(const struct RTCIntersectFunctionNArguments *args);
void occluded_shape(const struct RTCOccludedFunctionNArguments *args);
void intersect_pocket(const struct RTCIntersectFunctionNArguments *args);
void occluded_pocket(const struct RTCOccludedFunctionNArguments *args);
void intersect_instance(const struct RTCIntersectFunctionNArguments *args);
void occluded_instance(const struct RTCOccludedFunctionNArguments *args);

#endif
