#include "cli/sheet.h"

#include "base/io.h"
#include "base/mem.h"
#include "cli/picture.h"
#include "image/image.h"
#include "image/lettering.h"
#include "image/peek.h"
#include "render/film.h"
#include "render/texture_image.h"

#include <math.h>
#include <string.h>

enum {
    LONGEST_SIDE = 16384,
    MOST_PIXELS = 1 << 24,
    MOST_PICTURE_PIXELS = 1 << 28,
    IN_ONE_ROW = 6,    // a single sweep of more values is folded
    LABEL_LENGTH = 24, // most characters of a row's label
    TEXT_SIZE = 512,
    WIDTH_FOR_SCALE = 850, // so many pixels of the sheet for each step of the letters' size
};

static const float PAPER[3] = {0.94f, 0.94f, 0.94f}, INK[3] = {0.1f, 0.1f, 0.1f},
                   FAINT[3] = {0.45f, 0.45f, 0.45f}, EMPTY[3] = {0.85f, 0.85f, 0.85f};

// In pixels.
typedef struct Layout {
    size_t columns, rows, blocks;
    bool folded;
    int shrink; // how many pixels of a picture, in each direction, become one
    int scale;  // of the letters
    int cell_width, cell_height;
    int margin, gap, line; // line: a line of text with what is free around it
    int label_width;       // of the rows' labels
    int block_height, width, height;
} Layout;

// --- Words ---------------------------------------------------------------------------------------

static void label_text(const Sweep *sweep, size_t value, char *text, size_t size)
{
    snprintf(text, size, "%s = %s", sweep->name, sweep->values[value]);
}

// What all pictures of a block have in common: the values from the third sweep on.
static void block_text(const Sheet *sheet, size_t block, char *text, size_t size)
{
    size_t length = 0;
    text[0] = '\0';
    for (size_t i = 2; i < sheet->sweep_count && length < size; ++i) {
        const Sweep *sweep = &sheet->sweeps[i];
        const int n = snprintf(text + length, size - length, "%s%s = %s", length ? "   " : "",
                               sweep->name, sweep->values[block % sweep->count]);
        block /= sweep->count;
        length += n > 0 ? (size_t)n : 0;
    }
}

static size_t missing_count(const Sheet *sheet)
{
    size_t count = 0;
    for (size_t i = 0; i < sheet->cell_count; ++i) {
        count += !sheet->cells[i].picture;
    }
    return count;
}

// --- Layout --------------------------------------------------------------------------------------

static void arrange(const Sheet *sheet, Layout *l)
{
    const size_t first = sheet->sweeps[0].count;
    l->folded = sheet->sweep_count == 1 && first > IN_ONE_ROW;
    l->columns = l->folded ? (size_t)ceil(sqrt((double)first)) : first;
    l->rows = l->folded ? (first + l->columns - 1) / l->columns
                        : (sheet->sweep_count > 1 ? sheet->sweeps[1].count : 1);
    l->blocks = l->folded ? 1 : sheet->cell_count / (l->columns * l->rows);
}

static int label_width(const Sheet *sheet, const Layout *l)
{
    size_t most = 0;
    for (size_t row = 0; sheet->sweep_count > 1 && row < l->rows; ++row) {
        char text[TEXT_SIZE];
        label_text(&sheet->sweeps[1], row, text, sizeof text);
        const size_t count = letter_count(text);
        most = count > most ? count : most;
    }
    most = most < LABEL_LENGTH ? most : LABEL_LENGTH;
    return most ? (int)most * LETTER_WIDTH * l->scale + l->margin : 0;
}

static double rounded(double number, double least, double most)
{
    return fmax(least, fmin(most, floor(number + 0.5)));
}

// Everything that follows from how far the pictures (of at most width x height) are shrunk. False
// where the sheet would be too large.
static bool measure(const Sheet *sheet, int width, int height, int shrink, Layout *l)
{
    const double columns = (double)l->columns, rows = (double)l->rows, blocks = (double)l->blocks;
    l->shrink = shrink;
    l->cell_width = (width + shrink - 1) / shrink;
    l->cell_height = (height + shrink - 1) / shrink;
    l->scale = (int)rounded(columns * l->cell_width / WIDTH_FOR_SCALE, 1, 16);
    l->margin = 8 * l->scale;
    l->gap = 4 * l->scale;
    l->line = (LETTER_HEIGHT + 5) * l->scale;
    l->label_width = label_width(sheet, l);
    const double label_lines = (l->folded ? rows : 1) + (blocks > 1 ? 1 : 0);
    const double block_height = label_lines * l->line + rows * (l->cell_height + l->gap);
    const double all_width =
        2.0 * l->margin + l->label_width + columns * (l->cell_width + l->gap) - l->gap;
    const double all_height =
        2.0 * l->margin + l->line + blocks * (block_height + l->margin) - l->margin - l->gap;
    if (all_width > LONGEST_SIDE || all_height > LONGEST_SIDE ||
        all_width * all_height > MOST_PIXELS) {
        return false;
    }
    l->block_height = (int)block_height + l->margin;
    l->width = (int)all_width;
    l->height = (int)all_height;
    return true;
}

