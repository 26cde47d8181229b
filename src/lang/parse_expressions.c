#include "lang/lexer_internal.h"
#include "lang/parser_internal.h"

// --- Operators -----------------------------------------------------------------------------------

enum {
    POWER_NONE = 0,
#define OPERATOR(id, text, power) POWER_##id = power,
    OPERATORS(OPERATOR)
#undef OPERATOR
        POWER_RANGE = 5,
};

typedef struct Binary {
    uint8_t power; // 0: no binary operator
    uint8_t op;
} Binary;

static const Binary binaries[TOKEN_KIND_COUNT] = {
    [TOKEN_OR] = {POWER_OR, OP_OR},
    [TOKEN_AND] = {POWER_AND, OP_AND},
    [TOKEN_EQUAL] = {POWER_EQUAL, OP_EQUAL},
    [TOKEN_NOT_EQUAL] = {POWER_NOT_EQUAL, OP_NOT_EQUAL},
    [TOKEN_LESS] = {POWER_LESS, OP_LESS},
    [TOKEN_LESS_EQUAL] = {POWER_LESS_EQUAL, OP_LESS_EQUAL},
    [TOKEN_GREATER] = {POWER_GREATER, OP_GREATER},
    [TOKEN_GREATER_EQUAL] = {POWER_GREATER_EQUAL, OP_GREATER_EQUAL},
    [TOKEN_RANGE] = {POWER_RANGE, 0},
    [TOKEN_RANGE_BELOW] = {POWER_RANGE, 1},
    [TOKEN_PLUS] = {POWER_ADD, OP_ADD},
    [TOKEN_MINUS] = {POWER_SUBTRACT, OP_SUBTRACT},
    [TOKEN_STAR] = {POWER_MULTIPLY, OP_MULTIPLY},
    [TOKEN_SLASH] = {POWER_DIVIDE, OP_DIVIDE},
    [TOKEN_PERCENT] = {POWER_MODULO, OP_MODULO},
    [TOKEN_CARET] = {POWER_POWER, OP_POWER},
};

const char *operator_text(Operator op)
{
    static const char *const texts[] = {
#define OPERATOR(id, text, power) text,
        OPERATORS(OPERATOR)
#undef OPERATOR
    };
    return texts[op];
}

static AstId parse_binary(Parser *p, int least);

static AstId binary_node(Parser *p, Binary binary, uint32_t begin, AstId left, AstId right)
{
    bool range = binary.power == POWER_RANGE;
    AstId id = parse_node(p, range ? AST_RANGE : AST_BINARY, begin, left, right);
    AstNode *node = &p->ast->nodes.items[id];
    node->op = range ? 0 : binary.op;
    node->aux = range ? binary.op : 0;
    return id;
}

static void report_chained(Parser *p, Binary binary)
{
    Diag *diag = parse_error(p, E0213, parse_token_span(p),
                             binary.power == POWER_RANGE ? "ranges do not chain"
                                                         : "comparisons do not chain");
    parse_note(p, diag,
               binary.power == POWER_RANGE ? "a range has two ends: `a..b` or `a..<b`"
                                           : "write `a < b and b < c`");
}

// Whether the operator at hand is the `%` of a tolerance: `within 1% of b`.
static bool at_percent(const Parser *p)
{
    return parse_at(p, TOKEN_PERCENT) && p->tolerance == p->nesting &&
           lexer_peek_word(&p->lexer, STR("of"));
}

// The operators that bind at least as tightly as `least`, behind an operand.
static AstId parse_operators(Parser *p, AstId left, uint32_t begin, int least)
{
    int before = POWER_NONE;
    while (!p->panicking) {
        Binary binary = binaries[p->token.kind];
        if (binary.power == POWER_NONE || binary.power < least || at_percent(p)) {
            break;
        }
        if (binary.power == before &&
            (binary.power == POWER_EQUAL || binary.power == POWER_RANGE)) {
            report_chained(p, binary);
        }
        before = binary.power;
        uint32_t height = p->height;
        parse_advance(p);
        AstId right;
        if (binary.power == POWER_POWER) { // binds to the right, and takes a sign there
            right = parse_enter(p) ? parse_binary(p, POWER_NEGATE) : 0;
            parse_leave(p);
        } else {
            right = parse_binary(p, binary.power + 1);
        }
        if (!parse_link(p, height)) {
            return left;
        }
        left = binary_node(p, binary, begin, left, right);
    }
    return left;
}

// --- Primaries -----------------------------------------------------------------------------------

