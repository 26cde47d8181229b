#include "lang/parser_internal.h"

enum { LANGUAGE_VERSION = 1 };

static AstId parse_item(Parser *p);

// --- Declarations --------------------------------------------------------------------------------

bool parse_binding(Parser *p)
{
    if (p->panicking) {
        return false;
    }
    if (parse_accept(p, TOKEN_ASSIGN)) {
        return true;
    }
    if (!parse_at(p, TOKEN_COLON)) {
        parse_expected(p, "`=`");
        return false;
    }
    Span colon = parse_token_span(p);
    parse_advance(p);
    if (parse_at(p, TOKEN_NAME) && lexer_peek(&p->lexer) == '=') {
        Diag *diag = parse_error(p, E0206, parse_span(p, colon.begin, p->token.end),
                                 "only a `param` declares a type");
        parse_suggest(p, diag, parse_span(p, colon.begin, p->token.end), "");
        parse_advance(p);
        parse_advance(p);
    } else {
        Diag *diag = parse_error(p, E0206, colon, "a name is bound with `=`");
        parse_suggest(p, diag, colon, "=");
    }
    return true;
}

// let = "let" NAME "=" expression
static AstId parse_let(Parser *p)
{
    uint32_t begin = p->token.begin;
    parse_advance(p);
    uint32_t name_begin = p->token.begin;
    Symbol symbol = parse_name(p, "a name after `let`");
    uint32_t name_end = parse_name_end(p, name_begin);
    AstId value = parse_binding(p) ? parse_expression(p) : 0;
    ++p->height;
    uint32_t words[] = {name_begin, name_end, value};
    return parse_node(p, AST_LET, begin, symbol, parse_extra(p, 3, words));
}

// import = "import" STRING "as" NAME
static AstId parse_import(Parser *p)
{
    uint32_t begin = p->token.begin;
    parse_advance(p);
    if (!parse_at(p, TOKEN_STRING)) {
        parse_expected(p, "the file to import, as a string");
        return 0;
    }
    uint32_t string_begin = p->token.begin, symbol = p->token.symbol;
    parse_advance(p);
    AstId string = parse_node(p, AST_STRING, string_begin, symbol, 0);
    if (!parse_at(p, TOKEN_AS)) {
        Diag *diag = parse_error(p, E0220, parse_missing_span(p), "an import needs a name");
        parse_note(p, diag, "write `import \"file.scn\" as name`, then use `name.member`");
        p->panicking = true;
        return 0;
    }
    parse_advance(p);
    uint32_t name_begin = p->token.begin;
    Symbol space = parse_name(p, "a name after `as`");
    uint32_t words[] = {space, name_begin, parse_name_end(p, name_begin)};
    p->height = 2;
    return parse_node(p, AST_IMPORT, begin, string, parse_extra(p, 3, words));
}

// ":" NAME "=", the type and the default of a parameter; false after an error
static bool parse_param_type(Parser *p, Token *type)
{
    static const char *const example = "write `param name: type = default in range \"text\"`";
    *type = p->token;
    type->symbol = 0;
    if (parse_accept(p, TOKEN_COLON)) {
        *type = p->token;
        type->symbol = parse_name(p, "a type");
    } else if (parse_at(p, TOKEN_ASSIGN)) {
        parse_note(p, parse_error(p, E0219, parse_token_span(p), "a parameter needs a type"),
                   example);
    }
    if (p->panicking || parse_accept(p, TOKEN_ASSIGN)) {
        return !p->panicking;
    }
    parse_note(p,
               parse_error(p, E0219, parse_missing_span(p), "a parameter needs a %s",
                           type->symbol ? "default" : "type and a default"),
               example);
    p->panicking = true;
    return false;
}

// param = "param" NAME ":" NAME "=" expression [ "in" expression ] [ STRING ]
static AstId parse_param(Parser *p)
{
    uint32_t begin = p->token.begin, tallest = 0;
    parse_advance(p);
    uint32_t name_begin = p->token.begin;
    Symbol symbol = parse_name(p, "a name after `param`");
    uint32_t name_end = parse_name_end(p, name_begin);
    Token type;
    if (p->panicking || !parse_param_type(p, &type)) {
        return 0;
    }
    AstId value = parse_expression(p), range = 0, text = 0;
    tallest = p->height;
    if (!p->panicking && parse_accept(p, TOKEN_IN)) {
        range = parse_expression(p);
        tallest = parse_taller(tallest, p->height);
    }
    if (!p->panicking && parse_at(p, TOKEN_STRING)) {
        uint32_t string_begin = p->token.begin, string = p->token.symbol;
        parse_advance(p);
        text = parse_node(p, AST_STRING, string_begin, string, 0);
    }
    p->height = tallest + 1;
    uint32_t words[] = {name_begin, name_end, type.symbol, value,
                        range,      text,     type.begin,  type.end};
    return parse_node(p, AST_PARAM, begin, symbol, parse_extra(p, 8, words));
}

