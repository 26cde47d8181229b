#include "lang/format_internal.h"

static uint32_t content_of(const Formatter *f, uint32_t group)
{
    return group == ATOM_NONE ? 0 : f->atoms.items[group].content;
}

// Where the line that begins with atom i begins.
static uint32_t indent_of(const Formatter *f, uint32_t i)
{
    const Atom *atom = &f->atoms.items[i];
    if (atom_closes(atom)) {
        return f->atoms.items[atom->match].line_indent;
    }
    bool inner = atom->gap_class == GAP_KEEP || atom->gap_class == GAP_GLUE;
    return content_of(f, atom->group) + (inner ? FORMAT_INDENT : 0);
}

// The first atom behind `begin` that begins a line.
static uint32_t line_end(const Formatter *f, uint32_t begin)
{
    uint32_t i = begin + 1;
    while (i < f->atoms.count && !f->atoms.items[i].breaks) {
        ++i;
    }
    return i;
}

// The first token of the line that ends beyond the last column; ATOM_NONE where all fit.
static uint32_t find_overflow(const Formatter *f, uint32_t begin, uint32_t indent)
{
    uint32_t column = indent;
    for (uint32_t i = begin; i < f->atoms.count; ++i) {
        const Atom *atom = &f->atoms.items[i];
        if (i > begin && atom->breaks) {
            break;
        }
        column += i > begin && atom->space;
        column = atom_is_long(f, atom) ? atom->tail : column + atom->width;
        if (!atom_is_comment(atom)) {
            column += format_has_comma(f, i);
            if (column > FORMAT_COLUMNS) {
                return i;
            }
        }
    }
    return ATOM_NONE;
}

// The last token before atom i, which is not the first one.
static uint32_t token_before(const Formatter *f, uint32_t i)
{
    do {
        --i;
    } while (atom_is_comment(&f->atoms.items[i]));
    return i;
}

// The elements that share the line get lines of their own: in braces all, else those that don't
// fit. False where no line end was added, so that nothing is tried for ever.
static bool break_row(Formatter *f, uint32_t begin, uint32_t overflow)
{
    uint32_t last = ATOM_NONE;
    bool any = false;
    for (uint32_t i = begin + 1; i < f->atoms.count && !f->atoms.items[i].breaks; ++i) {
        const Atom *atom = &f->atoms.items[i];
        // A gap that begins before the line, at a comment, has its line end already.
        if (atom->element && format_is_broken(f, atom->group) && token_before(f, i) >= begin) {
            if (!format_is_brace(f, atom->group)) {
                if (i > overflow) {
                    break;
                }
                last = i;
            } else {
                any |= format_break_gap(f, token_before(f, i));
            }
        }
        if (i > overflow && last != ATOM_NONE) {
            break;
        }
        i = atom_opens(atom) && !atom->inside ? atom->match : i;
    }
    if (last != ATOM_NONE) {
        any |= format_break_gap(f, token_before(f, last));
    }
    return any;
}

// Breaks the outermost brace that is too long; else the outermost other bracket that is.
static bool break_bracket(Formatter *f, uint32_t begin, uint32_t overflow)
{
    uint32_t bracket = ATOM_NONE;
    for (uint32_t i = begin; i <= overflow; ++i) {
        const Atom *atom = &f->atoms.items[i];
        if (!atom_opens(atom) || atom->broken || atom->match < overflow) {
            continue;
        }
        if (atom->kind == TOKEN_LEFT_BRACE && atom->match > i + 1) {
            format_break_group(f, i, true);
            return true;
        }
        if (bracket == ATOM_NONE && atom->several) {
            bracket = i;
        }
    }
    if (bracket != ATOM_NONE) {
        format_break_group(f, bracket, false);
    }
    return bracket != ATOM_NONE;
}

static bool end_line(Formatter *f, uint32_t begin, uint32_t indent)
{
    uint32_t end = line_end(f, begin);
    for (uint32_t i = begin; i < end; ++i) {
        Atom *atom = &f->atoms.items[i];
        if (atom_opens(atom)) {
            atom->line_indent = indent;
            atom->content = atom->broken ? indent + FORMAT_INDENT : content_of(f, atom->group);
        }
    }
    Line line = {begin, end, indent, f->atoms.items[begin].breaks == 2};
    return array_push(&f->lines, line);
}

bool format_lines(Formatter *f)
{
    for (uint32_t begin = 0; begin < f->atoms.count;) {
        uint32_t indent = indent_of(f, begin), overflow;
        do {
            overflow = find_overflow(f, begin, indent);
        } while (overflow != ATOM_NONE &&
                 (break_row(f, begin, overflow) || break_bracket(f, begin, overflow)));
        if (!end_line(f, begin, indent)) {
            return false;
        }
        begin = f->lines.items[f->lines.count - 1].end;
    }
    return true;
}
