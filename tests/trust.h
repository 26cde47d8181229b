// Lines of the table of trust: what was checked and where, what was expected and what came out, and
// how small an error would have been found. Tests write them as they run, each program into a file
// of its own in the build folder (trust/*.tsv); tools/trust makes one table of them, in which all
// statistical checks are one family. The name of a reference check begins with its number.
#ifndef TEST_TRUST_H
#define TEST_TRUST_H

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A run in which every statistical check takes as many samples as a bias of 0.1 % needs, as by
// `tools/trust full`.
static inline bool full_run(void)
{
    const char *text = getenv("SCN_TRUST");
    return text && strcmp(text, "full") == 0;
}

// Of a program that is run in parts: which one this is. To be set before the first line.
static const char *trust_part = "";

// The test's source, as seen from tests/.
static inline const char *trust_where(void)
{
    const char *file = __BASE_FILE__, *where = file;
    for (const char *at = file; (at = strstr(at, "tests/")) != NULL; ++at) {
        where = at + strlen("tests/");
    }
    return where;
}

static inline FILE *trust_file(void)
{
    static FILE *file;
    static bool tried;
    if (!tried) {
        char path[512], name[128];
        snprintf(name, sizeof name, "%s", trust_where());
        for (char *c = name; *c; ++c) {
            *c = *c == '/' || *c == '.' ? '_' : *c;
        }
        snprintf(path, sizeof path, "%s/trust/%s%s%s.tsv", SCN_BINARY_DIR,
                 full_run() ? "full/" : "", name, trust_part);
        file = fopen(path, "w");
        tried = true;
    }
    return file;
}

// The columns: kind, name, where, and what the kind says (tests/trust_table.c reads them).
__attribute__((format(printf, 3, 4))) static inline void
trust_line(const char *kind, const char *name, const char *format, ...)
{
    FILE *file = trust_file();
    if (file) {
        va_list arguments;
        va_start(arguments, format);
        fprintf(file, "%s\t%s\t%s\t", kind, name, trust_where());
        vfprintf(file, format, arguments);
        fputc('\n', file);
        va_end(arguments);
        fflush(file);
    }
}

// A mean with its standard error, Student's t with so many degrees of freedom. In a full run a
// relative bias larger than `allowed` must not go unfound.
static inline void trust_mean(const char *name, double expected, double measured, double error,
                              double freedom, double allowed)
{
    trust_line("mean", name, "%.17g\t%.17g\t%.6g\t%g\t%g", expected, measured, error, freedom,
               allowed);
}

// Pearson's test of `samples` in cells with so many degrees of freedom.
static inline void trust_chi2(const char *name, double p, double samples, double freedom)
{
    trust_line("chi2", name, "%.6g\t%.0f\t%.0f", p, samples, freedom);
}

// A number without noise; the tolerance is absolute. Whether it is right.
static inline bool trust_near(const char *name, double expected, double measured, double tolerance)
{
    const bool right = fabs(measured - expected) <= tolerance;
    trust_line("near", name, "%.17g\t%.17g\t%.6g", expected, measured, tolerance);
    if (!right) {
        fprintf(stderr, "%s: %.17g, not %.17g\n", name, measured, expected);
    }
    return right;
}

// Something that mustn't exceed a bound. Whether it doesn't.
static inline bool trust_at_most(const char *name, double bound, double measured)
{
    const bool right = measured <= bound;
    trust_line("most", name, "%.17g\t%.17g", bound, measured);
    if (!right) {
        fprintf(stderr, "%s: %.9g, more than %.9g\n", name, measured, bound);
    }
    return right;
}

// Something of which none may happen in so many tries. Whether none did.
static inline bool trust_none(const char *name, long failures, long tries)
{
    trust_line("none", name, "%ld\t%ld", tries, failures);
    if (failures) {
        fprintf(stderr, "%s: %ld of %ld\n", name, failures, tries);
    }
    return failures == 0;
}

#endif
