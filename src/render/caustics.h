// The light that photons bring (photons.h), by pixel, and how samples get it.
//
// A picture's samples are cut into runs; each run has photons of its own, as many as it has
// samples, whose light every sample of the run adds. So the photons, too, grow with the samples: a
// pixel's sums depend on its samples only (film.h), parts of a picture join to the whole, and what
// is added later is as good as what was there from the start.
//
// Photons are followed in chunks by several threads, and what the camera sees of them is kept and
// then added in their order: bytes don't depend on threads.
#ifndef RENDER_CAUSTICS_H
#define RENDER_CAUSTICS_H

#include "render/photons.h"

struct Renderer;

typedef struct CausticPixel {
    double sum[3];
    double square; // of the luminance: the sum of squares, and then its variance by sample
} CausticPixel;

// The film's height is cut into so many strips where what threads have to add is shared out.
enum { CAUSTIC_STRIPS = 1024 };

typedef struct PhotonChunk {
    PhotonSplat *splats;
    uint32_t count;
    uint16_t in_strip[CAUSTIC_STRIPS]; // of these, by their places
    IntegratorStats stats;
} PhotonChunk;

// Samples [first, end).
typedef struct SampleRun {
    uint32_t first, end;
} SampleRun;

typedef struct CausticFilm {
    CausticPixel *pixels[2]; // of each stream; the second only with a stopping rule
    SampleRun run;           // which is ready; end = 0: none
    PhotonChunk *chunks;
    PhotonSplat *splats; // of all chunks
    uint32_t chunk_count;
} CausticFilm;

// Makes the renderer ready for photons if they are asked for; its world, camera and filter are.
// False after a report.
bool caustics_begin(struct Renderer *r, DiagSink *sink);
void caustics_end(struct Renderer *r);
// Traces the photons of the samples that the pass under way will take, if they aren't ready. False
// after a stop.
bool caustics_trace(struct Renderer *r);

#endif
