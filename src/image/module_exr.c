// EXR files by OpenEXR's C part; the module that image.c loads for them. Here they are written, in
// module_exr_read.c read. See exr_module.h.
#include "image/module_exr.h"

#include <errno.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern const ExrFunctions scn_exr_functions;

enum {
    LONGEST_NAME = 255,      // of a channel or an attribute
    LONGEST_SHORT_NAME = 31, // longer ones want a flag in the file
    ZIP_LEVEL = 4,           // OpenEXR's own, said here lest a version thinks otherwise
};

// One channel of the file. They stand, and are stored, in the order of their names.
typedef struct Channel {
    char name[LONGEST_NAME + 1];
    const unsigned char *values; // its first one
    int32_t pixel_stride, line_stride;
    exr_pixel_type_t given, stored;
} Channel;

typedef struct Work {
    const ExrWrite *write;
    Channel *channels;
    int channel_count;
    FILE *file;
    uint64_t at; // where the file's next byte goes
    int code;    // errno of its first failure
    exr_context_t context;
    exr_encode_pipeline_t pipeline;
    exr_result_t (*compress)(exr_encode_pipeline_t *pipeline); // OpenEXR's own
    char *message;
    size_t message_size;
} Work;

static bool refuse(const Work *work, const char *why)
{
    snprintf(work->message, work->message_size, "%s", why);
    return false;
}

static bool succeeded(const Work *work, exr_result_t result)
{
    return result == EXR_ERR_SUCCESS ||
           refuse(work, result == EXR_ERR_OUT_OF_MEMORY ? "there is not enough memory to write it"
                                                        : exr_get_default_error_message(result));
}

// --- What OpenEXR calls --------------------------------------------------------------------------

// It doesn't tell its functions for memory whom they serve. All callers have the same.
static void *(*_Atomic allocate)(size_t count, size_t size);
static void (*_Atomic release)(void *block);

static void *on_allocate(size_t size)
{
    void *(*const given)(size_t, size_t) = atomic_load(&allocate);
    return given(1, size);
}

static void on_free(void *block)
{
    void (*const given)(void *) = atomic_load(&release);
    given(block);
}

static void on_error(exr_const_context_t context, exr_result_t code, const char *text)
{
    (void)context; // lest they are printed; whoever called tells by the result
    (void)code;
    (void)text;
}

exr_context_initializer_t exr_context_settings(ExrMemory memory, void *user)
{
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    atomic_store(&allocate, memory.allocate);
    atomic_store(&release, memory.release);
    settings.error_handler_fn = on_error;
    settings.alloc_fn = on_allocate;
    settings.free_fn = on_free;
    settings.user_data = user;
    return settings;
}

static int64_t on_write(exr_const_context_t context, void *data, const void *bytes, uint64_t size,
                        uint64_t offset, exr_stream_error_func_ptr_t error)
{
    Work *work = data;
    (void)context;
    (void)error;
    errno = 0;
    if ((offset != work->at && fseeko(work->file, (off_t)offset, SEEK_SET) != 0) ||
        fwrite(bytes, 1, size, work->file) != size) {
        work->code = work->code ? work->code : errno ? errno : EIO;
        return -1;
    }
    work->at = offset + size;
    return (int64_t)size;
}

// Readers take a chunk that is as long as its values for one that isn't compressed; OpenEXR 3.1
// writes the compressed bytes even so where they happen to have that length.
static exr_result_t compress_chunk(exr_encode_pipeline_t *pipeline)
{
    const Work *work = pipeline->encoding_user_data;
    const exr_result_t result = work->compress(pipeline);
    if (result == EXR_ERR_CORRUPT_CHUNK) {
        return EXR_ERR_OUT_OF_MEMORY; // the only reason for which zlib can fail here
    }
    if (result == EXR_ERR_SUCCESS && pipeline->compressed_bytes == pipeline->packed_bytes &&
        pipeline->compressed_buffer != pipeline->packed_buffer) {
        memcpy(pipeline->compressed_buffer, pipeline->packed_buffer, pipeline->packed_bytes);
    }
    return result;
}

// --- Channels ------------------------------------------------------------------------------------

static int by_name(const void *a, const void *b)
{
    return strcmp(((const Channel *)a)->name, ((const Channel *)b)->name);
}

