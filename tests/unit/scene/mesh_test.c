#include "../test_support.h"
#include "scene/mesh.h"
#include "scene/mesh_build.h"
#include "scene/mesh_cache.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// Assimp 5.2's reader of glTF loses 2 kB with every file that it gives up on.
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:libassimp";
}

static const Schema no_kinds = {NULL, 0};

// A folder of its own with a scene that may read there.
typedef struct Bench {
    char folder[64];
    Sandbox sandbox;
    Scene scene;
    Arena arena;
    DiagSink sink;
} Bench;

static void bench_begin(Bench *bench)
{
    strcpy(bench->folder, "/tmp/scn_mesh_XXXXXX");
    assert_non_null(mkdtemp(bench->folder));
    bench->arena = (Arena){0};
    sandbox_init(&bench->sandbox);
    assert_int_equal(sandbox_allow(&bench->sandbox, bench->folder), IO_OK);
    diag_sink_init(&bench->sink, &bench->arena);
    assert_true(scene_init(&bench->scene, &no_kinds, &bench->sandbox));
}

static void bench_end(Bench *bench)
{
    scene_free(&bench->scene);
    sandbox_free(&bench->sandbox);
    diag_sink_free(&bench->sink);
    arena_free(&bench->arena);
    char path[512];
    DIR *folder = opendir(bench->folder);
    for (struct dirent *entry; folder && (entry = readdir(folder));) {
        snprintf(path, sizeof path, "%s/%.255s", bench->folder, entry->d_name);
        unlink(path);
    }
    closedir(folder);
    rmdir(bench->folder);
}

static void write_file(const Bench *bench, const char *name, const void *bytes, size_t size)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", bench->folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

static uint32_t load(Bench *bench, const char *name, bool smooth)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", bench->folder, name);
    return mesh_load(&bench->scene, path, smooth, (MeshReport){&bench->sink, {1, 2, 3}});
}

static const Mesh *load_good(Bench *bench, const char *name, bool smooth)
{
    uint32_t id = load(bench, name, smooth);
    if (id == NONE_ID) {
        fail_msg("%s: %s", name, bench->sink.count ? bench->sink.items[0].message : "?");
    }
    return &bench->scene.meshes.items[id];
}

static Vec3 corner(const Mesh *mesh, size_t i)
{
    const float *p = mesh->positions + 3 * (size_t)mesh->triangles[i];
    return add(mesh->origin, vec3((double)p[0], (double)p[1], (double)p[2]));
}

static Vec3 face_normal(const Mesh *mesh, size_t t)
{
    return cross(sub(corner(mesh, 3 * t + 1), corner(mesh, 3 * t)),
                 sub(corner(mesh, 3 * t + 2), corner(mesh, 3 * t)));
}

// --- One cube in several formats -----------------------------------------------------------------

static const int cube_corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                       {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
// Counter-clockwise from outside.
static const int cube_faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                     {2, 3, 7, 6}, {1, 2, 6, 5}, {0, 4, 7, 3}};

static void write_ply_cube(const Bench *bench)
{
    char text[2048] =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
        "property float z\nelement face 6\nproperty list uchar int vertex_indices\n"
        "end_header\n";
    char *at = text + strlen(text);
    for (int i = 0; i < 8; ++i) {
        at += sprintf(at, "%d %d %d\n", cube_corners[i][0], cube_corners[i][1], cube_corners[i][2]);
    }
    for (int f = 0; f < 6; ++f) {
        const int *c = cube_faces[f];
        at += sprintf(at, "4 %d %d %d %d\n", c[0], c[1], c[2], c[3]);
    }
    write_file(bench, "cube.ply", text, strlen(text));
}

