#include "base/line_diff.h"

enum {
    MOST_EDITS = 2000, // beyond them one large change is given instead of the fewest small ones
};

// Eugene W. Myers, "An O(ND) LineDiffence Algorithm and Its Variations" (1986), the greedy form:
// the farthest line reached on each diagonal with d edits, for d = 0, 1, 2, …; all are kept to find
// the way back.
static bool split(Str text, DiffLines *lines)
{
    size_t count = 0;
    for (size_t i = 0; i < text.length; ++i) {
        count += text.at[i] == '\n' || i + 1 == text.length;
    }
    *lines = (DiffLines){mem_alloc(count + 1, sizeof(Str)), 0};
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

static void trim(LineDiff *d)
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
static int *reached(const LineDiff *differ, int d, int k)
{
    return &differ->reached.items[(size_t)d * (size_t)d + (size_t)(k + d)];
}

// Whether the last of d edits that led to diagonal k added a line (else it removed one).
static bool came_by_adding(const LineDiff *differ, int d, int k)
{
    return k == -d || (k != d && *reached(differ, d - 1, k - 1) < *reached(differ, d - 1, k + 1));
}

// The number of edits; -1 where they are too many, -2 without memory.
static int find_edits(LineDiff *differ)
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

static void mark_edits(LineDiff *differ, int edits)
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

// --- The whole -----------------------------------------------------------------------------------

bool line_diff(LineDiff *diff, Str before, Str after)
{
    *diff = (LineDiff){0};
    if (!split(before, &diff->before) || !split(after, &diff->after)) {
        return false;
    }
    diff->removed = mem_alloc_zeroed((size_t)diff->before.count + 1, 1);
    diff->added = mem_alloc_zeroed((size_t)diff->after.count + 1, 1);
    if (!diff->removed || !diff->added) {
        return false;
    }
    trim(diff);
    int edits = find_edits(diff);
    if (edits != -2) {
        mark_edits(diff, edits);
    }
    return edits != -2;
}

void line_diff_free(LineDiff *diff)
{
    mem_free(diff->before.items);
    mem_free(diff->after.items);
    mem_free(diff->removed);
    mem_free(diff->added);
    array_free(&diff->reached);
    *diff = (LineDiff){0};
}

bool line_diff_next(const LineDiff *diff, int *before, int *after, LineChange *change)
{
    int i = *before, k = *after;
    while (i < diff->before.count && k < diff->after.count && !diff->removed[i] &&
           !diff->added[k]) {
        ++i;
        ++k;
    }
    *change = (LineChange){i, i, k, k};
    while (i < diff->before.count && diff->removed[i]) {
        ++i;
    }
    while (k < diff->after.count && diff->added[k]) {
        ++k;
    }
    change->before_end = *before = i;
    change->after_end = *after = k;
    return i > change->before || k > change->after;
}
