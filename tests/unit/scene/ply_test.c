#include "../test_support.h"
#include "scene/mesh.h"
#include "scene/mesh_build.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Bytes {
    char at[8192];
    size_t size;
} Bytes;

static void put(Bytes *bytes, const void *what, size_t size)
{
    assert_true(bytes->size + size <= sizeof bytes->at);
    memcpy(bytes->at + bytes->size, what, size);
    bytes->size += size;
}

static void put_text(Bytes *bytes, const char *text)
{
    put(bytes, text, strlen(text));
}

// A number of `size` bytes in either byte order.
static void put_bits(Bytes *bytes, const void *value, size_t size, bool big)
{
    const char *little = value;
    for (size_t i = 0; i < size; ++i) {
        put(bytes, little + (big ? size - 1 - i : i), 1);
    }
}

static void put_float(Bytes *bytes, float value, bool big)
{
    put_bits(bytes, &value, sizeof value, big);
}

typedef struct Read {
    Arena arena;
    Mesh mesh;
    char message[256];
    bool good;
} Read;

// Reads from memory of exactly that size, so that a sanitizer sees every byte beyond it.
static Read read_bytes(const char *bytes, size_t size)
{
    Read read = {0};
    char *exact = malloc(size ? size : 1);
    memcpy(exact, bytes, size);
    read.good = ply_read(&read.arena, exact, size, &read.mesh, read.message, sizeof read.message);
    free(exact);
    return read;
}

static Read read_text(const char *text)
{
    return read_bytes(text, strlen(text));
}

static const char square_header[] = "comment a square\n"
                                    "element vertex 4\n"
                                    "property float x\nproperty float y\nproperty float z\n"
                                    "element face 2\n"
                                    "property list uchar int vertex_indices\n"
                                    "end_header\n";
static const float square[4][3] = {{0, 0, 0}, {2, 0, 0}, {2, 1.5f, 0}, {0, 1.5f, -0.25f}};

static void make_binary(Bytes *bytes, bool big)
{
    bytes->size = 0;
    put_text(bytes, big ? "ply\nformat binary_big_endian 1.0\n"
                        : "ply\nformat binary_little_endian 1.0\n");
    put_text(bytes, square_header);
    for (int i = 0; i < 12; ++i) {
        put_float(bytes, square[i / 3][i % 3], big);
    }
    static const int32_t faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
    for (int f = 0; f < 2; ++f) {
        put(bytes, "\3", 1);
        for (int i = 0; i < 3; ++i) {
            put_bits(bytes, &faces[f][i], 4, big);
        }
    }
}

static void make_ascii(Bytes *bytes)
{
    bytes->size = 0;
    put_text(bytes, "ply\nformat ascii 1.0\n");
    put_text(bytes, square_header);
    put_text(bytes, "0 0 0\n2 0 0\n2 1.5 0\n0 15e-1 -.25\n3 0 1 2\n3 0 2 3\n");
}

static void check_square(Read *read)
{
    if (!read->good) {
        fail_msg("%s", read->message);
    }
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    assert_int_equal(read->mesh.vertex_count, 4);
    assert_int_equal(read->mesh.triangle_count, 2);
    assert_memory_equal(read->mesh.positions, square, sizeof square);
    assert_memory_equal(read->mesh.triangles, triangles, sizeof triangles);
    assert_null(read->mesh.normals);
    assert_null(read->mesh.uvs);
    assert_null(read->mesh.colors);
    assert_true(length(read->mesh.origin) == 0);
    arena_free(&read->arena);
}

static void all_three_formats(void **state)
{
    (void)state;
    Bytes bytes;
    make_ascii(&bytes);
    Read read = read_bytes(bytes.at, bytes.size);
    check_square(&read);
    for (int big = 0; big < 2; ++big) {
        make_binary(&bytes, big);
        read = read_bytes(bytes.at, bytes.size);
        check_square(&read);
    }
}