static bool set_channel(const Work *work, const ImageLayer *layer, int c, Channel *out)
{
    const int64_t pixel_bytes =
        layer->ids ? (int64_t)sizeof *layer->ids : layer->channels * (int64_t)sizeof *layer->pixels;
    const int64_t line_bytes = pixel_bytes * work->write->file->width;
    const int length = snprintf(out->name, sizeof out->name, "%s%s%s", layer->name,
                                *layer->name ? "." : "", layer->suffixes[c]);
    if (length < 0 || (size_t)length >= sizeof out->name) {
        return refuse(work, "a channel's name is too long");
    }
    if (line_bytes > INT32_MAX) {
        return refuse(work, "its rows are too long");
    }
    // Ids and positions are spoilt by half floats.
    const bool halved = work->write->bits == 16 && !*layer->name;
    out->values =
        layer->ids ? (const unsigned char *)layer->ids : (const unsigned char *)(layer->pixels + c);
    out->given = layer->ids ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
    out->stored = layer->ids ? EXR_PIXEL_UINT : halved ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
    out->pixel_stride = (int32_t)pixel_bytes;
    out->line_stride = (int32_t)line_bytes;
    return true;
}

static bool make_channels(Work *work)
{
    const ImageFile *file = work->write->file;
    size_t count = 0;
    for (int l = 0; l < file->layer_count; ++l) {
        count += (size_t)file->layers[l].channels;
    }
    if (count == 0 || count > INT16_MAX) {
        return refuse(work, "it has no channels, or too many");
    }
    work->channels = work->write->memory.allocate(count, sizeof *work->channels);
    if (!work->channels) {
        return succeeded(work, EXR_ERR_OUT_OF_MEMORY);
    }
    for (int l = 0; l < file->layer_count; ++l) {
        for (int c = 0; c < file->layers[l].channels; ++c) {
            if (!set_channel(work, &file->layers[l], c, &work->channels[work->channel_count])) {
                return false;
            }
            ++work->channel_count;
        }
    }
    qsort(work->channels, count, sizeof *work->channels, by_name);
    return true;
}

