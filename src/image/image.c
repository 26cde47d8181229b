#include "image/image.h"

#include "base/mem.h"
#include "base/module.h"
#include "base/thread.h"
#include "image/exr_module.h"
#include "image/oiio_module.h"
#include "image/peek.h"
#include "image/png_module.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

// --- Types ---------------------------------------------------------------------------------------

typedef struct WriteType {
    const char *extension, *format; // OpenImageIO's name
    int bits;                       // the type's own
    int allowed[3];                 // all it can have
    bool layers, alpha;
} WriteType;

static const WriteType write_types[] = {
    {"exr", "openexr", 32, {16, 32}, true, true},  {"png", "png", 8, {8, 16}, false, true},
    {"tif", "tiff", 16, {8, 16, 32}, false, true}, {"tiff", "tiff", 16, {8, 16, 32}, false, true},
    {"hdr", "hdr", 32, {32}, false, false},        {"jpg", "jpeg", 8, {8}, false, false},
    {"jpeg", "jpeg", 8, {8}, false, false},        {"webp", "webp", 8, {8}, false, true},
    {"bmp", "bmp", 8, {8}, false, false},          {"tga", "targa", 8, {8}, false, true},
    {"ppm", "pnm", 8, {8, 16}, false, false},
};

static const char *extension_of(const char *name)
{
    const char *slash = strrchr(name, '/'), *file = slash ? slash + 1 : name;
    const char *dot = strrchr(file, '.');
    return dot && dot > file ? dot + 1 : "";
}

static const WriteType *write_type(const char *name)
{
    const char *extension = extension_of(name);
    for (size_t i = 0; i < sizeof write_types / sizeof write_types[0]; ++i) {
        if (strcasecmp(write_types[i].extension, extension) == 0) {
            return &write_types[i];
        }
    }
    return NULL;
}

static bool is_png(const char *format)
{
    return strcmp(format, "png") == 0;
}

static bool is_exr(const char *format)
{
    return strcmp(format, "openexr") == 0;
}

bool image_can_write(const char *name)
{
    return write_type(name) != NULL;
}

bool image_has_bits(const char *name, int bits)
{
    const WriteType *type = write_type(name);
    bool found = bits == 0 && type;
    for (size_t i = 0; type && i < sizeof type->allowed / sizeof type->allowed[0]; ++i) {
        found |= bits != 0 && type->allowed[i] == bits;
    }
    return found;
}

bool image_is_linear(const char *name, int bits)
{
    const WriteType *type = write_type(name);
    return type && (is_exr(type->format) || (bits ? bits : type->bits) == 32);
}

bool image_has_layers(const char *name)
{
    const WriteType *type = write_type(name);
    return type && type->layers;
}

const char *image_extensions(void)
{
    return "exr, png, tif, tiff, hdr, jpg, jpeg, webp, bmp, tga, ppm";
}

// The type of a file by its first bytes or, where they say nothing (Targa), by its name.
static const char *read_format(const char *name, const unsigned char *bytes, size_t size)
{
    static const struct {
        const char *format, *magic;
        size_t length, at;
    } types[] = {
        {"openexr", "\x76\x2f\x31\x01", 4, 0},
        {"png", "\x89PNG\r\n\x1a\n", 8, 0},
        {"jpeg", "\xff\xd8\xff", 3, 0},
        {"tiff", "II*\0", 4, 0},
        {"tiff", "MM\0*", 4, 0},
        {"tiff", "II+\0", 4, 0},
        {"tiff", "MM\0+", 4, 0},
        {"hdr", "#?RADIANCE", 10, 0},
        {"hdr", "#?RGBE", 6, 0},
        {"webp", "WEBPVP8", 7, 8},
        {"gif", "GIF87a", 6, 0},
        {"gif", "GIF89a", 6, 0},
        {"bmp", "BM", 2, 0},
    };
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i) {
        if (size >= types[i].at + types[i].length &&
            memcmp(bytes + types[i].at, types[i].magic, types[i].length) == 0) {
            return types[i].format;
        }
    }
    if (size >= 3 && bytes[0] == 'P' && strchr("123456Ff", bytes[1]) && bytes[1] &&
        strchr(" \t\r\n#", bytes[2]) && bytes[2]) {
        return "pnm";
    }
    return strcasecmp(extension_of(name), "tga") == 0 ? "targa" : NULL;
}

