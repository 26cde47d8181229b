// Numbers, strings and colours.
#include "lang/lexer_internal.h"

#include "base/decimal.h"
#include "base/utf8.h"
#include "schema/schema.h"

#include <math.h>

// --- Numbers -------------------------------------------------------------------------------------

// What people write for a unit.
static const char *const unit_words[][2] = {
    {"degree", "deg"}, {"degrees", "deg"},  {"radian", "rad"},   {"radians", "rad"},
    {"turns", "turn"}, {"meter", "m"},      {"meters", "m"},     {"metre", "m"},
    {"metres", "m"},   {"micron", "um"},    {"sec", "s"},        {"second", "s"},
    {"seconds", "s"},  {"kelvin", "K"},     {"watt", "W"},       {"watts", "W"},
    {"lumen", "lm"},   {"lumens", "lm"},    {"candela", "cd"},   {"lux", "lx"},
    {"nits", "nit"},   {"\xc2\xb0", "deg"}, {"\xc2\xb5m", "um"}, {"\xce\xbcm", "um"},
};

static const char *suggest_unit(Str written)
{
    for (size_t i = 0; i < sizeof unit_words / sizeof *unit_words; ++i) {
        if (str_equal(written, str_from(unit_words[i][0]))) {
            return unit_words[i][1];
        }
    }
    const char *best = NULL;
    size_t best_distance = 2;
    for (size_t i = 0; i < schema_unit_count && written.length > 1; ++i) {
        size_t distance = str_distance(written, str_from(schema_units[i].name), 2);
        if (distance < best_distance) {
            best_distance = distance;
            best = schema_units[i].name;
        }
    }
    for (size_t i = 0; i < schema_unit_count && !best && written.length == 1; ++i) {
        const char *name = schema_units[i].name; // a letter in the wrong case
        if (!name[1] && (name[0] ^ written.at[0]) == ('a' ^ 'A')) {
            best = name;
        }
    }
    return best;
}

static void report_unit(Lexer *lexer, const char *begin, const char *end)
{
    Str written = {begin, (size_t)(end - begin)};
    Span at = lexer_span(lexer, begin, end);
    Diag *diag = diag_report(lexer->sink, E0111, at, "`%.*s` is not a unit",
                             (int)(written.length < 40 ? written.length : 40), begin);
    const char *near = suggest_unit(written);
    if (near) {
        diag_suggest(lexer->sink, diag, at, near);
    }
    diag_note(lexer->sink, diag,
              "the units are deg rad turn, km m cm mm um nm, s ms, K, W kW, lm cd lx nit");
}

static void report_number(Lexer *lexer, const char *begin, const char *end, const char *why)
{
    diag_report(lexer->sink, E0109, lexer_span(lexer, begin, end), "%s", why);
}

// Letters, digits and characters beyond ASCII directly behind a number: its unit.
static const char *unit_end(const char *at, const char *end)
{
    while (at < end && (char_is(*at, CHAR_LETTER | CHAR_DIGIT) || (unsigned char)*at >= 0x80)) {
        ++at;
    }
    return at;
}

static void unit(Lexer *lexer, Token *token)
{
    const char *begin = lexer->at, *end = unit_end(begin, lexer->end);
    if (begin == end) {
        return;
    }
    lexer->at = end;
    token->unit = lexer_find_unit(lexer, begin, (size_t)(end - begin));
    if (token->unit) {
        return;
    }
    if (end - begin == 1 && (*begin == 'e' || *begin == 'E')) {
        report_number(lexer, begin, end, "digits must follow the `e` of an exponent");
    } else if (*begin == '_') {
        report_number(lexer, begin, begin + 1, "`_` may only stand between two digits");
    } else {
        report_unit(lexer, begin, end);
    }
}

typedef struct Decimal {
    uint64_t mantissa; // of the first 19 significant digits
    int digits;        // in it
    int64_t exponent;  // of the mantissa's last digit
    bool inexact;      // there were more digits
} Decimal;

// Digits with `_` between them; the first stands at `at`, so that one stands before each `_`.
static const char *read_digits(const Lexer *lexer, const char *at, Decimal *decimal, bool fraction)
{
    for (; at < lexer->end; ++at) {
        if (*at == '_' && at + 1 < lexer->end && char_is(at[1], CHAR_DIGIT)) {
            continue;
        }
        if (!char_is(*at, CHAR_DIGIT)) {
            break;
        }
        if (decimal->digits < 19) {
            decimal->mantissa = decimal->mantissa * 10 + (uint64_t)(*at - '0');
            decimal->digits += decimal->mantissa != 0;
            decimal->exponent -= fraction;
        } else {
            decimal->inexact = true;
            decimal->exponent += !fraction;
        }
    }
    return at;
}

