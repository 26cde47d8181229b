// scnrender check FILE: every mistake, no picture.
#include "cli/commands.h"
#include "cli/load.h"

int command_check(const Options *options)
{
    Loading loading;
    int code = loading_begin(&loading, options);
    if (code == EXIT_OK) {
        loading_evaluate(&loading);
        code = loading_report(&loading);
    }
    loading_free(&loading);
    return code;
}