// With \r\n and \r instead of \n, blank lines, and other blanks.
static void line_ends(void **state)
{
    (void)state;
    Bytes unix_text, other;
    make_ascii(&unix_text);
    static const char *const ends[] = {"\r\n", "\r", "\n\n", " \n", "\r\n\r\n", "\t \r"};
    for (size_t e = 0; e < TEST_COUNT(ends); ++e) {
        other.size = 0;
        for (size_t i = 0; i < unix_text.size; ++i) {
            if (unix_text.at[i] == '\n') {
                put_text(&other, ends[e]);
            } else {
                put(&other, unix_text.at[i] == ' ' ? "\t" : &unix_text.at[i], 1);
            }
        }
        for (size_t cut = 0; cut < 2; ++cut) { // also without the last line's end
            Read read = read_bytes(other.at, other.size - cut * strlen(ends[e]));
            check_square(&read);
        }
    }
}

// A binary body that begins with what looks like an end of line, behind each kind of line end.
static void binary_after_any_line_end(void **state)
{
    (void)state;
    static const char *const ends[] = {"\n", "\r\n"};
    for (size_t e = 0; e < TEST_COUNT(ends); ++e) {
        Bytes bytes = {.size = 0};
        static const char *const lines[] = {"ply",
                                            "format binary_little_endian 1.0",
                                            "element vertex 3",
                                            "property uchar x",
                                            "property char y",
                                            "property short z",
                                            "element face 1",
                                            "property list uint ushort vertex_index",
                                            "end_header"};
        for (size_t i = 0; i < TEST_COUNT(lines); ++i) {
            put_text(&bytes, lines[i]);
            put_text(&bytes, ends[e]);
        }
        put(&bytes,
            "\n\r\r\n"
            "\xff\x80\x00\x80"
            "\1\2\3\4",
            12);
        put(&bytes,
            "\3\0\0\0"
            "\2\0\1\0\0\0",
            10);
        Read read = read_bytes(bytes.at, bytes.size);
        assert_true(read.good);
        static const float expected[] = {10, 13, 2573, 255, -128, -32768, 1, 2, 1027};
        assert_memory_equal(read.mesh.positions, expected, sizeof expected);
        assert_int_equal(read.mesh.triangles[0], 2);
        arena_free(&read.arena);
    }
}

// Every property in an odd order and type, elements that mean nothing to us, lists in the vertices,
// and faces before vertices.
static const char everything[] =
    "ply\nformat ascii 1.0\nobj_info made by hand\ncomment\n"
    "element camera 1\nproperty float view\nproperty list uchar float matrix\n"
    "element face 1\nproperty uchar flags\nproperty list uchar float weights\n"
    "property list ushort uint vertex_index\nproperty double quality\n"
    "element nothing 1000000000000\n"
    "element vertex 3\nproperty double nz\nproperty uchar green\nproperty double z\n"
    "property float t\nproperty list uchar uchar tags\nproperty uchar red\nproperty uchar blue\n"
    "property uchar alpha\nproperty double y\nproperty double x\nproperty float s\n"
    "property double nx\nproperty double ny\n"
    "element edge 2\nproperty int a\nproperty int b\n"
    "end_header\n"
    "1 2 3.5 4.5\n"
    "9 2 0.5 0.5 3 0 1 2 0.25\n"
    "1 255 0 0.5 0 0 128 255 0 0 0.25 0 0\n"
    "0 0 0 0 2 7 7 255 0 9 0 1 0 0 1\n"
    "0 64 0 1 1 3 64 64 9 1 0 1 1 0\n"
    "0 1\n1 2\n";

static void properties_in_any_order(void **state)
{
    (void)state;
    Read read = read_text(everything);
    if (!read.good) {
        fail_msg("%s", read.message);
    }
    const Mesh *mesh = &read.mesh;
    assert_int_equal(mesh->triangle_count, 1);
    assert_int_equal(mesh->vertex_count, 3);
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const float normals[] = {0, 0, 1, 0, 1, 0, 1, 0, 0};
    static const float uvs[] = {0.25f, 0.5f, 0, 0, 1, 1};
    assert_memory_equal(mesh->positions, positions, sizeof positions);
    assert_memory_equal(mesh->normals, normals, sizeof normals);
    assert_memory_equal(mesh->uvs, uvs, sizeof uvs);
    // Whole-number colors are sRGB-encoded: 128 is 0.2158605, 64 is 0.0512695.
    static const float colors[] = {0, 1, 0.2158605f, 1, 0, 0, 0.0512695f, 0.0512695f, 0.0512695f};
    for (int i = 0; i < 9; ++i) {
        assert_true(fabsf(mesh->colors[i] - colors[i]) < 1e-6f);
    }
    arena_free(&read.arena);
}

