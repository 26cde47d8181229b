#include "format_check.h"

static const ParseLimits limits = {200};

static uint32_t add(FormatBench *bench, const char *text, size_t length)
{
    return sources_add(&bench->sources, "test.scn", NULL, (Str){text, length}, (Span){0});
}

static Str comment_text(const FormatBench *bench, const Ast *ast, size_t i)
{
    Str text = source_get(&bench->sources, ast->file)->text;
    AstComment comment = ast->comments.items[i];
    Str trimmed = {text.at + comment.begin, comment.end - comment.begin};
    while (trimmed.at[1] == '/' && strchr(" \t\r\n", trimmed.at[trimmed.length - 1])) {
        --trimmed.length;
    }
    return trimmed;
}

static const char *compare(const FormatBench *bench, const Ast *before, const Ast *after)
{
    if (!ast_equal(before, after)) {
        return "another tree";
    }
    if (before->comments.count != after->comments.count) {
        return "another number of comments";
    }
    for (size_t i = 0; i < before->comments.count; ++i) {
        if (!str_equal(comment_text(bench, before, i), comment_text(bench, after, i))) {
            return "another comment";
        }
    }
    return NULL;
}

static const char *check_trees(FormatBench *bench, uint32_t before, uint32_t after)
{
    Ast a, b;
    bool good = parse(&a, &bench->sources, before, &bench->names, limits, true, &bench->sink);
    good = parse(&b, &bench->sources, after, &bench->names, limits, true, &bench->sink) && good;
    const char *wrong = good ? compare(bench, &a, &b) : "the result has errors";
    ast_free(&a);
    ast_free(&b);
    return wrong;
}

static const char *check_layout(const FormatText *text)
{
    for (size_t i = 0; i < text->count; ++i) {
        if (text->items[i] == '\n' && i == 0) {
            return "a blank line at the beginning";
        }
        if (text->items[i] == '\n' && i >= 2 && text->items[i - 1] == '\n' &&
            text->items[i - 2] == '\n') {
            return "two blank lines"; // the caller knows whether they are a comment's
        }
    }
    bool only_a_mark = text->count == 3 && memcmp(text->items, "\xef\xbb\xbf", 3) == 0;
    return text->count && !only_a_mark && text->items[text->count - 1] != '\n'
               ? "no end of the last line"
               : NULL;
}

const char *format_bench_check(FormatBench *bench, const char *text, size_t length)
{
    *bench = (FormatBench){0};
    sources_init(&bench->sources, &bench->arena);
    interner_init(&bench->names, &bench->arena);
    diag_sink_init(&bench->sink, &bench->arena);
    uint32_t file = add(bench, text, length);
    bench->accepted =
        format_source(&bench->once, &bench->sources, file, &bench->names, limits, &bench->sink);
    if (!bench->accepted) {
        return bench->sink.errors > 0 ? NULL : "refused without a diagnostic";
    }
    uint32_t again = add(bench, bench->once.items ? bench->once.items : "", bench->once.count);
    const char *wrong = check_trees(bench, file, again);
    if (wrong) {
        return wrong;
    }
    if (!format_source(&bench->twice, &bench->sources, again, &bench->names, limits,
                       &bench->sink)) {
        return "not accepted the second time";
    }
    if (bench->once.count != bench->twice.count ||
        (bench->once.count > 0 &&
         memcmp(bench->once.items, bench->twice.items, bench->once.count) != 0)) {
        return "another text the second time";
    }
    bool free_comments = memchr(text, '*', length) != NULL; // may hold any lines
    return free_comments ? NULL : check_layout(&bench->once);
}

void format_bench_end(FormatBench *bench)
{
    array_free(&bench->once);
    array_free(&bench->twice);
    diag_sink_free(&bench->sink);
    interner_free(&bench->names);
    sources_free(&bench->sources);
    arena_free(&bench->arena);
}
