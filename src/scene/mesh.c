#include "scene/mesh.h"

#include "base/module.h"
#include "scene/mesh_build.h"
#include "scene/mesh_cache.h"
#include "scene/mesh_module.h"

#include <inttypes.h>
#include <string.h>
#include <strings.h>

// --- Reports
// ---------------------------------------------------------------------------------------

static uint32_t fails_for_memory(MeshReport report)
{
    diag_report(report.sink, E0001, report.at, "out of memory while making a mesh");
    return NONE_ID;
}

// A path as the author knows it: below the scene's folder.
static const char *shown_path(const Scene *scene, const char *path)
{
    const Sandbox *sandbox = scene->sandbox;
    for (int i = 0; sandbox && i < sandbox->root_count; ++i) {
        size_t length = strlen(sandbox->roots[i].path);
        if (length && strncmp(path, sandbox->roots[i].path, length) == 0 && path[length] == '/') {
            return path + length + 1;
        }
    }
    return path;
}

// "2 triangles without area and 1 with a corner that isn't finite", for either or both.
static void describe_left_out(const Mesh *mesh, char *text, size_t size)
{
    char flat[64] = "";
    uint32_t wild = mesh->not_finite;
    if (mesh->degenerate) {
        snprintf(flat, sizeof flat, "%" PRIu32 " triangle%s without area%s", mesh->degenerate,
                 mesh->degenerate == 1 ? "" : "s", wild ? " and " : "");
    }
    if (wild) {
        snprintf(text, size, "%s%" PRIu32 "%s with a corner that isn't finite", flat, wild,
                 mesh->degenerate ? ""
                 : wild == 1      ? " triangle"
                                  : " triangles");
    } else {
        snprintf(text, size, "%s", flat);
    }
}

static void say_what_was_changed(const Mesh *mesh, const char *what, MeshReport report)
{
    if (mesh->degenerate || mesh->not_finite) {
        char text[160];
        describe_left_out(mesh, text, sizeof text);
        diag_report(report.sink, W0850, report.at, "%s: %s %s left out", what, text,
                    mesh->degenerate + (uint64_t)mesh->not_finite == 1 ? "was" : "were");
    }
    if (mesh->mended) {
        diag_report(report.sink, W0851, report.at,
                    "%s: %" PRIu32 " normals, texture coordinates or colors can't be used as they "
                    "are and were replaced",
                    what, mesh->mended);
    }
}

// --- The end that all meshes come to
// -----------------------------------------------------------------

// Everything but adding it to the scene; `what` names the mesh in messages.
static bool finish(Mesh *mesh, Arena *arena, bool smooth, const char *what, MeshReport report)
{
    if (mesh->triangle_count == 0) {
        Diag *diag = diag_report(report.sink, E0852, report.at, "%s has no triangle", what);
        if (mesh->degenerate || mesh->not_finite) {
            char text[160];
            describe_left_out(mesh, text, sizeof text);
            diag_note(report.sink, diag, "%s can't be used", text);
        }
        return false;
    }
    mesh->smooth = smooth;
    mesh->normals = smooth ? mesh->normals : NULL;
    mesh->mended = mesh_mend_attributes(mesh);
    say_what_was_changed(mesh, what, report);
    if (smooth && !mesh->normals && !mesh_make_normals(mesh, arena)) {
        fails_for_memory(report);
        return false;
    }
    return true;
}

// --- Through assimp
// ----------------------------------------------------------------------------------

enum { MOST_FILES = 64 }; // that one mesh file may refer to

typedef struct ModuleContext {
    const Scene *scene;
    Arena arena;                 // of the module's output
    FileBytes files[MOST_FILES]; // [0] is the mesh's own
    const char *paths[MOST_FILES];
    int file_count;
    char refused[256]; // the last file that couldn't be read, and why
} ModuleContext;

// A file is asked for several times: to see whether it is there, to look at its first bytes, …
static const FileBytes *find_read(const ModuleContext *module, const char *path)
{
    for (int i = 0; i < module->file_count; ++i) {
        if (strcmp(module->paths[i], path) == 0) {
            return &module->files[i];
        }
    }
    return NULL;
}

