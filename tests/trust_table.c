// One table of all lines that tests left (trust.h): `trust_table FOLDER [full]`. All statistical
// checks in it are one family: each at Šidák's level, so that all together go wrong by chance once
// in a thousand tables. "bias found": the smallest relative bias that a check finds in 99 of 100
// runs; of a density, its root mean square; of something that may not happen, how often it would.
// Fails where a check is wrong, where a reference check has no line, and in a full run where a
// check is weak: would miss a bias of 0.1 %, or what else its test allows.
#include "base/statistics.h"

#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REFERENCES = 27, FIELDS = 8, MOST_ROWS = 8192 };
static const double ALPHA = 1e-3;

typedef struct Row {
    char *field[FIELDS]; // kind, name, where, numbers
    int fields, order, reference;
} Row;

static Row rows[MOST_ROWS];
static int row_count;

static double number(const Row *row, int index)
{
    return index + 3 < row->fields ? strtod(row->field[index + 3], NULL) : NAN;
}

static bool is_kind(const Row *row, const char *kind)
{
    return strcmp(row->field[0], kind) == 0;
}

static bool is_statistical(const Row *row)
{
    return is_kind(row, "mean") || is_kind(row, "chi2");
}

static void read_line(const char *line)
{
    char *copy = strdup(line);
    if (!copy || row_count == MOST_ROWS) {
        fprintf(stderr, "too many lines\n");
        exit(2);
    }
    copy[strcspn(copy, "\n")] = 0;
    Row row = {.order = row_count};
    for (char *at = copy; at && row.fields < FIELDS;) {
        row.field[row.fields++] = at;
        at = strchr(at, '\t');
        if (at) {
            *at++ = 0;
        }
    }
    if (row.fields < 5) {
        fprintf(stderr, "not a line of a table: %s\n", line);
        exit(2);
    }
    const long reference = strtol(row.field[1], NULL, 10);
    char after = row.field[1][strspn(row.field[1], "0123456789")];
    row.reference = after == ' ' && reference >= 1 && reference <= REFERENCES ? (int)reference : 0;
    rows[row_count++] = row;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static void read_folder(const char *folder)
{
    static char *names[MOST_ROWS];
    static char line[4096], path[4096];
    int count = 0;
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory && (entry = readdir(directory)) != NULL;) {
        const char *dot = strrchr(entry->d_name, '.');
        if (dot && strcmp(dot, ".tsv") == 0 && count < MOST_ROWS) {
            names[count++] = strdup(entry->d_name);
        }
    }
    if (!directory || count == 0) {
        fprintf(stderr, "no lines in %s\n", folder);
        exit(2);
    }
    closedir(directory);
    qsort(names, (size_t)count, sizeof *names, by_name);
    for (int i = 0; i < count; ++i) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        FILE *file = fopen(path, "r");
        while (file && fgets(line, sizeof line, file)) {
            read_line(line);
        }
        if (file) {
            fclose(file);
        }
        free(names[i]);
    }
}

// Reference checks first, in their order; others as they came.
static int by_reference(const void *a, const void *b)
{
    const Row *x = a, *y = b;
    const int i = x->reference ? x->reference : REFERENCES + 1;
    const int j = y->reference ? y->reference : REFERENCES + 1;
    return i != j ? i - j : x->order - y->order;
}

// The root mean square of relative deviations of a density that Pearson's test finds in 99 of 100
// runs: N times its square is the noncentrality λ, with which chi-squared has the mean k + λ and
// the variance 2 k + 4 λ; the critical value by Wilson and Hilferty (1931).
static double chi2_bias(double level, double samples, double freedom)
{
    const double k = freedom, z = student_quantile(2 * level, 1e6);
    const double critical = k * pow(1 - 2 / (9 * k) + z * sqrt(2 / (9 * k)), 3);
    const double one_percent = student_quantile(0.02, 1e6);
    double lambda = 0;
    for (int i = 0; i < 100; ++i) {
        lambda = critical - k + one_percent * sqrt(2 * k + 4 * lambda);
    }
    return sqrt(lambda / samples);
}

