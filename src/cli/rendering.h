// One picture on its way from a scene's text to the disk: for `render`, and for those who make many
// (series.h).
#ifndef CLI_RENDERING_H
#define CLI_RENDERING_H

#include "cli/interrupt.h"
#include "cli/load.h"
#include "cli/told.h"

typedef struct RenderTask {
    const Options *options; // of this picture
    Moment moment;
    bool *moves; // set once the scene is evaluated: whether it depends on the moment; or NULL
    bool *no_such_param; // set where a setting is of no param of the scene; or NULL
    // What follows is for a picture of a series: it is written when it is done and not before, its
    // checkpoint serves to go on after an interruption and is dropped otherwise, and signals stop
    // evaluation, too.
    bool in_series;
    const char *also;  // a second file of the same picture, without further layers; NULL: none
    const char *label; // stands before the bar and the statistics: "[3/12] "; NULL: nothing
    Told *told;        // diagnostics that aren't shown again
    void (*on_read)(void *context, const char *path, uint64_t hash); // Sandbox.on_read
    void *on_read_context;
    struct PictureCache *pictures; // of the pictures before; NULL: none are kept
    struct MeshCache *meshes;      // the same
} RenderTask;

// Renders it. An ExitCode, after a message if it isn't EXIT_OK (of a series' picture that was
// interrupted nothing is said). `interrupt` is zero, or was begun and heeded by whoever makes a
// series; it is ended by interrupt_end.
int render_picture(const RenderTask *task, Interrupt *interrupt);

#endif
