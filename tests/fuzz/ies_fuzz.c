// The reader of photometric files: whatever the bytes, a table with a finite flux and finite
// intensities everywhere, or a message with its line.
#include "base/mem.h"
#include "fuzz.h"
#include "scene/ies.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    const uint64_t live = mem_live_count();
    Arena arena = {.limit = (size_t)1 << 26};
    IesError error;
    const IesWeb *web = ies_read(&arena, (Str){(const char *)bytes, size}, &error);
    fuzz_require(web || error.message[0], "a failure is told");
    for (int i = 0; web && i < 64; ++i) {
        double z = 1 - i / 31.5, phi = 2.4 * i, r = sqrt(fmax(0, 1 - z * z));
        double candela = ies_candela(web, z, r * cos(phi), r * sin(phi));
        double factor = ies_tilt_factor(web, 0.05 * i);
        fuzz_require(candela >= 0 && isfinite(candela) && factor >= 0, "finite intensities");
    }
    fuzz_require(!web || (ies_reach(web) >= 0 && !isnan(ies_lumens(web))), "a flux");
    arena_free(&arena);
    fuzz_require(mem_live_count() == live, "all memory is given back");
    return 0;
}
