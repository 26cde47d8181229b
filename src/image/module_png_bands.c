#include "image/module_png_bands.h"

#include <string.h>
#include <zlib.h>

// Bytes of rows in a band. What repeats isn't found across its border, which makes files larger by
// less than a hundredth.
enum { BAND_BYTES = 1 << 18 };
// Bands that are compressed before any of them is written.
enum { BANDS_AT_ONCE = 64 };
// The noise of a picture can't be compressed, and what is smooth is by this, too: a third of the
// time of zlib's own choice, and files between 7 % larger and 10 % smaller.
enum { LEVEL = 2, WINDOW_BITS = 15, MEMORY_LEVEL = 8 };
// The stream's first bytes (RFC 1950): a window of 32 KB, a fast level, no dictionary. Its last
// four are the sum.
static const unsigned char stream_head[] = {0x78, 0x5e};
enum { SUM_BYTES = 4 };

typedef struct PngBand {
    unsigned char *bytes; // with room for the sum
    size_t size;
    uLong adler; // of what was compressed, …
    size_t raw;  // … and how many bytes that were
} PngBand;

typedef struct Job {
    const PngWrite *write;
    PngBands *bands;
    size_t row_bytes, band_rows;
    size_t first, all; // bands: the first of those that are made now; of the picture
} Job;

// --- Rows ----------------------------------------------------------------------------------------

// A value in [0, 1] as the nearest of 0 … largest; NaN as 0.
static unsigned quantize(float value, double largest)
{
    const double scaled = (double)value * largest + 0.5;
    return (unsigned)(!(scaled > 0) ? 0 : scaled < largest ? scaled : largest);
}

static void quantize_row(const PngWrite *write, size_t y, unsigned char *out)
{
    const float *pixel = write->pixels + y * (size_t)write->width * (size_t)write->channels;
    for (int x = 0; x < write->width; ++x, pixel += write->channels) {
        for (int c = 0; c < write->used; ++c) {
            if (write->bits == 8) {
                *out++ = (unsigned char)quantize(pixel[c], 255);
            } else {
                const unsigned value = quantize(pixel[c], 65535);
                *out++ = (unsigned char)(value >> 8);
                *out++ = (unsigned char)value;
            }
        }
    }
}

// The filters of the PNG specification that are tried (12, "Filter algorithms"): what a row differs
// from its bytes one pixel to the left, or above.
enum { FILTER_NONE, FILTER_SUB, FILTER_UP, FILTERS };

// The specification's heuristic: the least sum of the bytes, as signed numbers without their signs.
static uint32_t distance_from_zero(unsigned char byte)
{
    return byte < 128 ? byte : 256U - byte;
}

static int best_filter(const unsigned char *row, const unsigned char *above, size_t size,
                       size_t pixel)
{
    enum { AT_ONCE = 4096 };
    uint64_t sums[FILTERS] = {0};
    for (size_t begin = 0; begin < size; begin += AT_ONCE) {
        const size_t end = size - begin < AT_ONCE ? size : begin + AT_ONCE;
        uint32_t none = 0, sub = 0, up = 0;
        for (size_t i = begin; i < end; ++i) {
            none += distance_from_zero(row[i]);
            sub += distance_from_zero((unsigned char)(row[i] - (row - pixel)[i]));
            up += distance_from_zero((unsigned char)(row[i] - above[i]));
        }
        sums[FILTER_NONE] += none;
        sums[FILTER_SUB] += sub;
        sums[FILTER_UP] += up;
    }
    const int less = sums[FILTER_SUB] < sums[FILTER_NONE] ? FILTER_SUB : FILTER_NONE;
    return sums[FILTER_UP] < sums[less] ? FILTER_UP : less;
}

// Writes the filter's number and the filtered row to `out`. There is a pixel of zeros before `row`.
static void filter_row(const unsigned char *row, const unsigned char *above, size_t size,
                       size_t pixel, unsigned char *out)
{
    const int best = best_filter(row, above, size, pixel);
    const unsigned char *from = best == FILTER_SUB ? row - pixel : above;
    *out++ = (unsigned char)best;
    if (best == FILTER_NONE) {
        memcpy(out, row, size);
        return;
    }
    for (size_t i = 0; i < size; ++i) {
        out[i] = (unsigned char)(row[i] - from[i]);
    }
}

// --- Bands ---------------------------------------------------------------------------------------

static voidpf zlib_allocate(voidpf opaque, uInt count, uInt size)
{
    const PngMemory *memory = opaque;
    return memory->allocate(count, size);
}

static void zlib_release(voidpf opaque, voidpf block)
{
    const PngMemory *memory = opaque;
    memory->release(block);
}

