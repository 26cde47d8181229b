// A picture as the bytes of a file, as `scnrender render` writes it.
#ifndef WATCH_SAVE_H
#define WATCH_SAVE_H

#include "base/io.h"
#include "watch/session.h"

// `type` is "png" (developed) or "exr" (linear). NULL, with a message of one line, where it can't
// be made.
FileBytes *save_picture(const Snapshot *picture, SessionLook look, const char *type, char *message,
                        size_t message_size);
// Gives it back.
void save_release(void *bytes);

#endif
