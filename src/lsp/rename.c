// Renaming, held to what it must not change: afterwards there are no more errors than before, and
// every place still means the same declaration.
#include "lsp/features.h"
#include "lsp/references.h"
#include "lsp/uri.h"

#include "base/mem.h"

// --- Names ---------------------------------------------------------------------------------------

static bool is_letter(char c)
{
    return c == '_' || ((c | 0x20) >= 'a' && (c | 0x20) <= 'z');
}

static const char *refuse_name(const char *name)
{
    bool good = name && is_letter(*name);
    for (size_t i = 1; good && name[i]; ++i) {
        good = is_letter(name[i]) || (name[i] >= '0' && name[i] <= '9');
    }
    if (!good) {
        return "a name is made of letters, digits and `_`, and begins with no digit";
    }
    for (size_t i = 0; i < lang_keyword_count; ++i) {
        if (strcmp(lang_keywords[i], name) == 0) {
            return "this is a reserved word and can't be a name";
        }
    }
    return NULL;
}

static bool find_target(Server *server, Document *document, const cJSON *params, Target *target,
                        FilePlace *declaration)
{
    const Analysis *analysis = document_analysis(server, document);
    if (!analysis) {
        return false;
    }
    *target = target_at(analysis, server_offset(server, document, json_at(params, "position")));
    *declaration = reference_target(analysis, target);
    return declaration->path != NULL;
}

cJSON *feature_prepare_rename(Server *server, Document *document, const cJSON *params)
{
    Target target;
    FilePlace declaration;
    if (!find_target(server, document, params, &target, &declaration)) {
        return NULL;
    }
    return json_range(server, &document->text, target.begin, target.end);
}

// --- The changed texts ---------------------------------------------------------------------------

typedef struct Changed {
    const char *path;
    Buffer text;
} Changed;

typedef struct Trial {
    Server *server;
    ARRAY(Changed) files;
} Trial;

static bool find_changed(void *context, const char *path, Str *text)
{
    Trial *trial = context;
    for (size_t i = 0; i < trial->files.count; ++i) {
        if (strcmp(trial->files.items[i].path, path) == 0) {
            *text = buffer_content(&trial->files.items[i].text);
            return true;
        }
    }
    Document *document = document_by_path(trial->server, path);
    if (document) {
        *text = buffer_content(&document->text);
    }
    return document != NULL;
}

static bool change_file(Trial *trial, Places *places, const References *list, size_t from,
                        size_t to, Str name)
{
    const char *path = list->items[from].at.path;
    const PlaceFile *file = places_file(places, path);
    Changed changed = {.path = path};
    bool good = file && buffer_set(&changed.text, buffer_content(place_text(file)));
    for (size_t i = to; good && i-- > from;) {
        const FilePlace *at = &list->items[i].at;
        good = at->end <= changed.text.bytes.count &&
               buffer_replace(&changed.text, at->begin, at->end, name);
    }
    if (!good || !array_push(&trial->files, changed)) {
        buffer_free(&changed.text);
        return false;
    }
    return true;
}

// The reference that belongs to the document's changed text after the change.
static FilePlace moved(const References *list, const FilePlace *declaration, size_t length)
{
    FilePlace place = *declaration;
    for (size_t i = 0; i < list->count; ++i) {
        const FilePlace *at = &list->items[i].at;
        if (strcmp(at->path, place.path) == 0 && at->begin < declaration->begin) {
            place.begin += (uint32_t)length - (at->end - at->begin);
        }
    }
    place.end = place.begin + (uint32_t)length;
    return place;
}

