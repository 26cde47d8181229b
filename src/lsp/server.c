#include "lsp/server.h"

#include "base/mem.h"
#include "lsp/features.h"
#include "lsp/uri.h"

#include <errno.h>
#include <poll.h>
#include <time.h>
#include <unistd.h>

double server_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

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

// --- Life ----------------------------------------------------------------------------------------

static double positive(const cJSON *options, const char *path, double other)
{
    double value = json_get_number(options, path, other);
    return value >= 0 && value < 1e9 ? value : other;
}

static void take_settings(Settings *settings, const cJSON *options)
{
    const cJSON *item = json_at(options, "evaluate");
    settings->evaluate = item ? cJSON_IsTrue(item) : settings->evaluate;
    settings->pause = positive(options, "evaluateAfter", settings->pause * 1000) / 1000;
    settings->seconds = positive(options, "evaluateFor", settings->seconds * 1000) / 1000;
    item = json_at(options, "inlayHints.values");
    settings->hint_values = item ? cJSON_IsTrue(item) : settings->hint_values;
    item = json_at(options, "inlayHints.parameterNames");
    settings->hint_names = item ? cJSON_IsTrue(item) : settings->hint_names;
    item = json_at(options, "inlayHints.units");
    settings->hint_units = item ? cJSON_IsTrue(item) : settings->hint_units;
}

static void add_folder(Server *server, const char *uri)
{
    const char *path = uri ? uri_to_path(&server->arena, str_from(uri)) : NULL;
    if (path) {
        size_t length = strlen(path);
        while (length > 1 && path[length - 1] == '/') {
            --length;
        }
        path = arena_copy_string(&server->arena, path, length);
    }
    if (path) {
        array_push(&server->folders, path);
    }
}

static void remove_folder(Server *server, const char *uri)
{
    Arena scratch = {0};
    const char *path = uri ? uri_to_path(&scratch, str_from(uri)) : NULL;
    size_t kept = 0;
    for (size_t i = 0; i < server->folders.count; ++i) {
        if (!path || strcmp(server->folders.items[i], path) != 0) {
            server->folders.items[kept++] = server->folders.items[i];
        }
    }
    server->folders.count = kept;
    arena_free(&scratch);
}

static void take_folders(Server *server, const cJSON *params)
{
    const cJSON *folder, *folders = json_at(params, "workspaceFolders");
    cJSON_ArrayForEach(folder, folders)
    {
        add_folder(server, json_get_string(folder, "uri"));
    }
    if (server->folders.count == 0) {
        add_folder(server, json_get_string(params, "rootUri"));
    }
}

static void take_client(Server *server, const cJSON *client)
{
    static const char documentation[] =
        "textDocument.completion.completionItem.documentationFormat";
    ClientFeatures *features = &server->client;
    features->snippets =
        json_get_true(client, "textDocument.completion.completionItem.snippetSupport");
    features->markdown = json_lists(client, "textDocument.hover.contentFormat", "markdown") ||
                         json_lists(client, documentation, "markdown");
    features->symbol_trees =
        json_get_true(client, "textDocument.documentSymbol.hierarchicalDocumentSymbolSupport");
    features->edit_range =
        json_lists(client, "textDocument.completion.completionList.itemDefaults", "editRange");
    features->related = json_get_true(client, "textDocument.publishDiagnostics.relatedInformation");
    features->watches =
        json_get_true(client, "workspace.didChangeWatchedFiles.dynamicRegistration");
    // The client's order tells what it likes best; bytes are what the text is kept in.
    if (json_lists(client, "general.positionEncodings", "utf-8")) {
        server->encoding = POSITIONS_UTF8;
    }
}

static const char *encoding_name(PositionEncoding encoding)
{
    static const char *const names[] = {"utf-16", "utf-8", "utf-32"};
    return names[encoding];
}

static void add_list(cJSON *object, const char *name, const char *const *strings, int count)
{
    cJSON_AddItemToObject(object, name, cJSON_CreateStringArray(strings, count));
}

static void add_sync(cJSON *capabilities)
{
    cJSON *sync = cJSON_AddObjectToObject(capabilities, "textDocumentSync");
    cJSON_AddTrueToObject(sync, "openClose");
    cJSON_AddNumberToObject(sync, "change", 2); // incremental
    cJSON_AddTrueToObject(sync, "save");
    cJSON *workspace = cJSON_AddObjectToObject(capabilities, "workspace");
    cJSON *folders = cJSON_AddObjectToObject(workspace, "workspaceFolders");
    cJSON_AddTrueToObject(folders, "supported");
    cJSON_AddTrueToObject(folders, "changeNotifications");
}

static void add_features(cJSON *capabilities)
{
    static const char *const switches[] = {
        "hoverProvider",
        "definitionProvider",
        "referencesProvider",
        "documentHighlightProvider",
        "documentSymbolProvider",
        "colorProvider",
        "documentFormattingProvider",
        "documentRangeFormattingProvider",
        "inlayHintProvider",
        "foldingRangeProvider",
        "selectionRangeProvider",
        "workspaceSymbolProvider",
    };
    for (size_t i = 0; i < sizeof switches / sizeof *switches; ++i) {
        cJSON_AddTrueToObject(capabilities, switches[i]);
    }
    static const char *const triggers[] = {".", "\"", "/", ":"};
    cJSON *completion = cJSON_AddObjectToObject(capabilities, "completionProvider");
    add_list(completion, "triggerCharacters", triggers, 4);
    cJSON_AddTrueToObject(completion, "resolveProvider");
    static const char *const opening[] = {"(", ","};
    cJSON *signatures = cJSON_AddObjectToObject(capabilities, "signatureHelpProvider");
    add_list(signatures, "triggerCharacters", opening, 2);
    cJSON *rename = cJSON_AddObjectToObject(capabilities, "renameProvider");
    cJSON_AddTrueToObject(rename, "prepareProvider");
    static const char *const actions[] = {"quickfix", "source.fixAll.scnrender"};
    add_list(cJSON_AddObjectToObject(capabilities, "codeActionProvider"), "codeActionKinds",
             actions, 2);
    cJSON_AddObjectToObject(capabilities, "documentLinkProvider");
    cJSON *tokens = cJSON_AddObjectToObject(capabilities, "semanticTokensProvider");
    cJSON_AddItemToObject(tokens, "legend", semantic_token_legend());
    cJSON_AddTrueToObject(tokens, "range");
    cJSON_AddTrueToObject(cJSON_AddObjectToObject(tokens, "full"), "delta");
}

