// What the module scn_exr.so offers: EXR written, and most of it read, through OpenEXR's C part
// alone (OpenEXRCore), which loads in two milliseconds. A table of functions under the symbol
// "scn_exr_functions". Without the module, and for files that it leaves alone, there is
// OpenImageIO.
#ifndef IMAGE_EXR_MODULE_H
#define IMAGE_EXR_MODULE_H

#include "image/image.h"

enum { EXR_MODULE_VERSION = 2 }; // to be raised with every change here, and of ImageFile

typedef struct ExrMemory {
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *block);
} ExrMemory;

typedef struct ExrWrite {
    const char *path;
    const ImageFile *file;
    int bits;         // of the picture's own channels, 16 or 32; layers' have 32
    ExrMemory memory; // the same for all threads
} ExrWrite;

typedef struct ExrRead {
    const void *bytes;
    size_t size;
    int64_t max_pixels;
    ExrMemory memory; // the same for all threads
    // Filled:
    int width, height, channels;
    float *pixels; // of `memory`
} ExrRead;

typedef enum ExrReading {
    EXR_IS_READ,
    EXR_NO_MEMORY, // there is none for it
    EXR_NOT_READ,  // it is damaged, or of a kind that is left to OpenImageIO
} ExrReading;

typedef struct ExrFunctions {
    uint32_t version;
    // False with a message when it fails.
    bool (*write)(const ExrWrite *write, char *message, size_t message_size);
    ExrReading (*read)(ExrRead *read);
} ExrFunctions;

#endif
