// Meshes of files that outlive the scene that named them: where a scene is evaluated again and
// again, a file is parsed once for as long as its bytes, and those of the files that it refers to,
// stay the same. A scene gets a copy, so that nothing of it depends on the cache.
#ifndef SCENE_MESH_CACHE_H
#define SCENE_MESH_CACHE_H

#include "scene/scene.h"

// A file's name and bytes.
typedef struct MeshSource {
    const char *path;
    const FileBytes *bytes;
} MeshSource;

typedef struct MeshCache MeshCache;

// A Scene's `mesh_cache` may point to one, for one thread at a time. With a cache of NULL nothing
// is found or kept.
MeshCache *mesh_cache_new(void);
void mesh_cache_free(MeshCache *cache);
// After a scene was evaluated, or before the next is: what none asked for since the last turn is
// dropped.
void mesh_cache_turn(MeshCache *cache);
// Whether a mesh is known that was made of this file and of others that are as they were: these are
// read through the sandbox, too. Then *mesh is a copy in `arena`, without the name of its file; not
// found where memory runs out.
bool mesh_cache_find(MeshCache *cache, Sandbox *sandbox, MeshSource file, bool smooth, Arena *arena,
                     Mesh *mesh);
// Keeps a copy of a mesh; sources[0] is its own file.
void mesh_cache_add(MeshCache *cache, const MeshSource *sources, size_t count, const Mesh *mesh);

#endif