static void write_obj_cube(const Bench *bench)
{
    char text[2048] = "# a cube\nmtllib cube.mtl\no cube\n";
    char *at = text + strlen(text);
    for (int i = 0; i < 8; ++i) {
        at +=
            sprintf(at, "v %d %d %d\n", cube_corners[i][0], cube_corners[i][1], cube_corners[i][2]);
    }
    at += sprintf(at, "usemtl red\n");
    for (int f = 0; f < 6; ++f) {
        const int *c = cube_faces[f];
        at += sprintf(at, "f %d %d %d %d\n", c[0] + 1, c[1] + 1, c[2] + 1, c[3] + 1);
    }
    write_file(bench, "cube.obj", text, strlen(text));
    static const char material[] = "newmtl red\nKd 1 0 0\n";
    write_file(bench, "cube.mtl", material, strlen(material));
}

static void write_stl_cube(const Bench *bench)
{
    char text[8192] = "solid cube\n";
    char *at = text + strlen(text);
    for (int t = 0; t < 12; ++t) {
        static const int fan[2][3] = {{0, 1, 2}, {0, 2, 3}};
        at += sprintf(at, "facet normal 0 0 0\nouter loop\n");
        for (int i = 0; i < 3; ++i) {
            const int *c = cube_corners[cube_faces[t / 2][fan[t % 2][i]]];
            at += sprintf(at, "vertex %d %d %d\n", c[0], c[1], c[2]);
        }
        at += sprintf(at, "endloop\nendfacet\n");
    }
    sprintf(at, "endsolid cube\n");
    write_file(bench, "cube.stl", text, strlen(text));
}

static void write_off_cube(const Bench *bench)
{
    char text[2048] = "OFF\n8 6 0\n";
    char *at = text + strlen(text);
    for (int i = 0; i < 8; ++i) {
        at += sprintf(at, "%d %d %d\n", cube_corners[i][0], cube_corners[i][1], cube_corners[i][2]);
    }
    for (int f = 0; f < 6; ++f) {
        const int *c = cube_faces[f];
        at += sprintf(at, "4 %d %d %d %d\n", c[0], c[1], c[2], c[3]);
    }
    write_file(bench, "cube.off", text, strlen(text));
}

// glTF, its bytes in cube.bin; a node moves, turns and mirrors half a cube back into a cube's
// place.
static void write_gltf_cube(const Bench *bench)
{
    float positions[8][3];
    uint16_t indices[36];
    for (int i = 0; i < 24; ++i) {
        positions[i / 3][i % 3] = (float)cube_corners[i / 3][i % 3] * (i % 3 == 0 ? -2.0f : 1.0f);
    }
    for (int t = 0; t < 12; ++t) {
        // Wound the other way round, since the mirroring turns it.
        static const int fan[2][3] = {{0, 2, 1}, {0, 3, 2}};
        for (int i = 0; i < 3; ++i) {
            indices[3 * t + i] = (uint16_t)cube_faces[t / 2][fan[t % 2][i]];
        }
    }
    char bytes[sizeof positions + sizeof indices];
    memcpy(bytes, positions, sizeof positions);
    memcpy(bytes + sizeof positions, indices, sizeof indices);
    write_file(bench, "cube.bin", bytes, sizeof bytes);
    static const char json[] =
        "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0]}],\n"
        "\"nodes\": [{\"children\": [1], \"translation\": [0, 0, 5]},\n"
        "{\"mesh\": 0, \"scale\": [-0.5, 1, 1], \"translation\": [0, 0, -5]}],\n"
        "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"indices\": 1}]}],\n"
        "\"buffers\": [{\"uri\": \"cube.bin\", \"byteLength\": 168}],\n"
        "\"bufferViews\": [{\"buffer\": 0, \"byteOffset\": 0, \"byteLength\": 96, \"target\": "
        "34962},\n"
        "{\"buffer\": 0, \"byteOffset\": 96, \"byteLength\": 72, \"target\": 34963}],\n"
        "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 8, \"type\": "
        "\"VEC3\",\n"
        "\"min\": [-2, 0, 0], \"max\": [0, 1, 1]},\n"
        "{\"bufferView\": 1, \"componentType\": 5123, \"count\": 36, \"type\": \"SCALAR\"}]}\n";
    write_file(bench, "cube.gltf", json, strlen(json));
}