static const FileBytes *read_new(ModuleContext *module, const char *path)
{
    if (module->file_count == MOST_FILES) {
        snprintf(module->refused, sizeof module->refused, "more than %d files", MOST_FILES);
        return NULL;
    }
    FileBytes *file = &module->files[module->file_count];
    const char *name = arena_copy_string(&module->arena, path, strlen(path));
    IoError error = name ? sandbox_read(module->scene->sandbox, path, file) : IO_NO_MEMORY;
    if (error != IO_OK) {
        snprintf(module->refused, sizeof module->refused, "`%.180s`: %s",
                 shown_path(module->scene, path), io_error_text(error));
        return NULL;
    }
    module->paths[module->file_count++] = name;
    return file;
}

static bool module_read(void *context, const char *path, const void **bytes, size_t *size)
{
    const FileBytes *file = find_read(context, path);
    file = file ? file : read_new(context, path);
    if (file) {
        *bytes = file->bytes;
        *size = file->size;
    }
    return file != NULL;
}

static void *module_alloc(void *context, size_t count, size_t size)
{
    ModuleContext *module = context;
    return arena_array(&module->arena, count, size);
}

static bool has_extension(const char *path, const char *extension)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot + 1, extension) == 0;
}

static bool is_known_to_module(const char *path)
{
    static const char *const known[] = {"obj", "stl", "gltf", "glb", "3ds", "off",
                                        "dae", "fbx", "lwo",  "x",   "3mf"};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        if (has_extension(path, known[i])) {
            return true;
        }
    }
    return false;
}

// Cuts the module's faces into triangles and joins equal vertices, in the context's arena.
static PolygonResult build(ModuleContext *module, const MeshModuleOutput *output, Mesh *mesh)
{
    MeshBuilder builder;
    uint64_t triangles = 0;
    const uint32_t *indices = output->indices;
    for (uint32_t f = 0; f < output->face_count; ++f) {
        triangles += output->sizes[f] > 2 ? output->sizes[f] - 2 : 0;
    }
    *mesh = (Mesh){.normals = output->normals, .uvs = output->uvs, .colors = output->colors};
    if (triangles > UINT32_MAX / 3 ||
        !mesh_set_positions(mesh, &module->arena, output->points, output->vertex_count) ||
        !mesh_builder_begin(&builder, &module->arena, *mesh, (size_t)triangles)) {
        return POLYGON_NO_MEMORY;
    }
    PolygonResult result = POLYGON_OK;
    for (uint32_t f = 0; f < output->face_count && result == POLYGON_OK; ++f) {
        // Files of triangles may hold points and lines as well, which are no damage.
        if (output->sizes[f] >= 3) {
            result = mesh_builder_add(&builder, indices, output->sizes[f]);
        }
        indices += output->sizes[f];
    }
    *mesh = builder.mesh;
    mesh_builder_free(&builder);
    return result != POLYGON_OK || mesh_join(mesh) ? result : POLYGON_NO_MEMORY;
}

// By custom the colors of these formats are sRGB-encoded; glTF's are linear by its specification.
static void decode_colors(Mesh *mesh, const char *path)
{
    bool linear = has_extension(path, "gltf") || has_extension(path, "glb");
    for (size_t i = 0; mesh->colors && !linear && i < 3 * (size_t)mesh->vertex_count; ++i) {
        mesh->colors[i] = mesh_srgb_to_linear(mesh->colors[i]);
    }
}

static bool build_and_finish(Scene *scene, ModuleContext *module, const MeshModuleOutput *output,
                             const char *path, bool smooth, MeshReport report, Mesh *mesh)
{
    const char *shown = shown_path(scene, path);
    char what[300];
    snprintf(what, sizeof what, "`%.280s`", shown);
    switch (build(module, output, mesh)) {
    case POLYGON_OK:
        decode_colors(mesh, path);
        if (!finish(mesh, &module->arena, smooth, what, report)) {
            return false;
        }
        if (!mesh_copy(mesh, &scene->arena)) {
            fails_for_memory(report);
            return false;
        }
        return true;
    case POLYGON_NO_MEMORY:
        fails_for_memory(report);
        return false;
    case POLYGON_TOO_LONG:
        break;
    }
    diag_report(report.sink, E0856, report.at,
                "%s has a face of more than %d corners that isn't convex", what,
                POLYGON_LONGEST_CONCAVE);
    return false;
}

static bool import(Scene *scene, ModuleContext *module, MeshModuleImport *run, const char *path,
                   bool smooth, MeshReport report, Mesh *mesh)
{
    char message[512] = "";
    MeshModuleHost host = {module, module_read, module_alloc};
    MeshModuleOutput output = {0};
    if (run(&host, path, &output, message, sizeof message)) {
        return build_and_finish(scene, module, &output, path, smooth, report, mesh);
    }
    Diag *diag = diag_report(report.sink, E0851, report.at, "`%s` can't be used: %s",
                             shown_path(scene, path), message);
    if (module->refused[0]) {
        diag_note(report.sink, diag, "it wanted %s", module->refused);
    }
    return false;
}