// A row of the table; 'o' right, 'W' wrong, 'w' too weak.
static char print_row(const Row *row, double level, bool full)
{
    char expected[32], error[16] = "exact", z[16] = "", bias[24] = "", verdict = 'o';
    double measured = number(row, 1);
    snprintf(expected, sizeof expected, "%.9g", number(row, 0));
    if (is_kind(row, "mean")) {
        const double e = number(row, 2), freedom = number(row, 3);
        const double off = (measured - number(row, 0)) / e;
        const double critical = student_quantile(level, freedom);
        const double found =
            (critical + student_quantile(0.02, freedom)) * e / fabs(number(row, 0));
        snprintf(error, sizeof error, "%.2g", e);
        snprintf(z, sizeof z, "%.2f", off);
        snprintf(bias, sizeof bias, "%.4f%%", 100 * found);
        verdict = !(fabs(off) <= critical) ? 'W' : full && !(found <= number(row, 4)) ? 'w' : 'o';
    } else if (is_kind(row, "chi2")) {
        measured = number(row, 0);
        snprintf(expected, sizeof expected, "p > %.2g", level);
        snprintf(error, sizeof error, "chi2 %s", row->field[5]);
        snprintf(bias, sizeof bias, "%.3f%% rms",
                 100 * chi2_bias(level, number(row, 1), number(row, 2)));
        verdict = measured > level ? 'o' : 'W';
    } else if (is_kind(row, "near")) {
        const double scale = number(row, 0) == 0 ? 1 : fabs(number(row, 0));
        snprintf(bias, sizeof bias, "%.2g%%", 100 * number(row, 2) / scale);
        verdict = fabs(measured - number(row, 0)) <= number(row, 2) ? 'o' : 'W';
    } else if (is_kind(row, "most")) {
        snprintf(expected, sizeof expected, "<= %.6g", number(row, 0));
        verdict = measured <= number(row, 0) ? 'o' : 'W';
    } else { // none
        snprintf(expected, sizeof expected, "0 of %s", row->field[3]);
        snprintf(bias, sizeof bias, "1 in %.3g", number(row, 0) / -log(0.01));
        verdict = measured == 0 ? 'o' : 'W';
    }
    printf("%-52s %15s %13.8g %10s %7s %12s  %-5s  %s\n", row->field[1], expected, measured, error,
           z, bias,
           verdict == 'W'   ? "WRONG"
           : verdict == 'w' ? "weak"
                            : "ok",
           row->field[2]);
    return verdict;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        return 2;
    }
    const bool full = argc > 2 && strcmp(argv[2], "full") == 0;
    read_folder(argv[1]);
    qsort(rows, (size_t)row_count, sizeof *rows, by_reference);
    int family = 0, wrong = 0, weak = 0, missing = 0;
    bool found[REFERENCES + 1] = {false};
    for (int i = 0; i < row_count; ++i) {
        family += is_statistical(&rows[i]);
        found[rows[i].reference] = true;
    }
    const double level = sidak(ALPHA, family > 0 ? family : 1);
    printf("%-52s %15s %13s %10s %7s %12s  %-5s  %s\n", "check", "expected", "measured",
           "std.error", "z", "bias found", "", "where");
    for (int i = 0; i < row_count; ++i) {
        const char verdict = print_row(&rows[i], level, full);
        wrong += verdict == 'W';
        weak += verdict == 'w';
    }
    for (int i = 1; i <= REFERENCES; ++i) {
        if (!found[i]) {
            printf("%d: no check\n", i);
            ++missing;
        }
    }
    printf("%d checks, of which %d statistical; family-wise significance %g, each at %.3g; %d "
           "wrong, %d weak, %d of the %d reference checks missing\n",
           row_count, family, ALPHA, level, wrong, weak, missing, REFERENCES);
    return wrong + weak + missing ? 1 : 0;
}
