// EXR read through OpenEXR's C part: the same pixels as OpenImageIO's to the bit, what is left to
// OpenImageIO, and that whatever is damaged is refused in OpenImageIO's words.
#include "base/io.h"
#include "base/mem.h"
#include "base/module.h"
#include "image/exr_module.h"
#include "image/image.h"
#include "image/oiio_module.h"

#include <openexr.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "folder.h"

enum { MOST_CHANNELS = 8 };
static const int64_t MOST_PIXELS = 1 << 22;

static const ExrFunctions *exr;
static const OiioFunctions *oiio;

static uint32_t next_random(void)
{
    static uint64_t state = 88172645463325252;
    state = state * 6364136223846793005 + 1442695040888963407;
    return (uint32_t)(state >> 32);
}

// --- Files of all kinds --------------------------------------------------------------------------

typedef struct Kind {
    exr_compression_t compression;
    int tile_width, tile_height; // 0: rows
    exr_tile_level_mode_t levels;
    bool upwards; // said to be from the bottom
    int x, y, width, height;
    int channel_count;
    const char *names[MOST_CHANNELS]; // in the order of the alphabet
    exr_pixel_type_t types[MOST_CHANNELS];
    int sampling; // of the last channel; 0: 1
    bool smooth;  // else noise
} Kind;

typedef struct Writer {
    const Kind *kind;
    exr_context_t context;
    unsigned char *values; // of one channel, enough for any chunk
} Writer;

static void must(exr_result_t result)
{
    if (result != EXR_ERR_SUCCESS) {
        fail_msg("%s", exr_get_error_code_as_string(result));
    }
}

static void encode(Writer *writer, const exr_chunk_info_t *chunk)
{
    exr_encode_pipeline_t pipeline = {0};
    must(exr_encoding_initialize(writer->context, 0, chunk, &pipeline));
    const size_t size = (size_t)chunk->width * (size_t)chunk->height * 4 + 64;
    unsigned char *values = malloc(size * MOST_CHANNELS);
    for (size_t i = 0; i < size * MOST_CHANNELS; ++i) {
        values[i] = writer->kind->smooth ? (unsigned char)(i / 64) : (unsigned char)next_random();
    }
    for (int c = 0; c < pipeline.channel_count; ++c) {
        exr_coding_channel_info_t *info = &pipeline.channels[c];
        info->user_bytes_per_element = info->bytes_per_element;
        info->user_data_type = info->data_type;
        info->user_pixel_stride = info->bytes_per_element;
        info->user_line_stride = info->width * info->bytes_per_element;
        info->encode_from_ptr = values + (size_t)c * size;
    }
    must(exr_encoding_choose_default_routines(writer->context, 0, &pipeline));
    must(exr_encoding_run(writer->context, 0, &pipeline));
    must(exr_encoding_destroy(writer->context, &pipeline));
    free(values);
}

static int level_size(int size, int level)
{
    return size >> level > 0 ? size >> level : 1;
}

static void write_tiles(Writer *writer)
{
    const Kind *kind = writer->kind;
    int32_t levels = 1, same = 1;
    must(exr_get_tile_levels(writer->context, 0, &levels, &same));
    for (int level = 0; level < levels; ++level) {
        const int width = level_size(kind->width, level), height = level_size(kind->height, level);
        for (int y = 0; y * kind->tile_height < height; ++y) {
            for (int x = 0; x * kind->tile_width < width; ++x) {
                exr_chunk_info_t chunk;
                must(exr_write_tile_chunk_info(writer->context, 0, x, y, level, level, &chunk));
                encode(writer, &chunk);
            }
        }
    }
}

static void write_rows(Writer *writer)
{
    const Kind *kind = writer->kind;
    int32_t step = 0;
    must(exr_get_scanlines_per_chunk(writer->context, 0, &step));
    for (int y = 0; y < kind->height; y += step) {
        exr_chunk_info_t chunk;
        must(exr_write_scanline_chunk_info(writer->context, 0, kind->y + y, &chunk));
        encode(writer, &chunk);
    }
}

static void on_error(exr_const_context_t context, exr_result_t code, const char *text)
{
    (void)context;
    (void)code;
    (void)text;
}

