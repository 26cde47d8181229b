// From text to tokens, one at a time, without copying the text and without allocating for a token.
#ifndef LANG_LEXER_H
#define LANG_LEXER_H

#include "base/diag.h"
#include "base/source.h"
#include "base/str.h"
#include "lang/ast.h"

#include <setjmp.h>
#include <stdio.h>

// KEYWORD(id, text): the reserved words.
#define KEYWORDS(KEYWORD)                                                                          \
    KEYWORD(IMPORT, "import")                                                                      \
    KEYWORD(AS, "as")                                                                              \
    KEYWORD(PARAM, "param")                                                                        \
    KEYWORD(LET, "let")                                                                            \
    KEYWORD(FN, "fn")                                                                              \
    KEYWORD(EXPECT, "expect")                                                                      \
    KEYWORD(FOR, "for")                                                                            \
    KEYWORD(IN, "in")                                                                              \
    KEYWORD(IF, "if")                                                                              \
    KEYWORD(ELSE, "else")                                                                          \
    KEYWORD(TRUE, "true")                                                                          \
    KEYWORD(FALSE, "false")                                                                        \
    KEYWORD(WITH, "with")                                                                          \
    KEYWORD(WITHIN, "within")                                                                      \
    KEYWORD(AND, "and")                                                                            \
    KEYWORD(OR, "or")                                                                              \
    KEYWORD(NOT, "not")

// MARK(id, text): punctuation.
#define MARKS(MARK)                                                                                \
    MARK(LEFT_BRACE, "{")                                                                          \
    MARK(RIGHT_BRACE, "}")                                                                         \
    MARK(LEFT_PAREN, "(")                                                                          \
    MARK(RIGHT_PAREN, ")")                                                                         \
    MARK(LEFT_BRACKET, "[")                                                                        \
    MARK(RIGHT_BRACKET, "]")                                                                       \
    MARK(COLON, ":")                                                                               \
    MARK(COMMA, ",")                                                                               \
    MARK(DOT, ".")                                                                                 \
    MARK(RANGE, "..")                                                                              \
    MARK(RANGE_BELOW, "..<")                                                                       \
    MARK(ASSIGN, "=")                                                                              \
    MARK(EQUAL, "==")                                                                              \
    MARK(NOT_EQUAL, "!=")                                                                          \
    MARK(LESS, "<")                                                                                \
    MARK(LESS_EQUAL, "<=")                                                                         \
    MARK(GREATER, ">")                                                                             \
    MARK(GREATER_EQUAL, ">=")                                                                      \
    MARK(PLUS, "+")                                                                                \
    MARK(MINUS, "-")                                                                               \
    MARK(STAR, "*")                                                                                \
    MARK(SLASH, "/")                                                                               \
    MARK(PERCENT, "%")                                                                             \
    MARK(CARET, "^")

typedef enum TokenKind {
    TOKEN_END,
    TOKEN_ERROR, // characters that make no token; already reported
    TOKEN_NAME,
    TOKEN_NUMBER,
    TOKEN_STRING,
    TOKEN_COLOR,
#define KEYWORD(id, text) TOKEN_##id,
    KEYWORDS(KEYWORD)
#undef KEYWORD
#define MARK(id, text) TOKEN_##id,
        MARKS(MARK)
#undef MARK
            TOKEN_KIND_COUNT
} TokenKind;

typedef struct Token {
    uint8_t kind;        // TokenKind
    bool on_new_line;    // the first of its line
    uint16_t unit;       // NUMBER: index into schema_units + 1; 0: none
    uint32_t begin, end; // bytes in the file
    union {
        Symbol symbol;  // NAME; STRING (of the text without quotes and escapes)
        uint32_t color; // COLOR: 0xRRGGBB
        double number;  // NUMBER, as written
    };
} Token;

// Names met lately, by their bytes, so that most need neither the interner's hash nor a look at
// the reserved words.
typedef struct NameSlot {
    uint64_t key[2]; // up to 16 bytes, padded with zeros
    Symbol symbol;
    uint32_t kind; // TokenKind; 0: free
} NameSlot;

enum { NAME_SLOTS = 256, UNIT_SLOTS = 64 };

typedef struct Lexer {
    const char *begin, *at, *end; // the text, and how far it has been read
    uint32_t file;
    Interner *names;
    DiagSink *sink;
    AstCommentArray *comments; // where comments are kept; NULL: nowhere
    jmp_buf *on_oom;           // taken when memory runs out
    ARRAY(char) scratch;       // a string being unescaped
    // What was found last when looking ahead: the end of the line, and the next closing quote of
    // each kind. A line of a million opening ones isn't searched a million times.
    const char *line_end, *closing[6];
    NameSlot slots[NAME_SLOTS];
    struct {
        uint32_t key;   // up to 4 bytes, padded with zeros
        uint16_t index; // into schema_units + 1; 0: free
    } units[UNIT_SLOTS];
} Lexer;

// Starts at the beginning of source `file`. Reports bytes that aren't UTF-8, and NUL bytes (then
// there are no tokens). To be given back with lexer_free, also after the jump.
void lexer_init(Lexer *lexer, const Source *source, uint32_t file, Interner *names, DiagSink *sink,
                AstCommentArray *comments, jmp_buf *on_oom);
void lexer_free(Lexer *lexer);

// The next token. Errors are reported to the sink. At the end of the text it gives TOKEN_END, again
// and again.
void lexer_next(Lexer *lexer, Token *token);

// The character that follows the last token, blanks and comments skipped; 0 at the end.
char lexer_peek(const Lexer *lexer);
// Whether the word follows there.
bool lexer_peek_word(const Lexer *lexer, Str word);

// The unit written [at, at + length): an index into schema_units + 1, or 0.
uint16_t lexer_find_unit(const Lexer *lexer, const char *at, size_t length);

const char *token_kind_name(TokenKind kind); // "name", "`{`", "`let`", …

// Writes the tokens of a file, one a line: the bytes, the kind and the text. True when no error was
// reported.
bool lexer_dump(const Sources *sources, uint32_t file, Interner *names, DiagSink *sink, FILE *out);

#endif