static void floating_colors_are_linear(void **state)
{
    (void)state;
    Read read = read_text("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                          "property float y\nproperty float z\nproperty float red\n"
                          "property float green\nproperty ushort blue\nelement face 1\n"
                          "property list uchar int vertex_indices\nend_header\n"
                          "0 0 0 0.5 2 65535\n1 0 0 0 0 0\n0 1 0 0 0 32768\n3 0 1 2\n");
    assert_true(read.good);
    assert_true(read.mesh.colors[0] == 0.5f && read.mesh.colors[1] == 2.0f);
    assert_true(fabsf(read.mesh.colors[2] - 1.0f) < 1e-6f);
    assert_true(fabsf(read.mesh.colors[8] - 0.2140489f) < 1e-5f);
    arena_free(&read.arena);
}

// Cut into triangles that cover the polygon; an L and a square with a point in the middle of a
// side.
static void polygons_are_cut(void **state)
{
    (void)state;
    Read read = read_text("ply\nformat ascii 1.0\nelement vertex 10\nproperty float x\n"
                          "property float y\nproperty float z\nelement face 4\n"
                          "property list uchar int vertex_indices\nend_header\n"
                          "0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n"
                          "5 0 0\n6 0 0\n6 1 0\n5 1 0\n"
                          "6 0 1 2 3 4 5\n4 6 7 8 9\n4 0 5 3 2\n2 0 1\n");
    assert_true(read.good);
    assert_int_equal(read.mesh.triangle_count, 4 + 2 + 2);
    assert_int_equal(read.mesh.degenerate, 1);
    double area = 0;
    for (uint32_t t = 0; t < 6; ++t) {
        Vec3 p[3];
        for (int i = 0; i < 3; ++i) {
            const float *at = read.mesh.positions + 3 * read.mesh.triangles[3 * t + (uint32_t)i];
            p[i] = vec3((double)at[0], (double)at[1], (double)at[2]);
        }
        Vec3 n = cross(sub(p[1], p[0]), sub(p[2], p[0]));
        assert_true(n.z > 0);
        area += n.z / 2;
    }
    assert_true(fabs(area - 4) < 1e-12);
    arena_free(&read.arena);
}

static void triangle_strips(void **state)
{
    (void)state;
    Read read = read_text("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                          "property float y\nproperty float z\nelement tristrips 1\n"
                          "property list int int vertex_indices\nend_header\n"
                          "0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 3 2 1\n");
    if (!read.good) {
        fail_msg("%s", read.message);
    }
    static const uint32_t triangles[] = {0, 1, 2, 2, 1, 3, 3, 2, 1};
    assert_int_equal(read.mesh.triangle_count, 3);
    assert_memory_equal(read.mesh.triangles, triangles, sizeof triangles);
    arena_free(&read.arena);
}

// Triangles that can't be used are counted, and those left keep their order.
static void bad_triangles_are_counted(void **state)
{
    (void)state;
    Read read = read_text("ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\n"
                          "property float y\nproperty float z\nelement face 7\n"
                          "property list uchar int vertex_indices\nend_header\n"
                          "0 0 0\n1 0 0\n2 0 0\n0 1 0\nnan 0 0\n0 -inf 0\n0 1.#QNAN 0\n"
                          "3 0 1 2\n3 0 1 3\n3 0 0 1\n3 0 1 4\n3 0 5 1\n4 0 1 3 6\n3 3 2 1\n");
    if (!read.good) {
        fail_msg("%s", read.message);
    }
    assert_int_equal(read.mesh.triangle_count, 2);
    assert_int_equal(read.mesh.degenerate, 2);
    assert_int_equal(read.mesh.not_finite, 4);
    static const uint32_t triangles[] = {0, 1, 3, 3, 2, 1};
    assert_memory_equal(read.mesh.triangles, triangles, sizeof triangles);
    arena_free(&read.arena);
}

