#include "lang/lexer_internal.h"

#include "base/utf8.h"
#include "lang/lang.h"

#define REPEAT_26(c, class)                                                                        \
    [c] = class, [c + 1] = class, [c + 2] = class, [c + 3] = class, [c + 4] = class,               \
    [c + 5] = class, [c + 6] = class, [c + 7] = class, [c + 8] = class, [c + 9] = class,           \
    [c + 10] = class, [c + 11] = class, [c + 12] = class, [c + 13] = class, [c + 14] = class,      \
    [c + 15] = class, [c + 16] = class, [c + 17] = class, [c + 18] = class, [c + 19] = class,      \
    [c + 20] = class, [c + 21] = class, [c + 22] = class, [c + 23] = class, [c + 24] = class,      \
    [c + 25] = class

enum { HEX_LETTER = CHAR_LETTER | CHAR_HEX, DIGIT = CHAR_DIGIT | CHAR_HEX };

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Woverride-init" // a to f stand in a to z
const uint8_t lexer_classes[256] = {
    [' '] = CHAR_BLANK,
    ['\t'] = CHAR_BLANK,
    ['\r'] = CHAR_BLANK,
    ['\n'] = CHAR_BLANK,
    ['_'] = CHAR_LETTER,
    REPEAT_26('a', CHAR_LETTER),
    REPEAT_26('A', CHAR_LETTER),
    ['a'] = HEX_LETTER,
    ['b'] = HEX_LETTER,
    ['c'] = HEX_LETTER,
    ['d'] = HEX_LETTER,
    ['e'] = HEX_LETTER,
    ['f'] = HEX_LETTER,
    ['A'] = HEX_LETTER,
    ['B'] = HEX_LETTER,
    ['C'] = HEX_LETTER,
    ['D'] = HEX_LETTER,
    ['E'] = HEX_LETTER,
    ['F'] = HEX_LETTER,
    ['0'] = DIGIT,
    ['1'] = DIGIT,
    ['2'] = DIGIT,
    ['3'] = DIGIT,
    ['4'] = DIGIT,
    ['5'] = DIGIT,
    ['6'] = DIGIT,
    ['7'] = DIGIT,
    ['8'] = DIGIT,
    ['9'] = DIGIT,
};
#pragma GCC diagnostic pop

static const Str keywords[] = {
#define KEYWORD(id, text) {text, sizeof text - 1},
    KEYWORDS(KEYWORD)
#undef KEYWORD
};

const char *const lang_keywords[] = {
#define KEYWORD(id, text) text,
    KEYWORDS(KEYWORD)
#undef KEYWORD
};
const size_t lang_keyword_count = sizeof lang_keywords / sizeof lang_keywords[0];

enum { FIRST_KEYWORD = TOKEN_COLOR + 1, KEYWORD_COUNT = sizeof keywords / sizeof *keywords };

// --- Start ---------------------------------------------------------------------------------------

static void report_bad_byte(Lexer *lexer, const char *at, const char *end)
{
    Diag *diag = diag_report(lexer->sink, E0101, lexer_span(lexer, at, end),
                             "the byte 0x%02x is not valid UTF-8", (unsigned char)*at);
    if (at == lexer->begin && end - at >= 2 &&
        ((at[0] == '\xff' && at[1] == '\xfe') || (at[0] == '\xfe' && at[1] == '\xff'))) {
        diag_note(lexer->sink, diag, "the file looks like UTF-16: save it as UTF-8");
    } else {
        diag_note(lexer->sink, diag, "save the file as UTF-8");
    }
}

// Whether all bytes are ASCII and none is 0. Looks at many at once, for all of a long text.
static bool is_plain(const char *at, const char *end)
{
    enum { WORDS = 16 };
    const uint64_t high = 0x8080808080808080u, ones = 0x0101010101010101u;
    uint64_t words[WORDS];
    for (; (size_t)(end - at) >= sizeof words; at += sizeof words) {
        memcpy(words, at, sizeof words);
        uint64_t bad = 0;
        for (int i = 0; i < WORDS; ++i) {
            bad |= words[i] | (words[i] - ones); // of ASCII: has its high bits where a byte is 0
        }
        if (bad & high) {
            return false;
        }
    }
    while (at < end && (signed char)*at > 0) {
        ++at;
    }
    return at == end;
}

