// Between mesh.c and the module that reads meshes through assimp (module_assimp.c): the module
// links nothing of ours, and gets what it needs through a table of functions.
#ifndef SCENE_MESH_MODULE_H
#define SCENE_MESH_MODULE_H

#include "base/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// What the module may ask for. `context` goes with every call.
typedef struct MeshModuleHost {
    void *context;
    // The bytes of a file that the mesh's file refers to (or of that file itself), by its path.
    // They stay until the import is over. False where the file may not or can't be read.
    bool (*read)(void *context, const char *path, const void **bytes, size_t *size);
    // Memory for the output, given back by the host; NULL when there is none.
    void *(*alloc)(void *context, size_t count, size_t size);
} MeshModuleHost;

// All meshes of a file in one, with its hierarchy of nodes applied.
typedef struct MeshModuleOutput {
    Vec3 *points;
    float *normals, *uvs, *colors; // 3, 2, 3 numbers a vertex; NULL if no mesh of the file has any
    uint32_t *indices, *sizes;     // faces one after another; sizes[f] corners each, at least 1
    uint32_t vertex_count, face_count;
    uint64_t index_count;
} MeshModuleOutput;

// False with a message. The symbol `scn_mesh_import` of the module is such a function.
typedef bool MeshModuleImport(const MeshModuleHost *host, const char *path, MeshModuleOutput *out,
                              char *message, size_t message_size);

#define MESH_MODULE_SYMBOL "scn_mesh_import"

MeshModuleImport scn_mesh_import;

#endif