// What is named glTF and begins as nothing of that kind does: assimp would look for another of its
// readers.
static bool is_no_gltf(const char *path, const FileBytes *file)
{
    if (has_extension(path, "glb")) {
        return file->size < 4 || memcmp(file->bytes, "glTF", 4) != 0;
    }
    if (!has_extension(path, "gltf")) {
        return false;
    }
    size_t at = 0;
    while (at < file->size && memchr(" \t\r\n", file->bytes[at], 4)) {
        ++at;
    }
    return at == file->size || file->bytes[at] != '{';
}

// A binary glTF file whose first chunk is longer than the file; assimp would make room for it all.
static bool is_cut_glb(const FileBytes *file)
{
    const unsigned char *bytes = (const unsigned char *)file->bytes;
    if (file->size < 4 || memcmp(bytes, "glTF", 4) != 0) {
        return false;
    }
    if (file->size < 20) {
        return true;
    }
    uint32_t length = (uint32_t)bytes[12] | (uint32_t)bytes[13] << 8 | (uint32_t)bytes[14] << 16 |
                      (uint32_t)bytes[15] << 24;
    return length > file->size - 20;
}

static MeshModuleImport *find_import(const Scene *scene, const char *path, MeshReport report)
{
    char message[512];
    void *library = module_open("scn_assimp", message, sizeof message);
    MeshModuleImport *run = NULL;
    if (library) {
        // ISO C has no cast from an object's address to a function's; POSIX says this works.
        *(void **)&run = module_symbol(library, MESH_MODULE_SYMBOL);
        snprintf(message, sizeof message, "it has no `%s`", MESH_MODULE_SYMBOL);
    }
    if (!run) {
        Diag *diag = diag_report(report.sink, E0858, report.at,
                                 "`%s` needs the module scn_assimp.so", shown_path(scene, path));
        diag_note(report.sink, diag, "%s", message);
    }
    return run;
}

static void keep_for_later(const Scene *scene, const ModuleContext *module, const Mesh *mesh)
{
    MeshSource sources[MOST_FILES];
    for (int i = 0; i < module->file_count; ++i) {
        sources[i] = (MeshSource){module->paths[i], &module->files[i]};
    }
    mesh_cache_add(scene->mesh_cache, sources, (size_t)module->file_count, mesh);
}

// `file` stays the caller's.
static bool load_with_module(Scene *scene, const char *path, const FileBytes *file, bool smooth,
                             MeshReport report, Mesh *mesh)
{
    if (is_no_gltf(path, file)) {
        diag_report(report.sink, E0851, report.at,
                    "`%s` is damaged: a glTF file begins with `{`, a binary one with `glTF`",
                    shown_path(scene, path));
        return false;
    }
    if (is_cut_glb(file)) {
        diag_report(report.sink, E0851, report.at,
                    "`%s` is damaged: its first chunk is longer than the file",
                    shown_path(scene, path));
        return false;
    }
    MeshModuleImport *run = find_import(scene, path, report);
    if (!run) {
        return false;
    }
    ModuleContext *module = mem_alloc_zeroed(1, sizeof *module);
    if (!module) {
        fails_for_memory(report);
        return false;
    }
    module->scene = scene;
    module->files[0] = *file;
    module->paths[0] = path;
    module->file_count = 1;
    bool good = import(scene, module, run, path, smooth, report, mesh);
    if (good && !module->refused[0]) { // what was missing may come
        keep_for_later(scene, module, mesh);
    }
    for (int i = 1; i < module->file_count; ++i) {
        file_bytes_free(&module->files[i]);
    }
    arena_free(&module->arena);
    mem_free(module);
    return good;
}

// --- PLY
// ---------------------------------------------------------------------------------------------

static bool load_ply(Scene *scene, const char *path, const FileBytes *file, bool smooth,
                     MeshReport report, Mesh *mesh)
{
    char message[512], what[300];
    snprintf(what, sizeof what, "`%.280s`", shown_path(scene, path));
    if (!ply_read(&scene->arena, file->bytes, file->size, mesh, message, sizeof message)) {
        diag_report(report.sink, E0851, report.at, "%s is damaged: %s", what, message);
        return false;
    }
    const bool good = finish(mesh, &scene->arena, smooth, what, report);
    if (good) {
        mesh_cache_add(scene->mesh_cache, &(MeshSource){path, file}, 1, mesh);
    }
    return good;
}

