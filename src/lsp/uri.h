// file: URIs and paths.
#ifndef LSP_URI_H
#define LSP_URI_H

#include "base/arena.h"
#include "base/str.h"

// The path that a file: URI names, or NULL for other schemes, other hosts and bad escapes.
const char *uri_to_path(Arena *arena, Str uri);
// The URI of an absolute path.
const char *uri_from_path(Arena *arena, const char *path);

#endif
