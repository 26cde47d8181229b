#include "render/texture_image.h"

float srgb_decode(float encoded)
{
    float a = fabsf(encoded);
    float linear = a <= 0.04045f ? a / 12.92f : powf((a + 0.055f) / 1.055f, 2.4f);
    return copysignf(linear, encoded);
}

// The index that stands for `i`, or -1 for black.
static int wrap_index(double i, int size, TextureWrap wrap)
{
    double n = size;
    switch (wrap) {
    case WRAP_CLAMP:
        return (int)fmin(fmax(i, 0), n - 1);
    case WRAP_BLACK:
        return i < 0 || i >= n ? -1 : (int)i;
    case WRAP_MIRROR: {
        double k = i - 2 * n * floor(i / (2 * n));
        return (int)fmin(fmax(k < n ? k : 2 * n - 1 - k, 0), n - 1);
    }
    case WRAP_REPEAT:
    default:
        return (int)fmin(fmax(i - n * floor(i / n), 0), n - 1);
    }
}

static Rgb texel(const TextureImage *image, int x, int y)
{
    return x < 0 || y < 0 ? rgb_gray(0)
                          : image->texels[(size_t)y * (size_t)image->width + (size_t)x];
}

// The two texels beside x, and how far x lies from the first to the second.
static inline void neighbours(double x, int size, TextureWrap wrap, int *first, int *second,
                              float *part)
{
    const double from = x - 0.5;
    const bool inside = from >= 0 && from < size - 1; // then all ways of wrapping agree
    const double whole = inside ? (double)(int)from : floor(from);
    *part = (float)(from - whole);
    *first = inside ? (int)from : wrap_index(whole, size, wrap);
    *second = inside ? (int)from + 1 : wrap_index(whole + 1, size, wrap);
}

Rgb texture_image_look_up(const TextureImage *image, double u, double v, TextureFilter filter,
                          TextureWrap wrap_u, TextureWrap wrap_v)
{
    double x = u * image->width, y = (1 - v) * image->height;
    if (!isfinite(x) || !isfinite(y)) {
        return rgb_gray(0);
    }
    if (filter == FILTER_NEAREST) {
        return texel(image, wrap_index(floor(x), image->width, wrap_u),
                     wrap_index(floor(y), image->height, wrap_v));
    }
    int left, right, top, bottom;
    float fx, fy;
    neighbours(x, image->width, wrap_u, &left, &right, &fx);
    neighbours(y, image->height, wrap_v, &top, &bottom, &fy);
    Rgb upper = rgb_add(rgb_scale(texel(image, left, top), 1 - fx),
                        rgb_scale(texel(image, right, top), fx));
    Rgb lower = rgb_add(rgb_scale(texel(image, left, bottom), 1 - fx),
                        rgb_scale(texel(image, right, bottom), fx));
    return rgb_add(rgb_scale(upper, 1 - fy), rgb_scale(lower, fy));
}
