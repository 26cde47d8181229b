// Definition, references, highlights.
#include "lsp/references.h"

#include "lsp/features.h"
#include "lsp/workspace.h"

#include <stdlib.h>

// --- Declarations --------------------------------------------------------------------------------

FilePlace reference_target(const Analysis *analysis, const Target *target)
{
    if (target->kind != TARGET_NAME || target->meaning.kind != MEANS_ITEM) {
        return (FilePlace){0};
    }
    Span name = survey_name_span(analysis->survey, target->meaning.file, target->meaning.item);
    return (FilePlace){tree_file_path(analysis, target->meaning.file), name.begin, name.end};
}

static bool is_at_top(const Ast *ast, AstId item)
{
    uint32_t list = ast_node(ast, ast->root)->a;
    for (uint32_t i = 0; i < ast_list_count(ast, list); ++i) {
        if (ast_list_items(ast, list)[i] == item) {
            return true;
        }
    }
    return false;
}

bool reference_is_local(const Analysis *analysis, const Target *target)
{
    const Ast *ast = survey_ast(analysis->survey, target->meaning.file);
    AstTag tag = (AstTag)ast_node(ast, target->meaning.item)->tag;
    if (tag == AST_PARAMETER) {
        return false; // calls elsewhere may name it
    }
    return tag == AST_IMPORT || tag == AST_FOR || !is_at_top(ast, target->meaning.item);
}

// --- In one survey -------------------------------------------------------------------------------

typedef struct Collector {
    const Analysis *analysis;
    const FilePlace *declaration;
    References *out;
} Collector;

static bool means_it(const Collector *c, const Meaning *meaning)
{
    if (meaning->kind != MEANS_ITEM) {
        return false;
    }
    Span name = survey_name_span(c->analysis->survey, meaning->file, meaning->item);
    const char *path = tree_file_path(c->analysis, meaning->file);
    return name.begin == c->declaration->begin && path && strcmp(path, c->declaration->path) == 0;
}

static void found(Collector *c, uint32_t file, uint32_t begin, uint32_t end, bool declares)
{
    Reference reference = {{tree_file_path(c->analysis, file), begin, end}, declares};
    array_push(c->out, reference);
}

static void look_at_arguments(Collector *c, uint32_t file, const AstNode *call)
{
    const Ast *ast = survey_ast(c->analysis->survey, file);
    for (uint32_t i = 0; i < ast_list_count(ast, call->b); ++i) {
        const AstNode *argument = ast_node(ast, ast_list_items(ast, call->b)[i]);
        if (argument->tag != AST_ARGUMENT) {
            continue;
        }
        uint32_t other = file;
        AstId fn = tree_function(c->analysis, &other, call->a);
        AstId parameter =
            fn ? tree_parameter(survey_ast(c->analysis->survey, other), fn, argument->a) : 0;
        Meaning meaning = {.kind = MEANS_ITEM, .file = other, .item = parameter};
        if (parameter && means_it(c, &meaning)) {
            uint32_t length = (uint32_t)tree_symbol(c->analysis, argument->a).length;
            found(c, file, argument->begin, argument->begin + length, false);
        }
    }
}

static void look_at(Collector *c, uint32_t file, AstId id)
{
    const AstNode *node = ast_node(survey_ast(c->analysis->survey, file), id);
    if (node->tag == AST_NAME || node->tag == AST_MEMBER) {
        Meaning meaning = survey_meaning(c->analysis->survey, file, id);
        if (means_it(c, &meaning)) {
            uint32_t length = c->declaration->end - c->declaration->begin;
            found(c, file, node->tag == AST_NAME ? node->begin : node->end - length, node->end,
                  false);
        }
    } else if (node->tag == AST_CALL) {
        look_at_arguments(c, file, node);
    }
}

void references_in(const Analysis *analysis, const FilePlace *declaration, References *out)
{
    Collector c = {analysis, declaration, out};
    for (uint32_t file = 0; file < survey_file_count(analysis->survey); ++file) {
        const Ast *ast = survey_ast(analysis->survey, file);
        const char *path = tree_file_path(analysis, file);
        if (path && strcmp(path, declaration->path) == 0) {
            found(&c, file, declaration->begin, declaration->end, true);
        }
        for (AstId id = 1; path && id < ast->nodes.count; ++id) {
            look_at(&c, file, id);
        }
    }
}

// --- Everywhere ----------------------------------------------------------------------------------

static int compare(const void *a, const void *b)
{
    const Reference *left = a, *right = b;
    int order = strcmp(left->at.path, right->at.path);
    return order ? order : (left->at.begin > right->at.begin) - (left->at.begin < right->at.begin);
}

static void keep_once(References *list)
{
    size_t kept = 0;
    if (list->count > 0) {
        qsort(list->items, list->count, sizeof(Reference), compare);
    }
    for (size_t i = 0; i < list->count; ++i) {
        if (kept == 0 || compare(&list->items[kept - 1], &list->items[i]) != 0) {
            list->items[kept++] = list->items[i];
        }
    }
    list->count = kept;
}

