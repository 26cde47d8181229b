// Canonical layout of a scene's text. Only blanks, line ends, commas between fields and items, and
// commas before a closing bracket change: the tokens, and so the syntax tree, stay as they were.
//
// The style
//
//  - Two spaces a level; `kind { field: value, field: value }`, `f(a, b)`, `[a, b]`, `{}`; one
//  space
//    around operators, `=` and words, none around `.` and behind a minus that negates. A range has
//    none (`0..<n`) unless an end is a sum or product (`0 ..< n + 1`).
//  - Lines are broken where the author broke them, if that is between elements (fields, items,
//    arguments, …), inside of brackets' ends, around an operator, behind `=` and `:`, before
//    `with`, `else` and a parameter's range and text. Other line ends are taken out.
//  - Brackets with such a break between their elements, and braces with any inside, are broken:
//  what
//    they hold stands on lines of its own, two spaces deeper than the line that opens them.
//    Elements that shared a line share it still. Braces that had breaks only deeper inside get one
//    element a line.
//  - A comma stands between elements; in braces only between those on one line. None stands before
//    a closing bracket.
//  - A line of more than 100 columns (not counting a comment at its end) is broken: in braces, one
//    element a line; else at the last comma that fits.
//  - One blank line at most, and none just inside of brackets.
//  - A line that goes on in the middle of an expression is two spaces deeper.
//  - Comments stay where they are: at the end of a line, on a line of their own, or inside of one.
//    Blanks at the end of `//` comments go; other comments stay to the letter.
//  - Columns: where words of the same role in consecutive lines of one level (or comments at line
//    ends within one paragraph or top-level item) began in the same column with more than one space
//    before one of them, they will again, as far to the left as they can.
//
// Formatting what was formatted changes nothing.
#ifndef LANG_FORMAT_H
#define LANG_FORMAT_H

#include "base/array.h"
#include "lang/ast.h"

enum { FORMAT_COLUMNS = 100, FORMAT_INDENT = 2 };

typedef ARRAY(char) FormatText;

// Appends the formatted text of source `file` to *out (to be given back with array_free, also after
// errors). False when the source has syntax errors, which are reported, or when memory runs out
// (E0001); then *out is of no use.
bool format_source(FormatText *out, const Sources *sources, uint32_t file, Interner *names,
                   ParseLimits limits, DiagSink *sink);

// True if both trees, made with the same interner, are equal but for the places in the text.
bool ast_equal(const Ast *a, const Ast *b);

#endif
