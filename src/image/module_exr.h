// What the two halves of the module scn_exr.so share; see exr_module.h.
#ifndef IMAGE_MODULE_EXR_H
#define IMAGE_MODULE_EXR_H

#include "image/exr_module.h"

#include <openexr.h>

// OpenEXR's settings for a context whose functions get `user`, with memory of the caller's.
exr_context_initializer_t exr_context_settings(ExrMemory memory, void *user);

ExrReading exr_module_read(ExrRead *read);

#endif