static int compare_numbers(const void *a, const void *b)
{
    return memcmp(a, b, 9 * sizeof(int));
}

// The triangles as whole numbers, each beginning with its smallest corner, sorted.
static void collect_triangles(const Mesh *mesh, int out[12][9])
{
    assert_int_equal(mesh->triangle_count, 12);
    for (size_t t = 0; t < 12; ++t) {
        int p[3][3], first = 0;
        for (size_t i = 0; i < 9; ++i) {
            double value = vec3_get(corner(mesh, 3 * t + i / 3), (int)(i % 3));
            assert_true(fabs(value - round(value)) < 1e-6);
            p[i / 3][i % 3] = (int)lround(value);
        }
        for (int i = 1; i < 3; ++i) {
            first = memcmp(p[i], p[first], sizeof p[i]) < 0 ? i : first;
        }
        for (int i = 0; i < 3; ++i) {
            memcpy(out[t] + 3 * i, p[(first + i) % 3], sizeof p[0]);
        }
    }
    qsort(out, 12, sizeof out[0], compare_numbers);
}

static void one_cube_through_every_format(void **state)
{
    (void)state;
    Bench bench;
    bench_begin(&bench);
    write_ply_cube(&bench);
    write_obj_cube(&bench);
    write_stl_cube(&bench);
    write_off_cube(&bench);
    write_gltf_cube(&bench);
    int expected[12][9], got[12][9];
    collect_triangles(load_good(&bench, "cube.ply", false), expected);
    static const char *const names[] = {"cube.obj", "cube.stl", "cube.off", "cube.gltf"};
    for (size_t i = 0; i < TEST_COUNT(names); ++i) {
        for (int smooth = 0; smooth < 2; ++smooth) {
            const Mesh *mesh = load_good(&bench, names[i], smooth);
            collect_triangles(mesh, got);
            assert_memory_equal(got, expected, sizeof got);
            // Equal vertices are one; with normals, the creases part them into 24.
            assert_int_equal(mesh->vertex_count, smooth ? 24 : 8);
            assert_true((mesh->normals != NULL) == (smooth != 0));
        }
    }
    assert_int_equal(bench.sink.count, 0);
    bench_end(&bench);
}

static void the_same_file_is_read_once(void **state)
{
    (void)state;
    Bench bench;
    bench_begin(&bench);
    write_ply_cube(&bench);
    uint32_t a = load(&bench, "cube.ply", true), b = load(&bench, "cube.ply", false);
    assert_int_equal(load(&bench, "cube.ply", true), a);
    assert_int_equal(load(&bench, "cube.ply", false), b);
    assert_int_not_equal(a, b);
    assert_int_equal(bench.scene.meshes.count, 2);
    bench_end(&bench);
}

// Does the cache know the mesh of this file as it is now?
static bool is_known(Bench *bench, const char *name, bool smooth)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", bench->folder, name);
    FileBytes bytes;
    assert_int_equal(sandbox_read(&bench->sandbox, path, &bytes), IO_OK);
    Arena arena = {0};
    Mesh mesh;
    bool known = mesh_cache_find(bench->scene.mesh_cache, &bench->sandbox,
                                 (MeshSource){path, &bytes}, smooth, &arena, &mesh);
    file_bytes_free(&bytes);
    arena_free(&arena);
    return known;
}

