// What the module scn_oiio.so offers: a table of functions under the symbol "scn_oiio_functions".
// No exception leaves them; all give false and a message when they fail.
#ifndef IMAGE_OIIO_MODULE_H
#define IMAGE_OIIO_MODULE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { OIIO_MODULE_VERSION = 1 }; // to be raised with every change here

typedef struct OiioRead {
    const char *format; // OpenImageIO's name for the type
    const void *bytes;
    size_t size;
    int64_t max_pixels;
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *block);
    // Filled:
    int width, height, channels;
    float *pixels;
    bool srgb_encoded;
} OiioRead;

typedef enum OiioSample { OIIO_UINT8, OIIO_UINT16, OIIO_HALF, OIIO_FLOAT } OiioSample;

typedef struct OiioLayer {
    const char *name;
    int channels, used; // floats a pixel, and how many of them are written
    const char *const *suffixes;
    const float *pixels;
    const uint32_t *ids;
} OiioLayer;

typedef struct OiioText {
    const char *name, *text;
} OiioText;

typedef struct OiioWrite {
    const char *format, *extension, *path;
    int width, height;
    OiioSample sample;
    bool linear;
    const OiioLayer *layers;
    int layer_count;
    const OiioText *texts; // attributes
    int text_count;
} OiioWrite;

typedef struct OiioFunctions {
    uint32_t version;
    bool (*read)(OiioRead *read, char *message, size_t message_size);
    bool (*write)(const OiioWrite *write, char *message, size_t message_size);
} OiioFunctions;

#ifdef __cplusplus
}
#endif

#endif
