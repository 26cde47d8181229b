// Images: PNG is read and written through libpng, EXR through OpenEXR's C part, all else through
// OpenImageIO (and EXR of kinds that module_exr_read.c leaves alone, or where OpenEXR's module
// isn't there). They are loaded as modules on first use, libpng and OpenEXR in a millisecond or
// two, OpenImageIO in a third of a second (and 130 MB); oiio.cpp is the project's only C++ file,
// and no exception leaves it.
#ifndef IMAGE_IMAGE_H
#define IMAGE_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct Image {
    int width, height, channels; // 1 gray, 2 gray and alpha, 3 RGB, 4 RGB and alpha
    float *pixels; // width * height * channels, rows from the top; whole numbers as fractions of
                   // their type's largest, alpha not multiplied in, as the file has it; floats of
                   // any value, infinite and NaN included. Owned; image_free
    bool srgb_encoded; // the file's own word or, lacking that, its type's custom: whole numbers
                       // are sRGB-encoded, floats linear. EXR and HDR are always linear.
} Image;

typedef struct ImageLimits {
    int64_t max_pixels; // of one image; larger ones are refused before memory is taken
} ImageLimits;

// Starts loading what pictures of that file name's type want (any other name: all that may be
// wanted), in a thread of its own, so that nobody waits for it later. Optional.
void image_preload(const char *name);
// Waits until that is loaded. False with a message if it can't be.
bool image_available(const char *name, char *message, size_t message_size);

// Decodes an image held in memory; `name` gives the type where the bytes don't, and stands in
// messages. Reads EXR, PNG, JPEG, TIFF, HDR, WebP, GIF (the first frame), BMP, Targa and PNM/PFM;
// of more than four channels R, G and B or else the first. False with a message of one line.
bool image_read(const char *name, const void *bytes, size_t size, ImageLimits limits, Image *out,
                char *message, size_t message_size);
void image_free(Image *image);

// A channel group to be written ("" or a layer's name).
typedef struct ImageLayer {
    const char *name;            // "" for the picture itself, else "albedo", "normal", …
    int channels;                // 1, 3 or 4
    const char *const *suffixes; // channel names: "R" "G" "B", "X" "Y" "Z", "Z", "id"
    const float *pixels;         // width * height * channels
    const uint32_t *ids;         // width * height, instead of pixels: one channel of UINT (EXR)
} ImageLayer;

typedef struct ImageAttribute {
    const char *name, *text;
} ImageAttribute;

typedef struct ImageFile {
    int width, height;
    int bits; // of a channel; 0: the type's own
    const ImageLayer *layers;
    int layer_count;
    const ImageAttribute *attributes;
    int attribute_count;
    unsigned threads; // that may compress it; 0 counts as 1. The bytes don't depend on it
} ImageFile;

// Writes the layers into the file `path` (made by atomic_temporary_name), in the format of
// `format_of`'s extension; all layers into one EXR, only the first (without its alpha where the
// type has none) into any other type. Types of whole numbers take 0 to 1, rounded to the nearest;
// NaN gives 0. Nothing is converted: image_is_linear says what the pixels should be. The same input
// gives the same bytes: no time but the one in the attributes is written (TIFF and EXR want a
// DateTime; theirs is 1970 unless given). False with a message; the caller discards the file.
bool image_write(const char *path, const char *format_of, const ImageFile *file, char *message,
                 size_t message_size);

// These load nothing.
// True when pictures of that file name's type can be written.
bool image_can_write(const char *name);
// True when the type can have so many bits a channel (0: its own).
bool image_has_bits(const char *name, int bits);
// True when the type holds linear light (EXR, HDR, floats); otherwise an encoded picture.
bool image_is_linear(const char *name, int bits);
// True when the type holds layers.
bool image_has_layers(const char *name);
// The extensions that can be written, "exr, png, …".
const char *image_extensions(void);

#endif