// Reports the first few runs of bytes that aren't UTF-8.
static void check_utf8(Lexer *lexer)
{
    enum { REPORTED = 10 };
    const char *at = lexer->begin, *end = lexer->end;
    for (int reported = 0; at < end && reported < REPORTED;) {
        for (uint64_t word; end - at >= 8; at += 8) {
            memcpy(&word, at, 8);
            if (word & 0x8080808080808080u) {
                break;
            }
        }
        const char *stop = end - at >= 8 ? at + 8 : end;
        while (at < stop) {
            uint32_t code;
            int length = utf8_decode(at, end, &code);
            if (code != UTF8_INVALID) {
                at += length;
                continue;
            }
            const char *bad = at;
            do {
                at += length;
                length = at < end ? utf8_decode(at, end, &code) : 0;
            } while (at < end && code == UTF8_INVALID);
            report_bad_byte(lexer, bad, at);
            ++reported;
        }
    }
}

static uint32_t unit_key(const char *at, size_t length)
{
    uint32_t key = 0;
    for (size_t i = 0; i < length; ++i) {
        key |= (uint32_t)(unsigned char)at[i] << (8 * i);
    }
    return key;
}

static uint32_t unit_slot(uint32_t key)
{
    return (key * 0x9e3779b1u) >> 26;
}

static void index_units(Lexer *lexer)
{
    for (size_t i = 0; i < schema_unit_count; ++i) {
        size_t length = strlen(schema_units[i].name);
        uint32_t key = unit_key(schema_units[i].name, length < 4 ? length : 4);
        uint32_t slot = unit_slot(key);
        while (lexer->units[slot].index) {
            slot = (slot + 1) % UNIT_SLOTS;
        }
        lexer->units[slot].key = key;
        lexer->units[slot].index = (uint16_t)(i + 1);
    }
}

uint16_t lexer_find_unit(const Lexer *lexer, const char *at, size_t length)
{
    if (length > 4) {
        return 0;
    }
    uint32_t key = unit_key(at, length), slot = unit_slot(key);
    while (lexer->units[slot].index && lexer->units[slot].key != key) {
        slot = (slot + 1) % UNIT_SLOTS;
    }
    return lexer->units[slot].index;
}

void lexer_init(Lexer *lexer, const Source *source, uint32_t file, Interner *names, DiagSink *sink,
                AstCommentArray *comments, jmp_buf *on_oom)
{
    memset(lexer, 0, sizeof *lexer);
    lexer->begin = lexer->at = source->text.length ? source->text.at : "";
    lexer->end = lexer->begin + source->text.length;
    lexer->file = file;
    lexer->names = names;
    lexer->sink = sink;
    lexer->comments = comments;
    lexer->on_oom = on_oom;
    index_units(lexer);
    if (is_plain(lexer->begin, lexer->end)) {
        return;
    }
    check_utf8(lexer);
    const char *nul = memchr(lexer->begin, '\0', source->text.length);
    if (nul) {
        Diag *diag = diag_report(sink, E0102, lexer_span(lexer, nul, nul + 1), "a byte of value 0");
        diag_note(sink, diag, "this isn't a text file, or its encoding isn't UTF-8");
        lexer->at = lexer->end;
    } else if (source->text.length >= 3 && memcmp(lexer->begin, "\xef\xbb\xbf", 3) == 0) {
        lexer->at += 3;
    }
}

void lexer_free(Lexer *lexer)
{
    array_free(&lexer->scratch);
}

// --- Blanks and comments -------------------------------------------------------------------------

static const char *line_comment_end(const char *at, const char *end)
{
    const char *newline = memchr(at, '\n', (size_t)(end - at));
    const char *stop = newline ? newline : end;
    return stop[-1] == '\r' ? stop - 1 : stop;
}

// Behind the comment that begins at `at`, or NULL where it is never closed; comments nest.
static const char *block_comment_end(const char *at, const char *end)
{
    size_t depth = 0;
    while (end - at >= 2) {
        if (at[0] == '/' && at[1] == '*') {
            ++depth;
            at += 2;
        } else if (at[0] == '*' && at[1] == '/') {
            at += 2;
            if (--depth == 0) {
                return at;
            }
        } else {
            ++at;
        }
    }
    return NULL;
}

