// A decoded picture, as textures and environments look it up.
#ifndef RENDER_TEXTURE_IMAGE_H
#define RENDER_TEXTURE_IMAGE_H

#include "base/vec.h"

#include <stddef.h>
#include <stdint.h>

typedef enum TextureEncoding { ENCODING_AUTO, ENCODING_SRGB, ENCODING_LINEAR } TextureEncoding;
typedef enum TextureFilter { FILTER_BILINEAR, FILTER_NEAREST } TextureFilter;
typedef enum TextureWrap { WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR, WRAP_BLACK } TextureWrap;

// Most pixels of one picture.
#define TEXTURE_MAX_PIXELS ((int64_t)1 << 27)

typedef struct TextureImage {
    int width, height;
    Rgb *texels; // width * height, linear, rows from the top
    Rgb mean;
} TextureImage;

// The value at (u, v): (0, 0) is the bottom left corner of the picture, (1, 1) the top right one;
// texel (x, y) has its centre at ((x + ½)/width, 1 - (y + ½)/height). What lies outside follows
// from the wrap of each axis.
Rgb texture_image_look_up(const TextureImage *image, double u, double v, TextureFilter filter,
                          TextureWrap wrap_u, TextureWrap wrap_v);
// The sRGB curve's inverse (IEC 61966-2-1), for encoded values of any size.
float srgb_decode(float encoded);

#endif
