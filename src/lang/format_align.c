#include "lang/format_internal.h"

#include <stdlib.h>

// Atoms of several lines that the author put into one column, as a set with one representative.
typedef struct Column {
    uint32_t atom, line;
    uint32_t set;    // index of another member, nearer to the representative
    uint32_t column; // in the source
} Column;

// A comment at the end of a line.
typedef struct EndComment {
    uint32_t paragraph, column; // of the source
    uint32_t index;             // among the columns
} EndComment;

typedef struct Aligner {
    Formatter *f;
    ARRAY(Column) columns; // the atoms that could be aligned, line by line
    ARRAY(EndComment) comments;
    uint32_t paragraph; // comments are aligned inside of it, beyond neighbouring lines
} Aligner;

static uint32_t find_set(Aligner *a, uint32_t i)
{
    while (a->columns.items[i].set != i) {
        a->columns.items[i].set = a->columns.items[a->columns.items[i].set].set;
        i = a->columns.items[i].set;
    }
    return i;
}

static bool is_wide(const Aligner *a, uint32_t i)
{
    return a->f->atoms.items[a->columns.items[i].atom].wide;
}

static void link(Aligner *a, uint32_t i, uint32_t k)
{
    if (is_wide(a, i) || is_wide(a, k)) {
        uint32_t one = find_set(a, i), other = find_set(a, k);
        a->columns.items[one > other ? one : other].set = one > other ? other : one;
    }
}

// What stands before an atom, as far as the role of the atom goes.
static int role_before(const Formatter *f, uint32_t i)
{
    return f->atoms.items[i].element ? -1 : f->atoms.items[i - 1].kind;
}

static bool same_role(const Formatter *f, uint32_t i, uint32_t k)
{
    return f->atoms.items[i].kind == f->atoms.items[k].kind ||
           role_before(f, i) == role_before(f, k);
}

// The atoms of a line that can be aligned. Columns of the source say nothing behind a line end that
// was taken out.
static bool collect(Aligner *a, uint32_t line_index)
{
    const Formatter *f = a->f;
    const Line *line = &f->lines.items[line_index];
    for (uint32_t i = line->begin + 1; i < line->end; ++i) {
        const Atom *atom = &f->atoms.items[i];
        if (atom->newlines || atom_is_long(f, atom - 1)) {
            break;
        }
        bool open = atom_opens(atom) && atom->broken;
        if (!atom->space || open || (atom_is_comment(atom) && i + 1 < line->end)) {
            continue;
        }
        uint32_t index = (uint32_t)a->columns.count;
        Column column = {.atom = i, .line = line_index, .set = index, .column = atom->column};
        if (!array_push(&a->columns, column)) {
            return false;
        }
    }
    return true;
}

static void link_lines(Aligner *a, uint32_t above, uint32_t begin, uint32_t end)
{
    const Column *columns = a->columns.items;
    for (uint32_t i = above, k = begin; i < begin && k < end;) {
        if (columns[i].column < columns[k].column) {
            ++i;
        } else if (columns[i].column > columns[k].column) {
            ++k;
        } else {
            if (same_role(a->f, columns[i].atom, columns[k].atom)) {
                link(a, i, k);
            }
            ++i;
            ++k;
        }
    }
}

static bool add_comment(Aligner *a, uint32_t i)
{
    const Column *column = &a->columns.items[i];
    EndComment comment = {a->paragraph, column->column, i};
    return !atom_is_comment(&a->f->atoms.items[column->atom]) || array_push(&a->comments, comment);
}

// By the first of three numbers that differs; the last ones always do.
static int compare_keys(const uint32_t a[3], const uint32_t b[3])
{
    int i = 0;
    while (i < 2 && a[i] == b[i]) {
        ++i;
    }
    return a[i] < b[i] ? -1 : 1;
}

static int compare_comments(const void *left, const void *right)
{
    const EndComment *a = left, *b = right;
    return compare_keys((uint32_t[]){a->paragraph, a->column, a->index},
                        (uint32_t[]){b->paragraph, b->column, b->index});
}

