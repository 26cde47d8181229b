// Images through libpng and OpenImageIO: round trips, exact values, and files that lie.
#include "image/image.h"

#include "base/io.h"
#include "base/mem.h"

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

enum { WIDTH = 37, HEIGHT = 23, PIXELS = WIDTH * HEIGHT };

static const char *const RGB_NAMES[] = {"R", "G", "B", "A"};
static const ImageLimits LIMITS = {1 << 24};

static FileBytes bytes_of(const char *path)
{
    FileBytes bytes;
    assert_int_equal(file_read(path, 1 << 28, &bytes), IO_OK);
    return bytes;
}

static void write_file(const char *name, const ImageFile *file)
{
    char message[512] = "";
    if (!image_write(path_of(name), name, file, message, sizeof message)) {
        fail_msg("%s: %s", name, message);
    }
}

static Image read_file(const char *name)
{
    FileBytes bytes = bytes_of(path_of(name));
    Image image;
    char message[512] = "";
    if (!image_read(name, bytes.bytes, bytes.size, LIMITS, &image, message, sizeof message)) {
        fail_msg("%s: %s", name, message);
    }
    file_bytes_free(&bytes);
    return image;
}

// A picture with a value of its own in each pixel and channel, in [0, 1].
static float *make_pixels(int channels)
{
    float *pixels = malloc(sizeof(float) * (size_t)(PIXELS * channels));
    for (int i = 0; i < PIXELS * channels; ++i) {
        pixels[i] = (float)((i * 7919) % 10007) / 10006;
    }
    return pixels;
}

static ImageFile one_layer(ImageLayer *layer, const float *pixels, int channels, int bits)
{
    *layer = (ImageLayer){"", channels, RGB_NAMES, pixels, NULL};
    return (ImageFile){WIDTH, HEIGHT, bits, layer, 1, NULL, 0, 1};
}

// Writes and reads again; every value is off by at most `error`.
static void check_round_trip(const char *name, int channels, int bits, float error, bool encoded)
{
    float *pixels = make_pixels(channels);
    ImageLayer layer;
    ImageFile file = one_layer(&layer, pixels, channels, bits);
    write_file(name, &file);
    Image image = read_file(name);
    assert_int_equal(image.width, WIDTH);
    assert_int_equal(image.height, HEIGHT);
    assert_int_equal(image.srgb_encoded, encoded);
    assert_true(image.channels >= channels || channels == 4);
    int both = image.channels < channels ? image.channels : channels;
    for (int i = 0; i < PIXELS; ++i) {
        for (int c = 0; c < both; ++c) {
            float read = image.pixels[i * image.channels + c], was = pixels[i * channels + c];
            if (!(fabsf(read - was) <= error)) {
                fail_msg("%s: pixel %d channel %d is %g, was %g", name, i, c, (double)read,
                         (double)was);
            }
        }
    }
    image_free(&image);
    free(pixels);
}

static void test_round_trips(void **state)
{
    (void)state;
    check_round_trip("a.png", 3, 0, 0.50001f / 255, true);
    check_round_trip("a.PNG", 1, 0, 0.50001f / 255, true);
    check_round_trip("a16.png", 3, 16, 0.5001f / 65535, true);
    check_round_trip("alpha.png", 4, 8, 0.50001f / 255, true);
    check_round_trip("a.tif", 3, 0, 0.5001f / 65535, true);
    check_round_trip("a8.tiff", 3, 8, 0.50001f / 255, true);
    check_round_trip("a32.tif", 3, 32, 0, false);
    check_round_trip("alpha.tif", 4, 16, 0.5001f / 65535, true);
    check_round_trip("a.exr", 3, 0, 0, false);
    check_round_trip("alpha.exr", 4, 0, 0, false);
    check_round_trip("gray.exr", 1, 0, 0, false);
    check_round_trip("half.exr", 3, 16, 0x1p-12f, false);
    check_round_trip("a.hdr", 3, 0, 1.0f / 128, false);
    check_round_trip("a.bmp", 3, 0, 0.50001f / 255, true);
    check_round_trip("a.tga", 3, 0, 0.50001f / 255, true);
    check_round_trip("a.ppm", 3, 0, 0.50001f / 255, true);
}

