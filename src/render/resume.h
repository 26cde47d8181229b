// A renderer put away in a checkpoint, and taken up again by another run of the program.
#ifndef RENDER_RESUME_H
#define RENDER_RESUME_H

#include "render/checkpoint.h"
#include "render/render.h"

// Writes what was done to the file `path`, which is replaced as a whole, with `notes` for whoever
// makes a picture of it. Not while the renderer runs. False with a message; the old file is then as
// it was.
bool renderer_save(Renderer *renderer, CheckpointTexts notes, const char *path, char *message,
                   size_t message_size);
// Takes up what was saved by a renderer of the same scene and settings: a run from there gives the
// bytes of one that never was interrupted. More or fewer samples may be asked for than then, if no
// pixel has too many or ends within a block.
// Only before the first renderer_run, and no run after an error. Anything but CHECKPOINT_SOUND
// comes with a message; with that the message is a warning, or "".
CheckpointResult renderer_load(Renderer *renderer, const char *path, char *message,
                               size_t message_size);

#endif