// --- The modules ---------------------------------------------------------------------------------

static const void *module_functions(const char *name, const char *library, const char *symbol,
                                    uint32_t wanted, char *message, size_t message_size)
{
    char why[512];
    void *module = module_open(name, why, sizeof why);
    if (!module) {
        snprintf(message, message_size, "%s can't be loaded: %.400s", library, why);
        return NULL;
    }
    const void *table = module_symbol(module, symbol);
    uint32_t version = 0; // a table begins with it
    if (table) {
        memcpy(&version, table, sizeof version);
    }
    if (version != wanted) {
        snprintf(message, message_size, "the module %s belongs to another version of scnrender",
                 name);
        return NULL;
    }
    return table;
}

// Libraries behind OpenImageIO start threads as they are loaded, and end the program where they
// can't.
static const OiioFunctions *oiio_functions(char *message, size_t message_size)
{
    enum { THREADS_STARTED = 12 };
    static atomic_bool loaded;
    if (!atomic_load(&loaded) && !thread_can_start(THREADS_STARTED)) {
        snprintf(message, message_size, "the system gives OpenImageIO no threads");
        return NULL;
    }
    atomic_store(&loaded, true);
    return module_functions("scn_oiio", "OpenImageIO", "scn_oiio_functions", OIIO_MODULE_VERSION,
                            message, message_size);
}

static const PngFunctions *png_functions(char *message, size_t message_size)
{
    return module_functions("scn_png", "libpng", "scn_png_functions", PNG_MODULE_VERSION, message,
                            message_size);
}

static const ExrFunctions *exr_functions(char *message, size_t message_size)
{
    return module_functions("scn_exr", "OpenEXR", "scn_exr_functions", EXR_MODULE_VERSION, message,
                            message_size);
}

// What writes a type of pictures.
typedef enum Writer { WRITER_PNG, WRITER_EXR, WRITER_OIIO } Writer;

// A module that is there, but can't be loaded, is an error: a system that has no memory or
// descriptors for it has none for OpenImageIO.
static Writer writer_of(const WriteType *type)
{
    if (is_png(type->format)) {
        return WRITER_PNG;
    }
    return is_exr(type->format) && module_exists("scn_exr") ? WRITER_EXR : WRITER_OIIO;
}

bool image_available(const char *name, char *message, size_t message_size)
{
    const WriteType *type = write_type(name);
    switch (type ? writer_of(type) : WRITER_OIIO) {
    case WRITER_PNG:
        return png_functions(message, message_size) != NULL;
    case WRITER_EXR:
        return exr_functions(message, message_size) != NULL;
    case WRITER_OIIO:
        break;
    }
    return oiio_functions(message, message_size) != NULL;
}

static void *preload_main(void *nothing)
{
    char message[512];
    oiio_functions(message, sizeof message); // a failure is told by whoever needs the module
    return nothing;
}

void image_preload(const char *name)
{
    const WriteType *type = write_type(name);
    pthread_t thread;
    if (type && writer_of(type) != WRITER_OIIO) {
        return; // there is nothing to wait for
    }
    if (thread_start(&thread, NULL, preload_main, NULL)) {
        pthread_detach(thread);
    }
}

// Decoders take memory by rows and tiles as soon as they open a file, so that its size is looked at
// before.
static bool size_is_allowed(const char *format, const void *bytes, size_t size, ImageLimits limits,
                            char *message, size_t message_size)
{
    enum { LONGEST_SIDE = 1 << 18, LARGEST_TILE = 1 << 24 };
    PeekedSize peeked;
    if (!image_peek(format, bytes, size, &peeked)) {
        snprintf(message, message_size, "its header is damaged");
        return false;
    }
    if (peeked.width > LONGEST_SIDE || peeked.height > LONGEST_SIDE ||
        peeked.tile_width > LONGEST_SIDE || peeked.tile_height > LONGEST_SIDE ||
        peeked.width * peeked.height > limits.max_pixels ||
        peeked.tile_width * peeked.tile_height > LARGEST_TILE) {
        snprintf(message, message_size, "its %lld x %lld pixels are more than allowed",
                 (long long)peeked.width, (long long)peeked.height);
        return false;
    }
    return true;
}

