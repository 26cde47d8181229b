#include "lsp/server.h"

#include "base/clock.h"
#include "base/mem.h"
#include "lang/lexer.h"
#include "lsp/uri.h"

#include <limits.h>
#include <stdlib.h>
#include <unistd.h>

// --- The list ------------------------------------------------------------------------------------

Document *document_by_uri(Server *server, const char *uri)
{
    for (size_t i = 0; uri && i < server->documents.count; ++i) {
        if (strcmp(server->documents.items[i]->uri, uri) == 0) {
            return server->documents.items[i];
        }
    }
    return NULL;
}

Document *document_by_path(Server *server, const char *path)
{
    for (size_t i = 0; path && i < server->documents.count; ++i) {
        Document *document = server->documents.items[i];
        if (strcmp(document->path, path) == 0 || strcmp(document->real, path) == 0) {
            return document;
        }
    }
    return NULL;
}

// --- What is known of a document -----------------------------------------------------------------

static void drop_analysis(Document *document)
{
    Analysis *analysis = document->analysis;
    if (analysis) {
        survey_free(analysis->survey);
        lang_free(&analysis->lang);
        sandbox_free(&analysis->sandbox);
        mem_free(analysis);
        document->analysis = NULL;
    }
}

static bool depends_on(const Document *document, const char *path)
{
    return document->analysis && survey_find_file(document->analysis->survey, path) >= 0;
}

// Whether a file that could not be read was reported: it may be this one.
static bool misses_file(const Report *report)
{
    for (size_t i = 0; i < report->items.count; ++i) {
        DiagCode code = report->items.items[i].code;
        if (code == E0601 || code == E0602 || code == E0603) {
            return true;
        }
    }
    return false;
}

// What was found of the documents that read this file no longer holds.
static void make_stale(Server *server, const char *path, const char *real)
{
    for (size_t i = 0; i < server->documents.count; ++i) {
        Document *document = server->documents.items[i];
        if (depends_on(document, path) || depends_on(document, real) ||
            misses_file(&document->said) || misses_file(&document->found)) {
            drop_analysis(document);
            document->is_told = false;
            document->evaluate_at = clock_seconds() + server->settings.pause;
            if (server->evaluation.document == document) {
                evaluation_cancel(server);
            }
        }
    }
}

static void document_free(Document *document)
{
    drop_analysis(document);
    buffer_free(&document->text);
    array_free(&document->tokens);
    report_free(&document->said);
    report_free(&document->found);
    mem_free(document->sent_tokens);
    arena_free(&document->arena);
    mem_free(document);
}

// A document that is no file lies in the first folder of the workspace, as far as names go.
static const char *made_up_path(Server *server, Document *document)
{
    char folder[PATH_MAX];
    const char *in = server->folders.count           ? server->folders.items[0]
                     : getcwd(folder, sizeof folder) ? folder
                                                     : "/";
    const char *slash = strrchr(document->uri, '/'), *colon = strrchr(document->uri, ':');
    const char *name = slash ? slash + 1 : colon ? colon + 1 : document->uri;
    return arena_printf(&document->arena, "%s/%s", in, *name ? name : "scene");
}

static bool set_paths(Server *server, Document *document)
{
    document->path = uri_to_path(&document->arena, str_from(document->uri));
    if (!document->path) {
        document->path = made_up_path(server, document);
    }
    char real[PATH_MAX];
    document->real = document->path && realpath(document->path, real)
                         ? arena_copy_string(&document->arena, real, strlen(real))
                         : document->path;
    return document->path && document->real;
}

Document *document_open(Server *server, const char *uri, double version, Str text)
{
    Document *document = document_by_uri(server, uri);
    if (document) { // opened twice
        document_edit(server, document, 0, (uint32_t)document->text.bytes.count, text);
        document->version = version;
        return document;
    }
    document = mem_alloc_zeroed(1, sizeof *document);
    if (!document) {
        return NULL;
    }
    document->uri = arena_copy_string(&document->arena, uri, strlen(uri));
    document->version = version;
    bool good = document->uri && set_paths(server, document) && buffer_set(&document->text, text) &&
                array_reserve(&server->documents, 1);
    if (!good) {
        document_free(document);
        return NULL;
    }
    make_stale(server, document->path, document->real);
    array_push(&server->documents, document);
    document->evaluate_at = clock_seconds();
    return document;
}