static cJSON *initialize(Server *server, const cJSON *params)
{
    if (server->phase != PHASE_NEW) {
        return server_fail(server, RPC_INVALID_REQUEST, "the server was initialized before");
    }
    server->phase = PHASE_RUNNING;
    take_client(server, json_at(params, "capabilities"));
    take_folders(server, params);
    take_settings(&server->settings, json_at(params, "initializationOptions"));
    cJSON *result = cJSON_CreateObject();
    cJSON *capabilities = cJSON_AddObjectToObject(result, "capabilities");
    cJSON_AddStringToObject(capabilities, "positionEncoding", encoding_name(server->encoding));
    add_sync(capabilities);
    add_features(capabilities);
    cJSON *info = cJSON_AddObjectToObject(result, "serverInfo");
    cJSON_AddStringToObject(info, "name", "scnrender");
    cJSON_AddStringToObject(info, "version", server->host->version);
    return result;
}

// Asks to be told of files that change on the disk: imports, textures, meshes.
static void initialized(Server *server, const cJSON *params)
{
    (void)params;
    if (!server->client.watches) {
        return;
    }
    cJSON *watchers = cJSON_CreateArray(), *watcher = cJSON_CreateObject();
    cJSON_AddStringToObject(watcher, "globPattern", "**/*");
    cJSON_AddItemToArray(watchers, watcher);
    cJSON *options = cJSON_CreateObject(), *registration = cJSON_CreateObject();
    cJSON_AddItemToObject(options, "watchers", watchers);
    cJSON_AddStringToObject(registration, "id", "files");
    cJSON_AddStringToObject(registration, "method", "workspace/didChangeWatchedFiles");
    cJSON_AddItemToObject(registration, "registerOptions", options);
    cJSON *registrations = cJSON_CreateArray(), *request = cJSON_CreateObject();
    cJSON_AddItemToArray(registrations, registration);
    cJSON_AddItemToObject(request, "registrations", registrations);
    server_request(server, "client/registerCapability", request);
}

static cJSON *shut_down(Server *server, const cJSON *params)
{
    (void)params;
    server->phase = PHASE_SHUT_DOWN;
    evaluation_cancel(server);
    return NULL;
}

static void leave(Server *server, const cJSON *params)
{
    (void)params;
    server->end = server->phase == PHASE_SHUT_DOWN ? LSP_ENDED : LSP_ABANDONED;
    server->phase = PHASE_ENDED;
}

// --- Documents -----------------------------------------------------------------------------------

static void did_open(Server *server, const cJSON *params)
{
    const char *uri = json_get_string(params, "textDocument.uri");
    const char *text = json_get_string(params, "textDocument.text");
    if (uri && text) {
        document_open(server, uri, json_get_number(params, "textDocument.version", 0),
                      str_from(text));
    }
}

static void did_change(Server *server, const cJSON *params)
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

static void did_save(Server *server, const cJSON *params)
{
    Document *document = document_by_uri(server, json_get_string(params, "textDocument.uri"));
    if (document && document->evaluate_at > 0) {
        document->evaluate_at = server_now();
    }
}

static void did_close(Server *server, const cJSON *params)
{
    Document *document = document_by_uri(server, json_get_string(params, "textDocument.uri"));
    if (document) {
        document_close(server, document);
    }
}

static void files_changed(Server *server, const cJSON *params)
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

static void folders_changed(Server *server, const cJSON *params)
{
    const cJSON *folder;
    cJSON_ArrayForEach(folder, json_at(params, "event.removed"))
    {
        remove_folder(server, json_get_string(folder, "uri"));
    }
    cJSON_ArrayForEach(folder, json_at(params, "event.added"))
    {
        add_folder(server, json_get_string(folder, "uri"));
    }
}

static void configured(Server *server, const cJSON *params)
{
    const cJSON *own = json_at(params, "settings.scnrender");
    take_settings(&server->settings, own ? own : json_at(params, "settings"));
}

// --- Methods -------------------------------------------------------------------------------------

static const struct {
    const char *method;
    void (*handle)(Server *server, const cJSON *params);
} notifications[] = {
    {"initialized", initialized},
    {"exit", leave},
    {"textDocument/didOpen", did_open},
    {"textDocument/didChange", did_change},
    {"textDocument/didSave", did_save},
    {"textDocument/didClose", did_close},
    {"workspace/didChangeWatchedFiles", files_changed},
    {"workspace/didChangeWorkspaceFolders", folders_changed},
    {"workspace/didChangeConfiguration", configured},
};

static const struct {
    const char *method;
    cJSON *(*handle)(Server *server, const cJSON *params);
} requests[] = {
    {"initialize", initialize},
    {"shutdown", shut_down},
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
    double now = server_now(), next = -1;
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
