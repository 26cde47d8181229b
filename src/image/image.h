// Images: read and written through OpenImageIO, which is loaded (a third of a second, 130 MB) only
// on first use, as a module; oiio.cpp is the project's only C++ file, and no exception leaves it.
#ifndef IMAGE_IMAGE_H
#define IMAGE_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct Image {
    int width, height, channels;
    float *pixels;     // width * height * channels, rows from the top; owned, image_free
    bool srgb_encoded; // the file's own word or, lacking that, its type's custom: PNG, JPEG, GIF,
                       // WebP and 8-bit TIFF are sRGB-encoded, EXR, HDR and float TIFF linear
} Image;

typedef struct ImageLimits {
    int64_t max_pixels; // of one image; larger ones are refused before memory is taken
} ImageLimits;

// Starts loading the module in a thread of its own, so that nobody waits for it later. Optional.
void image_preload(void);

// Decodes an image held in memory; `name` gives the type where the bytes don't, and stands in
// messages. False with a message.
bool image_read(const char *name, const void *bytes, size_t size, ImageLimits limits, Image *out,
                char *message, size_t message_size);
void image_free(Image *image);

// A channel group to be written ("" or a layer's name).
typedef struct ImageLayer {
    const char *name;            // "" for the picture itself, else "albedo", "normal", …
    int channels;                // 1, 3 or 4
    const char *const *suffixes; // channel names: "R" "G" "B", "X" "Y" "Z", "Z", "id"
    const float *pixels;         // width * height * channels
    bool uint32_ids; // `pixels` holds exact whole numbers: written as UINT where possible
} ImageLayer;

typedef struct ImageAttribute {
    const char *name, *text;
} ImageAttribute;

// Writes the layers into the file `path` (made by atomic_temporary_name), in the format of
// `format_of`'s extension; all layers into one EXR, only the first into any other type, quantised
// with fixed rounding. The same input gives the same bytes (no time stamp but the one in
// attributes). False with a message; the caller discards the file.
bool image_write(const char *path, const char *format_of, int width, int height,
                 const ImageLayer *layers, int layer_count, const ImageAttribute *attributes,
                 int attribute_count, char *message, size_t message_size);
// True when pictures of that file name's type can be written; it doesn't load the module.
bool image_can_write(const char *name);

#endif
