// scnrender export FILE --to TARGET: the flat scene, written for another program.
#include "cli/commands.h"
#include "cli/exporting.h"
#include "cli/load.h"

#include "base/io.h"

#include <errno.h>
#include <string.h>

bool report_partners(Loading *loading, ExportNotes *notes)
{
    DiagSink *sink = &loading->lang.sink;
    const Options *options = loading->options;
    if (!export_check(options->target, &loading->scene, &loading->lang.sources, notes)) {
        return false;
    }
    Diag *diag = NULL;
    for (size_t i = 0; i < notes->list.count; ++i) {
        const ExportNote *note = &notes->list.items[i];
        const ExportNote *before = i > 0 ? note - 1 : NULL;
        bool same = before && diag && before->at.file == note->at.file &&
                    before->at.begin == note->at.begin && before->at.end == note->at.end;
        if (same) { // one diagnostic a place
            diag_note(sink, diag, "%s", note->text);
        } else {
            diag = diag_report(sink, N0980, note->at, "for %s: %s", options->target->program,
                               note->text);
        }
    }
    return true;
}

static const char *title_of(const char *shown)
{
    const char *slash = strrchr(shown, '/');
    return slash ? slash + 1 : shown;
}

// "shelf.pov" for "shelf.scn", in the working folder's terms.
static const char *default_name(Loading *loading)
{
    const char *name = loading->shown;
    return arena_printf(&loading->lang.arena, "%.*s.%s", (int)stem_length(name), name,
                        loading->options->target->extension);
}

static int write_to(Loading *loading, ExportNotes *notes, FILE *out)
{
    export_write(loading->options->target, &loading->scene, &loading->lang.sources,
                 title_of(loading->shown), notes, out);
    return ferror(out) ? EXIT_FILES : EXIT_OK;
}

static int write_file(Loading *loading, ExportNotes *notes)
{
    const char *name = loading->options->output;
    char message[512];
    AtomicFile file;
    if (name && strcmp(name, "-") == 0) {
        return write_to(loading, notes, stdout);
    }
    if (!name && loading->is_text) {
        return complain(EXIT_USAGE, "a scene from the standard input needs --output");
    }
    name = name ? name : default_name(loading);
    if (!name) {
        return complain_no_memory();
    }
    if (!atomic_file_open(&file, name, message, sizeof message)) {
        return complain(EXIT_FILES, "can't write `%s`: %s", name, message);
    }
    write_to(loading, notes, file.stream);
    if (!atomic_file_commit(&file, message, sizeof message)) {
        return complain(EXIT_FILES, "can't write `%s`: %s", name, message);
    }
    return EXIT_OK;
}

int command_export(const Options *options)
{
    Loading loading;
    ExportNotes notes = {0};
    int code = loading_begin(&loading, options);
    if (code == EXIT_OK) {
        bool noted = !loading_evaluate(&loading) || report_partners(&loading, &notes);
        code = loading_report(&loading);
        if (!noted) {
            code = complain(EXIT_NO_MEMORY, "the scene can't be looked through for the export");
        }
    }
    if (code == EXIT_OK) {
        code = write_file(&loading, &notes);
    }
    export_notes_free(&notes);
    loading_free(&loading);
    return code;
}
