// scnrender params FILE: a scene's parameters, as JSON.
#include "cli/commands.h"
#include "cli/load.h"

int command_params(const Options *options)
{
    Loading loading;
    int code = loading_begin(&loading, options);
    if (code == EXIT_OK) {
        lang_params_json(&loading.lang, loading.path, loading.shown, stdout);
        code = loading_report(&loading);
    }
    loading_free(&loading);
    return code;
}