// JPEG and WebP lose something, but not much of a smooth picture.
static void test_types_with_loss(void **state)
{
    (void)state;
    static const char *const names[] = {"a.jpg", "a.webp"};
    float *pixels = make_pixels(3);
    for (int i = 0; i < PIXELS * 3; ++i) {
        pixels[i] = (float)(i / 3 % WIDTH) / WIDTH;
    }
    ImageLayer layer;
    ImageFile file = one_layer(&layer, pixels, 3, 0);
    for (size_t n = 0; n < 2; ++n) {
        write_file(names[n], &file);
        Image image = read_file(names[n]);
        assert_int_equal(image.channels, 3);
        assert_true(image.srgb_encoded);
        for (int i = 0; i < 3 * PIXELS; ++i) {
            assert_float_equal(image.pixels[i], pixels[i], 0.03f);
        }
        image_free(&image);
    }
    free(pixels);
}

// All values of eight bits come back as they went, and values between go to the nearest.
static void test_exact_png_values(void **state)
{
    (void)state;
    float pixels[3 * 256];
    for (int i = 0; i < 256; ++i) {
        pixels[3 * i] = (float)i / 255;
        pixels[3 * i + 1] = ((float)i + 0.499f) / 255;
        pixels[3 * i + 2] = ((float)i - 0.499f) / 255;
    }
    ImageLayer layer = {"", 3, RGB_NAMES, pixels, NULL};
    ImageFile file = {16, 16, 8, &layer, 1, NULL, 0, 1};
    static const char *const names[] = {"exact.png", "exact.bmp", "exact.tga", "exact.ppm"};
    for (size_t n = 0; n < sizeof names / sizeof names[0]; ++n) {
        write_file(names[n], &file);
        Image image = read_file(names[n]);
        for (int i = 0; i < 3 * 256; ++i) {
            if (lroundf(image.pixels[i] * 255) != i / 3) {
                fail_msg("%s: value %d is %g", names[n], i, (double)image.pixels[i] * 255);
            }
            assert_float_equal(image.pixels[i] * 255, (float)(i / 3), 1e-4f);
        }
        assert_true(image.pixels[3 * 255] == 1.0f);
        image_free(&image);
    }
}

// A PNG of more bands than are compressed at once (module_png_bands.c), of noise, of what repeats
// above or to the left, and of nothing: the bytes are those of one thread, the values come back.
static void test_png_of_many_bands(void **state)
{
    (void)state;
    enum { SIDE = 1900, VALUES = 3 * SIDE * SIDE };
    float *pixels = malloc(sizeof(float) * VALUES);
    assert_non_null(pixels);
    uint32_t noise = 7;
    for (int i = 0; i < VALUES; ++i) {
        const int x = i / 3 % SIDE, y = i / 3 / SIDE;
        noise = noise * 1664525 + 1013904223;
        const uint32_t values[] = {noise >> 16, (uint32_t)x, (uint32_t)(37 * y), 0};
        pixels[i] = (float)(values[y / 50 % 4] & 0xffff) / 65535;
    }
    ImageLayer layer = {"", 3, RGB_NAMES, pixels, NULL};
    ImageFile file = {SIDE, SIDE, 16, &layer, 1, NULL, 0, 1};
    write_file("one.png", &file);
    file.threads = 3;
    write_file("three.png", &file);
    FileBytes one = bytes_of(path_of("one.png")), three = bytes_of(path_of("three.png"));
    assert_int_equal(one.size, three.size);
    assert_memory_equal(one.bytes, three.bytes, one.size);
    assert_true(one.size < 2 * (size_t)VALUES / 3); // a quarter is noise
    file_bytes_free(&one);
    file_bytes_free(&three);
    Image image = read_file("three.png");
    for (int i = 0; i < VALUES; ++i) {
        if (!(fabsf(image.pixels[i] - pixels[i]) < 0.1f / 65535)) {
            fail_msg("value %d is %g, was %g", i, (double)image.pixels[i], (double)pixels[i]);
        }
    }
    image_free(&image);
    free(pixels);
}

// --- PNG files made by hand ----------------------------------------------------------------------

typedef struct PngMaker {
    unsigned char bytes[1024];
    size_t count;
} PngMaker;

static void add_bytes(PngMaker *png, const void *bytes, size_t count)
{
    assert_true(png->count + count <= sizeof png->bytes);
    memcpy(png->bytes + png->count, bytes, count);
    png->count += count;
}

