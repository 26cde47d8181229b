// The frames of the base protocol: `Content-Length: N`, a blank line, N bytes of JSON. Whatever the
// peer sends, reading goes on with the next thing that looks like a frame.
#ifndef LSP_FRAMES_H
#define LSP_FRAMES_H

#include "base/array.h"
#include "base/str.h"

#include <stdbool.h>
#include <stddef.h>

enum {
    FRAME_HEADER_MOST = 64 << 10, // bytes of a header
    FRAME_BODY_MOST = 256 << 20,  // bytes of a message
};

// Bytes that have arrived and were not yet taken. Begin with zeros; give back with frames_free.
typedef struct Frames {
    ARRAY(char) bytes;
    size_t taken;  // of `bytes`: read already
    size_t search; // up to where there is no end of a header
    size_t skip;   // bytes still to come of a message that is too large
} Frames;

typedef enum FrameResult {
    FRAME_MORE, // needs more bytes
    FRAME_BODY,
    FRAME_BAD, // something that is no frame, or too large a one, was left out
} FrameResult;

void frames_free(Frames *frames);
// Room for `size` more bytes, to be followed by frames_added; NULL without memory.
char *frames_room(Frames *frames, size_t size);
void frames_added(Frames *frames, size_t size);
// The next message; *body is good until the next call of any of these.
FrameResult frames_next(Frames *frames, Str *body);

#endif
