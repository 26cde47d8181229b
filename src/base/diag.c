#include "base/diag.h"

#include "base/hash.h"
#include "base/mem.h"

#include <stdarg.h>

static const DiagInfo infos[] = {
#define DIAG(code, severity, title, paragraph, example)                                            \
    {#code, severity, title, paragraph, example},
#include "base/diag_codes.def"
#undef DIAG
};

const DiagInfo *diag_info(DiagCode code)
{
    return &infos[code];
}

static char upper(char c)
{
    return c >= 'a' && c <= 'z' ? (char)(c - 'a' + 'A') : c;
}

DiagCode diag_find(Str name)
{
    for (int code = 0; code < DIAG_CODE_COUNT; ++code) {
        const char *known = infos[code].name;
        size_t i = 0;
        while (i < name.length && known[i] && upper(name.at[i]) == known[i]) {
            ++i;
        }
        if (i == name.length && !known[i]) {
            return (DiagCode)code;
        }
    }
    return DIAG_CODE_COUNT;
}

void diag_sink_init(DiagSink *sink, Arena *arena)
{
    *sink = (DiagSink){.arena = arena, .limit = DIAG_DEFAULT_LIMIT};
}

void diag_sink_free(DiagSink *sink)
{
    mem_free(sink->items);
    mem_free(sink->slots);
    *sink = (DiagSink){0};
}

// --- Memory: nothing here may jump, since a diagnostic is often what tells of a jump ------------

static void *allocate(DiagSink *sink, size_t size)
{
    jmp_buf *jump = sink->arena->on_oom;
    sink->arena->on_oom = NULL;
    void *memory = arena_alloc_zeroed(sink->arena, size);
    sink->arena->on_oom = jump;
    if (!memory) {
        sink->out_of_memory = true;
    }
    return memory;
}

// The formatted text in the arena; NULL without memory.
static const char *format_text(DiagSink *sink, const char *format, va_list arguments)
{
    va_list again;
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    char *text = length < 0 ? NULL : allocate(sink, (size_t)length + 1);
    if (text) {
        vsnprintf(text, (size_t)length + 1, format, again);
    }
    va_end(again);
    return text;
}

bool diag_is_kept(const DiagSink *sink, const Diag *diag)
{
    return diag != &sink->spare;
}

// --- The set of what has been reported -----------------------------------------------------------

static uint32_t find_slot(const DiagSink *sink, DiagCode code, Span at)
{
    uint32_t hash = hash_combine(hash_combine(at.file, at.begin), at.end ^ (uint32_t)code << 20);
    uint32_t slot = hash & sink->slot_mask;
    for (; sink->slots[slot]; slot = (slot + 1) & sink->slot_mask) {
        const Diag *diag = &sink->items[sink->slots[slot] - 1];
        if (diag->code == code && diag->at.file == at.file && diag->at.begin == at.begin &&
            diag->at.end == at.end) {
            break;
        }
    }
    return slot;
}

static bool make_room(DiagSink *sink)
{
    if (sink->count < sink->capacity) {
        return true;
    }
    uint32_t capacity = sink->capacity ? sink->capacity * 2 : 16;
    Diag *items = mem_realloc(sink->items, capacity, sizeof *items);
    if (!items) {
        return false;
    }
    sink->items = items;
    uint32_t *slots = mem_alloc_zeroed((size_t)capacity * 2, sizeof *slots);
    if (!slots) {
        return false;
    }
    mem_free(sink->slots);
    sink->slots = slots;
    sink->slot_mask = capacity * 2 - 1;
    sink->capacity = capacity;
    for (uint32_t i = 0; i < sink->count; ++i) {
        slots[find_slot(sink, items[i].code, items[i].at)] = i + 1;
    }
    return true;
}

static void fill_slots(DiagSink *sink)
{
    memset(sink->slots, 0, ((size_t)sink->slot_mask + 1) * sizeof *sink->slots);
    for (uint32_t i = 0; i < sink->count; ++i) {
        sink->slots[find_slot(sink, sink->items[i].code, sink->items[i].at)] = i + 1;
    }
}

// Beyond the limit an error takes the place of the last warning.
static Diag *keep_beyond(DiagSink *sink, Diag diag)
{
    sink->dropped++;
    for (uint32_t i = sink->count; diag.severity == SEVERITY_ERROR && i-- > 0;) {
        if (sink->items[i].severity != SEVERITY_ERROR) {
            sink->items[i] = diag;
            fill_slots(sink);
            return &sink->items[i];
        }
    }
    return &sink->spare;
}

static Diag *keep(DiagSink *sink, Diag diag)
{
    if (sink->count >= sink->limit) {
        return keep_beyond(sink, diag);
    }
    if (!make_room(sink)) {
        sink->out_of_memory = true;
        return &sink->spare;
    }
    sink->items[sink->count] = diag;
    sink->slots[find_slot(sink, diag.code, diag.at)] = sink->count + 1;
    return &sink->items[sink->count++];
}

static bool was_reported(const DiagSink *sink, DiagCode code, Span at)
{
    return sink->slots && sink->slots[find_slot(sink, code, at)];
}

// --- Reporting -----------------------------------------------------------------------------------

Diag *diag_report(DiagSink *sink, DiagCode code, Span at, const char *format, ...)
{
    sink->spare = (Diag){.code = code, .severity = infos[code].severity, .at = at, .message = ""};
    if (was_reported(sink, code, at)) {
        return &sink->spare;
    }
    sink->errors += infos[code].severity == SEVERITY_ERROR;
    sink->warnings += infos[code].severity == SEVERITY_WARNING;
    Diag *diag = keep(sink, (Diag){.code = code,
                                   .severity = infos[code].severity,
                                   .at = at,
                                   .message = infos[code].title,
                                   .frames = sink->frames});
    if (diag_is_kept(sink, diag)) {
        va_list arguments;
        va_start(arguments, format);
        const char *message = format_text(sink, format, arguments);
        va_end(arguments);
        diag->message = message ? message : diag->message;
    }
    return diag;
}

DiagMark diag_mark(const DiagSink *sink)
{
    return (DiagMark){sink->count, sink->errors, sink->warnings, sink->dropped,
                      sink->out_of_memory};
}

bool diag_is_since(const DiagSink *sink, DiagMark mark)
{
    return sink->count != mark.count || sink->errors != mark.errors ||
           sink->warnings != mark.warnings || sink->dropped != mark.dropped ||
           sink->out_of_memory != mark.out_of_memory;
}

void diag_rewind(DiagSink *sink, DiagMark mark)
{
    sink->count = mark.count;
    sink->errors = mark.errors;
    sink->warnings = mark.warnings;
    sink->dropped = mark.dropped;
    sink->out_of_memory = mark.out_of_memory;
    if (sink->slots) {
        fill_slots(sink);
    }
}

void diag_label(DiagSink *sink, Diag *diag, const char *format, ...)
{
    if (!diag_is_kept(sink, diag)) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    diag->label = format_text(sink, format, arguments);
    va_end(arguments);
}

void diag_note(DiagSink *sink, Diag *diag, const char *format, ...)
{
    if (!diag_is_kept(sink, diag)) {
        return;
    }
    DiagNote *note = allocate(sink, sizeof *note);
    va_list arguments;
    va_start(arguments, format);
    const char *text = note ? format_text(sink, format, arguments) : NULL;
    va_end(arguments);
    if (text) {
        note->text = text;
        DiagNote **last = &diag->notes;
        while (*last) {
            last = &(*last)->next;
        }
        *last = note;
    }
}

void diag_suggest(DiagSink *sink, Diag *diag, Span at, const char *text)
{
    if (!diag_is_kept(sink, diag)) {
        return;
    }
    size_t size = strlen(text) + 1;
    char *copy = allocate(sink, size);
    if (copy) {
        memcpy(copy, text, size);
        diag->fix_at = at;
        diag->fix_text = copy;
    }
    if (!diag->label) {
        diag_label(sink, diag, *text ? "did you mean `%s`?" : "remove it", text);
    }
}

// Frames of one diagnostic go before the chain that the sink puts on all.
void diag_frame(DiagSink *sink, Diag *diag, Span at, const char *format, ...)
{
    if (!diag_is_kept(sink, diag)) {
        return;
    }
    DiagFrame *frame = allocate(sink, sizeof *frame);
    va_list arguments;
    va_start(arguments, format);
    const char *text = frame ? format_text(sink, format, arguments) : NULL;
    va_end(arguments);
    if (text) {
        DiagFrame **last = &diag->frames;
        while (*last && *last != sink->frames) {
            last = &(*last)->next;
        }
        *frame = (DiagFrame){at, text, *last};
        *last = frame;
    }
}