static void add_word(PngMaker *png, uint32_t word)
{
    unsigned char bytes[4] = {(unsigned char)(word >> 24), (unsigned char)(word >> 16),
                              (unsigned char)(word >> 8), (unsigned char)word};
    add_bytes(png, bytes, 4);
}

static void add_chunk(PngMaker *png, const char *type, const void *bytes, size_t count)
{
    add_word(png, (uint32_t)count);
    size_t begin = png->count;
    add_bytes(png, type, 4);
    add_bytes(png, bytes, count);
    uint32_t crc = UINT32_MAX;
    for (size_t i = begin; i < png->count; ++i) {
        crc ^= png->bytes[i];
        for (int bit = 0; bit < 8; ++bit) {
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
        }
    }
    add_word(png, ~crc);
}

// The rows, each behind its filter's number, in one stored block of deflate.
static void add_rows(PngMaker *png, const void *rows, size_t count)
{
    PngMaker data = {.count = 0};
    const unsigned char *at = rows;
    unsigned char head[] = {0x78, 1, 1, (unsigned char)count, 0, (unsigned char)~count, 0xff};
    add_bytes(&data, head, sizeof head);
    add_bytes(&data, rows, count);
    uint32_t a = 1, b = 0;
    for (size_t i = 0; i < count; ++i) {
        a = (a + at[i]) % 65521;
        b = (b + a) % 65521;
    }
    add_word(&data, b << 16 | a);
    add_chunk(png, "IDAT", data.bytes, data.count);
    add_chunk(png, "IEND", "", 0);
}

static PngMaker begin_png(unsigned char width, unsigned char height, unsigned char bits,
                          unsigned char color_type, unsigned char interlaced)
{
    PngMaker png = {.count = 0};
    unsigned char head[13] = {0, 0, 0, width, 0, 0, 0, height, bits, color_type, 0, 0, interlaced};
    add_bytes(&png, "\x89PNG\r\n\x1a\n", 8);
    add_chunk(&png, "IHDR", head, sizeof head);
    return png;
}

// What it should be read as; values in 65535ths.
static void check_png(const PngMaker *png, int channels, bool srgb_encoded, const int *values)
{
    Image image;
    char message[512] = "";
    if (!image_read("a.png", png->bytes, png->count, LIMITS, &image, message, sizeof message)) {
        fail_msg("%s", message);
    }
    assert_int_equal(image.channels, channels);
    assert_int_equal(image.srgb_encoded, srgb_encoded);
    for (int i = 0; i < image.width * image.height * channels; ++i) {
        assert_float_equal(image.pixels[i], (float)values[i] / 65535, 1e-7f);
    }
    image_free(&image);
}

// Palettes, transparent colors, few bits, 16 bits, and rows in seven passes.
static void test_kinds_of_png(void **state)
{
    (void)state;
    enum { FULL = 65535, GRAY = 0, RGB = 2, PALETTE = 3, GRAY_ALPHA = 4 };
    PngMaker png = begin_png(5, 1, 1, GRAY, 0);
    add_rows(&png, "\0\x90", 2); // 10010
    check_png(&png, 1, true, (const int[]){FULL, 0, 0, FULL, 0});
    png = begin_png(2, 1, 4, PALETTE, 0);
    add_chunk(&png, "PLTE", "\xff\0\0\0\xff\0", 6);
    add_rows(&png, "\0\x10", 2);
    check_png(&png, 3, true, (const int[]){0, FULL, 0, FULL, 0, 0});
    png = begin_png(2, 1, 8, PALETTE, 0);
    add_chunk(&png, "PLTE", "\xff\0\0\0\xff\0", 6);
    add_chunk(&png, "tRNS", "\x33", 1);
    add_rows(&png, "\0\0\1", 3);
    check_png(&png, 4, true, (const int[]){FULL, 0, 0, FULL / 5, 0, FULL, 0, FULL});
    png = begin_png(2, 1, 16, GRAY, 0);
    add_chunk(&png, "tRNS", "\x12\x34", 2);
    add_rows(&png, "\0\x12\x34\x12\x35", 5);
    check_png(&png, 2, true, (const int[]){0x1234, 0, 0x1235, FULL});
    png = begin_png(1, 2, 8, GRAY_ALPHA, 0);
    add_chunk(&png, "gAMA", "\0\1\x86\xa0", 4); // 100000: linear
    add_rows(&png, "\0\x33\x66\2\0\x33", 6);    // the second row is a difference to the first
    check_png(&png, 2, false, (const int[]){FULL / 5, 2 * (FULL / 5), FULL / 5, 3 * (FULL / 5)});
    png = begin_png(1, 1, 8, RGB, 0);
    add_chunk(&png, "sRGB", "\0", 1); // wins over the exponent
    add_chunk(&png, "gAMA", "\0\1\x86\xa0", 4);
    add_rows(&png, "\0\x33\x66\x99", 4);
    check_png(&png, 3, true, (const int[]){FULL / 5, 2 * (FULL / 5), 3 * (FULL / 5)});
    // Adam7: of 3 x 3 pixels the passes hold (0,0), none, none, (2,0), (0,2) (2,2), (1,0) (1,2) and
    // the middle row.
    png = begin_png(3, 3, 8, GRAY, 1);
    add_rows(&png,
             "\0\0"
             "\0\x33"
             "\0\x99\xff"
             "\0\x66"
             "\0\xcc"
             "\0\x33\x66\x99",
             15);
    check_png(&png, 1, true,
              (const int[]){0, 2 * (FULL / 5), FULL / 5, FULL / 5, 2 * (FULL / 5), 3 * (FULL / 5),
                            3 * (FULL / 5), 4 * (FULL / 5), FULL});
}

