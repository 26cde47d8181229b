#include "image/peek.h"

#include <string.h>

typedef struct Bytes {
    const unsigned char *at;
    size_t size;
} Bytes;

// Whole numbers at an offset that the caller has checked.
static uint32_t little16(const unsigned char *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8;
}
static uint32_t little24(const unsigned char *at)
{
    return little16(at) | (uint32_t)at[2] << 16;
}
static uint32_t little32(const unsigned char *at)
{
    return little16(at) | little16(at + 2) << 16;
}
static uint32_t big16(const unsigned char *at)
{
    return (uint32_t)at[0] << 8 | at[1];
}
static uint32_t big32(const unsigned char *at)
{
    return big16(at) << 16 | big16(at + 2);
}

static void enlarge(PeekedSize *out, int64_t width, int64_t height)
{
    out->width = width > out->width ? width : out->width;
    out->height = height > out->height ? height : out->height;
}

static bool peek_png(Bytes file, PeekedSize *out)
{
    if (file.size < 24) {
        return false;
    }
    enlarge(out, big32(file.at + 16), big32(file.at + 20));
    return true;
}

// The canvas, and each frame's own size, which may be larger.
static bool peek_gif(Bytes file, PeekedSize *out)
{
    if (file.size < 13) {
        return false;
    }
    enlarge(out, little16(file.at + 6), little16(file.at + 8));
    size_t at = 13 + (file.at[10] & 0x80 ? (size_t)3 << ((file.at[10] & 7) + 1) : 0);
    while (at < file.size && file.at[at] != 0x3b) {
        size_t blocks = at + 2; // of an extension
        if (file.at[at] == 0x2c) {
            if (file.size - at < 11) {
                return true; // the decoder will find it cut
            }
            enlarge(out, little16(file.at + at + 5), little16(file.at + at + 7));
            unsigned flags = file.at[at + 9];
            blocks = at + 11 + (flags & 0x80 ? (size_t)3 << ((flags & 7) + 1) : 0);
        } else if (file.at[at] != 0x21) {
            break;
        }
        while (blocks < file.size && file.at[blocks]) {
            blocks += (size_t)file.at[blocks] + 1;
        }
        at = blocks + 1;
    }
    return true;
}

static bool peek_bmp(Bytes file, PeekedSize *out)
{
    if (file.size < 26) {
        return false;
    }
    if (little32(file.at + 14) == 12) { // OS/2
        enlarge(out, little16(file.at + 18), little16(file.at + 20));
        return true;
    }
    int64_t width = (int32_t)little32(file.at + 18), height = (int32_t)little32(file.at + 22);
    enlarge(out, width, height < 0 ? -height : height); // negative: rows from the top
    return width > 0;
}

static bool peek_targa(Bytes file, PeekedSize *out)
{
    if (file.size < 18) {
        return false;
    }
    enlarge(out, little16(file.at + 12), little16(file.at + 14));
    return true;
}

// RIFF chunks: VP8X gives the canvas, VP8 and VP8L the picture's own size.
static bool peek_webp(Bytes file, PeekedSize *out)
{
    bool found = false;
    for (size_t at = 12; file.size > at && file.size - at >= 8;) {
        const unsigned char *chunk = file.at + at;
        size_t length = little32(chunk + 4), room = file.size - at - 8;
        const unsigned char *data = chunk + 8;
        if (memcmp(chunk, "VP8X", 4) == 0 && room >= 10) {
            enlarge(out, (int64_t)little24(data + 4) + 1, (int64_t)little24(data + 7) + 1);
            found = true;
        } else if (memcmp(chunk, "VP8 ", 4) == 0 && room >= 10) {
            enlarge(out, little16(data + 6) & 0x3fff, little16(data + 8) & 0x3fff);
            found = true;
        } else if (memcmp(chunk, "VP8L", 4) == 0 && room >= 5) {
            uint32_t bits = little32(data + 1);
            enlarge(out, (int64_t)(bits & 0x3fff) + 1, (int64_t)(bits >> 14 & 0x3fff) + 1);
            found = true;
        }
        if (length > room) {
            break;
        }
        at += 8 + length + (length & 1);
    }
    return found;
}