static void meshes_are_kept_between_scenes(void **state)
{
    (void)state;
    Bench bench;
    bench_begin(&bench);
    write_ply_cube(&bench);
    write_obj_cube(&bench);
    write_gltf_cube(&bench);
    MeshCache *cache = mesh_cache_new();
    bench.scene.mesh_cache = cache;
    static const char *const names[] = {"cube.ply", "cube.obj", "cube.gltf"};
    int expected[12][9], got[12][9];
    for (size_t i = 0; i < TEST_COUNT(names); ++i) {
        assert_false(is_known(&bench, names[i], true));
        collect_triangles(load_good(&bench, names[i], true), expected);
        assert_true(is_known(&bench, names[i], true));
        assert_false(is_known(&bench, names[i], false));
        mesh_cache_turn(cache);
        assert_true(scene_clear(&bench.scene));
        const Mesh *again = load_good(&bench, names[i], true);
        collect_triangles(again, got);
        assert_memory_equal(got, expected, sizeof got);
        assert_int_equal(again->vertex_count, 24);
        assert_non_null(again->normals);
    }
    // The file itself is as it was, but not the one that it refers to.
    static const char other[168] = {0};
    write_file(&bench, "cube.bin", other, sizeof other);
    assert_false(is_known(&bench, "cube.gltf", true));
    assert_true(is_known(&bench, "cube.obj", true));
    write_file(&bench, "cube.obj", "v 0 0 0\n", 8);
    assert_false(is_known(&bench, "cube.obj", true));
    // What was asked for stays for one turn more; the first was not, for two turns.
    assert_false(is_known(&bench, "cube.ply", true));
    load_good(&bench, "cube.ply", true);
    assert_true(is_known(&bench, "cube.ply", true));
    mesh_cache_turn(cache);
    assert_true(is_known(&bench, "cube.ply", true));
    mesh_cache_turn(cache);
    mesh_cache_turn(cache);
    assert_false(is_known(&bench, "cube.ply", true));
    mesh_cache_free(cache);
    bench.scene.mesh_cache = NULL;
    collect_triangles(load_good(&bench, "cube.ply", true), got); // a copy: the cache is gone
    bench_end(&bench);
}

static void a_kept_mesh_is_warned_of_again(void **state)
{
    (void)state;
    Bench bench;
    bench_begin(&bench);
    static const char flat[] = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                               "property float y\nproperty float z\nelement face 2\n"
                               "property list uchar int vertex_indices\nend_header\n"
                               "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 0 1\n";
    write_file(&bench, "flat.ply", flat, strlen(flat));
    bench.scene.mesh_cache = mesh_cache_new();
    char path[256];
    snprintf(path, sizeof path, "%s/flat.ply", bench.folder);
    for (uint32_t i = 0; i < 2; ++i) { // at places of their own: what is told twice is told once
        MeshReport report = {&bench.sink, {1, 2 + i, 3 + i}};
        assert_int_not_equal(mesh_load(&bench.scene, path, true, report), NONE_ID);
        assert_int_equal(bench.sink.warnings, i + 1);
        assert_int_equal(bench.sink.items[i].code, W0850);
        assert_string_equal(bench.sink.items[i].message, bench.sink.items[0].message);
        assert_true(scene_clear(&bench.scene));
    }
    mesh_cache_free(bench.scene.mesh_cache);
    bench_end(&bench);
}

// --- Normals
// ---------------------------------------------------------------------------------------

// Each corner of a cube has three vertices with the three faces' normals.
static void cubes_keep_their_edges(void **state)
{
    (void)state;
    Bench bench;
    bench_begin(&bench);
    write_ply_cube(&bench);
    const Mesh *mesh = load_good(&bench, "cube.ply", true);
    assert_int_equal(mesh->vertex_count, 24);
    for (size_t i = 0; i < 36; ++i) {
        const float *n = mesh->normals + 3 * (size_t)mesh->triangles[i];
        Vec3 face = normalize(face_normal(mesh, i / 3));
        assert_true(length(sub(vec3((double)n[0], (double)n[1], (double)n[2]), face)) < 1e-6);
    }
    bench_end(&bench);
}

