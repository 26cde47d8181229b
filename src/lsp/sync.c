// What the client tells of its documents, and of files.
#include "base/clock.h"
#include "lsp/lifecycle.h"
#include "lsp/uri.h"

void sync_open(Server *server, const cJSON *params)
{
    const char *uri = json_get_string(params, "textDocument.uri");
    const char *text = json_get_string(params, "textDocument.text");
    if (uri && text) {
        document_open(server, uri, json_get_number(params, "textDocument.version", 0),
                      str_from(text));
    }
}

void sync_change(Server *server, const cJSON *params)
{
    Document *document = document_by_uri(server, json_get_string(params, "textDocument.uri"));
    if (!document) {
        return;
    }
    document->version = json_get_number(params, "textDocument.version", document->version + 1);
    const cJSON *change;
    cJSON_ArrayForEach(change, json_at(params, "contentChanges"))
    {
        const char *text = json_get_string(change, "text");
        const cJSON *range = json_at(change, "range");
        uint32_t begin = 0, end = (uint32_t)document->text.bytes.count;
        if (cJSON_IsObject(range)) {
            server_range(server, document, range, &begin, &end);
        }
        if (text) {
            document_edit(server, document, begin, end, str_from(text));
        }
    }
}

void sync_save(Server *server, const cJSON *params)
{
    Document *document = document_by_uri(server, json_get_string(params, "textDocument.uri"));
    if (document && document->evaluate_at > 0) {
        document->evaluate_at = clock_seconds();
    }
}

void sync_close(Server *server, const cJSON *params)
{
    Document *document = document_by_uri(server, json_get_string(params, "textDocument.uri"));
    if (document) {
        document_close(server, document);
    }
}

void sync_files_changed(Server *server, const cJSON *params)
{
    const cJSON *change;
    cJSON_ArrayForEach(change, json_at(params, "changes"))
    {
        const char *uri = json_get_string(change, "uri");
        const char *path = uri ? uri_to_path(&server->scratch, str_from(uri)) : NULL;
        if (path) {
            document_file_changed(server, path);
        }
    }
}
