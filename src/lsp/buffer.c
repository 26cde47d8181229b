#include "lsp/buffer.h"

#include "base/utf8.h"

#include <string.h>

static const size_t MOST_BYTES = INT32_MAX;

void buffer_free(Buffer *text)
{
    array_free(&text->bytes);
    array_free(&text->lines);
}

// --- Lines ---------------------------------------------------------------------------------------

// Appends the starts of the lines that begin behind `at`. A line index of a few hundred kilobytes
// is made in a fraction of a millisecond, so it is made anew from the first line that changed.
static bool index_lines(Buffer *text, uint32_t at)
{
    const char *bytes = text->bytes.items;
    uint32_t end = (uint32_t)text->bytes.count;
    while (at < end) {
        const char *newline = memchr(bytes + at, '\n', end - at);
        uint32_t stop = newline ? (uint32_t)(newline - bytes) : end;
        // Carriage returns that no newline follows end lines, too.
        const char *lone = memchr(bytes + at, '\r', stop - at);
        if (lone && (uint32_t)(lone - bytes) + 1 < stop) {
            stop = (uint32_t)(lone - bytes);
        } else if (lone && stop == end) {
            stop = (uint32_t)(lone - bytes);
        }
        if (stop == end) {
            return true;
        }
        at = stop + 1;
        if (!array_push(&text->lines, at)) {
            return false;
        }
    }
    return true;
}

// The last line that starts at or before `offset`.
uint32_t buffer_line(const Buffer *text, uint32_t offset)
{
    uint32_t low = 0, high = (uint32_t)text->lines.count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (text->lines.items[middle] <= offset) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

static bool index_from(Buffer *text, uint32_t line)
{
    text->lines.count = line;
    if (line == 0 && !array_push(&text->lines, 0)) {
        return false;
    }
    return index_lines(text, text->lines.items[text->lines.count - 1]);
}

// --- Changes -------------------------------------------------------------------------------------

bool buffer_set(Buffer *text, Str content)
{
    return buffer_replace(text, 0, (uint32_t)text->bytes.count, content);
}

bool buffer_replace(Buffer *text, uint32_t begin, uint32_t end, Str content)
{
    size_t count = text->bytes.count, removed = end - begin;
    if (count - removed + content.length > MOST_BYTES ||
        !array_reserve(&text->bytes, content.length + 1)) {
        return false;
    }
    char *bytes = text->bytes.items;
    memmove(bytes + begin + content.length, bytes + end, count - end);
    if (content.length > 0) {
        memcpy(bytes + begin, content.at, content.length);
    }
    text->bytes.count = count - removed + content.length;
    // The line before may have ended with a carriage return that now belongs to a newline.
    uint32_t line = text->lines.count ? buffer_line(text, begin > 0 ? begin - 1 : 0) : 0;
    return index_from(text, line);
}

// --- Positions -----------------------------------------------------------------------------------

static uint32_t units_of(uint32_t code, int length, PositionEncoding encoding)
{
    switch (encoding) {
    case POSITIONS_UTF8:
        return (uint32_t)length;
    case POSITIONS_UTF16:
        return length == 4 && code != UTF8_INVALID ? 2 : 1;
    case POSITIONS_UTF32:
        break;
    }
    return 1;
}

// Where the line's own characters end.
static uint32_t line_end(const Buffer *text, uint32_t line)
{
    if (line + 1 >= text->lines.count) {
        return (uint32_t)text->bytes.count;
    }
    uint32_t begin = text->lines.items[line], end = text->lines.items[line + 1] - 1;
    bool both = end > begin && text->bytes.items[end] == '\n' && text->bytes.items[end - 1] == '\r';
    return end - both;
}

uint32_t buffer_offset(const Buffer *text, Position position, PositionEncoding encoding)
{
    if (position.line >= text->lines.count) {
        return (uint32_t)text->bytes.count;
    }
    const char *at = text->bytes.items + text->lines.items[position.line];
    const char *end = text->bytes.items + line_end(text, position.line);
    for (uint32_t column = 0; at < end && column < position.column;) {
        uint32_t code;
        int length = utf8_decode(at, end, &code);
        column += units_of(code, length, encoding);
        if (column > position.column) {
            break;
        }
        at += length;
    }
    return (uint32_t)(at - text->bytes.items);
}

uint32_t buffer_units(Str run, PositionEncoding encoding)
{
    if (encoding == POSITIONS_UTF8) {
        return (uint32_t)run.length;
    }
    uint32_t units = 0;
    for (const char *at = run.at, *end = run.at + run.length; at < end;) {
        uint32_t code;
        int length = utf8_decode(at, end, &code);
        units += units_of(code, length, encoding);
        at += length;
    }
    return units;
}

Position buffer_position(const Buffer *text, uint32_t offset, PositionEncoding encoding)
{
    if (text->lines.count == 0) {
        return (Position){0, 0};
    }
    if (offset > text->bytes.count) {
        offset = (uint32_t)text->bytes.count;
    }
    uint32_t line = buffer_line(text, offset), begin = text->lines.items[line];
    return (Position){line,
                      buffer_units((Str){text->bytes.items + begin, offset - begin}, encoding)};
}
