// EXR written through OpenEXR's C part: the same bytes as OpenImageIO writes, and what fails.
#include "image/image.h"

#include "base/io.h"
#include "base/mem.h"
#include "base/module.h"
#include "image/oiio_module.h"

#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "folder.h"

enum { MOST_LAYERS = 4, MOST_TEXTS = 4, MOST_ATTRIBUTES = 64, MOST_CHUNKS = 32 };

static const char *const RGBA[] = {"R", "G", "B", "A"};
static const char *const XYZ[] = {"X", "Y", "Z"}, *const Z[] = {"Z"}, *const ID[] = {"id"};
static FileBytes bytes_of(const char *name)
{
    FileBytes bytes;
    assert_int_equal(file_read(path_of(name), 1 << 28, &bytes), IO_OK);
    return bytes;
}

static FileBytes written(const char *name, const ImageFile *file)
{
    char message[512] = "";
    if (!image_write(path_of(name), name, file, message, sizeof message)) {
        fail_msg("%s: %s", name, message);
    }
    return bytes_of(name);
}

// As image.c does where OpenEXR's module isn't installed.
static FileBytes written_by_openimageio(const char *name, const ImageFile *file)
{
    char message[512] = "";
    void *module = module_open("scn_oiio", message, sizeof message);
    const OiioFunctions *oiio = module ? module_symbol(module, "scn_oiio_functions") : NULL;
    OiioLayer layers[MOST_LAYERS];
    OiioText texts[MOST_TEXTS];
    assert_true(file->layer_count <= MOST_LAYERS && file->attribute_count <= MOST_TEXTS);
    for (int i = 0; i < file->layer_count; ++i) {
        const ImageLayer *layer = &file->layers[i];
        layers[i] = (OiioLayer){layer->name,     layer->channels, layer->channels,
                                layer->suffixes, layer->pixels,   layer->ids};
    }
    for (int i = 0; i < file->attribute_count; ++i) {
        texts[i] = (OiioText){file->attributes[i].name, file->attributes[i].text};
    }
    const OiioWrite write = {.format = "openexr",
                             .extension = "exr",
                             .path = path_of(name),
                             .width = file->width,
                             .height = file->height,
                             .sample = file->bits == 16 ? OIIO_HALF : OIIO_FLOAT,
                             .linear = true,
                             .layers = layers,
                             .layer_count = file->layer_count,
                             .texts = texts,
                             .text_count = file->attribute_count};
    if (!oiio || !oiio->write(&write, message, sizeof message)) {
        fail_msg("%s: %s", name, message);
    }
    return bytes_of(name);
}

static uint32_t next_random(void)
{
    static uint64_t state = 2463534242;
    state = state * 6364136223846793005 + 1442695040888963407;
    return (uint32_t)(state >> 32);
}

// --- What a file holds ---------------------------------------------------------------------------

// An attribute with its type and its value, or a chunk of rows with its head.
typedef struct Piece {
    const char *bytes;
    size_t size;
} Piece;

typedef struct Contents {
    uint32_t version; // and flags
    Piece attributes[MOST_ATTRIBUTES], chunks[MOST_CHUNKS];
    int attribute_count, chunk_count;
} Contents;

static uint32_t word_at(const char *bytes)
{
    uint32_t word;
    memcpy(&word, bytes, sizeof word);
    return word;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const Piece *)a)->bytes, ((const Piece *)b)->bytes);
}

// Attributes by their names, but for the one that says "scanlineimage", which files of one part
// needn't have (openexr.com, "OpenEXR File Layout").
static Contents contents_of(const FileBytes *file, int height)
{
    Contents contents = {.version = word_at(file->bytes + 4)};
    assert_int_equal(word_at(file->bytes), 20000630);
    const char *at = file->bytes + 8;
    while (*at) {
        const char *type = at + strlen(at) + 1, *size = type + strlen(type) + 1;
        Piece piece = {at, (size_t)(size - at) + 4 + word_at(size)};
        assert_true(contents.attribute_count < MOST_ATTRIBUTES);
        if (strcmp(at, "type") == 0) {
            assert_memory_equal(size + 4, "scanlineimage", 13);
        } else {
            contents.attributes[contents.attribute_count++] = piece;
        }
        at += piece.size;
    }
    qsort(contents.attributes, (size_t)contents.attribute_count, sizeof(Piece), by_name);
    contents.chunk_count = (height + 15) / 16;
    assert_true(contents.chunk_count <= MOST_CHUNKS);
    const char *expected = at + 1 + 8 * contents.chunk_count;
    for (int i = 0; i < contents.chunk_count; ++i) {
        uint64_t offset;
        memcpy(&offset, at + 1 + 8 * i, sizeof offset);
        assert_ptr_equal(file->bytes + offset, expected);
        contents.chunks[i] = (Piece){expected, 8 + word_at(expected + 4)};
        expected += contents.chunks[i].size;
    }
    assert_ptr_equal(expected, file->bytes + file->size);
    return contents;
}