static void test_png_attributes(void **state)
{
    (void)state;
    float pixel[4] = {1, 0.5f, 0, 0.25f};
    ImageLayer layer = {"", 4, RGB_NAMES, pixel, NULL};
    static const ImageAttribute attributes[] = {
        {"Software", "scnrender"}, {"scnrender:camera", ""}, {"scnrender:scene", "bl\u00fcte.scn"}};
    ImageFile file = {1, 1, 0, &layer, 1, attributes, 3, 1};
    write_file("texts.png", &file);
    FileBytes bytes = bytes_of(path_of("texts.png"));
    static const struct {
        const char *bytes;
        size_t count;
    } expected[] = {{"tEXtSoftware\0scnrender", 22},
                    {"tEXtscnrender:camera\0", 21},
                    {"iTXtscnrender:scene\0\0\0\0\0bl\u00fcte.scn", 34}, // not Latin-1, but UTF-8
                    {"gAMA\0\0\xb1\x8f", 8},
                    {"sRGB\3", 5}};
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; ++i) {
        if (!memmem(bytes.bytes, bytes.size, expected[i].bytes, expected[i].count)) {
            fail_msg("no %s", expected[i].bytes);
        }
    }
    file_bytes_free(&bytes);
}

static void test_values_out_of_range(void **state)
{
    (void)state;
    float pixels[3 * 4] = {-1,    -INFINITY, NAN,  1.0001f, 7, INFINITY,
                           -0.0f, 1e-30f,    0.5f, 1,       0, 0.25f};
    static const int expected[3 * 4] = {0, 0, 0, 255, 255, 255, 0, 0, 128, 255, 0, 64};
    ImageLayer layer = {"", 3, RGB_NAMES, pixels, NULL};
    ImageFile file = {2, 2, 8, &layer, 1, NULL, 0, 1};
    write_file("range.png", &file);
    Image image = read_file("range.png");
    for (int i = 0; i < 3 * 4; ++i) {
        assert_int_equal(lroundf(image.pixels[i] * 255), expected[i]);
    }
    image_free(&image);
    file.bits = 32; // floats are kept whatever they are
    write_file("range.exr", &file);
    image = read_file("range.exr");
    assert_memory_equal(image.pixels, pixels, sizeof pixels);
    image_free(&image);
}

static bool contains(const FileBytes *bytes, const char *text)
{
    return memmem(bytes->bytes, bytes->size, text, strlen(text)) != NULL;
}

static void write_layers(const char *name, const uint32_t *ids, const float *picture,
                         const float *normals, const float *depth)
{
    static const char *const xyz[] = {"X", "Y", "Z"}, *const z[] = {"Z"}, *const id[] = {"id"};
    ImageLayer layers[] = {{"", 3, RGB_NAMES, picture, NULL},
                           {"normal", 3, xyz, normals, NULL},
                           {"depth", 1, z, depth, NULL},
                           {"object", 1, id, NULL, ids}};
    ImageAttribute attributes[] = {{"scnrender:sceneHash", "0123456789abcdef"},
                                   {"scnrender:samples", "64"}};
    ImageFile file = {WIDTH, HEIGHT, 0, layers, 4, attributes, 2, 1};
    write_file(name, &file);
}

