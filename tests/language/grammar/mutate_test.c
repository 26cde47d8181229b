// Damaged sentences are answered with diagnostics or success, never with a crash.
//     mutate_test GRAMMAR [COUNT [SEED]]      (or SCN_TEST_SEED in the environment)
#include "base/mem.h"
#include "bench.h"
#include "grammar.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdlib.h>

typedef struct Text {
    char *at;
    size_t length;
} Text;

typedef struct Piece {
    size_t begin, end;
} Piece;

// A run of word characters, or one other character: near enough to a token.
static Piece random_piece(const Text *text, Random *random)
{
    size_t at = random_below(random, (uint32_t)text->length);
    size_t begin = at, end = at + 1;
    if (isalnum((unsigned char)text->at[at])) {
        while (begin > 0 && isalnum((unsigned char)text->at[begin - 1])) {
            --begin;
        }
        while (end < text->length && isalnum((unsigned char)text->at[end])) {
            ++end;
        }
    }
    return (Piece){begin, end};
}

// text[0, begin) insert text[end, …)
static void replace(Text *text, size_t begin, size_t end, const char *insert, size_t count)
{
    size_t length = text->length - (end - begin) + count;
    char *made = malloc(length + 1);
    if (!made) {
        exit(2);
    }
    memcpy(made, text->at, begin);
    memcpy(made + begin, insert, count);
    memcpy(made + begin + count, text->at + end, text->length - end);
    made[length] = '\0';
    free(text->at);
    *text = (Text){made, length};
}

static void swap_pieces(Text *text, Random *random)
{
    Piece a = random_piece(text, random), b = random_piece(text, random);
    if (a.end > b.begin) {
        return;
    }
    char *copy = strndup(text->at + a.begin, a.end - a.begin);
    char *other = strndup(text->at + b.begin, b.end - b.begin);
    replace(text, b.begin, b.end, copy, a.end - a.begin);
    replace(text, a.begin, a.end, other, b.end - b.begin);
    free(copy);
    free(other);
}

static void insert_token(Text *text, Random *random)
{
    static const char *const tokens[] = {
        "{",      "}",      "(",      ")",     "[",         "]",
        ":",      ",",      ".",      "..",    "..<",       "=",
        "==",     "-",      "+",      "*",     "/",         "^",
        "%",      "<",      "import", "as",    "fn",        "if",
        "else",   "for",    "in",     "with",  "let",       "param",
        "not",    "and",    "true",   "a",     "sphere",    "1",
        "2.5m",   "\"",     "#",      "#fff",  "//",        "/*",
        "*/",     ";",      "!",      "&&",    "...",       "1e",
        "expect", "within", "of",     "1% of", "1.",        ".5",
        "5 m",    "\\u{",   "\n",     "\t",    "\xc3\xa9",  "\xe2\x80\x9c",
        "\xff",   "1__0",   "'",      "scn 2", "5\xc2\xb0", "@",
        "1e999",  "0x1f",   "..=",    "**",    "\xc2\xa0",  "\r"};
    const char *token = tokens[random_below(random, sizeof tokens / sizeof *tokens)];
    size_t at = random_piece(text, random).begin;
    replace(text, at, at, token, strlen(token));
}

static void mutate(Text *text, Random *random)
{
    if (text->length == 0) {
        replace(text, 0, 0, "{", 1);
    }
    Piece piece = random_piece(text, random);
    char byte = (char)(unsigned char)random_below(random, 256);
    switch (random_below(random, 9)) {
    case 0:
    case 1:
        replace(text, piece.begin, piece.end, "", 0);
        break;
    case 2: {
        char *copy = strndup(text->at + piece.begin, piece.end - piece.begin);
        replace(text, piece.end, piece.end, copy, piece.end - piece.begin);
        free(copy);
        break;
    }
    case 3:
        swap_pieces(text, random);
        break;
    case 4:
        replace(text, piece.begin, piece.begin + 1, &byte, 1);
        break;
    case 5:
        replace(text, piece.begin, piece.begin, &byte, 1);
        break;
    case 6:
        replace(text, piece.begin, text->length, "", 0);
        break;
    default:
        insert_token(text, random);
    }
}

// The parser must be as sound when memory runs out at any point.
static const char *check_without_memory(const Text *text, Random *random)
{
    ParseBench bench;
    uint64_t before = mem_allocation_count();
    bench_begin(&bench, text->at, text->length);
    uint64_t needed = mem_allocation_count() - before;
    bench_end(&bench);
    mem_fail_after(random_below(random, (uint32_t)needed));
    bench_begin(&bench, text->at, text->length);
    mem_fail_after(UINT64_MAX);
    const char *wrong = bench.ok ? "success without memory" : NULL;
    bench_end(&bench);
    return wrong;
}

static bool check(const Text *text, Random *random, uint64_t *accepted, uint64_t *codes)
{
    ParseBench bench;
    bench_begin(&bench, text->at, text->length);
    const char *wrong = bench_check(&bench);
    *accepted += bench.ok;
    for (uint32_t i = 0; i < bench.sink.count; ++i) {
        ++codes[bench.sink.items[i].code];
    }
    if (!wrong && random_below(random, 8) == 0) {
        wrong = check_without_memory(text, random);
    }
    if (wrong) {
        printf("%s\n----\n%.*s\n----\n", wrong, (int)text->length, text->at);
        diag_write_text(&bench.sink, &bench.sources, stdout, DIAG_PLAIN);
    }
    bench_end(&bench);
    return !wrong;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        fputs("usage: mutate_test GRAMMAR [COUNT [SEED]]\n", stderr);
        return 2;
    }
    unsigned long count = argc > 2 ? strtoul(argv[2], NULL, 10) : 10000;
    const char *seed_text = argc > 3 ? argv[3] : getenv("SCN_TEST_SEED");
    uint64_t seed = seed_text ? strtoull(seed_text, NULL, 0) : 20240917;
    printf("%lu damaged sentences, seed %" PRIu64 "\n", count, seed);
    Grammar grammar = grammar_read(argv[1]);
    uint64_t accepted = 0, codes[DIAG_CODE_COUNT] = {0};
    unsigned long i = 0;
    bool good = true;
    for (; i < count && good; ++i) {
        Random random = {seed + i * 0xd1342543de82ef95u};
        Bounds bounds = {8 + random_below(&random, 30), 20 + random_below(&random, 300)};
        Text text;
        text.at = grammar_sentence(&grammar, &random, bounds, &text.length);
        for (uint32_t k = random_below(&random, 4); k < 4; ++k) {
            mutate(&text, &random);
        }
        good = check(&text, &random, &accepted, codes);
        if (!good) {
            printf("sentence %lu of seed %" PRIu64 "\n", i, seed);
        }
        free(text.at);
    }
    size_t kinds = 0;
    for (int code = 0; code < DIAG_CODE_COUNT; ++code) {
        kinds += codes[code] > 0;
        if (codes[code]) {
            printf("%s %" PRIu64 "\n", diag_info((DiagCode)code)->name, codes[code]);
        }
    }
    printf("%" PRIu64 " accepted, %zu codes seen\n", accepted, kinds);
    grammar_free(&grammar);
    // Most damage must be noticed, by many different diagnostics.
    return good && accepted < count / 2 && kinds >= 20 ? 0 : 1;
}
