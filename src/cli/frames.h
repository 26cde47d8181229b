// scnrender FILE --frames A..B: numbered pictures, and a film of them.
#ifndef CLI_FRAMES_H
#define CLI_FRAMES_H

#include "cli/options.h"

// An ExitCode.
int frames_render(const Options *options);

#endif
