// scnrender FILE --sweep NAME=VALUES: a picture for each value of parameters, and a sheet of them.
#ifndef CLI_SWEEP_H
#define CLI_SWEEP_H

#include "cli/options.h"

// An ExitCode.
int sweep_render(const Options *options);

#endif
