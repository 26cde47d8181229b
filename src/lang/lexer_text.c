// What the lexer says: about characters that begin no token, and in its dump.
#include "lang/lexer_internal.h"

#include "base/utf8.h"
#include "schema/schema.h"

#include <inttypes.h>
#include <utf8proc.h>

// Characters that people or word processors write for others, and other languages' marks.
typedef struct LookAlike {
    const char *written, *meant, *message;
    TokenKind kind; // what it is read as; TOKEN_END: a blank
} LookAlike;

static const LookAlike look_alikes[] = {
    {";", "", "`;` has no meaning here: nothing separates items but a line, a blank or a comma",
     TOKEN_END},
    {"&&", "and", "`&&` is written `and`", TOKEN_AND},
    {"||", "or", "`||` is written `or`", TOKEN_OR},
    {"!", "not ", "`!` is written `not`", TOKEN_NOT},
    {"**", "^", "`**` is written `^`", TOKEN_CARET},
    {"...", "..", "a range is written `a..b`, or `a..<b` without its last", TOKEN_RANGE},
    {"..=", "..", "`a..b` already has both ends", TOKEN_RANGE},
    {"\xe2\x88\x92", "-", "this is U+2212 (minus sign), not `-`", TOKEN_MINUS},
    {"\xe2\x80\x93", "-", "this is U+2013 (en dash), not `-`", TOKEN_MINUS},
    {"\xc3\x97", "*", "this is U+00D7 (multiplication sign), not `*`", TOKEN_STAR},
    {"\xc3\xb7", "/", "this is U+00F7 (division sign), not `/`", TOKEN_SLASH},
    {"\xe2\x89\xa4", "<=", "this is U+2264, not `<=`", TOKEN_LESS_EQUAL},
    {"\xe2\x89\xa5", ">=", "this is U+2265, not `>=`", TOKEN_GREATER_EQUAL},
    {"\xe2\x89\xa0", "!=", "this is U+2260, not `!=`", TOKEN_NOT_EQUAL},
    {"\xc2\xa0", " ", "this is U+00A0 (no-break space), not a blank", TOKEN_END},
    {"\xe2\x80\x8b", "", "this is U+200B (zero width space)", TOKEN_END},
    {"\xef\xbb\xbf", "", "this is U+FEFF (byte order mark), which may only begin a file",
     TOKEN_END},
};

static const LookAlike *find_look_alike(const Lexer *lexer)
{
    size_t room = (size_t)(lexer->end - lexer->at);
    for (size_t i = 0; i < sizeof look_alikes / sizeof *look_alikes; ++i) {
        size_t length = strlen(look_alikes[i].written);
        if (length <= room && memcmp(lexer->at, look_alikes[i].written, length) == 0) {
            return &look_alikes[i];
        }
    }
    return NULL;
}

static bool look_alike(Lexer *lexer, Token *token, const LookAlike *found)
{
    const char *end = lexer->at + strlen(found->written);
    DiagCode code = found->written[0] == ';' ? E0104 : E0103;
    Span at = lexer_span(lexer, lexer->at, end);
    Diag *diag = diag_report(lexer->sink, code, at, "%s", found->message);
    diag_label(lexer->sink, diag, "%s%s%s", *found->meant ? "write `" : "remove it", found->meant,
               *found->meant ? "`" : "");
    diag_suggest(lexer->sink, diag, at, found->meant);
    lexer->at = end;
    token->kind = (uint8_t)found->kind;
    return found->kind != TOKEN_END;
}

// The first place at or behind `at` where `what` stands, or the end of the text; *last is what was
// found before, and serves as long as it lies ahead.
static const char *look_ahead(const Lexer *lexer, const char *at, const char *what,
                              const char **last)
{
    if (!*last || *last < at) {
        const char *found = memmem(at, (size_t)(lexer->end - at), what, strlen(what));
        *last = found ? found : lexer->end;
    }
    return *last;
}

// A string in other quotes: read up to the closing one on the line.
static bool other_quotes(Lexer *lexer, Token *token)
{
    static const char *const pairs[][2] = {
        {"'", "'"},
        {"\xe2\x80\x9c", "\xe2\x80\x9d"}, // “ ”
        {"\xe2\x80\x98", "\xe2\x80\x99"}, // ‘ ’
        {"\xe2\x80\x9d", "\xe2\x80\x9d"}, // ” ”
        {"\xe2\x80\x99", "\xe2\x80\x99"}, // ’ ’
        {"`", "`"},
    };
    _Static_assert(sizeof pairs / sizeof *pairs == sizeof lexer->closing / sizeof *lexer->closing,
                   "one for each pair");
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i) {
        size_t length = strlen(pairs[i][0]);
        if ((size_t)(lexer->end - lexer->at) < length ||
            memcmp(lexer->at, pairs[i][0], length) != 0) {
            continue;
        }
        const char *text = lexer->at + length;
        const char *stop = look_ahead(lexer, text, pairs[i][1], &lexer->closing[i]);
        bool closed = stop < look_ahead(lexer, text, "\n", &lexer->line_end);
        const char *end = closed ? stop + strlen(pairs[i][1]) : text;
        diag_report(lexer->sink, E0103, lexer_span(lexer, lexer->at, end),
                    "a string stands in double quotes: \"…\"");
        lexer->at = end;
        token->kind = TOKEN_ERROR;
        if (closed) {
            token->kind = TOKEN_STRING;
            token->symbol = lexer_intern(lexer, text, stop);
        }
        return true;
    }
    return false;
}

