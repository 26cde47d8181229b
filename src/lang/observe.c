// What lets and params come to, kept for editors.
#include "base/hash.h"
#include "lang/eval.h"

#include <stdarg.h>
#include <stdio.h>

enum { LINE_SIZE = 120, LIST_ITEMS = 4, LIST_DEPTH = 3 };

// A line that ends in "…" where it is full.
typedef struct Line {
    char text[LINE_SIZE];
    size_t length;
} Line;

__attribute__((format(printf, 2, 3))) static void put(Line *line, const char *format, ...)
{
    size_t room = sizeof line->text - line->length;
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(line->text + line->length, room, format, arguments);
    va_end(arguments);
    if (length > 0) {
        line->length += (size_t)length < room ? (size_t)length : room - 1;
    }
}

// The most bytes below `most` that hold whole characters.
static size_t whole_characters(const char *text, size_t most)
{
    while (most > 0 && ((unsigned char)text[most] & 0xc0) == 0x80) {
        --most;
    }
    return most;
}

static void end_line(Line *line)
{
    if (line->length + 1 >= sizeof line->text) {
        size_t end = whole_characters(line->text, sizeof line->text - sizeof "…");
        memcpy(line->text + end, "…", sizeof "…");
        line->length = end + sizeof "…" - 1;
    }
}

static void add_string(Line *line, Value v)
{
    enum { MOST = 60 };
    size_t shown = v.count > MOST ? whole_characters(v.string, MOST) : v.count;
    put(line, "\"%.*s%s\"", (int)shown, v.string, shown < v.count ? "…" : "");
}

// Six digits are for reading; whole numbers stand in full.
static void add_number(Line *line, double number, uint8_t dim)
{
    double shown = dim == DIM_ANGLE ? number * (180 / PI) : number;
    bool is_whole = shown == floor(shown) && fabs(shown) < 1e15;
    put(line, is_whole ? "%.0f" : "%.6g", shown == 0 ? 0.0 : shown);
    put(line, "%s", dim == DIM_ANGLE ? "deg" : dim_info((Dim)dim)->si_unit);
}

static void add_numbers(Line *line, const char *before, Value v)
{
    put(line, "%s(", before);
    for (int i = 0; i < v.small; ++i) {
        put(line, "%s", i ? ", " : "");
        add_number(line, v.components[i], v.dim);
    }
    put(line, ")");
}

static void add_value(Eval *ev, Line *line, Value v, int depth)
{
    char words[DESCRIBE_SIZE];
    switch ((ValueType)v.type) {
    case VALUE_BOOL:
        put(line, "%s", v.boolean ? "true" : "false");
        break;
    case VALUE_NUMBER:
        add_number(line, v.number, v.dim);
        break;
    case VALUE_STRING:
        add_string(line, v);
        break;
    case VALUE_VECTOR:
        add_numbers(line, "", v);
        break;
    case VALUE_COLOR:
        add_numbers(line, "rgb", v);
        break;
    case VALUE_LIST:
        put(line, "[");
        for (uint32_t i = 0; i < v.count && i < LIST_ITEMS && depth < LIST_DEPTH; ++i) {
            put(line, "%s", i ? ", " : "");
            add_value(ev, line, v.items[i], depth + 1);
        }
        if (v.count > LIST_ITEMS || (depth == LIST_DEPTH && v.count > 0)) {
            put(line, ", … %u in all", v.count);
        }
        put(line, "]");
        break;
    case VALUE_RANGE:
        put(line, "%.0f..<%.0f", v.number, v.number + v.count);
        break;
    case VALUE_NODE:
        put(line, "%s { … }", ev->lang->schema->types[v.node->type]->name);
        break;
    default:
        put(line, "%s", describe_value(ev, v, words, sizeof words));
    }
}

// --- The table -------------------------------------------------------------------------------

void observations_free(Observations *observations)
{
    array_free(&observations->items);
    array_free(&observations->slots);
}

static uint32_t *find_slot(Observations *all, Span at)
{
    uint32_t mask = (uint32_t)all->slots.count - 1;
    uint32_t slot = hash_combine(at.file, at.begin) & mask;
    for (; all->slots.items[slot]; slot = (slot + 1) & mask) {
        const Observation *other = &all->items.items[all->slots.items[slot] - 1];
        if (other->name.file == at.file && other->name.begin == at.begin) {
            break;
        }
    }
    return &all->slots.items[slot];
}

// Keeps the table at most half full.
static bool make_room(Observations *all)
{
    size_t size = all->slots.count;
    if (all->items.count * 2 < size) {
        return array_reserve(&all->items, 1);
    }
    size_t wanted = size ? size * 2 : 64;
    if (!array_reserve(&all->slots, wanted - size) || !array_reserve(&all->items, 1)) {
        return false;
    }
    all->slots.count = wanted;
    memset(all->slots.items, 0, wanted * sizeof *all->slots.items);
    for (size_t i = 0; i < all->items.count; ++i) {
        *find_slot(all, all->items.items[i].name) = (uint32_t)i + 1;
    }
    return true;
}

static const char *keep(Lang *lang, const char *text, size_t length)
{
    jmp_buf *jump = lang->arena.on_oom;
    lang->arena.on_oom = NULL;
    const char *copy = arena_copy_string(&lang->arena, text, length);
    lang->arena.on_oom = jump;
    return copy;
}

// Lines are compared, not values: the first one's memory may be gone.
void observe_value(Eval *ev, const Env *env, AstId item, Value v)
{
    Observations *all = ev->lang->observed;
    bool is_file = source_get(&ev->lang->sources, env->module->file)->real; // else defaults
    if (is_error(v) || !is_file || !make_room(all)) {
        return;
    }
    Span name = item_name_span(env->module, item);
    uint32_t *slot = find_slot(all, name);
    Observation *known = *slot ? &all->items.items[*slot - 1] : NULL;
    if (known && known->varies) {
        ++known->times;
        return;
    }
    Line line = {.length = 0};
    add_value(ev, &line, v, 0);
    end_line(&line);
    if (known) {
        ++known->times;
        known->varies = !known->text || strcmp(known->text, line.text) != 0;
        return;
    }
    char type[DESCRIBE_SIZE];
    describe_value(ev, v, type, sizeof type);
    Observation kept = {.name = name,
                        .times = 1,
                        .text = keep(ev->lang, line.text, line.length),
                        .type = keep(ev->lang, type, strlen(type))};
    if (array_push(&all->items, kept)) {
        *slot = (uint32_t)all->items.count;
    }
}