static void expect_same_pieces(const Piece *a, int a_count, const Piece *b, int b_count)
{
    assert_int_equal(a_count, b_count);
    for (int i = 0; i < a_count; ++i) {
        assert_int_equal(a[i].size, b[i].size);
        assert_memory_equal(a[i].bytes, b[i].bytes, a[i].size);
    }
}

// Writes it both ways and compares all that the files hold.
static void check_same(const ImageFile *file)
{
    FileBytes old_bytes = written_by_openimageio("old.exr", file);
    FileBytes new_bytes = written("new.exr", file);
    const Contents before = contents_of(&old_bytes, file->height);
    const Contents after = contents_of(&new_bytes, file->height);
    assert_int_equal(before.version, after.version);
    assert_int_equal(new_bytes.size, old_bytes.size + 29); // the type
    expect_same_pieces(before.attributes, before.attribute_count, after.attributes,
                       after.attribute_count);
    expect_same_pieces(before.chunks, before.chunk_count, after.chunks, after.chunk_count);
    file_bytes_free(&old_bytes);
    file_bytes_free(&new_bytes);
}

// --- Pictures ------------------------------------------------------------------------------------

typedef struct Picture {
    float *values, *normals, *depth;
    uint32_t *ids;
    ImageLayer layers[4];
} Picture;

static float *noise(size_t count)
{
    float *values = malloc(count * sizeof *values);
    for (size_t i = 0; i < count; ++i) {
        values[i] = (float)(next_random() % 4096) / 1024 - 1;
    }
    return values;
}

static Picture make_picture(int width, int height, int channels)
{
    const size_t pixels = (size_t)width * (size_t)height;
    Picture picture = {noise(pixels * 4),
                       noise(pixels * 3),
                       noise(pixels),
                       malloc(pixels * sizeof *picture.ids),
                       {{0}}};
    for (size_t i = 0; i < pixels; ++i) {
        picture.ids[i] = UINT32_MAX - (uint32_t)i / 7; // more than a float holds
    }
    picture.layers[0] = (ImageLayer){"", channels, RGBA, picture.values, NULL};
    picture.layers[1] = (ImageLayer){"normal", 3, XYZ, picture.normals, NULL};
    picture.layers[2] = (ImageLayer){"depth", 1, Z, picture.depth, NULL};
    picture.layers[3] = (ImageLayer){"object_id", 1, ID, NULL, picture.ids};
    return picture;
}

static void free_picture(Picture *picture)
{
    free(picture->values);
    free(picture->normals);
    free(picture->depth);
    free(picture->ids);
}

static void test_same_as_openimageio(void **state)
{
    (void)state;
    static const int sizes[][2] = {{1, 1},   {17, 33}, {37, 16}, {1, 47},
                                   {200, 3}, {64, 64}, {15, 17}, {129, 32}};
    static const ImageAttribute attributes[] = {{"Software", "scnrender"},
                                                {"scnrender:camera", ""},
                                                {"scnrender:scene", "bl\u00fcte \u2603.scn"},
                                                {"scnrender:samples", "64"}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; ++s) {
        for (int channels = 1; channels <= 4; channels += channels == 1 ? 2 : 1) {
            Picture picture = make_picture(sizes[s][0], sizes[s][1], channels);
            for (int layers = 1; layers <= 4; layers += 3) {
                for (int bits = 0; bits <= 32; bits += 16) {
                    const ImageFile file = {sizes[s][0], sizes[s][1], bits, picture.layers,
                                            layers,      attributes,  4,    1};
                    check_same(&file);
                }
            }
            free_picture(&picture);
        }
    }
}

