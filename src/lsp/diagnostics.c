// What is published: for each file, what all open documents that read it have to say of it.
#include "lsp/server.h"

#include "base/mem.h"

static int severity_number(Severity severity)
{
    return severity == SEVERITY_ERROR ? 1 : severity == SEVERITY_WARNING ? 2 : 3;
}

// "message: label", and a line for each note.
static Str full_text(Memo *memo, const ReportItem *item)
{
    FILE *out = memo_begin(memo);
    if (!out) {
        return str_from(item->message);
    }
    fputs(item->message, out);
    if (item->label) {
        fprintf(out, "\n%s", item->label);
    }
    for (uint32_t i = 0; i < item->note_count; ++i) {
        fprintf(out, "\nnote: %s", item->notes[i] ? item->notes[i] : "");
    }
    return memo_text(memo);
}

static void add_links(cJSON *json, const ReportItem *item, Places *places)
{
    if (!places->server->client.related || item->link_count == 0) {
        return;
    }
    cJSON *list = cJSON_AddArrayToObject(json, "relatedInformation");
    for (uint32_t i = 0; i < item->link_count; ++i) {
        cJSON *location = places_location(places, &item->links[i].at);
        if (location) {
            cJSON *link = cJSON_CreateObject();
            cJSON_AddItemToObject(link, "location", location);
            json_add_text(link, "message", str_from(item->links[i].text));
            cJSON_AddItemToArray(list, link);
        }
    }
}

static cJSON *item_to_json(const ReportItem *item, const PlaceFile *file, Places *places)
{
    Server *server = places->server;
    cJSON *json = cJSON_CreateObject();
    cJSON_AddItemToObject(json, "range",
                          json_range(server, place_text(file), item->at.begin, item->at.end));
    cJSON_AddNumberToObject(json, "severity", severity_number(item->severity));
    cJSON_AddStringToObject(json, "code", diag_info(item->code)->name);
    cJSON_AddStringToObject(json, "source", "scnrender");
    Memo memo = {0};
    json_add_text(json, "message", full_text(&memo, item));
    memo_free(&memo);
    if (item->code == W0301) {
        const int unnecessary = 1;
        cJSON_AddItemToObject(json, "tags", cJSON_CreateIntArray(&unnecessary, 1));
    }
    add_links(json, item, places);
    return json;
}

// --- One file ------------------------------------------------------------------------------------

typedef struct Said {
    const ReportItem **items;
    size_t count;
} Said;

static bool was_said(const Said *said, const ReportItem *item)
{
    for (size_t i = 0; i < said->count; ++i) {
        const ReportItem *other = said->items[i];
        if (other->code == item->code && other->at.begin == item->at.begin &&
            other->at.end == item->at.end) {
            return true;
        }
    }
    return false;
}

// Without a place, it is told of the document itself.
static bool is_of_file(const ReportItem *item, const char *path, const char *real,
                       const Document *document)
{
    const char *at = item->at.path ? item->at.path : document->real;
    return !item->gone && (strcmp(at, path) == 0 || strcmp(at, real) == 0);
}

static void collect(Said *said, const Report *report, const char *path, const char *real,
                    const Document *document)
{
    for (size_t i = 0; i < report->items.count; ++i) {
        const ReportItem *item = &report->items.items[i];
        if (is_of_file(item, path, real, document) && !was_said(said, item)) {
            said->items[said->count++] = item;
        }
    }
}

static size_t count_items(const Server *server)
{
    size_t count = 0;
    for (size_t i = 0; i < server->documents.count; ++i) {
        const Document *document = server->documents.items[i];
        count += document->said.items.count + document->found.items.count;
    }
    return count;
}

