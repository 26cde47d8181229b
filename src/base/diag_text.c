// Diagnostics for people.
#include "base/diag_write.h"
#include "base/mem.h"
#include "base/utf8.h"

enum {
    TAB_STOP = 4,
    LINE_COLUMNS = 160, // of a source line, most that are shown
    LEAD_COLUMNS = 60,  // of them before the span, where the line is cut
    LEAD_BYTES = 500,   // that are looked at for them; characters of no width may be among them
    LINE_BYTES = 4000,  // of a line from there on, most that are looked at
    FRAMES_FIRST = 8,   // of a long chain, what is shown at its inner …
    FRAMES_LAST = 4,    // … and at its outer end
};

typedef struct Printer {
    const DiagSink *sink;
    Sources *sources;
    FILE *out;
    bool colored;
    int width; // of the line numbers of the diagnostic being printed
} Printer;

static void style(const Printer *p, const char *code)
{
    if (p->colored) {
        fprintf(p->out, "\033[%sm", code);
    }
}

#define STYLE_OFF    "0"
#define STYLE_BOLD   "1"
#define STYLE_GUTTER "1;34"

static const char *severity_style(Severity severity)
{
    return severity == SEVERITY_ERROR ? "1;31" : severity == SEVERITY_WARNING ? "1;33" : "1;36";
}

static const char *severity_name(Severity severity)
{
    return severity == SEVERITY_ERROR ? "error" : severity == SEVERITY_WARNING ? "warning" : "note";
}

static void put_spaces(FILE *out, long count)
{
    for (; count > 0; --count) {
        putc(' ', out);
    }
}

// One character; what must not reach a terminal is shown as U+FFFD.
static void put_character(FILE *out, const char *at, int length, uint32_t code)
{
    if (code == UTF8_INVALID || utf8_is_control(code)) {
        fputs("\xef\xbf\xbd", out);
    } else {
        fwrite(at, 1, (size_t)length, out);
    }
}

// Text of a message. Its further lines are indented by `indent`.
static void put_text(const Printer *p, const char *text, int indent)
{
    const char *end = text + strlen(text);
    while (text < end) {
        uint32_t code;
        int length = utf8_decode(text, end, &code);
        if (code == '\n') {
            putc('\n', p->out);
            put_spaces(p->out, indent);
        } else if (code == '\t') {
            putc(' ', p->out);
        } else {
            put_character(p->out, text, length, code);
        }
        text += length;
    }
}

// --- Places --------------------------------------------------------------------------------------

static void put_place(const Printer *p, Span at)
{
    const Source *source = source_get(p->sources, at.file);
    if (!source) {
        return;
    }
    Place place = source_place(p->sources, at.file, at.begin);
    put_spaces(p->out, p->width + 1);
    style(p, STYLE_GUTTER);
    fputs("-->", p->out);
    style(p, STYLE_OFF);
    putc(' ', p->out);
    put_text(p, source->path, 0);
    fprintf(p->out, ":%u:%u\n", place.line, place.column);
}

// "   |", or " 8 |" where line > 0; without a space after it.
static void put_gutter(const Printer *p, uint32_t line)
{
    style(p, STYLE_GUTTER);
    if (line) {
        fprintf(p->out, " %*u |", p->width, line);
    } else {
        put_spaces(p->out, p->width + 2);
        putc('|', p->out);
    }
    style(p, STYLE_OFF);
}

static void put_prefix(const Printer *p)
{
    put_spaces(p->out, p->width + 2);
    style(p, STYLE_GUTTER);
    fputs("= ", p->out);
    style(p, STYLE_OFF);
}

// --- Source lines --------------------------------------------------------------------------------

static long width_at(uint32_t code, long column)
{
    if (code == '\t') {
        return TAB_STOP - column % TAB_STOP;
    }
    return code == UTF8_INVALID || utf8_is_control(code) ? 1 : utf8_width(code);
}

// Columns that the first `bytes` bytes of a line take. A byte inside a character counts as its
// start.
static long columns_of(Str line, size_t bytes)
{
    long column = 0;
    const char *at = line.at, *end = line.at + line.length;
    while (at < end && (size_t)(at - line.at) < bytes) {
        uint32_t code;
        int length = utf8_decode(at, end, &code);
        if ((size_t)(at - line.at) + (size_t)length > bytes) {
            break;
        }
        column += width_at(code, column);
        at += length;
    }
    return column;
}