// Paths that outlive the survey.
static void keep_paths(Server *server, References *list, size_t from)
{
    const char *last = NULL;
    for (size_t i = from; i < list->count; ++i) {
        const char *path = list->items[i].at.path;
        if (!last || strcmp(last, path) != 0) {
            last = arena_copy_string(&server->scratch, path, strlen(path));
        }
        list->items[i].at.path = last ? last : "";
    }
}

typedef struct Gathering {
    Server *server;
    const FilePlace *declaration;
    References *out;
} Gathering;

static void gather(void *context, const Analysis *analysis)
{
    Gathering *gathering = context;
    size_t from = gathering->out->count;
    if (survey_find_file(analysis->survey, gathering->declaration->path) >= 0) {
        references_in(analysis, gathering->declaration, gathering->out);
        keep_paths(gathering->server, gathering->out, from);
    }
}

void references_everywhere(Server *server, Document *document, const FilePlace *declaration,
                           bool local, References *out)
{
    Gathering gathering = {server, declaration, out};
    FilePlace kept = *declaration;
    kept.path = arena_copy_string(&server->scratch, kept.path, strlen(kept.path));
    gathering.declaration = &kept;
    const Analysis *analysis = document_analysis(server, document);
    if (!kept.path || !analysis) {
        return;
    }
    gather(&gathering, analysis);
    for (size_t i = 0; !local && i < server->documents.count; ++i) {
        Document *other = server->documents.items[i];
        analysis = other == document ? NULL : document_analysis(server, other);
        if (analysis) {
            gather(&gathering, analysis);
        }
    }
    if (!local) {
        workspace_surveys(server, kept.path, gather, &gathering);
    }
    keep_once(out);
}

// --- Requests ------------------------------------------------------------------------------------

cJSON *feature_references(Server *server, Document *document, const cJSON *params)
{
    const Analysis *analysis = document_analysis(server, document);
    if (!analysis) {
        return NULL;
    }
    Target target =
        target_at(analysis, server_offset(server, document, json_at(params, "position")));
    FilePlace declaration = reference_target(analysis, &target);
    if (!declaration.path) {
        return NULL;
    }
    bool declared = json_get_true(params, "context.includeDeclaration");
    References list = {0};
    references_everywhere(server, document, &declaration, reference_is_local(analysis, &target),
                          &list);
    cJSON *result = cJSON_CreateArray();
    Places places = {.server = server};
    for (size_t i = 0; i < list.count; ++i) {
        cJSON *location = declared || !list.items[i].declares
                              ? places_location(&places, &list.items[i].at)
                              : NULL;
        if (location) {
            cJSON_AddItemToArray(result, location);
        }
    }
    places_end(&places);
    array_free(&list);
    return result;
}

cJSON *feature_highlight(Server *server, Document *document, const cJSON *params)
{
    const Analysis *analysis = document_analysis(server, document);
    if (!analysis) {
        return NULL;
    }
    Target target =
        target_at(analysis, server_offset(server, document, json_at(params, "position")));
    FilePlace declaration = reference_target(analysis, &target);
    References list = {0};
    if (declaration.path) {
        references_in(analysis, &declaration, &list);
    }
    cJSON *result = cJSON_CreateArray();
    for (size_t i = 0; i < list.count; ++i) {
        const Reference *reference = &list.items[i];
        if (strcmp(reference->at.path, document->real) == 0) {
            cJSON *highlight = cJSON_CreateObject();
            cJSON_AddItemToObject(
                highlight, "range",
                json_range(server, &document->text, reference->at.begin, reference->at.end));
            cJSON_AddNumberToObject(highlight, "kind", reference->declares ? 3 : 2);
            cJSON_AddItemToArray(result, highlight);
        }
    }
    array_free(&list);
    return result;
}

// The file that a string names, where it is there.
static bool string_file(Server *server, const Document *document, const Analysis *analysis,
                        const Target *target, FilePlace *out)
{
    const Ast *ast = survey_ast(analysis->survey, 0);
    if (target->kind == TARGET_IMPORT) {
        int64_t file = survey_import(analysis->survey, 0, target->node);
        *out = (FilePlace){file >= 0 ? tree_file_path(analysis, (uint32_t)file) : NULL, 0, 0};
        return out->path != NULL;
    }
    if (target->kind != TARGET_STRING || !target->param || target->param->type != PARAM_FILE) {
        return false;
    }
    const char *path;
    Str written = tree_symbol(analysis, ast_node(ast, target->node)->a);
    *out = (FilePlace){0};
    if (sandbox_resolve(&analysis->sandbox, &server->scratch, document->real, written, &path) ==
        IO_OK) {
        out->path = path;
    }
    return out->path != NULL;
}

cJSON *feature_definition(Server *server, Document *document, const cJSON *params)
{
    const Analysis *analysis = document_analysis(server, document);
    if (!analysis) {
        return NULL;
    }
    Target target =
        target_at(analysis, server_offset(server, document, json_at(params, "position")));
    FilePlace place = reference_target(analysis, &target);
    if (!place.path && !string_file(server, document, analysis, &target, &place)) {
        return NULL;
    }
    Places places = {.server = server};
    cJSON *location = places_location(&places, &place);
    places_end(&places);
    return location;
}
