#include "grammar.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// --- Random numbers ------------------------------------------------------------------------------

uint64_t random_next(Random *random)
{
    uint64_t x = random->state += 0x9e3779b97f4a7c15u; // SplitMix64
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

uint32_t random_below(Random *random, uint32_t count)
{
    return (uint32_t)((random_next(random) >> 32) * count >> 32);
}

// --- Reading -------------------------------------------------------------------------------------

typedef struct Reader {
    const char *path, *text, *at;
    char word[256]; // of the current symbol
    enum { END, NAME, TEXT, CODE, MARK } kind;
    uint32_t code; // CODE: U+…; TEXT of one ASCII character: it
} Reader;

static void *must(void *memory)
{
    if (!memory) {
        fputs("out of memory\n", stderr);
        exit(2);
    }
    return memory;
}

static void stop(const Reader *r, const char *what)
{
    int line = 1;
    for (const char *c = r->text; c < r->at; ++c) {
        line += *c == '\n';
    }
    fprintf(stderr, "%s:%d: %s (at \"%s\")\n", r->path, line, what, r->word);
    exit(2);
}

static void skip_remarks(Reader *r)
{
    for (;;) {
        while (isspace((unsigned char)*r->at)) {
            ++r->at;
        }
        if (strncmp(r->at, "(*", 2) != 0) {
            return;
        }
        const char *end = strstr(r->at, "*)");
        if (!end) {
            stop(r, "a remark is not closed");
        }
        r->at = end + 2;
    }
}

static void take(Reader *r, const char *begin, const char *end)
{
    size_t length = (size_t)(end - begin);
    if (length >= sizeof r->word) {
        stop(r, "too long");
    }
    memcpy(r->word, begin, length);
    r->word[length] = '\0';
}

static void next(Reader *r)
{
    skip_remarks(r);
    const char *begin = r->at;
    r->code = 0;
    if (*begin == '\0') {
        r->kind = END;
        take(r, begin, begin);
    } else if (strncmp(begin, "U+", 2) == 0) {
        char *end;
        r->kind = CODE;
        r->code = (uint32_t)strtoul(begin + 2, &end, 16);
        r->at = end;
        take(r, begin, r->at);
    } else if (isalpha((unsigned char)*begin)) {
        while (isalnum((unsigned char)*r->at) || *r->at == '_') {
            ++r->at;
        }
        r->kind = NAME;
        take(r, begin, r->at);
    } else if (*begin == '"' || *begin == '\'') {
        const char *end = strchr(begin + 1, *begin);
        if (!end) {
            stop(r, "a text is not closed");
        }
        r->kind = TEXT;
        take(r, begin + 1, end);
        r->code = r->word[1] ? 0 : (unsigned char)r->word[0];
        r->at = end + 1;
    } else {
        r->kind = MARK;
        r->at += strncmp(begin, "..", 2) == 0 ? 2 : 1;
        take(r, begin, r->at);
    }
}

static bool at_mark(const Reader *r, const char *mark)
{
    return r->kind == MARK && strcmp(r->word, mark) == 0;
}

static void expect(Reader *r, const char *mark)
{
    if (!at_mark(r, mark)) {
        fprintf(stderr, "expected %s: ", mark);
        stop(r, "the grammar is not sound");
    }
    next(r);
}

static Part *new_part(PartTag tag)
{
    Part *part = must(calloc(1, sizeof *part));
    part->tag = tag;
    return part;
}

static void add_child(Part *part, Part *child)
{
    part->children =
        must(realloc(part->children, (part->child_count + 1) * sizeof *part->children));
    part->children[part->child_count++] = child;
}

static Part *read_choice(Reader *r);

static Part *read_bracket(Reader *r, PartTag tag, const char *close)
{
    next(r);
    Part *inner = read_choice(r);
    expect(r, close);
    if (tag == PART_ROW) {
        return inner;
    }
    Part *part = new_part(tag);
    add_child(part, inner);
    return part;
}

static Part *read_character(Reader *r)
{
    Part *part = new_part(PART_TEXT);
    uint32_t first = r->code;
    bool code = r->kind == CODE;
    part->text = must(strdup(r->word));
    next(r);
    if (at_mark(r, "..")) {
        next(r);
        part->tag = PART_RANGE;
        part->first = first;
        part->last = r->code;
        if (!first || part->last < first) {
            stop(r, "a range needs two characters");
        }
        next(r);
    } else if (code) {
        part->tag = PART_RANGE;
        part->first = part->last = first;
    }
    return part;
}

static Part *read_part(Reader *r)
{
    if (at_mark(r, "(")) {
        return read_bracket(r, PART_ROW, ")");
    }
    if (at_mark(r, "[")) {
        return read_bracket(r, PART_OPTION, "]");
    }
    if (at_mark(r, "{")) {
        return read_bracket(r, PART_REPEAT, "}");
    }
    if (r->kind == TEXT || r->kind == CODE) {
        return read_character(r);
    }
    if (r->kind != NAME) {
        stop(r, "unexpected");
    }
    Part *part = new_part(PART_RULE);
    part->text = must(strdup(r->word));
    next(r);
    return part;
}

static bool ends_row(const Reader *r)
{
    return r->kind == END || (r->kind == MARK && strchr("|)]};-", r->word[0]));
}

static Part *read_row(Reader *r)
{
    Part *part = new_part(PART_ROW);
    do {
        add_child(part, read_part(r));
    } while (!ends_row(r));
    if (!at_mark(r, "-")) {
        return part;
    }
    Part *but = new_part(PART_BUT);
    next(r);
    add_child(but, part);
    add_child(but, read_part(r));
    return but;
}

static Part *read_choice(Reader *r)
{
    Part *first = read_row(r);
    if (!at_mark(r, "|")) {
        return first;
    }
    Part *part = new_part(PART_CHOICE);
    add_child(part, first);
    while (at_mark(r, "|")) {
        next(r);
        add_child(part, read_row(r));
    }
    return part;
}

static size_t find_rule(const Grammar *g, const char *name)
{
    for (size_t i = 0; i < g->count; ++i) {
        if (strcmp(g->rules[i].name, name) == 0) {
            return i;
        }
    }
    fprintf(stderr, "the grammar has no rule %s\n", name);
    exit(2);
}

static void link_part(const Grammar *g, Part *part)
{
    part->taken = must(calloc(part->child_count + 2, sizeof *part->taken));
    part->depth = 1000;
    if (part->tag == PART_RULE) {
        part->rule = find_rule(g, part->text);
    }
    for (size_t i = 0; i < part->child_count; ++i) {
        link_part(g, part->children[i]);
    }
}

// One step towards the least depths; true when something changed.
static bool deepen(const Grammar *g, Part *part)
{
    bool changed = false;
    unsigned most = 0, least = 1000;
    for (size_t i = 0; i < part->child_count; ++i) {
        changed |= deepen(g, part->children[i]);
        unsigned depth = part->children[i]->depth;
        most = depth > most ? depth : most;
        least = depth < least ? depth : least;
    }
    unsigned depth = 0;
    if (part->tag == PART_RULE) {
        depth = g->rules[part->rule].depth + 1;
    } else if (part->tag == PART_ROW || part->tag == PART_BUT) {
        depth = most;
    } else if (part->tag == PART_CHOICE) {
        depth = least;
    }
    changed |= depth < part->depth;
    part->depth = depth < part->depth ? depth : part->depth;
    return changed;
}

static void find_depths(Grammar *g)
{
    for (bool changed = true; changed;) {
        changed = false;
        for (size_t i = 0; i < g->count; ++i) {
            changed |= deepen(g, g->rules[i].body);
            g->rules[i].depth = g->rules[i].body->depth;
        }
    }
    for (size_t i = 0; i < g->count; ++i) {
        if (g->rules[i].depth >= 1000) {
            fprintf(stderr, "the rule %s never ends\n", g->rules[i].name);
            exit(2);
        }
    }
}

static char *read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) {
        perror(path);
        exit(2);
    }
    char *text = must(calloc(1, 1 << 20));
    size_t length = fread(text, 1, (1 << 20) - 1, file);
    text[length] = '\0';
    fclose(file);
    return text;
}

