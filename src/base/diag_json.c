// Diagnostics for tools.
#include "base/diag_write.h"
#include "base/mem.h"
#include "base/utf8.h"

#include <inttypes.h>

// A JSON string (RFC 8259): what isn't UTF-8 becomes U+FFFD.
static void put_string(FILE *out, const char *text)
{
    if (!text) {
        fputs("null", out);
        return;
    }
    const char *end = text + strlen(text);
    putc('"', out);
    while (text < end) {
        uint32_t code;
        int length = utf8_decode(text, end, &code);
        if (code == UTF8_INVALID) {
            fputs("\\ufffd", out);
        } else if (code == '"' || code == '\\') {
            fprintf(out, "\\%c", (char)code);
        } else if (code == '\n') {
            fputs("\\n", out);
        } else if (code < 0x20 || code == 0x7f) {
            fprintf(out, "\\u%04" PRIx32, code);
        } else {
            fwrite(text, 1, (size_t)length, out);
        }
        text += length;
    }
    putc('"', out);
}

static const char *path_of(const Sources *sources, uint32_t file)
{
    const Source *source = source_get(sources, file);
    return source ? source->path : NULL;
}

static void put_place(FILE *out, Sources *sources, Span at)
{
    fputs("\"file\":", out);
    put_string(out, path_of(sources, at.file));
    Place begin = source_place(sources, at.file, at.begin);
    fprintf(out, ",\"line\":%u,\"column\":%u", begin.line, begin.column);
}

static void put_link(FILE *out, Sources *sources, Span at, const char *text, bool first)
{
    fputs(first ? "{" : ",{", out);
    put_place(out, sources, at);
    fputs(",\"text\":", out);
    put_string(out, text);
    putc('}', out);
}

static void put_chain(FILE *out, Sources *sources, const Diag *diag)
{
    bool first = true;
    fputs(",\"chain\":[", out);
    for (const DiagFrame *frame = diag->frames; frame; frame = frame->next) {
        put_link(out, sources, frame->at, frame->text, first);
        first = false;
    }
    const Source *source = source_get(sources, diag->at.file);
    for (uint32_t depth = 0; source && source->imported_at.file && depth < 64; ++depth) {
        put_link(out, sources, source->imported_at, "imported here", first);
        first = false;
        source = source_get(sources, source->imported_at.file);
    }
    putc(']', out);
}

static void put_diag(FILE *out, Sources *sources, const Diag *diag)
{
    static const char *const severities[] = {"note", "warning", "error"};
    fprintf(out, "{\"code\":\"%s\",\"severity\":\"%s\",\"message\":", diag_info(diag->code)->name,
            severities[diag->severity]);
    put_string(out, diag->message);
    fputs(",\"label\":", out);
    put_string(out, diag->label);
    putc(',', out);
    put_place(out, sources, diag->at);
    Place end = source_place(sources, diag->at.file, diag->at.end);
    fprintf(out, ",\"end_line\":%u,\"end_column\":%u,\"begin\":%u,\"end\":%u,\"notes\":[", end.line,
            end.column, diag->at.begin, diag->at.end);
    for (const DiagNote *note = diag->notes; note; note = note->next) {
        put_string(out, note->text);
        fputs(note->next ? "," : "", out);
    }
    putc(']', out);
    put_chain(out, sources, diag);
    if (diag->fix_text) {
        fputs(",\"fix\":{", out);
        put_place(out, sources, diag->fix_at);
        Place fix_end = source_place(sources, diag->fix_at.file, diag->fix_at.end);
        fprintf(out, ",\"end_line\":%u,\"end_column\":%u,\"begin\":%u,\"end\":%u,\"text\":",
                fix_end.line, fix_end.column, diag->fix_at.begin, diag->fix_at.end);
        put_string(out, diag->fix_text);
        putc('}', out);
    }
    fputs("}\n", out);
}

void diag_write_json(const DiagSink *sink, Sources *sources, FILE *out)
{
    uint32_t *order = diag_sorted(sink);
    for (uint32_t i = 0; i < sink->count; ++i) {
        put_diag(out, sources, &sink->items[order ? order[i] : i]);
    }
    mem_free(order);
    if (sink->out_of_memory) {
        put_diag(
            out, sources,
            &(Diag){.code = E0001, .severity = SEVERITY_ERROR, .message = diag_info(E0001)->title});
    }
}