static FileBytes make(const Kind *kind)
{
    Writer writer = {.kind = kind};
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = on_error;
    must(exr_start_write(&writer.context, path_of("kind.exr"), EXR_WRITE_FILE_DIRECTLY, &start));
    int part = 0;
    const bool tiled = kind->tile_width > 0;
    must(exr_add_part(writer.context, NULL, tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE,
                      &part));
    const exr_attr_box2i_t window = {{{{kind->x, kind->y}}},
                                     {{{kind->x + kind->width - 1, kind->y + kind->height - 1}}}};
    const exr_attr_box2i_t display = {{{{0, 0}}}, {{{63, 47}}}};
    const exr_attr_v2f_t center = {{{0, 0}}};
    must(exr_initialize_required_attr(writer.context, 0, &display, &window, 1, &center, 1,
                                      EXR_LINEORDER_INCREASING_Y, kind->compression));
    for (int c = 0; c < kind->channel_count; ++c) {
        const bool last = c == kind->channel_count - 1;
        const int sampling = last && kind->sampling ? kind->sampling : 1;
        must(exr_add_channel(writer.context, 0, kind->names[c], kind->types[c],
                             EXR_PERCEPTUALLY_LOGARITHMIC, sampling, sampling));
    }
    if (tiled) {
        must(exr_set_tile_descriptor(writer.context, 0, (uint32_t)kind->tile_width,
                                     (uint32_t)kind->tile_height, kind->levels,
                                     EXR_TILE_ROUND_DOWN));
    }
    must(exr_write_header(writer.context));
    if (tiled) {
        write_tiles(&writer);
    } else {
        write_rows(&writer);
    }
    must(exr_finish(&writer.context));
    FileBytes bytes;
    assert_int_equal(file_read(path_of("kind.exr"), 1 << 28, &bytes), IO_OK);
    if (kind->upwards) { // though they aren't: the table leads to them, but not everybody looks
        char *order = memmem(bytes.bytes, bytes.size, "lineOrder\0lineOrder", 20);
        assert_non_null(order);
        order[24] = EXR_LINEORDER_DECREASING_Y;
    }
    return bytes;
}

// --- Both readers --------------------------------------------------------------------------------

static bool by_openimageio(const void *bytes, size_t size, Image *out, char *message)
{
    OiioRead read = {.format = "openexr",
                     .bytes = bytes,
                     .size = size,
                     .max_pixels = MOST_PIXELS,
                     .allocate = mem_alloc_zeroed,
                     .release = mem_free};
    message[0] = '\0';
    *out = (Image){0};
    if (!oiio->read(&read, message, 512)) {
        return false;
    }
    *out = (Image){read.width, read.height, read.channels, read.pixels, read.srgb_encoded};
    return true;
}

static ExrReading by_openexr(const void *bytes, size_t size, Image *out)
{
    ExrRead read = {.bytes = bytes,
                    .size = size,
                    .max_pixels = MOST_PIXELS,
                    .memory = {mem_alloc_zeroed, mem_free}};
    const ExrReading reading = exr->read(&read);
    assert_true((reading == EXR_IS_READ) == (read.pixels != NULL));
    *out = (Image){read.width, read.height, read.channels, read.pixels, false};
    return reading;
}

static void expect_same(const Image *a, const Image *b)
{
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channels, b->channels);
    assert_int_equal(a->srgb_encoded, b->srgb_encoded);
    const size_t count = (size_t)a->width * (size_t)a->height * (size_t)a->channels;
    assert_memory_equal(a->pixels, b->pixels, count * sizeof *a->pixels);
}

// What image_read gives is what OpenImageIO gives, picture or complaint; true where it was read
// without it.
static bool compare(const void *bytes, size_t size, ImageLimits limits)
{
    char message[512], expected[512];
    Image image, same, fast;
    const bool wanted = by_openimageio(bytes, size, &same, expected);
    const ExrReading reading = by_openexr(bytes, size, &fast);
    const bool good = image_read("a.exr", bytes, size, limits, &image, message, sizeof message);
    assert_int_not_equal(reading, EXR_NO_MEMORY);
    if (reading == EXR_IS_READ && !wanted) {
        fail_msg("read, but OpenImageIO says `%s`", expected);
    }
    if (reading == EXR_IS_READ) {
        expect_same(&fast, &same);
    }
    if (good) {
        assert_true(wanted);
        if (reading == EXR_IS_READ) { // of what is damaged OpenImageIO gives now this, now that
            expect_same(&image, &same);
        }
    } else if (!strstr(message, "header is damaged") && !strstr(message, "than allowed")) {
        assert_string_equal(message, expected);
    }
    image_free(&image);
    image_free(&same);
    image_free(&fast);
    return reading == EXR_IS_READ;
}

static void check(const Kind *kind, bool fast)
{
    FileBytes bytes = make(kind);
    const bool was_fast = compare(bytes.bytes, bytes.size, (ImageLimits){MOST_PIXELS});
    if (was_fast != fast) {
        fail_msg("compression %d, tiles %d, channels %d: fast %d", kind->compression,
                 kind->tile_width, kind->channel_count, was_fast);
    }
    file_bytes_free(&bytes);
}

#define H EXR_PIXEL_HALF
#define F EXR_PIXEL_FLOAT
#define U EXR_PIXEL_UINT

