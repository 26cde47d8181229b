// EXR files read by OpenEXR's C part: those of one part with one sample a pixel, by rows or tiles,
// whose compression loses nothing and is zlib's or by runs. All else is left to OpenImageIO, and
// what is damaged, too, so that it is refused in the same words: of tables of chunks nothing is
// reconstructed here, and of a file either all is read or nothing. The pixels are OpenImageIO's to
// the bit.
//
// PIZ, PXR24 and B44 are left out with intent: in OpenEXR 3.1 the C part's decoders of them read
// and write beyond their buffers where a file is made for it (repaired later there), the C++ ones
// don't.
#define IMATH_HALF_NO_LOOKUP_TABLE // which would want the library with it
#include "image/module_exr.h"

#include <half.h>
#include <string.h>

enum { MOST_CHANNELS = 64, MOST_CHANNELS_KEPT = 4 };

typedef struct Work {
    ExrRead *read;
    exr_context_t context;
    exr_decode_pipeline_t pipeline;
    bool begun; // the pipeline
    exr_attr_box2i_t window;
    int channel_count;           // of the file
    int places[MOST_CHANNELS];   // of each among those of the picture; -1: not wanted
    size_t sizes[MOST_CHANNELS]; // bytes of a value
    bool halves[MOST_CHANNELS];  // else floats
    uint64_t pixel_bytes;        // of all channels
    int64_t x, y, width, height; // where the chunk belongs
} Work;

// --- What OpenEXR calls --------------------------------------------------------------------------

static int64_t on_size(exr_const_context_t context, void *data)
{
    const Work *work = data;
    (void)context;
    return (int64_t)work->read->size;
}

static int64_t on_read(exr_const_context_t context, void *data, void *out, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t error)
{
    const ExrRead *read = ((const Work *)data)->read;
    (void)context;
    (void)error;
    const uint64_t left = offset < read->size ? read->size - offset : 0;
    const uint64_t given = size < left ? size : left;
    if (given > 0) {
        memcpy(out, (const unsigned char *)read->bytes + offset, given);
    }
    return (int64_t)given;
}

// --- Chunks --------------------------------------------------------------------------------------

