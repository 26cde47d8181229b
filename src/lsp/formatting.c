// `scnrender fmt` for a document, as the edits of the lines that change.
#include "lsp/features.h"

#include "base/line_diff.h"
#include "lang/format.h"

static ParseLimits parse_limits(const Server *server)
{
    uint64_t nesting = server->host->limits.nesting;
    return (ParseLimits){nesting < PARSE_NESTING_MOST ? (uint32_t)nesting : PARSE_NESTING_MOST};
}

// The canonical text; false where the document has errors of syntax.
static bool format(Server *server, const Document *document, FormatText *out)
{
    Arena arena = {0};
    Sources sources;
    Interner names;
    DiagSink sink;
    sources_init(&sources, &arena);
    interner_init(&names, &arena);
    diag_sink_init(&sink, &arena);
    uint32_t file =
        sources_add(&sources, document->path, NULL, buffer_content(&document->text), (Span){0});
    bool good = file && format_source(out, &sources, file, &names, parse_limits(server), &sink);
    diag_sink_free(&sink);
    interner_free(&names);
    sources_free(&sources);
    arena_free(&arena);
    return good;
}

static Str joined(const DiffLines *lines, int begin, int end, Str text)
{
    const char *from = begin < lines->count ? lines->items[begin].at : text.at + text.length;
    const char *to = end < lines->count ? lines->items[end].at : text.at + text.length;
    return (Str){from, (size_t)(to - from)};
}

// The edits of the changes that touch bytes [begin, end).
static void add_edits(const Server *server, const Document *document, const LineDiff *diff,
                      Str before, Str after, uint32_t begin, uint32_t end, cJSON *list)
{
    LineChange change;
    for (int i = 0, k = 0; line_diff_next(diff, &i, &k, &change);) {
        Str old = joined(&diff->before, change.before, change.before_end, before);
        Str new = joined(&diff->after, change.after, change.after_end, after);
        uint32_t at = (uint32_t)(old.at - before.at), stop = at + (uint32_t)old.length;
        if (at <= end && stop >= begin) {
            cJSON_AddItemToArray(list, json_edit(server, &document->text, at, stop, new));
        }
    }
}

static cJSON *format_range(Server *server, Document *document, uint32_t begin, uint32_t end)
{
    FormatText formatted = {0};
    cJSON *list = NULL;
    if (format(server, document, &formatted)) {
        Str before = buffer_content(&document->text);
        Str after = {formatted.items ? formatted.items : "", formatted.count};
        LineDiff diff;
        list = cJSON_CreateArray();
        if (line_diff(&diff, before, after)) {
            add_edits(server, document, &diff, before, after, begin, end, list);
        }
        line_diff_free(&diff);
    } else {
        server_fail(server, RPC_FAILED, "only scenes without errors of syntax can be formatted");
    }
    array_free(&formatted);
    return list;
}

cJSON *feature_formatting(Server *server, Document *document, const cJSON *params)
{
    (void)params;
    return format_range(server, document, 0, (uint32_t)document->text.bytes.count);
}

cJSON *feature_range_formatting(Server *server, Document *document, const cJSON *params)
{
    uint32_t begin, end;
    server_range(server, document, json_at(params, "range"), &begin, &end);
    return format_range(server, document, begin, end > begin ? end - 1 : end);
}
