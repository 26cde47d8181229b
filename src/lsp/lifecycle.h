// The protocol's own messages: of the session (lifecycle.c) and of documents (sync.c).
#ifndef LSP_LIFECYCLE_H
#define LSP_LIFECYCLE_H

#include "lsp/server.h"

cJSON *life_initialize(Server *server, const cJSON *params);
void life_initialized(Server *server, const cJSON *params);
cJSON *life_shut_down(Server *server, const cJSON *params);
void life_leave(Server *server, const cJSON *params);
void life_folders_changed(Server *server, const cJSON *params);
void life_configured(Server *server, const cJSON *params);

void sync_open(Server *server, const cJSON *params);
void sync_change(Server *server, const cJSON *params);
void sync_save(Server *server, const cJSON *params);
void sync_close(Server *server, const cJSON *params);
void sync_files_changed(Server *server, const cJSON *params);

#endif
