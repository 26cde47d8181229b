// Cutting plane polygons into triangles.
#ifndef SCENE_POLYGON_H
#define SCENE_POLYGON_H

#include "base/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// A polygon that isn't convex takes time with the square of its corners: no more than these.
enum { POLYGON_LONGEST_CONCAVE = 5000 };

typedef enum PolygonResult { POLYGON_OK, POLYGON_NO_MEMORY, POLYGON_TOO_LONG } PolygonResult;

// Memory that is used again from polygon to polygon; zero bytes are an empty one.
typedef struct PolygonScratch {
    Vec2 *points;
    uint32_t *next, *before;
    size_t capacity;
} PolygonScratch;

void polygon_scratch_free(PolygonScratch *scratch);

// Cuts the polygon with the `count` >= 3 corners into count - 2 triangles, which are written to
// `triangles` as 3 * (count - 2) numbers of corners, wound as the polygon is. A strictly convex
// polygon becomes a fan about its first corner. Any other is cut by clipping ears (Meisters 1975)
// in the plane of its mean normal (Newell), in exact order, so that the same corners give the same
// triangles. Corners that lie off that plane keep their places. One that crosses itself is cut into
// as many triangles, some of which overlap. All corners must be finite.
PolygonResult polygon_triangulate(PolygonScratch *scratch, const Vec3 *corners, uint32_t count,
                                  uint32_t *triangles);

#endif