Grammar grammar_read(const char *path)
{
    char *text = read_file(path);
    Grammar g = {0};
    Reader r = {.path = path, .text = text, .at = text};
    next(&r);
    while (r.kind != END) {
        g.rules = must(realloc(g.rules, (g.count + 1) * sizeof *g.rules));
        Rule *rule = &g.rules[g.count++];
        if (r.kind != NAME) {
            stop(&r, "a rule must begin with its name");
        }
        *rule = (Rule){.name = must(strdup(r.word)),
                       .token = isupper((unsigned char)r.word[0]) != 0,
                       .depth = 1000};
        next(&r);
        expect(&r, "=");
        rule->body = read_choice(&r);
        expect(&r, ";");
    }
    free(text);
    for (size_t i = 0; i < g.count; ++i) {
        link_part(&g, g.rules[i].body);
    }
    find_depths(&g);
    g.blank = find_rule(&g, "BLANK");
    g.name = find_rule(&g, "NAME");
    g.number = find_rule(&g, "NUMBER");
    g.unit = find_rule(&g, "UNIT");
    g.reserved = find_rule(&g, "RESERVED");
    return g;
}

static void free_part(Part *part)
{
    for (size_t i = 0; i < part->child_count; ++i) {
        free_part(part->children[i]);
    }
    free(part->children);
    free(part->taken);
    free(part->text);
    free(part);
}

