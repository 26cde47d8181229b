// Pictures for tev (https://github.com/Tom94/tev), a viewer of high dynamic range, over its
// protocol.
#ifndef WATCH_TEV_H
#define WATCH_TEV_H

#include "watch/session.h"

#define TEV_ADDRESS "127.0.0.1:14158" // where tev listens unless told otherwise

typedef struct TevSender TevSender;

// Sends the session's pictures, in linear light and called `name`, to the tev at "HOST:PORT" from a
// thread of its own: as fast as tev takes them, and again from the start when tev is started later
// or anew. NULL, with a message, where the address makes no sense. `name` must outlive it.
TevSender *tev_new(Session *session, const char *address, const char *name, char *message,
                   size_t message_size);
// Closes the session and waits. NULL is fine.
void tev_free(TevSender *sender);

// --- Packets -------------------------------------------------------------------------------------
// All are little-endian, begin with their length in bytes, itself included, in four, and a type in
// one; strings end with a 0. (src/Ipc.cpp of tev 2.)

// An image of three channels R, G and B, in place of one of that name; shown if `focus`.
void tev_create_image(Text *packet, const char *name, bool focus, uint32_t width, uint32_t height);
// Rows [first, first + rows) of it; `radiance` are 3 * width * rows floats.
void tev_update_image(Text *packet, const char *name, uint32_t width, uint32_t first, uint32_t rows,
                      const float *radiance);

#endif