static void convert(const unsigned char *values, bool half, int64_t count, float *out,
                    ptrdiff_t step)
{
    for (int64_t i = 0; i < count; ++i, out += step) {
        if (half) {
            const unsigned bits = values[2 * i] | (unsigned)values[2 * i + 1] << 8;
            *out = imath_half_to_float((imath_half_bits_t)bits);
        } else {
            const unsigned char *at = values + 4 * i;
            const uint32_t bits = (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 |
                                  (uint32_t)at[3] << 24;
            memcpy(out, &bits, sizeof bits);
        }
    }
}

// A chunk's rows follow one another, each with all values of one channel, then of the next.
static exr_result_t unpack_chunk(exr_decode_pipeline_t *pipeline)
{
    const Work *work = pipeline->decoding_user_data;
    const exr_chunk_info_t *chunk = &pipeline->chunk;
    const ExrRead *read = work->read;
    const uint64_t size = (uint64_t)work->width * (uint64_t)work->height * work->pixel_bytes;
    if (chunk->width != work->width || chunk->height != work->height ||
        chunk->unpacked_size != size || !pipeline->unpacked_buffer ||
        (chunk->compression == EXR_COMPRESSION_NONE && chunk->packed_size != size)) {
        return EXR_ERR_CORRUPT_CHUNK;
    }
    const unsigned char *from = pipeline->unpacked_buffer;
    for (int64_t y = 0; y < work->height; ++y) {
        float *row =
            read->pixels + ((work->y + y) * read->width + work->x) * (int64_t)read->channels;
        for (int c = 0; c < work->channel_count; ++c) {
            if (work->places[c] >= 0) {
                convert(from, work->halves[c], work->width, row + work->places[c], read->channels);
            }
            from += (size_t)work->width * work->sizes[c];
        }
    }
    return EXR_ERR_SUCCESS;
}

// Routines are chosen as if OpenEXR were to unpack to floats that lie apart, which are never read
// in place; then unpack_chunk takes its part.
static exr_result_t begin_pipeline(Work *work, const exr_chunk_info_t *chunk)
{
    exr_decode_pipeline_t *pipeline = &work->pipeline;
    const ExrRead *read = work->read;
    exr_result_t result = exr_decoding_initialize(work->context, 0, chunk, pipeline);
    if (result != EXR_ERR_SUCCESS) {
        return result;
    }
    work->begun = true;
    if (pipeline->channel_count != work->channel_count) {
        return EXR_ERR_INVALID_ATTR;
    }
    const int32_t pixel = (read->channels + 1) * (int32_t)sizeof *read->pixels;
    for (int c = 0; c < work->channel_count; ++c) {
        exr_coding_channel_info_t *info = &pipeline->channels[c];
        if (work->places[c] >= 0) {
            info->decode_to_ptr = (uint8_t *)(read->pixels + work->places[c]);
            info->user_bytes_per_element = sizeof *read->pixels;
            info->user_data_type = EXR_PIXEL_FLOAT;
            info->user_pixel_stride = pixel;
            info->user_line_stride = pixel * read->width;
        }
    }
    result = exr_decoding_choose_default_routines(work->context, 0, pipeline);
    pipeline->decoding_user_data = work;
    pipeline->unpack_and_convert_fn = unpack_chunk;
    return result;
}

// RLE of OpenEXR 3.1 gives an error's number where a length is expected.
static bool is_doubtful(const exr_chunk_info_t *chunk)
{
    return chunk->compression == EXR_COMPRESSION_RLE &&
           chunk->unpacked_size == EXR_ERR_CORRUPT_CHUNK;
}

static exr_result_t read_chunk(Work *work, const exr_chunk_info_t *chunk)
{
    if (is_doubtful(chunk)) {
        return EXR_ERR_CORRUPT_CHUNK;
    }
    const exr_result_t result = work->begun
                                    ? exr_decoding_update(work->context, 0, chunk, &work->pipeline)
                                    : begin_pipeline(work, chunk);
    return result == EXR_ERR_SUCCESS ? exr_decoding_run(work->context, 0, &work->pipeline) : result;
}

static int64_t at_most(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

// OpenImageIO reads rows as they lie in the file, wherever the table says that they are: so chunks
// are to follow one another.
static exr_result_t read_rows(Work *work)
{
    enum { CHUNK_HEAD = 8 }; // its first row, its size
    int32_t step = 0;
    uint64_t next = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(work->context, 0, &step);
    if (result == EXR_ERR_SUCCESS && step < 1) {
        return EXR_ERR_INVALID_ATTR;
    }
    work->width = work->read->width;
    for (int64_t y = 0; y < work->read->height && result == EXR_ERR_SUCCESS; y += step) {
        exr_chunk_info_t chunk = {0};
        work->y = y;
        work->height = at_most(step, work->read->height - y);
        const int line = (int)(work->window.min.y + y);
        result = exr_read_scanline_chunk_info(work->context, 0, line, &chunk);
        if (result == EXR_ERR_SUCCESS) {
            const bool follows = next == 0 || chunk.data_offset == next;
            result = follows ? read_chunk(work, &chunk) : EXR_ERR_BAD_CHUNK_LEADER;
        }
        next = chunk.data_offset + chunk.packed_size + CHUNK_HEAD;
    }
    return result;
}

static exr_result_t read_tile(Work *work, int column, int row)
{
    exr_chunk_info_t chunk;
    const exr_result_t result =
        exr_read_tile_chunk_info(work->context, 0, column, row, 0, 0, &chunk);
    return result == EXR_ERR_SUCCESS ? read_chunk(work, &chunk) : result;
}

// Of a picture in several sizes the largest.
static exr_result_t read_tiles(Work *work)
{
    uint32_t width = 0, height = 0;
    exr_tile_level_mode_t levels;
    exr_tile_round_mode_t rounding;
    const ExrRead *read = work->read;
    exr_result_t result =
        exr_get_tile_descriptor(work->context, 0, &width, &height, &levels, &rounding);
    if (result == EXR_ERR_SUCCESS &&
        (width == 0 || height == 0 || levels == EXR_TILE_RIPMAP_LEVELS)) {
        return EXR_ERR_FEATURE_NOT_IMPLEMENTED;
    }
    for (work->y = 0; work->y < read->height && result == EXR_ERR_SUCCESS; work->y += height) {
        work->height = at_most(height, read->height - work->y);
        for (work->x = 0; work->x < read->width && result == EXR_ERR_SUCCESS; work->x += width) {
            work->width = at_most(width, read->width - work->x);
            result = read_tile(work, (int)(work->x / width), (int)(work->y / height));
        }
    }
    return result;
}

// --- The header ----------------------------------------------------------------------------------

static int find(const exr_attr_chlist_t *list, const char *name)
{
    for (int c = 0; c < list->num_channels; ++c) {
        if (strcmp(list->entries[c].name.str, name) == 0) {
            return c;
        }
    }
    return -1;
}

// R, G and B or Y, and A, where all other channels are layers'. Of others OpenImageIO knows which
// are meant.
static bool choose_channels(Work *work, const exr_attr_chlist_t *list)
{
    const bool gray = find(list, "Y") >= 0;
    const char *const names[] = {gray ? "Y" : "R", gray ? "A" : "G", "B", "A"};
    int count = 0;
    for (int i = 0; i < (gray ? 2 : MOST_CHANNELS_KEPT); ++i) {
        const int c = find(list, names[i]);
        if (c >= 0) {
            work->places[c] = count++;
        } else if (strcmp(names[i], "A") != 0) {
            return false;
        }
    }
    work->read->channels = count;
    const bool all = count == list->num_channels;
    // Up to four OpenImageIO takes whatever they are called.
    return all || (!gray && list->num_channels > MOST_CHANNELS_KEPT);
}

static bool look_at_channels(Work *work, const exr_attr_chlist_t *list)
{
    if (list->num_channels < 1 || list->num_channels > MOST_CHANNELS) {
        return false;
    }
    work->channel_count = list->num_channels;
    memset(work->places, -1, sizeof work->places);
    if (!choose_channels(work, list)) {
        return false;
    }
    for (int c = 0; c < list->num_channels; ++c) {
        const exr_attr_chlist_entry_t *channel = &list->entries[c];
        const bool wanted = work->places[c] >= 0;
        work->halves[c] = channel->pixel_type == EXR_PIXEL_HALF;
        work->sizes[c] = work->halves[c] ? 2 : 4;
        work->pixel_bytes += work->sizes[c];
        if (channel->x_sampling != 1 || channel->y_sampling != 1 ||
            (wanted && channel->pixel_type == EXR_PIXEL_UINT) ||
            (!wanted && !strchr(channel->name.str, '.'))) {
            return false;
        }
    }
    return true;
}

static bool look_at_window(Work *work)
{
    if (exr_get_data_window(work->context, 0, &work->window) != EXR_ERR_SUCCESS) {
        return false;
    }
    const exr_attr_box2i_t *window = &work->window;
    const int64_t width = (int64_t)window->max.x - window->min.x + 1,
                  height = (int64_t)window->max.y - window->min.y + 1;
    const int64_t longest = 1 << 20; // image.c allows less
    if (width < 1 || height < 1 || width > longest || height > longest ||
        width * height > work->read->max_pixels) {
        return false;
    }
    work->read->width = (int)width;
    work->read->height = (int)height;
    return true;
}

static bool is_downwards(const Work *work)
{
    exr_lineorder_t order;
    return exr_get_lineorder(work->context, 0, &order) == EXR_ERR_SUCCESS &&
           order == EXR_LINEORDER_INCREASING_Y;
}

static bool is_simple(Work *work, exr_storage_t *storage)
{
    int parts = 0;
    exr_compression_t compression;
    const exr_attr_chlist_t *channels = NULL;
    if (exr_get_count(work->context, &parts) != EXR_ERR_SUCCESS || parts != 1 ||
        exr_get_storage(work->context, 0, storage) != EXR_ERR_SUCCESS ||
        !(*storage == EXR_STORAGE_TILED ||
          (*storage == EXR_STORAGE_SCANLINE && is_downwards(work))) ||
        exr_get_compression(work->context, 0, &compression) != EXR_ERR_SUCCESS ||
        exr_get_channels(work->context, 0, &channels) != EXR_ERR_SUCCESS) {
        return false;
    }
    switch (compression) {
    case EXR_COMPRESSION_NONE:
    case EXR_COMPRESSION_RLE:
    case EXR_COMPRESSION_ZIPS:
    case EXR_COMPRESSION_ZIP:
        return look_at_channels(work, channels) && look_at_window(work);
    default:
        return false;
    }
}

// --- The file ------------------------------------------------------------------------------------

static exr_result_t read_picture(Work *work)
{
    ExrRead *read = work->read;
    exr_storage_t storage;
    if (!is_simple(work, &storage)) {
        return EXR_ERR_FEATURE_NOT_IMPLEMENTED;
    }
    const size_t values = (size_t)read->width * (size_t)read->height * (size_t)read->channels;
    read->pixels = read->memory.allocate(values, sizeof *read->pixels);
    if (!read->pixels) {
        return EXR_ERR_OUT_OF_MEMORY;
    }
    const exr_result_t result = storage == EXR_STORAGE_TILED ? read_tiles(work) : read_rows(work);
    if (work->begun) {
        exr_decoding_destroy(work->context, &work->pipeline);
    }
    return result;
}

ExrReading exr_module_read(ExrRead *read)
{
    Work work = {.read = read};
    exr_context_initializer_t start = exr_context_settings(read->memory, &work);
    start.read_fn = on_read;
    start.size_fn = on_size;
    start.flags = EXR_CONTEXT_FLAG_STRICT_HEADER | EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    read->pixels = NULL;
    exr_result_t result = exr_start_read(&work.context, "image.exr", &start);
    if (result == EXR_ERR_SUCCESS) {
        result = read_picture(&work);
        exr_finish(&work.context);
    }
    if (result == EXR_ERR_SUCCESS) {
        return EXR_IS_READ;
    }
    if (read->pixels) {
        read->memory.release(read->pixels);
        read->pixels = NULL;
    }
    return result == EXR_ERR_OUT_OF_MEMORY ? EXR_NO_MEMORY : EXR_NOT_READ;
}
