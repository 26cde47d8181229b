// What the server's files share.
//
//   server.c       messages, the loop, the table of methods
//   lifecycle.c    what client and server can do; sync.c: what the client tells of documents
//   documents.c    open documents and what is known of them
//   evaluation.c   the process that evaluates a document
//   diagnostics.c  what is published
//   tree.c         walks over syntax trees; what stands at a place
//   and a file for each feature, see features.h
#ifndef LSP_SERVER_H
#define LSP_SERVER_H

#include "base/io.h"
#include "lang/survey.h"
#include "lsp/buffer.h"
#include "lsp/frames.h"
#include "lsp/json.h"
#include "lsp/lsp.h"
#include "lsp/report.h"

#include <stdatomic.h>
#include <sys/types.h>

typedef struct Server Server;
typedef struct Document Document;

// --- Documents -----------------------------------------------------------------------------------

// A survey of a document's text as it is, with what it needs to live.
typedef struct Analysis {
    Lang lang;
    Sandbox sandbox;
    Survey *survey;
} Analysis;

// A token of the text, or a comment.
typedef struct DocumentToken {
    uint8_t kind; // TokenKind, or TOKEN_KIND_COUNT for a comment
    bool on_new_line;
    uint32_t begin, end;
} DocumentToken;
typedef ARRAY(DocumentToken) DocumentTokens;

struct Document {
    Arena arena;            // the names
    const char *uri, *path; // as the client gave it; absolute, made up where there is no file
    const char *real;       // with links resolved
    double version;
    Buffer text;
    Analysis *analysis; // NULL: to be made
    bool has_tokens;
    DocumentTokens tokens;
    Report said;        // by the survey
    Report found;       // by the last evaluation, moved along with the text since
    bool is_told;       // the diagnostics of this text were published
    double evaluate_at; // by clock_seconds; 0: not to be evaluated
    // Semantic tokens as last sent, to tell what changed.
    uint32_t *sent_tokens;
    size_t sent_count;
    uint32_t sent_number;
};

// NULL where it isn't open.
Document *document_by_uri(Server *server, const char *uri);
Document *document_by_path(Server *server, const char *path);
Document *document_open(Server *server, const char *uri, double version, Str text);
void document_close(Server *server, Document *document);
void documents_free(Server *server);
// Replaces bytes [begin, end). False without memory.
bool document_edit(Server *server, Document *document, uint32_t begin, uint32_t end, Str text);
// A file that documents may depend on has changed on the disk.
void document_file_changed(Server *server, const char *path);
// Both are made on first need after a change. The analysis is NULL without memory.
const Analysis *document_analysis(Server *server, Document *document);
const DocumentTokens *document_tokens(Server *server, Document *document);

// Takes warnings of names that aren't used out of the report of a file that emits nothing: it is
// there to be imported, or only begun.
void document_excuse(const Document *document, Report *report);

// Opens the sandbox for a document: its folder, the host's folders, and, for files that emit
// nothing and so are there to be imported, the workspace.
void document_sandbox(Server *server, const Document *document, Sandbox *sandbox);
// Prepares a run over the document's text and those of the others that are open.
void document_lang(Server *server, Lang *lang, Sandbox *sandbox);

// --- Evaluation ----------------------------------------------------------------------------------

typedef struct Evaluation {
    Document *document; // NULL: none runs
    pid_t process;
    int from; // its report
    ARRAY(char) bytes;
    double stop_at, kill_at;
    atomic_int *stop; // shared with it
} Evaluation;

void evaluation_start(Server *server, Document *document);
// Reads what has arrived; once it is whole it goes to the document.
void evaluation_read(Server *server);
// Ends one that takes too long.
void evaluation_watch(Server *server, double now);
void evaluation_cancel(Server *server);
void evaluation_free(Server *server);

// --- The server ----------------------------------------------------------------------------------

typedef struct ClientFeatures {
    bool snippets, markdown, symbol_trees, related, watches;
    bool edit_range; // completion lists may say once what their items replace
} ClientFeatures;

typedef struct Settings {
    bool evaluate;
    double pause; // seconds after the last key
    double seconds;
    bool hint_values, hint_names, hint_units;
} Settings;

typedef enum Phase { PHASE_NEW, PHASE_RUNNING, PHASE_SHUT_DOWN, PHASE_ENDED } Phase;

// JSON-RPC's and the protocol's.
typedef enum RpcError {
    RPC_PARSE_ERROR = -32700,
    RPC_INVALID_REQUEST = -32600,
    RPC_METHOD_NOT_FOUND = -32601,
    RPC_INVALID_PARAMS = -32602,
    RPC_NOT_INITIALIZED = -32002,
    RPC_CANCELLED = -32800,
    RPC_FAILED = -32803,
} RpcError;

struct Server {
    const LspHost *host;
    int in, out;
    Frames frames;
    ARRAY(cJSON *) queue; // messages in their order
    Phase phase;
    LspEnd end;
    bool is_broken; // nobody reads
    PositionEncoding encoding;
    ClientFeatures client;
    Settings settings;
    ARRAY(Document *) documents;
    Arena arena; // paths of the workspace
    ARRAY(const char *) folders;
    ARRAY(char *) shown; // URIs that have diagnostics, beside the documents'
    Evaluation evaluation;
    uint32_t next_request;
    // Set by a handler that fails; the message is a literal or the arena's.
    RpcError error;
    const char *error_text;
    Arena scratch; // of the request at hand
};

void server_notify(Server *server, const char *method, cJSON *params);
void server_request(Server *server, const char *method, cJSON *params);
cJSON *server_fail(Server *server, RpcError error, const char *text); // gives NULL
void server_log(Server *server, const char *text);

// Analyses what is new, publishes, and starts what is due; gives the seconds until the next is,
// negative for none.
double server_idle(Server *server);

// --- Diagnostics ---------------------------------------------------------------------------------

void diagnostics_publish(Server *server, Document *document);
// Empties what is shown of a document that was closed.
void diagnostics_forget(Server *server, Document *document);

// --- Places --------------------------------------------------------------------------------------

uint32_t server_offset(const Server *server, const Document *document, const cJSON *position);
// "range"'s bytes.
void server_range(const Server *server, const Document *document, const cJSON *range,
                  uint32_t *begin, uint32_t *end);
cJSON *json_range(const Server *server, const Buffer *text, uint32_t begin, uint32_t end);
cJSON *json_position(const Server *server, const Buffer *text, uint32_t offset);
cJSON *json_edit(const Server *server, const Buffer *text, uint32_t begin, uint32_t end, Str with);

// Places in any files, each read once.
typedef struct PlaceFile {
    const char *path, *uri;
    const Buffer *text; // an open document's, or
    Buffer own;
} PlaceFile;
typedef struct Places {
    Server *server;
    ARRAY(PlaceFile) files;
} Places;

void places_end(Places *places);
// NULL without memory, or where the file can't be read. Good until the next call.
const PlaceFile *places_file(Places *places, const char *path);
const Buffer *place_text(const PlaceFile *file);
cJSON *places_location(Places *places, const FilePlace *at);

#endif