// --- Functions -----------------------------------------------------------------------------------

// parameter = NAME [ "=" expression ]
static AstId parse_parameter(Parser *p)
{
    uint32_t begin = p->token.begin;
    Symbol symbol = parse_name(p, "the name of a parameter");
    AstId value = 0;
    p->height = 0;
    if (!p->panicking && (parse_at(p, TOKEN_ASSIGN) || parse_at(p, TOKEN_COLON))) {
        (void)parse_binding(p); // which it is, or is taken for
        value = parse_expression(p);
    }
    ++p->height;
    return parse_node(p, AST_PARAMETER, begin, symbol, value);
}

// parameters = "(" [ parameter { "," parameter } [ "," ] ] ")"
static uint32_t parse_parameters(Parser *p)
{
    uint32_t open = p->token.begin, tallest = 0;
    size_t mark = p->stack.count;
    if (!parse_expect(p, TOKEN_LEFT_PAREN)) {
        return 0;
    }
    ++p->open;
    if (!parse_at(p, TOKEN_RIGHT_PAREN)) {
        do {
            parse_push(p, parse_parameter(p));
            tallest = parse_taller(tallest, p->height);
        } while (parse_more(p, TOKEN_RIGHT_PAREN));
    }
    parse_close(p, TOKEN_RIGHT_PAREN, open);
    p->height = tallest;
    return parse_list(p, mark);
}

// fn       = "fn" NAME parameters ( "=" expression | block )
// function = "fn" parameters ( "=" expression | block )
AstId parse_function(Parser *p, uint32_t begin, bool named)
{
    uint32_t name_begin = p->token.begin, name_end = name_begin;
    Symbol symbol = 0;
    if (named) {
        symbol = parse_name(p, "the function's name");
        name_end = parse_name_end(p, name_begin);
    }
    uint32_t parameters = parse_parameters(p), height = p->height;
    AstId body = 0;
    if (p->panicking) {
        return 0;
    }
    if (parse_at(p, TOKEN_LEFT_BRACE)) {
        body = parse_block(p);
    } else if (parse_accept(p, TOKEN_ASSIGN)) {
        body = parse_expression(p);
    } else {
        parse_expected(p, "`=` or `{` before the function's body");
    }
    p->height = parse_taller(p->height, height) + 1;
    uint32_t words[] = {name_begin, name_end, body, parameters};
    return parse_node(p, AST_FN, begin, symbol, parse_extra(p, 4, words));
}

static AstId parse_fn(Parser *p)
{
    uint32_t begin = p->token.begin;
    parse_advance(p);
    return parse_function(p, begin, true);
}

// --- Statements ----------------------------------------------------------------------------------

// The body of a `for` or `if` must be a block; what stands there instead is reported and read.
static AstId parse_required_block(Parser *p, const char *of)
{
    if (p->panicking) {
        return 0;
    }
    if (parse_at(p, TOKEN_LEFT_BRACE)) {
        return parse_block(p);
    }
    parse_error(p, E0215, parse_missing_span(p), "the body of %s stands in braces: `{ … }`", of);
    if (parse_at(p, TOKEN_END) || parse_at(p, TOKEN_RIGHT_BRACE)) {
        return 0;
    }
    (void)parse_enter(p); // as deep as the expression in parentheses before it
    AstId item = parse_item(p);
    parse_leave(p);
    return item;
}

// for = "for" "(" NAME "in" expression ")" block
static AstId parse_for(Parser *p)
{
    uint32_t begin = p->token.begin;
    parse_advance(p);
    uint32_t open = p->token.begin;
    if (parse_expect(p, TOKEN_LEFT_PAREN)) {
        ++p->open;
    }
    uint32_t name_begin = p->token.begin;
    Symbol symbol = parse_name(p, "a name for the element");
    uint32_t name_end = parse_name_end(p, name_begin);
    parse_expect(p, TOKEN_IN);
    AstId sequence = parse_expression(p);
    uint32_t height = p->height;
    parse_close(p, TOKEN_RIGHT_PAREN, open);
    AstId body = parse_required_block(p, "`for`");
    p->height = parse_taller(p->height, height) + 1;
    uint32_t words[] = {name_begin, name_end, sequence, body};
    return parse_node(p, AST_FOR, begin, symbol, parse_extra(p, 4, words));
}

