#include "cli/diff.h"

#include "base/array.h"

enum {
    CONTEXT = 3,
    MOST_EDITS = 2000, // beyond them one large change is shown instead of the fewest small ones
};

typedef struct Lines {
    Str *items; // with their ends
    int count;
} Lines;

// Eugene W. Myers, "An O(ND) Difference Algorithm and Its Variations" (1986), the greedy form: the
// farthest line reached on each diagonal with d edits, for d = 0, 1, 2, …; all are kept to find the
// way back.
typedef struct Differ {
    Lines before, after;
    int head, tail;        // equal lines at both ends
    ARRAY(int) reached;    // 2 d + 1 of them for each d
    bool *removed, *added; // of each line
} Differ;

static bool split(Str text, Lines *lines)
{
    size_t count = 0;
    for (size_t i = 0; i < text.length; ++i) {
        count += text.at[i] == '\n' || i + 1 == text.length;
    }
    *lines = (Lines){mem_alloc(count + 1, sizeof(Str)), 0};
    if (!lines->items || count > INT32_MAX / 4) {
        return false;
    }
    for (const char *at = text.at, *end = at + text.length; at < end;) {
        const char *line_end = memchr(at, '\n', (size_t)(end - at));
        size_t length = (size_t)(line_end ? line_end + 1 - at : end - at);
        lines->items[lines->count++] = (Str){at, length};
        at += length;
    }
    return true;
}

static void trim(Differ *d)
{
    int most = d->before.count < d->after.count ? d->before.count : d->after.count;
    while (d->head < most && str_equal(d->before.items[d->head], d->after.items[d->head])) {
        ++d->head;
    }
    while (d->tail < most - d->head && str_equal(d->before.items[d->before.count - 1 - d->tail],
                                                 d->after.items[d->after.count - 1 - d->tail])) {
        ++d->tail;
    }
}

// The line of `before` reached with d edits on diagonal k (line of before - line of after).
static int *reached(const Differ *differ, int d, int k)
{
    return &differ->reached.items[(size_t)d * (size_t)d + (size_t)(k + d)];
}

// Whether the last of d edits that led to diagonal k added a line (else it removed one).
static bool came_by_adding(const Differ *differ, int d, int k)
{
    return k == -d || (k != d && *reached(differ, d - 1, k - 1) < *reached(differ, d - 1, k + 1));
}

// The number of edits; -1 where they are too many, -2 without memory.
static int find_edits(Differ *differ)
{
    int rows = differ->before.count - differ->head - differ->tail;
    int columns = differ->after.count - differ->head - differ->tail;
    const Str *before = differ->before.items + differ->head;
    const Str *after = differ->after.items + differ->head;
    for (int d = 0; d <= MOST_EDITS; ++d) {
        if (!array_reserve(&differ->reached, 2 * d + 1)) {
            return -2;
        }
        differ->reached.count += 2 * (size_t)d + 1;
        for (int k = -d; k <= d; k += 2) {
            int x = d == 0                         ? 0
                    : came_by_adding(differ, d, k) ? *reached(differ, d - 1, k + 1)
                                                   : *reached(differ, d - 1, k - 1) + 1;
            while (x < rows && x - k < columns && x - k >= 0 &&
                   str_equal(before[x], after[x - k])) {
                ++x;
            }
            *reached(differ, d, k) = x;
            if (k == rows - columns && x >= rows) {
                return d;
            }
        }
    }
    return -1;
}

static void mark_edits(Differ *differ, int edits)
{
    int rows = differ->before.count - differ->head - differ->tail;
    int columns = differ->after.count - differ->head - differ->tail;
    if (edits < 0) {
        memset(differ->removed + differ->head, true, (size_t)rows);
        memset(differ->added + differ->head, true, (size_t)columns);
        return;
    }
    for (int d = edits, k = rows - columns; d > 0; --d) {
        bool adding = came_by_adding(differ, d, k);
        k += adding ? 1 : -1;
        int x = *reached(differ, d - 1, k);
        if (adding) {
            differ->added[differ->head + x - k] = true;
        } else {
            differ->removed[differ->head + x] = true;
        }
    }
}

// --- Writing -------------------------------------------------------------------------------------

typedef struct Hunk {
    int before, after;         // first lines
    int before_end, after_end; // behind the last ones
} Hunk;

// From the change at (before, after) on: what belongs to one hunk, without context around.
static Hunk find_hunk(const Differ *d, int before, int after)
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

static void write_hunk(const Differ *d, Hunk hunk, FILE *out)
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

static void write_hunks(const Differ *d, const char *name, FILE *out)
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
    Differ differ = {0};
    int edits = -2;
    if (split(before, &differ.before) && split(after, &differ.after)) {
        differ.removed = mem_alloc_zeroed((size_t)differ.before.count + 1, 1);
        differ.added = mem_alloc_zeroed((size_t)differ.after.count + 1, 1);
    }
    if (differ.removed && differ.added) {
        trim(&differ);
        edits = find_edits(&differ);
    }
    if (edits != -2) {
        mark_edits(&differ, edits);
        write_hunks(&differ, name, out);
    }
    mem_free(differ.before.items);
    mem_free(differ.after.items);
    mem_free(differ.removed);
    mem_free(differ.added);
    array_free(&differ.reached);
    return edits != -2;
}
