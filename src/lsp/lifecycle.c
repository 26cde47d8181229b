// From the client's hello to its farewell: what both can do, the folders, the settings.
#include "lsp/lifecycle.h"
#include "lsp/features.h"
#include "lsp/uri.h"

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

cJSON *life_initialize(Server *server, const cJSON *params)
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
void life_initialized(Server *server, const cJSON *params)
{
    (void)params;
    if (!server->client.watches) {
        return;
    }
    cJSON *watchers = cJSON_CreateArray(), *watcher = cJSON_CreateObject();
    cJSON_AddStringToObject(
        watcher, "globPattern",
        "**/*.{scn,png,jpg,jpeg,exr,hdr,tif,tiff,webp,ply,obj,stl,gltf,glb,ies}");
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

cJSON *life_shut_down(Server *server, const cJSON *params)
{
    (void)params;
    server->phase = PHASE_SHUT_DOWN;
    evaluation_cancel(server);
    return NULL;
}

void life_leave(Server *server, const cJSON *params)
{
    (void)params;
    server->end = server->phase == PHASE_SHUT_DOWN ? LSP_ENDED : LSP_ABANDONED;
    server->phase = PHASE_ENDED;
}

void life_folders_changed(Server *server, const cJSON *params)
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

void life_configured(Server *server, const cJSON *params)
{
    const cJSON *own = json_at(params, "settings.scnrender");
    take_settings(&server->settings, own ? own : json_at(params, "settings"));
}
