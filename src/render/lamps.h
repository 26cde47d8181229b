// Pixels in which edges of lamps are seen. Across such an edge radiance jumps by far more than
// anywhere else, so that most of a picture's error may sit in a few pixels; and a ray that looks at
// a lamp costs a small part of a path. There, what the camera sees of lamps is found by further
// rays of their own, and paths bring the rest.
//
// Which pixels these are is decided by the lamps' places and by trial rays that count for nothing
// else: what is decided thus says nothing about the samples, and their mean stays what it is.
#ifndef RENDER_LAMPS_H
#define RENDER_LAMPS_H

#include "render/camera.h"
#include "render/world.h"

enum { LAMP_RAYS = 8 }; // for each path

// What is known of a pixel.
typedef enum LampMark {
    LAMP_NONE,  // no edge: the path's own ray is enough
    LAMP_MAYBE, // to be tried
    LAMP_EDGE,
} LampMark;

// For each pixel of the film, rows from the top, its LampMark, in *marks; NULL where the camera
// sees no edges of lamps at all. reach: how far a pixel's filter reaches from its centre, pixels.
// False when memory runs out. Give it back with mem_free.
bool lamp_marks(const World *world, const Camera *camera, uint32_t width, uint32_t height,
                double reach, uint8_t **marks);

#endif
