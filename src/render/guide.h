// Where light comes from by way of mirrors and glass. A few thousand rays are sent from the lamps
// to what mirrors and refracts; where they come to rest on something rough, they leave a note from
// which point of the glass they came. Paths that scatter near there then aim at those points for a
// part of their directions: a caustic under a small lamp, which a path would find by luck alone, is
// found every few tries. After Jensen 1995, "Importance driven path tracing using the photon map".
//
// The notes decide where to look, not what is seen: a direction's density is that of both ways to
// choose it, exactly, so that the mean stays what it is, whatever the notes say.
#ifndef RENDER_GUIDE_H
#define RENDER_GUIDE_H

#include "base/arena.h"
#include "base/vec.h"

// The part of the directions that are to be chosen so where there is a cell.
#define GUIDE_PART 0.3F

struct World;
typedef struct Guide Guide;
typedef struct GuideCell GuideCell;

// *out is NULL where nothing is to be found so. The world is ready but for this. The same for the
// same scene, always. False when memory runs out; `arena` keeps it.
bool guide_build(const struct World *world, Arena *arena, const Guide **out);
// Whether directions are chosen so on materials of these lobes.
bool guide_serves(uint32_t lobes);
// What is known about the neighbourhood of a point; NULL: nothing.
const GuideCell *guide_find(const Guide *guide, Vec3 p);
// A unit direction from p, by three numbers in [0, 1).
Vec3 guide_sample(const GuideCell *cell, Vec3 p, float choice, float u, float v);
// The density by solid angle with which it chooses a unit direction.
float guide_pdf(const GuideCell *cell, Vec3 p, Vec3 direction);

#endif