// --- Pictures ------------------------------------------------------------------------------------

static bool read_bytes(const char *path, FileBytes *bytes, char *message, size_t size)
{
    const IoError error = file_read(path, (uint64_t)1 << 34, bytes);
    if (error != IO_OK) {
        snprintf(message, size, "can't read `%.300s`: %s", path, io_error_text(error));
    }
    return error == IO_OK;
}

// The largest width and height of the pictures.
static bool find_size(const Sheet *sheet, int *width, int *height, char *message, size_t size)
{
    *width = *height = 1;
    for (size_t i = 0; i < sheet->cell_count; ++i) {
        const char *path = sheet->cells[i].picture;
        FileBytes bytes;
        PeekedSize peeked = {0};
        if (!path) {
            continue;
        }
        if (!read_bytes(path, &bytes, message, size)) {
            return false;
        }
        const bool good = image_peek("png", bytes.bytes, bytes.size, &peeked) &&
                          peeked.width <= 1 << 20 && peeked.height <= 1 << 20;
        file_bytes_free(&bytes);
        if (!good) {
            snprintf(message, size, "`%.300s` is no sound PNG", path);
            return false;
        }
        *width = peeked.width > *width ? (int)peeked.width : *width;
        *height = peeked.height > *height ? (int)peeked.height : *height;
    }
    return true;
}

// The mean of the light that a square of pixels sends, encoded again.
static void mean_pixel(const Image *image, int left, int top, int side, float out[3])
{
    const int right = left + side < image->width ? left + side : image->width;
    const int bottom = top + side < image->height ? top + side : image->height;
    double sum[3] = {0};
    for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
            const float *pixel = image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) *
                                                     (size_t)image->channels;
            for (int c = 0; c < 3; ++c) {
                sum[c] += (double)srgb_decode(pixel[image->channels < 3 ? 0 : c]);
            }
        }
    }
    const double count = (double)(right - left) * (bottom - top);
    for (int c = 0; c < 3; ++c) {
        out[c] = tone_encode(TONE_SRGB, (float)(sum[c] / count));
    }
}

static void draw_image(const Canvas *canvas, const Layout *l, const Image *image, int x, int y)
{
    const int width = (image->width + l->shrink - 1) / l->shrink;
    const int height = (image->height + l->shrink - 1) / l->shrink;
    x += (l->cell_width - width) / 2;
    y += (l->cell_height - height) / 2;
    for (int row = 0; row < height; ++row) {
        float *at = canvas->pixels + 3 * ((size_t)(y + row) * (size_t)canvas->width + (size_t)x);
        for (int column = 0; column < width; ++column, at += 3) {
            mean_pixel(image, column * l->shrink, row * l->shrink, l->shrink, at);
        }
    }
}

static bool draw_picture(const Canvas *canvas, const Layout *l, const char *path, int x, int y,
                         char *message, size_t size)
{
    FileBytes bytes;
    Image image;
    if (!read_bytes(path, &bytes, message, size)) {
        return false;
    }
    char why[300];
    const bool good = image_read(path, bytes.bytes, bytes.size, (ImageLimits){MOST_PICTURE_PIXELS},
                                 &image, why, sizeof why);
    file_bytes_free(&bytes);
    if (!good) {
        snprintf(message, size, "can't read `%.300s`: %s", path, why);
        return false;
    }
    if (image.width <= l->cell_width * l->shrink && image.height <= l->cell_height * l->shrink) {
        draw_image(canvas, l, &image, x, y);
    }
    image_free(&image);
    return true;
}

// --- Drawing -------------------------------------------------------------------------------------

// A text in a box of that width, in its middle or at its left.
static void draw_text(const Canvas *canvas, const Layout *l, int x, int y, int width, bool middle,
                      const char *text, const float ink[3])
{
    char fitting[TEXT_SIZE];
    letter_shorten(text, (size_t)(width / (LETTER_WIDTH * l->scale)), fitting, sizeof fitting);
    const int used = (int)letter_count(fitting) * LETTER_WIDTH * l->scale;
    letter_text(canvas, middle ? x + (width - used) / 2 : x, y, l->scale, fitting, ink);
}

// "name = value", or the value alone where there is no room for both.
static void draw_label(const Canvas *canvas, const Layout *l, int x, int y, const Sweep *sweep,
                       size_t value)
{
    char text[TEXT_SIZE];
    label_text(sweep, value, text, sizeof text);
    const bool fits = letter_count(text) <= (size_t)(l->cell_width / (LETTER_WIDTH * l->scale));
    draw_text(canvas, l, x, y, l->cell_width, true, fits ? text : sweep->values[value], INK);
}