static bool is_ply(const char *path, const FileBytes *file)
{
    return has_extension(path, "ply") || (file->size > 4 && memcmp(file->bytes, "ply", 3) == 0 &&
                                          (file->bytes[3] == '\n' || file->bytes[3] == '\r'));
}

// --- Files
// -------------------------------------------------------------------------------------------

static bool load(Scene *scene, const char *path, bool smooth, MeshReport report, Mesh *mesh)
{
    const char *shown = shown_path(scene, path);
    FileBytes file;
    IoError error = sandbox_read(scene->sandbox, path, &file);
    if (error != IO_OK) {
        diag_report(report.sink, E0850, report.at, "`%s` can't be read: %s", shown,
                    io_error_text(error));
        return false;
    }
    bool good = false;
    if (mesh_cache_find(scene->mesh_cache, scene->sandbox, (MeshSource){path, &file}, smooth,
                        &scene->arena, mesh)) {
        char what[300];
        snprintf(what, sizeof what, "`%.280s`", shown);
        say_what_was_changed(mesh, what, report);
        good = true;
    } else if (is_ply(path, &file)) {
        good = load_ply(scene, path, &file, smooth, report, mesh);
    } else if (is_known_to_module(path)) {
        good = load_with_module(scene, path, &file, smooth, report, mesh);
    } else {
        Diag *diag =
            diag_report(report.sink, E0857, report.at, "`%s` is of no type that is known", shown);
        diag_note(report.sink, diag,
                  "meshes are read from .ply, .obj, .stl, .gltf, .glb, .3ds, "
                  ".off, .dae, .fbx, .lwo, .x and .3mf");
    }
    file_bytes_free(&file);
    return good;
}

static uint32_t find_loaded(const Scene *scene, const char *path, bool smooth)
{
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        const Mesh *mesh = &scene->meshes.items[i];
        if (mesh->file && mesh->smooth == smooth && strcmp(mesh->file, path) == 0) {
            return (uint32_t)i;
        }
    }
    return NONE_ID;
}

// Adds the mesh, or gives back what the arena holds of it.
static uint32_t keep(Scene *scene, Mesh *mesh, bool good, ArenaMark mark, MeshReport report)
{
    uint32_t id = good ? scene_add_mesh(scene, *mesh) : NONE_ID;
    if (id == NONE_ID) {
        arena_rewind(&scene->arena, mark);
    }
    return good && id == NONE_ID ? fails_for_memory(report) : id;
}

uint32_t mesh_load(Scene *scene, const char *path, bool smooth, MeshReport report)
{
    uint32_t id = find_loaded(scene, path, smooth);
    if (id != NONE_ID) {
        return id;
    }
    // A jump out of here would lose the file and the working memory.
    jmp_buf *on_oom = scene->arena.on_oom;
    scene->arena.on_oom = NULL;
    ArenaMark mark = arena_mark(&scene->arena);
    Mesh mesh = {0};
    bool good = load(scene, path, smooth, report, &mesh);
    if (good) {
        mesh.file = arena_copy_string(&scene->arena, path, strlen(path));
    }
    id = keep(scene, &mesh, good, mark, report);
    scene->arena.on_oom = on_oom;
    return id;
}

// --- Lists
// -------------------------------------------------------------------------------------------

static bool check_length(const char *name, uint32_t count, uint32_t vertices, MeshReport report)
{
    if (count == 0 || count == vertices) {
        return true;
    }
    diag_report(report.sink, E0853, report.at,
                "`%s` has %" PRIu32 " entr%s, but `vertices` has %" PRIu32, name, count,
                count == 1 ? "y" : "ies", vertices);
    return false;
}

// Every wrong face is worth a message of its own, but not thousands of them.
static bool check_faces(const FaceList *faces, uint32_t vertices, MeshReport report)
{
    const uint32_t *index = faces->indices;
    uint32_t wrong = 0;
    for (uint32_t f = 0; f < faces->count && wrong == 0; ++f) {
        if (faces->sizes[f] < 3) {
            diag_report(report.sink, E0855, report.at,
                        "face %" PRIu32 " has %" PRIu32 " corner%s; a face has three or more", f,
                        faces->sizes[f], faces->sizes[f] == 1 ? "" : "s");
            ++wrong;
        }
        for (uint32_t i = 0; i < faces->sizes[f]; ++i, ++index) {
            if (*index >= vertices && wrong == 0) {
                diag_report(report.sink, E0854, report.at,
                            "face %" PRIu32 " refers to vertex %" PRIu32 ", but there are %" PRIu32
                            " vertices, counted from 0",
                            f, *index, vertices);
                ++wrong;
            }
        }
    }
    return wrong == 0;
}