// A ball's normals point away from its middle; its poles and seams get no creases.
static void balls_are_smooth(void **state)
{
    (void)state;
    enum { ACROSS = 24, DOWN = 12 };
    Bench bench;
    bench_begin(&bench);
    Vec3 points[(DOWN + 1) * (ACROSS + 1)];
    uint32_t indices[DOWN * ACROSS * 4], sizes[DOWN * ACROSS];
    for (int j = 0; j <= DOWN; ++j) {
        for (int i = 0; i <= ACROSS; ++i) {
            double theta = PI * j / DOWN, phi = 2 * PI * (i % ACROSS) / ACROSS;
            double ring = j % DOWN ? sin(theta) : 0;
            points[j * (ACROSS + 1) + i] =
                vec3(50 + ring * cos(phi), cos(theta), 7 - ring * sin(phi));
        }
    }
    for (uint32_t j = 0; j < DOWN; ++j) {
        for (uint32_t i = 0; i < ACROSS; ++i) {
            uint32_t at = j * (ACROSS + 1) + i, face = j * ACROSS + i;
            const uint32_t quad[] = {at, at + ACROSS + 1, at + ACROSS + 2, at + 1};
            memcpy(indices + 4 * face, quad, sizeof quad);
            sizes[face] = 4;
        }
    }
    uint32_t id =
        mesh_from_lists(&bench.scene, (Vec3List){points, (DOWN + 1) * (ACROSS + 1)},
                        (FaceList){indices, sizes, DOWN * ACROSS * 4, DOWN * ACROSS}, (Vec3List){0},
                        (Vec2List){0}, (RgbList){0}, true, (MeshReport){&bench.sink, {0}});
    assert_int_not_equal(id, NONE_ID);
    const Mesh *mesh = &bench.scene.meshes.items[id];
    assert_int_equal(mesh->vertex_count, (DOWN + 1) * (ACROSS + 1));
    assert_int_equal(mesh->degenerate, 2 * ACROSS); // at the poles
    assert_int_equal(mesh->triangle_count, 2 * ACROSS * (DOWN - 1));
    assert_int_equal(bench.sink.warnings, 1);
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; ++i) {
        Vec3 outwards = normalize(sub(corner(mesh, i), vec3(50, 0, 7)));
        const float *n = mesh->normals + 3 * (size_t)mesh->triangles[i];
        assert_true(dot(outwards, vec3((double)n[0], (double)n[1], (double)n[2])) > 0.995);
    }
    bench_end(&bench);
}

// Two triangles hinged at an edge: one normal there below the crease angle, two above it.
static void creases_begin_at_their_angle(void **state)
{
    (void)state;
    for (int degrees = 0; degrees < 180; degrees += 7) {
        Bench bench;
        bench_begin(&bench);
        double angle = degrees * PI / 180;
        Vec3 points[] = {{0, 0, 0}, {0, 1, 0}, {1, 0.5, 0}, {-cos(angle), 0.5, -sin(angle)}};
        uint32_t indices[] = {0, 2, 1, 0, 1, 3}, sizes[] = {3, 3};
        uint32_t id = mesh_from_lists(
            &bench.scene, (Vec3List){points, 4}, (FaceList){indices, sizes, 6, 2}, (Vec3List){0},
            (Vec2List){0}, (RgbList){0}, true, (MeshReport){&bench.sink, {0}});
        assert_int_not_equal(id, NONE_ID);
        assert_int_equal(bench.scene.meshes.items[id].vertex_count,
                         degrees < MESH_CREASE_ANGLE ? 4 : 6);
        bench_end(&bench);
    }
}

// A file's own normals are kept with smooth, and dropped without; bad ones are mended and reported.
static void normals_of_the_file(void **state)
{
    (void)state;
    static const char text[] = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                               "property float y\nproperty float z\nproperty float nx\n"
                               "property float ny\nproperty float nz\nproperty float u\n"
                               "property float v\nelement face 1\n"
                               "property list uchar int vertex_indices\nend_header\n"
                               "0 0 0 0 0 3 0 0\n1 0 0 1 0 0 1 0\n1 1 0 0 0 0 nan 1\n"
                               "0 1 0 nan 0 0 0 1\n4 0 1 2 3\n";
    Bench bench;
    bench_begin(&bench);
    write_file(&bench, "square.ply", text, strlen(text));
    const Mesh *mesh = load_good(&bench, "square.ply", true);
    static const float normals[] = {0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 1};
    static const float uvs[] = {0, 0, 1, 0, 0, 0, 0, 1};
    assert_memory_equal(mesh->normals, normals, sizeof normals);
    assert_memory_equal(mesh->uvs, uvs, sizeof uvs);
    assert_int_equal(bench.sink.warnings, 1);
    assert_int_equal(bench.sink.items[0].code, W0851);
    assert_string_equal(bench.sink.items[0].message,
                        "`square.ply`: 3 normals, texture coordinates or colors can't be used as "
                        "they are and were replaced");
    assert_null(load_good(&bench, "square.ply", false)->normals);
    bench_end(&bench);
}

