// What the lexer's files share.
#ifndef LANG_LEXER_INTERNAL_H
#define LANG_LEXER_INTERNAL_H

#include "lang/lexer.h"

enum CharClass {
    CHAR_BLANK = 1,
    CHAR_DIGIT = 2,
    CHAR_LETTER = 4, // what a name begins with
    CHAR_HEX = 8,
};
extern const uint8_t lexer_classes[256];

static inline bool char_is(char c, int classes)
{
    return (lexer_classes[(unsigned char)c] & classes) != 0;
}

static inline uint32_t lexer_offset(const Lexer *lexer, const char *at)
{
    return (uint32_t)(at - lexer->begin);
}

static inline Span lexer_span(const Lexer *lexer, const char *begin, const char *end)
{
    return (Span){lexer->file, lexer_offset(lexer, begin), lexer_offset(lexer, end)};
}

// The symbol; takes the jump when memory runs out.
Symbol lexer_intern(Lexer *lexer, const char *begin, const char *end);

// The common case of a number at `at`, where a digit stands: few digits, no `_`, no exponent and no
// unit. Behind it, or NULL where it is something else.
const char *lexer_plain_number(const char *at, const char *end, double *out);

// Where the next token begins, or the end.
const char *lexer_next_begin(const char *at, const char *end);

// Each reads its token at lexer->at, moves lexer->at behind it, and fills kind and value.
void lexer_number(Lexer *lexer, Token *token);
void lexer_string(Lexer *lexer, Token *token);
void lexer_color(Lexer *lexer, Token *token);
// A name that goes on with letters beyond ASCII: reports and reads it. False where none follow.
bool lexer_foreign_name(Lexer *lexer, Token *token);
// A character that begins no token: reports it. False: it counts as blank.
bool lexer_unexpected(Lexer *lexer, Token *token);

#endif
