// Every sentence of grammar/scn.ebnf, formatted, has the same tree and comments, and is formatted;
// and so are the scenes in the folders named.
//     format_test GRAMMAR [COUNT [FOLDER…]]      (SCN_TEST_SEED in the environment)
#include "format_check.h"
#include "grammar.h"

#include "base/io.h"

#include <ftw.h>
#include <inttypes.h>
#include <stdlib.h>

typedef ARRAY(char) Text;

static void put(Text *text, char c)
{
    if (!array_push(text, c)) {
        abort();
    }
}

// What the generator seldom writes where it had a blank: line ends, gaps up to a column that other
// lines may have too, tabs, comments, carriage returns; at times a byte order mark.
static Text shake(const char *from, Random *random)
{
    static const uint32_t grids[] = {4, 12, 40, 600};
    Text text = {0};
    uint32_t grid = grids[random_below(random, 4)], column = 0;
    for (const char *mark = random_below(random, 8) ? "" : "\xef\xbb\xbf"; *mark; ++mark) {
        put(&text, *mark);
    }
    for (; *from; ++from) {
        uint32_t choice = *from == ' ' ? random_below(random, 8) : UINT32_MAX;
        if (choice < 2) {
            put(&text, '\n');
        } else if (choice < 4) {
            for (uint32_t most = 0; (column % grid || !most) && most < grid; ++most, ++column) {
                put(&text, ' ');
            }
        } else if (choice == 4) {
            const char *at =
                (const char *[]){" /* c */ ", "\t", " // c\n", "\r\n"}[random_below(random, 4)];
            for (; *at; ++at) {
                put(&text, *at);
            }
        } else {
            put(&text, *from);
        }
        column = text.items[text.count - 1] == '\n' ? 0 : column + 1;
    }
    put(&text, '\0');
    return text;
}

static bool run_text(const char *name, const char *text, size_t length, bool must_parse,
                     size_t *accepted)
{
    FormatBench bench;
    const char *wrong = format_bench_check(&bench, text, length);
    if (!wrong && must_parse && !bench.accepted) {
        wrong = "not accepted";
    }
    if (wrong) {
        printf("%s: %s\n---- before\n%.*s\n---- once\n%.*s\n---- twice\n%.*s\n----\n", name, wrong,
               (int)length, text, (int)bench.once.count, bench.once.items ? bench.once.items : "",
               (int)bench.twice.count, bench.twice.items ? bench.twice.items : "");
        diag_write_text(&bench.sink, &bench.sources, stdout, DIAG_PLAIN);
    }
    *accepted += bench.accepted;
    format_bench_end(&bench);
    return !wrong;
}

static size_t run_sentences(Grammar *grammar, uint64_t seed, unsigned long count)
{
    size_t failed = 0, accepted = 0;
    for (unsigned long i = 0; i < count && failed < 3; ++i) {
        Random random = {seed + i * 0x9e3779b97f4a7c15u};
        Bounds bounds = {8 + random_below(&random, 40), 20 + random_below(&random, 900)};
        size_t length;
        char *text = grammar_sentence(grammar, &random, bounds, &length);
        char name[64];
        snprintf(name, sizeof name, "sentence %lu of seed %" PRIu64, i, seed);
        failed += !run_text(name, text, length, true, &accepted);
        // May end a `//` comment or a string: some are no sentences any more.
        Text shaken = shake(text, &random);
        failed += !run_text(name, shaken.items, shaken.count - 1, false, &accepted);
        array_free(&shaken);
        free(text);
    }
    printf("%zu sentences accepted\n", accepted);
    return failed + (accepted < count);
}

// nftw hands nothing on to its callback.
static size_t files_failed, files_accepted, files_seen;

static int visit(const char *path, const struct stat *info, int type, struct FTW *place)
{
    (void)info;
    (void)place;
    size_t length = strlen(path);
    FileBytes bytes;
    if (type == FTW_F && length > 4 && strcmp(path + length - 4, ".scn") == 0) {
        ++files_seen;
        if (file_read(path, UINT32_MAX, &bytes) != IO_OK) {
            printf("can't read %s\n", path);
            ++files_failed;
        } else {
            files_failed += !run_text(path, bytes.bytes, bytes.size, false, &files_accepted);
            file_bytes_free(&bytes);
        }
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        fputs("usage: format_test GRAMMAR [COUNT [FOLDER…]]\n", stderr);
        return 2;
    }
    unsigned long count = argc > 2 ? strtoul(argv[2], NULL, 10) : 10000;
    const char *seed_text = getenv("SCN_TEST_SEED");
    uint64_t seed = seed_text ? strtoull(seed_text, NULL, 0) : 20240917;
    Grammar grammar = grammar_read(argv[1]);
    size_t failed = run_sentences(&grammar, seed, count);
    grammar_free(&grammar);
    for (int i = 3; i < argc; ++i) {
        nftw(argv[i], visit, 16, FTW_PHYS);
    }
    if (argc > 3) {
        printf("%zu files, %zu of them accepted\n", files_seen, files_accepted);
        failed += files_failed + (files_accepted < 20);
    }
    puts(failed ? "FAILED" : "all trees and comments kept");
    return failed ? 1 : 0;
}
