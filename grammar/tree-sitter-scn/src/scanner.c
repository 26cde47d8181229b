// Block comments, which nest, and the `%` of a tolerance, which is none where no `of` follows: no
// regular expression can tell.
#include "tree_sitter/parser.h"

enum { BLOCK_COMMENT, PERCENT };

void *tree_sitter_scn_external_scanner_create(void)
{
    return NULL;
}

void tree_sitter_scn_external_scanner_destroy(void *payload)
{
    (void)payload;
}

unsigned tree_sitter_scn_external_scanner_serialize(void *payload, char *buffer)
{
    (void)payload;
    (void)buffer;
    return 0;
}

void tree_sitter_scn_external_scanner_deserialize(void *payload, const char *buffer,
                                                  unsigned length)
{
    (void)payload;
    (void)buffer;
    (void)length;
}

static bool is_blank(int32_t c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

static bool is_name(int32_t c)
{
    return c == '_' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

// Behind "/": the rest of a block comment; false where it is none, or never ends.
static bool skip_block(TSLexer *lexer)
{
    if (lexer->lookahead != '*') {
        return false;
    }
    lexer->advance(lexer, false);
    for (unsigned depth = 1; depth > 0;) {
        if (lexer->eof(lexer)) {
            return false;
        }
        int32_t c = lexer->lookahead;
        lexer->advance(lexer, false);
        if (c == '*' && lexer->lookahead == '/') {
            lexer->advance(lexer, false);
            --depth;
        } else if (c == '/' && lexer->lookahead == '*') {
            lexer->advance(lexer, false);
            ++depth;
        }
    }
    return true;
}

static bool scan_comment(TSLexer *lexer)
{
    lexer->advance(lexer, false);
    lexer->result_symbol = BLOCK_COMMENT;
    if (!skip_block(lexer)) {
        return false;
    }
    lexer->mark_end(lexer);
    return true;
}

// Blanks and comments.
static bool skip_extras(TSLexer *lexer)
{
    for (;;) {
        while (is_blank(lexer->lookahead)) {
            lexer->advance(lexer, false);
        }
        if (lexer->lookahead != '/') {
            return true;
        }
        lexer->advance(lexer, false);
        if (lexer->lookahead == '/') {
            while (lexer->lookahead != '\n' && !lexer->eof(lexer)) {
                lexer->advance(lexer, false);
            }
        } else if (!skip_block(lexer)) {
            return false;
        }
    }
}

static bool scan_percent(TSLexer *lexer)
{
    lexer->advance(lexer, false);
    lexer->mark_end(lexer);
    if (!skip_extras(lexer)) {
        return false;
    }
    for (const char *word = "of"; *word; ++word) {
        if (lexer->lookahead != *word) {
            return false;
        }
        lexer->advance(lexer, false);
    }
    lexer->result_symbol = PERCENT;
    return !is_name(lexer->lookahead);
}

bool tree_sitter_scn_external_scanner_scan(void *payload, TSLexer *lexer, const bool *valid)
{
    (void)payload;
    while (is_blank(lexer->lookahead)) {
        lexer->advance(lexer, true);
    }
    if (lexer->lookahead == '/' && valid[BLOCK_COMMENT]) {
        return scan_comment(lexer);
    }
    return lexer->lookahead == '%' && valid[PERCENT] && scan_percent(lexer);
}