// Whether the current token, a name behind a number, is a unit that stands apart: no item or field
// begins with it.
static bool is_detached_unit(const Parser *p)
{
    const char *text = p->lexer.begin + p->token.begin;
    if (!lexer_find_unit(&p->lexer, text, p->token.end - p->token.begin)) {
        return false;
    }
    char next = lexer_peek(&p->lexer);
    if (next && strchr(":{([.=", next)) {
        return false;
    }
    const char *rest = p->lexer.at, *end = p->lexer.end;
    while (rest < end && (*rest == ' ' || *rest == '\t' || *rest == '\n' || *rest == '\r')) {
        ++rest;
    }
    bool with = end - rest >= 4 && memcmp(rest, "with", 4) == 0 &&
                (end - rest == 4 || !char_is(rest[4], CHAR_LETTER | CHAR_DIGIT));
    return !with;
}

// NUMBER
static AstId parse_number(Parser *p)
{
    Token number = p->token;
    parse_advance(p);
    if (parse_at(p, TOKEN_NAME) && !p->token.on_new_line && !number.unit && is_detached_unit(p)) {
        const char *text = p->lexer.begin + p->token.begin;
        int length = (int)(p->token.end - p->token.begin);
        Diag *diag =
            parse_error(p, E0112, parse_token_span(p),
                        "the unit `%.*s` must stand directly behind its number", length, text);
        diag_label(p->lexer.sink, diag, "remove the blank before it");
        parse_suggest(p, diag, parse_span(p, number.end, p->token.begin), "");
        number.unit = lexer_find_unit(&p->lexer, text, (size_t)length);
        parse_advance(p);
    }
    AstId id = parse_node(p, AST_NUMBER, number.begin, 0, 0);
    AstNode *node = &p->ast->nodes.items[id];
    node->aux = number.unit;
    memcpy((char *)node + offsetof(AstNode, a), &number.number, sizeof number.number);
    return id;
}

// parenthesized = "(" expression ")"
// vector = "(" expression "," expression [ "," expression ] [ "," expression ] [ "," ] ")"
static AstId parse_vector(Parser *p)
{
    uint32_t begin = p->token.begin, tallest = 0;
    size_t mark = p->stack.count;
    parse_advance(p);
    ++p->open;
    AstId first = 0;
    bool comma = false;
    if (!parse_at(p, TOKEN_RIGHT_PAREN)) {
        do {
            first = parse_expression(p);
            tallest = parse_taller(tallest, p->height);
            parse_push(p, first);
            comma = parse_at(p, TOKEN_COMMA);
        } while (parse_more(p, TOKEN_RIGHT_PAREN));
    }
    parse_close(p, TOKEN_RIGHT_PAREN, begin);
    size_t count = p->stack.count - mark;
    p->height = tallest + 1;
    if (count == 1 && !comma) {
        p->stack.count = mark;
        --p->height;
        return first;
    }
    if (count < 2 || count > 4) {
        Diag *diag = parse_error(p, E0212, parse_span(p, begin, p->previous_end),
                                 "a vector has two, three or four components, not %zu", count);
        parse_note(p, diag, count > 4 ? "a list is written `[…]`" : "write `(x, y, z)`");
        p->stack.count = mark + (count < 4 ? count : 4); // no node has more
    }
    uint32_t list = parse_list(p, mark);
    return parse_node(p, AST_VECTOR, begin, list, 0);
}

static AstId parse_element(Parser *p);

// "for" "(" NAME "in" expression ")" element
static AstId parse_element_for(Parser *p)
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
    AstId body = parse_element(p);
    p->height = parse_taller(p->height, height) + 1;
    uint32_t words[] = {name_begin, name_end, sequence, body};
    return parse_node(p, AST_FOR, begin, symbol, parse_extra(p, 4, words));
}

// "if" "(" expression ")" element [ "else" element ]
static AstId parse_element_if(Parser *p)
{
    uint32_t begin = p->token.begin;
    parse_advance(p);
    AstId condition = parse_condition(p);
    uint32_t height = p->height;
    AstId branches[2] = {parse_element(p), 0};
    height = parse_taller(height, p->height);
    if (!p->panicking && parse_accept(p, TOKEN_ELSE)) {
        branches[1] = parse_element(p);
    }
    p->height = parse_taller(height, p->height) + 1;
    return parse_node(p, AST_IF, begin, condition, parse_extra(p, 2, branches));
}

