// The reader of PLY: whatever the bytes, a sound mesh or a message.
#include "scene/mesh.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    Arena arena = {.limit = (size_t)1 << 26};
    Mesh mesh = {0};
    char message[200] = "";
    bool good = ply_read(&arena, (const char *)bytes, size, &mesh, message, sizeof message);
    for (size_t i = 0; good && i < 3 * (size_t)mesh.triangle_count; ++i) {
        if (mesh.triangles[i] >= mesh.vertex_count) {
            abort();
        }
    }
    if (!good && !message[0]) {
        abort();
    }
    arena_free(&arena);
    return 0;
}
