#include "lsp/server.h"

#include "base/clock.h"
#include "base/mem.h"
#include "lsp/features.h"
#include "lsp/lifecycle.h"

#include <errno.h>
#include <poll.h>
#include <unistd.h>

// --- Sending -------------------------------------------------------------------------------------

static void write_all(Server *server, const char *bytes, size_t length)
{
    while (length > 0 && !server->is_broken) {
        ssize_t size = write(server->out, bytes, length);
        if (size < 0 && errno == EAGAIN) { // somebody made it non-blocking
            struct pollfd ready = {.fd = server->out, .events = POLLOUT};
            poll(&ready, 1, -1);
        } else if (size < 0 && errno != EINTR) {
            server->is_broken = true;
        }
        bytes += size > 0 ? size : 0;
        length -= size > 0 ? (size_t)size : 0;
    }
}

// Takes the message.
static void send_message(Server *server, cJSON *message)
{
    cJSON_AddStringToObject(message, "jsonrpc", "2.0");
    char *text = message ? cJSON_PrintUnformatted(message) : NULL;
    cJSON_Delete(message);
    if (text) {
        char header[64];
        size_t length = strlen(text);
        int size = snprintf(header, sizeof header, "Content-Length: %zu\r\n\r\n", length);
        write_all(server, header, (size_t)size);
        write_all(server, text, length);
        cJSON_free(text);
    }
}

void server_notify(Server *server, const char *method, cJSON *params)
{
    cJSON *message = cJSON_CreateObject();
    cJSON_AddStringToObject(message, "method", method);
    cJSON_AddItemToObject(message, "params", params);
    send_message(server, message);
}

void server_request(Server *server, const char *method, cJSON *params)
{
    cJSON *message = cJSON_CreateObject();
    char id[32];
    snprintf(id, sizeof id, "scnrender-%u", ++server->next_request);
    cJSON_AddStringToObject(message, "id", id);
    cJSON_AddStringToObject(message, "method", method);
    cJSON_AddItemToObject(message, "params", params);
    send_message(server, message);
}

void server_log(Server *server, const char *text)
{
    cJSON *params = cJSON_CreateObject();
    cJSON_AddNumberToObject(params, "type", 4);
    cJSON_AddStringToObject(params, "message", text);
    server_notify(server, "window/logMessage", params);
}

cJSON *server_fail(Server *server, RpcError error, const char *text)
{
    server->error = error;
    server->error_text = text;
    return NULL;
}

static cJSON *copy_id(const cJSON *id)
{
    return id ? cJSON_Duplicate(id, false) : cJSON_CreateNull();
}

static void respond_error(Server *server, const cJSON *id, RpcError error, const char *text)
{
    cJSON *message = cJSON_CreateObject(), *body = cJSON_CreateObject();
    cJSON_AddItemToObject(message, "id", copy_id(id));
    cJSON_AddNumberToObject(body, "code", error);
    json_add_text(body, "message", str_from(text));
    cJSON_AddItemToObject(message, "error", body);
    send_message(server, message);
}

static void respond(Server *server, const cJSON *id, cJSON *result)
{
    if (server->error) {
        cJSON_Delete(result);
        respond_error(server, id, server->error, server->error_text);
        return;
    }
    cJSON *message = cJSON_CreateObject();
    cJSON_AddItemToObject(message, "id", copy_id(id));
    cJSON_AddItemToObject(message, "result", result ? result : cJSON_CreateNull());
    send_message(server, message);
}

// --- Methods -------------------------------------------------------------------------------------

static const struct {
    const char *method;
    void (*handle)(Server *server, const cJSON *params);
} notifications[] = {
    {"initialized", life_initialized},
    {"exit", life_leave},
    {"textDocument/didOpen", sync_open},
    {"textDocument/didChange", sync_change},
    {"textDocument/didSave", sync_save},
    {"textDocument/didClose", sync_close},
    {"workspace/didChangeWatchedFiles", sync_files_changed},
    {"workspace/didChangeWorkspaceFolders", life_folders_changed},
    {"workspace/didChangeConfiguration", life_configured},
};

static const struct {
    const char *method;
    cJSON *(*handle)(Server *server, const cJSON *params);
} requests[] = {
    {"initialize", life_initialize},
    {"shutdown", life_shut_down},
    {"completionItem/resolve", feature_resolve_completion},
    {"workspace/symbol", feature_workspace_symbols},
};