static void test_exr_layers_and_attributes(void **state)
{
    (void)state;
    uint32_t *ids = malloc(sizeof *ids * PIXELS);
    float *picture = make_pixels(3), *normals = make_pixels(3), *depth = make_pixels(1);
    for (uint32_t i = 0; i < PIXELS; ++i) {
        ids[i] = UINT32_MAX - i; // more than a float holds
        normals[3 * i] = -normals[3 * i];
        depth[i] = 1000 * depth[i];
    }
    write_layers("layers.exr", ids, picture, normals, depth);
    FileBytes bytes = bytes_of(path_of("layers.exr"));
    static const char *const expected[] = {
        "normal.X",      "normal.Y",         "normal.Z", "depth.Z",
        "object.id",     "0123456789abcdef", "samples",  "scnrender:sceneHash",
        "chromaticities"};
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; ++i) {
        if (!contains(&bytes, expected[i])) {
            fail_msg("no %s", expected[i]);
        }
    }
    // Among more than four channels, the picture is what is read.
    Image image = read_file("layers.exr");
    assert_int_equal(image.channels, 3);
    assert_memory_equal(image.pixels, picture, sizeof(float) * 3 * PIXELS);
    image_free(&image);
    file_bytes_free(&bytes);
    // Other types take the first layer.
    write_layers("layers.png", ids, picture, normals, depth);
    image = read_file("layers.png");
    assert_int_equal(image.channels, 3);
    image_free(&image);
    free(ids);
    free(picture);
    free(normals);
    free(depth);
}

static void test_same_bytes(void **state)
{
    (void)state;
    static const char *const types[] = {"exr",  "png", "tif", "hdr", "jpg",
                                        "webp", "bmp", "tga", "ppm"};
    FileBytes first[sizeof types / sizeof types[0]];
    float *pixels = make_pixels(3);
    ImageLayer layer;
    ImageFile file = one_layer(&layer, pixels, 3, 0);
    for (int round = 0; round < 2; ++round) {
        for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i) {
            char name[32];
            snprintf(name, sizeof name, "same%d.%s", round, types[i]);
            write_file(name, &file);
            FileBytes bytes = bytes_of(path_of(name));
            if (round == 0) {
                first[i] = bytes;
                continue;
            }
            if (bytes.size != first[i].size ||
                memcmp(bytes.bytes, first[i].bytes, bytes.size) != 0) {
                fail_msg("%s differs", types[i]);
            }
            file_bytes_free(&bytes);
            file_bytes_free(&first[i]);
        }
        if (round == 0) {
            sleep(1); // a time stamp would count on
        }
    }
    free(pixels);
}

// --- Files that lie ------------------------------------------------------------------------------

// True when it was read; a failure has a message of one line.
static bool try_reading(const char *name, const void *bytes, size_t size, ImageLimits limits)
{
    Image image;
    char message[512] = "";
    bool good = image_read(name, bytes, size, limits, &image, message, sizeof message);
    if (good) {
        assert_true(image.width > 0 && image.height > 0 && image.channels > 0);
        assert_true((int64_t)image.width * image.height <= limits.max_pixels);
    } else {
        assert_true(message[0] != '\0');
        assert_null(strchr(message, '\n'));
        assert_null(image.pixels);
    }
    image_free(&image);
    return good;
}

static void test_damaged_files(void **state)
{
    (void)state;
    static const char *const names[] = {"d.exr",  "d.png", "d.tif", "d.hdr", "d.jpg",
                                        "d.webp", "d.bmp", "d.tga", "d.ppm"};
    float *pixels = make_pixels(3);
    ImageLayer layer;
    ImageFile file = one_layer(&layer, pixels, 3, 0);
    uint32_t random = 12345;
    for (size_t n = 0; n < sizeof names / sizeof names[0]; ++n) {
        write_file(names[n], &file);
        FileBytes bytes = bytes_of(path_of(names[n]));
        assert_true(try_reading(names[n], bytes.bytes, bytes.size, LIMITS));
        for (size_t cut = 0; cut < bytes.size; cut += cut < 64 ? 1 : bytes.size / 16) {
            char *shorter = malloc(cut + 1); // so that a sanitizer sees a read beyond the end
            memcpy(shorter, bytes.bytes, cut);
            bool read = try_reading(names[n], shorter, cut, LIMITS);
            assert_false(read && cut < 4);
            free(shorter);
        }
        char *changed = malloc(bytes.size);
        for (int round = 0; round < 150; ++round) {
            memcpy(changed, bytes.bytes, bytes.size);
            for (int k = 0; k < 1 + round % 4; ++k) {
                random = random * 1664525 + 1013904223;
                size_t span = round % 2 ? bytes.size : 128; // headers first of all
                changed[(random >> 8) % (span < bytes.size ? span : bytes.size)] =
                    (char)(random >> 3);
            }
            try_reading(names[n], changed, bytes.size, LIMITS);
        }
        free(changed);
        file_bytes_free(&bytes);
    }
    free(pixels);
}