// Doubles far from the origin keep their detail; near it the origin stays zero.
static void far_away(void **state)
{
    (void)state;
    Read read = read_text("ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\n"
                          "property double y\nproperty double z\nelement face 1\n"
                          "property list uchar int vertex_indices\nend_header\n"
                          "1000000.001 0 0\n1000000.002 0 0\n1000000.001 0.001 0\n3 0 1 2\n");
    assert_true(read.good);
    double side = (double)(read.mesh.positions[3] - read.mesh.positions[0]);
    assert_true(fabs(side - 0.001) < 1e-9);
    assert_true(fabs(read.mesh.origin.x + (double)read.mesh.positions[0] - 1000000.001) < 1e-9);
    arena_free(&read.arena);
    read = read_text("ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\n"
                     "property double y\nproperty double z\nelement face 1\n"
                     "property list uchar int vertex_indices\nend_header\n"
                     "1 0 0\n2 0 0\n1 1e300 0\n3 0 1 2\n");
    assert_true(read.good);
    assert_true(length(read.mesh.origin) == 0);
    assert_int_equal(read.mesh.not_finite, 1); // too large for a float
    arena_free(&read.arena);
}

#define HEADER "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
#define REST                                                                                       \
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"

// Damaged files, each with the exact message.
static void damage_is_named(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"", "line 1: a PLY file begins with the word `ply`"},
        {"plyx\n", "line 1: a PLY file begins with the word `ply`"},
        {"ply\n", "line 1: the file ends within its header"},
        {"ply\nformat ascii 1.0\nend_header\n", "line 3: the header announces no vertices"},
        {"ply\nelement vertex 0\nproperty float x\nproperty float y\nproperty float "
         "z\nend_header\n",
         "line 6: the header names no format"},
        {"ply\nformat ascii 2.0\n", "line 2: version `2.0` of PLY is not known"},
        {"ply\nformat text 1.0\n", "line 2: `text` is not a format of PLY"},
        {"ply\nformat ascii 1.0\nvertices 3\n", "line 3: `vertices` is not a word of PLY's header"},
        {"ply\nformat ascii 1.0\nelement vertex many\n",
         "line 3: `many` is not a count of elements"},
        {"ply\nformat ascii 1.0\nelement vertex -1\n", "line 3: `-1` is not a count of elements"},
        {"ply\nformat ascii 1.0\nelement vertex 99999999999999999999999\n",
         "line 3: `99999999999999999999999` is not a count of elements"},
        {"ply\nformat ascii 1.0\nelement vertex\n", "line 3: `` is not a count of elements"},
        {"ply\nformat ascii 1.0\nproperty float x\n",
         "line 3: a property before the first element"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty long x\n",
         "line 4: `long` is not a type of PLY (char, uchar, short, ushort, int, uint, float, "
         "double)"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float\n",
         "line 4: a property without a name"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nelement vertex 2\n",
         "line 4: a second element `vertex`"},
        {"ply\nformat ascii 1.0\nelement face 1\nproperty list float int vertex_indices\n",
         "line 4: the length of a list can't be a float"},
        {"ply\nformat ascii 1.0\nelement face 1\nproperty list uchar float vertex_indices\n",
         "line 4: indices of vertices can't be of type float"},
        {HEADER "end_header\n", "line 6: the vertices have no property `z`"},
        {HEADER "property float z\nelement face 1\nproperty int a\nend_header\n",
         "line 9: element `face` has no list `vertex_indices`"},
        {HEADER REST "0 0 0\n1 0 0\n0 1\n3 0 1 2\n", "line 12: the line ends before `z`"},
        {HEADER REST "0 0 0\n1 0 0\n0 1 x\n3 0 1 2\n", "line 12: `x` is not a number"},
        {HEADER REST "0 0 0\n1 0 0\n0 1 0x5\n3 0 1 2\n", "line 12: `0x5` is not a number"},
        {HEADER REST "0 0 0\n1 0 0 0\n0 1 0\n3 0 1 2\n",
         "line 11: `0` is more than element `vertex` has properties"},
        {HEADER REST "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
         "line 13: face 0 refers to vertex 3, but there are 3 vertices, counted from 0"},
        {HEADER REST "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
         "line 13: face 0 refers to vertex -1, but there are 3 vertices, counted from 0"},
        {HEADER REST "0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n",
         "line 13: 1.5 is not a value of type int, which `vertex_indices` has"},
        {HEADER REST "0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n",
         "line 13: the list `vertex_indices` is to have 4 items, but the line ends before"},
        {HEADER REST "0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n",
         "line 13: -3 is not a value of type uchar, which `vertex_indices` has"},
        {HEADER REST "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 0\n",
         "line 13: `0` is more than element `face` has properties"},
        {HEADER REST "0 0 0\n1 0 0\n", "line 11: the file ends after 2 of the 3 lines announced "
                                       "for element `vertex`"},
        {HEADER REST "0 0 0\n1 0 0\n0 1 0\n", "line 12: the file ends after 0 of the 1 lines "
                                              "announced for element `face`"},
        {HEADER REST "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n\n3 0 1 2\n",
         "line 15: more data than the header announces"},
    };
    for (size_t i = 0; i < TEST_COUNT(cases); ++i) {
        Read read = read_text(cases[i][0]);
        assert_false(read.good);
        assert_string_equal(read.message, cases[i][1]);
        arena_free(&read.arena);
    }
}

