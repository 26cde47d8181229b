// Meshes of all types: the first byte chooses the file's extension, the rest is the file, read as a
// scene would read it. Beside it lie a file of vertices for glTF's sake and a material file for
// OBJ's. Whatever the bytes: a sound mesh, or one diagnostic or more.
#include "base/mem.h"
#include "fuzz.h"
#include "render/render.h"
#include "scene/mesh.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

// Assimp leaks where one of its importers throws; ours is what is counted below.
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "detect_leaks=0";
}

static const char *const extensions[] = {"obj", "stl", "gltf", "glb"};
enum { EXTENSIONS = sizeof extensions / sizeof extensions[0] };

static void write_file(const char *folder, const char *name, const void *bytes, size_t size)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    fuzz_require(file && fwrite(bytes, 1, size, file) == size && fclose(file) == 0,
                 "the folder can be written");
}

static char folder[] = "/tmp/scn_mesh_fuzz_XXXXXX";

static void remove_folder(void)
{
    char path[256];
    for (int i = 0; i < EXTENSIONS; ++i) {
        snprintf(path, sizeof path, "%s/mesh.%s", folder, extensions[i]);
        unlink(path);
    }
    snprintf(path, sizeof path, "%s/mesh.bin", folder);
    unlink(path);
    snprintf(path, sizeof path, "%s/mesh.mtl", folder);
    unlink(path);
    rmdir(folder);
}

static Sandbox *sandbox(void)
{
    static Sandbox made;
    if (made.root_count == 0) {
        const float vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        static const char material[] = "newmtl a\nKd 1 0 0\nmap_Kd mesh.bin\n";
        sandbox_init(&made);
        made.max_file_bytes = 1 << 20;
        fuzz_require(mkdtemp(folder) && sandbox_allow(&made, folder) == IO_OK,
                     "a folder can be made");
        write_file(folder, "mesh.bin", vertices, sizeof vertices);
        write_file(folder, "mesh.mtl", material, sizeof material - 1);
        atexit(remove_folder);
    }
    return &made;
}

static void check(const Mesh *mesh)
{
    fuzz_require(mesh->vertex_count > 0 && mesh->triangle_count > 0, "a mesh isn't empty");
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; ++i) {
        fuzz_require(mesh->triangles[i] < mesh->vertex_count, "an index of a vertex");
        for (int c = 0; c < 3; ++c) {
            fuzz_require(isfinite(mesh->positions[3 * (size_t)mesh->triangles[i] + (size_t)c]),
                         "a finite position");
        }
    }
    for (size_t i = 0; mesh->normals && i < 3 * (size_t)mesh->vertex_count; ++i) {
        fuzz_require(isfinite(mesh->normals[i]), "a finite normal");
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    if (size == 0) {
        return 0;
    }
    Sandbox *files = sandbox();
    const uint64_t live = mem_live_count();
    Scene scene;
    Arena arena = {0};
    DiagSink sink;
    fuzz_require(scene_init(&scene, render_schema(), files), "beginning takes little memory");
    diag_sink_init(&sink, &arena);
    scene.arena.limit = (size_t)1 << 27;
    char name[32], path[256];
    snprintf(name, sizeof name, "mesh.%s", extensions[bytes[0] % EXTENSIONS]);
    write_file(folder, name, bytes + 1, size - 1);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    uint32_t id = mesh_load(&scene, path, bytes[0] & 0x80, (MeshReport){&sink, {0}});
    if (id == NONE_ID) {
        fuzz_require(sink.errors > 0 || sink.out_of_memory, "a failure is told");
        fuzz_require(sink.items[0].code != E0858, "the module is there");
    } else {
        check(&scene.meshes.items[id]);
    }
    diag_sink_free(&sink);
    scene_free(&scene);
    arena_free(&arena);
    fuzz_require(mem_live_count() == live, "all memory is given back");
    return 0;
}
