// The formatter: what parses is laid out with the same tree and the same comments, and laying that
// out again changes nothing.
#include "../language/grammar/format_check.h"
#include "fuzz.h"

#include "base/mem.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    const uint64_t live = mem_live_count();
    FormatBench bench;
    const char *wrong = format_bench_check(&bench, (const char *)bytes, size);
    fuzz_require(!wrong, wrong);
    format_bench_end(&bench);
    fuzz_require(mem_live_count() == live, "all memory is given back");
    return 0;
}