// element = "for" … | "if" … | expression
static AstId parse_element(Parser *p)
{
    AstId id = 0;
    if (p->panicking) {
        return 0;
    }
    if (parse_at(p, TOKEN_FOR)) {
        id = parse_enter(p) ? parse_element_for(p) : 0;
        parse_leave(p);
    } else if (parse_at(p, TOKEN_IF)) {
        id = parse_enter(p) ? parse_element_if(p) : 0;
        parse_leave(p);
    } else {
        id = parse_expression(p);
    }
    return id;
}

// list = "[" [ element { "," element } [ "," ] ] "]"
static AstId parse_list_literal(Parser *p)
{
    uint32_t begin = p->token.begin, tallest = 0;
    size_t mark = p->stack.count;
    parse_advance(p);
    ++p->open;
    if (!parse_at(p, TOKEN_RIGHT_BRACKET)) {
        do {
            parse_push(p, parse_element(p));
            tallest = parse_taller(tallest, p->height);
        } while (parse_more(p, TOKEN_RIGHT_BRACKET));
    }
    parse_close(p, TOKEN_RIGHT_BRACKET, begin);
    p->height = tallest + 1;
    uint32_t list = parse_list(p, mark);
    return parse_node(p, AST_LIST, begin, list, 0);
}

// kind = NAME "{" { ( field | item ) [ "," ] } "}", or just NAME
static AstId parse_named(Parser *p, const Token *name)
{
    if (!parse_at(p, TOKEN_LEFT_BRACE)) {
        p->height = 1;
        return parse_node(p, AST_NAME, name->begin, name->symbol, 0);
    }
    uint32_t list = parse_body(p, BODY_KIND);
    ++p->height;
    return parse_node(p, AST_KIND, name->begin, name->symbol, list);
}

static AstId parse_leaf(Parser *p, AstTag tag, uint32_t a)
{
    uint32_t begin = p->token.begin;
    parse_advance(p);
    return parse_node(p, tag, begin, a, 0);
}

// primary = NUMBER | STRING | COLOR | "true" | "false" | NAME | kind | parenthesized | vector
//         | list
static AstId parse_primary(Parser *p)
{
    p->height = 1;
    switch (p->token.kind) {
    case TOKEN_NUMBER:
        return parse_number(p);
    case TOKEN_STRING:
        return parse_leaf(p, AST_STRING, p->token.symbol);
    case TOKEN_COLOR:
        return parse_leaf(p, AST_COLOR, p->token.color);
    case TOKEN_TRUE:
    case TOKEN_FALSE:
        return parse_leaf(p, AST_BOOL, p->token.kind == TOKEN_TRUE);
    case TOKEN_NAME: {
        Token name = p->token;
        parse_advance(p);
        return parse_named(p, &name);
    }
    case TOKEN_LEFT_PAREN:
        return parse_vector(p);
    case TOKEN_LEFT_BRACKET:
        return parse_list_literal(p);
    default: {
        uint32_t begin = p->token.begin;
        parse_expected(p, "a value");
        return parse_node(p, AST_ERROR, begin < p->previous_end ? begin : p->previous_end, 0, 0);
    }
    }
}

// --- Suffixes ------------------------------------------------------------------------------------

// argument = [ NAME ":" ] expression
static AstId parse_argument(Parser *p, bool *named)
{
    if (!parse_at(p, TOKEN_NAME)) {
        return parse_expression(p);
    }
    Token name = p->token;
    parse_advance(p);
    if (parse_at(p, TOKEN_ASSIGN)) {
        Diag *diag = parse_error(p, E0205, parse_token_span(p), "arguments are named with `:`");
        parse_suggest(p, diag, parse_token_span(p), ":");
    } else if (!parse_at(p, TOKEN_COLON)) {
        return parse_expression_from(p, &name);
    }
    *named = true;
    parse_advance(p);
    AstId value = parse_expression(p);
    ++p->height;
    return parse_node(p, AST_ARGUMENT, name.begin, name.symbol, value);
}

// "(" [ argument { "," argument } [ "," ] ] ")", positional ones first
static uint32_t parse_arguments(Parser *p)
{
    uint32_t open = p->token.begin, tallest = 0;
    size_t mark = p->stack.count;
    bool any_named = false;
    parse_advance(p);
    ++p->open;
    if (!parse_at(p, TOKEN_RIGHT_PAREN)) {
        do {
            bool named = false;
            uint32_t begin = p->token.begin;
            parse_push(p, parse_argument(p, &named));
            tallest = parse_taller(tallest, p->height);
            if (any_named && !named) {
                parse_error(p, E0216, parse_span(p, begin, p->previous_end),
                            "an argument by position can't follow one by name");
            }
            any_named = any_named || named;
        } while (parse_more(p, TOKEN_RIGHT_PAREN));
    }
    parse_close(p, TOKEN_RIGHT_PAREN, open);
    p->height = tallest;
    return parse_list(p, mark);
}

