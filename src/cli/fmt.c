// scnrender fmt FILE…: each file is laid out anew, in place; `-` from standard input to standard
// output.
#include "cli/commands.h"
#include "cli/diff.h"
#include "cli/load.h"

#include "base/big_stack.h"
#include "lang/format.h"

#include <string.h>

enum { STACK_BYTES = 64 << 20 }; // for deep scenes under a raised limit

typedef struct File {
    const Options *options;
    const char *name, *shown;
    Arena arena;
    Sources sources;
    Interner names;
    DiagSink sink;
    FileBytes text;
    FormatText formatted;
} File;

static ParseLimits parse_limits(const Options *options)
{
    uint64_t nesting = options->limits.nesting;
    return (ParseLimits){nesting < PARSE_NESTING_MOST ? (uint32_t)nesting : PARSE_NESTING_MOST};
}

static Str formatted_text(const File *file)
{
    return (Str){file->formatted.items ? file->formatted.items : "", file->formatted.count};
}

// The new text means what the old one did. A failure would be a mistake of the formatter's; the
// scene is then better left alone.
static bool means_the_same(File *file, uint32_t before)
{
    uint32_t after =
        sources_add(&file->sources, file->shown, NULL, formatted_text(file), (Span){0});
    ParseLimits limits = parse_limits(file->options);
    Ast old = {0}, new = {0};
    bool same = after != 0;
    same = same && parse(&old, &file->sources, before, &file->names, limits, false, &file->sink);
    same = same && parse(&new, &file->sources, after, &file->names, limits, false, &file->sink);
    same = same && ast_equal(&old, &new);
    ast_free(&old);
    ast_free(&new);
    return same;
}

static int replace(const File *file)
{
    char message[512];
    AtomicFile out;
    if (!atomic_file_open(&out, file->name, message, sizeof message)) {
        return complain(EXIT_FILES, "%s", message);
    }
    Str text = formatted_text(file);
    fwrite(text.at, 1, text.length, out.stream);
    if (!atomic_file_commit(&out, message, sizeof message)) {
        return complain(EXIT_FILES, "%s", message);
    }
    if (!file->options->quiet) {
        fprintf(stderr, "formatted %s\n", file->shown);
    }
    return EXIT_OK;
}

// What is to be done with the new text.
static int deliver(const File *file)
{
    const Options *options = file->options;
    Str before = {file->text.bytes, file->text.size}, after = formatted_text(file);
    bool changed = !str_equal(before, after);
    if (changed && options->diff && !diff_write(before, after, file->shown, stdout)) {
        return complain_no_memory();
    }
    if (options->check) {
        if (changed && !options->diff) {
            printf("%s\n", file->shown);
        }
        return changed ? EXIT_DIAGNOSTICS : EXIT_OK;
    }
    if (options->diff) {
        return EXIT_OK;
    }
    if (strcmp(file->name, "-") == 0) {
        fwrite(after.at, 1, after.length, stdout);
        return EXIT_OK;
    }
    return changed ? replace(file) : EXIT_OK;
}

static int format_text(File *file)
{
    sources_init(&file->sources, &file->arena);
    interner_init(&file->names, &file->arena);
    diag_sink_init(&file->sink, &file->arena);
    uint64_t most = file->options->limits.diagnostics;
    file->sink.limit = most < UINT32_MAX ? (uint32_t)most : UINT32_MAX;
    Str text = {file->text.bytes, file->text.size};
    uint32_t source = sources_add(&file->sources, file->shown, NULL, text, (Span){0});
    if (!source) {
        return complain_no_memory();
    }
    if (!format_source(&file->formatted, &file->sources, source, &file->names,
                       parse_limits(file->options), &file->sink)) {
        return report_diagnostics(file->options, &file->sink, &file->sources);
    }
    if (!means_the_same(file, source)) {
        return complain(EXIT_DIAGNOSTICS,
                        "formatting `%s` would change its meaning, so it is left alone; please "
                        "report this",
                        file->shown);
    }
    return deliver(file);
}

static int format_file(const Options *options, const char *name)
{
    File file = {.options = options, .name = name};
    file.shown = strcmp(name, "-") == 0 ? "<stdin>" : name;
    uint64_t most = options->limits.file_bytes;
    IoError error = file_read(name, most < UINT32_MAX ? most : UINT32_MAX, &file.text);
    if (error != IO_OK) {
        return complain(error == IO_NO_MEMORY ? EXIT_NO_MEMORY : EXIT_FILES, "can't read `%s`: %s",
                        file.shown, io_error_text(error));
    }
    int code = format_text(&file);
    array_free(&file.formatted);
    diag_sink_free(&file.sink);
    interner_free(&file.names);
    sources_free(&file.sources);
    arena_free(&file.arena);
    file_bytes_free(&file.text);
    return code;
}

typedef struct Work {
    const Options *options;
    int code; // the greatest of the files'
} Work;

static void format_all(void *context, uintptr_t floor)
{
    (void)floor;
    Work *work = context;
    for (size_t i = 0; i < work->options->operand_count; ++i) {
        int code = format_file(work->options, work->options->operands[i]);
        work->code = code > work->code ? code : work->code;
    }
}

int command_fmt(const Options *options)
{
    Work work = {options, EXIT_OK};
    call_on_big_stack(STACK_BYTES, format_all, &work);
    return work.code;
}