// [ "within" sum [ "%" ] "of" expression ], behind the value; words[0] and [1] of the node
static void parse_within(Parser *p, uint32_t *words, bool *percent)
{
    if (p->panicking || !parse_accept(p, TOKEN_WITHIN)) {
        return;
    }
    uint32_t tallest = p->height;
    words[0] = parse_tolerance(p, percent);
    tallest = parse_taller(tallest, p->height);
    if (p->panicking) {
        return;
    }
    if (!parse_at(p, TOKEN_NAME) || !str_equal(parse_token_text(p), STR("of"))) {
        parse_note(p,
                   parse_error(p, E0224, parse_missing_span(p),
                               "expected `of` behind the tolerance, found %s", parse_found(p).text),
                   "write `expect a within 0.1 of b` or `expect a within 1% of b`");
        p->panicking = true;
        return;
    }
    parse_advance(p);
    words[1] = parse_expression(p);
    p->height = parse_taller(tallest, p->height);
}

// expect = "expect" expression [ "within" sum [ "%" ] "of" expression ]
static AstId parse_expectation(Parser *p)
{
    uint32_t begin = p->token.begin;
    bool percent = false;
    parse_advance(p);
    AstId value = parse_expression(p);
    uint32_t words[3] = {0};
    parse_within(p, words, &percent);
    ++p->height;
    AstId id = parse_node(p, AST_EXPECT, begin, value, parse_extra(p, 3, words));
    p->ast->nodes.items[id].aux = percent;
    return id;
}

static AstId emit_node(Parser *p, AstId value, uint32_t begin)
{
    ++p->height;
    return parse_node(p, AST_EMIT, begin, value, 0);
}

// Behind "if" "(" expression ")" block: [ "else" ( block | if_statement ) ]
static AstId parse_if_blocks(Parser *p, uint32_t begin, AstId condition);

static AstId parse_else_if(Parser *p)
{
    uint32_t begin = p->token.begin;
    parse_advance(p);
    AstId condition = parse_condition(p);
    return p->panicking ? 0 : parse_if_blocks(p, begin, condition);
}

static AstId parse_if_blocks(Parser *p, uint32_t begin, AstId condition)
{
    uint32_t height = p->height;
    AstId branches[2] = {parse_required_block(p, "`if`"), 0};
    height = parse_taller(height, p->height);
    if (!p->panicking && parse_accept(p, TOKEN_ELSE)) {
        if (parse_at(p, TOKEN_IF)) {
            (void)parse_enter(p); // as deep as the condition
            branches[1] = parse_else_if(p);
            parse_leave(p);
        } else {
            branches[1] = parse_required_block(p, "`else`");
        }
    }
    p->height = parse_taller(height, p->height) + 1;
    return parse_node(p, AST_IF, begin, condition, parse_extra(p, 2, branches));
}

// if_statement = "if" "(" expression ")" block [ "else" ( block | if_statement ) ]
// emit         = if_expression | …
static AstId parse_if(Parser *p)
{
    uint32_t begin = p->token.begin;
    parse_advance(p);
    AstId condition = parse_condition(p);
    if (p->panicking) {
        return 0;
    }
    if (parse_at(p, TOKEN_LEFT_BRACE)) {
        return parse_if_blocks(p, begin, condition);
    }
    AstId value = parse_if_branches(p, begin, condition);
    return emit_node(p, value, begin);
}

static bool begins_literal(const Parser *p)
{
    return parse_at(p, TOKEN_NUMBER) || parse_at(p, TOKEN_STRING) || parse_at(p, TOKEN_COLOR) ||
           parse_at(p, TOKEN_TRUE) || parse_at(p, TOKEN_FALSE);
}

// Behind a name that begins an item: `name = value`, or a field where none can stand.
static bool misplaced_value(Parser *p, const Token *name)
{
    if (parse_at(p, TOKEN_ASSIGN)) {
        Diag *diag = parse_error(p, E0208, parse_span(p, name->begin, name->end),
                                 "a name is bound with `let`");
        int length = (int)(name->end - name->begin < 40 ? name->end - name->begin : 40);
        diag_label(p->lexer.sink, diag, "write `let %.*s = …`", length,
                   p->lexer.begin + name->begin);
        parse_suggest(p, diag, parse_span(p, name->begin, name->begin), "let ");
    } else if (parse_at(p, TOKEN_COLON)) {
        if (!p->lost_brace) {
            Diag *diag = parse_error(p, E0222, parse_span(p, name->begin, name->end),
                                     "a field can only stand between a kind's braces");
            parse_note(p, diag, "is a `{` missing before it?");
        }
        p->lost_brace = true;
    } else {
        return false;
    }
    parse_advance(p);
    parse_expression(p);
    return true;
}