static bool draw_cell(const Sheet *sheet, const Canvas *canvas, const Layout *l, size_t number,
                      int x, int y, char *message, size_t size)
{
    const SheetCell *cell = &sheet->cells[number];
    if (cell->picture) {
        return draw_picture(canvas, l, cell->picture, x, y, message, size);
    }
    canvas_fill(canvas, x, y, l->cell_width, l->cell_height, EMPTY);
    draw_text(canvas, l, x, y + (l->cell_height - LETTER_HEIGHT * l->scale) / 2, l->cell_width,
              true, cell->why, FAINT);
    return true;
}

static bool draw_row(const Sheet *sheet, const Canvas *canvas, const Layout *l, size_t block,
                     size_t row, int *y, char *message, size_t size)
{
    const int left = l->margin + l->label_width, step = l->cell_width + l->gap;
    const size_t first = (block * l->rows + row) * l->columns;
    const bool labelled = l->folded || row == 0;
    for (size_t column = 0; labelled && column < l->columns; ++column) {
        const size_t value = l->folded ? first + column : column;
        if (value < sheet->sweeps[0].count) {
            draw_label(canvas, l, left + (int)column * step, *y, &sheet->sweeps[0], value);
        }
    }
    *y += labelled ? l->line : 0;
    if (sheet->sweep_count > 1) {
        char text[TEXT_SIZE];
        label_text(&sheet->sweeps[1], row, text, sizeof text);
        draw_text(canvas, l, l->margin, *y + (l->cell_height - LETTER_HEIGHT * l->scale) / 2,
                  l->label_width - l->margin, false, text, INK);
    }
    bool good = true;
    for (size_t column = 0; good && column < l->columns && first + column < sheet->cell_count;
         ++column) {
        good = draw_cell(sheet, canvas, l, first + column, left + (int)column * step, *y, message,
                         size);
    }
    *y += l->cell_height + l->gap;
    return good;
}

static bool draw_block(const Sheet *sheet, const Canvas *canvas, const Layout *l, size_t block,
                       int y, char *message, size_t size)
{
    if (l->blocks > 1) {
        char text[TEXT_SIZE];
        block_text(sheet, block, text, sizeof text);
        draw_text(canvas, l, l->margin, y, l->width - 2 * l->margin, false, text, INK);
        y += l->line;
    }
    bool good = true;
    for (size_t row = 0; good && row < l->rows; ++row) {
        good = draw_row(sheet, canvas, l, block, row, &y, message, size);
    }
    return good;
}

static bool draw(const Sheet *sheet, const Canvas *canvas, const Layout *l, char *message,
                 size_t size)
{
    char title[TEXT_SIZE];
    const size_t missing = missing_count(sheet);
    canvas_fill(canvas, 0, 0, l->width, l->height, PAPER);
    if (missing) {
        snprintf(title, sizeof title, "%zu of %zu missing · %s", missing, sheet->cell_count,
                 sheet->title);
    } else {
        snprintf(title, sizeof title, "%s", sheet->title);
    }
    draw_text(canvas, l, l->margin, l->margin, l->width - 2 * l->margin, false, title, FAINT);
    bool good = true;
    for (size_t block = 0; good && block < l->blocks; ++block) {
        good = draw_block(sheet, canvas, l, block,
                          l->margin + l->line + (int)block * l->block_height, message, size);
    }
    return good;
}

// --- The file ------------------------------------------------------------------------------------

static int write_canvas(const Canvas *canvas, const char *title, const char *path, char *message,
                        size_t size)
{
    static const char *const names[] = {"R", "G", "B"};
    const ImageLayer layer = {"", 3, names, canvas->pixels, NULL};
    const ImageAttribute attributes[] = {{"Software", "scnrender " SCN_VERSION},
                                         {"ImageDescription", title}};
    const ImageFile file = {canvas->width, canvas->height, 0, &layer, 1, attributes, 2, 1};
    Arena arena = {0};
    const int code = picture_replace(path, &file, &arena, message, size);
    arena_free(&arena);
    return code;
}

int sheet_write(const Sheet *sheet, const char *path, char *message, size_t message_size)
{
    Layout layout = {0};
    int width, height, shrink = 1;
    if (!find_size(sheet, &width, &height, message, message_size)) {
        return EXIT_FILES;
    }
    arrange(sheet, &layout);
    while (!measure(sheet, width, height, shrink, &layout)) {
        if (++shrink > (width > height ? width : height)) {
            snprintf(message, message_size, "%zu pictures are too many for one sheet",
                     sheet->cell_count);
            return EXIT_FILES;
        }
    }
    const Canvas canvas = {
        layout.width, layout.height,
        mem_alloc((size_t)layout.width * (size_t)layout.height, 3 * sizeof(float))};
    if (!canvas.pixels) {
        snprintf(message, message_size, "not enough memory for the sheet");
        return EXIT_NO_MEMORY;
    }
    const int code = draw(sheet, &canvas, &layout, message, message_size)
                         ? write_canvas(&canvas, sheet->title, path, message, message_size)
                         : EXIT_FILES;
    mem_free(canvas.pixels);
    return code;
}