static exr_result_t declare_channels(const Work *work)
{
    exr_result_t result = EXR_ERR_SUCCESS;
    for (int c = 0; c < work->channel_count && result == EXR_ERR_SUCCESS; ++c) {
        const Channel *channel = &work->channels[c];
        result = exr_add_channel(work->context, 0, channel->name, channel->stored,
                                 EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    return result;
}

// --- The header ----------------------------------------------------------------------------------

static bool has_long_names(const Work *work)
{
    const ImageFile *file = work->write->file;
    bool found = false;
    for (int c = 0; c < work->channel_count; ++c) {
        found |= strlen(work->channels[c].name) > LONGEST_SHORT_NAME;
    }
    for (int i = 0; i < file->attribute_count; ++i) {
        found |= strlen(file->attributes[i].name) > LONGEST_SHORT_NAME;
    }
    return found;
}

static exr_result_t set_texts(const Work *work)
{
    const ImageFile *file = work->write->file;
    // The same input gives the same bytes, so that no time is written but one that was given.
    exr_result_t result = exr_attr_set_string(work->context, 0, "capDate", "1970:01:01 00:00:00");
    for (int i = 0; i < file->attribute_count && result == EXR_ERR_SUCCESS; ++i) {
        const char *name = file->attributes[i].name;
        result =
            exr_attr_set_string(work->context, 0, strcmp(name, "DateTime") == 0 ? "capDate" : name,
                                file->attributes[i].text);
    }
    return result;
}

static exr_result_t set_attributes(const Work *work)
{
    static const exr_attr_chromaticities_t rec709 = {0.64f, 0.33f, 0.30f,   0.60f,
                                                     0.15f, 0.06f, 0.3127f, 0.3290f};
    const ImageFile *file = work->write->file;
    exr_result_t result = exr_initialize_required_attr_simple(work->context, 0, file->width,
                                                              file->height, EXR_COMPRESSION_ZIP);
    if (result == EXR_ERR_SUCCESS) {
        result = exr_attr_set_chromaticities(work->context, 0, "chromaticities", &rec709);
    }
    return result == EXR_ERR_SUCCESS ? set_texts(work) : result;
}

static exr_result_t write_header(const Work *work)
{
    int part = 0;
    exr_result_t result = EXR_ERR_SUCCESS;
    if (has_long_names(work)) {
        result = exr_set_longname_support(work->context, 1);
    }
    if (result == EXR_ERR_SUCCESS) {
        result = exr_add_part(work->context, NULL, EXR_STORAGE_SCANLINE, &part);
    }
    if (result == EXR_ERR_SUCCESS) {
        result = set_attributes(work);
    }
    if (result == EXR_ERR_SUCCESS) {
        result = declare_channels(work);
    }
    return result == EXR_ERR_SUCCESS ? exr_write_header(work->context) : result;
}

// --- Pixels --------------------------------------------------------------------------------------

// Points OpenEXR to the values from row y on.
static void point_to_rows(Work *work, int y)
{
    for (int c = 0; c < work->channel_count; ++c) {
        const Channel *channel = &work->channels[c];
        exr_coding_channel_info_t *info = &work->pipeline.channels[c];
        info->user_bytes_per_element = 4;
        info->user_data_type = (uint16_t)channel->given;
        info->user_pixel_stride = channel->pixel_stride;
        info->user_line_stride = channel->line_stride;
        info->encode_from_ptr = channel->values + (size_t)y * (size_t)channel->line_stride;
    }
}

static exr_result_t choose_routines(Work *work)
{
    const exr_result_t result =
        exr_encoding_choose_default_routines(work->context, 0, &work->pipeline);
    work->pipeline.encoding_user_data = work;
    work->compress = work->pipeline.compress_fn;
    work->pipeline.compress_fn = compress_chunk;
    return result;
}

static exr_result_t write_chunk(Work *work, int y)
{
    exr_chunk_info_t chunk;
    exr_result_t result = exr_write_scanline_chunk_info(work->context, 0, y, &chunk);
    if (result == EXR_ERR_SUCCESS) {
        result = y == 0 ? exr_encoding_initialize(work->context, 0, &chunk, &work->pipeline)
                        : exr_encoding_update(work->context, 0, &chunk, &work->pipeline);
    }
    if (result == EXR_ERR_SUCCESS) {
        point_to_rows(work, y);
        result = y == 0 ? choose_routines(work) : EXR_ERR_SUCCESS;
    }
    return result == EXR_ERR_SUCCESS ? exr_encoding_run(work->context, 0, &work->pipeline) : result;
}

static exr_result_t write_rows(Work *work)
{
    const int64_t height = work->write->file->height;
    int32_t step = 0; // 16
    exr_result_t result = exr_get_scanlines_per_chunk(work->context, 0, &step);
    for (int64_t y = 0; y < height && result == EXR_ERR_SUCCESS; y += step) {
        result = write_chunk(work, (int)y);
    }
    return result;
}

// --- The file ------------------------------------------------------------------------------------

static bool write_picture(Work *work)
{
    exr_context_initializer_t start = exr_context_settings(work->write->memory, work);
    start.write_fn = on_write;
    start.zip_level = ZIP_LEVEL;
    exr_result_t result =
        exr_start_write(&work->context, work->write->path, EXR_WRITE_FILE_DIRECTLY, &start);
    if (result != EXR_ERR_SUCCESS) {
        return succeeded(work, result);
    }
    result = write_header(work);
    if (result == EXR_ERR_SUCCESS) {
        result = write_rows(work);
        exr_encoding_destroy(work->context, &work->pipeline);
    }
    const exr_result_t finished = exr_finish(&work->context);
    return succeeded(work, result == EXR_ERR_SUCCESS ? finished : result);
}

static bool write_file(Work *work)
{
    work->file = fopen(work->write->path, "wb");
    if (!work->file) {
        return refuse(work, strerror(errno));
    }
    const bool good = write_picture(work);
    errno = 0;
    if (fclose(work->file) != 0 && work->code == 0) {
        work->code = errno ? errno : EIO;
    }
    return work->code == 0 ? good : refuse(work, strerror(work->code));
}

static bool write_exr(const ExrWrite *write, char *message, size_t message_size)
{
    Work work = {.write = write, .message = message, .message_size = message_size};
    const bool good = make_channels(&work) && write_file(&work);
    if (work.channels) {
        write->memory.release(work.channels);
    }
    return good;
}

__attribute__((visibility("default")))
const ExrFunctions scn_exr_functions = {EXR_MODULE_VERSION, write_exr, exr_module_read};