static AstId parse_index(Parser *p, AstId value, uint32_t begin)
{
    uint32_t open = p->token.begin;
    parse_advance(p);
    ++p->open;
    AstId index = parse_expression(p);
    parse_close(p, TOKEN_RIGHT_BRACKET, open);
    return parse_node(p, AST_INDEX, begin, value, index);
}

static AstId parse_suffix(Parser *p, AstId value, uint32_t begin)
{
    switch (p->token.kind) {
    case TOKEN_DOT: {
        parse_advance(p);
        Symbol symbol = parse_name(p, "a name");
        return parse_node(p, AST_MEMBER, begin, value, symbol);
    }
    case TOKEN_LEFT_BRACKET:
        return parse_index(p, value, begin);
    case TOKEN_LEFT_PAREN: {
        uint32_t arguments = parse_arguments(p);
        return parse_node(p, AST_CALL, begin, value, arguments);
    }
    default: { // with
        parse_advance(p);
        if (!parse_at(p, TOKEN_LEFT_BRACE)) {
            parse_expected(p, "`{` after `with`");
            return value;
        }
        uint32_t fields = parse_body(p, BODY_FIELDS);
        return parse_node(p, AST_WITH, begin, value, fields);
    }
    }
}

// { "." NAME | "[" expression "]" | "(" arguments ")" | "with" "{" { field [ "," ] } "}" }
static AstId parse_suffixes(Parser *p, AstId value, uint32_t begin)
{
    while (!p->panicking && (parse_at(p, TOKEN_DOT) || parse_at(p, TOKEN_LEFT_PAREN) ||
                             parse_at(p, TOKEN_LEFT_BRACKET) || parse_at(p, TOKEN_WITH))) {
        uint32_t height = p->height;
        value = parse_suffix(p, value, begin);
        if (!parse_link(p, height)) {
            break;
        }
    }
    return value;
}

// --- Expressions ---------------------------------------------------------------------------------

static AstId parse_unary(Parser *p, Operator op, int least)
{
    uint32_t begin = p->token.begin;
    parse_advance(p);
    AstId operand = parse_enter(p) ? parse_binary(p, least) : 0;
    parse_leave(p);
    ++p->height;
    AstId id = parse_node(p, AST_UNARY, begin, operand, 0);
    p->ast->nodes.items[id].op = (uint8_t)op;
    return id;
}

// An `if`, `fn` or `not` where an operand must stand.
static void report_needs_parentheses(Parser *p)
{
    Diag *diag = parse_error(p, E0217, parse_token_span(p), "%s as an operand needs parentheses",
                             parse_found(p).text);
    parse_note(p, diag, "`if`, `fn` and `not` reach as far to the right as they can");
}

// unary = "-" unary | power    not_expression = "not" not_expression | comparison
static AstId parse_operand(Parser *p, int least)
{
    switch (p->token.kind) {
    case TOKEN_MINUS:
        return parse_unary(p, OP_NEGATE, POWER_NEGATE);
    case TOKEN_NOT:
        if (least > POWER_NOT) {
            report_needs_parentheses(p);
        }
        return parse_unary(p, OP_NOT, POWER_NOT);
    case TOKEN_IF:
    case TOKEN_FN:
        report_needs_parentheses(p);
        return parse_expression(p);
    default: {
        uint32_t begin = p->token.begin;
        AstId value = parse_primary(p);
        return parse_suffixes(p, value, begin);
    }
    }
}

// or_expression  = and_expression { "or" and_expression }
// and_expression = not_expression { "and" not_expression }
// comparison     = range [ ( "==" | "!=" | "<" | "<=" | ">" | ">=" ) range ]
// range          = sum [ ( ".." | "..<" ) sum ]
// sum            = product { ( "+" | "-" ) product }
// product        = unary { ( "*" | "/" | "%" ) unary }
// power          = postfix [ "^" unary ]
static AstId parse_binary(Parser *p, int least)
{
    uint32_t begin = p->token.begin;
    AstId left = parse_operand(p, least);
    return parse_operators(p, left, begin, least);
}