static bool copy_lists(Scene *scene, Mesh *mesh, Vec3List normals, Vec2List uvs, RgbList colors)
{
    Arena *arena = &scene->arena;
    mesh->normals = normals.count ? arena_array(arena, normals.count, 3 * sizeof(float)) : NULL;
    mesh->uvs = uvs.count ? arena_array(arena, uvs.count, 2 * sizeof(float)) : NULL;
    mesh->colors = colors.count ? arena_array(arena, colors.count, 3 * sizeof(float)) : NULL;
    if ((normals.count && !mesh->normals) || (uvs.count && !mesh->uvs) ||
        (colors.count && !mesh->colors)) {
        return false;
    }
    for (size_t i = 0; i < normals.count; ++i) {
        mesh->normals[3 * i] = (float)normals.items[i].x;
        mesh->normals[3 * i + 1] = (float)normals.items[i].y;
        mesh->normals[3 * i + 2] = (float)normals.items[i].z;
    }
    for (size_t i = 0; i < uvs.count; ++i) {
        mesh->uvs[2 * i] = (float)uvs.items[i].x;
        mesh->uvs[2 * i + 1] = (float)uvs.items[i].y;
    }
    if (colors.count) {
        memcpy(mesh->colors, colors.items, colors.count * sizeof *colors.items);
    }
    return true;
}

static bool build_from_faces(Scene *scene, Mesh *mesh, const FaceList *faces, MeshReport report)
{
    uint64_t triangles = 0;
    for (uint32_t f = 0; f < faces->count; ++f) {
        triangles += faces->sizes[f] - 2;
    }
    MeshBuilder builder;
    if (triangles > UINT32_MAX / 3 ||
        !mesh_builder_begin(&builder, &scene->arena, *mesh, (size_t)triangles)) {
        fails_for_memory(report);
        return false;
    }
    PolygonResult result = POLYGON_OK;
    const uint32_t *indices = faces->indices;
    uint32_t f = 0;
    for (; f < faces->count && result == POLYGON_OK; ++f) {
        result = mesh_builder_add(&builder, indices, faces->sizes[f]);
        indices += faces->sizes[f];
    }
    *mesh = builder.mesh;
    mesh_builder_free(&builder);
    if (result == POLYGON_NO_MEMORY) {
        fails_for_memory(report);
    } else if (result == POLYGON_TOO_LONG) {
        diag_report(report.sink, E0856, report.at,
                    "face %" PRIu32 " has %" PRIu32 " corners and isn't convex; %d are the most",
                    f - 1, faces->sizes[f - 1], POLYGON_LONGEST_CONCAVE);
    }
    return result == POLYGON_OK;
}

static bool make_from_lists(Scene *scene, Vec3List vertices, FaceList faces, Vec3List normals,
                            Vec2List uvs, RgbList colors, bool smooth, MeshReport report,
                            Mesh *mesh)
{
    bool good = check_length("normals", normals.count, vertices.count, report);
    good = check_length("uvs", uvs.count, vertices.count, report) && good;
    good = check_length("colors", colors.count, vertices.count, report) && good;
    good = check_faces(&faces, vertices.count, report) && good;
    if (!good) {
        return false;
    }
    if (!mesh_set_positions(mesh, &scene->arena, vertices.items, vertices.count) ||
        !copy_lists(scene, mesh, normals, uvs, colors)) {
        fails_for_memory(report);
        return false;
    }
    return build_from_faces(scene, mesh, &faces, report) &&
           finish(mesh, &scene->arena, smooth, "the mesh", report);
}

uint32_t mesh_from_lists(Scene *scene, Vec3List vertices, FaceList faces, Vec3List normals,
                         Vec2List uvs, RgbList colors, bool smooth, MeshReport report)
{
    jmp_buf *on_oom = scene->arena.on_oom;
    scene->arena.on_oom = NULL;
    ArenaMark mark = arena_mark(&scene->arena);
    Mesh mesh = {0};
    bool good =
        make_from_lists(scene, vertices, faces, normals, uvs, colors, smooth, report, &mesh);
    uint32_t id = keep(scene, &mesh, good, mark, report);
    scene->arena.on_oom = on_oom;
    return id;
}