// --- Diagnostics
// -----------------------------------------------------------------------------------

static void expect_error(Bench *bench, const char *name, DiagCode code, const char *message)
{
    diag_sink_free(&bench->sink);
    diag_sink_init(&bench->sink, &bench->arena);
    assert_int_equal(load(bench, name, true), NONE_ID);
    assert_int_equal(bench->sink.errors, 1);
    assert_int_equal(bench->sink.items[0].code, code);
    if (message) {
        assert_string_equal(bench->sink.items[0].message, message);
    }
    assert_int_equal(bench->sink.items[0].at.begin, 2);
    assert_int_equal(bench->scene.meshes.count, 0);
}

static void what_is_wrong_is_said(void **state)
{
    (void)state;
    Bench bench;
    bench_begin(&bench);
    expect_error(&bench, "none.ply", E0850, NULL);
    expect_error(&bench, "none.obj", E0850, NULL);
    expect_error(&bench, "../../etc/passwd.ply", E0850, NULL);
    write_file(&bench, "a.ply", "ply\n", 4);
    expect_error(&bench, "a.ply", E0851,
                 "`a.ply` is damaged: line 1: the file ends within its header");
    write_file(&bench, "b.blend", "BLENDER", 7);
    expect_error(&bench, "b.blend", E0857, "`b.blend` is of no type that is known");
    write_file(&bench, "c.obj", "", 0);
    expect_error(&bench, "c.obj", E0851, NULL);
    write_file(&bench, "d.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n", 23);
    expect_error(&bench, "d.obj", E0852, "`d.obj` has no triangle");
    write_file(&bench, "e.gltf", "{\"asset\": {\"version\": \"2.0\"}", 29);
    expect_error(&bench, "e.gltf", E0851, NULL);
    // Files of other kinds, for which assimp has readers, by names of glTF's.
    static const char opengex[] = "Metric (key = \"distance\") {float {1}}";
    write_file(&bench, "h.glb", opengex, strlen(opengex));
    expect_error(&bench, "h.glb", E0851,
                 "`h.glb` is damaged: a glTF file begins with `{`, a binary one with `glTF`");
    write_file(&bench, "i.gltf", "\n", 1);
    expect_error(&bench, "i.gltf", E0851,
                 "`i.gltf` is damaged: a glTF file begins with `{`, a binary one with `glTF`");
    static const char words[] = "{} Metric VertexArray (attrib = \"position\")";
    write_file(&bench, "j.gltf", words, strlen(words));
    expect_error(&bench, "j.gltf", E0851, NULL);
    assert_non_null(strstr(bench.sink.items[0].message, "No suitable reader"));
    write_file(&bench, "f.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", 49);
    expect_error(&bench, "f.stl", E0851, NULL);
    static const char points[] = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                 "property float y\nproperty float z\nend_header\n0 0 0\n";
    write_file(&bench, "g.ply", points, strlen(points));
    expect_error(&bench, "g.ply", E0852, "`g.ply` has no triangle");
    bench_end(&bench);
}

// glTF's bytes may not come from outside the folder, and the note says which file was wanted.
static void modules_stay_in_the_sandbox(void **state)
{
    (void)state;
    Bench bench;
    bench_begin(&bench);
    write_gltf_cube(&bench);
    char path[256], name[256];
    snprintf(path, sizeof path, "%s/cube.bin", bench.folder);
    snprintf(name, sizeof name, "%s.outside", bench.folder);
    assert_int_equal(rename(path, name), 0);
    assert_int_equal(symlink(name, path), 0);
    assert_int_equal(load(&bench, "cube.gltf", true), NONE_ID);
    assert_int_equal(bench.sink.items[0].code, E0851);
    assert_non_null(bench.sink.items[0].notes);
    assert_non_null(strstr(bench.sink.items[0].notes->text, "cube.bin"));
    unlink(name);
    bench_end(&bench);
}