static void report_late_header(Parser *p, const Token *name)
{
    parse_error(p, E0210, parse_span(p, name->begin, p->token.end),
                "the header `scn %d` must be the first thing in a file", LANGUAGE_VERSION);
    parse_advance(p);
}

static bool is_scn(const Parser *p, const Token *name)
{
    return name->end - name->begin == 3 && memcmp(p->lexer.begin + name->begin, "scn", 3) == 0;
}

// emit = ( NAME | kind ) { suffix }
static AstId parse_emit(Parser *p, const Token *name)
{
    if (misplaced_value(p, name)) {
        return 0;
    }
    if (is_scn(p, name) && parse_at(p, TOKEN_NUMBER) && !p->token.on_new_line) {
        report_late_header(p, name);
        return 0;
    }
    AstId value = parse_emitted_from(p, name);
    return emit_node(p, value, name->begin);
}

static void report_no_item(Parser *p)
{
    if (p->token.kind != TOKEN_ERROR) {
        Diag *diag = parse_error(p, E0218, parse_token_span(p), "an item can't begin with %s",
                                 parse_found(p).text);
        if (parse_at(p, TOKEN_ELSE)) {
            parse_note(p, diag, "`else` stands directly behind the branch of an `if`");
        } else {
            parse_note(p, diag, "a shape, light, camera or setting can stand as a statement");
        }
    }
    p->panicking = true;
}

// item = let | fn | for | if_statement | expect | emit
static AstId parse_item(Parser *p)
{
    p->height = 0;
    switch (p->token.kind) {
    case TOKEN_NAME: {
        Token name = p->token;
        parse_advance(p);
        return parse_emit(p, &name);
    }
    case TOKEN_LET:
        return parse_let(p);
    case TOKEN_FN:
        return parse_fn(p);
    case TOKEN_FOR:
        return parse_for(p);
    case TOKEN_IF:
        return parse_if(p);
    case TOKEN_EXPECT:
        return parse_expectation(p);
    case TOKEN_IMPORT:
    case TOKEN_PARAM: {
        parse_error(p, E0211, parse_token_span(p), "%s must stand at the top level of a file",
                    parse_found(p).text);
        (void)(parse_at(p, TOKEN_IMPORT) ? parse_import(p) : parse_param(p));
        return 0;
    }
    default:
        report_no_item(p);
        return 0;
    }
}

// --- Bodies --------------------------------------------------------------------------------------

// field = NAME ":" expression, behind the name
static AstId parse_field_value(Parser *p, const Token *name)
{
    if (parse_at(p, TOKEN_ASSIGN)) {
        Diag *diag = parse_error(p, E0205, parse_token_span(p), "fields are given with `:`");
        parse_suggest(p, diag, parse_token_span(p), ":");
        parse_advance(p);
    } else if (!parse_accept(p, TOKEN_COLON)) {
        char text[48];
        int length = (int)(name->end - name->begin);
        snprintf(text, sizeof text, "%.*s", length < 40 ? length : 40,
                 p->lexer.begin + name->begin);
        Diag *diag = parse_error(p, E0204, parse_span(p, name->begin, name->end),
                                 "expected `:` after the field's name `%s`", text);
        diag_label(p->lexer.sink, diag, "write `%s: …`", text);
        parse_suggest(p, diag, parse_span(p, name->end, name->end), ":");
    }
    AstId value = parse_expression(p);
    ++p->height;
    return parse_node(p, AST_FIELD, name->begin, name->symbol, value);
}

// One of the things in a kind's braces, or in those of `with`.
static AstId parse_field_or_item(Parser *p, BodyKind kind)
{
    if (parse_at_reserved_word(p) && lexer_peek(&p->lexer) == ':') {
        parse_error(p, E0207, parse_token_span(p), "%s is a reserved word and can't be a name",
                    parse_found(p).text);
    } else if (!parse_at(p, TOKEN_NAME)) {
        if (kind == BODY_KIND) {
            return parse_item(p);
        }
        parse_expected(p, "a field");
        return 0;
    }
    Token name = p->token;
    parse_advance(p);
    if (kind == BODY_FIELDS || parse_at(p, TOKEN_COLON) || parse_at(p, TOKEN_ASSIGN) ||
        begins_literal(p)) {
        return parse_field_value(p, &name);
    }
    return parse_emit(p, &name);
}

