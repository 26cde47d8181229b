#include "render/adaptive.h"

#include "base/mem.h"

// The first decision falls after so many samples of each stream: a thousand in a cell.
enum { LEAST_SAMPLES = 16 };
// Beyond 64 samples numbers grow by whole blocks: from one decision to the next by one, and by a
// quarter where that is more.
enum { GROWTH = 4 };

static const double floor_share = 0.1; // of the picture's mean luminance

// --- Making it -----------------------------------------------------------------------------------

// The number of standard deviations within which a normal variable stays with that chance.
static double normal_width(double confidence)
{
    double low = 0, high = 40;
    for (int i = 0; i < 100; ++i) {
        const double middle = (low + high) / 2;
        if (erf(middle * 0x1.6a09e667f3bcdp-1) < confidence) { // over √2
            low = middle;
        } else {
            high = middle;
        }
    }
    return high;
}

bool adaptive_init(Adaptive *a, uint32_t width, uint32_t height, StopRule rule, uint32_t samples)
{
    *a = (Adaptive){.error = rule.error,
                    .z = normal_width(rule.confidence),
                    .width = width,
                    .height = height,
                    .columns = (width - 1) / ADAPTIVE_CELL + 1,
                    .rows = (height - 1) / ADAPTIVE_CELL + 1,
                    .most = samples > 2 ? samples / 2 : 1,
                    .state = {.floors = {-1, -1}}};
    const size_t count = (size_t)width * height, cells = (size_t)a->columns * a->rows;
    a->cells = mem_alloc_zeroed(cells, sizeof *a->cells);
    a->kept = mem_alloc_zeroed(count, sizeof *a->kept);
    bool ok = a->cells && a->kept;
    for (int s = 0; s < 2; ++s) {
        a->streams[s] = mem_alloc_zeroed(count, sizeof *a->streams[s]);
        ok = ok && a->streams[s];
    }
    a->expected = 2.0 * a->most * (double)count;
    if (!ok) {
        adaptive_free(a);
    }
    return ok;
}

void adaptive_free(Adaptive *a)
{
    mem_free(a->cells);
    mem_free(a->kept);
    mem_free(a->streams[0]);
    mem_free(a->streams[1]);
    *a = (Adaptive){0};
}

// --- Cells ---------------------------------------------------------------------------------------

typedef struct CellPixels {
    uint32_t x0, y0, x1, y1;
} CellPixels;

static CellPixels cell_pixels(uint32_t width, uint32_t height, uint32_t column, uint32_t row)
{
    const uint32_t x = column * ADAPTIVE_CELL, y = row * ADAPTIVE_CELL;
    return (CellPixels){x, y, width - x < ADAPTIVE_CELL ? width : x + ADAPTIVE_CELL,
                        height - y < ADAPTIVE_CELL ? height : y + ADAPTIVE_CELL};
}

// Over the pixels of a cell: the mean of their luminance, and of its variance.
typedef struct CellLight {
    double luminance, variance;
} CellLight;

static CellLight cell_light(const FilmPixel *pixels, uint32_t width, CellPixels cell)
{
    CellLight sum = {0};
    for (uint32_t y = cell.y0; y < cell.y1; ++y) {
        for (uint32_t x = cell.x0; x < cell.x1; ++x) {
            const FilmPixel *pixel = &pixels[(size_t)y * width + x];
            sum.luminance += film_luminance(pixel);
            sum.variance += film_variance(pixel);
        }
    }
    const double count = (double)(cell.x1 - cell.x0) * (cell.y1 - cell.y0);
    return (CellLight){sum.luminance / count, sum.variance / count};
}

// z standard errors over the light to which they are compared; 0 where there is no light at all.
static double relative_error(double variance, double z, double luminance, double least)
{
    const double light = fmax(luminance, least);
    return light > 0 ? z * sqrt(variance) / light : 0;
}

// --- Deciding ------------------------------------------------------------------------------------