void grammar_free(Grammar *g)
{
    for (size_t i = 0; i < g->count; ++i) {
        free_part(g->rules[i].body);
        free(g->rules[i].name);
    }
    free(g->rules);
    *g = (Grammar){0};
}

// --- Writing -------------------------------------------------------------------------------------

typedef struct Writer {
    Grammar *g;
    Random *random;
    Bounds bounds;
    char *text;
    size_t length, capacity;
    bool in_token;
    bool after_bare_number;
} Writer;

static void put(Writer *w, const char *bytes, size_t count)
{
    if (w->length + count + 1 > w->capacity) {
        w->capacity = (w->length + count + 1) * 2;
        w->text = must(realloc(w->text, w->capacity));
    }
    memcpy(w->text + w->length, bytes, count);
    w->length += count;
    w->text[w->length] = '\0';
}

static void put_code(Writer *w, uint32_t code)
{
    char bytes[4];
    if (code < 0x80) {
        bytes[0] = (char)code;
        put(w, bytes, 1);
        return;
    }
    int length = code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    for (int i = length - 1; i > 0; --i, code >>= 6) {
        bytes[i] = (char)(0x80 | (code & 0x3f));
    }
    bytes[0] = (char)(unsigned char)((0xf00u >> length) | code);
    put(w, bytes, (size_t)length);
}

static void write_part(Writer *w, Part *part, unsigned depth);

static bool is_word(char c)
{
    return isalnum((unsigned char)c) || c == '_';
}

// Whether `text` is one of the texts that make up a rule.
static bool is_one_of(const Rule *rule, const char *text)
{
    const Part *body = rule->body;
    for (size_t i = 0; i < body->child_count; ++i) {
        if (strcmp(body->children[i]->children[0]->text, text) == 0) {
            return true;
        }
    }
    return false;
}

static void write_blanks(Writer *w)
{
    uint32_t count =
        random_below(w->random, 4) ? random_below(w->random, 2) : random_below(w->random, 4);
    for (uint32_t i = 0; i < count; ++i) {
        size_t before = w->length;
        w->in_token = true;
        ++w->g->rules[w->g->blank].used;
        write_part(w, w->g->rules[w->g->blank].body, w->bounds.depth);
        w->in_token = false;
        bool comment_after_slash =
            before > 0 && w->text[before - 1] == '/' && w->text[before] == '/';
        if (comment_after_slash) { // would read as `//`
            w->length = before;
            put(w, " ", 1);
        }
    }
}

// Puts a token, with what must or may stand before it.
static void put_token(Writer *w, const char *token, bool is_name)
{
    write_blanks(w);
    bool words = w->length > 0 && is_word(w->text[w->length - 1]) && is_word(token[0]);
    if (words || (w->after_bare_number && strcmp(token, ".") == 0)) {
        put(w, " ", 1);
    }
    if (is_name && w->after_bare_number && is_one_of(&w->g->rules[w->g->unit], token)) {
        put(w, "\n", 1); // a unit on the same line would be an error
    }
    put(w, token, strlen(token));
}

static bool is_in_range(const char *token)
{
    char digits[2048];
    size_t count = 0;
    for (; *token && count + 1 < sizeof digits; ++token) {
        if (*token != '_') {
            digits[count++] = *token;
        }
    }
    digits[count] = '\0';
    double value = strtod(digits, NULL);
    return !isinf(value) && (value != 0 || strspn(digits, "0.") == strcspn(digits, "eE"));
}

// A token made by a rule in upper case: written apart, so that it can be thrown away and made again
// where it isn't a proper one.
static void write_token(Writer *w, size_t rule, unsigned depth)
{
    Writer part = *w;
    for (;;) {
        part.text = NULL;
        part.length = part.capacity = 0;
        part.in_token = true;
        put(&part, "", 0);
        write_part(&part, w->g->rules[rule].body, depth);
        bool proper = rule != w->g->number || is_in_range(part.text);
        if (proper) {
            break;
        }
        free(part.text);
    }
    put_token(w, part.text, rule == w->g->name);
    char last = part.text[part.length - 1];
    w->after_bare_number = rule == w->g->number && isdigit((unsigned char)last);
    free(part.text);
}