// Surveys the document over the changed texts: the errors, and the places that mean the
// declaration.
static bool survey_changed(Trial *trial, Document *document, const FilePlace *declaration,
                           uint32_t *errors, size_t *uses)
{
    Analysis analysis = {0};
    Str text;
    document_sandbox(trial->server, document, &analysis.sandbox);
    document_lang(trial->server, &analysis.lang, &analysis.sandbox);
    analysis.lang.find_given = find_changed;
    analysis.lang.find_given_context = trial;
    find_changed(trial, document->real, &text);
    analysis.survey = survey_open(&analysis.lang, text, document->real, document->path);
    bool good = analysis.survey != NULL;
    if (good) {
        References list = {0};
        references_in(&analysis, declaration, &list);
        *uses = list.count;
        *errors = analysis.lang.sink.errors;
        array_free(&list);
    }
    survey_free(analysis.survey);
    lang_free(&analysis.lang);
    sandbox_free(&analysis.sandbox);
    return good;
}

static bool keeps_meaning(Trial *trial, Document *document, const References *list,
                          const FilePlace *declaration, Str name)
{
    uint32_t errors_before = 0, errors_after = 0;
    size_t uses_before = 0, uses_after = 0;
    Trial unchanged = {.server = trial->server};
    FilePlace after = moved(list, declaration, name.length);
    return survey_changed(&unchanged, document, declaration, &errors_before, &uses_before) &&
           survey_changed(trial, document, &after, &errors_after, &uses_after) &&
           errors_after <= errors_before && uses_after == uses_before;
}

// --- The request ---------------------------------------------------------------------------------

static size_t file_end(const References *list, size_t from)
{
    size_t to = from;
    while (to < list->count && strcmp(list->items[to].at.path, list->items[from].at.path) == 0) {
        ++to;
    }
    return to;
}

static cJSON *edits(Server *server, Places *places, const References *list, Str name)
{
    cJSON *edit = cJSON_CreateObject(), *changes = cJSON_AddObjectToObject(edit, "changes");
    for (size_t from = 0; from < list->count; from = file_end(list, from)) {
        const PlaceFile *file = places_file(places, list->items[from].at.path);
        if (!file) {
            continue;
        }
        cJSON *array = cJSON_AddArrayToObject(changes, file->uri);
        for (size_t i = from; i < file_end(list, from); ++i) {
            const FilePlace *at = &list->items[i].at;
            cJSON_AddItemToArray(array,
                                 json_edit(server, place_text(file), at->begin, at->end, name));
        }
    }
    return edit;
}

static cJSON *rename_all(Server *server, Document *document, const References *list,
                         const FilePlace *declaration, Str name)
{
    Trial trial = {.server = server};
    Places places = {.server = server};
    bool good = true;
    for (size_t from = 0; good && from < list->count; from = file_end(list, from)) {
        good = change_file(&trial, &places, list, from, file_end(list, from), name);
    }
    cJSON *result = NULL;
    if (!good) {
        server_fail(server, RPC_FAILED, "a file that uses the name can't be read");
    } else if (!keeps_meaning(&trial, document, list, declaration, name)) {
        server_fail(server, RPC_FAILED,
                    "the new name is taken where the old one is used: something would mean "
                    "something else");
    } else {
        result = edits(server, &places, list, name);
    }
    for (size_t i = 0; i < trial.files.count; ++i) {
        buffer_free(&trial.files.items[i].text);
    }
    array_free(&trial.files);
    places_end(&places);
    return result;
}

cJSON *feature_rename(Server *server, Document *document, const cJSON *params)
{
    const char *name = json_get_string(params, "newName"), *refused = refuse_name(name);
    Target target;
    FilePlace declaration;
    if (refused) {
        return server_fail(server, RPC_INVALID_PARAMS, refused);
    }
    if (!find_target(server, document, params, &target, &declaration)) {
        return server_fail(server, RPC_FAILED, "no name that a scene declares stands here");
    }
    FilePlace kept = declaration;
    kept.path = arena_copy_string(&server->scratch, declaration.path, strlen(declaration.path));
    References list = {0};
    bool local = reference_is_local(document->analysis, &target);
    references_everywhere(server, document, &declaration, local, &list);
    cJSON *result = kept.path ? rename_all(server, document, &list, &kept, str_from(name)) : NULL;
    array_free(&list);
    return result;
}
