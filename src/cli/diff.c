#include "cli/diff.h"

#include "base/line_diff.h"

enum { CONTEXT = 3 };

// --- Writing -------------------------------------------------------------------------------------

typedef struct Hunk {
    int before, after;         // first lines
    int before_end, after_end; // behind the last ones
} Hunk;

// From the change at (before, after) on: what belongs to one hunk, without context around.
static Hunk find_hunk(const LineDiff *d, int before, int after)
{
    Hunk hunk = {before, after, before, after};
    for (int equal = 0; equal <= 2 * CONTEXT;) {
        if (before < d->before.count && d->removed[before]) {
            ++before;
        } else if (after < d->after.count && d->added[after]) {
            ++after;
        } else if (before < d->before.count && after < d->after.count) {
            ++before;
            ++after;
            ++equal;
            continue;
        } else {
            break;
        }
        equal = 0;
        hunk.before_end = before;
        hunk.after_end = after;
    }
    return hunk;
}

static void write_line(FILE *out, char mark, Str line)
{
    fputc(mark, out);
    fwrite(line.at, 1, line.length, out);
    if (line.length == 0 || line.at[line.length - 1] != '\n') {
        fputs("\n\\ No newline at end of file\n", out);
    }
}

static void write_range(FILE *out, char mark, int begin, int end)
{
    fprintf(out, " %c%d", mark, end > begin ? begin + 1 : begin);
    if (end - begin != 1) {
        fprintf(out, ",%d", end - begin);
    }
}

static void write_hunk(const LineDiff *d, Hunk hunk, FILE *out)
{
    int lead = hunk.before < CONTEXT ? hunk.before : CONTEXT;
    lead = hunk.after < lead ? hunk.after : lead;
    int left = d->before.count - hunk.before_end;
    int follow = left < CONTEXT ? left : CONTEXT;
    hunk.before -= lead;
    hunk.after -= lead;
    hunk.before_end += follow;
    hunk.after_end += follow;
    fputs("@@", out);
    write_range(out, '-', hunk.before, hunk.before_end);
    write_range(out, '+', hunk.after, hunk.after_end);
    fputs(" @@\n", out);
    for (int i = hunk.before, k = hunk.after; i < hunk.before_end || k < hunk.after_end;) {
        if (i < hunk.before_end && d->removed[i]) {
            write_line(out, '-', d->before.items[i++]);
        } else if (k < hunk.after_end && d->added[k]) {
            write_line(out, '+', d->after.items[k++]);
        } else {
            write_line(out, ' ', d->before.items[i++]);
            ++k;
        }
    }
}

static void write_hunks(const LineDiff *d, const char *name, FILE *out)
{
    fprintf(out, "--- %s\n+++ %s\n", name, name);
    for (int i = 0, k = 0; i < d->before.count || k < d->after.count;) {
        if ((i < d->before.count && d->removed[i]) || (k < d->after.count && d->added[k])) {
            Hunk hunk = find_hunk(d, i, k);
            write_hunk(d, hunk, out);
            i = hunk.before_end;
            k = hunk.after_end;
        } else {
            ++i;
            ++k;
        }
    }
}

bool diff_write(Str before, Str after, const char *name, FILE *out)
{
    if (str_equal(before, after)) {
        return true;
    }
    LineDiff diff;
    bool good = line_diff(&diff, before, after);
    if (good) {
        write_hunks(&diff, name, out);
    }
    line_diff_free(&diff);
    return good;
}
