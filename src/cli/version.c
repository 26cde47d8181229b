// scnrender version
#include "cli/commands.h"

int command_version(const Options *options)
{
    (void)options;
    puts("scnrender " SCN_VERSION);
    return EXIT_OK;
}
