// scnrender check FILE: every mistake, no picture.
#include "cli/commands.h"
#include "cli/load.h"
#include "render/light_report.h"

int command_check(const Options *options)
{
    Loading loading;
    int code = loading_begin(&loading, options);
    if (code == EXIT_OK) {
        if (loading_evaluate(&loading)) {
            light_note_laws(&loading.scene, &loading.lang.sink);
            light_warn_enclosed(&loading.scene, &loading.lang.sink);
        }
        code = loading_report(&loading);
    }
    loading_free(&loading);
    return code;
}