// `e`, a sign, digits. Returns `at` where that doesn't follow.
static const char *read_exponent(const Lexer *lexer, const char *at, Decimal *decimal)
{
    const char *end = lexer->end, *digits = at + 1;
    if (at >= end || (*at != 'e' && *at != 'E')) {
        return at;
    }
    bool negative = digits < end && *digits == '-';
    digits += digits < end && (*digits == '-' || *digits == '+');
    if (digits >= end || !char_is(*digits, CHAR_DIGIT)) {
        return at;
    }
    int64_t exponent = 0;
    for (; digits < end && char_is(*digits, CHAR_DIGIT); ++digits) {
        exponent = exponent < 100000 ? exponent * 10 + (*digits - '0') : exponent;
    }
    decimal->exponent += negative ? -exponent : exponent;
    return digits;
}

static bool point_follows(const Lexer *lexer, const char *at)
{
    return lexer->end - at > 1 && *at == '.' && char_is(at[1], CHAR_DIGIT);
}

// Behind a number that ends in a point, or has an exponent with a sign but no digits.
static void check_ending(Lexer *lexer, const char *begin)
{
    const char *at = lexer->at, *end = lexer->end;
    if (end - at >= 1 && *at == '.' && (end - at < 2 || at[1] != '.')) {
        bool name = end - at >= 2 && char_is(at[1], CHAR_LETTER);
        if (!name) {
            report_number(lexer, begin, at + 1, "a digit must follow the point of a number");
            ++lexer->at;
        }
    } else if (end - at >= 2 && (*at == 'e' || *at == 'E') && (at[1] == '-' || at[1] == '+')) {
        report_number(lexer, at, at + 2, "digits must follow the `e` of an exponent");
        lexer->at += 2;
    }
}

// Any number: with `_`, an exponent, many digits, or mistakes.
static void any_number(Lexer *lexer, Token *token)
{
    const char *begin = lexer->at, *at = begin;
    Decimal decimal = {0};
    if (*at == '.') {
        Diag *diag = diag_report(lexer->sink, E0117, lexer_span(lexer, at, at + 1),
                                 "a number must begin with a digit");
        diag_suggest(lexer->sink, diag, lexer_span(lexer, at, at + 1), "0.");
    } else {
        at = read_digits(lexer, at, &decimal, false);
    }
    if (point_follows(lexer, at)) {
        at = read_digits(lexer, at + 1, &decimal, true);
    }
    at = lexer->at = read_exponent(lexer, at, &decimal);
    bool small = decimal.exponent > -400 && decimal.exponent < 400;
    if (decimal.inexact || !small ||
        !decimal_from_parts(decimal.mantissa, (int)decimal.exponent, &token->number)) {
        token->number = decimal_read(begin, at);
    }
    if (isinf(token->number)) {
        diag_report(lexer->sink, E0110, lexer_span(lexer, begin, at),
                    "this number is too large: the largest is about 1.8e308");
        token->number = 0;
    } else if (token->number == 0 && decimal.mantissa != 0) {
        diag_report(lexer->sink, E0110, lexer_span(lexer, begin, at),
                    "this number is too small: the smallest beside 0 is about 4.9e-324");
    }
    check_ending(lexer, begin);
    unit(lexer, token);
}

const char *lexer_plain_number(const char *at, const char *end, double *out)
{
    const char *begin = at;
    uint64_t mantissa = 0;
    int exponent = 0;
    while (at < end && char_is(*at, CHAR_DIGIT)) {
        mantissa = mantissa * 10 + (uint64_t)(*at++ - '0');
    }
    if (at > begin && end - at > 1 && *at == '.' && char_is(at[1], CHAR_DIGIT)) {
        const char *point = at++;
        while (at < end && char_is(*at, CHAR_DIGIT)) {
            mantissa = mantissa * 10 + (uint64_t)(*at++ - '0');
        }
        exponent = (int)(point + 1 - at);
    }
    const bool ends =
        at == end || (!char_is(*at, CHAR_LETTER) && *at != '.' && (unsigned char)*at < 0x80);
    return ends && at > begin && at - begin <= 19 && decimal_from_parts(mantissa, exponent, out)
               ? at
               : NULL;
}

// number = digits [ "." digits ] [ "e" [ "+" | "-" ] digits ] [ unit ]
void lexer_number(Lexer *lexer, Token *token)
{
    token->kind = TOKEN_NUMBER;
    const char *at = lexer_plain_number(lexer->at, lexer->end, &token->number);
    if (at) {
        lexer->at = at;
    } else {
        any_number(lexer, token);
    }
}

// --- Strings -------------------------------------------------------------------------------------

static void append(Lexer *lexer, const char *bytes, size_t count)
{
    if (count == 0) {
        return;
    }
    if (!array_reserve(&lexer->scratch, count)) {
        longjmp(*lexer->on_oom, 1);
    }
    memcpy(lexer->scratch.items + lexer->scratch.count, bytes, count);
    lexer->scratch.count += count;
}

static uint32_t hex_value(char c)
{
    return (uint32_t)(c <= '9' ? c - '0' : (c | 0x20) - 'a' + 10);
}