// Each format's file cut off at many places: a mesh, or a diagnostic that says why not.
static void cut_off_files(void **state)
{
    (void)state;
    static const char *const names[] = {"cube.obj", "cube.stl", "cube.off", "cube.gltf"};
    for (size_t n = 0; n < TEST_COUNT(names); ++n) {
        Bench bench;
        bench_begin(&bench);
        write_obj_cube(&bench);
        write_stl_cube(&bench);
        write_off_cube(&bench);
        write_gltf_cube(&bench);
        char path[256], bytes[8192];
        snprintf(path, sizeof path, "%s/%s", bench.folder, names[n]);
        FILE *file = fopen(path, "rb");
        assert_non_null(file);
        size_t size = fread(bytes, 1, sizeof bytes, file);
        fclose(file);
        for (size_t cut = 0; cut < size; cut += 13) {
            char name[64];
            snprintf(name, sizeof name, "cut%zu_%s", cut, names[n]);
            write_file(&bench, name, bytes, cut);
            diag_sink_free(&bench.sink);
            diag_sink_init(&bench.sink, &bench.arena);
            assert_true((load(&bench, name, false) == NONE_ID) == (bench.sink.errors == 1));
        }
        bench_end(&bench);
    }
}

// --- Lists
// -----------------------------------------------------------------------------------------

static Vec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

static uint32_t from_lists(Bench *bench, uint32_t vertices, FaceList faces, uint32_t normals,
                           uint32_t uvs, uint32_t colors)
{
    static Vec2 some_uvs[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static Rgb some_colors[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 2, 2}};
    static Vec3 some_normals[] = {{0, 0, 2}, {0, 0, 1}, {0, 0, 1}, {0, 3, 0}};
    return mesh_from_lists(&bench->scene, (Vec3List){corners, vertices}, faces,
                           (Vec3List){some_normals, normals}, (Vec2List){some_uvs, uvs},
                           (RgbList){some_colors, colors}, true,
                           (MeshReport){&bench->sink, {1, 5, 9}});
}

static void lists_make_a_mesh(void **state)
{
    (void)state;
    Bench bench;
    bench_begin(&bench);
    uint32_t indices[] = {0, 1, 2, 3, 2, 1, 0}, sizes[] = {4, 3};
    uint32_t id = from_lists(&bench, 4, (FaceList){indices, sizes, 7, 2}, 4, 4, 4);
    assert_int_equal(id, 0);
    assert_int_equal(bench.sink.count, 0);
    const Mesh *mesh = &bench.scene.meshes.items[0];
    assert_int_equal(mesh->triangle_count, 3);
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3, 2, 1, 0};
    assert_memory_equal(mesh->triangles, triangles, sizeof triangles);
    assert_true(mesh->normals[2] == 1.0f && mesh->normals[10] == 1.0f);
    assert_true(mesh->uvs[5] == 1.0f && mesh->colors[11] == 2.0f);
    bench_end(&bench);
}

