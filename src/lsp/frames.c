#include "lsp/frames.h"

#include <string.h>
#include <strings.h>

void frames_free(Frames *frames)
{
    array_free(&frames->bytes);
    *frames = (Frames){0};
}

// What was taken makes room, but not each time: moving the rest costs.
static void compact(Frames *frames)
{
    size_t left = frames->bytes.count - frames->taken;
    if (left == 0) {
        frames->bytes.count = frames->taken = frames->search = 0;
    } else if (frames->taken > left) {
        memmove(frames->bytes.items, frames->bytes.items + frames->taken, left);
        frames->search = frames->search > frames->taken ? frames->search - frames->taken : 0;
        frames->bytes.count = left;
        frames->taken = 0;
    }
}

char *frames_room(Frames *frames, size_t size)
{
    compact(frames);
    return array_reserve(&frames->bytes, size) ? frames->bytes.items + frames->bytes.count : NULL;
}

void frames_added(Frames *frames, size_t size)
{
    size_t skipped = size < frames->skip ? size : frames->skip;
    if (skipped > 0) {
        char *begin = frames->bytes.items + frames->bytes.count;
        memmove(begin, begin + skipped, size - skipped);
        frames->skip -= skipped;
    }
    frames->bytes.count += size - skipped;
}

// The value of a header's line that is called `name`, blanks around it cut off.
static bool header_value(Str line, const char *name, Str *value)
{
    size_t length = strlen(name);
    if (line.length <= length || strncasecmp(line.at, name, length) != 0 ||
        line.at[length] != ':') {
        return false;
    }
    const char *begin = line.at + length + 1, *end = line.at + line.length;
    while (begin < end && (*begin == ' ' || *begin == '\t')) {
        ++begin;
    }
    while (end > begin && (end[-1] == ' ' || end[-1] == '\t')) {
        --end;
    }
    *value = (Str){begin, (size_t)(end - begin)};
    return true;
}

// A number of at most 15 digits.
static bool parse_length(Str text, size_t *out)
{
    size_t number = 0;
    for (size_t i = 0; i < text.length; ++i) {
        if (text.at[i] < '0' || text.at[i] > '9' || i >= 15) {
            return false;
        }
        number = number * 10 + (size_t)(text.at[i] - '0');
    }
    *out = number;
    return text.length > 0;
}

// The length that a header tells. Lines before it that are no fields (what is left of a message
// with a wrong length, say) don't matter.
static bool find_length(Str header, size_t *length)
{
    bool found = false;
    const char *at = header.at, *end = header.at + header.length;
    while (at < end) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        stop = stop ? stop : end;
        size_t size = (size_t)(stop - at);
        size -= size > 0 && at[size - 1] == '\r';
        Str value;
        if (header_value((Str){at, size}, "Content-Length", &value)) {
            found = parse_length(value, length);
        }
        at = stop < end ? stop + 1 : end;
    }
    return found;
}

// A blank line ends the header; some write it without carriage returns.
static const char *header_end(const char *at, const char *end, size_t *size)
{
    for (; at < end && (at = memchr(at, '\n', (size_t)(end - at))); ++at) {
        if (end - at >= 2 && at[1] == '\n') {
            *size = 2;
            return at;
        }
        if (end - at >= 3 && at[1] == '\r' && at[2] == '\n') {
            *size = 3;
            return at;
        }
    }
    return NULL;
}

static FrameResult skip_large(Frames *frames, size_t length)
{
    size_t there = frames->bytes.count - frames->taken;
    size_t now = there < length ? there : length;
    frames->taken += now;
    frames->skip = length - now;
    frames->search = frames->taken;
    return FRAME_BAD;
}

FrameResult frames_next(Frames *frames, Str *body)
{
    const char *begin = frames->bytes.items + frames->taken;
    const char *end = frames->bytes.items + frames->bytes.count;
    if (begin == end) {
        return FRAME_MORE;
    }
    size_t from = frames->search > frames->taken ? frames->search - frames->taken : 0, mark = 0;
    const char *stop = header_end(begin + from, end, &mark);
    if (!stop) {
        size_t unread = (size_t)(end - begin);
        frames->search = frames->taken + (unread > 2 ? unread - 2 : 0);
        if (unread <= FRAME_HEADER_MOST) {
            return FRAME_MORE;
        }
        frames->taken = frames->search;
        return FRAME_BAD;
    }
    Str header = {begin, (size_t)(stop - begin)};
    size_t length = 0, head = header.length + mark;
    if (!find_length(header, &length)) {
        frames->taken += head;
        frames->search = frames->taken;
        return FRAME_BAD;
    }
    if (length > FRAME_BODY_MOST) {
        frames->taken += head;
        return skip_large(frames, length);
    }
    frames->search = (size_t)(stop - frames->bytes.items); // the header needs no second look
    if ((size_t)(end - begin) - head < length) {
        return FRAME_MORE;
    }
    *body = (Str){begin + head, length};
    frames->taken += head + length;
    frames->search = frames->taken;
    return FRAME_BODY;
}
