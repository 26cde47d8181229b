// What the two printers of diagnostics share.
#ifndef BASE_DIAG_WRITE_H
#define BASE_DIAG_WRITE_H

#include "base/diag.h"

// The diagnostics' indices by file, place and order of report, to be given back with mem_free; NULL
// without memory for it (then print them as they came) or where there are none.
uint32_t *diag_sorted(const DiagSink *sink);

#endif