static void test_attributes(void **state)
{
    (void)state;
    float pixel = 0.5f;
    ImageLayer layer = {"", 1, Z, &pixel, NULL};
    char *text = malloc(100001);
    memset(text, 'x', 100000);
    text[100000] = '\0';
    const ImageAttribute attributes[] = {
        {"DateTime", "2026:11:26 12:00:00"},
        {"scnrender:command", text},
        {"scnrender:a_name_of_more_than_31_characters", "\u00e4\u00f6\u00fc"}};
    for (int count = 0; count <= 3; ++count) {
        const ImageFile file = {1, 1, 0, &layer, 1, attributes, count, 1};
        check_same(&file);
    }
    free(text);
}

// Any bits at all: floats are kept, NaN's too, and rounded to halves in the same way.
static void test_all_values(void **state)
{
    (void)state;
    enum { SIDE = 256, COUNT = 3 * SIDE * SIDE };
    static const uint32_t edges[] = {
        0,          0x80000000, 0x7f800000, 0xff800000, 0x7fc00000, 0x7f800001, 0xffffffff,
        0x477fe000, 0x477fefff, 0x477ff000, 0x38800000, 0x387fffff, 0x33000000, 0x33000001,
        0x33800000, 0x00000001, 0x3f801000, 0x3f803000, 0x3f801001, 0x7f7fffff, 0x7fa00000};
    uint32_t *bits = malloc(sizeof *bits * COUNT);
    float *values = malloc(sizeof *values * COUNT);
    for (int i = 0; i < COUNT; ++i) {
        bits[i] = i < (int)(sizeof edges / sizeof edges[0]) ? edges[i] : next_random();
        if (i % 2 && i > 100) { // where halves are
            bits[i] = (bits[i] & 0x87ffffff) + 0x34000000;
        }
    }
    memcpy(values, bits, sizeof *values * COUNT);
    ImageLayer layer = {"", 3, RGBA, values, NULL};
    ImageFile file = {SIDE, SIDE, 32, &layer, 1, NULL, 0, 1};
    check_same(&file);
    file.bits = 16;
    check_same(&file);
    free(bits);
    free(values);
}

// Rows with more or less noise: among them are some that are as long compressed as they are not.
static void test_chunks_that_win_nothing(void **state)
{
    (void)state;
    enum { WIDTH = 23, ROUNDS = 400 };
    float values[WIDTH];
    ImageLayer layer = {"", 1, Z, values, NULL};
    const ImageFile file = {WIDTH, 1, 0, &layer, 1, NULL, 0, 1};
    int raw = 0;
    for (int round = 0; round < ROUNDS; ++round) {
        for (int i = 0; i < WIDTH; ++i) {
            uint32_t bits = i < round % WIDTH ? next_random() : 0x3f800000;
            memcpy(&values[i], &bits, sizeof bits);
        }
        check_same(&file);
        FileBytes bytes = bytes_of("new.exr");
        raw += contents_of(&bytes, 1).chunks[0].size == 8 + sizeof values;
        file_bytes_free(&bytes);
    }
    assert_true(raw > 10 && raw < ROUNDS - 10);
}

static void test_reads_back(void **state)
{
    (void)state;
    Picture picture = make_picture(17, 33, 4);
    const ImageFile file = {17, 33, 0, picture.layers, 1, NULL, 0, 1};
    FileBytes bytes = written("back.exr", &file);
    Image image;
    char message[512] = "";
    assert_true(image_read("back.exr", bytes.bytes, bytes.size, (ImageLimits){1 << 20}, &image,
                           message, sizeof message));
    assert_int_equal(image.width, 17);
    assert_int_equal(image.height, 33);
    assert_int_equal(image.channels, 4);
    assert_memory_equal(image.pixels, picture.values, sizeof(float) * 4 * 17 * 33);
    image_free(&image);
    file_bytes_free(&bytes);
    free_picture(&picture);
}

// --- What fails ----------------------------------------------------------------------------------

static void expect_refused(const char *path, const ImageFile *file, const char *why)
{
    char message[512] = "";
    if (image_write(path, "a.exr", file, message, sizeof message) || !strstr(message, why)) {
        fail_msg("%s: `%s`, not `%s`", path, message, why);
    }
    assert_null(strchr(message, '\n'));
}

