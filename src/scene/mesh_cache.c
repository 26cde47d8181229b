#include "scene/mesh_cache.h"

#include "base/array.h"
#include "scene/mesh_build.h"

#include <string.h>
#include <xxhash.h>

typedef struct KeptSource {
    const char *path;
    XXH128_hash_t digest;
} KeptSource;

typedef struct KeptMesh {
    Arena arena;
    KeptSource *sources; // [0] is the mesh's own file
    size_t source_count;
    Mesh mesh;
    bool asked; // since the last turn
} KeptMesh;

struct MeshCache {
    ARRAY(KeptMesh *) kept;
};

static void drop(KeptMesh *kept)
{
    arena_free(&kept->arena);
    mem_free(kept);
}

MeshCache *mesh_cache_new(void)
{
    return mem_alloc_zeroed(1, sizeof(MeshCache));
}

void mesh_cache_free(MeshCache *cache)
{
    if (!cache) {
        return;
    }
    for (size_t i = 0; i < cache->kept.count; ++i) {
        drop(cache->kept.items[i]);
    }
    array_free(&cache->kept);
    mem_free(cache);
}

void mesh_cache_turn(MeshCache *cache)
{
    size_t still = 0;
    for (size_t i = 0; cache && i < cache->kept.count; ++i) {
        KeptMesh *kept = cache->kept.items[i];
        if (kept->asked) {
            kept->asked = false;
            cache->kept.items[still++] = kept;
        } else {
            drop(kept);
        }
    }
    if (cache) {
        cache->kept.count = still;
    }
}

static bool is_as_it_was(const KeptSource *source, const FileBytes *bytes)
{
    return XXH128_isEqual(source->digest, XXH3_128bits(bytes->bytes, bytes->size));
}

static bool others_are_as_they_were(const KeptMesh *kept, Sandbox *sandbox)
{
    for (size_t i = 1; i < kept->source_count; ++i) {
        FileBytes bytes;
        if (sandbox_read(sandbox, kept->sources[i].path, &bytes) != IO_OK) {
            return false;
        }
        const bool same = is_as_it_was(&kept->sources[i], &bytes);
        file_bytes_free(&bytes);
        if (!same) {
            return false;
        }
    }
    return true;
}

bool mesh_cache_find(MeshCache *cache, Sandbox *sandbox, MeshSource file, bool smooth, Arena *arena,
                     Mesh *mesh)
{
    for (size_t i = 0; cache && i < cache->kept.count; ++i) {
        KeptMesh *kept = cache->kept.items[i];
        if (kept->mesh.smooth == smooth && strcmp(kept->sources[0].path, file.path) == 0 &&
            is_as_it_was(&kept->sources[0], file.bytes) && others_are_as_they_were(kept, sandbox)) {
            kept->asked = true;
            *mesh = kept->mesh;
            return mesh_copy(mesh, arena);
        }
    }
    return false;
}

static bool copy_sources(KeptMesh *kept, const MeshSource *sources, size_t count)
{
    kept->sources = arena_array(&kept->arena, count, sizeof *kept->sources);
    for (size_t i = 0; kept->sources && i < count; ++i) {
        const char *path =
            arena_copy_string(&kept->arena, sources[i].path, strlen(sources[i].path));
        if (!path) {
            return false;
        }
        kept->sources[i] =
            (KeptSource){path, XXH3_128bits(sources[i].bytes->bytes, sources[i].bytes->size)};
    }
    kept->source_count = count;
    return kept->sources != NULL;
}

void mesh_cache_add(MeshCache *cache, const MeshSource *sources, size_t count, const Mesh *mesh)
{
    KeptMesh *kept = cache ? mem_alloc_zeroed(1, sizeof *kept) : NULL;
    if (!kept) {
        return;
    }
    kept->mesh = *mesh;
    kept->mesh.file = NULL;
    kept->asked = true;
    if (!copy_sources(kept, sources, count) || !mesh_copy(&kept->mesh, &kept->arena) ||
        !array_push(&cache->kept, kept)) {
        drop(kept);
    }
}
