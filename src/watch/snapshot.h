// A picture as it was at one moment of its rendering: what the film's means were, with what is
// needed to answer questions about it. Nothing changes it; it is shared by counting.
#ifndef WATCH_SNAPSHOT_H
#define WATCH_SNAPSHOT_H

#include "render/adaptive.h"
#include "render/camera.h"
#include "render/film.h"
#include "watch/loaded.h"

#include <stdatomic.h>

static const double SNAPSHOT_CONFIDENCE = 0.95; // of `relative`

typedef struct Snapshot {
    atomic_uint references;
    uint64_t number; // counts up from picture to picture
    uint32_t width, height;
    bool coarse;     // a first look of fewer pixels than the film has
    float *radiance; // 3 * width * height, linear Rec.709, rows from the top
    float *variance; // width * height: of the mean's luminance; NAN where there are no two samples
    double error;    // root of the mean variance over the mean luminance; NAN while unknown
    FilmError relative; // as files tell it
    uint32_t samples;   // that every pixel has
    FilmParams film;    // exposure and tone as the scene has them
    Camera camera;
    Loaded *loaded; // the scene that it shows
    char *command; // the command line that gives it, but for exposure and tone (mem); NULL: unknown
} Snapshot;

// What a renderer's film holds now (no thread may be rendering). Pixels without samples are taken
// from `under` (may be NULL), stretched. NULL without memory.
Snapshot *snapshot_new(const Film *film, const FilmParams *params, const Camera *camera,
                       Loaded *loaded, const Snapshot *under);
Snapshot *snapshot_keep(Snapshot *snapshot);
void snapshot_release(Snapshot *snapshot); // NULL is fine

// The picture as a display wants it, exactly as film_develop does and as an 8-bit file would hold
// it: 4 * width * height bytes, R G B and 255.
void snapshot_develop(const Snapshot *snapshot, double exposure, ToneCurve tone,
                      unsigned char *rgba);

#endif
