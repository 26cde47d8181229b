// scnrender check FILE: every mistake, no picture; with --for, also what an export would change.
#include "cli/commands.h"
#include "cli/exporting.h"
#include "render/light_report.h"
#include "render/material_report.h"

int command_check(const Options *options)
{
    Loading loading;
    ExportNotes notes = {0};
    int code = loading_begin(&loading, options);
    if (code == EXIT_OK) {
        bool good = loading_evaluate(&loading);
        if (good) {
            light_note_laws(&loading.scene, &loading.lang.sink);
            light_warn_enclosed(&loading.scene, loading.lang.threads, &loading.lang.sink);
            material_warn_open_glass(&loading.scene, &loading.lang.sink);
        }
        if (good && options->target && !report_partners(&loading, &notes)) {
            code = complain(EXIT_NO_MEMORY, "the scene can't be looked through for the export");
        }
        int reported = loading_report(&loading);
        code = code == EXIT_OK ? reported : code;
    }
    export_notes_free(&notes);
    loading_free(&loading);
    return code;
}