// Channels that are read without OpenImageIO.
static const Kind channels[] = {
    {.channel_count = 3, .names = {"B", "G", "R"}, .types = {H, H, H}},
    {.channel_count = 3, .names = {"B", "G", "R"}, .types = {F, F, F}},
    {.channel_count = 4, .names = {"A", "B", "G", "R"}, .types = {F, H, F, H}},
    {.channel_count = 1, .names = {"Y"}, .types = {F}},
    {.channel_count = 2, .names = {"A", "Y"}, .types = {H, H}},
    {.channel_count = 7,
     .names = {"A", "B", "G", "R", "id.U", "normal.X", "normal.Y"},
     .types = {H, H, H, H, U, F, H}},
    {.channel_count = 6,
     .names = {"B", "G", "R", "a.B", "a.G", "a.R"},
     .types = {F, F, F, H, H, H}},
};
enum { CHANNEL_KINDS = sizeof channels / sizeof channels[0] };

static const exr_compression_t plain[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                          EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP};
enum { PLAIN = sizeof plain / sizeof plain[0] };

static const struct {
    int x, y, width, height;
} windows[] = {{0, 0, 64, 48}, {-5, 7, 33, 17}, {100, -200, 19, 40}, {0, 0, 23, 33}};
enum { WINDOWS = sizeof windows / sizeof windows[0] };

static Kind with(const Kind *base, int window, exr_compression_t compression)
{
    Kind kind = *base;
    kind.x = windows[window].x;
    kind.y = windows[window].y;
    kind.width = windows[window].width;
    kind.height = windows[window].height;
    kind.compression = compression;
    return kind;
}

static void test_rows(void **state)
{
    (void)state;
    for (int c = 0; c < CHANNEL_KINDS; ++c) {
        for (int p = 0; p < PLAIN; ++p) {
            for (int w = 0; w < WINDOWS; ++w) {
                Kind kind = with(&channels[c], w, plain[p]);
                check(&kind, true);
                kind.smooth = true; // so that compression wins something
                check(&kind, true);
            }
        }
    }
}

static void test_tiles(void **state)
{
    (void)state;
    static const int tiles[][2] = {{16, 16}, {7, 30}, {64, 64}};
    for (int c = 0; c < CHANNEL_KINDS; ++c) {
        for (int p = 0; p < PLAIN; ++p) {
            for (int t = 0; t < 3; ++t) {
                Kind kind = with(&channels[c], (c + p + t) % WINDOWS, plain[p]);
                kind.tile_width = tiles[t][0];
                kind.tile_height = tiles[t][1];
                kind.levels = (c + t) % 2 ? EXR_TILE_ONE_LEVEL : EXR_TILE_MIPMAP_LEVELS;
                kind.smooth = (c + p) % 2;
                check(&kind, true);
            }
        }
    }
}

// All halves, NaN's and what is below the least normal one, too.
static void test_all_halves(void **state)
{
    (void)state;
    const Kind kind = {.compression = EXR_COMPRESSION_NONE,
                       .width = 256,
                       .height = 256,
                       .channel_count = 1,
                       .names = {"Y"},
                       .types = {H}};
    FileBytes bytes = make(&kind);
    assert_true(bytes.size > 256 * (512 + 8));
    char *chunk = bytes.bytes + bytes.size - 256 * (512 + 8);
    for (unsigned y = 0; y < 256; ++y, chunk += 512 + 8) {
        for (unsigned x = 0; x < 256; ++x) {
            chunk[8 + 2 * x] = (char)x;
            chunk[9 + 2 * x] = (char)y;
        }
    }
    assert_true(compare(bytes.bytes, bytes.size, (ImageLimits){MOST_PIXELS}));
    Image image;
    assert_int_equal(by_openexr(bytes.bytes, bytes.size, &image), EXR_IS_READ);
    assert_true(image.pixels[0x3c00] == 1 && image.pixels[0xc000] == -2 &&
                image.pixels[1] == 0x1p-24f && image.pixels[0x7bff] == 65504);
    image_free(&image);
    file_bytes_free(&bytes);
}