static void comment(Lexer *lexer, bool *new_line)
{
    const char *begin = lexer->at, *stop;
    if (begin[1] == '/') {
        stop = line_comment_end(begin, lexer->end);
    } else {
        stop = block_comment_end(begin, lexer->end);
        if (!stop) {
            Diag *diag = diag_report(lexer->sink, E0108, lexer_span(lexer, begin, begin + 2),
                                     "this comment is never closed");
            diag_note(lexer->sink, diag, "comments nest: each `/*` needs its own `*/`");
            stop = lexer->end;
        }
        *new_line = *new_line || memchr(begin, '\n', (size_t)(stop - begin));
    }
    lexer->at = stop;
    AstComment kept = {lexer_offset(lexer, begin), lexer_offset(lexer, stop)};
    if (lexer->comments && !array_push(lexer->comments, kept)) {
        longjmp(*lexer->on_oom, 1);
    }
}

// Moves to the next token. True when a line ended on the way.
static inline bool skip_blanks(Lexer *lexer)
{
    bool new_line = lexer->at == lexer->begin;
    const char *at = lexer->at, *end = lexer->end;
    at += at < end && *at == ' ';
    if (at<end && * at> '/') { // nothing or one blank, then a name, a number, most marks
        lexer->at = at;
        return new_line;
    }
    for (;;) {
        while (at < end && char_is(*at, CHAR_BLANK)) {
            new_line |= *at++ == '\n';
        }
        if (end - at < 2 || at[0] != '/' || (at[1] != '/' && at[1] != '*')) {
            lexer->at = at;
            return new_line;
        }
        lexer->at = at;
        comment(lexer, &new_line);
        at = lexer->at;
    }
}

const char *lexer_next_begin(const char *at, const char *end)
{
    for (;;) {
        while (at < end && char_is(*at, CHAR_BLANK)) {
            ++at;
        }
        if (end - at < 2 || at[0] != '/' || (at[1] != '/' && at[1] != '*')) {
            return at;
        }
        at = at[1] == '/' ? line_comment_end(at, end) : block_comment_end(at, end);
        if (!at) {
            return end;
        }
    }
}

char lexer_peek(const Lexer *lexer)
{
    const char *at = lexer_next_begin(lexer->at, lexer->end);
    return at < lexer->end ? *at : '\0';
}

bool lexer_peek_word(const Lexer *lexer, Str word)
{
    const char *at = lexer_next_begin(lexer->at, lexer->end), *end = at;
    while (end < lexer->end && char_is(*end, CHAR_LETTER | CHAR_DIGIT)) {
        ++end;
    }
    return str_equal((Str){at, (size_t)(end - at)}, word);
}

// --- Names ---------------------------------------------------------------------------------------

Symbol lexer_intern(Lexer *lexer, const char *begin, const char *end)
{
    Symbol symbol = intern(lexer->names, (Str){begin, (size_t)(end - begin)});
    if (!symbol) {
        longjmp(*lexer->on_oom, 1);
    }
    return symbol;
}

static TokenKind keyword_or_name(const char *at, size_t length)
{
    for (int i = 0; i < KEYWORD_COUNT; ++i) {
        if (keywords[i].length == length && memcmp(keywords[i].at, at, length) == 0) {
            return (TokenKind)(FIRST_KEYWORD + i);
        }
    }
    return TOKEN_NAME;
}

// Up to 8 bytes as a number, padded with zeros. `room` bytes may be read.
static inline uint64_t load_key(const char *at, size_t length, size_t room)
{
    uint64_t key = 0;
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    if (room >= 8) {
        memcpy(&key, at, 8);
        return length >= 8 ? key : key & (((uint64_t)1 << (8 * length)) - 1);
    }
#endif
    (void)room;
    memcpy(&key, at, length < 8 ? length : 8);
    return key;
}

static inline void name(Lexer *lexer, Token *token)
{
    const char *begin = lexer->at, *at = begin + 1, *end = lexer->end;
    while (at < end && char_is(*at, CHAR_LETTER | CHAR_DIGIT)) {
        ++at;
    }
    if (at < end && (unsigned char)*at >= 0x80 && lexer_foreign_name(lexer, token)) {
        return;
    }
    lexer->at = at;
    size_t length = (size_t)(at - begin), room = (size_t)(end - begin);
    if (length > 16) {
        token->kind = TOKEN_NAME; // no reserved word is as long
        token->symbol = lexer_intern(lexer, begin, at);
        return;
    }
    uint64_t low = load_key(begin, length, room);
    uint64_t high = length > 8 ? load_key(begin + 8, length - 8, room - 8) : 0;
    NameSlot *slot = &lexer->slots[((low ^ (high << 7)) * 0x9e3779b97f4a7c15u) >> 56];
    if (slot->key[0] != low || slot->key[1] != high) {
        Symbol symbol = lexer_intern(lexer, begin, at);
        *slot = (NameSlot){{low, high}, symbol, keyword_or_name(begin, length)};
    }
    token->kind = (uint8_t)slot->kind;
    token->symbol = slot->symbol;
}

