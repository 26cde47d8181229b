// Diagnostics that were shown already: of many pictures of one scene each is told once.
#ifndef CLI_TOLD_H
#define CLI_TOLD_H

#include "base/array.h"
#include "base/diag.h"

typedef struct Told { // of zero bytes: nothing was told
    ARRAY(uint64_t) hashes;
} Told;

// Leaves in *sink, a copy, only what wasn't told before, and keeps it as told. False without
// memory.
bool told_keep_new(Told *told, DiagSink *sink, const Sources *sources);
void told_free(Told *told);

#endif
