#include "base/source.h"

#include "base/mem.h"
#include "base/utf8.h"

void sources_init(Sources *sources, Arena *arena)
{
    *sources = (Sources){.arena = arena};
}

static void source_free(Source *source)
{
    mem_free(source->lines);
    mem_free(source->marks);
    if (source->release) {
        source->release(source->text);
    }
}

void sources_rewind(Sources *sources, uint32_t count)
{
    for (; sources->count > count; --sources->count) {
        source_free(&sources->items[sources->count]);
    }
}

void sources_free(Sources *sources)
{
    sources_rewind(sources, 0);
    mem_free(sources->items);
    *sources = (Sources){0};
}

uint32_t sources_add(Sources *sources, const char *path, const char *real, Str text,
                     Span imported_at)
{
    if (sources->count + 2 > sources->capacity) {
        uint32_t capacity = sources->capacity ? sources->capacity * 2 : 8;
        Source *items = mem_realloc(sources->items, capacity, sizeof *items);
        if (!items) {
            return 0;
        }
        sources->items = items;
        sources->capacity = capacity;
    }
    char *path_copy = arena_copy_string(sources->arena, path, strlen(path));
    char *real_copy = real ? arena_copy_string(sources->arena, real, strlen(real)) : NULL;
    if (!path_copy || (real && !real_copy)) {
        return 0;
    }
    sources->items[++sources->count] =
        (Source){.path = path_copy, .real = real_copy, .text = text, .imported_at = imported_at};
    return sources->count;
}

const Source *source_get(const Sources *sources, uint32_t file)
{
    return file && file <= sources->count ? &sources->items[file] : NULL;
}

// Fills the table of line starts; false without memory for it.
static bool index_lines(Source *source)
{
    if (source->lines) {
        return true;
    }
    const char *begin = source->text.at, *end = begin + source->text.length;
    uint32_t count = 1;
    for (const char *at = begin; at < end && (at = memchr(at, '\n', (size_t)(end - at))); ++at) {
        ++count;
    }
    uint32_t *lines = mem_alloc(count, sizeof *lines);
    if (!lines) {
        return false;
    }
    lines[0] = 0;
    count = 1;
    for (const char *at = begin; at < end && (at = memchr(at, '\n', (size_t)(end - at))); ++at) {
        lines[count++] = (uint32_t)(at + 1 - begin);
    }
    source->lines = lines;
    source->line_count = count;
    return true;
}

// The last line that starts at or before `offset`, counting from 0.
static uint32_t find_line(const Source *source, uint32_t offset)
{
    uint32_t low = 0, high = source->line_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (source->lines[middle] <= offset) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

static uint32_t count_characters(const char *at, const char *end)
{
    uint32_t count = 0;
    for (; at < end; ++count) {
        uint32_t code;
        at += utf8_decode(at, end, &code);
    }
    return count;
}

// A file may be one line of millions of characters, with as many places to be told: so the
// characters before every thousandth byte or so are counted once.
enum { MARK_EVERY = 1024 };

typedef struct SourceMark {
    uint32_t offset, characters; // characters that begin before `offset`, where one begins
} SourceMark;

static bool mark_characters(Source *source)
{
    if (source->marks) {
        return true;
    }
    const char *begin = source->text.at, *end = begin + source->text.length;
    SourceMark *marks = mem_alloc(source->text.length / MARK_EVERY + 1, sizeof *marks);
    if (!marks) {
        return false;
    }
    uint32_t count = 0, characters = 0;
    for (const char *at = begin; at < end; ++characters) {
        uint32_t code, offset = (uint32_t)(at - begin);
        if (offset >= count * MARK_EVERY) {
            marks[count++] = (SourceMark){offset, characters};
        }
        at += utf8_decode(at, end, &code);
    }
    source->marks = marks;
    source->mark_count = count;
    return true;
}

static uint32_t characters_before(const Source *source, uint32_t offset)
{
    // A mark lies at most three bytes behind its multiple of MARK_EVERY.
    uint32_t i = offset / MARK_EVERY;
    i = i < source->mark_count ? i : source->mark_count - 1;
    i -= i > 0 && source->marks[i].offset > offset;
    SourceMark mark = source->marks[i];
    const char *text = source->text.at;
    return mark.characters + count_characters(text + mark.offset, text + offset);
}

// Characters of a line from its start to `offset`.
static uint32_t characters_of_line(Source *source, uint32_t start, uint32_t offset)
{
    if (offset - start > 4 * MARK_EVERY && mark_characters(source)) {
        return characters_before(source, offset) - characters_before(source, start);
    }
    return count_characters(source->text.at + start, source->text.at + offset);
}

Place source_place(Sources *sources, uint32_t file, uint32_t offset)
{
    if (!source_get(sources, file)) {
        return (Place){0, 0};
    }
    Source *source = &sources->items[file];
    if (offset > source->text.length) {
        offset = (uint32_t)source->text.length;
    }
    uint32_t line = 0, start = 0;
    if (index_lines(source)) {
        line = find_line(source, offset);
        start = source->lines[line];
    } else { // without memory for the table: count
        for (uint32_t i = 0; i < offset; ++i) {
            if (source->text.at[i] == '\n') {
                ++line;
                start = i + 1;
            }
        }
    }
    return (Place){line + 1, characters_of_line(source, start, offset) + 1};
}

Str source_line(Sources *sources, uint32_t file, uint32_t line)
{
    if (!source_get(sources, file) || !index_lines(&sources->items[file])) {
        return STR("");
    }
    const Source *source = &sources->items[file];
    if (line < 1 || line > source->line_count) {
        return STR("");
    }
    size_t begin = source->lines[line - 1];
    size_t end = line < source->line_count ? source->lines[line] - 1 : source->text.length;
    if (end > begin && source->text.at[end - 1] == '\r') {
        --end;
    }
    return (Str){source->text.at + begin, end - begin};
}
