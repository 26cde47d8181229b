// The files that a scene may name.
#ifndef LSP_SCENE_FILES_H
#define LSP_SCENE_FILES_H

#include "lsp/server.h"

// Lists the folders and files in `folder` (relative to the file at `from`; "" or ending in "/")
// that lie where the scene may read and can be written in a string: scenes, or everything else. At
// most some thousand.
typedef void FileVisit(void *context, const char *name, bool is_folder);
void scene_files(Server *server, const Analysis *analysis, const char *from, Str folder,
                 bool scenes, FileVisit *visit, void *context);

#endif
