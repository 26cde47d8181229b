// Reading triangle meshes from files, and making them from lists.
#ifndef SCENE_MESH_H
#define SCENE_MESH_H

#include "scene/scene.h"

// The parameters of the `mesh` kind: its fields as written, and the Mesh that they became.
typedef struct MeshParams {
    const char *file;
    Vec3List vertices;
    FaceList faces;
    Vec3List normals;
    Vec2List uvs;
    RgbList colors;
    bool smooth;
    uint32_t mesh; // derived: index into scene->meshes
} MeshParams;

// A report at the mesh's `file` field, and the reader's own place in that file.
typedef struct MeshReport {
    DiagSink *sink;
    Span at;
} MeshReport;

// Adds the triangles of a file (PLY by our own reader; OBJ, STL, glTF, 3DS, … through assimp) to
// the scene and returns the mesh's id; the same file with the same options is read once. NONE_ID
// after a report: the file can't be read, is damaged (the message names its line or byte offset),
// holds no triangle, or is larger than the sandbox's limits. Degenerate and not-finite triangles
// are left out, counted in the Mesh and reported as a warning. Polygons are cut into triangles.
uint32_t mesh_load(Scene *scene, const char *path, bool smooth, MeshReport report);

// The same from lists, as the `mesh` kind's fields hold them; normals, uvs and colors may be empty,
// else they have as many entries as vertices.
uint32_t mesh_from_lists(Scene *scene, Vec3List vertices, FaceList faces, Vec3List normals,
                         Vec2List uvs, RgbList colors, bool smooth, MeshReport report);

// The reader of PLY (ASCII, binary little and big endian), on bytes in memory; fuzzed on its own.
// On success fills *mesh with memory from `arena`. On failure returns false and writes what is
// wrong into `message`, with the line (ASCII part) or the byte offset.
bool ply_read(Arena *arena, const char *bytes, size_t size, Mesh *mesh, char *message,
              size_t message_size);

#endif
