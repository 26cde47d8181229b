// Lexer and parser alone, with every promise of their headers: a tree whose children lie inside
// their parents and that is no deeper than said, diagnostics that lie in the text, no success with
// an error.
#include "../language/grammar/bench.h"
#include "fuzz.h"

#include "base/mem.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    const uint64_t live = mem_live_count();
    ParseBench bench;
    bench_begin(&bench, (const char *)bytes, size);
    const char *wrong = bench_check_tree(&bench);
    fuzz_require(!wrong, wrong);
    bench_end(&bench);
    fuzz_require(mem_live_count() == live, "all memory is given back");
    return 0;
}