static const struct {
    const char *method;
    Feature *handle;
} features[] = {
    {"textDocument/completion", feature_completion},
    {"textDocument/hover", feature_hover},
    {"textDocument/signatureHelp", feature_signature_help},
    {"textDocument/definition", feature_definition},
    {"textDocument/references", feature_references},
    {"textDocument/documentHighlight", feature_highlight},
    {"textDocument/prepareRename", feature_prepare_rename},
    {"textDocument/rename", feature_rename},
    {"textDocument/documentSymbol", feature_document_symbols},
    {"textDocument/documentColor", feature_colors},
    {"textDocument/colorPresentation", feature_color_presentations},
    {"textDocument/formatting", feature_formatting},
    {"textDocument/rangeFormatting", feature_range_formatting},
    {"textDocument/codeAction", feature_code_actions},
    {"textDocument/semanticTokens/full", feature_semantic_tokens},
    {"textDocument/semanticTokens/full/delta", feature_semantic_tokens_delta},
    {"textDocument/semanticTokens/range", feature_semantic_tokens_range},
    {"textDocument/inlayHint", feature_inlay_hints},
    {"textDocument/foldingRange", feature_folding_ranges},
    {"textDocument/selectionRange", feature_selection_ranges},
    {"textDocument/documentLink", feature_links},
};

#define COUNT(list) (sizeof(list) / sizeof *(list))

static void handle_notification(Server *server, const char *method, const cJSON *params)
{
    bool any_time = strcmp(method, "exit") == 0;
    for (size_t i = 0; i < COUNT(notifications); ++i) {
        if (strcmp(notifications[i].method, method) == 0 &&
            (any_time || server->phase == PHASE_RUNNING)) {
            notifications[i].handle(server, params);
            return;
        }
    }
}

static cJSON *call_feature(Server *server, Feature *feature, const cJSON *params)
{
    Document *document = document_by_uri(server, json_get_string(params, "textDocument.uri"));
    if (!document) {
        return server_fail(server, RPC_INVALID_PARAMS, "the document isn't open");
    }
    return feature(server, document, params);
}

static cJSON *handle_request(Server *server, const char *method, const cJSON *params)
{
    bool first = strcmp(method, "initialize") == 0;
    if (server->phase == PHASE_NEW && !first) {
        return server_fail(server, RPC_NOT_INITIALIZED, "the server was not initialized");
    }
    if (server->phase == PHASE_SHUT_DOWN) {
        return server_fail(server, RPC_INVALID_REQUEST, "the server was shut down");
    }
    for (size_t i = 0; i < COUNT(requests); ++i) {
        if (strcmp(requests[i].method, method) == 0) {
            return requests[i].handle(server, params);
        }
    }
    for (size_t i = 0; i < COUNT(features); ++i) {
        if (strcmp(features[i].method, method) == 0) {
            return call_feature(server, features[i].handle, params);
        }
    }
    return server_fail(server, RPC_METHOD_NOT_FOUND, "there is no such method");
}

static void handle(Server *server, const cJSON *message)
{
    const char *method = json_get_string(message, "method");
    const cJSON *id = json_at(message, "id"), *params = json_at(message, "params");
    server->error = 0;
    if (!method) {
        bool answer = json_at(message, "result") || json_at(message, "error");
        if (!cJSON_IsObject(message) || !answer) {
            respond_error(server, id, RPC_INVALID_REQUEST, "a message needs a method");
        }
    } else if (id) {
        cJSON *result = handle_request(server, method, params);
        respond(server, id, result);
    } else {
        handle_notification(server, method, params);
    }
    arena_free(&server->scratch);
}

// --- The queue -----------------------------------------------------------------------------------

static bool same_id(const cJSON *a, const cJSON *b)
{
    return a && b && cJSON_Compare(a, b, true);
}

// A request that still waits is answered at once.
static void cancel(Server *server, const cJSON *id)
{
    for (size_t i = 0; i < server->queue.count; ++i) {
        cJSON *message = server->queue.items[i];
        if (json_at(message, "method") && same_id(json_at(message, "id"), id)) {
            respond_error(server, id, RPC_CANCELLED, "cancelled");
            cJSON_Delete(message);
            memmove(&server->queue.items[i], &server->queue.items[i + 1],
                    (--server->queue.count - i) * sizeof(cJSON *));
            return;
        }
    }
}

static void enqueue(Server *server, cJSON *message)
{
    const char *method = json_get_string(message, "method");
    if (method && strcmp(method, "$/cancelRequest") == 0) {
        cancel(server, json_at(message, "params.id"));
        cJSON_Delete(message);
    } else if (!array_push(&server->queue, message)) {
        cJSON_Delete(message);
    }
}

static void enqueue_body(Server *server, Str body)
{
    const char *stop = NULL;
    cJSON *message = cJSON_ParseWithLengthOpts(body.at, body.length, &stop, false);
    if (!message) {
        respond_error(server, NULL, RPC_PARSE_ERROR, "the message is no JSON");
    } else if (cJSON_IsArray(message)) { // a batch, which JSON-RPC knows and the protocol doesn't
        cJSON *part;
        while ((part = cJSON_DetachItemFromArray(message, 0))) {
            enqueue(server, part);
        }
        cJSON_Delete(message);
    } else {
        enqueue(server, message);
    }
}

