#include "lsp/workspace.h"

#include "lsp/features.h"
#include "lsp/tree.h"

#include <dirent.h>
#include <limits.h>
#include <stdlib.h>
#include <sys/stat.h>

enum { MOST_FILES = 4000, MOST_ENTRIES = 50000, DEEPEST = 12, LARGEST = 8 << 20 };

typedef struct Search {
    Server *server;
    const char *path;
    Str name; // the last part of the path; empty: every scene
    WorkspaceVisit *visit;
    void *context;
    int files, entries;
} Search;

static bool contains(Str text, Str part)
{
    return part.length == 0 || memmem(text.at, text.length, part.at, part.length) != NULL;
}

static void survey_file(Search *search, const char *path)
{
    char real[PATH_MAX];
    FileBytes bytes;
    if (document_by_path(search->server, path) || !realpath(path, real) ||
        (search->path && strcmp(real, search->path) == 0) ||
        file_read(path, LARGEST, &bytes) != IO_OK) {
        return;
    }
    Str text = {bytes.bytes, bytes.size};
    Analysis analysis = {0};
    if (contains(text, search->name)) {
        Document document = {.path = path, .real = real};
        document_sandbox(search->server, &document, &analysis.sandbox);
        document_lang(search->server, &analysis.lang, &analysis.sandbox);
        analysis.survey = survey_open(&analysis.lang, text, real, path);
        if (analysis.survey) {
            search->visit(search->context, &analysis);
        }
        survey_free(analysis.survey);
        lang_free(&analysis.lang);
        sandbox_free(&analysis.sandbox);
    }
    file_bytes_free(&bytes);
}

// Links are not followed; folders of other tools are left out.
static void search_folder(Search *search, const char *folder, int depth)
{
    DIR *list = depth < DEEPEST ? opendir(folder) : NULL;
    const struct dirent *entry;
    while (list && search->entries < MOST_ENTRIES && (entry = readdir(list))) {
        char path[PATH_MAX];
        struct stat info;
        ++search->entries;
        int size = snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (entry->d_name[0] == '.' || strcmp(entry->d_name, "node_modules") == 0 ||
            size >= (int)sizeof path || lstat(path, &info) != 0) {
            continue;
        }
        size_t length = strlen(entry->d_name);
        bool scene = length > 4 && strcmp(entry->d_name + length - 4, ".scn") == 0;
        if (S_ISDIR(info.st_mode)) {
            search_folder(search, path, depth + 1);
        } else if (S_ISREG(info.st_mode) && scene && search->files++ < MOST_FILES) {
            survey_file(search, path);
        }
    }
    if (list) {
        closedir(list);
    }
}

void workspace_surveys(Server *server, const char *path, WorkspaceVisit *visit, void *context)
{
    const char *slash = path ? strrchr(path, '/') : NULL;
    Search search = {.server = server,
                     .path = path,
                     .name = slash ? str_from(slash + 1) : STR(""),
                     .visit = visit,
                     .context = context};
    for (size_t i = 0; i < server->folders.count; ++i) {
        search_folder(&search, server->folders.items[i], 0);
    }
}