bool adaptive_finished(const Adaptive *a)
{
    if (a->state.done >= a->most) {
        return true;
    }
    for (size_t i = 0; i < (size_t)a->columns * a->rows; ++i) {
        if (adaptive_at_work(&a->cells[i])) {
            return false;
        }
    }
    return true;
}

uint32_t adaptive_next_target(const Adaptive *a)
{
    const uint32_t done = a->state.done;
    uint32_t target = done == 0    ? 1
                      : done == 1  ? 4
                      : done == 4  ? LEAST_SAMPLES
                      : done == 16 ? 32
                                   : SAMPLE_BLOCK;
    if (done >= SAMPLE_BLOCK) {
        const uint32_t blocks = done / SAMPLE_BLOCK, more = blocks / GROWTH;
        target = (blocks + (more > 1 ? more : 1)) * SAMPLE_BLOCK;
    }
    return target < a->most ? target : a->most;
}

// What a stream's errors are relative to is fixed by its first samples, which are always drawn:
// later ones are only there where the other stream asked for them.
static void set_floors(Adaptive *a)
{
    const size_t count = (size_t)a->width * a->height;
    for (int s = 0; s < 2; ++s) {
        double sum = 0;
        for (size_t p = 0; p < count; ++p) {
            sum += film_luminance(&a->streams[s][p]);
        }
        a->state.floors[s] = floor_share * sum / (double)count;
    }
}

// The error that the pixels of a cell have when both streams have `done` samples, as one sees it.
static double error_seen_by(const Adaptive *a, int stream, CellPixels pixels)
{
    const CellLight light = cell_light(a->streams[stream], a->width, pixels);
    return relative_error(light.variance / 2, a->z, light.luminance, a->state.floors[stream]);
}

// Puts away the sums of a stream that is complete while the other isn't.
static void keep(Adaptive *a, int stream, CellPixels cell)
{
    for (uint32_t y = cell.y0; y < cell.y1; ++y) {
        for (uint32_t x = cell.x0; x < cell.x1; ++x) {
            const size_t at = (size_t)y * a->width + x;
            a->kept[at] = a->streams[stream][at];
        }
    }
}

// A pixel from the sums of both streams: with n samples, whose mean is the even mean of the two,
// and whose variance is that of this mean.
static FilmPixel join_streams(const FilmPixel *a, const FilmPixel *b)
{
    if (a->samples == 0 || b->samples == 0) {
        return a->samples ? *a : *b;
    }
    const double na = a->samples, nb = b->samples, n = na + nb;
    FilmPixel out = {.samples = a->samples + b->samples};
    for (int i = 0; i < 3; ++i) {
        out.sum[i] = n * (a->sum[i] / na + b->sum[i] / nb) / 2;
    }
    const double variance = (film_variance(a) + film_variance(b)) / 4;
    const double mean = (film_luminance(a) + film_luminance(b)) / 2;
    out.square_sum = n * ((n - 1) * variance + mean * mean);
    return out;
}

static void show_cell(const Adaptive *a, const AdaptiveCell *cell, CellPixels pixels, Film *film)
{
    for (uint32_t y = pixels.y0; y < pixels.y1; ++y) {
        for (uint32_t x = pixels.x0; x < pixels.x1; ++x) {
            const size_t at = (size_t)y * a->width + x;
            const FilmPixel *kept = &a->kept[at];
            film->pixels[at] = join_streams(cell->enough[0] ? kept : &a->streams[0][at],
                                            cell->enough[1] ? kept : &a->streams[1][at]);
        }
    }
}