static bool read_png(const void *bytes, size_t size, ImageLimits limits, Image *out, char *message,
                     size_t message_size)
{
    const PngFunctions *png = png_functions(message, message_size);
    PngRead read = {.bytes = bytes,
                    .size = size,
                    .max_pixels = limits.max_pixels,
                    .memory = {mem_alloc_zeroed, mem_free}};
    if (!png || !png->read(&read, message, message_size)) {
        return false;
    }
    *out = (Image){read.width, read.height, read.channels, read.pixels, read.srgb_encoded};
    return true;
}

static bool read_any(const char *format, const void *bytes, size_t size, ImageLimits limits,
                     Image *out, char *message, size_t message_size)
{
    const OiioFunctions *oiio = oiio_functions(message, message_size);
    OiioRead read = {.format = format,
                     .bytes = bytes,
                     .size = size,
                     .max_pixels = limits.max_pixels,
                     .allocate = mem_alloc_zeroed,
                     .release = mem_free};
    if (!oiio || !oiio->read(&read, message, message_size)) {
        return false;
    }
    *out = (Image){read.width, read.height, read.channels, read.pixels, read.srgb_encoded};
    return true;
}

// OpenImageIO 2.4 believes the length that a JPEG file's IPTC data say of themselves, and reads up
// to 64 KB beyond their end. They bear on no pixel: such a file is read from a copy in which they
// don't go by the name under which it looks for them.
static bool read_jpeg(const char *format, const void *bytes, size_t size, ImageLimits limits,
                      Image *out, char *message, size_t message_size)
{
    static const char iptc[] = "Photoshop 3.0";
    const size_t length = sizeof iptc - 1;
    if (!memmem(bytes, size, iptc, length)) {
        return read_any(format, bytes, size, limits, out, message, message_size);
    }
    char *copy = mem_alloc(size, 1);
    if (!copy) {
        snprintf(message, message_size, "there is not enough memory for it");
        return false;
    }
    memcpy(copy, bytes, size);
    for (char *at = copy; (at = memmem(at, size - (size_t)(at - copy), iptc, length));) {
        *at = '-';
    }
    const bool good = read_any(format, copy, size, limits, out, message, message_size);
    mem_free(copy);
    return good;
}

// What isn't there for the taking, OpenImageIO reads, or says why not.
static bool read_exr(const char *format, const void *bytes, size_t size, ImageLimits limits,
                     Image *out, char *message, size_t message_size)
{
    ExrReading reading = EXR_NOT_READ;
    ExrRead read = {.bytes = bytes,
                    .size = size,
                    .max_pixels = limits.max_pixels,
                    .memory = {mem_alloc_zeroed, mem_free}};
    if (module_exists("scn_exr")) {
        const ExrFunctions *exr = exr_functions(message, message_size);
        if (!exr) {
            return false;
        }
        reading = exr->read(&read);
    }
    switch (reading) {
    case EXR_IS_READ:
        *out = (Image){read.width, read.height, read.channels, read.pixels, false};
        return true;
    case EXR_NO_MEMORY:
        snprintf(message, message_size, "there is not enough memory for it");
        return false;
    case EXR_NOT_READ:
        break;
    }
    return read_any(format, bytes, size, limits, out, message, message_size);
}

bool image_read(const char *name, const void *bytes, size_t size, ImageLimits limits, Image *out,
                char *message, size_t message_size)
{
    *out = (Image){0};
    const char *format = read_format(name, bytes, size);
    if (!format) {
        snprintf(message, message_size, "this is not an image of a type that can be read");
        return false;
    }
    if (!size_is_allowed(format, bytes, size, limits, message, message_size)) {
        return false;
    }
    if (is_png(format)) {
        return read_png(bytes, size, limits, out, message, message_size);
    }
    if (strcmp(format, "jpeg") == 0) {
        return read_jpeg(format, bytes, size, limits, out, message, message_size);
    }
    return is_exr(format) ? read_exr(format, bytes, size, limits, out, message, message_size)
                          : read_any(format, bytes, size, limits, out, message, message_size);
}

void image_free(Image *image)
{
    mem_free(image->pixels);
    *image = (Image){0};
}

static OiioSample sample_type(const WriteType *type, int bits)
{
    switch (bits ? bits : type->bits) {
    case 8:
        return OIIO_UINT8;
    case 16:
        return type->layers ? OIIO_HALF : OIIO_UINT16;
    default:
        return OIIO_FLOAT;
    }
}

