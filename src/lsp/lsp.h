// The language server: scenes' diagnostics, completion, hover and so on for editors, after the
// Language Server Protocol 3.17.
#ifndef LSP_LSP_H
#define LSP_LSP_H

#include "lang/lang.h"

// What the server is given by whoever starts it.
typedef struct LspHost {
    const Schema *schema;
    // More checks of a scene that was evaluated without an error; may be NULL.
    void (*check)(const Scene *scene, DiagSink *sink);
    Limits limits;
    const char *const *folders; // that scenes may read, beside their own
    size_t folder_count;
    const char *version;
    bool evaluates; // else it starts no processes
} LspHost;

typedef enum LspEnd {
    LSP_ENDED,     // asked to shut down, then to exit
    LSP_ABANDONED, // `exit` without `shutdown`, or the client is gone
    LSP_NO_MEMORY,
} LspEnd;

// Serves a client over two files (standard input and output) until it ends. Needs a stack of some
// MiB. Starts processes of its own to evaluate scenes; none is left at the end.
LspEnd lsp_serve(const LspHost *host, int in, int out);

#endif
