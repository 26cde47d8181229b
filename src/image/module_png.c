// PNG files by libpng; the module that image.c loads for them. See png_module.h.
#include "image/module_png_bands.h"

#include <errno.h>
#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

extern const PngFunctions scn_png_functions;

// A file being read or written. libpng leaves its functions by a jump when something is wrong: so
// whatever must be given back lies here, and no function that sets the jump has locals of its own.
typedef struct Work {
    png_structp png;
    png_infop info;
    PngMemory memory;
    void *row;   // one row of the file's samples; of an interlaced file, all rows
    void **rows; // of an interlaced file
    char *message;
    size_t message_size;
    FILE *file;                    // being written
    PngBands bands;                // its pixels
    int code;                      // errno of its first failure
    const unsigned char *at, *end; // being read
    jmp_buf failed;
} Work;

// --- What libpng calls ---------------------------------------------------------------------------

static void on_error(png_structp png, png_const_charp text)
{
    Work *work = png_get_error_ptr(png);
    snprintf(work->message, work->message_size, "%s", *text ? text : "it is damaged");
    for (char *c = work->message; *c; ++c) { // a chunk's name may be anything
        *c = (unsigned char)*c < 0x20 || *c == 0x7f ? '?' : *c;
    }
    longjmp(work->failed, 1);
}

static void on_warning(png_structp png, png_const_charp text)
{
    (void)png;
    (void)text;
}

static void *on_malloc(png_structp png, png_alloc_size_t size)
{
    const Work *work = png_get_mem_ptr(png);
    return work->memory.allocate(1, size);
}

static void on_free(png_structp png, void *block)
{
    const Work *work = png_get_mem_ptr(png);
    work->memory.release(block);
}

static void on_write(png_structp png, png_bytep bytes, size_t size)
{
    Work *work = png_get_io_ptr(png);
    errno = 0;
    if (fwrite(bytes, 1, size, work->file) != size) {
        work->code = errno ? errno : EIO;
        png_error(png, "it can't be written");
    }
}

// libpng's own way to write pixels has them compressed by one thread.
static void on_compressed(void *context, const void *bytes, size_t size)
{
    const Work *work = context;
    png_write_chunk(work->png, (png_const_bytep) "IDAT", bytes, size);
}

static void on_flush(png_structp png)
{
    (void)png; // when the file is closed
}

static void on_read(png_structp png, png_bytep bytes, size_t size)
{
    Work *work = png_get_io_ptr(png);
    if ((size_t)(work->end - work->at) < size) {
        png_error(png, "it ends too early");
    }
    memcpy(bytes, work->at, size);
    work->at += size;
}

static void *take(const Work *work, size_t count, size_t size)
{
    void *block = work->memory.allocate(count, size);
    if (!block) {
        png_error(work->png, "there is not enough memory for it");
    }
    return block;
}

static void give_back(Work *work)
{
    if (work->row) {
        work->memory.release(work->row);
    }
    if (work->rows) {
        work->memory.release(work->rows);
    }
}

// --- Writing -------------------------------------------------------------------------------------

static bool is_ascii(const char *text)
{
    while (*text && !((unsigned char)*text & 0x80)) {
        ++text;
    }
    return !*text;
}

static void write_texts(const Work *work, const PngWrite *write)
{
    for (int i = 0; i < write->text_count; ++i) {
        const PngText *text = &write->texts[i];
        // A tEXt chunk is Latin-1.
        png_text chunk = {.compression = is_ascii(text->text) ? PNG_TEXT_COMPRESSION_NONE
                                                              : PNG_ITXT_COMPRESSION_NONE,
                          .key = (char *)(uintptr_t)text->name,
                          .text = (char *)(uintptr_t)text->text};
        png_set_text(work->png, work->info, &chunk, 1);
    }
}