AstId parse_tolerance(Parser *p, bool *percent)
{
    uint32_t outer = p->tolerance;
    (void)parse_enter(p); // as deep as the value before `within`
    p->tolerance = p->nesting;
    AstId value = parse_binary(p, POWER_ADD);
    *percent = !p->panicking && at_percent(p);
    if (*percent) {
        parse_advance(p);
    }
    p->tolerance = outer;
    parse_leave(p);
    return value;
}

// An `=` behind an expression was meant to compare.
static AstId parse_assignment(Parser *p, AstId left, uint32_t begin)
{
    Diag *diag = parse_error(p, E0221, parse_token_span(p), "`=` does not compare");
    parse_suggest(p, diag, parse_token_span(p), "==");
    uint32_t height = p->height;
    parse_advance(p);
    AstId right = parse_expression(p);
    return parse_link(p, height) ? binary_node(p, binaries[TOKEN_EQUAL], begin, left, right) : left;
}

AstId parse_condition(Parser *p)
{
    uint32_t open = p->token.begin;
    if (!parse_at(p, TOKEN_LEFT_PAREN)) {
        parse_expected(p, "`(` before the condition");
        return 0;
    }
    parse_advance(p);
    ++p->open;
    AstId condition = parse_expression(p);
    parse_close(p, TOKEN_RIGHT_PAREN, open);
    return condition;
}

AstId parse_if_branches(Parser *p, uint32_t begin, AstId condition)
{
    uint32_t height = p->height;
    AstId branches[2] = {parse_expression(p), 0};
    height = parse_taller(height, p->height);
    if (!p->panicking && !parse_at(p, TOKEN_ELSE)) {
        Diag *diag = parse_error(p, E0214, parse_span(p, begin, begin + 2),
                                 "an `if` that stands for a value needs an `else`");
        parse_note(p, diag, "write `if (condition) a else b`");
    } else if (!p->panicking) {
        parse_advance(p);
        branches[1] = parse_expression(p);
    }
    p->height = parse_taller(height, p->height) + 1;
    return parse_node(p, AST_IF, begin, condition, parse_extra(p, 2, branches));
}

// expression = if_expression | function | or_expression
// if_expression = "if" "(" expression ")" expression "else" expression
static AstId parse_any_expression(Parser *p)
{
    uint32_t begin = p->token.begin;
    AstId value;
    if (parse_at(p, TOKEN_IF)) {
        parse_advance(p);
        AstId condition = parse_condition(p);
        value = parse_if_branches(p, begin, condition);
    } else if (parse_at(p, TOKEN_FN)) {
        parse_advance(p);
        value = parse_function(p, begin, false);
    } else {
        value = parse_binary(p, POWER_OR);
    }
    bool assigned = parse_at(p, TOKEN_ASSIGN) && !p->token.on_new_line && !p->panicking;
    return assigned ? parse_assignment(p, value, begin) : value;
}

// Whether a token goes on with the expression before it.
static inline bool goes_on(uint8_t kind)
{
    return binaries[kind].power || kind == TOKEN_DOT || kind == TOKEN_LEFT_PAREN ||
           kind == TOKEN_LEFT_BRACKET || kind == TOKEN_WITH || kind == TOKEN_ASSIGN;
}

// The rest of an expression behind its first primary.
static AstId parse_rest(Parser *p, AstId value, uint32_t begin)
{
    if (!goes_on(p->token.kind)) {
        return value;
    }
    value = parse_suffixes(p, value, begin);
    value = parse_operators(p, value, begin, POWER_OR);
    bool assigned = parse_at(p, TOKEN_ASSIGN) && !p->token.on_new_line && !p->panicking;
    return assigned ? parse_assignment(p, value, begin) : value;
}

AstId parse_expression(Parser *p)
{
    if (p->panicking) {
        return 0;
    }
    AstId value = 0;
    if (parse_enter(p)) {
        if (parse_at(p, TOKEN_NUMBER)) { // the common case, on a short way
            uint32_t begin = p->token.begin;
            p->height = 1;
            value = parse_number(p);
            value = parse_rest(p, value, begin);
        } else {
            value = parse_any_expression(p);
        }
    }
    parse_leave(p);
    return value;
}

AstId parse_expression_from(Parser *p, const Token *name)
{
    AstId value = 0;
    if (parse_enter(p)) {
        value = parse_rest(p, parse_named(p, name), name->begin);
    }
    parse_leave(p);
    return value;
}

AstId parse_emitted_from(Parser *p, const Token *name)
{
    AstId value = 0;
    if (parse_enter(p)) {
        value = parse_suffixes(p, parse_named(p, name), name->begin);
    }
    parse_leave(p);
    return value;
}
