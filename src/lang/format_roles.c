#include "lang/format_internal.h"

// --- Roles ---------------------------------------------------------------------------------------

// The token can end an operand, so that a minus behind it subtracts and a bracket calls or indexes.
static bool ends_operand(const Formatter *f, uint32_t i)
{
    if (i == ATOM_NONE) {
        return false;
    }
    const Atom *atom = &f->atoms.items[i];
    switch (atom->kind) {
    case TOKEN_NAME:
        return !atom->of;
    case TOKEN_NUMBER:
    case TOKEN_STRING:
    case TOKEN_COLOR:
    case TOKEN_TRUE:
    case TOKEN_FALSE:
    case TOKEN_RIGHT_BRACE:
    case TOKEN_RIGHT_BRACKET:
        return true;
    case TOKEN_RIGHT_PAREN:
        return !f->atoms.items[atom->match].condition;
    default:
        return false;
    }
}

static bool may_begin_item(const Atom *atom)
{
    return atom->kind == TOKEN_NAME || atom->kind == TOKEN_LET || atom->kind == TOKEN_FN ||
           atom->kind == TOKEN_FOR || atom->kind == TOKEN_IF || atom->kind == TOKEN_EXPECT ||
           atom->kind == TOKEN_PARAM || atom->kind == TOKEN_IMPORT;
}

// Whether `of` at atom i belongs to a `within` before it in the same element.
static bool is_of(const Formatter *f, uint32_t i)
{
    const Atom *atom = &f->atoms.items[i];
    if (atom->kind != TOKEN_NAME ||
        !str_equal((Str){f->text + atom->begin, atom->end - atom->begin}, STR("of"))) {
        return false;
    }
    for (uint32_t k = i; k-- > 0;) {
        const Atom *before = &f->atoms.items[k];
        if (atom_closes(before)) {
            k = before->match;
            before = &f->atoms.items[k];
        } else if (atom_opens(before) || before->of) {
            return false;
        }
        if (before->kind == TOKEN_WITHIN || before->element) {
            return before->kind == TOKEN_WITHIN;
        }
    }
    return false;
}

static bool is_percent(const Formatter *f, uint32_t i)
{
    uint32_t next = format_token_from(f, i + 1);
    return next < f->atoms.count && is_of(f, next);
}

static bool is_binary(const Formatter *f, uint32_t previous, const Atom *atom)
{
    switch (atom->kind) {
    case TOKEN_PERCENT:
        return !is_percent(f, (uint32_t)(atom - f->atoms.items));
    case TOKEN_MINUS:
        return ends_operand(f, previous) && !f->atoms.items[previous].comma;
    case TOKEN_PLUS:
    case TOKEN_STAR:
    case TOKEN_SLASH:
    case TOKEN_CARET:
    case TOKEN_EQUAL:
    case TOKEN_NOT_EQUAL:
    case TOKEN_LESS:
    case TOKEN_LESS_EQUAL:
    case TOKEN_GREATER:
    case TOKEN_GREATER_EQUAL:
    case TOKEN_AND:
    case TOKEN_OR:
    case TOKEN_RANGE:
    case TOKEN_RANGE_BELOW:
        return true;
    default:
        return false;
    }
}

static bool begins_element(const Formatter *f, uint32_t previous, const Atom *atom)
{
    if (previous == ATOM_NONE || previous == atom->group || atom_closes(atom) || atom->of) {
        return false;
    }
    return format_is_brace(f, atom->group) ? may_begin_item(atom) && ends_operand(f, previous)
                                           : f->atoms.items[previous].comma;
}

// The `}` of a block that is a branch of a statement: `else` belongs on its line.
static bool ends_branch(const Formatter *f, uint32_t i)
{
    const Atom *atom = &f->atoms.items[i];
    if (atom->kind != TOKEN_RIGHT_BRACE) {
        return false;
    }
    uint32_t before = atom->match;
    do {
        --before; // a brace never stands first
    } while (atom_is_comment(&f->atoms.items[before]));
    return f->atoms.items[before].kind == TOKEN_RIGHT_PAREN && !ends_operand(f, before);
}

// Whether a line may end between two tokens inside of an element.
static GapClass inner_gap(const Formatter *f, uint32_t previous, const Atom *atom)
{
    const Atom *before = &f->atoms.items[previous];
    bool keep = false;
    if (atom->kind == TOKEN_ELSE) {
        keep = !ends_branch(f, previous);
    } else if (atom->kind == TOKEN_IN) {
        keep = atom->group == ATOM_NONE || !f->atoms.items[atom->group].condition;
    } else if (before->kind == TOKEN_ELSE) {
        keep = atom->kind != TOKEN_LEFT_BRACE && atom->kind != TOKEN_IF;
    } else if (atom->kind == TOKEN_WITHIN || atom->of) {
        keep = true;
    } else if (before->kind == TOKEN_RIGHT_PAREN) {
        keep = atom->binary || atom->kind == TOKEN_WITH ||
               (!ends_operand(f, previous) && atom->kind != TOKEN_LEFT_BRACE);
    } else {
        keep = atom->binary || before->binary || before->kind == TOKEN_ASSIGN ||
               before->kind == TOKEN_COLON || atom->kind == TOKEN_WITH ||
               (atom->kind == TOKEN_STRING && ends_operand(f, previous));
    }
    return keep ? GAP_KEEP : GAP_GLUE;
}