static void write_picture(Work *work, const PngWrite *write)
{
    static const int color_types[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                      PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
    png_set_write_fn(work->png, work, on_write, on_flush);
    png_set_IHDR(work->png, work->info, (png_uint_32)write->width, (png_uint_32)write->height,
                 write->bits, color_types[write->used - 1], PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(work->png, work->info, PNG_sRGB_INTENT_ABSOLUTE);
    write_texts(work, write);
    png_write_info(work->png, work->info);
    if (!png_bands_write(&work->bands, write, on_compressed, work)) {
        png_error(work->png, "there is not enough memory to write it");
    }
    png_write_chunk(work->png, (png_const_bytep) "IEND", NULL, 0);
}

static bool try_writing(Work *work, const PngWrite *write)
{
    if (setjmp(work->failed)) {
        return false;
    }
    work->png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, work, on_error, on_warning, work,
                                          on_malloc, on_free);
    work->info = work->png ? png_create_info_struct(work->png) : NULL;
    if (!work->info) {
        snprintf(work->message, work->message_size, "there is not enough memory to write it");
        return false;
    }
    write_picture(work, write);
    return true;
}

static bool write_png(const PngWrite *write, char *message, size_t message_size)
{
    Work work = {.memory = write->memory, .message = message, .message_size = message_size};
    work.file = fopen(write->path, "wb");
    if (!work.file) {
        snprintf(message, message_size, "%s", strerror(errno));
        return false;
    }
    bool good = try_writing(&work, write);
    png_destroy_write_struct(&work.png, &work.info);
    png_bands_free(&work.bands, &work.memory);
    errno = 0;
    if (fclose(work.file) != 0 && work.code == 0) {
        work.code = errno ? errno : EIO;
    }
    if (work.code != 0) {
        snprintf(message, message_size, "%s", strerror(work.code));
    }
    return good && work.code == 0;
}

// --- Reading -------------------------------------------------------------------------------------

// Whole numbers are sRGB-encoded unless the file says that they aren't.
static bool is_srgb_encoded(const Work *work)
{
    int intent;
    double gamma;
    if (png_get_sRGB(work->png, work->info, &intent) ||
        !png_get_gAMA(work->png, work->info, &gamma)) {
        return true;
    }
    return !(fabs(round(100 / gamma) / 100 - 1) <= 0.01);
}

// Palettes become colors, transparent colors alpha, and fewer than eight bits eight.
static void read_header(Work *work, PngRead *read)
{
    png_set_read_fn(work->png, work, on_read);
    png_read_info(work->png, work->info);
    const int64_t width = png_get_image_width(work->png, work->info);
    const int64_t height = png_get_image_height(work->png, work->info);
    if (width * height > read->max_pixels) {
        png_error(work->png, "it has more pixels than allowed");
    }
    read->srgb_encoded = is_srgb_encoded(work);
    png_set_expand(work->png);
    if (png_get_interlace_type(work->png, work->info) != PNG_INTERLACE_NONE) {
        png_set_interlace_handling(work->png);
    }
    png_read_update_info(work->png, work->info);
    read->width = (int)width;
    read->height = (int)height;
    read->channels = png_get_channels(work->png, work->info);
}

// A row of samples as fractions of their largest.
static void to_floats(const unsigned char *samples, int bits, size_t count, float *out)
{
    if (bits == 8) {
        for (size_t i = 0; i < count; ++i) {
            out[i] = (float)samples[i] * (1.0f / 255);
        }
    } else {
        for (size_t i = 0; i < count; ++i) {
            out[i] = (float)(samples[2 * i] << 8 | samples[2 * i + 1]) * (1.0f / 65535);
        }
    }
}

static void read_rows(Work *work, PngRead *read)
{
    const int bits = png_get_bit_depth(work->png, work->info);
    const size_t samples = (size_t)read->width * (size_t)read->channels;
    const size_t row_bytes = png_get_rowbytes(work->png, work->info), height = (size_t)read->height;
    const bool whole = png_get_interlace_type(work->png, work->info) != PNG_INTERLACE_NONE;
    read->pixels = take(work, samples * height, sizeof *read->pixels);
    work->row = take(work, whole ? height : 1, row_bytes);
    if (whole) {
        work->rows = take(work, height, sizeof *work->rows);
        for (size_t y = 0; y < height; ++y) {
            work->rows[y] = (char *)work->row + y * row_bytes;
        }
        png_read_image(work->png, (png_bytepp)work->rows);
    }
    for (size_t y = 0; y < height; ++y) {
        if (!whole) {
            png_read_row(work->png, work->row, NULL);
        }
        to_floats(whole ? work->rows[y] : work->row, bits, samples, read->pixels + y * samples);
    }
}

static bool try_reading(Work *work, PngRead *read)
{
    if (setjmp(work->failed)) {
        return false;
    }
    work->png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, work, on_error, on_warning, work,
                                         on_malloc, on_free);
    work->info = work->png ? png_create_info_struct(work->png) : NULL;
    if (!work->info) {
        snprintf(work->message, work->message_size, "there is not enough memory for it");
        return false;
    }
    read_header(work, read);
    read_rows(work, read);
    return true;
}

static bool read_png(PngRead *read, char *message, size_t message_size)
{
    Work work = {.memory = read->memory,
                 .message = message,
                 .message_size = message_size,
                 .at = read->bytes,
                 .end = (const unsigned char *)read->bytes + read->size};
    read->pixels = NULL;
    bool good = try_reading(&work, read);
    png_destroy_read_struct(&work.png, &work.info, NULL);
    give_back(&work);
    if (!good && read->pixels) {
        read->memory.release(read->pixels);
        read->pixels = NULL;
    }
    return good;
}

__attribute__((visibility("default")))
const PngFunctions scn_png_functions = {PNG_MODULE_VERSION, read_png, write_png};
