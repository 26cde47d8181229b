// What the module scn_png.so offers: PNG through libpng alone, which loads in a millisecond. A
// table of functions under the symbol "scn_png_functions"; all give false and a message when they
// fail.
#ifndef IMAGE_PNG_MODULE_H
#define IMAGE_PNG_MODULE_H

#include "base/thread.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { PNG_MODULE_VERSION = 2 }; // to be raised with every change here

typedef struct PngMemory {
    void *(*allocate)(size_t count, size_t size); // cleared
    void (*release)(void *block);
} PngMemory;

typedef struct PngRead {
    const void *bytes;
    size_t size;
    int64_t max_pixels;
    PngMemory memory;
    // Filled:
    int width, height, channels;
    float *pixels; // of `memory`
    bool srgb_encoded;
} PngRead;

typedef struct PngText {
    const char *name, *text; // UTF-8
} PngText;

typedef struct PngWrite {
    const char *path;
    int width, height, bits; // 8 or 16
    int channels, used;      // floats a pixel, and how many of them are written: 1 to 4
    const float *pixels;
    const PngText *texts; // attributes
    int text_count;
    PngMemory memory;
    // parallel_for, and how many threads there are for it.
    void (*parallel)(uint64_t count, unsigned threads, ParallelWork *work, void *context,
                     const atomic_int *stop);
    unsigned threads;
} PngWrite;

typedef struct PngFunctions {
    uint32_t version;
    bool (*read)(PngRead *read, char *message, size_t message_size);
    bool (*write)(const PngWrite *write, char *message, size_t message_size);
} PngFunctions;

#endif