static void lists_are_checked(void **state)
{
    (void)state;
    uint32_t good[] = {0, 1, 2}, beyond[] = {0, 1, 2, 1, 2, 4}, few[] = {0, 1, 2, 3, 1};
    uint32_t line[] = {0, 1, 1}, three[] = {3, 3}, two[] = {3, 2};
    FaceList one = {good, three, 3, 1};
    static const struct {
        DiagCode code;
        const char *message;
    } expected[] = {
        {E0853, "`normals` has 3 entries, but `vertices` has 4"},
        {E0853, "`uvs` has 1 entry, but `vertices` has 4"},
        {E0853, "`colors` has 2 entries, but `vertices` has 4"},
        {E0854, "face 1 refers to vertex 4, but there are 4 vertices, counted from 0"},
        {E0855, "face 1 has 2 corners; a face has three or more"},
        {E0852, "the mesh has no triangle"},
        {E0852, "the mesh has no triangle"},
        {E0854, "face 0 refers to vertex 0, but there are 0 vertices, counted from 0"},
    };
    for (size_t i = 0; i < TEST_COUNT(expected); ++i) {
        Bench bench;
        bench_begin(&bench);
        uint32_t id = i == 0   ? from_lists(&bench, 4, one, 3, 0, 0)
                      : i == 1 ? from_lists(&bench, 4, one, 0, 1, 0)
                      : i == 2 ? from_lists(&bench, 4, one, 0, 0, 2)
                      : i == 3 ? from_lists(&bench, 4, (FaceList){beyond, three, 6, 2}, 0, 0, 0)
                      : i == 4 ? from_lists(&bench, 4, (FaceList){few, two, 5, 2}, 0, 0, 0)
                      : i == 5 ? from_lists(&bench, 4, (FaceList){line, three, 3, 1}, 0, 0, 0)
                      : i == 6 ? from_lists(&bench, 4, (FaceList){0}, 0, 0, 0)
                               : from_lists(&bench, 0, one, 0, 0, 0);
        assert_int_equal(id, NONE_ID);
        assert_int_equal(bench.sink.errors, 1);
        assert_int_equal(bench.sink.items[0].code, expected[i].code);
        assert_string_equal(bench.sink.items[0].message, expected[i].message);
        assert_int_equal(bench.sink.items[0].at.begin, 5);
        bench_end(&bench);
    }
}

static void left_out_triangles_are_reported(void **state)
{
    (void)state;
    Bench bench;
    bench_begin(&bench);
    Vec3 points[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {(double)NAN, 0, 0}};
    uint32_t indices[] = {0, 1, 2, 0, 0, 1, 1, 2, 3}, sizes[] = {3, 3, 3};
    uint32_t id = mesh_from_lists(&bench.scene, (Vec3List){points, 4},
                                  (FaceList){indices, sizes, 9, 3}, (Vec3List){0}, (Vec2List){0},
                                  (RgbList){0}, false, (MeshReport){&bench.sink, {0}});
    assert_int_equal(id, 0);
    assert_int_equal(bench.sink.warnings, 1);
    assert_int_equal(bench.sink.items[0].code, W0850);
    assert_string_equal(bench.sink.items[0].message,
                        "the mesh: 1 triangle without area and 1 with a corner that isn't finite "
                        "were left out");
    bench_end(&bench);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    static const char *const names[] = {"cube.ply", "cube.obj"};
    for (size_t n = 0; n < TEST_COUNT(names); ++n) {
        Bench bench;
        bench_begin(&bench);
        write_ply_cube(&bench);
        write_obj_cube(&bench);
        uint32_t id = NONE_ID;
        unsigned failures = 0;
        for (; id == NONE_ID && failures < 1000; failures += id == NONE_ID) {
            mem_fail_after(failures);
            id = load(&bench, names[n], true);
            mem_fail_after(UINT64_MAX);
            assert_int_equal(bench.scene.meshes.count, id != NONE_ID);
        }
        assert_int_not_equal(id, NONE_ID);
        assert_true(failures >= 8);
        bench_end(&bench);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_cube_through_every_format),
        cmocka_unit_test(the_same_file_is_read_once),
        cmocka_unit_test(meshes_are_kept_between_scenes),
        cmocka_unit_test(a_kept_mesh_is_warned_of_again),
        cmocka_unit_test(cubes_keep_their_edges),
        cmocka_unit_test(balls_are_smooth),
        cmocka_unit_test(creases_begin_at_their_angle),
        cmocka_unit_test(normals_of_the_file),
        cmocka_unit_test(what_is_wrong_is_said),
        cmocka_unit_test(modules_stay_in_the_sandbox),
        cmocka_unit_test(cut_off_files),
        cmocka_unit_test(lists_make_a_mesh),
        cmocka_unit_test(lists_are_checked),
        cmocka_unit_test(left_out_triangles_are_reported),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