// IPTC data that say that they are longer than they are bear on no pixel, and nothing is read
// beyond their end.
static void test_jpeg_with_iptc(void **state)
{
    (void)state;
    static const char segment[] = "\xff\xed\x00\x21Photoshop 3.0\0"
                                  "8BIM\4\4\0\0\xff\xff\x1c\2\5\xff\xf0"
                                  "ab";
    enum { SEGMENT = sizeof segment - 1 };
    float *pixels = make_pixels(3);
    ImageLayer layer;
    ImageFile file = one_layer(&layer, pixels, 3, 0);
    write_file("i.jpg", &file);
    Image plain = read_file("i.jpg");
    FileBytes bytes = bytes_of(path_of("i.jpg"));
    const size_t size = bytes.size + SEGMENT;
    char *longer = malloc(size);
    memcpy(longer, bytes.bytes, 2);
    memcpy(longer + 2, segment, SEGMENT);
    memcpy(longer + 2 + SEGMENT, bytes.bytes + 2, bytes.size - 2);
    Image image;
    char message[512] = "";
    assert_true(image_read("i.jpg", longer, size, LIMITS, &image, message, sizeof message));
    assert_int_equal(image.width, plain.width);
    assert_int_equal(image.channels, plain.channels);
    assert_memory_equal(image.pixels, plain.pixels,
                        sizeof(float) * (size_t)(plain.width * plain.height * plain.channels));
    image_free(&image);
    image_free(&plain);
    free(longer);
    file_bytes_free(&bytes);
    free(pixels);
}

static void test_huge_sizes(void **state)
{
    (void)state;
    static const unsigned char png[] =
        "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\x7f\xff\xff\xff\x7f\xff\xff\xff\x08\x02\0\0\0\0\0\0\0";
    static const unsigned char bmp[] =
        "BM\x46\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\xff\xff\xff\x7f\xff\xff\xff\x7f\x01\0\x18\0\0\0"
        "\0\0\x10\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";
    static const unsigned char tga[] = "\0\0\x02\0\0\0\0\0\0\0\0\0\xff\xff\xff\xff\x18\0abcdef";
    static const unsigned char hdr[] =
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\nabcd";
    static const unsigned char ppm[] = "P6 2000000000 2000000000 255\nabcdef";
    static const unsigned char gif[] =
        "GIF89a\xff\xff\xff\xff\0\0\0,\0\0\0\0\xff\xff\xff\xff\0\x02";
    const struct {
        const char *name;
        const unsigned char *bytes;
        size_t size;
    } files[] = {{"h.png", png, sizeof png - 1}, {"h.bmp", bmp, sizeof bmp - 1},
                 {"h.tga", tga, sizeof tga - 1}, {"h.hdr", hdr, sizeof hdr - 1},
                 {"h.ppm", ppm, sizeof ppm - 1}, {"h.gif", gif, sizeof gif - 1}};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; ++i) {
        if (try_reading(files[i].name, files[i].bytes, files[i].size, LIMITS)) {
            fail_msg("%s was read", files[i].name);
        }
    }
    struct rusage used; // and no memory was taken for what they claim
    assert_int_equal(getrusage(RUSAGE_SELF, &used), 0);
#ifndef __SANITIZE_ADDRESS__
    assert_true(used.ru_maxrss < 1000000);
#endif
}