static bool is_letter(uint32_t code)
{
    if (code == UTF8_INVALID || code < 0x80) {
        return false;
    }
    utf8proc_category_t category = utf8proc_category((utf8proc_int32_t)code);
    return category >= UTF8PROC_CATEGORY_LU && category <= UTF8PROC_CATEGORY_NO;
}

// Behind the letters, digits and marks of any script that begin at `at`.
static const char *word_end(const char *at, const char *end)
{
    while (at < end) {
        uint32_t code;
        int length = utf8_decode(at, end, &code);
        if (!char_is(*at, CHAR_LETTER | CHAR_DIGIT) && !is_letter(code)) {
            break;
        }
        at += length;
    }
    return at;
}

static void foreign_name(Lexer *lexer, Token *token, const char *end)
{
    diag_report(lexer->sink, E0114, lexer_span(lexer, lexer->at, end),
                "a name is made of the letters a-z and A-Z, digits and `_`");
    token->kind = TOKEN_NAME;
    token->symbol = lexer_intern(lexer, lexer->at, end);
    lexer->at = end;
}

bool lexer_foreign_name(Lexer *lexer, Token *token)
{
    const char *at = lexer->at, *end = word_end(at, lexer->end);
    while (char_is(*at, CHAR_LETTER | CHAR_DIGIT)) {
        ++at;
    }
    if (end == at) {
        return false;
    }
    foreign_name(lexer, token, end);
    return true;
}

bool lexer_unexpected(Lexer *lexer, Token *token)
{
    const LookAlike *found = find_look_alike(lexer);
    if (found) {
        return look_alike(lexer, token, found);
    }
    if (other_quotes(lexer, token)) {
        return true;
    }
    const char *begin = lexer->at;
    uint32_t code;
    const char *end = begin + utf8_decode(begin, lexer->end, &code);
    token->kind = TOKEN_ERROR;
    if (is_letter(code)) {
        foreign_name(lexer, token, word_end(begin, lexer->end));
        return true;
    }
    if (code == UTF8_INVALID) { // reported at the start
        for (; end < lexer->end; ++end) {
            utf8_decode(end, lexer->end, &code);
            if (code != UTF8_INVALID) {
                break;
            }
        }
    } else if (utf8_is_control(code)) {
        diag_report(lexer->sink, E0116, lexer_span(lexer, begin, end),
                    "a control character (U+%04" PRIX32 ")", code);
    } else {
        diag_report(lexer->sink, E0103, lexer_span(lexer, begin, end), "`%.*s` has no meaning here",
                    (int)(end - begin), begin);
    }
    lexer->at = end;
    return true;
}

// --- Names of tokens and the dump ----------------------------------------------------------------

const char *token_kind_name(TokenKind kind)
{
    static const char *const names[] = {
        "the end of the file",     "error", "name", "number", "string", "color",
#define TEXT(id, text) "`" text "`",
        KEYWORDS(TEXT) MARKS(TEXT)
#undef TEXT
    };
    return names[kind];
}

static void dump_token(const Lexer *lexer, const Token *token, FILE *out)
{
    fprintf(out, "%u:%u ", token->begin, token->end);
    switch (token->kind) {
    case TOKEN_END:
        fputs("end", out);
        break;
    case TOKEN_NAME:
        fprintf(out, "name %s", symbol_name(lexer->names, token->symbol).at);
        break;
    case TOKEN_NUMBER:
        fprintf(out, "number %.17g%s%s", token->number, token->unit ? " " : "",
                token->unit ? schema_units[token->unit - 1].name : "");
        break;
    case TOKEN_COLOR:
        fprintf(out, "color #%06" PRIx32, token->color);
        break;
    case TOKEN_STRING:
        fprintf(out, "string %.*s", (int)(token->end - token->begin), lexer->begin + token->begin);
        break;
    case TOKEN_ERROR:
        fputs("error", out);
        break;
    default:
        fprintf(out, "%.*s", (int)(token->end - token->begin), lexer->begin + token->begin);
    }
    putc('\n', out);
}

typedef struct Dump {
    Lexer lexer;
    jmp_buf on_oom;
} Dump;

static void dump_tokens(Dump *dump, FILE *out)
{
    if (setjmp(dump->on_oom)) {
        diag_report(dump->lexer.sink, E0001, (Span){dump->lexer.file, 0, 0}, "out of memory");
        return;
    }
    Token token;
    do {
        lexer_next(&dump->lexer, &token);
        dump_token(&dump->lexer, &token, out);
    } while (token.kind != TOKEN_END);
}

bool lexer_dump(const Sources *sources, uint32_t file, Interner *names, DiagSink *sink, FILE *out)
{
    Dump dump;
    uint32_t errors = sink->errors;
    jmp_buf *outer = names->arena->on_oom;
    names->arena->on_oom = NULL;
    lexer_init(&dump.lexer, source_get(sources, file), file, names, sink, NULL, &dump.on_oom);
    dump_tokens(&dump, out);
    lexer_free(&dump.lexer);
    names->arena->on_oom = outer;
    return sink->errors == errors;
}
