// The compressed pixels of a PNG file, made in bands of rows by threads: for module_png.c. The
// bytes don't depend on how many threads there are.
#ifndef IMAGE_MODULE_PNG_BANDS_H
#define IMAGE_MODULE_PNG_BANDS_H

#include "image/png_module.h"

// Takes the next bytes of the file's one stream of compressed data (its IDAT chunks). May jump.
typedef void PngSink(void *context, const void *bytes, size_t size);

// Compressed bands that wait to be written; all zero before the first call.
typedef struct PngBands {
    struct PngBand *items;
    size_t count;
} PngBands;

// Filters and compresses all rows and hands the stream to `sink`, in order. False when memory runs
// out. Afterwards, and after the sink has jumped, *bands has to be freed.
bool png_bands_write(PngBands *bands, const PngWrite *write, PngSink *sink, void *context);
void png_bands_free(PngBands *bands, const PngMemory *memory);

#endif
