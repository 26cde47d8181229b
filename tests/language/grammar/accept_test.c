// Every sentence of grammar/scn.ebnf is accepted.
//     accept_test GRAMMAR [COUNT [SEED]]      (or SCN_TEST_SEED in the environment)
#include "bench.h"
#include "grammar.h"

#include <inttypes.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    if (argc < 2) {
        fputs("usage: accept_test GRAMMAR [COUNT [SEED]]\n", stderr);
        return 2;
    }
    unsigned long count = argc > 2 ? strtoul(argv[2], NULL, 10) : 10000;
    const char *seed_text = argc > 3 ? argv[3] : getenv("SCN_TEST_SEED");
    uint64_t seed = seed_text ? strtoull(seed_text, NULL, 0) : 20240917;
    printf("%lu sentences, seed %" PRIu64 "\n", count, seed);
    Grammar grammar = grammar_read(argv[1]);
    uint64_t tags[AST_TAG_COUNT] = {0};
    size_t failed = 0, bytes = 0;
    for (unsigned long i = 0; i < count && failed < 5; ++i) {
        Random random = {seed + i * 0x9e3779b97f4a7c15u};
        Bounds bounds = {8 + random_below(&random, 40), 20 + random_below(&random, 600)};
        size_t length;
        char *text = grammar_sentence(&grammar, &random, bounds, &length);
        ParseBench bench;
        bench_begin(&bench, text, length);
        const char *wrong = bench_check(&bench);
        if (!bench.ok || wrong) {
            printf("sentence %lu of seed %" PRIu64 ": %s\n----\n%s\n----\n", i, seed,
                   wrong ? wrong : "not accepted", text);
            diag_write_text(&bench.sink, &bench.sources, stdout, DIAG_PLAIN);
            ++failed;
        }
        for (size_t k = 1; k < bench.ast.nodes.count; ++k) {
            ++tags[bench.ast.nodes.items[k].tag];
        }
        bytes += length;
        bench_end(&bench);
        free(text);
    }
    failed += grammar_print_unused(&grammar);
    for (int tag = AST_ERROR + 1; tag < AST_TAG_COUNT; ++tag) {
        if (!tags[tag]) {
            printf("never made: %s\n", ast_tag_name((AstTag)tag));
            ++failed;
        }
    }
    printf("%zu bytes; %s\n", bytes, failed ? "FAILED" : "all accepted, every production used");
    grammar_free(&grammar);
    return failed ? 1 : 0;
}
