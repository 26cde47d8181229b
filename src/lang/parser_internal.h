// What the parser's files share. Every parse function reads its production from the current token
// on and returns its node; after an error it returns some node (perhaps 0) and `panicking` is set
// until the enclosing body has found the next item.
#ifndef LANG_PARSER_INTERNAL_H
#define LANG_PARSER_INTERNAL_H

#include "lang/ast.h"
#include "lang/lexer.h"

struct Parser {
    Ast *ast;
    Lexer lexer;
    Token token;           // the current one
    uint32_t previous_end; // end of the token before it
    uint32_t nesting, most_nesting;
    uint32_t height;      // of the tree that was returned last, in nodes
    uint32_t most_height; // of a chain
    uint32_t open;        // ( and [ that are open in the current body
    uint32_t tolerance;   // nesting of the tolerance that is being read; 0: none
    bool panicking;       // an error was reported; nothing more until the next item
    bool gave_up;         // nothing more until the end of the file
    bool lost_brace;      // fields stood outside of a kind: a `}` will be too many
    bool out_of_memory;
    AstWordArray stack; // children of the lists being read; lowest the file's items
    jmp_buf on_oom;
    // Of what parser_read_item read last: its place on the stack, and how long the tree's arrays
    // were before.
    size_t item, item_nodes, item_extra;
    struct Repeats *repeats; // NULL: none are looked for
};

// --- Tokens --------------------------------------------------------------------------------------

static inline void parse_advance(Parser *p)
{
    p->previous_end = p->token.end;
    lexer_next(&p->lexer, &p->token);
}

static inline bool parse_at(const Parser *p, TokenKind kind)
{
    return p->token.kind == kind;
}

// Takes the token if it is of this kind.
static inline bool parse_accept(Parser *p, TokenKind kind)
{
    if (p->token.kind != kind) {
        return false;
    }
    parse_advance(p);
    return true;
}

// --- Errors --------------------------------------------------------------------------------------

static inline Span parse_span(const Parser *p, uint32_t begin, uint32_t end)
{
    return (Span){p->ast->file, begin, end};
}
static inline Span parse_token_span(const Parser *p)
{
    return parse_span(p, p->token.begin, p->token.end);
}
static inline Str parse_token_text(const Parser *p)
{
    return (Str){p->lexer.begin + p->token.begin, p->token.end - p->token.begin};
}
// Where something is missing: the current token, or behind the last one if a line ends between.
Span parse_missing_span(const Parser *p);
// Reports, unless an error is being recovered from or the parser gave up: then it returns the
// sink's spare diagnostic, which isn't kept. Never NULL.
Diag *parse_error(Parser *p, DiagCode code, Span at, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
void parse_note(Parser *p, Diag *diag, const char *text);
void parse_suggest(Parser *p, Diag *diag, Span at, const char *text);
// "expected WHAT, found …", and panics.
void parse_expected(Parser *p, const char *what);
bool parse_expect(Parser *p, TokenKind kind);
// What stands at the current token, for messages.
typedef struct TokenText {
    char text[64];
} TokenText;
TokenText parse_found(const Parser *p);
// Stops reading: the rest of the file would only give further errors.
void parse_give_up(Parser *p);

// A reserved word; not `!`, `&&` or `||`, which the lexer has reported and taken for one.
bool parse_at_reserved_word(const Parser *p);
// A name. A reserved word is reported and taken as one. 0 after an error.
Symbol parse_name(Parser *p, const char *what);
// Behind the name that began at byte `begin`; where the name was missing, `begin` itself.
static inline uint32_t parse_name_end(const Parser *p, uint32_t begin)
{
    return p->previous_end > begin ? p->previous_end : begin;
}
// The closing bracket of what was opened at byte `open`.
void parse_close(Parser *p, TokenKind close, uint32_t open);
// Behind an element of a list in brackets: true when another follows.
bool parse_more(Parser *p, TokenKind close);
// Skips to where the next item or field of the current body may begin; `before`: the first byte of
// the item that failed.
void parse_recover(Parser *p, uint32_t before);

// --- Depth ---------------------------------------------------------------------------------------

// One level deeper; false (reported) beyond the limit. To be matched by parse_leave in any case.
bool parse_enter(Parser *p);
static inline void parse_leave(Parser *p)
{
    --p->nesting;
}
// A link of a chain: makes p->height one more than it and `other`. False beyond the limit.
bool parse_link(Parser *p, uint32_t other);
static inline uint32_t parse_taller(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

// --- Nodes ---------------------------------------------------------------------------------------

void parse_out_of_memory(Parser *p) __attribute__((noreturn));
// Does `work`, which may call parse_out_of_memory. False where it did, which is reported; then the
// parser has given up.
bool parse_guarded(Parser *p, void (*work)(Parser *p, void *with), void *with);

static inline AstId parse_node(Parser *p, AstTag tag, uint32_t begin, uint32_t a, uint32_t b)
{
    AstNode node = {.tag = (uint8_t)tag, .begin = begin, .end = p->previous_end, .a = a, .b = b};
    if (!array_push(&p->ast->nodes, node)) {
        parse_out_of_memory(p);
    }
    return (AstId)(p->ast->nodes.count - 1);
}

static inline void parse_push(Parser *p, uint32_t word)
{
    if (!array_push(&p->stack, word)) {
        parse_out_of_memory(p);
    }
}
// The words on the stack above `mark` as a list in Ast.extra.
uint32_t parse_list(Parser *p, size_t mark);
// `count` words in Ast.extra; returns the index of the first.
uint32_t parse_extra(Parser *p, size_t count, const uint32_t *words);

// --- Productions ---------------------------------------------------------------------------------

AstId parse_expression(Parser *p);
// The rest of an expression whose first token was a name.
AstId parse_expression_from(Parser *p, const Token *name);
// The rest of a statement that emits a value, whose first token was a name.
AstId parse_emitted_from(Parser *p, const Token *name);
// The tolerance of an `expect`: sum [ "%" ], before `of`; *percent: the `%` is there.
AstId parse_tolerance(Parser *p, bool *percent);
// "if" "(" expression ")" has been read.
AstId parse_if_branches(Parser *p, uint32_t begin, AstId condition);
// "(" expression ")" behind `if`.
AstId parse_condition(Parser *p);
// [ NAME ] parameters ( "=" expression | block ), behind `fn`.
AstId parse_function(Parser *p, uint32_t begin, bool named);
// `=`; a `:` is reported and taken for it, and so is a type.
bool parse_binding(Parser *p);

// --- Statements that repeat one another (repeat.c) -----------------------------------------------

typedef struct Repeats Repeats;
Repeats *repeats_new(void); // NULL without memory; to be given back with mem_free

// --- Bodies --------------------------------------------------------------------------------------

typedef enum BodyKind {
    BODY_ITEMS,  // of a block
    BODY_KIND,   // fields and items of a kind
    BODY_FIELDS, // of `with`
} BodyKind;
// "{" … "}" as a list of its nodes.
uint32_t parse_body(Parser *p, BodyKind kind);
AstId parse_block(Parser *p);
// The header.
void parse_file_begin(Parser *p);
// An item at the top of the file, put on the stack unless there was nothing but a mistake.
void parse_file_item(Parser *p);
// The `,` behind an item, if it is there.
void parse_item_comma(Parser *p);
// The root.
AstId parse_file_end(Parser *p);

#endif
