// Meshes through assimp, as a module of its own: loaded by mesh.c on first use. Assimp reads files
// only through the host's table, takes no post-processing steps, and its data are checked before
// they are used: indices, counts, and the depth of its hierarchy.
#include "scene/mesh_module.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/scene.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { DEEPEST_NODE = 500 };
static const uint64_t most_items = UINT32_MAX / 3; // vertices, faces

// --- Files
// -----------------------------------------------------------------------------------------

typedef struct OpenFile {
    struct aiFile file; // first: assimp sees this
    const char *bytes;
    size_t size, at;
    bool gltf; // by its name
} OpenFile;

static bool is_named_gltf(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot && (strcasecmp(dot, ".gltf") == 0 || strcasecmp(dot, ".glb") == 0);
}

static OpenFile *open_file(struct aiFile *file)
{
    return (OpenFile *)(void *)file;
}

// Two of assimp's readers know glTF; where both refuse a file, assimp asks all others whether they
// know it by words near its beginning, bytes that no reader of glTF asks for like this. What is
// named glTF isn't theirs.
static bool is_probe(const OpenFile *open, size_t size, size_t count)
{
    return open->gltf && open->at == 0 && size == 1 && count != open->size;
}

static size_t read_items(struct aiFile *file, char *out, size_t size, size_t count)
{
    OpenFile *open = open_file(file);
    if (is_probe(open, size, count)) {
        return 0;
    }
    size_t left = size ? (open->size - open->at) / size : 0;
    count = count < left ? count : left;
    memcpy(out, open->bytes + open->at, count * size);
    open->at += count * size;
    return count;
}

static size_t refuse_to_write(struct aiFile *file, const char *bytes, size_t size, size_t count)
{
    (void)file, (void)bytes, (void)size, (void)count;
    return 0;
}

static size_t tell(struct aiFile *file)
{
    return open_file(file)->at;
}

static size_t file_size(struct aiFile *file)
{
    return open_file(file)->size;
}

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    OpenFile *open = open_file(file);
    size_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? open->at : open->size;
    size_t to = from + offset; // offsets backwards come as large ones
    if (to > open->size) {
        return aiReturn_FAILURE;
    }
    open->at = to;
    return aiReturn_SUCCESS;
}

static void flush(struct aiFile *file)
{
    (void)file;
}

static struct aiFile *open_for_assimp(struct aiFileIO *io, const char *path, const char *mode)
{
    const MeshModuleHost *host = (const MeshModuleHost *)(const void *)io->UserData;
    const void *bytes;
    size_t size;
    if (!mode || mode[0] != 'r' || strchr(mode, '+') ||
        !host->read(host->context, path, &bytes, &size)) {
        return NULL;
    }
    OpenFile *open = calloc(1, sizeof *open);
    if (!open) {
        return NULL;
    }
    open->bytes = bytes;
    open->size = size;
    open->gltf = is_named_gltf(path);
    open->file = (struct aiFile){.ReadProc = read_items,
                                 .WriteProc = refuse_to_write,
                                 .TellProc = tell,
                                 .FileSizeProc = file_size,
                                 .SeekProc = seek,
                                 .FlushProc = flush};
    return &open->file;
}

static void close_for_assimp(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    free(open_file(file));
}

// --- From assimp's meshes to one
// -------------------------------------------------------------------

typedef struct Collector {
    const struct aiScene *scene;
    MeshModuleOutput *out;
    uint64_t vertices, faces, indices; // counted, then filled so far
    bool normals, uvs, colors, keep_normals;
    bool filling;
    char *message;
    size_t message_size;
} Collector;

static bool fail(Collector *collector, const char *text)
{
    snprintf(collector->message, collector->message_size, "%s", text);
    return false;
}

static Affine to_affine(const struct aiMatrix4x4 *m)
{
    return (Affine){{{(double)m->a1, (double)m->a2, (double)m->a3, (double)m->a4},
                     {(double)m->b1, (double)m->b2, (double)m->b3, (double)m->b4},
                     {(double)m->c1, (double)m->c2, (double)m->c3, (double)m->c4}}};
}

// a after b. (Ours, in base/vec.c, isn't linked here.)
static Affine multiply(const Affine *a, const Affine *b)
{
    Affine out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) {
            out.m[i][j] = a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] +
                          a->m[i][2] * b->m[2][j] + (j == 3 ? a->m[i][3] : 0);
        }
    }
    return out;
}