void parse_item_comma(Parser *p)
{
    if (parse_accept(p, TOKEN_COMMA) && parse_at(p, TOKEN_COMMA)) {
        parse_error(p, E0201, parse_token_span(p), "a comma without an item before it");
        while (parse_accept(p, TOKEN_COMMA)) {
        }
    }
}

static void take_stray_bracket(Parser *p)
{
    if (!(p->lost_brace && parse_at(p, TOKEN_RIGHT_BRACE))) {
        parse_error(p, E0203, parse_token_span(p), "this %s closes nothing", parse_found(p).text);
    }
    p->lost_brace = false;
    parse_advance(p);
}

static bool at_stray_bracket(const Parser *p)
{
    return parse_at(p, TOKEN_RIGHT_PAREN) || parse_at(p, TOKEN_RIGHT_BRACKET);
}

// The inside of a pair of braces, up to the closing one.
static void parse_body_items(Parser *p, BodyKind kind)
{
    uint32_t tallest = 0;
    while (!parse_at(p, TOKEN_RIGHT_BRACE) && !parse_at(p, TOKEN_END)) {
        if (at_stray_bracket(p)) {
            take_stray_bracket(p);
            continue;
        }
        uint32_t before = p->token.begin;
        AstId id = kind == BODY_ITEMS ? parse_item(p) : parse_field_or_item(p, kind);
        if (p->panicking) {
            parse_recover(p, before);
        }
        if (id) {
            parse_push(p, id);
        }
        tallest = parse_taller(tallest, p->height);
        parse_item_comma(p);
    }
    p->height = tallest;
}

uint32_t parse_body(Parser *p, BodyKind kind)
{
    uint32_t open_brace = p->token.begin, open = p->open;
    size_t mark = p->stack.count;
    if (parse_enter(p)) {
        parse_advance(p);
        p->open = 0;
        parse_body_items(p, kind);
        p->open = open;
        parse_close(p, TOKEN_RIGHT_BRACE, open_brace);
    }
    parse_leave(p);
    return parse_list(p, mark);
}

// block = "{" { item [ "," ] } "}"
AstId parse_block(Parser *p)
{
    uint32_t begin = p->token.begin;
    uint32_t list = parse_body(p, BODY_ITEMS);
    ++p->height;
    return parse_node(p, AST_BLOCK, begin, list, 0);
}

// --- The file ------------------------------------------------------------------------------------

// file_item = import | param | item
static AstId parse_any_item(Parser *p)
{
    switch (p->token.kind) {
    case TOKEN_IMPORT:
        return parse_import(p);
    case TOKEN_PARAM:
        return parse_param(p);
    default:
        return parse_item(p);
    }
}

void parse_file_item(Parser *p)
{
    if (at_stray_bracket(p) || parse_at(p, TOKEN_RIGHT_BRACE)) {
        take_stray_bracket(p);
        return;
    }
    uint32_t before = p->token.begin;
    AstId id = parse_any_item(p);
    if (p->panicking) {
        parse_recover(p, before);
    }
    if (id) {
        parse_push(p, id);
    }
    parse_item_comma(p);
}

// header = "scn" NUMBER; behind "scn". False where no number follows.
static bool parse_header(Parser *p)
{
    if (!parse_at(p, TOKEN_NUMBER)) {
        return false;
    }
    if (p->token.number != LANGUAGE_VERSION || p->token.unit) {
        Diag *diag = parse_error(p, E0209, parse_token_span(p),
                                 "version %s of the language is not known", parse_found(p).text);
        diag_note(p->lexer.sink, diag, "this program knows version %d", LANGUAGE_VERSION);
    }
    p->ast->version = LANGUAGE_VERSION;
    parse_advance(p);
    parse_item_comma(p);
    return true;
}

// file = [ header [ "," ] ] { file_item [ "," ] }
void parse_file_begin(Parser *p)
{
    Token first = p->token;
    if (!parse_at(p, TOKEN_NAME) || !is_scn(p, &first)) {
        return;
    }
    parse_advance(p);
    if (parse_header(p)) {
        return;
    }
    AstId id = parse_emit(p, &first);
    if (p->panicking) {
        parse_recover(p, first.begin);
    }
    if (id) {
        parse_push(p, id);
    }
    parse_item_comma(p);
}

AstId parse_file_end(Parser *p)
{
    uint32_t items = parse_list(p, 0);
    AstId file = parse_node(p, AST_FILE, 0, items, 0);
    p->ast->nodes.items[file].end = (uint32_t)(p->lexer.end - p->lexer.begin);
    return file;
}