// Each comment with the next one in its paragraph that stands in the same column.
static void link_comments(Aligner *a)
{
    EndComment *comments = a->comments.items;
    if (a->comments.count > 0) {
        qsort(comments, a->comments.count, sizeof *comments, compare_comments);
    }
    for (size_t i = 1; i < a->comments.count; ++i) {
        if (comments[i - 1].paragraph == comments[i].paragraph &&
            comments[i - 1].column == comments[i].column) {
            link(a, comments[i - 1].index, comments[i].index);
        }
    }
}

static bool link_all(Aligner *a)
{
    uint32_t above = 0;
    for (uint32_t i = 0; i < a->f->lines.count; ++i) {
        const Line *line = &a->f->lines.items[i];
        uint32_t begin = (uint32_t)a->columns.count;
        if (!collect(a, i)) {
            return false;
        }
        uint32_t end = (uint32_t)a->columns.count;
        if (line->blank && line->indent == 0) {
            ++a->paragraph;
        }
        if (i > 0 && !line->blank && line[-1].indent == line->indent) {
            link_lines(a, above, begin, end);
        }
        if (end > begin && !add_comment(a, end - 1)) {
            return false;
        }
        above = begin;
    }
    link_comments(a);
    return true;
}

static int compare_columns(const void *left, const void *right)
{
    const Column *a = left, *b = right;
    return compare_keys((uint32_t[]){a->column, a->set, a->atom},
                        (uint32_t[]){b->column, b->set, b->atom});
}

// How far a line has been laid out.
typedef struct Cursor {
    uint32_t atom, column; // the column behind the atom and its comma
} Cursor;

// The column at which the atom stands without a pad.
static uint32_t natural_column(const Formatter *f, Cursor *cursor, uint32_t atom)
{
    while (cursor->atom + 1 < atom) {
        const Atom *next = &f->atoms.items[++cursor->atom];
        cursor->column += (uint32_t)next->space + next->pad + next->width;
        cursor->column += !atom_is_comment(next) && format_has_comma(f, cursor->atom);
    }
    return cursor->column + f->atoms.items[atom].space;
}

static void place(Aligner *a, Cursor *cursors, const Column *first, const Column *last)
{
    Formatter *f = a->f;
    uint32_t column = 0;
    for (const Column *at = first; at < last; ++at) {
        uint32_t natural = natural_column(f, &cursors[at->line], at->atom);
        column = natural > column ? natural : column;
    }
    for (const Column *at = first; at < last; ++at) {
        f->atoms.items[at->atom].pad = column - natural_column(f, &cursors[at->line], at->atom);
    }
}

static bool place_all(Aligner *a)
{
    const Formatter *f = a->f;
    for (uint32_t i = 0; i < a->columns.count; ++i) {
        a->columns.items[i].set = find_set(a, i);
    }
    Cursor *cursors = mem_alloc(f->lines.count, sizeof *cursors);
    if (!cursors) {
        return false;
    }
    for (uint32_t i = 0; i < f->lines.count; ++i) {
        const Line *line = &f->lines.items[i];
        const Atom *atom = &f->atoms.items[line->begin];
        cursors[i] = (Cursor){line->begin, line->indent + atom->width};
        cursors[i].column += !atom_is_comment(atom) && format_has_comma(f, line->begin);
    }
    qsort(a->columns.items, a->columns.count, sizeof *a->columns.items, compare_columns);
    const Column *end = a->columns.items + a->columns.count;
    for (const Column *first = a->columns.items, *last; first < end; first = last) {
        for (last = first + 1; last < end && last->set == first->set; ++last) {
        }
        place(a, cursors, first, last);
    }
    mem_free(cursors);
    return true;
}

bool format_align(Formatter *f)
{
    Aligner a = {.f = f};
    bool good = link_all(&a) && (a.columns.count == 0 || place_all(&a));
    array_free(&a.columns);
    array_free(&a.comments);
    return good;
}
