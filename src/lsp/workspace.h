// The scenes of the workspace's folders that aren't open.
#ifndef LSP_WORKSPACE_H
#define LSP_WORKSPACE_H

#include "lsp/server.h"

// Surveys each scene that may import the file at `path` (those whose text has its name), one after
// the other. A few thousand files are looked at, no more.
typedef void WorkspaceVisit(void *context, const Analysis *analysis);
void workspace_surveys(Server *server, const char *path, WorkspaceVisit *visit, void *context);

#endif
