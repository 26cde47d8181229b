#include "cli/sweep_values.h"

#include "base/number.h"
#include "schema/schema.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

typedef struct Parser {
    Arena *arena;
    const char **values;
    size_t count, capacity;
    char *message;
    size_t message_size;
} Parser;

static bool wrong(const Parser *p, const char *format, ...) __attribute__((format(printf, 2, 3)));

static bool wrong(const Parser *p, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(p->message, p->message_size, format, arguments);
    va_end(arguments);
    return false;
}

static bool no_memory(const Parser *p)
{
    return wrong(p, "not enough memory");
}

// --- Pieces --------------------------------------------------------------------------------------

static const char *end_of_string(const char *at)
{
    for (++at; *at && *at != '"'; ++at) {
        at += *at == '\\' && at[1];
    }
    return *at ? at + 1 : at;
}

// The first `what` outside of brackets and strings in [at, end); `end` where there is none.
static const char *find_outside(const char *at, const char *end, const char *what)
{
    const size_t length = strlen(what);
    int depth = 0;
    while (at < end) {
        if (depth <= 0 && (size_t)(end - at) >= length && memcmp(at, what, length) == 0) {
            return at;
        }
        depth += strchr("([{", *at) ? 1 : strchr(")]}", *at) ? -1 : 0;
        at = *at == '"' ? end_of_string(at) : at + 1;
    }
    return end;
}

static Str trimmed(const char *begin, const char *end)
{
    while (begin < end && (*begin == ' ' || *begin == '\t')) {
        ++begin;
    }
    while (begin < end && (end[-1] == ' ' || end[-1] == '\t')) {
        --end;
    }
    return (Str){begin, (size_t)(end - begin)};
}

static bool add_value(Parser *p, const char *value)
{
    if (!value) {
        return no_memory(p);
    }
    if (p->count == SWEEP_MOST_VALUES) {
        return wrong(p, "more than %d values", SWEEP_MOST_VALUES);
    }
    if (p->count == p->capacity) {
        const size_t capacity = p->capacity ? 2 * p->capacity : 16;
        const char **grown = arena_array(p->arena, capacity, sizeof *grown);
        if (!grown) {
            return no_memory(p);
        }
        if (p->count) {
            memcpy(grown, p->values, p->count * sizeof *grown);
        }
        p->values = grown;
        p->capacity = capacity;
    }
    p->values[p->count++] = value;
    return true;
}

// --- Ranges --------------------------------------------------------------------------------------

typedef struct Number {
    double number; // in its unit
    Str unit;      // may be empty
} Number;

// "1.3", "-20cm": a number that nothing but letters follow.
static bool is_number(Str text, Number *out)
{
    const char *end = text.at + text.length;
    const char *rest = number_parse(text.at, end, &out->number);
    if (!rest || !isfinite(out->number)) {
        return false;
    }
    out->unit = (Str){rest, (size_t)(end - rest)};
    for (; rest < end; ++rest) {
        if (!((*rest >= 'a' && *rest <= 'z') || (*rest >= 'A' && *rest <= 'Z'))) {
            return false;
        }
    }
    return true;
}

typedef struct Range {
    Number first, last;
    bool counted;
    double count;
} Range;

// A value that is none is a value of its own: "../a.png".
static bool is_range(Str text, Range *range)
{
    const char *end = text.at + text.length, *dots = find_outside(text.at, end, "..");
    if (dots == end) {
        return false;
    }
    const char *colon = find_outside(dots, end, ":");
    range->counted = colon < end;
    range->count = 0;
    if (range->counted) {
        const Str count = trimmed(colon + 1, end);
        const char *rest = number_parse(count.at, count.at + count.length, &range->count);
        if (rest != count.at + count.length) {
            range->count = 0;
        }
    }
    return is_number(trimmed(text.at, dots), &range->first) &&
           is_number(trimmed(dots + 2, colon), &range->last);
}

// Brings both ends to one unit: the only one that is written, or that of the last.
static bool agree(const Parser *p, Range *range)
{
    Number *first = &range->first, *last = &range->last;
    if (first->unit.length == 0 || last->unit.length == 0) {
        first->unit = last->unit = first->unit.length ? first->unit : last->unit;
    }
    const UnitInfo *from = first->unit.length ? unit_find(first->unit) : NULL;
    const UnitInfo *to = last->unit.length ? unit_find(last->unit) : NULL;
    const Str *unknown = first->unit.length && !from ? &first->unit
                         : last->unit.length && !to  ? &last->unit
                                                     : NULL;
    if (unknown) {
        return wrong(p, "there is no unit `%.*s`", (int)unknown->length, unknown->at);
    }
    if (from && from != to) {
        if (from->dim != to->dim) {
            return wrong(p, "one end is %s, the other %s", dim_info(from->dim)->name,
                         dim_info(to->dim)->name);
        }
        first->number *= from->factor / to->factor;
        first->unit = last->unit;
    }
    return true;
}

// So many digits that what is meant is written: 1.4, not 1.4000000000000001.
static char *value_text(Arena *arena, double number, Str unit)
{
    return arena_printf(arena, "%.12g%.*s", number, (int)unit.length, unit.at);
}

static bool is_whole(Number q)
{
    return q.unit.length == 0 && q.number == floor(q.number) && fabs(q.number) < 1e9;
}

static bool add_range(Parser *p, Str text, Range *range)
{
    if (!agree(p, range)) {
        return false;
    }
    const double first = range->first.number, last = range->last.number;
    double count = range->count;
    if (!range->counted) {
        if (!is_whole(range->first) || !is_whole(range->last)) {
            return wrong(p, "`%.*s` doesn't say how many values: write %.*s:5", (int)text.length,
                         text.at, (int)text.length, text.at);
        }
        count = fabs(last - first) + 1;
    }
    if (!(count >= 2 && count <= SWEEP_MOST_VALUES && count == floor(count))) {
        return wrong(p, "`%.*s` must be of 2 to %d values", (int)text.length, text.at,
                     SWEEP_MOST_VALUES);
    }
    for (double i = 0; i < count; ++i) {
        const double t = i / (count - 1), number = (1 - t) * first + t * last;
        if (!add_value(p, value_text(p->arena, number, range->first.unit))) {
            return false;
        }
    }
    return true;
}

// --- All -----------------------------------------------------------------------------------------

static bool add_values(Parser *p, const char *at)
{
    const char *end = at + strlen(at);
    for (;; ++at) {
        const char *comma = find_outside(at, end, ",");
        const Str text = trimmed(at, comma);
        Range range;
        if (text.length == 0) {
            return wrong(p, "a value is missing");
        }
        if (!(is_range(text, &range)
                  ? add_range(p, text, &range)
                  : add_value(p, arena_copy_string(p->arena, text.at, text.length)))) {
            return false;
        }
        at = comma;
        if (at == end) {
            return true;
        }
    }
}

bool sweep_parse(Arena *arena, const char *text, Sweep *out, char *message, size_t message_size)
{
    Parser p = {.arena = arena, .message = message, .message_size = message_size};
    const char *equals = strchr(text, '=');
    const Str name = equals ? trimmed(text, equals) : (Str){0};
    if (name.length == 0) {
        return wrong(&p, "NAME=VALUE,... is wanted");
    }
    if (!add_values(&p, equals + 1)) {
        return false;
    }
    *out = (Sweep){arena_copy_string(arena, name.at, name.length), p.values, p.count};
    return out->name || no_memory(&p);
}
