// The size that an image file claims, read from its header before any decoder sees it: some
// decoders take memory for whatever they are told as soon as they are opened.
#ifndef IMAGE_PEEK_H
#define IMAGE_PEEK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct PeekedSize {
    int64_t width, height; // the largest of all parts
    int64_t tile_width, tile_height;
} PeekedSize;

// `format` is "openexr", "png", "jpeg", "webp", "gif", "bmp" or "targa"; of other types, whose
// decoders wait, the size stays 0 and true is returned. False when the header is damaged or cut.
bool image_peek(const char *format, const void *bytes, size_t size, PeekedSize *out);

#endif
