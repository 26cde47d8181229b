#include "cli/load.h"

#include "base/thread.h"
#include "cli/told.h"
#include "render/render.h"

#include <errno.h>
#include <limits.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

int complain(int code, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("scnrender: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    return code;
}

int complain_no_memory(void)
{
    return complain(EXIT_NO_MEMORY, "not enough memory");
}

size_t stem_length(const char *name)
{
    const char *slash = strrchr(name, '/'), *file = slash ? slash + 1 : name;
    const char *dot = strrchr(file, '.');
    return dot && dot > file ? (size_t)(dot - name) : strlen(name);
}

// --- Finding the scene
// -----------------------------------------------------------------------------

// The scene comes from a pipe: it is read whole, and names in it start from the working folder.
static int begin_text(Loading *loading, const char *name)
{
    char folder[PATH_MAX];
    if (!getcwd(folder, sizeof folder)) {
        return complain(EXIT_FILES, "the working folder can't be found: %s", strerror(errno));
    }
    IoError error = file_read(name, loading->options->limits.file_bytes, &loading->text);
    if (error != IO_OK) {
        return complain(error == IO_NO_MEMORY ? EXIT_NO_MEMORY : EXIT_FILES, "can't read %s: %s",
                        loading->shown, io_error_text(error));
    }
    loading->is_text = true;
    loading->path = arena_printf(&loading->lang.arena, "%s/standard input", folder);
    loading->lang.given_path = loading->path;
    loading->lang.given_text = (Str){loading->text.bytes, loading->text.size};
    return loading->path ? EXIT_OK : complain_no_memory();
}

static int begin_file(Loading *loading, const char *name)
{
    char real[PATH_MAX];
    if (!realpath(name, real)) {
        return complain(EXIT_FILES, "can't read `%s`: %s", name, strerror(errno));
    }
    struct stat info;
    if (stat(real, &info) == 0 && !S_ISREG(info.st_mode)) {
        return complain(EXIT_FILES, "can't read `%s`: it is not a file", name);
    }
    if (access(real, R_OK) != 0) {
        return complain(EXIT_FILES, "can't read `%s`: %s", name, strerror(errno));
    }
    loading->path = arena_copy_string(&loading->lang.arena, real, strlen(real));
    return loading->path ? EXIT_OK : complain_no_memory();
}

static int allow(Loading *loading, const char *folder)
{
    IoError error = sandbox_allow(&loading->sandbox, folder);
    return error == IO_OK ? EXIT_OK
           : error == IO_TOO_LARGE
               ? complain(EXIT_USAGE, "too many folders are allowed; `%s` is one too many", folder)
               : complain(EXIT_FILES, "can't read the folder `%s`: %s", folder,
                          io_error_text(error));
}

static int open_sandbox(Loading *loading)
{
    const char *slash = strrchr(loading->path, '/');
    size_t length = slash > loading->path ? (size_t)(slash - loading->path) : 1;
    const char *folder = arena_copy_string(&loading->lang.arena, loading->path, length);
    int code = folder ? allow(loading, folder) : complain_no_memory();
    for (size_t i = 0; code == EXIT_OK && i < loading->options->folder_count; ++i) {
        code = allow(loading, loading->options->folders[i]);
    }
    IoError error = code == EXIT_OK ? lang_use_library(&loading->lang) : IO_OK;
    return error == IO_OK
               ? code
               : complain(EXIT_FILES, "can't read the standard library: %s", io_error_text(error));
}

int loading_begin(Loading *loading, const Options *options)
{
    *loading = (Loading){.options = options};
    sandbox_init(&loading->sandbox);
    const Schema *schema = render_schema();
    loading->has_lang = lang_init(&loading->lang, schema, &loading->sandbox);
    loading->has_scene =
        loading->has_lang && scene_init(&loading->scene, schema, &loading->sandbox);
    if (!loading->has_scene) {
        return complain_no_memory();
    }
    loading->lang.limits = options->limits;
    loading->lang.settings = options->settings;
    loading->lang.setting_count = options->setting_count;
    loading->lang.threads = options->threads ? options->threads : thread_processor_count();
    loading->sandbox.threads = loading->lang.threads;
    loading->lang.print_to = options->quiet ? NULL : stderr;
    loading->lang.sink.limit = options->limits.diagnostics < UINT32_MAX
                                   ? (uint32_t)options->limits.diagnostics
                                   : UINT32_MAX;
    const char *name = options->operand;
    bool standard_input = strcmp(name, "-") == 0;
    loading->shown = standard_input ? "<stdin>" : name;
    struct stat info;
    bool pipe = !standard_input && stat(name, &info) == 0 &&
                (S_ISFIFO(info.st_mode) || S_ISCHR(info.st_mode));
    int code = standard_input || pipe ? begin_text(loading, name) : begin_file(loading, name);
    return code == EXIT_OK ? open_sandbox(loading) : code;
}

bool loading_evaluate(Loading *loading)
{
    return lang_load(&loading->lang, loading->path, loading->shown, &loading->scene);
}

void loading_free_part(Loading *loading, unsigned part)
{
    if (part == 0) {
        if (loading->has_scene) {
            scene_free(&loading->scene);
        }
        return;
    }
    if (loading->has_lang) {
        lang_free(&loading->lang);
    }
    file_bytes_free(&loading->text);
    sandbox_free(&loading->sandbox);
}

void loading_free(Loading *loading)
{
    for (unsigned part = 0; part < LOADING_PARTS; ++part) {
        loading_free_part(loading, part);
    }
}

// --- Diagnostics
// -----------------------------------------------------------------------------------

static DiagColor color_of_errors(void)
{
    const char *no_color = getenv("NO_COLOR"), *term = getenv("TERM");
    bool plain = (no_color && *no_color) || (term && strcmp(term, "dumb") == 0);
    return !plain && isatty(STDERR_FILENO) ? DIAG_COLORED : DIAG_PLAIN;
}

// The same sink with nothing but its errors; false without memory.
static bool keep_errors(DiagSink *sink)
{
    Diag *errors = arena_array(sink->arena, (size_t)sink->count + 1, sizeof *errors);
    uint32_t count = 0;
    for (uint32_t i = 0; errors && i < sink->count; ++i) {
        if (sink->items[i].severity == SEVERITY_ERROR) {
            errors[count++] = sink->items[i];
        }
    }
    sink->items = errors;
    sink->count = count;
    sink->warnings = 0;
    return errors != NULL;
}

static void write_counted(uint32_t count, const char *what, const char *before)
{
    if (count > 0) {
        fprintf(stderr, "%s%u %s%s", before, (unsigned)count, what, count == 1 ? "" : "s");
    }
}

static void write_summary(const DiagSink *sink)
{
    if (sink->errors + sink->warnings == 0) {
        return;
    }
    write_counted(sink->errors, "error", "");
    write_counted(sink->warnings, "warning", sink->errors ? ", " : "");
    if (sink->dropped > 0) {
        fprintf(stderr, " (%u not shown; see --limit diagnostics=N)", (unsigned)sink->dropped);
    }
    fputc('\n', stderr);
}

static bool memory_ran_out(const DiagSink *sink)
{
    bool out = sink->out_of_memory;
    for (uint32_t i = 0; i < sink->count; ++i) {
        out |= sink->items[i].code == E0001;
    }
    return out;
}

static int report(const Options *options, Told *told, const DiagSink *sink, Sources *sources)
{
    DiagSink shown = *sink;
    if ((options->quiet && !keep_errors(&shown)) ||
        (told && !told_keep_new(told, &shown, sources))) {
        return complain_no_memory();
    }
    if (options->json) {
        diag_write_json(&shown, sources, stderr);
    } else {
        diag_write_text(&shown, sources, stderr, color_of_errors());
        write_summary(&shown);
    }
    fflush(stderr);
    if (memory_ran_out(sink)) {
        return shown.count > 0 ? EXIT_NO_MEMORY : complain_no_memory();
    }
    return sink->errors > 0 ? EXIT_DIAGNOSTICS : EXIT_OK;
}

int report_diagnostics(const Options *options, const DiagSink *sink, Sources *sources)
{
    return report(options, NULL, sink, sources);
}

int loading_report(Loading *loading)
{
    return report(loading->options, loading->told, &loading->lang.sink, &loading->lang.sources);
}