// --- Tokens --------------------------------------------------------------------------------------

static inline bool follows(const Lexer *lexer, int offset, char c)
{
    return lexer->end - lexer->at > offset && lexer->at[offset] == c;
}

static inline void mark(Lexer *lexer, Token *token, TokenKind kind, int length)
{
    token->kind = (uint8_t)kind;
    lexer->at += length;
}

static void dots(Lexer *lexer, Token *token)
{
    if (!follows(lexer, 1, '.')) {
        mark(lexer, token, TOKEN_DOT, 1);
    } else if (follows(lexer, 2, '<')) {
        mark(lexer, token, TOKEN_RANGE_BELOW, 3);
    } else {
        mark(lexer, token, TOKEN_RANGE, 2);
    }
}

// A mark that may be followed by `=`.
static void with_equals(Lexer *lexer, Token *token, TokenKind alone, TokenKind with)
{
    bool two = follows(lexer, 1, '=');
    mark(lexer, token, two ? with : alone, two ? 2 : 1);
}

// Marks that no longer mark begins with.
static const uint8_t marks[256] = {
    ['{'] = TOKEN_LEFT_BRACE,  ['}'] = TOKEN_RIGHT_BRACE,  ['('] = TOKEN_LEFT_PAREN,
    [')'] = TOKEN_RIGHT_PAREN, ['['] = TOKEN_LEFT_BRACKET, [']'] = TOKEN_RIGHT_BRACKET,
    [':'] = TOKEN_COLON,       [','] = TOKEN_COMMA,        ['+'] = TOKEN_PLUS,
    ['-'] = TOKEN_MINUS,       ['/'] = TOKEN_SLASH,        ['%'] = TOKEN_PERCENT,
    ['^'] = TOKEN_CARET,
};

// Reads the token at lexer->at. False where there was none after all, only a reported character.
static inline bool read_token(Lexer *lexer, Token *token)
{
    char c = *lexer->at;
    if (char_is(c, CHAR_LETTER)) {
        name(lexer, token);
        return true;
    }
    if (char_is(c, CHAR_DIGIT)) {
        lexer_number(lexer, token);
        return true;
    }
    if (marks[(unsigned char)c]) {
        mark(lexer, token, (TokenKind)marks[(unsigned char)c], 1);
        return true;
    }
    switch (c) {
    case '"':
        lexer_string(lexer, token);
        return true;
    case '#':
        lexer_color(lexer, token);
        return true;
    case '=':
        with_equals(lexer, token, TOKEN_ASSIGN, TOKEN_EQUAL);
        return true;
    case '<':
        with_equals(lexer, token, TOKEN_LESS, TOKEN_LESS_EQUAL);
        return true;
    case '>':
        with_equals(lexer, token, TOKEN_GREATER, TOKEN_GREATER_EQUAL);
        return true;
    case '*':
        if (follows(lexer, 1, '*')) {
            return lexer_unexpected(lexer, token);
        }
        mark(lexer, token, TOKEN_STAR, 1);
        return true;
    case '!':
        if (!follows(lexer, 1, '=')) {
            return lexer_unexpected(lexer, token);
        }
        mark(lexer, token, TOKEN_NOT_EQUAL, 2);
        return true;
    case '.':
        if (lexer->end - lexer->at > 1 && char_is(lexer->at[1], CHAR_DIGIT)) {
            lexer_number(lexer, token);
            return true;
        }
        if (follows(lexer, 1, '.') && (follows(lexer, 2, '.') || follows(lexer, 2, '='))) {
            return lexer_unexpected(lexer, token);
        }
        dots(lexer, token);
        return true;
    default:
        return lexer_unexpected(lexer, token);
    }
}

void lexer_next(Lexer *lexer, Token *token)
{
    bool new_line = false;
    do {
        new_line |= skip_blanks(lexer);
        token->on_new_line = new_line;
        token->unit = 0;
        token->begin = lexer_offset(lexer, lexer->at);
        if (lexer->at == lexer->end) {
            token->kind = TOKEN_END;
            token->end = token->begin;
            return;
        }
    } while (!read_token(lexer, token));
    token->end = lexer_offset(lexer, lexer->at);
}