// `version` is negative for files that aren't open.
static void publish_file(Places *places, const char *uri, const char *path, const char *real,
                         double version)
{
    Server *server = places->server;
    Said said = {arena_array(&server->scratch, count_items(server), sizeof *said.items), 0};
    for (size_t i = 0; said.items && i < server->documents.count; ++i) {
        const Document *document = server->documents.items[i];
        collect(&said, &document->said, path, real, document);
        collect(&said, &document->found, path, real, document);
    }
    cJSON *params = cJSON_CreateObject(), *list;
    cJSON_AddStringToObject(params, "uri", uri);
    if (version >= 0) {
        cJSON_AddNumberToObject(params, "version", version);
    }
    list = cJSON_AddArrayToObject(params, "diagnostics");
    for (size_t i = 0; i < said.count; ++i) {
        const PlaceFile *file = places_file(places, real);
        if (file) {
            cJSON_AddItemToArray(list, item_to_json(said.items[i], file, places));
        }
    }
    server_notify(server, "textDocument/publishDiagnostics", params);
}

// --- Files that aren't open ----------------------------------------------------------------------

typedef struct Others {
    const char **paths;
    size_t count;
} Others;

static void add_others(Server *server, Others *others, const Report *report)
{
    for (size_t i = 0; i < report->items.count; ++i) {
        const char *path = report->items.items[i].at.path;
        bool known = !path || report->items.items[i].gone || document_by_path(server, path);
        for (size_t k = 0; k < others->count && !known; ++k) {
            known = strcmp(others->paths[k], path) == 0;
        }
        if (!known) {
            others->paths[others->count++] = path;
        }
    }
}

static bool is_shown(const Server *server, const char *uri, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (server->shown.items[i] && strcmp(server->shown.items[i], uri) == 0) {
            return true;
        }
    }
    return false;
}

static void show(Server *server, const char *uri)
{
    size_t size = strlen(uri) + 1;
    char *copy = mem_alloc(size, 1);
    if (copy) {
        memcpy(copy, uri, size);
    }
    if (copy && !array_push(&server->shown, copy)) {
        mem_free(copy);
    }
}

static void clear(Server *server, const char *uri)
{
    cJSON *params = cJSON_CreateObject();
    cJSON_AddStringToObject(params, "uri", uri);
    cJSON_AddArrayToObject(params, "diagnostics");
    server_notify(server, "textDocument/publishDiagnostics", params);
}

static void publish_others(Places *places)
{
    Server *server = places->server;
    Others others = {arena_array(&server->scratch, count_items(server), sizeof *others.paths), 0};
    for (size_t i = 0; others.paths && i < server->documents.count; ++i) {
        add_others(server, &others, &server->documents.items[i]->said);
        add_others(server, &others, &server->documents.items[i]->found);
    }
    size_t before = server->shown.count;
    for (size_t i = 0; i < others.count; ++i) {
        const PlaceFile *file = places_file(places, others.paths[i]);
        if (file) {
            const char *uri = file->uri;
            publish_file(places, uri, others.paths[i], others.paths[i], -1);
            show(server, uri);
        }
    }
    // Those that were shown before and have nothing any more.
    for (size_t i = 0; i < before; ++i) {
        char *uri = server->shown.items[i];
        bool again = false;
        for (size_t k = before; k < server->shown.count && !again; ++k) {
            again = strcmp(server->shown.items[k], uri) == 0;
        }
        if (!again && !document_by_uri(server, uri)) {
            clear(server, uri);
        }
        mem_free(uri);
    }
    for (size_t i = before; i < server->shown.count; ++i) {
        server->shown.items[i - before] = server->shown.items[i];
    }
    server->shown.count -= before;
}

void diagnostics_publish(Server *server, Document *document)
{
    Places places = {.server = server};
    publish_file(&places, document->uri, document->path, document->real, document->version);
    document->is_told = true;
    publish_others(&places);
    places_end(&places);
}

void diagnostics_forget(Server *server, Document *document)
{
    if (!is_shown(server, document->uri, server->shown.count)) {
        clear(server, document->uri);
    }
}