// Compresses filtered rows into band->bytes, whole bytes of a stream that others go on with.
static bool compress_rows(const PngMemory *memory, const unsigned char *rows, bool first, bool last,
                          PngBand *band)
{
    z_stream stream = {
        .zalloc = zlib_allocate, .zfree = zlib_release, .opaque = (voidpf)(uintptr_t)memory};
    // Negative: without head and sum, which are the whole stream's.
    if (deflateInit2(&stream, LEVEL, Z_DEFLATED, -WINDOW_BITS, MEMORY_LEVEL, Z_FILTERED) != Z_OK) {
        return false;
    }
    const size_t head = first ? sizeof stream_head : 0;
    const size_t most = deflateBound(&stream, (uLong)band->raw) + 16; // 5 for the flush
    band->bytes = memory->allocate(head + most + SUM_BYTES, 1);
    bool good = band->bytes != NULL;
    if (good) {
        memcpy(band->bytes, stream_head, head);
        stream.next_in = (Bytef *)(uintptr_t)rows;
        stream.avail_in = (uInt)band->raw;
        stream.next_out = band->bytes + head;
        stream.avail_out = (uInt)most;
        const int ended = deflate(&stream, last ? Z_FINISH : Z_SYNC_FLUSH);
        good = ended == (last ? Z_STREAM_END : Z_OK) && stream.avail_in == 0;
        band->size = head + most - stream.avail_out;
    }
    deflateEnd(&stream);
    return good;
}

// Filters the rows from `begin` to before `end`. `room`: zeros, ROOM_ROWS times the size of a row
// with a pixel before it.
enum { MOST_PIXEL = 8, ROOM_ROWS = 2 };
static void make_rows(const Job *job, size_t begin, size_t end, unsigned char *room,
                      unsigned char *out)
{
    const PngWrite *write = job->write;
    const size_t size = job->row_bytes;
    const size_t pixel = (size_t)write->used * (size_t)write->bits / 8;
    unsigned char *above = room + MOST_PIXEL, *row = above + size + MOST_PIXEL;
    if (begin > 0) {
        quantize_row(write, begin - 1, above);
    }
    for (size_t y = begin; y < end; ++y, out += size + 1) {
        quantize_row(write, y, row);
        filter_row(row, above, size, pixel, out);
        unsigned char *old = above;
        above = row;
        row = old;
    }
}

// Leaves band->bytes NULL where memory runs out.
static void make_band(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    const Job *job = context;
    const PngMemory *memory = &job->write->memory;
    const size_t number = job->first + (size_t)item, height = (size_t)job->write->height;
    const size_t begin = number * job->band_rows;
    const size_t end = height - begin > job->band_rows ? begin + job->band_rows : height;
    PngBand *band = &job->bands->items[item];
    band->raw = (end - begin) * (job->row_bytes + 1);
    unsigned char *rows = memory->allocate(band->raw, 1);
    unsigned char *room = memory->allocate(job->row_bytes + MOST_PIXEL, ROOM_ROWS);
    if (rows && room) {
        make_rows(job, begin, end, room, rows);
        band->adler = adler32(adler32(0, NULL, 0), rows, (uInt)band->raw);
        if (!compress_rows(memory, rows, number == 0, number + 1 == job->all, band)) {
            memory->release(band->bytes);
            band->bytes = NULL;
        }
    }
    memory->release(rows);
    memory->release(room);
}

static void free_bytes(const PngBands *bands, const PngMemory *memory)
{
    for (size_t i = 0; i < bands->count; ++i) {
        memory->release(bands->items[i].bytes);
        bands->items[i] = (PngBand){.bytes = NULL};
    }
}

bool png_bands_write(PngBands *bands, const PngWrite *write, PngSink *sink, void *context)
{
    Job job = {.write = write, .bands = bands};
    job.row_bytes = (size_t)write->width * (size_t)write->used * (size_t)write->bits / 8;
    job.band_rows = job.row_bytes < BAND_BYTES ? BAND_BYTES / (job.row_bytes + 1) : 1;
    job.all = ((size_t)write->height - 1) / job.band_rows + 1;
    const size_t room = job.all < BANDS_AT_ONCE ? job.all : BANDS_AT_ONCE;
    bands->items = write->memory.allocate(room, sizeof *bands->items);
    if (!bands->items) {
        return false;
    }
    bands->count = room;
    uLong adler = adler32(0, NULL, 0);
    for (; job.first < job.all; job.first += room) {
        const size_t count = job.all - job.first < room ? job.all - job.first : room;
        write->parallel(count, write->threads, make_band, &job, NULL);
        for (size_t i = 0; i < count; ++i) {
            PngBand *band = &bands->items[i];
            if (!band->bytes) {
                return false;
            }
            adler = adler32_combine(adler, band->adler, (z_off_t)band->raw);
            for (int k = 0; k < SUM_BYTES && job.first + i + 1 == job.all; ++k) {
                band->bytes[band->size++] = (unsigned char)(adler >> (24 - 8 * k));
            }
            sink(context, band->bytes, band->size);
        }
        free_bytes(bands, &write->memory);
    }
    return true;
}

void png_bands_free(PngBands *bands, const PngMemory *memory)
{
    free_bytes(bands, memory);
    memory->release(bands->items);
    *bands = (PngBands){NULL, 0};
}