void document_close(Server *server, Document *document)
{
    if (server->evaluation.document == document) {
        evaluation_cancel(server);
    }
    diagnostics_forget(server, document);
    size_t i = 0;
    while (server->documents.items[i] != document) {
        ++i;
    }
    memmove(&server->documents.items[i], &server->documents.items[i + 1],
            (--server->documents.count - i) * sizeof(Document *));
    drop_analysis(document);
    make_stale(server, document->path, document->real); // the file's text counts again
    document_free(document);
}

void documents_free(Server *server)
{
    // An analysis may hold texts of other documents.
    for (size_t i = 0; i < server->documents.count; ++i) {
        drop_analysis(server->documents.items[i]);
    }
    for (size_t i = 0; i < server->documents.count; ++i) {
        document_free(server->documents.items[i]);
    }
    array_free(&server->documents);
}

bool document_edit(Server *server, Document *document, uint32_t begin, uint32_t end, Str text)
{
    // Whole documents are sent even where little has changed.
    Str old = buffer_content(&document->text);
    size_t same = 0;
    while (begin < end && same < text.length && old.at[begin] == text.at[same]) {
        ++begin;
        ++same;
    }
    text = (Str){text.at + same, text.length - same};
    while (end > begin && text.length > 0 && old.at[end - 1] == text.at[text.length - 1]) {
        --end;
        --text.length;
    }
    if (begin == end && text.length == 0) {
        document->is_told = false; // the version is a new one
        return true;
    }
    make_stale(server, document->path, document->real);
    drop_analysis(document); // it holds the text
    document->is_told = false;
    document->has_tokens = false;
    document->evaluate_at = clock_seconds() + server->settings.pause;
    if (server->evaluation.document == document) {
        evaluation_cancel(server);
    }
    if (!buffer_replace(&document->text, begin, end, text)) {
        return false;
    }
    for (size_t i = 0; i < server->documents.count; ++i) {
        Document *other = server->documents.items[i];
        report_edit(&other->found, document->real, begin, end, (uint32_t)text.length);
    }
    return true;
}

void document_file_changed(Server *server, const char *path)
{
    if (!document_by_path(server, path)) { // else the editor's text counts
        make_stale(server, path, path);
    }
}

// --- Analysis ------------------------------------------------------------------------------------

static bool find_open_text(void *context, const char *path, Str *text)
{
    Document *document = document_by_path(context, path);
    if (document) {
        *text = buffer_content(&document->text);
    }
    return document != NULL;
}

void document_lang(Server *server, Lang *lang, Sandbox *sandbox)
{
    lang_init(lang, server->host->schema, sandbox);
    lang->limits = server->host->limits;
    uint64_t most = server->host->limits.diagnostics;
    lang->sink.limit = most < UINT32_MAX ? (uint32_t)most : UINT32_MAX;
    lang->find_given = find_open_text;
    lang->find_given_context = server;
}

static bool is_below(const char *path, const char *folder)
{
    size_t length = strlen(folder);
    return strncmp(path, folder, length) == 0 && (path[length] == '/' || length == 1);
}

// Whether an item at the top of the file emits something, as far as is known.
static bool emits(const Document *document)
{
    if (!document->analysis) {
        return true;
    }
    const Ast *ast = survey_ast(document->analysis->survey, 0);
    uint32_t list = ast->nodes.items[ast->root].a;
    for (uint32_t i = 0; ast->root && i < ast_list_count(ast, list); ++i) {
        uint8_t tag = ast->nodes.items[ast_list_items(ast, list)[i]].tag;
        if (tag == AST_EMIT || tag == AST_FOR || tag == AST_IF) {
            return true;
        }
    }
    return false;
}

void document_sandbox(Server *server, const Document *document, Sandbox *sandbox)
{
    sandbox_init(sandbox);
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s", document->real);
    char *slash = strrchr(folder, '/');
    if (slash) {
        slash[slash == folder] = '\0';
        sandbox_allow(sandbox, folder);
    }
    for (size_t i = 0; i < server->host->folder_count; ++i) {
        sandbox_allow(sandbox, server->host->folders[i]);
    }
    for (size_t i = 0; !emits(document) && i < server->folders.count; ++i) {
        if (is_below(document->path, server->folders.items[i])) {
            sandbox_allow(sandbox, server->folders.items[i]);
        }
    }
}

