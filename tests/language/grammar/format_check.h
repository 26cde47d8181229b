// One text through the formatter, with every promise of its header checked.
#ifndef TESTS_FORMAT_CHECK_H
#define TESTS_FORMAT_CHECK_H

#include "lang/format.h"

typedef struct FormatBench {
    Arena arena;
    Sources sources;
    Interner names;
    DiagSink sink;
    FormatText once, twice;
    bool accepted; // the text has no syntax errors
} FormatBench;

// Formats, formats the result, and compares. NULL, or what is wrong: another tree, another text the
// second time, lost comments, …. `text` must live until format_bench_end.
const char *format_bench_check(FormatBench *bench, const char *text, size_t length);
void format_bench_end(FormatBench *bench);

#endif
