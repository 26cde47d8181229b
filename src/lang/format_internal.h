// What the formatter's files share: a text as a row of atoms (tokens and comments, without commas),
// which one step after another decides on.
#ifndef LANG_FORMAT_INTERNAL_H
#define LANG_FORMAT_INTERNAL_H

#include "lang/format.h"
#include "lang/lexer.h"

enum {
    ATOM_LINE_COMMENT = TOKEN_KIND_COUNT,
    ATOM_BLOCK_COMMENT,
};
#define ATOM_NONE UINT32_MAX // no atom; as a group: the file

// What lies between a token and the next.
typedef enum GapClass {
    GAP_ELEMENT, // the end of an element (field, item, argument, …) and the next one
    GAP_OPEN,    // an opening bracket and what it holds
    GAP_CLOSE,   // the last of what a bracket holds, and its end
    GAP_EMPTY,   // both ends of a bracket
    GAP_KEEP,    // inside of an element, where a line may end
    GAP_GLUE,    // where it may not
} GapClass;

typedef struct Atom {
    uint32_t begin, end;  // bytes of the source
    uint32_t column;      // characters before it in its line of the source
    uint32_t width, tail; // characters up to the end of its first line, and of its last one
    uint32_t match;       // brackets: the other one
    uint32_t group;       // the bracket around it; of a bracket: the one around both
    uint32_t line_indent; // opening brackets: of the line that they stand on
    uint32_t content;     // opening brackets: indentation of what they hold
    uint32_t pad;         // further spaces before it
    uint8_t kind;         // TokenKind, or a comment
    uint8_t gap_class;    // GapClass of the gap before the next token (a comment: that it is in)
    uint8_t breaks;       // before it: 0, 1 line end, 2: and a blank line
    uint8_t newlines;     // in the source before it, at most 2
    bool space;           // before it, where no line ends there
    bool wide;            // two blanks at least stood before it
    bool comma;           // a comma followed in the source
    bool element;         // begins an element that isn't the first of its group
    bool binary, unary;   // operators
    bool of;              // the word `of` behind `within`
    bool condition;       // ( behind `if` and `for`
    bool several;         // opening brackets: more than one element
    bool broken;          // opening brackets: their contents stand on lines of their own
    bool inside;          // opening brackets: a line ends somewhere between both
} Atom;

typedef struct Line {
    uint32_t begin, end; // atoms
    uint32_t indent;
    bool blank; // a blank line before it
} Line;

typedef struct Formatter {
    const char *text;
    ARRAY(Atom) atoms;
    ARRAY(Line) lines;
    AstCommentArray comments;
} Formatter;

static inline bool atom_is_comment(const Atom *atom)
{
    return atom->kind >= ATOM_LINE_COMMENT;
}
// A comment of several lines.
static inline bool atom_is_long(const Formatter *f, const Atom *atom)
{
    return atom->kind == ATOM_BLOCK_COMMENT &&
           memchr(f->text + atom->begin, '\n', atom->end - atom->begin);
}
static inline bool atom_opens(const Atom *atom)
{
    return atom->kind == TOKEN_LEFT_BRACE || atom->kind == TOKEN_LEFT_PAREN ||
           atom->kind == TOKEN_LEFT_BRACKET;
}
static inline bool atom_closes(const Atom *atom)
{
    return atom->kind == TOKEN_RIGHT_BRACE || atom->kind == TOKEN_RIGHT_PAREN ||
           atom->kind == TOKEN_RIGHT_BRACKET;
}
// Elements stand in it as in braces: with commas only on one line.
static inline bool format_is_brace(const Formatter *f, uint32_t group)
{
    return group == ATOM_NONE || f->atoms.items[group].kind == TOKEN_LEFT_BRACE;
}
static inline bool format_is_broken(const Formatter *f, uint32_t group)
{
    return group == ATOM_NONE || f->atoms.items[group].broken;
}
// The innermost bracket whose inside the place before the atom is.
static inline uint32_t format_place(const Formatter *f, uint32_t i)
{
    const Atom *atom = &f->atoms.items[i];
    return atom_closes(atom) ? atom->match : atom->group;
}
// The first token at or behind atom i; the count of atoms where only comments follow.
uint32_t format_token_from(const Formatter *f, uint32_t i);
// A comma is written behind token i.
bool format_has_comma(const Formatter *f, uint32_t i);

// Decides what each atom is, and the space before it.
void format_roles(Formatter *f);
// Decides where lines end, as the author had it.
void format_breaks(Formatter *f);
// Makes the lines, and breaks those that are too long. False without memory.
bool format_lines(Formatter *f);
// Finds columns that the author aligned. False without memory.
bool format_align(Formatter *f);

// A line ends before atom i.
void format_add_break(Formatter *f, uint32_t i);
// The gap behind token i gets a line end, if it has none; true when it was added.
bool format_break_gap(Formatter *f, uint32_t i);
// Both ends of a bracket, and all elements of a brace.
void format_break_group(Formatter *f, uint32_t opener, bool each_element);

#endif