// The start-of-frame segment (ITU T.81, B.2.2).
static bool peek_jpeg(Bytes file, PeekedSize *out)
{
    size_t at = 2;
    while (at < file.size && file.size - at >= 9) {
        if (file.at[at] != 0xff) {
            ++at; // decoders look for the next marker, too
            continue;
        }
        unsigned marker = file.at[at + 1];
        bool frame =
            marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
        if (frame) {
            enlarge(out, big16(file.at + at + 7), big16(file.at + at + 5));
            return true;
        }
        bool alone = marker == 0xff || marker == 0x00 || marker == 0x01 ||
                     (marker >= 0xd0 && marker <= 0xd8);
        if (alone) {
            at += marker == 0xff ? 1 : 2;
        } else {
            at += 2 + (size_t)big16(file.at + at + 2);
        }
    }
    return false;
}

// A NUL-terminated name of an EXR header; its length, or 0 at the header's end or beyond the file.
static size_t exr_name(Bytes file, size_t at)
{
    const unsigned char *end = at < file.size ? memchr(file.at + at, 0, file.size - at) : NULL;
    return end ? (size_t)(end - (file.at + at)) : 0;
}

static void exr_attribute(const char *name, const char *type, Bytes value, PeekedSize *out)
{
    if (strcmp(name, "dataWindow") == 0 && strcmp(type, "box2i") == 0 && value.size >= 16) {
        int64_t x0 = (int32_t)little32(value.at), y0 = (int32_t)little32(value.at + 4);
        int64_t x1 = (int32_t)little32(value.at + 8), y1 = (int32_t)little32(value.at + 12);
        enlarge(out, x1 - x0 + 1, y1 - y0 + 1);
    } else if (strcmp(name, "tiles") == 0 && strcmp(type, "tiledesc") == 0 && value.size >= 8) {
        int64_t width = little32(value.at), height = little32(value.at + 4);
        out->tile_width = width > out->tile_width ? width : out->tile_width;
        out->tile_height = height > out->tile_height ? height : out->tile_height;
    }
}

// Headers of attributes ("name\0type\0size, value"), each ended by an empty name; several, ended by
// an empty one, in a file of several parts (openexr.com, "OpenEXR File Layout").
static bool peek_exr(Bytes file, PeekedSize *out)
{
    enum { MULTI_PART = 0x1000 };
    if (file.size < 9) {
        return false;
    }
    bool many = little32(file.at + 4) & MULTI_PART, empty = true;
    for (size_t at = 8; at < file.size;) {
        if (file.at[at] == 0) { // the end of a header
            if (!many || empty) {
                return out->width > 0 && out->height > 0;
            }
            empty = true;
            ++at;
            continue;
        }
        size_t name = exr_name(file, at), type_at = at + name + 1;
        size_t type = exr_name(file, type_at), size_at = type_at + type + 1;
        if (!name || !type || size_at > file.size || file.size - size_at < 4) {
            return false;
        }
        size_t length = little32(file.at + size_at), value_at = size_at + 4;
        if (length > file.size - value_at) {
            return false;
        }
        exr_attribute((const char *)file.at + at, (const char *)file.at + type_at,
                      (Bytes){file.at + value_at, length}, out);
        empty = false;
        at = value_at + length;
    }
    return false;
}

bool image_peek(const char *format, const void *bytes, size_t size, PeekedSize *out)
{
    static const struct {
        const char *format;
        bool (*peek)(Bytes file, PeekedSize *out);
    } types[] = {{"openexr", peek_exr}, {"png", peek_png}, {"jpeg", peek_jpeg},
                 {"webp", peek_webp},   {"gif", peek_gif}, {"bmp", peek_bmp},
                 {"targa", peek_targa}};
    *out = (PeekedSize){0};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i) {
        if (strcmp(types[i].format, format) == 0) {
            return types[i].peek((Bytes){bytes, size}, out);
        }
    }
    return true;
}