static int used_channels(const WriteType *type, const ImageLayer *layer)
{
    return layer->channels == 4 && !type->alpha ? 3 : layer->channels;
}

static bool write_png(const char *path, const WriteType *type, const ImageFile *file, char *message,
                      size_t message_size)
{
    const PngFunctions *png = png_functions(message, message_size);
    if (!png) {
        return false;
    }
    PngText *texts = mem_alloc((size_t)file->attribute_count, sizeof *texts);
    if (!texts) {
        snprintf(message, message_size, "not enough memory");
        return false;
    }
    for (int i = 0; i < file->attribute_count; ++i) {
        texts[i] = (PngText){file->attributes[i].name, file->attributes[i].text};
    }
    const ImageLayer *layer = &file->layers[0];
    PngWrite write = {.path = path,
                      .width = file->width,
                      .height = file->height,
                      .bits = file->bits ? file->bits : type->bits,
                      .channels = layer->channels,
                      .used = used_channels(type, layer),
                      .pixels = layer->pixels,
                      .texts = texts,
                      .text_count = file->attribute_count,
                      .memory = {mem_alloc_zeroed, mem_free},
                      .parallel = parallel_for,
                      .threads = file->threads};
    bool written = png->write(&write, message, message_size);
    mem_free(texts);
    return written;
}

static bool write_exr(const char *path, const WriteType *type, const ImageFile *file, char *message,
                      size_t message_size)
{
    const ExrFunctions *exr = exr_functions(message, message_size);
    const ExrWrite write = {.path = path,
                            .file = file,
                            .bits = file->bits ? file->bits : type->bits,
                            .memory = {mem_alloc_zeroed, mem_free}};
    return exr && exr->write(&write, message, message_size);
}

static bool write_layers(const OiioFunctions *oiio, const char *path, const char *format_of,
                         const WriteType *type, const ImageFile *file, OiioLayer *layers,
                         OiioText *texts, char *message, size_t message_size)
{
    int count = type->layers ? file->layer_count : 1;
    for (int i = 0; i < count; ++i) {
        const ImageLayer *layer = &file->layers[i];
        layers[i] = (OiioLayer){layer->name,     layer->channels, used_channels(type, layer),
                                layer->suffixes, layer->pixels,   layer->ids};
    }
    for (int i = 0; i < file->attribute_count; ++i) {
        texts[i] = (OiioText){file->attributes[i].name, file->attributes[i].text};
    }
    OiioWrite write = {.format = type->format,
                       .extension = type->extension,
                       .path = path,
                       .width = file->width,
                       .height = file->height,
                       .sample = sample_type(type, file->bits),
                       .linear = image_is_linear(format_of, file->bits),
                       .layers = layers,
                       .layer_count = count,
                       .texts = texts,
                       .text_count = file->attribute_count};
    return oiio->write(&write, message, message_size);
}

static bool write_any(const char *path, const char *format_of, const WriteType *type,
                      const ImageFile *file, char *message, size_t message_size)
{
    const OiioFunctions *oiio = oiio_functions(message, message_size);
    if (!oiio) {
        return false;
    }
    OiioLayer *layers = mem_alloc((size_t)file->layer_count, sizeof *layers);
    OiioText *texts = mem_alloc((size_t)file->attribute_count, sizeof *texts);
    bool written = false;
    if (layers && texts) {
        written =
            write_layers(oiio, path, format_of, type, file, layers, texts, message, message_size);
    } else {
        snprintf(message, message_size, "not enough memory");
    }
    mem_free(layers);
    mem_free(texts);
    return written;
}

bool image_write(const char *path, const char *format_of, const ImageFile *file, char *message,
                 size_t message_size)
{
    const WriteType *type = write_type(format_of);
    if (!type || !image_has_bits(format_of, file->bits)) {
        snprintf(message, message_size, "images can be written as %s", image_extensions());
        return false;
    }
    switch (writer_of(type)) {
    case WRITER_PNG:
        return write_png(path, type, file, message, message_size);
    case WRITER_EXR:
        return write_exr(path, type, file, message, message_size);
    case WRITER_OIIO:
        break;
    }
    return write_any(path, format_of, type, file, message, message_size);
}