static void damage_in_binary_is_named(void **state)
{
    (void)state;
    Bytes bytes;
    make_binary(&bytes, false);
    size_t body = bytes.size - 48 - 26;
    char expected[200];
    bytes.at[body + 48 + 13 + 5] = 9;
    Read read = read_bytes(bytes.at, bytes.size);
    snprintf(expected, sizeof expected,
             "byte %zu: face 1 refers to vertex 9, but there are 4 vertices, counted from 0",
             body + 48 + 13 + 5);
    assert_false(read.good);
    assert_string_equal(read.message, expected);
    arena_free(&read.arena);
    make_binary(&bytes, false);
    bytes.at[body + 48 + 13] = 100;
    read = read_bytes(bytes.at, bytes.size);
    snprintf(expected, sizeof expected,
             "byte %zu: the list `vertex_indices` is to have 100 items, but the file ends before",
             body + 48 + 13);
    assert_false(read.good);
    assert_string_equal(read.message, expected);
    make_binary(&bytes, false);
    put_text(&bytes, "tail");
    read = read_bytes(bytes.at, bytes.size);
    snprintf(expected, sizeof expected,
             "byte %zu: the file goes on for 4 bytes behind what its header announces",
             bytes.size - 4);
    assert_false(read.good);
    assert_string_equal(read.message, expected);
    arena_free(&read.arena);
}

// Counts that would need more memory than there is must be refused before any is taken.
static void lying_counts_take_no_memory(void **state)
{
    (void)state;
    static const char *const counts[] = {"4000000000", "18446744073709551615", "1000000000000000",
                                         "768614336404564651", "4294967295"};
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    for (size_t i = 0; i < TEST_COUNT(counts) * TEST_COUNT(formats); ++i) {
        char text[512];
        const char *count = counts[i / 3], *format = formats[i % 3];
        for (int which = 0; which < 3; ++which) {
            snprintf(
                text, sizeof text,
                "ply\nformat %s 1.0\nelement vertex %s\nproperty %sfloat x\nproperty float y\n"
                "property float z\n%s\nelement face %s\nproperty list uint int vertex_indices\n"
                "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
                format, which == 0 ? count : "3", "",
                which == 2 ? "property list uint double extra" : "", which == 1 ? count : "1");
            Arena arena = {0};
            Mesh mesh = {0};
            char message[256] = "";
            uint64_t before = mem_allocation_count();
            assert_false(ply_read(&arena, text, strlen(text), &mesh, message, sizeof message));
            assert_true(strncmp(message, "line ", 5) == 0 || strncmp(message, "byte ", 5) == 0);
            if (which == 0) {
                assert_int_equal(mem_allocation_count() - before, 1); // the reader itself
                assert_int_equal(arena.reserved, 0);
            }
            assert_true(arena.reserved < 1 << 20);
            arena_free(&arena);
        }
    }
}