// Each stream decides for the other. A cell that is done gets its pixels for good.
static void decide_cell(Adaptive *a, AdaptiveCell *cell, CellPixels pixels, uint32_t done,
                        Film *film)
{
    const AdaptiveCell before = *cell;
    double worst = 0;
    for (int s = 0; s < 2; ++s) {
        if (before.enough[s] == 0) {
            const double error = error_seen_by(a, 1 - s, pixels);
            worst = fmax(worst, error);
            cell->enough[s] = error <= a->error ? done : 0;
        }
    }
    if (!adaptive_at_work(cell)) {
        show_cell(a, &before, pixels, film);
        a->expected += 2.0 * done * (pixels.x1 - pixels.x0) * (pixels.y1 - pixels.y0);
        return;
    }
    for (int s = 0; s < 2; ++s) {
        if (cell->enough[s] != before.enough[s]) {
            keep(a, s, pixels);
        }
    }
    const double ratio = worst / a->error, wanted = done * fmax(ratio * ratio, 1);
    a->expected += 2 * fmin(wanted, a->most) * (pixels.x1 - pixels.x0) * (pixels.y1 - pixels.y0);
}

// Samples that were drawn for a cell that is done.
static double drawn(const AdaptiveCell *cell)
{
    const uint32_t most = cell->enough[0] > cell->enough[1] ? cell->enough[0] : cell->enough[1];
    return 2.0 * most;
}

void adaptive_decide(Adaptive *a, uint32_t done, Film *film)
{
    a->state.done = done;
    if (done < LEAST_SAMPLES) {
        return;
    }
    if (a->state.floors[0] < 0) {
        set_floors(a);
    }
    a->expected = 0;
    for (uint32_t row = 0; row < a->rows; ++row) {
        for (uint32_t column = 0; column < a->columns; ++column) {
            AdaptiveCell *cell = &a->cells[(size_t)row * a->columns + column];
            const CellPixels pixels = cell_pixels(a->width, a->height, column, row);
            if (adaptive_at_work(cell)) {
                decide_cell(a, cell, pixels, done, film);
            } else {
                a->expected += drawn(cell) * (pixels.x1 - pixels.x0) * (pixels.y1 - pixels.y0);
            }
        }
    }
}

void adaptive_show(const Adaptive *a, Film *film)
{
    for (uint32_t row = 0; row < a->rows; ++row) {
        for (uint32_t column = 0; column < a->columns; ++column) {
            const AdaptiveCell *cell = &a->cells[(size_t)row * a->columns + column];
            if (adaptive_at_work(cell)) {
                show_cell(a, cell, cell_pixels(a->width, a->height, column, row), film);
            }
        }
    }
    uint32_t fewest = UINT32_MAX;
    for (size_t p = 0; p < film_pixel_count(film); ++p) {
        fewest = film->pixels[p].samples < fewest ? film->pixels[p].samples : fewest;
    }
    film->samples_done = fewest;
}

// --- The error that was reached ------------------------------------------------------------------

static bool pixels_have_variance(const Film *film)
{
    for (size_t p = 0; p < film_pixel_count(film); ++p) {
        if (film->pixels[p].samples < 2) {
            return false;
        }
    }
    return true;
}

static double film_floor(const Film *film)
{
    double sum = 0;
    for (size_t p = 0; p < film_pixel_count(film); ++p) {
        sum += film_luminance(&film->pixels[p]);
    }
    return floor_share * sum / (double)film_pixel_count(film);
}

FilmError film_error(const Film *film, double confidence, double wanted)
{
    if (!pixels_have_variance(film)) {
        return (FilmError){NAN, NAN, 0};
    }
    const double z = normal_width(confidence), floor = film_floor(film);
    const uint32_t columns = (film->width - 1) / ADAPTIVE_CELL + 1;
    const uint32_t rows = (film->height - 1) / ADAPTIVE_CELL + 1;
    double squares = 0, worst = 0, met = 0;
    for (uint32_t row = 0; row < rows; ++row) {
        for (uint32_t column = 0; column < columns; ++column) {
            const CellPixels pixels = cell_pixels(film->width, film->height, column, row);
            const CellLight light = cell_light(film->pixels, film->width, pixels);
            const double error = relative_error(light.variance, z, light.luminance, floor);
            squares += error * error;
            worst = fmax(worst, error);
            met += error <= wanted;
        }
    }
    const double cells = (double)columns * rows;
    return (FilmError){sqrt(squares / cells), worst, met / cells};
}