static void write_but(Writer *w, const Part *part, unsigned depth)
{
    size_t before = w->length;
    do {
        w->length = before;
        write_part(w, part->children[0], depth);
    } while (is_one_of(&w->g->rules[part->children[1]->rule], w->text + before));
}

static void write_choice(Writer *w, Part *part, unsigned depth, bool short_way)
{
    size_t pick = random_below(w->random, (uint32_t)part->child_count);
    // One in four goes where no sentence has been yet.
    for (size_t i = 0; i < part->child_count && random_below(w->random, 4) == 0; ++i) {
        if (!part->taken[i]) {
            pick = i;
            break;
        }
    }
    if (short_way || part->children[pick]->depth > depth) {
        size_t start = pick;
        for (size_t k = 0; k < part->child_count; ++k) {
            size_t i = (start + k) % part->child_count;
            if (part->children[i]->depth < part->children[pick]->depth) {
                pick = i;
            }
        }
    }
    ++part->taken[pick];
    write_part(w, part->children[pick], depth);
}

static void write_rule(Writer *w, size_t index, unsigned depth)
{
    Rule *rule = &w->g->rules[index];
    ++rule->used;
    depth = depth ? depth - 1 : 0;
    if (rule->token && !w->in_token) {
        write_token(w, index, depth);
    } else {
        write_part(w, rule->body, depth);
    }
}

static void write_part(Writer *w, Part *part, unsigned depth)
{
    bool short_way = w->length > w->bounds.size && !w->in_token;
    switch (part->tag) {
    case PART_TEXT:
        if (w->in_token) {
            put(w, part->text, strlen(part->text));
        } else {
            put_token(w, part->text, false);
            w->after_bare_number = isdigit((unsigned char)part->text[0]);
        }
        break;
    case PART_RANGE: {
        uint32_t span = part->last - part->first + 1;
        // Mostly near the beginning: few characters are beyond ASCII.
        span = span > 96 && random_below(w->random, 8) ? 96 : span;
        put_code(w, part->first + random_below(w->random, span));
        break;
    }
    case PART_RULE:
        write_rule(w, part->rule, depth);
        break;
    case PART_ROW:
        for (size_t i = 0; i < part->child_count; ++i) {
            write_part(w, part->children[i], depth);
        }
        break;
    case PART_CHOICE:
        write_choice(w, part, depth, short_way);
        break;
    case PART_OPTION:
    case PART_REPEAT: {
        bool possible = !short_way && part->children[0]->depth <= depth;
        uint32_t most = part->tag == PART_REPEAT ? 4 : 2;
        uint32_t count = possible ? random_below(w->random, most) : 0;
        ++part->taken[count > 0];
        for (uint32_t i = 0; i < count; ++i) {
            write_part(w, part->children[0], depth);
        }
        break;
    }
    case PART_BUT:
        write_but(w, part, depth);
        break;
    }
}

char *grammar_sentence(Grammar *grammar, Random *random, Bounds bounds, size_t *length)
{
    Writer w = {.g = grammar, .random = random, .bounds = bounds};
    put(&w, "", 0);
    write_rule(&w, 0, bounds.depth);
    write_blanks(&w);
    *length = w.length;
    return w.text;
}

// --- What was used -------------------------------------------------------------------------------

static size_t print_unused_part(const Rule *rule, const Part *part)
{
    size_t unused = 0;
    size_t ways = part->tag == PART_CHOICE                               ? part->child_count
                  : part->tag == PART_OPTION || part->tag == PART_REPEAT ? 2
                                                                         : 0;
    for (size_t i = 0; i < ways; ++i) {
        if (!part->taken[i]) {
            printf("never used: in %s, way %zu of %zu\n", rule->name, i + 1, ways);
            ++unused;
        }
    }
    for (size_t i = 0; i < part->child_count; ++i) {
        unused += print_unused_part(rule, part->children[i]);
    }
    return unused;
}

size_t grammar_print_unused(const Grammar *grammar)
{
    size_t unused = 0;
    for (size_t i = 0; i < grammar->count; ++i) {
        const Rule *rule = &grammar->rules[i];
        if (i == grammar->reserved) {
            continue; // what names are not
        }
        if (!rule->used) {
            printf("never used: %s\n", rule->name);
            ++unused;
        }
        unused += print_unused_part(rule, rule->body);
    }
    return unused;
}