static Analysis *analyse(Server *server, Document *document)
{
    Analysis *analysis = mem_alloc_zeroed(1, sizeof *analysis);
    if (!analysis) {
        return NULL;
    }
    document_sandbox(server, document, &analysis->sandbox);
    document_lang(server, &analysis->lang, &analysis->sandbox);
    analysis->survey = survey_open(&analysis->lang, buffer_content(&document->text), document->real,
                                   document->path);
    if (!analysis->survey) {
        lang_free(&analysis->lang);
        sandbox_free(&analysis->sandbox);
        mem_free(analysis);
        return NULL;
    }
    return analysis;
}

static bool lies_outside(const Analysis *analysis)
{
    for (uint32_t i = 0; i < analysis->lang.sink.count; ++i) {
        if (analysis->lang.sink.items[i].code == E0601) {
            return true;
        }
    }
    return false;
}

const Analysis *document_analysis(Server *server, Document *document)
{
    if (document->analysis) {
        return document->analysis;
    }
    document->analysis = analyse(server, document);
    if (document->analysis && lies_outside(document->analysis) && !emits(document)) {
        Analysis *again = analyse(server, document); // now that it is known to be a library
        drop_analysis(document);
        document->analysis = again;
    }
    report_free(&document->said);
    if (document->analysis) {
        report_take(&document->said, &document->analysis->lang, NULL);
        document_excuse(document, &document->said);
    }
    return document->analysis;
}

static bool declares_at(const Document *document, uint32_t begin)
{
    const Survey *survey = document->analysis->survey;
    const Ast *ast = survey_ast(survey, 0);
    uint32_t list = ast->nodes.items[ast->root].a;
    for (uint32_t i = 0; i < ast_list_count(ast, list); ++i) {
        AstId item = ast_list_items(ast, list)[i];
        uint8_t tag = ast->nodes.items[item].tag;
        if ((tag == AST_LET || tag == AST_FN || tag == AST_PARAM || tag == AST_IMPORT) &&
            survey_name_span(survey, 0, item).begin == begin) {
            return true;
        }
    }
    return false;
}

void document_excuse(const Document *document, Report *report)
{
    if (!document->analysis || emits(document)) {
        return;
    }
    size_t kept = 0;
    for (size_t i = 0; i < report->items.count; ++i) {
        ReportItem item = report->items.items[i];
        bool excused = item.code == W0301 && item.at.path &&
                       strcmp(item.at.path, document->real) == 0 &&
                       declares_at(document, item.at.begin);
        if (!excused) {
            report->items.items[kept++] = item;
        }
    }
    report->items.count = kept;
}

// --- Tokens --------------------------------------------------------------------------------------

typedef struct TokenReader {
    Lexer lexer;
    Token token;
    Arena arena;
    Interner names;
    DiagSink nowhere; // the survey reports
    AstCommentArray comments;
    size_t comment; // the next one
    DocumentTokens *out;
    jmp_buf on_oom;
} TokenReader;

static void push_token(TokenReader *r, DocumentToken token)
{
    if (!array_push(r->out, token)) {
        longjmp(r->on_oom, 1);
    }
}

static void read_tokens(TokenReader *r, const Source *source)
{
    if (setjmp(r->on_oom) != 0) {
        return;
    }
    lexer_init(&r->lexer, source, 1, &r->names, &r->nowhere, &r->comments, &r->on_oom);
    do {
        lexer_next(&r->lexer, &r->token);
        for (; r->comment < r->comments.count; ++r->comment) {
            AstComment comment = r->comments.items[r->comment];
            push_token(r, (DocumentToken){TOKEN_KIND_COUNT, false, comment.begin, comment.end});
        }
        if (r->token.kind != TOKEN_END) {
            push_token(r, (DocumentToken){r->token.kind, r->token.on_new_line, r->token.begin,
                                          r->token.end});
        }
    } while (r->token.kind != TOKEN_END);
}

const DocumentTokens *document_tokens(Server *server, Document *document)
{
    (void)server;
    if (document->has_tokens) {
        return &document->tokens;
    }
    document->tokens.count = 0;
    TokenReader *r = mem_alloc_zeroed(1, sizeof *r);
    if (!r) {
        return &document->tokens;
    }
    interner_init(&r->names, &r->arena);
    diag_sink_init(&r->nowhere, &r->arena);
    r->nowhere.limit = 0;
    r->out = &document->tokens;
    read_tokens(r, &(Source){.text = buffer_content(&document->text)});
    lexer_free(&r->lexer);
    diag_sink_free(&r->nowhere);
    interner_free(&r->names);
    array_free(&r->comments);
    arena_free(&r->arena);
    mem_free(r);
    document->has_tokens = true;
    return &document->tokens;
}