static void enqueue_frames(Server *server)
{
    Str body;
    for (FrameResult result; (result = frames_next(&server->frames, &body)) != FRAME_MORE;) {
        if (result == FRAME_BODY) {
            enqueue_body(server, body);
        } else {
            respond_error(server, NULL, RPC_PARSE_ERROR, "what was sent is no message");
        }
    }
}

// --- The loop ------------------------------------------------------------------------------------

static bool may_evaluate(const Server *server, const Document *document)
{
    return server->host->evaluates && server->settings.evaluate && document->evaluate_at > 0 &&
           server->phase == PHASE_RUNNING;
}

double server_idle(Server *server)
{
    for (size_t i = 0; i < server->documents.count; ++i) {
        if (!server->documents.items[i]->is_told && server->phase == PHASE_RUNNING) {
            document_analysis(server, server->documents.items[i]);
            diagnostics_publish(server, server->documents.items[i]);
            arena_free(&server->scratch);
        }
    }
    double now = clock_seconds(), next = -1;
    evaluation_watch(server, now);
    if (server->evaluation.document) {
        return 0.1;
    }
    Document *due = NULL;
    for (size_t i = 0; i < server->documents.count; ++i) {
        Document *document = server->documents.items[i];
        if (may_evaluate(server, document) && (!due || document->evaluate_at < due->evaluate_at)) {
            due = document;
        }
    }
    if (due && due->evaluate_at <= now) {
        due->evaluate_at = 0;
        evaluation_start(server, due);
        return 0.1;
    }
    return due ? due->evaluate_at - now : next;
}

// Reads what has come, waiting for it at most `seconds` (negative: for ever). False at the end.
static bool receive(Server *server, double seconds)
{
    enum { ROOM = 64 << 10 };
    struct pollfd from[] = {
        {.fd = server->in, .events = POLLIN},
        {.fd = server->evaluation.document ? server->evaluation.from : -1, .events = POLLIN},
    };
    int wait = seconds < 0 ? -1 : seconds > 3600 ? 3600000 : (int)(seconds * 1000 + 0.999);
    if (poll(from, 2, wait) < 0) {
        return errno == EINTR;
    }
    if (from[1].revents) {
        evaluation_read(server);
    }
    if (!from[0].revents) {
        return true;
    }
    char *room = frames_room(&server->frames, ROOM);
    if (!room) {
        server->end = LSP_NO_MEMORY;
        return false;
    }
    ssize_t size = read(server->in, room, ROOM);
    if (size <= 0) {
        return size < 0 && (errno == EINTR || errno == EAGAIN);
    }
    frames_added(&server->frames, (size_t)size);
    enqueue_frames(server);
    return true;
}

static void handle_first(Server *server)
{
    cJSON *message = server->queue.items[0];
    memmove(&server->queue.items[0], &server->queue.items[1],
            --server->queue.count * sizeof(cJSON *));
    handle(server, message);
    cJSON_Delete(message);
}

static void serve(Server *server)
{
    while (server->phase != PHASE_ENDED && !server->is_broken) {
        // Between messages a look at what else has come: a request may be cancelled by it.
        double wait = server->queue.count ? 0 : server_idle(server);
        bool goes_on = receive(server, wait);
        if (server->queue.count) {
            handle_first(server);
        } else if (!goes_on) {
            return;
        }
    }
}

LspEnd lsp_serve(const LspHost *host, int in, int out)
{
    Server *server = mem_alloc_zeroed(1, sizeof *server);
    if (!server) {
        return LSP_NO_MEMORY;
    }
    server->host = host;
    server->in = in;
    server->out = out;
    server->end = LSP_ABANDONED;
    server->settings = (Settings){.evaluate = true,
                                  .pause = 0.25,
                                  .seconds = 3,
                                  .hint_values = true,
                                  .hint_names = true,
                                  .hint_units = true};
    serve(server);
    LspEnd end = server->end;
    evaluation_free(server);
    documents_free(server);
    for (size_t i = 0; i < server->queue.count; ++i) {
        cJSON_Delete(server->queue.items[i]);
    }
    array_free(&server->queue);
    for (size_t i = 0; i < server->shown.count; ++i) {
        mem_free(server->shown.items[i]);
    }
    array_free(&server->shown);
    array_free(&server->folders);
    frames_free(&server->frames);
    arena_free(&server->arena);
    arena_free(&server->scratch);
    mem_free(server);
    return end;
}
