// Where a declaration is used.
#ifndef LSP_REFERENCES_H
#define LSP_REFERENCES_H

#include "lsp/tree.h"

typedef struct Reference {
    FilePlace at;
    bool declares;
} Reference;
typedef ARRAY(Reference) References;

// The declaration that `target` names, known by its file and place.
FilePlace reference_target(const Analysis *analysis, const Target *target);
// Adds all uses of the declaration (and itself) in the files of one survey.
void references_in(const Analysis *analysis, const FilePlace *declaration, References *out);
// In all open documents and the scenes of the workspace, each place once, in order. Paths are the
// server's scratch arena's.
void references_everywhere(Server *server, Document *document, const FilePlace *declaration,
                           bool local, References *out);
// Whether only its own file can use it.
bool reference_is_local(const Analysis *analysis, const Target *target);

#endif
