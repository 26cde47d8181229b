// How libFuzzer and AFL++ change a scene's text: half of the time byte by byte, as they would
// anyway, and half of the time word by word, with the words of the tables that the language runs
// on.
#include "lang/lang.h"
#include "lang/lexer.h"
#include "render/render.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

size_t LLVMFuzzerMutate(uint8_t *bytes, size_t size, size_t most);
size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t most, unsigned seed);

enum { MOST_WORDS = 4096 };

typedef struct Words {
    Str items[MOST_WORDS];
    size_t count;
} Words;

static void add_word(Words *words, const char *text, size_t length)
{
    if (words->count < MOST_WORDS && length > 0) {
        words->items[words->count++] = (Str){text, length};
    }
}

static void add_kinds(Words *words)
{
    const Schema *schema = render_schema();
    for (size_t i = 0; i < schema->type_count; ++i) {
        const NodeType *type = schema->types[i];
        add_word(words, type->name, strlen(type->name));
        if (type->example) {
            add_word(words, type->example, strlen(type->example));
        }
        for (size_t p = 0; p < type->param_count; ++p) {
            add_word(words, type->params[p].name, strlen(type->params[p].name));
            if (type->params[p].default_text) {
                add_word(words, type->params[p].default_text, strlen(type->params[p].default_text));
            }
            for (const char *const *c = type->params[p].choices; c && *c; ++c) {
                add_word(words, *c, strlen(*c));
            }
        }
    }
}

static const Words *all_words(void)
{
    static const char *const others[] = {"//",
                                         "/*",
                                         "*/",
                                         "\\u{",
                                         "1e9",
                                         "#fff",
                                         "#8090a0",
                                         "scn 1",
                                         "0.5m",
                                         "\xc3\xa9",
                                         "\n",
                                         "i",
                                         "a",
                                         "\"lib.scn\"",
                                         "\"tri.ply\"",
                                         "\"lamp.ies\"",
                                         "{ }",
                                         "0..<3",
                                         "[1, 2]",
                                         "(1, 2, 3)",
                                         "0",
                                         "-1",
                                         "transform: ",
                                         "material: ",
                                         "name: ",
                                         "color: ",
                                         " = ",
                                         ": ",
                                         "of",
                                         "expect a within 1% of b",
                                         "radiance(region((0, 0), (1, 1)))"};
    static Words words;
    if (words.count > 0) {
        return &words;
    }
    for (int kind = TOKEN_COLOR + 1; kind < TOKEN_KIND_COUNT; ++kind) {
        const char *quoted = token_kind_name((TokenKind)kind) + 1; // behind the `
        add_word(&words, quoted, strcspn(quoted, "`"));
    }
    for (size_t i = 0; i < schema_unit_count; ++i) {
        add_word(&words, schema_units[i].name, strlen(schema_units[i].name));
    }
    add_kinds(&words);
#define BUILTIN(name, least, most, signature, doc) add_word(&words, #name, sizeof #name - 1);
#define CONSTANT(name, dimension, value, doc)      add_word(&words, #name, sizeof #name - 1);
#define MOMENT(name, dimension, doc)               add_word(&words, #name, sizeof #name - 1);
#include "lang/builtins.def"
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i) {
        add_word(&words, others[i], strlen(others[i]));
    }
    return &words;
}

// --- Changes -----------------------------------------------------------------------------------

static uint32_t below(uint64_t *random, size_t bound)
{
    *random = *random * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)((*random >> 33) % (bound ? bound : 1));
}

typedef struct Piece {
    size_t begin, end;
} Piece;

static bool in_word(uint8_t byte)
{
    return isalnum(byte) || byte == '_' || byte == '.';
}

// A word, or one other byte.
static Piece piece_at(const uint8_t *bytes, size_t size, size_t at)
{
    Piece piece = {at, at + (at < size)};
    if (at < size && in_word(bytes[at])) {
        while (piece.begin > 0 && in_word(bytes[piece.begin - 1])) {
            --piece.begin;
        }
        while (piece.end < size && in_word(bytes[piece.end])) {
            ++piece.end;
        }
    }
    return piece;
}

// bytes[0, piece.begin) word bytes[piece.end, size); unchanged where that is too long.
static size_t put(uint8_t *bytes, size_t size, size_t most, Piece piece, Str word)
{
    size_t tail = size - piece.end, wanted = piece.begin + word.length + tail;
    if (wanted > most) {
        return size;
    }
    memmove(bytes + piece.begin + word.length, bytes + piece.end, tail);
    memcpy(bytes + piece.begin, word.at, word.length);
    return wanted;
}

// Text from `piece` to the bracket that closes it, if it opens one.
static Piece whole_bracket(const uint8_t *bytes, size_t size, Piece piece)
{
    int depth = 0;
    for (size_t at = piece.begin; at < size; ++at) {
        depth += bytes[at] == '(' || bytes[at] == '[' || bytes[at] == '{';
        depth -= bytes[at] == ')' || bytes[at] == ']' || bytes[at] == '}';
        if (depth <= 0 && at + 1 >= piece.end) {
            return (Piece){piece.begin, at + 1};
        }
    }
    return piece;
}

static size_t change_words(uint8_t *bytes, size_t size, size_t most, uint64_t *random)
{
    enum { LONGEST = 256 };
    char copy[LONGEST];
    Piece piece = piece_at(bytes, size, below(random, size + 1));
    Piece other = piece_at(bytes, size, below(random, size + 1));
    const Words *words = all_words();
    Str word = words->items[below(random, words->count)];
    switch (below(random, 6)) {
    case 0: // another word in its place
        return put(bytes, size, most, piece, word);
    case 1: // a word before it
        piece.end = piece.begin;
        return put(bytes, size, most, piece, word);
    case 2: // nothing in its place
        return put(bytes, size, most, whole_bracket(bytes, size, piece), STR(""));
    case 3:
        return put(bytes, size, most, piece, STR(" "));
    default: // a copy of another piece, brackets and all, before or in place of it
        other = whole_bracket(bytes, size, other);
        if (other.end - other.begin > LONGEST) {
            return size;
        }
        memcpy(copy, bytes + other.begin, other.end - other.begin);
        if (below(random, 2)) {
            piece.end = piece.begin;
        }
        return put(bytes, size, most, piece, (Str){copy, other.end - other.begin});
    }
}

size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t most, unsigned seed)
{
    uint64_t random = seed * 0x9e3779b97f4a7c15u + 1;
    if (below(&random, 2)) {
        return LLVMFuzzerMutate(bytes, size, most);
    }
    for (uint32_t times = 1 + below(&random, 3); times > 0; --times) {
        size = change_words(bytes, size, most, &random);
    }
    return size;
}
