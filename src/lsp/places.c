#include "lsp/server.h"

#include "lsp/uri.h"

// --- In a document -------------------------------------------------------------------------------

static uint32_t whole(const cJSON *number)
{
    double value = cJSON_IsNumber(number) ? number->valuedouble : 0;
    return value >= UINT32_MAX ? UINT32_MAX : value > 0 ? (uint32_t)value : 0;
}

uint32_t server_offset(const Server *server, const Document *document, const cJSON *position)
{
    Position at = {whole(json_at(position, "line")), whole(json_at(position, "character"))};
    return buffer_offset(&document->text, at, server->encoding);
}

void server_range(const Server *server, const Document *document, const cJSON *range,
                  uint32_t *begin, uint32_t *end)
{
    *begin = server_offset(server, document, json_at(range, "start"));
    *end = server_offset(server, document, json_at(range, "end"));
    if (*end < *begin) {
        uint32_t other = *begin;
        *begin = *end;
        *end = other;
    }
}

// Positions are printed here: they are most of what is sent, and as objects of cJSON they would
// cost ten times as much.
enum { POSITION_SIZE = 64 };

static char *put_number(char *out, uint32_t number)
{
    char digits[10];
    int length = 0;
    do {
        digits[length++] = (char)('0' + number % 10);
    } while ((number /= 10) > 0);
    while (length > 0) {
        *out++ = digits[--length];
    }
    return out;
}

static char *put_text(char *out, const char *text)
{
    size_t length = strlen(text);
    memcpy(out, text, length + 1);
    return out + length;
}

static char *put_position(char *out, const Server *server, const Buffer *text, uint32_t offset)
{
    Position at = buffer_position(text, offset, server->encoding);
    out = put_number(put_text(out, "{\"line\":"), at.line);
    return put_text(put_number(put_text(out, ",\"character\":"), at.column), "}");
}

cJSON *json_position(const Server *server, const Buffer *text, uint32_t offset)
{
    char json[POSITION_SIZE];
    put_position(json, server, text, offset);
    return cJSON_CreateRaw(json);
}

cJSON *json_range(const Server *server, const Buffer *text, uint32_t begin, uint32_t end)
{
    char json[2 * POSITION_SIZE + 32], *out = put_text(json, "{\"start\":");
    out = put_text(put_position(out, server, text, begin), ",\"end\":");
    put_text(put_position(out, server, text, end), "}");
    return cJSON_CreateRaw(json);
}

cJSON *json_edit(const Server *server, const Buffer *text, uint32_t begin, uint32_t end, Str with)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddItemToObject(json, "range", json_range(server, text, begin, end));
    json_add_text(json, "newText", with);
    return json;
}

// --- In any file ---------------------------------------------------------------------------------

void places_end(Places *places)
{
    for (size_t i = 0; i < places->files.count; ++i) {
        buffer_free(&places->files.items[i].own);
    }
    array_free(&places->files);
}

static bool read_file(PlaceFile *file, const char *path)
{
    FileBytes bytes;
    if (file_read(path, UINT32_MAX / 4, &bytes) != IO_OK) {
        return false;
    }
    bool good = buffer_set(&file->own, (Str){bytes.bytes, bytes.size});
    file_bytes_free(&bytes);
    return good;
}

const PlaceFile *places_file(Places *places, const char *path)
{
    for (size_t i = 0; path && i < places->files.count; ++i) {
        if (strcmp(places->files.items[i].path, path) == 0) {
            return places->files.items[i].uri ? &places->files.items[i] : NULL;
        }
    }
    if (!path || !array_reserve(&places->files, 1)) {
        return NULL;
    }
    Arena *arena = &places->server->scratch;
    PlaceFile file = {.path = arena_copy_string(arena, path, strlen(path))};
    const Document *document = document_by_path(places->server, path);
    if (document) {
        file.uri = document->uri;
        file.text = &document->text;
    } else if (read_file(&file, path)) {
        file.uri = uri_from_path(arena, path);
    }
    if (!file.path) {
        buffer_free(&file.own);
        return NULL;
    }
    array_push(&places->files, file);
    return file.uri ? &places->files.items[places->files.count - 1] : NULL;
}

const Buffer *place_text(const PlaceFile *file)
{
    return file->text ? file->text : &file->own;
}

// The beginning of a file that isn't open, whatever it holds.
static cJSON *file_location(Places *places, const char *path)
{
    const char *uri = uri_from_path(&places->server->scratch, path);
    if (!uri) {
        return NULL;
    }
    Buffer empty = {0};
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "uri", uri);
    cJSON_AddItemToObject(json, "range", json_range(places->server, &empty, 0, 0));
    return json;
}

cJSON *places_location(Places *places, const FilePlace *at)
{
    if (at->path && at->end == 0 && !document_by_path(places->server, at->path)) {
        return file_location(places, at->path);
    }
    const PlaceFile *file = places_file(places, at->path);
    if (!file) {
        return NULL;
    }
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "uri", file->uri);
    cJSON_AddItemToObject(json, "range",
                          json_range(places->server, place_text(file), at->begin, at->end));
    return json;
}