static GapClass gap_class(const Formatter *f, uint32_t previous, const Atom *atom)
{
    if (previous == ATOM_NONE || atom->element) {
        return GAP_ELEMENT;
    }
    if (atom_closes(atom)) {
        return previous == atom->match ? GAP_EMPTY : GAP_CLOSE;
    }
    return atom_opens(&f->atoms.items[previous]) ? GAP_OPEN : inner_gap(f, previous, atom);
}

// --- Spaces --------------------------------------------------------------------------------------

static bool is_arithmetic(const Atom *atom)
{
    return atom->binary &&
           (atom->kind == TOKEN_PLUS || atom->kind == TOKEN_MINUS || atom->kind == TOKEN_STAR ||
            atom->kind == TOKEN_SLASH || atom->kind == TOKEN_PERCENT || atom->kind == TOKEN_CARET);
}

// Operands of a range end at these.
static bool ends_sum(const Atom *atom)
{
    return (atom->binary && !is_arithmetic(atom)) || atom->kind == TOKEN_ASSIGN ||
           atom->kind == TOKEN_COLON || atom->kind == TOKEN_NOT || atom->kind == TOKEN_IN ||
           atom->kind == TOKEN_IF || atom->kind == TOKEN_ELSE || atom->kind == TOKEN_FOR ||
           atom->kind == TOKEN_EXPECT || atom->kind == TOKEN_WITHIN || atom->of ||
           atom->kind == TOKEN_LET || atom->kind == TOKEN_PARAM || atom->kind == TOKEN_FN;
}

// An end of the range is a sum, product or power.
static bool has_long_ends(const Formatter *f, uint32_t i)
{
    for (uint32_t k = i; k-- > 0;) {
        const Atom *atom = &f->atoms.items[k];
        if (atom_closes(atom) && ends_operand(f, k)) {
            k = atom->match;
            atom = &f->atoms.items[k];
        } else if (atom_opens(atom) || atom_closes(atom) || ends_sum(atom)) {
            break;
        }
        if (is_arithmetic(atom)) {
            return true;
        }
        if (atom->element) {
            break;
        }
    }
    for (uint32_t k = i + 1; k < f->atoms.count; ++k) {
        const Atom *atom = &f->atoms.items[k];
        if (atom->element || atom_closes(atom) || ends_sum(atom)) {
            break;
        }
        if (is_arithmetic(atom)) {
            return true;
        }
        k = atom_opens(atom) ? atom->match : k;
    }
    return false;
}

static bool is_range(const Atom *atom)
{
    return atom->kind == TOKEN_RANGE || atom->kind == TOKEN_RANGE_BELOW;
}

// A space stands between two neighbours on a line. previous: the last token.
static bool wants_space(const Formatter *f, uint32_t i, uint32_t previous)
{
    const Atom *before = &f->atoms.items[i - 1], *atom = &f->atoms.items[i];
    if (before->kind == TOKEN_LEFT_PAREN || before->kind == TOKEN_LEFT_BRACKET ||
        atom->kind == TOKEN_RIGHT_PAREN || atom->kind == TOKEN_RIGHT_BRACKET) {
        return false;
    }
    if (atom_is_comment(before) || atom_is_comment(atom)) {
        return true;
    }
    if (atom->kind == TOKEN_LEFT_PAREN || atom->kind == TOKEN_LEFT_BRACKET) {
        if (before->unary || (is_range(before) && !before->space)) {
            return false;
        }
        return atom->element || !(ends_operand(f, previous) || before->kind == TOKEN_FN);
    }
    if (is_range(atom)) {
        return has_long_ends(f, i);
    }
    if (atom->kind == TOKEN_DOT && before->kind == TOKEN_NUMBER) {
        return atom_is_comment(atom + 1); // `1./**/x` would be a number with a digit missing
    }
    if (is_range(before)) {
        return has_long_ends(f, i - 1);
    }
    return !(before->unary || (atom->kind == TOKEN_PERCENT && !atom->binary) ||
             atom->kind == TOKEN_COLON || atom->kind == TOKEN_DOT || before->kind == TOKEN_DOT ||
             (before->kind == TOKEN_LEFT_BRACE && atom->kind == TOKEN_RIGHT_BRACE));
}

// --- Together ------------------------------------------------------------------------------------

