// What stands behind a place of a picture.
#ifndef WATCH_INSPECT_H
#define WATCH_INSPECT_H

#include "watch/snapshot.h"

// Places: (0, 0) the picture's top left corner, (1, 1) its bottom right one. All may be called from
// any thread, while the scene is rendered.

// How deep what is seen there lies along the camera's axis, m; NAN where nothing is.
double inspect_depth(const Snapshot *picture, double x, double y);
// How far from the camera to turn it about: what stands in the middle of the picture, or about the
// middle of the scene.
double inspect_pivot(const Snapshot *picture);
// As JSON (docs/watch.md). A failed text without memory.
Text inspect_json(const Snapshot *picture, double x, double y);

#endif