// The rows of the cofactor matrix, which carries normals up to the sign of the determinant.
static void cofactors(const Affine *a, Vec3 rows[3])
{
    Vec3 r[3];
    for (int i = 0; i < 3; ++i) {
        r[i] = vec3(a->m[i][0], a->m[i][1], a->m[i][2]);
    }
    for (int i = 0; i < 3; ++i) {
        rows[i] = cross(r[(i + 1) % 3], r[(i + 2) % 3]);
    }
}

static double determinant(const Affine *a)
{
    Vec3 rows[3];
    cofactors(a, rows);
    return dot(vec3(a->m[0][0], a->m[0][1], a->m[0][2]), rows[0]);
}

static Vec3 from_assimp(const struct aiVector3D *v)
{
    return vec3((double)v->x, (double)v->y, (double)v->z);
}

static void store(float *out, Vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static void fill_normals(const struct aiMesh *mesh, const Affine *to_root, float *out)
{
    Vec3 rows[3];
    cofactors(to_root, rows);
    double side = determinant(to_root) < 0 ? -1 : 1;
    for (size_t i = 0; mesh->mNormals && i < mesh->mNumVertices; ++i) {
        Vec3 n = from_assimp(&mesh->mNormals[i]);
        n = normalize(scale(vec3(dot(rows[0], n), dot(rows[1], n), dot(rows[2], n)), side));
        store(out + 3 * i, n); // not finite where it was zero; the host mends it
    }
}

static void fill_vertices(Collector *collector, const struct aiMesh *mesh, const Affine *to_root)
{
    MeshModuleOutput *out = collector->out;
    const size_t first = collector->vertices;
    for (size_t i = 0; i < mesh->mNumVertices; ++i) {
        out->points[first + i] = transform_point(to_root, from_assimp(&mesh->mVertices[i]));
        if (out->uvs && mesh->mTextureCoords[0]) {
            out->uvs[2 * (first + i)] = mesh->mTextureCoords[0][i].x;
            out->uvs[2 * (first + i) + 1] = mesh->mTextureCoords[0][i].y;
        }
        if (out->colors) {
            const struct aiColor4D *color = mesh->mColors[0] ? &mesh->mColors[0][i] : NULL;
            float *rgb_out = out->colors + 3 * (first + i);
            rgb_out[0] = color ? color->r : 1;
            rgb_out[1] = color ? color->g : 1;
            rgb_out[2] = color ? color->b : 1;
        }
    }
    if (out->normals) {
        fill_normals(mesh, to_root, out->normals + 3 * first);
    }
}

// A mirrored mesh is wound the other way round, so that its front stays its front.
static void fill_faces(Collector *collector, const struct aiMesh *mesh, bool mirrored)
{
    MeshModuleOutput *out = collector->out;
    for (size_t f = 0; f < mesh->mNumFaces; ++f) {
        const struct aiFace *face = &mesh->mFaces[f];
        uint32_t *indices = out->indices + collector->indices;
        for (uint32_t i = 0; i < face->mNumIndices; ++i) {
            indices[mirrored ? face->mNumIndices - 1 - i : i] =
                (uint32_t)collector->vertices + face->mIndices[i];
        }
        out->sizes[collector->faces + f] = face->mNumIndices;
        collector->indices += face->mNumIndices;
    }
}

static bool check_mesh(Collector *collector, const struct aiMesh *mesh)
{
    if ((mesh->mNumVertices && !mesh->mVertices) || (mesh->mNumFaces && !mesh->mFaces)) {
        return fail(collector, "a mesh without vertices");
    }
    for (size_t f = 0; f < mesh->mNumFaces; ++f) {
        const struct aiFace *face = &mesh->mFaces[f];
        for (uint32_t i = 0; i < face->mNumIndices; ++i) {
            if (face->mIndices[i] >= mesh->mNumVertices) {
                return fail(collector, "a face refers to a vertex that isn't there");
            }
        }
        collector->indices += face->mNumIndices;
    }
    collector->normals = collector->normals || (mesh->mNormals && collector->keep_normals);
    collector->uvs = collector->uvs || mesh->mTextureCoords[0];
    collector->colors = collector->colors || mesh->mColors[0];
    return true;
}

static bool collect_mesh(Collector *collector, uint32_t number, const Affine *to_root)
{
    const struct aiMesh *mesh =
        number < collector->scene->mNumMeshes ? collector->scene->mMeshes[number] : NULL;
    if (!mesh) {
        return fail(collector, "a node refers to a mesh that isn't there");
    }
    if (collector->filling) {
        fill_vertices(collector, mesh, to_root);
        fill_faces(collector, mesh, determinant(to_root) < 0);
    } else if (!check_mesh(collector, mesh)) {
        return false;
    }
    collector->vertices += mesh->mNumVertices;
    collector->faces += mesh->mNumFaces;
    return (collector->vertices <= most_items && collector->faces <= most_items) ||
           fail(collector, "more vertices or faces than a mesh can have");
}

static bool collect_node(Collector *collector, const struct aiNode *node, const Affine *above,
                         int depth)
{
    if (depth > DEEPEST_NODE) {
        return fail(collector, "its nodes are nested too deeply");
    }
    Affine own = to_affine(&node->mTransformation), to_root = multiply(above, &own);
    for (unsigned i = 0; i < node->mNumMeshes; ++i) {
        if (!collect_mesh(collector, node->mMeshes[i], &to_root)) {
            return false;
        }
    }
    for (unsigned i = 0; i < node->mNumChildren; ++i) {
        if (node->mChildren[i] &&
            !collect_node(collector, node->mChildren[i], &to_root, depth + 1)) {
            return false;
        }
    }
    return true;
}

static bool make_room(const Collector *collector, const MeshModuleHost *host)
{
    MeshModuleOutput *out = collector->out;
    size_t vertices = collector->vertices;
    out->vertex_count = (uint32_t)collector->vertices;
    out->face_count = (uint32_t)collector->faces;
    out->index_count = collector->indices;
    out->points = host->alloc(host->context, vertices, sizeof *out->points);
    out->indices = host->alloc(host->context, collector->indices, sizeof *out->indices);
    out->sizes = host->alloc(host->context, collector->faces, sizeof *out->sizes);
    if (collector->normals) {
        out->normals = host->alloc(host->context, vertices, 3 * sizeof(float));
    }
    if (collector->uvs) {
        out->uvs = host->alloc(host->context, vertices, 2 * sizeof(float));
    }
    if (collector->colors) {
        out->colors = host->alloc(host->context, vertices, 3 * sizeof(float));
    }
    if (!out->points || !out->indices || !out->sizes || (collector->normals && !out->normals) ||
        (collector->uvs && !out->uvs) || (collector->colors && !out->colors)) {
        return false;
    }
    // Meshes without the attribute leave theirs as it is.
    if (out->normals) {
        memset(out->normals, 0, vertices * 3 * sizeof(float));
    }
    if (out->uvs) {
        memset(out->uvs, 0, vertices * 2 * sizeof(float));
    }
    return true;
}

static bool collect(Collector *collector, const MeshModuleHost *host)
{
    const struct aiNode *root = collector->scene->mRootNode;
    const Affine identity = affine_identity();
    if (!root) {
        return fail(collector, "it holds no mesh");
    }
    if (!collect_node(collector, root, &identity, 0)) {
        return false;
    }
    if (!make_room(collector, host)) {
        return fail(collector, "not enough memory");
    }
    collector->filling = true;
    collector->vertices = collector->faces = collector->indices = 0;
    return collect_node(collector, root, &identity, 0);
}

// An STL file has one normal for each triangle, which says no more than its corners do.
static bool has_own_normals(const char *path)
{
    const char *dot = strrchr(path, '.');
    return !dot || strcasecmp(dot, ".stl") != 0;
}

bool scn_mesh_import(const MeshModuleHost *host, const char *path, MeshModuleOutput *out,
                     char *message, size_t message_size)
{
    MeshModuleHost table = *host;
    struct aiFileIO io = {open_for_assimp, close_for_assimp, (char *)(void *)&table};
    struct aiPropertyStore *properties = aiCreatePropertyStore();
    if (!properties) {
        snprintf(message, message_size, "not enough memory");
        return false;
    }
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1);
    const struct aiScene *scene = aiImportFileExWithProperties(path, 0, &io, properties);
    aiReleasePropertyStore(properties);
    if (!scene) {
        const char *reason = aiGetErrorString();
        snprintf(message, message_size, "%s", reason && *reason ? reason : "assimp gave no reason");
        return false;
    }
    Collector collector = {.scene = scene,
                           .out = out,
                           .keep_normals = has_own_normals(path),
                           .message = message,
                           .message_size = message_size};
    bool good = collect(&collector, host);
    aiReleaseImport(scene);
    return good;
}