// Cut off at every byte: never a crash, and but for the cuts that leave a whole file, a message
// with a line or a byte.
static void cut_off_anywhere(void **state)
{
    (void)state;
    Bytes bytes;
    for (int format = 0; format < 4; ++format) {
        if (format == 0) {
            make_ascii(&bytes);
        } else if (format == 3) {
            bytes.size = 0;
            put_text(&bytes, everything);
        } else {
            make_binary(&bytes, format == 2);
        }
        bool ascii = format == 0 || format == 3;
        for (size_t size = 0; size < bytes.size; ++size) {
            Read read = read_bytes(bytes.at, size);
            // Without its last line's end, or with a shorter last number, a text file is whole.
            assert_true(!read.good || (ascii && size + 4 >= bytes.size));
            if (!read.good) {
                unsigned long long place;
                assert_int_equal(
                    sscanf(read.message,
                           format == 1 || format == 2 ? "%*4s %llu:" : "line %llu:", &place),
                    1);
                assert_true(place <= bytes.size);
            }
            arena_free(&read.arena);
        }
    }
}

// Every byte set to several values: success or a message, never a crash.
static void any_byte_wrong(void **state)
{
    (void)state;
    static const unsigned char wrong[] = {0,   1,   '\n', '\r', ' ',  '-',
                                          '0', '9', 'e',  0x7f, 0x80, 0xff};
    Bytes bytes;
    for (int format = 0; format < 4; ++format) {
        if (format == 0) {
            make_ascii(&bytes);
        } else if (format == 3) {
            bytes.size = 0;
            put_text(&bytes, everything);
        } else {
            make_binary(&bytes, format == 2);
        }
        for (size_t i = 0; i < bytes.size; ++i) {
            char kept = bytes.at[i];
            for (size_t w = 0; w < TEST_COUNT(wrong); ++w) {
                bytes.at[i] = (char)wrong[w];
                Read read = read_bytes(bytes.at, bytes.size);
                assert_true(read.good || strlen(read.message) > 8);
                for (size_t t = 0; read.good && t < 3 * (size_t)read.mesh.triangle_count; ++t) {
                    assert_true(read.mesh.triangles[t] < read.mesh.vertex_count);
                }
                arena_free(&read.arena);
            }
            bytes.at[i] = kept;
        }
    }
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    bool done = false;
    unsigned failures = 0;
    for (; !done && failures < 1000; failures += !done) {
        mem_fail_after(failures);
        Arena arena = {0};
        Mesh mesh;
        char message[256];
        done = ply_read(&arena, everything, strlen(everything), &mesh, message, sizeof message);
        mem_fail_after(UINT64_MAX);
        assert_true(done || strstr(message, "not enough memory"));
        arena_free(&arena);
    }
    assert_true(done && failures >= 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_three_formats),
        cmocka_unit_test(line_ends),
        cmocka_unit_test(binary_after_any_line_end),
        cmocka_unit_test(properties_in_any_order),
        cmocka_unit_test(floating_colors_are_linear),
        cmocka_unit_test(polygons_are_cut),
        cmocka_unit_test(triangle_strips),
        cmocka_unit_test(bad_triangles_are_counted),
        cmocka_unit_test(far_away),
        cmocka_unit_test(damage_is_named),
        cmocka_unit_test(damage_in_binary_is_named),
        cmocka_unit_test(lying_counts_take_no_memory),
        cmocka_unit_test(cut_off_anywhere),
        cmocka_unit_test(any_byte_wrong),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
