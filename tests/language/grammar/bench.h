// One text through the parser, with every promise of its header checked.
#ifndef TESTS_GRAMMAR_BENCH_H
#define TESTS_GRAMMAR_BENCH_H

#include "lang/ast.h"

typedef struct ParseBench {
    Arena arena;
    Sources sources;
    Interner names;
    DiagSink sink;
    Ast ast;
    bool ok;
} ParseBench;

// Parses; `text` must live until bench_end.
void bench_begin(ParseBench *bench, const char *text, size_t length);
void bench_end(ParseBench *bench);
// NULL, or what is wrong: a node or diagnostic that doesn't lie in the text, a child that isn't
// inside its parent, success with errors reported, …
const char *bench_check(ParseBench *bench);
// The same, without also writing the diagnostics and the tree to nowhere.
const char *bench_check_tree(const ParseBench *bench);

#endif