// \u{1F600}: one to six hexadecimal digits of a Unicode scalar value. `at` is behind the `u`.
static const char *unicode_escape(Lexer *lexer, const char *at)
{
    const char *begin = at - 2;
    uint32_t code = 0;
    int digits = 0;
    if (at < lexer->end && *at == '{') {
        for (++at; at < lexer->end && char_is(*at, CHAR_HEX); ++at, ++digits) {
            code = digits < 6 ? code << 4 | hex_value(*at) : UINT32_MAX;
        }
    }
    bool closed = digits > 0 && at < lexer->end && *at == '}';
    at += closed;
    if (!closed) {
        diag_report(lexer->sink, E0107, lexer_span(lexer, begin, at),
                    "a Unicode escape is written `\\u{…}` with one to six hexadecimal digits");
    } else if (digits > 6 || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff)) {
        diag_report(lexer->sink, E0107, lexer_span(lexer, begin, at),
                    "there is no such Unicode character");
    } else {
        char bytes[4];
        append(lexer, bytes, (size_t)utf8_encode(code, bytes));
    }
    return at;
}

// `at` is behind the backslash.
static const char *escape(Lexer *lexer, const char *at)
{
    if (at == lexer->end || *at == '\n' || *at == '\r') {
        return at; // the string isn't closed, which is reported
    }
    switch (*at) {
    case 'n':
        append(lexer, "\n", 1);
        return at + 1;
    case 't':
        append(lexer, "\t", 1);
        return at + 1;
    case '"':
    case '\\':
        append(lexer, at, 1);
        return at + 1;
    case 'u':
        return unicode_escape(lexer, at + 1);
    default: {
        uint32_t code;
        const char *stop = at + utf8_decode(at, lexer->end, &code);
        Diag *diag = diag_report(lexer->sink, E0106, lexer_span(lexer, at - 1, stop),
                                 "there is no escape `\\%.*s`", (int)(stop - at), at);
        diag_note(lexer->sink, diag, "the escapes are \\n \\t \\\" \\\\ \\u{…}");
        return stop;
    }
    }
}

// string = '"' { character | escape } '"', on one line
void lexer_string(Lexer *lexer, Token *token)
{
    const char *begin = lexer->at, *at = begin + 1, *run = at, *end = lexer->end;
    lexer->scratch.count = 0;
    bool escaped = false;
    while (at < end && *at != '"' && *at != '\n' &&
           !(*at == '\r' && end - at > 1 && at[1] == '\n')) {
        if (*at == '\\') {
            escaped = true;
            append(lexer, run, (size_t)(at - run));
            run = at = escape(lexer, at + 1);
        } else if ((unsigned char)*at < 0x20 && *at != '\t') {
            diag_report(lexer->sink, E0116, lexer_span(lexer, at, at + 1),
                        "a control character (0x%02x) in a string", (unsigned char)*at);
            ++at;
        } else {
            ++at;
        }
    }
    token->kind = TOKEN_STRING;
    bool closed = at < end && *at == '"';
    if (escaped) {
        append(lexer, run, (size_t)(at - run));
        const char *text = lexer->scratch.count ? lexer->scratch.items : "";
        token->symbol = lexer_intern(lexer, text, text + lexer->scratch.count);
    } else {
        token->symbol = lexer_intern(lexer, run, at);
    }
    lexer->at = at + closed;
    if (!closed) {
        Diag *diag = diag_report(lexer->sink, E0105, lexer_span(lexer, begin, at),
                                 "this string is not closed on its line");
        diag_label(lexer->sink, diag, "expected `\"`");
        diag_suggest(lexer->sink, diag, lexer_span(lexer, at, at), "\"");
    }
}

// --- Colours -------------------------------------------------------------------------------------

// color = "#" hex hex hex [ hex hex hex ]
void lexer_color(Lexer *lexer, Token *token)
{
    const char *begin = lexer->at, *at = begin + 1;
    uint32_t value = 0;
    bool good = true;
    for (; at < lexer->end && char_is(*at, CHAR_LETTER | CHAR_DIGIT); ++at) {
        good = good && char_is(*at, CHAR_HEX);
        value = good ? value << 4 | hex_value(*at) : 0;
    }
    token->kind = TOKEN_COLOR;
    lexer->at = at;
    size_t digits = (size_t)(at - begin - 1);
    if (!good || (digits != 3 && digits != 6)) {
        Diag *diag = diag_report(lexer->sink, E0113, lexer_span(lexer, begin, at),
                                 "a color is `#` and three or six hexadecimal digits");
        if (digits == 0) {
            diag_note(lexer->sink, diag, "comments begin with `//`");
            const char *newline = memchr(at, '\n', (size_t)(lexer->end - at));
            lexer->at = newline ? newline : lexer->end;
            token->kind = TOKEN_ERROR;
        } else if (good && (digits == 4 || digits == 8)) {
            diag_note(lexer->sink, diag, "a color has no alpha here; see `mask` for cut-outs");
        }
        token->color = 0;
        return;
    }
    if (digits == 3) {
        value = (value & 0xf00) * 0x1100 | (value & 0x0f0) * 0x110 | (value & 0x00f) * 0x11;
    }
    token->color = value;
}