static void test_what_is_left(void **state)
{
    (void)state;
    static const exr_compression_t other[] = {EXR_COMPRESSION_PIZ, EXR_COMPRESSION_PXR24,
                                              EXR_COMPRESSION_B44, EXR_COMPRESSION_B44A};
    for (size_t i = 0; i < sizeof other / sizeof other[0]; ++i) {
        Kind kind = with(&channels[0], 0, other[i]);
        kind.smooth = true;
        check(&kind, false);
    }
    static const Kind kinds[] = {
        {.channel_count = 1, .names = {"Y"}, .types = {U}},
        {.channel_count = 3, .names = {"B", "G", "R"}, .types = {F, U, F}},
        {.channel_count = 1, .names = {"Z"}, .types = {F}},
        {.channel_count = 2, .names = {"G", "R"}, .types = {F, F}},
        {.channel_count = 4, .names = {"B", "G", "R", "Z"}, .types = {F, F, F, F}},
        {.channel_count = 5, .names = {"A", "B", "G", "R", "Z"}, .types = {F, F, F, F, F}},
        {.channel_count = 4, .names = {"B", "G", "R", "a.X"}, .types = {F, F, F, F}},
        {.channel_count = 2, .names = {"Y", "a.X"}, .types = {F, F}},
        {.channel_count = 3, .names = {"b", "g", "r"}, .types = {F, F, F}},
    };
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        const Kind kind = with(&kinds[i], 0, EXR_COMPRESSION_ZIP);
        check(&kind, false);
    }
    Kind sampled = with(&channels[0], 0, EXR_COMPRESSION_ZIP);
    sampled.sampling = 2;
    check(&sampled, false);
    Kind upwards = with(&channels[0], 0, EXR_COMPRESSION_ZIP);
    upwards.upwards = true;
    check(&upwards, false);
}

// --- What fails ----------------------------------------------------------------------------------

// Cut, or with a few bytes changed, mostly in the header and the table of chunks.
static void test_damaged(void **state)
{
    (void)state;
    int fast = 0, refused = 0;
    for (int c = 0; c < CHANNEL_KINDS; ++c) {
        for (int p = 0; p < PLAIN; ++p) {
            Kind kind = with(&channels[c], 1 + (c + p) % 3, plain[p]);
            kind.smooth = c % 2;
            kind.tile_width = kind.tile_height = p % 2 ? 16 : 0;
            FileBytes bytes = make(&kind);
            for (int round = 0; round < 60; ++round) {
                size_t size = bytes.size;
                if (round % 6 == 0) {
                    size = 64 + next_random() % (size - 64);
                }
                char *changed = malloc(size); // so that a sanitizer sees a read beyond the end
                memcpy(changed, bytes.bytes, size);
                const size_t span = round % 2 || size < 800 ? size : 800;
                for (int k = 0; round % 6 && k < 1 + round % 3; ++k) {
                    changed[8 + next_random() % (span - 8)] = (char)next_random();
                }
                const bool good = compare(changed, size, (ImageLimits){MOST_PIXELS});
                fast += good;
                refused += !good;
                free(changed);
            }
            file_bytes_free(&bytes);
        }
    }
    assert_true(fast > 100 && refused > 100);
}

static void test_no_memory(void **state)
{
    (void)state;
    Kind kind = with(&channels[5], 0, EXR_COMPRESSION_ZIP);
    kind.smooth = true;
    FileBytes bytes = make(&kind);
    const uint64_t live = mem_live_count();
    bool good = false;
    uint64_t allocations = 0;
    while (!good && allocations < 1000) {
        char message[512] = "";
        Image image;
        mem_fail_after(allocations);
        good = image_read("a.exr", bytes.bytes, bytes.size, (ImageLimits){MOST_PIXELS}, &image,
                          message, sizeof message);
        mem_fail_after(UINT64_MAX);
        if (!good) {
            assert_string_equal(message, "there is not enough memory for it");
            ++allocations;
        }
        image_free(&image);
        assert_int_equal(mem_live_count(), live);
    }
    assert_true(good && allocations > 10);
    file_bytes_free(&bytes);
}

static void test_too_many_pixels(void **state)
{
    (void)state;
    const Kind kind = with(&channels[0], 0, EXR_COMPRESSION_ZIP);
    FileBytes bytes = make(&kind);
    ExrRead read = {.bytes = bytes.bytes,
                    .size = bytes.size,
                    .max_pixels = 64 * 48 - 1,
                    .memory = {mem_alloc_zeroed, mem_free}};
    assert_int_equal(exr->read(&read), EXR_NOT_READ);
    assert_null(read.pixels);
    file_bytes_free(&bytes);
}

static int begin(void **state)
{
    char message[512];
    setenv("SCNRENDER_MODULES", SCN_BINARY_DIR "/lib/scnrender", 1);
    void *first = module_open("scn_exr", message, sizeof message);
    void *second = module_open("scn_oiio", message, sizeof message);
    exr = first ? module_symbol(first, "scn_exr_functions") : NULL;
    oiio = second ? module_symbol(second, "scn_oiio_functions") : NULL;
    return exr && oiio ? make_folder(state) : -1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows),
        cmocka_unit_test(test_tiles),
        cmocka_unit_test(test_all_halves),
        cmocka_unit_test(test_what_is_left),
        cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_no_memory),
        cmocka_unit_test(test_too_many_pixels),
    };
    return cmocka_run_group_tests(tests, begin, remove_folder);
}