// A small file whose header claims long rows, for which OpenEXR would take gigabytes at once.
static void test_long_rows(void **state)
{
    (void)state;
    float pixels[3] = {1, 2, 3};
    ImageLayer layer = {"", 3, RGB_NAMES, pixels, NULL};
    ImageFile file = {1, 1, 0, &layer, 1, NULL, 0, 1};
    write_file("long.exr", &file);
    FileBytes bytes = bytes_of(path_of("long.exr"));
    char *window = memmem(bytes.bytes, bytes.size, "dataWindow", 10);
    assert_non_null(window);
    char *x1 = window + 11 + 6 + 4 + 8;
    memcpy(x1, "\0\0\0\x01", 4); // 2^24
    assert_false(try_reading("long.exr", bytes.bytes, bytes.size, LIMITS));
    memcpy(x1, "\xff\xff\xff\xff", 4); // an empty window
    assert_false(try_reading("long.exr", bytes.bytes, bytes.size, LIMITS));
    file_bytes_free(&bytes);
}

static void test_pixel_limit(void **state)
{
    (void)state;
    float *pixels = make_pixels(3);
    ImageLayer layer;
    ImageFile file = one_layer(&layer, pixels, 3, 0);
    write_file("limit.exr", &file);
    FileBytes bytes = bytes_of(path_of("limit.exr"));
    assert_false(try_reading("limit.exr", bytes.bytes, bytes.size, (ImageLimits){PIXELS - 1}));
    assert_true(try_reading("limit.exr", bytes.bytes, bytes.size, (ImageLimits){PIXELS}));
    file_bytes_free(&bytes);
    free(pixels);
}

static void test_unknown_types(void **state)
{
    (void)state;
    assert_false(try_reading("a.txt", "hello", 5, LIMITS));
    assert_false(try_reading("a.png", "hello", 5, LIMITS));
    assert_false(try_reading("a", "", 0, LIMITS));
    // The bytes decide, not the name.
    float *pixels = make_pixels(3);
    ImageLayer layer;
    ImageFile file = one_layer(&layer, pixels, 3, 0);
    write_file("true.png", &file);
    FileBytes bytes = bytes_of(path_of("true.png"));
    assert_true(try_reading("lies.jpg", bytes.bytes, bytes.size, LIMITS));
    file_bytes_free(&bytes);
    char message[512] = "";
    assert_false(image_write(path_of("a.txt"), "a.txt", &file, message, sizeof message));
    assert_non_null(strstr(message, "exr, png"));
    file.bits = 16;
    assert_false(image_write(path_of("a.jpg"), "a.jpg", &file, message, sizeof message));
    free(pixels);
}

static void test_what_can_be_written(void **state)
{
    (void)state;
    assert_true(image_can_write("a/b.c/picture.png"));
    assert_true(image_can_write("P.EXR"));
    assert_false(image_can_write("png"));
    assert_false(image_can_write(".png")); // a hidden file without a type
    assert_false(image_can_write("a.png/b"));
    assert_false(image_can_write(""));
    assert_false(image_can_write("a.pngx"));
    assert_true(image_has_bits("a.png", 16));
    assert_false(image_has_bits("a.png", 32));
    assert_false(image_has_bits("a.jpg", 16));
    assert_true(image_has_bits("a.jpg", 0));
    assert_false(image_has_bits("a.txt", 0));
    assert_true(image_is_linear("a.exr", 16));
    assert_true(image_is_linear("a.hdr", 0));
    assert_true(image_is_linear("a.tif", 32));
    assert_false(image_is_linear("a.tif", 0));
    assert_false(image_is_linear("a.png", 16));
    assert_true(image_has_layers("a.exr"));
    assert_false(image_has_layers("a.tif"));
    // The list is the table.
    char list[128], name[32];
    snprintf(list, sizeof list, "%s", image_extensions());
    for (char *at = strtok(list, ", "); at; at = strtok(NULL, ", ")) {
        snprintf(name, sizeof name, "a.%s", at);
        assert_true(image_can_write(name));
    }
}