static void test_wrong_sizes(void **state)
{
    (void)state;
    float pixel[4] = {0};
    char name[300];
    memset(name, 'n', sizeof name - 1);
    name[sizeof name - 1] = '\0';
    ImageLayer layer = {"", 4, RGBA, pixel, NULL};
    ImageFile file = {1 << 28, 1 << 28, 0, &layer, 1, NULL, 0, 1}; // nothing is read of it
    expect_refused(path_of("wrong.exr"), &file, "rows are too long");
    file = (ImageFile){1, 1, 0, &layer, 0, NULL, 0, 1};
    expect_refused(path_of("wrong.exr"), &file, "no channels");
    layer.name = name;
    file.layer_count = 1;
    expect_refused(path_of("wrong.exr"), &file, "name is too long");
    layer.name = "";
    const ImageAttribute attribute = {name, "text"};
    file.attributes = &attribute;
    file.attribute_count = 1;
    expect_refused(path_of("wrong.exr"), &file, "too long"); // in OpenEXR's words
    static const char *const twice[] = {"R", "R", "B", "A"};
    layer.suffixes = twice;
    file.attribute_count = 0;
    expect_refused(path_of("wrong.exr"), &file, "");
}

static void test_full_disk(void **state)
{
    (void)state;
    Picture picture = make_picture(40, 40, 3);
    const ImageFile file = {40, 40, 0, picture.layers, 4, NULL, 0, 1};
    FileBytes bytes = written("full.exr", &file);
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    for (size_t room = 0; room < bytes.size;
         room += room < 1500 || room > bytes.size - 5 ? 1 : 97) {
        const struct rlimit small = {room, before.rlim_max};
        char message[512] = "";
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        bool good = image_write(path_of("full.exr"), "a.exr", &file, message, sizeof message);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
        if (good || !strstr(message, "File too large")) {
            fail_msg("%zu bytes: %d %s", room, good, message);
        }
    }
    FileBytes again = written("full.exr", &file);
    assert_int_equal(again.size, bytes.size);
    assert_memory_equal(again.bytes, bytes.bytes, bytes.size);
    expect_refused("/dev/full", &file, "No space left");
    expect_refused(path_of("none/a.exr"), &file, "No such file");
    file_bytes_free(&bytes);
    file_bytes_free(&again);
    free_picture(&picture);
}

static void test_no_memory(void **state)
{
    (void)state;
    Picture picture = make_picture(20, 40, 3);
    static const ImageAttribute attributes[] = {{"Software", "scnrender"}, {"a", "b"}};
    const ImageFile file = {20, 40, 16, picture.layers, 4, attributes, 2, 1};
    FileBytes bytes = written("memory.exr", &file);
    uint64_t allocations = 0;
    const uint64_t live = mem_live_count();
    bool good = false;
    while (!good && allocations < 1000) {
        char message[512] = "";
        mem_fail_after(allocations);
        good = image_write(path_of("memory.exr"), "a.exr", &file, message, sizeof message);
        mem_fail_after(UINT64_MAX);
        assert_int_equal(mem_live_count(), live);
        if (!good) {
            assert_non_null(strstr(message, "not enough memory"));
            ++allocations;
        }
    }
    assert_true(good && allocations > 20);
    FileBytes again = written("memory.exr", &file);
    assert_int_equal(again.size, bytes.size);
    assert_memory_equal(again.bytes, bytes.bytes, bytes.size);
    file_bytes_free(&bytes);
    file_bytes_free(&again);
    free_picture(&picture);
}

// A module that isn't one.
static void test_broken_module(void **state)
{
    (void)state;
    setenv("SCNRENDER_MODULES", folder, 1);
    FILE *fake = fopen(path_of("scn_exr.so"), "w");
    fputs("not a library", fake);
    fclose(fake);
    float pixel = 0.5f;
    char message[512] = "";
    ImageLayer layer = {"", 1, Z, &pixel, NULL};
    const ImageFile file = {1, 1, 0, &layer, 1, NULL, 0, 1};
    expect_refused(path_of("broken.exr"), &file, "OpenEXR can't be loaded");
    assert_false(image_available("a.exr", message, sizeof message));
    assert_non_null(strstr(message, "OpenEXR can't be loaded"));
    setenv("SCNRENDER_MODULES", SCN_BINARY_DIR "/lib/scnrender", 1);
    image_preload("a.exr");
    assert_true(image_available("a.exr", message, sizeof message));
}

int main(void)
{
    setenv("SCNRENDER_MODULES", SCN_BINARY_DIR "/lib/scnrender", 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_as_openimageio), cmocka_unit_test(test_attributes),
        cmocka_unit_test(test_all_values),          cmocka_unit_test(test_chunks_that_win_nothing),
        cmocka_unit_test(test_reads_back),          cmocka_unit_test(test_wrong_sizes),
        cmocka_unit_test(test_full_disk),           cmocka_unit_test(test_no_memory),
        cmocka_unit_test(test_broken_module),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
