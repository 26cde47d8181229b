// The parser's house-keeping: tokens, errors, recovery, nodes.
#include "lang/lexer_internal.h"
#include "lang/parser_internal.h"

#include <stdarg.h>

// --- Errors --------------------------------------------------------------------------------------

Span parse_missing_span(const Parser *p)
{
    if (p->token.kind == TOKEN_END || p->token.on_new_line) {
        return parse_span(p, p->previous_end, p->previous_end);
    }
    return parse_token_span(p);
}

Diag *parse_error(Parser *p, DiagCode code, Span at, const char *format, ...)
{
    if (p->panicking || p->gave_up) {
        return &p->lexer.sink->spare;
    }
    char text[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return diag_report(p->lexer.sink, code, at, "%s", text);
}

void parse_note(Parser *p, Diag *diag, const char *text)
{
    diag_note(p->lexer.sink, diag, "%s", text);
}

void parse_suggest(Parser *p, Diag *diag, Span at, const char *text)
{
    diag_suggest(p->lexer.sink, diag, at, text);
}

TokenText parse_found(const Parser *p)
{
    enum { LONGEST = 40 };
    TokenText found;
    const char *text = p->lexer.begin + p->token.begin;
    int length = (int)(p->token.end - p->token.begin);
    int shown = length;
    if (length > LONGEST) {
        for (shown = LONGEST; ((unsigned char)text[shown] & 0xc0) == 0x80; --shown) {
        }
    }
    if (p->token.kind == TOKEN_END) {
        snprintf(found.text, sizeof found.text, "the end of the file");
    } else {
        snprintf(found.text, sizeof found.text, "`%.*s%s`", shown, text, shown < length ? "…" : "");
    }
    return found;
}

void parse_expected(Parser *p, const char *what)
{
    if (p->token.kind != TOKEN_ERROR) {
        parse_error(p, E0201, parse_missing_span(p), "expected %s, found %s", what,
                    parse_found(p).text);
    }
    p->panicking = true;
}

bool parse_expect(Parser *p, TokenKind kind)
{
    if (p->panicking) {
        return false;
    }
    if (!parse_accept(p, kind)) {
        parse_expected(p, token_kind_name(kind));
        return false;
    }
    return true;
}

void parse_give_up(Parser *p)
{
    p->gave_up = true;
    p->lexer.at = p->lexer.end;
    p->token.kind = TOKEN_END;
    p->token.begin = p->token.end = (uint32_t)(p->lexer.end - p->lexer.begin);
}

bool parse_at_reserved_word(const Parser *p)
{
    return p->token.kind >= TOKEN_IMPORT && p->token.kind <= TOKEN_NOT &&
           char_is(p->lexer.begin[p->token.begin], CHAR_LETTER);
}

Symbol parse_name(Parser *p, const char *what)
{
    if (p->panicking) {
        return 0;
    }
    if (!parse_at(p, TOKEN_NAME)) {
        if (!parse_at_reserved_word(p) || p->token.on_new_line) {
            parse_expected(p, what);
            return 0;
        }
        parse_error(p, E0207, parse_token_span(p), "%s is a reserved word and can't be a name",
                    parse_found(p).text);
    }
    Symbol symbol = p->token.symbol;
    parse_advance(p);
    return symbol;
}

// --- Brackets and recovery -----------------------------------------------------------------------

static bool may_begin_item(const Parser *p)
{
    switch (p->token.kind) {
    case TOKEN_NAME:
    case TOKEN_LET:
    case TOKEN_FOR:
    case TOKEN_FN:
    case TOKEN_IF:
    case TOKEN_EXPECT:
    case TOKEN_IMPORT:
    case TOKEN_PARAM:
        return true;
    default:
        return false;
    }
}

static void report_unclosed(Parser *p, TokenKind close, uint32_t open)
{
    Diag *diag = parse_error(p, E0202, parse_missing_span(p), "expected %s, found %s",
                             token_kind_name(close), parse_found(p).text);
    diag_frame(p->lexer.sink, diag, parse_span(p, open, open + 1), "to close the `%c` here",
               p->lexer.begin[open]);
}

void parse_close(Parser *p, TokenKind close, uint32_t open)
{
    if (p->panicking) {
        return;
    }
    p->open -= close != TOKEN_RIGHT_BRACE;
    if (parse_accept(p, close)) {
        return;
    }
    uint8_t kind = p->token.kind;
    if (kind == TOKEN_END) {
        report_unclosed(p, close, open);
        parse_give_up(p);
    } else if (kind == TOKEN_RIGHT_BRACE || (p->token.on_new_line && may_begin_item(p))) {
        report_unclosed(p, close, open); // and go on as if it stood here
    } else if (kind == TOKEN_RIGHT_PAREN || kind == TOKEN_RIGHT_BRACKET) {
        report_unclosed(p, close, open);
        parse_advance(p);
    } else {
        p->open += close != TOKEN_RIGHT_BRACE;
        parse_expected(p, close == TOKEN_RIGHT_PAREN ? "`,` or `)`" : "`,` or `]`");
    }
}

// Whether the current token can only begin a value, on the same line as what stands before.
static bool begins_value(const Parser *p)
{
    switch (p->token.kind) {
    case TOKEN_NAME:
    case TOKEN_NUMBER:
    case TOKEN_STRING:
    case TOKEN_COLOR:
    case TOKEN_TRUE:
    case TOKEN_FALSE:
        return !p->token.on_new_line;
    default:
        return false;
    }
}

bool parse_more(Parser *p, TokenKind close)
{
    if (p->panicking) {
        return false;
    }
    if (parse_accept(p, TOKEN_COMMA)) {
        return !parse_at(p, close);
    }
    if (parse_at(p, close) || !begins_value(p)) {
        return false;
    }
    Span at = parse_span(p, p->previous_end, p->previous_end);
    Diag *diag = parse_error(p, E0223, at, "expected `,` before %s", parse_found(p).text);
    diag_label(p->lexer.sink, diag, "a comma is missing");
    diag_suggest(p->lexer.sink, diag, at, ",");
    return true;
}

// Skips a bracket with all that it holds.
static void skip_group(Parser *p)
{
    uint32_t depth = 0;
    do {
        switch (p->token.kind) {
        case TOKEN_LEFT_BRACE:
        case TOKEN_LEFT_PAREN:
        case TOKEN_LEFT_BRACKET:
            ++depth;
            break;
        case TOKEN_RIGHT_BRACE:
        case TOKEN_RIGHT_PAREN:
        case TOKEN_RIGHT_BRACKET:
            --depth;
            break;
        case TOKEN_END:
            return;
        default:
            break;
        }
        parse_advance(p);
    } while (depth > 0);
}

// Whether the current token is a place to go on from.
static bool is_resting_place(const Parser *p)
{
    switch (p->token.kind) {
    case TOKEN_END:
    case TOKEN_RIGHT_BRACE:
    case TOKEN_LET:
    case TOKEN_EXPECT:
    case TOKEN_IMPORT:
    case TOKEN_PARAM:
        return true;
    case TOKEN_FOR:
    case TOKEN_FN:
    case TOKEN_IF:
        return p->token.on_new_line && p->open == 0;
    case TOKEN_NAME: {
        char next = lexer_peek(&p->lexer);
        return p->open == 0 && (p->token.on_new_line || next == ':' || next == '{');
    }
    default:
        return false;
    }
}

void parse_recover(Parser *p, uint32_t before)
{
    p->panicking = false;
    bool opening = parse_at(p, TOKEN_LEFT_BRACE) || parse_at(p, TOKEN_LEFT_PAREN) ||
                   parse_at(p, TOKEN_LEFT_BRACKET);
    if (p->token.begin == before && !opening) { // no item begins with a closing brace
        parse_advance(p);
    }
    while (!is_resting_place(p)) {
        switch (p->token.kind) {
        case TOKEN_LEFT_BRACE:
        case TOKEN_LEFT_PAREN:
        case TOKEN_LEFT_BRACKET:
            skip_group(p);
            break;
        case TOKEN_RIGHT_PAREN:
        case TOKEN_RIGHT_BRACKET:
            p->open -= p->open > 0;
            parse_advance(p);
            break;
        case TOKEN_COMMA:
            if (p->open == 0) {
                return; // the loop over the body takes it
            }
            parse_advance(p);
            break;
        default:
            parse_advance(p);
        }
    }
    p->open = 0;
}

// --- Depth ---------------------------------------------------------------------------------------

bool parse_enter(Parser *p)
{
    if (++p->nesting <= p->most_nesting) {
        return !p->gave_up;
    }
    Diag *diag = parse_error(p, E0701, parse_token_span(p), "nested more than %u levels deep",
                             p->most_nesting);
    parse_note(p, diag, "`--limit nesting=N` allows more");
    parse_give_up(p);
    p->panicking = true;
    return false;
}

bool parse_link(Parser *p, uint32_t other)
{
    p->height = parse_taller(p->height, other) + 1;
    if (p->height <= p->most_height) {
        return true;
    }
    Diag *diag = parse_error(p, E0701, parse_token_span(p),
                             "an expression with more than %u operations in a row", p->most_height);
    parse_note(p, diag, "name a part of it with `let`, or use `sum` over a list");
    parse_give_up(p);
    p->panicking = true;
    return false;
}

// --- Nodes ---------------------------------------------------------------------------------------

void parse_out_of_memory(Parser *p)
{
    longjmp(p->on_oom, 1);
}

uint32_t parse_extra(Parser *p, size_t count, const uint32_t *words)
{
    AstWordArray *extra = &p->ast->extra;
    if (!array_reserve(extra, count)) {
        parse_out_of_memory(p);
    }
    uint32_t first = (uint32_t)extra->count;
    for (size_t i = 0; i < count; ++i) {
        extra->items[first + i] = words[i];
    }
    extra->count += count;
    return first;
}

uint32_t parse_list(Parser *p, size_t mark)
{
    size_t count = p->stack.count - mark;
    AstWordArray *extra = &p->ast->extra;
    if (count == 0) {
        return 0;
    }
    if (!array_reserve(extra, count + 1)) {
        parse_out_of_memory(p);
    }
    uint32_t list = (uint32_t)extra->count;
    extra->items[list] = (uint32_t)count;
    for (size_t i = 0; i < count; ++i) {
        extra->items[list + 1 + i] = p->stack.items[mark + i];
    }
    extra->count += count + 1;
    p->stack.count = mark;
    return list;
}

// --- Start ---------------------------------------------------------------------------------------

void ast_free(Ast *ast)
{
    array_free(&ast->nodes);
    array_free(&ast->extra);
    array_free(&ast->comments);
}

typedef struct Start {
    const Sources *sources;
    uint32_t file;
    Interner *names;
    ParseLimits limits;
    AstCommentArray *comments;
    DiagSink *sink;
} Start;

// The parser's own jump gives its arrays back, so the interner's arena must not take another.
bool parse_guarded(Parser *p, void (*work)(Parser *p, void *with), void *with)
{
    Interner *names = p->lexer.names;
    jmp_buf *outer = names->arena->on_oom;
    names->arena->on_oom = NULL;
    bool good = setjmp(p->on_oom) == 0;
    if (good) {
        work(p, with);
    } else {
        diag_report(p->lexer.sink, E0001, (Span){p->ast->file, 0, 0},
                    "out of memory while parsing");
        p->out_of_memory = true;
        parse_give_up(p);
    }
    p->lexer.names->arena->on_oom = outer;
    return good;
}

static void begin(Parser *p, void *with)
{
    const Start *start = with;
    lexer_init(&p->lexer, source_get(start->sources, start->file), start->file, start->names,
               start->sink, start->comments, &p->on_oom);
    if (!array_push(&p->ast->nodes, (AstNode){0}) || !array_push(&p->ast->extra, 0)) {
        parse_out_of_memory(p);
    }
    lexer_next(&p->lexer, &p->token);
    parse_file_begin(p);
}

static bool too_long(const Start *start)
{
    if (source_get(start->sources, start->file)->text.length < UINT32_MAX - 16) { // excepted: 4 GiB
        return false;
    }
    diag_report(start->sink, E0702, (Span){start->file, 0, 0}, "the file has more than 4 GiB");
    return true;
}

// Fills *p, and *ast with what is known at once.
static void init(Parser *p, Ast *ast, const Start *start)
{
    *ast = (Ast){.file = start->file};
    uint32_t nesting = start->limits.nesting;
    memset(p, 0, sizeof *p);
    p->ast = ast;
    p->most_nesting = nesting < PARSE_NESTING_MOST ? nesting : PARSE_NESTING_MOST;
    p->most_height = 4 * p->most_nesting + PARSE_CHAIN_MOST;
    p->lexer.names = start->names;
    p->lexer.sink = start->sink;
}

static void release(Parser *p)
{
    array_free(&p->stack);
    lexer_free(&p->lexer);
}

static void rest(Parser *p, void *nothing)
{
    (void)nothing;
    while (!parse_at(p, TOKEN_END)) {
        parse_file_item(p);
    }
    p->ast->root = parse_file_end(p);
}

bool parse(Ast *ast, const Sources *sources, uint32_t file, Interner *names, ParseLimits limits,
           bool keep_comments, DiagSink *sink)
{
    Start start = {sources, file, names, limits, keep_comments ? &ast->comments : NULL, sink};
    Parser p;
    init(&p, ast, &start);
    uint32_t errors = sink->errors;
    if (too_long(&start)) { // excepted: that takes a text of 4 GiB
        return false;
    }
    // Literal items have a node for each 5 to 6 bytes and a word for each 8. Room that isn't used
    // is never touched, and so costs no memory; without it the arrays grow as they must.
    size_t length = source_get(sources, file)->text.length;
    (void)array_reserve(&ast->nodes, length / 5);
    (void)array_reserve(&ast->extra, length / 8);
    (void)(parse_guarded(&p, begin, &start) && parse_guarded(&p, rest, NULL));
    release(&p);
    return sink->errors == errors;
}

// --- Bit by bit ----------------------------------------------------------------------------------

Parser *parser_new(Ast *ast, const Sources *sources, uint32_t file, Interner *names,
                   ParseLimits limits, DiagSink *sink)
{
    Start start = {sources, file, names, limits, NULL, sink};
    Parser *p = mem_alloc(1, sizeof *p);
    if (!p) {
        *ast = (Ast){.file = file};
        diag_report(sink, E0001, (Span){file, 0, 0}, "out of memory while parsing");
        return NULL;
    }
    init(p, ast, &start);
    if (too_long(&start)) { // excepted: that takes a text of 4 GiB
        p->token.kind = TOKEN_END;
    } else {
        parse_guarded(p, begin, &start);
    }
    p->repeats = repeats_new(); // without it all is only slower
    return p;
}

void parser_free(Parser *p)
{
    if (p) {
        release(p);
        mem_free(p->repeats);
        mem_free(p);
    }
}

bool parser_has_items(const Parser *p)
{
    return p->stack.count > 0;
}

bool parser_at_end(const Parser *p)
{
    return parse_at(p, TOKEN_END);
}

bool parser_is_out_of_memory(const Parser *p)
{
    return p->out_of_memory;
}

static void read_item(Parser *p, void *nothing)
{
    (void)nothing;
    parse_file_item(p);
}

AstId parser_read_item(Parser *p)
{
    p->item = p->stack.count;
    p->item_nodes = p->ast->nodes.count;
    p->item_extra = p->ast->extra.count;
    const bool good = parse_guarded(p, read_item, NULL);
    return good && p->stack.count > p->item ? p->stack.items[p->item] : 0;
}

void parser_take_out(Parser *p, bool keep_nodes)
{
    p->stack.count = p->item;
    if (!keep_nodes) {
        p->ast->nodes.count = p->item_nodes;
        p->ast->extra.count = p->item_extra;
    }
}

bool parser_finish(Parser *p)
{
    return !p->out_of_memory && parse_guarded(p, rest, NULL);
}