// The columns [first, last) of a line.
static void put_columns(const Printer *p, Str line, long first, long last)
{
    long column = 0;
    const char *at = line.at, *end = line.at + line.length;
    while (at < end && column < last) {
        uint32_t code;
        int length = utf8_decode(at, end, &code);
        long width = width_at(code, column);
        if (column >= first && code == '\t') {
            put_spaces(p->out, width);
        } else if (column >= first) {
            put_character(p->out, at, length, code);
        } else if (column + width > first) {
            put_spaces(p->out, column + width - first); // a wide character cut in two
        }
        column += width;
        at += length;
    }
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

static bool inside_character(char c)
{
    return ((unsigned char)c & 0xc0) == 0x80;
}

// Cuts a line of a million bytes down to those near the span [*begin, *end), which it moves along;
// true where bytes before or behind it are gone.
static bool cut_before(Str *line, size_t *begin, size_t *end)
{
    if (*begin <= (size_t)LINE_BYTES || line->length <= (size_t)LINE_BYTES) {
        return false;
    }
    size_t skip = (*begin < line->length ? *begin : line->length) - LEAD_BYTES;
    for (int i = 0; i < 3 && inside_character(line->at[skip]); ++i) {
        --skip;
    }
    *line = (Str){line->at + skip, line->length - skip};
    *begin -= skip;
    *end -= skip;
    return true;
}
static bool cut_behind(Str *line, size_t begin, size_t *end)
{
    size_t most = begin + LINE_BYTES;
    if (line->length <= most) {
        return false;
    }
    for (int i = 0; i < 3 && inside_character(line->at[most]); ++i) {
        --most;
    }
    line->length = most;
    *end = *end < most ? *end : most;
    return true;
}

// A source line with carets under its bytes [begin, end), and the label.
static void put_marked_line(const Printer *p, const Diag *diag, uint32_t number, size_t begin,
                            size_t end, const char *label)
{
    Str line = source_line(p->sources, diag->at.file, number);
    bool more_before = cut_before(&line, &begin, &end);
    bool more_behind = cut_behind(&line, begin, &end);
    while (!more_behind && line.length > end && line.length > begin &&
           is_blank(line.at[line.length - 1])) {
        --line.length;
    }
    long from = columns_of(line, begin), to = columns_of(line, end);
    if (begin > line.length) { // the line's end itself
        from += (long)(begin - line.length);
    }
    to = to > from ? to : from + 1;
    long whole = columns_of(line, line.length), first = 0;
    if (more_before || (whole > LINE_COLUMNS && to > LINE_COLUMNS - 20)) {
        first = from > LEAD_COLUMNS ? from - LEAD_COLUMNS : 0;
    }
    long last = first + LINE_COLUMNS < whole ? first + LINE_COLUMNS : whole;
    if (to > last && last < whole) {
        to = last;
    }
    bool cut = first > 0 || more_before;
    more_behind = more_behind || last < whole;
    put_gutter(p, number);
    if (last > first) {
        fputs(cut ? " … " : " ", p->out);
        put_columns(p, line, first, last);
        fputs(more_behind ? " …" : "", p->out);
    }
    putc('\n', p->out);
    put_gutter(p, 0);
    put_spaces(p->out, 1 + (cut ? 2 : 0) + from - first);
    style(p, severity_style(diag->severity));
    for (long i = from; i < to; ++i) {
        putc('^', p->out);
    }
    if (label && *label) {
        putc(' ', p->out);
        put_text(p, label, p->width + 4);
    }
    style(p, STYLE_OFF);
    putc('\n', p->out);
}

static size_t line_start(const Printer *p, uint32_t file, uint32_t line)
{
    return (size_t)(source_line(p->sources, file, line).at - source_get(p->sources, file)->text.at);
}

// A span over several lines shows its first and its last line.
static void put_snippet(const Printer *p, const Diag *diag, uint32_t first, uint32_t last)
{
    Span at = diag->at;
    if (!source_get(p->sources, at.file)->lines) {
        return; // no memory for the table of lines
    }
    put_gutter(p, 0);
    putc('\n', p->out);
    size_t start = line_start(p, at.file, first);
    Str line = source_line(p->sources, at.file, first);
    if (first == last) {
        put_marked_line(p, diag, first, at.begin - start, at.end - start, diag->label);
        return;
    }
    while (line.length > at.begin - start + 1 && is_blank(line.at[line.length - 1])) {
        --line.length;
    }
    put_marked_line(p, diag, first, at.begin - start, line.length, NULL);
    if (last > first + 1) {
        style(p, STYLE_GUTTER);
        put_spaces(p->out, p->width);
        fputs("...\n", p->out);
        style(p, STYLE_OFF);
    }
    start = line_start(p, at.file, last);
    line = source_line(p->sources, at.file, last);
    size_t begin = 0, end = at.end - start;
    while (begin + 1 < end && begin < line.length && is_blank(line.at[begin])) {
        ++begin;
    }
    put_marked_line(p, diag, last, begin, end, diag->label);
}

// --- Chains --------------------------------------------------------------------------------------

static void put_link(const Printer *p, const char *text, Span at)
{
    put_prefix(p);
    put_text(p, text, p->width + 4);
    putc('\n', p->out);
    put_place(p, at);
}

static void put_chain(const Printer *p, const Diag *diag)
{
    uint32_t count = 0, i = 0;
    for (const DiagFrame *frame = diag->frames; frame; frame = frame->next) {
        ++count;
    }
    for (const DiagFrame *frame = diag->frames; frame; frame = frame->next, ++i) {
        bool cut = count > FRAMES_FIRST + FRAMES_LAST + 1;
        if (!cut || i < FRAMES_FIRST || i >= count - FRAMES_LAST) {
            put_link(p, frame->text, frame->at);
        } else if (i == FRAMES_FIRST) {
            put_prefix(p);
            fprintf(p->out, "… %u more …\n", count - FRAMES_FIRST - FRAMES_LAST);
        }
    }
    const Source *source = source_get(p->sources, diag->at.file);
    for (uint32_t depth = 0; source && source->imported_at.file && depth < 64; ++depth) {
        put_link(p, "imported here", source->imported_at);
        source = source_get(p->sources, source->imported_at.file);
    }
}

// --- A diagnostic --------------------------------------------------------------------------------

static int digits_of(uint32_t number)
{
    int digits = 1;
    for (; number >= 10; number /= 10) {
        ++digits;
    }
    return digits;
}

static void put_headline(const Printer *p, Severity severity, const char *code, const char *message)
{
    style(p, severity_style(severity));
    fprintf(p->out, "%s[%s]", severity_name(severity), code);
    style(p, STYLE_OFF);
    style(p, STYLE_BOLD);
    fputs(": ", p->out);
    put_text(p, message, 4);
    style(p, STYLE_OFF);
    putc('\n', p->out);
}

static void put_diag(Printer *p, const Diag *diag)
{
    Diag inside = *diag;
    const Source *source = source_get(p->sources, diag->at.file);
    uint32_t first = 0, last = 0;
    if (source) {
        uint32_t size = (uint32_t)source->text.length;
        inside.at.begin = diag->at.begin < size ? diag->at.begin : size;
        inside.at.end = diag->at.end < size ? diag->at.end : size;
        if (inside.at.end < inside.at.begin) {
            inside.at.end = inside.at.begin;
        }
        bool empty = inside.at.end == inside.at.begin;
        first = source_place(p->sources, inside.at.file, inside.at.begin).line;
        // The line break that ends a line belongs to it.
        last = source_place(p->sources, inside.at.file, inside.at.end - !empty).line;
    }
    p->width = digits_of(last);
    put_headline(p, diag->severity, diag_info(diag->code)->name, diag->message);
    put_place(p, inside.at);
    if (source) {
        put_snippet(p, &inside, first, last);
    } else if (diag->label && *diag->label) {
        put_prefix(p);
        put_text(p, diag->label, p->width + 4);
        putc('\n', p->out);
    }
    for (const DiagNote *note = diag->notes; note; note = note->next) {
        put_prefix(p);
        fputs("note: ", p->out);
        put_text(p, note->text, p->width + 10);
        putc('\n', p->out);
    }
    put_chain(p, &inside);
}

void diag_write_text(const DiagSink *sink, Sources *sources, FILE *out, DiagColor color)
{
    Printer p = {sink, sources, out, color == DIAG_COLORED, 1};
    uint32_t *order = diag_sorted(sink);
    for (uint32_t i = 0; i < sink->count; ++i) {
        if (i > 0) {
            putc('\n', out);
        }
        put_diag(&p, &sink->items[order ? order[i] : i]);
    }
    mem_free(order);
    if (sink->dropped) {
        fprintf(out, "%s%u more diagnostic%s not shown\n", sink->count ? "\n" : "", sink->dropped,
                sink->dropped == 1 ? " is" : "s are");
    }
    if (sink->out_of_memory) {
        put_headline(&p, SEVERITY_ERROR, diag_info(E0001)->name, diag_info(E0001)->title);
    }
}