static void find_groups(Formatter *f)
{
    uint32_t group = ATOM_NONE, previous = ATOM_NONE;
    for (uint32_t i = 0; i < f->atoms.count; ++i) {
        Atom *atom = &f->atoms.items[i];
        if (atom_closes(atom) && group != ATOM_NONE) {
            atom->match = group;
            f->atoms.items[group].match = i;
            group = f->atoms.items[group].group;
        }
        atom->group = group;
        if (atom_opens(atom)) {
            group = i;
        }
        if (atom->kind == TOKEN_LEFT_PAREN && previous != ATOM_NONE) {
            uint8_t kind = f->atoms.items[previous].kind;
            atom->condition = kind == TOKEN_IF || kind == TOKEN_FOR;
        }
        previous = atom_is_comment(atom) ? previous : i;
    }
}

static void find_elements(Formatter *f)
{
    uint32_t previous = ATOM_NONE;
    for (uint32_t i = 0; i < f->atoms.count; ++i) {
        Atom *atom = &f->atoms.items[i];
        if (atom_is_comment(atom)) {
            continue;
        }
        atom->of = is_of(f, i);
        atom->binary = is_binary(f, previous, atom);
        atom->unary = atom->kind == TOKEN_MINUS && !atom->binary;
        atom->element = begins_element(f, previous, atom);
        if (atom->element && atom->group != ATOM_NONE) {
            f->atoms.items[atom->group].several = true;
        }
        atom->gap_class = (uint8_t)gap_class(f, previous, atom);
        for (uint32_t k = i; k-- > 0 && atom_is_comment(&f->atoms.items[k]);) {
            f->atoms.items[k].gap_class = atom->gap_class;
        }
        previous = i;
    }
}

void format_roles(Formatter *f)
{
    find_groups(f);
    find_elements(f);
    uint32_t previous = ATOM_NONE;
    for (uint32_t i = 0; i < f->atoms.count; ++i) {
        Atom *atom = &f->atoms.items[i];
        atom->space = i > 0 && wants_space(f, i, previous);
        previous = atom_is_comment(atom) ? previous : i;
    }
}

// --- Line ends -----------------------------------------------------------------------------------

void format_add_break(Formatter *f, uint32_t i)
{
    if (!f->atoms.items[i].breaks) {
        f->atoms.items[i].breaks = 1;
    }
    for (uint32_t group = format_place(f, i); group != ATOM_NONE && !f->atoms.items[group].inside;
         group = f->atoms.items[group].group) {
        f->atoms.items[group].inside = true;
    }
}

bool format_break_gap(Formatter *f, uint32_t i)
{
    uint32_t next = format_token_from(f, i + 1);
    for (uint32_t k = i + 1; k <= next && k < f->atoms.count; ++k) {
        if (f->atoms.items[k].breaks) {
            return false;
        }
    }
    format_add_break(f, i + 1);
    return true;
}

void format_break_group(Formatter *f, uint32_t opener, bool each_element)
{
    uint32_t close = f->atoms.items[opener].match;
    f->atoms.items[opener].broken = true;
    format_break_gap(f, opener);
    uint32_t previous = opener;
    for (uint32_t i = opener + 1; each_element && i < close; ++i) {
        const Atom *atom = &f->atoms.items[i];
        if (atom_is_comment(atom)) {
            continue;
        }
        if (atom->element) {
            format_break_gap(f, previous);
        }
        i = atom_opens(atom) ? atom->match : i;
        previous = i;
    }
    format_add_break(f, close);
}

static uint8_t author_breaks(const Formatter *f, uint32_t i)
{
    const Atom *atom = &f->atoms.items[i], *before = &f->atoms.items[i - 1];
    bool comment = atom_is_comment(atom) || atom_is_comment(before);
    bool inner = atom->gap_class == GAP_KEEP || atom->gap_class == GAP_GLUE;
    bool at_edge = atom_opens(before) || atom_closes(atom);
    uint8_t most = inner || at_edge ? 1 : 2;
    if (!comment && (atom->gap_class == GAP_EMPTY || atom->gap_class == GAP_GLUE)) {
        most = 0;
    }
    uint8_t breaks = atom->newlines < most ? atom->newlines : most;
    return before->kind == ATOM_LINE_COMMENT && !breaks ? 1 : breaks;
}

void format_breaks(Formatter *f)
{
    for (uint32_t i = 1; i < f->atoms.count; ++i) {
        Atom *atom = &f->atoms.items[i];
        atom->breaks = author_breaks(f, i);
        if (atom->breaks) {
            uint32_t place = format_place(f, i);
            if (place != ATOM_NONE && atom->gap_class != GAP_KEEP && atom->gap_class != GAP_GLUE) {
                f->atoms.items[place].broken = true;
            }
            format_add_break(f, i);
        }
    }
    // From the inside outwards, since breaking a brace breaks those around it.
    for (uint32_t i = (uint32_t)f->atoms.count; i-- > 0;) {
        const Atom *atom = &f->atoms.items[i];
        if (atom_opens(atom) && atom->broken) {
            format_break_group(f, i, false);
        } else if (atom->kind == TOKEN_LEFT_BRACE && atom->inside) {
            format_break_group(f, i, true);
        }
    }
}
