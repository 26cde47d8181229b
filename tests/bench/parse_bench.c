// How fast a big file of literal items is parsed. Not a test.
//     parse_bench [SPHERES [ROUNDS]]
#include "lang/ast.h"

#include <stdlib.h>
#include <time.h>

// CPU time, since other programs may run.
static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static char *make_text(size_t spheres, size_t *length)
{
    char *text = malloc(spheres * 96 + 1), *at = text;
    if (!text) {
        return NULL;
    }
    srand(1);
    for (size_t i = 0; i < spheres; ++i) {
        at += sprintf(at, "sphere { center: (%.4f, %.3f, %d) radius: 0.%02d material: m%d }\n",
                      rand() % 100000 / 1000.0 - 50, rand() % 1000 / 100.0, rand() % 100,
                      rand() % 100, rand() % 8);
    }
    *length = (size_t)(at - text);
    return text;
}

// Seconds that one parse takes; the tree's size in *bytes.
static double measure(Str text, size_t *bytes)
{
    Arena arena = {0};
    Sources sources;
    Interner names;
    DiagSink sink;
    sources_init(&sources, &arena);
    interner_init(&names, &arena);
    diag_sink_init(&sink, &arena);
    uint32_t file = sources_add(&sources, "bench.scn", NULL, text, (Span){0});
    Ast ast;
    double begin = now();
    bool ok = parse(&ast, &sources, file, &names, (ParseLimits){200}, false, &sink);
    double seconds = now() - begin;
    *bytes = ast.nodes.count * sizeof(AstNode) + ast.extra.count * sizeof(uint32_t);
    if (!ok) {
        diag_write_text(&sink, &sources, stderr, DIAG_PLAIN);
        exit(1);
    }
    ast_free(&ast);
    diag_sink_free(&sink);
    interner_free(&names);
    sources_free(&sources);
    arena_free(&arena);
    return seconds;
}

int main(int argc, char **argv)
{
    size_t spheres = argc > 1 ? strtoul(argv[1], NULL, 10) : 1000000;
    int rounds = argc > 2 ? atoi(argv[2]) : 5;
    size_t length = 0, bytes = 0;
    char *text = make_text(spheres, &length);
    if (!text) {
        return 2;
    }
    double best = 1e30;
    for (int i = 0; i < rounds; ++i) {
        double seconds = measure((Str){text, length}, &bytes);
        best = seconds < best ? seconds : best;
    }
    printf("%zu spheres, %.1f MB: %.0f MB/s, %.3f s, tree of %.1f MB\n", spheres,
           (double)length / 1e6, (double)length / 1e6 / best, best, (double)bytes / 1e6);
    free(text);
    return 0;
}