// Where a disk is full, writing says so whatever the type.
static void test_full_disk(void **state)
{
    (void)state;
    static const char *const names[] = {"f.exr",  "f.png", "f.tif", "f.hdr", "f.jpg",
                                        "f.webp", "f.bmp", "f.tga", "f.ppm"};
    float *pixels = make_pixels(3);
    ImageLayer layer;
    ImageFile file = one_layer(&layer, pixels, 3, 0);
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    for (size_t n = 0; n < sizeof names / sizeof names[0]; ++n) {
        write_file(names[n], &file);
        FileBytes bytes = bytes_of(path_of(names[n]));
        rlim_t room[] = {0, 100, bytes.size / 2, bytes.size - 1};
        file_bytes_free(&bytes);
        for (size_t i = 0; i < sizeof room / sizeof room[0]; ++i) {
            struct rlimit small = {room[i], before.rlim_max};
            char message[512] = "";
            assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
            bool written = image_write(path_of(names[n]), names[n], &file, message, sizeof message);
            assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
            if (written || strstr(message, "File too large") == NULL) {
                fail_msg("%s, %d bytes: %d %s", names[n], (int)room[i], written, message);
            }
        }
    }
    char message[512] = "";
    char none[64];
    snprintf(none, sizeof none, "%s/none/a.png", folder);
    assert_false(image_write(none, "a.png", &file, message, sizeof message));
    assert_non_null(strstr(message, "No such file"));
    free(pixels);
}

static void test_no_memory(void **state)
{
    (void)state;
    float *pixels = make_pixels(3);
    ImageLayer layer;
    ImageFile file = one_layer(&layer, pixels, 3, 0);
    char message[512];
    write_file("memory.png", &file);
    FileBytes bytes = bytes_of(path_of("memory.png"));
    mem_fail_after(0);
    Image image;
    bool read = image_read("a.png", bytes.bytes, bytes.size, LIMITS, &image, message, 512);
    bool written = image_write(path_of("memory.png"), "a.png", &file, message, 512);
    mem_fail_after(1);
    written |= image_write(path_of("memory.png"), "a.png", &file, message, 512);
    mem_fail_after(UINT64_MAX);
    assert_false(read);
    assert_false(written);
    file_bytes_free(&bytes);
    free(pixels);
}

// Neither library is there, or what lies in its place is none.
static void check_missing_module(const char *name, const char *module, const char *complaint)
{
    setenv("SCNRENDER_MODULES", folder, 1); // an empty one: the search goes on beside the program
    char message[512] = "";
    float pixel[3] = {0};
    ImageLayer layer = {"", 3, RGB_NAMES, pixel, NULL};
    ImageFile file = {1, 1, 0, &layer, 1, NULL, 0, 1};
    if (!image_write(path_of(name), name, &file, message, sizeof message)) {
        assert_non_null(strstr(message, complaint));
    }
    char broken[128];
    snprintf(broken, sizeof broken, "%s/%s.so", folder, module);
    FILE *fake = fopen(broken, "w");
    fputs("not a library", fake);
    fclose(fake);
    assert_false(image_write(path_of(name), name, &file, message, sizeof message));
    assert_non_null(strstr(message, complaint));
    assert_false(image_available(name, message, sizeof message));
    assert_non_null(strstr(message, complaint));
    setenv("SCNRENDER_MODULES", SCN_BINARY_DIR "/lib/scnrender", 1);
    image_preload(name);
    image_preload("");
    assert_true(image_available(name, message, sizeof message));
    assert_true(image_write(path_of(name), name, &file, message, sizeof message));
}

static void test_missing_module(void **state)
{
    (void)state;
    check_missing_module("m.tif", "scn_oiio", "OpenImageIO can't be loaded");
    check_missing_module("m.png", "scn_png", "libpng can't be loaded");
}

int main(void)
{
    setenv("SCNRENDER_MODULES", SCN_BINARY_DIR "/lib/scnrender", 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_missing_module),
        cmocka_unit_test(test_round_trips),
        cmocka_unit_test(test_types_with_loss),
        cmocka_unit_test(test_exact_png_values),
        cmocka_unit_test(test_png_of_many_bands),
        cmocka_unit_test(test_kinds_of_png),
        cmocka_unit_test(test_png_attributes),
        cmocka_unit_test(test_values_out_of_range),
        cmocka_unit_test(test_exr_layers_and_attributes),
        cmocka_unit_test(test_same_bytes),
        cmocka_unit_test(test_jpeg_with_iptc),
        cmocka_unit_test(test_damaged_files),
        cmocka_unit_test(test_huge_sizes),
        cmocka_unit_test(test_long_rows),
        cmocka_unit_test(test_pixel_limit),
        cmocka_unit_test(test_unknown_types),
        cmocka_unit_test(test_what_can_be_written),
        cmocka_unit_test(test_full_disk),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
