// The reader of PLY: whatever the bytes, a sound mesh or a message.
#include "base/mem.h"
#include "fuzz.h"
#include "scene/mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    const uint64_t live = mem_live_count();
    Arena arena = {.limit = (size_t)1 << 26};
    Mesh mesh = {0};
    char message[200] = "";
    bool good = ply_read(&arena, (const char *)bytes, size, &mesh, message, sizeof message);
    for (size_t i = 0; good && i < 3 * (size_t)mesh.triangle_count; ++i) {
        fuzz_require(mesh.triangles[i] < mesh.vertex_count, "an index of a vertex");
    }
    fuzz_require(good || message[0], "a failure is told");
    arena_free(&arena);
    fuzz_require(mem_live_count() == live, "all memory is given back");
    return 0;
}
