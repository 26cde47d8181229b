// What `check --for` and `export` share.
#ifndef CLI_EXPORTING_H
#define CLI_EXPORTING_H

#include "cli/load.h"
#include "export/export.h"

// Finds what the options' target can't say and reports it as notes. False without memory.
bool report_partners(Loading *loading, ExportNotes *notes);

#endif
