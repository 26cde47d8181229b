// The language server: a text is opened, asked everything at a few places, changed there, and asked
// again. All memory is given back at the end.
#include "fuzz.h"

#include "base/hash.h"
#include "base/mem.h"
#include "lsp/json.h"
#include "lsp/lsp.h"
#include "render/render.h"

#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static const char *const methods[] = {
    "completion",           "hover",
    "signatureHelp",        "definition",
    "references",           "documentHighlight",
    "prepareRename",        "rename",
    "documentSymbol",       "documentColor",
    "colorPresentation",    "formatting",
    "rangeFormatting",      "codeAction",
    "semanticTokens/full",  "semanticTokens/full/delta",
    "semanticTokens/range", "inlayHint",
    "foldingRange",         "selectionRange",
    "documentLink",
};

static void send_message(int to, cJSON *message)
{
    cJSON_AddStringToObject(message, "jsonrpc", "2.0");
    char *text = cJSON_PrintUnformatted(message);
    dprintf(to, "Content-Length: %zu\r\n\r\n%s", strlen(text), text);
    cJSON_free(text);
    cJSON_Delete(message);
}

static cJSON *begin_message(const char *method, cJSON **params)
{
    cJSON *message = cJSON_CreateObject();
    cJSON_AddStringToObject(message, "method", method);
    *params = cJSON_AddObjectToObject(message, "params");
    return message;
}

static void add_document(cJSON *params, int version)
{
    cJSON *document = cJSON_AddObjectToObject(params, "textDocument");
    cJSON_AddStringToObject(document, "uri", "file:///fuzz/scene.scn");
    cJSON_AddNumberToObject(document, "version", version);
}

static cJSON *position(uint32_t line, uint32_t character)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "line", line);
    cJSON_AddNumberToObject(json, "character", character);
    return json;
}

static void add_range(cJSON *params, uint32_t line, uint32_t character, uint32_t lines)
{
    cJSON *range = cJSON_AddObjectToObject(params, "range");
    cJSON_AddItemToObject(range, "start", position(line, character));
    cJSON_AddItemToObject(range, "end", position(line + lines, character + 3));
}

static void ask_all(int to, uint32_t line, uint32_t character, int *id)
{
    for (size_t i = 0; i < sizeof methods / sizeof *methods; ++i) {
        char method[64];
        cJSON *params;
        snprintf(method, sizeof method, "textDocument/%s", methods[i]);
        cJSON *message = begin_message(method, &params);
        cJSON_AddNumberToObject(message, "id", ++*id);
        add_document(params, 1);
        cJSON_AddItemToObject(params, "position", position(line, character));
        cJSON_AddItemToArray(cJSON_AddArrayToObject(params, "positions"),
                             position(line, character));
        add_range(params, line, character, (uint32_t)(i % 3));
        cJSON_AddStringToObject(params, "newName", "other");
        cJSON_AddStringToObject(params, "previousResultId", "1");
        send_message(to, message);
    }
}

static void change(int to, uint32_t line, uint32_t character, const char *text)
{
    cJSON *params, *message = begin_message("textDocument/didChange", &params);
    add_document(params, 2);
    cJSON *one = cJSON_CreateObject();
    add_range(one, line, character, 0);
    cJSON_AddStringToObject(one, "text", text);
    cJSON_AddItemToArray(cJSON_AddArrayToObject(params, "contentChanges"), one);
    send_message(to, message);
}

static void write_session(int to, const char *text, size_t size)
{
    cJSON *params, *message = begin_message("initialize", &params);
    cJSON_AddNumberToObject(message, "id", 0);
    send_message(to, message);
    message = begin_message("textDocument/didOpen", &params);
    add_document(params, 1);
    json_add_text(cJSON_GetObjectItem(params, "textDocument"), "text", (Str){text, size});
    send_message(to, message);
    uint32_t lines = 1;
    for (size_t i = 0; i < size; ++i) {
        lines += text[i] == '\n';
    }
    static const char *const typed[] = {"", "\n", "}", "sphere { r", "(", "\"", "/*", ". "};
    uint32_t seed = (uint32_t)size;
    int id = 0;
    for (int round = 0; round < 3; ++round) {
        seed = hash_combine(seed, size ? (uint8_t)text[seed % size] : 0);
        uint32_t line = seed % lines, character = (seed >> 16) % 40;
        ask_all(to, line, character, &id);
        change(to, line, character, typed[seed >> 8 & 7]);
    }
    ask_all(to, 0, 0, &id);
    message = begin_message("shutdown", &params);
    cJSON_AddNumberToObject(message, "id", ++id);
    send_message(to, message);
    send_message(to, begin_message("exit", &params));
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    const uint64_t live = mem_live_count();
    int in = memfd_create("lsp", MFD_CLOEXEC), out = open("/dev/null", O_WRONLY | O_CLOEXEC);
    fuzz_require(in >= 0 && out >= 0, "files can be opened");
    write_session(in, (const char *)bytes, size);
    lseek(in, 0, SEEK_SET);
    LspHost host = {.schema = render_schema(), .limits = limits_default(), .version = "0"};
    fuzz_require(lsp_serve(&host, in, out) == LSP_ENDED, "the server goes on to the end");
    close(in);
    close(out);
    fuzz_require(mem_live_count() == live, "all memory is given back");
    return 0;
}
