#include "lsp/scene_files.h"

#include <dirent.h>
#include <limits.h>
#include <stdlib.h>
#include <sys/stat.h>

typedef struct Listing {
    Server *server;
    const Analysis *analysis;
    bool scenes;
    FileVisit *visit;
    void *context;
} Listing;

static bool is_scene(const char *name)
{
    size_t length = strlen(name);
    return length > 4 && strcmp(name + length - 4, ".scn") == 0;
}

// Links may lead out; what they lead to must lie inside, too.
static bool is_allowed(const Listing *listing, const char *path)
{
    char real[PATH_MAX];
    const char *inside;
    return realpath(path, real) &&
           sandbox_resolve(&listing->analysis->sandbox, &listing->server->scratch, NULL,
                           str_from(real), &inside) == IO_OK;
}

static void look_at(const Listing *listing, const char *folder, const char *name)
{
    char path[PATH_MAX];
    struct stat info;
    int size = snprintf(path, sizeof path, "%s/%s", folder, name);
    bool plain = name[0] != '.' && !strpbrk(name, "\"\\\n\t");
    if (!plain || size < 0 || (size_t)size >= sizeof path || stat(path, &info) != 0 ||
        !is_allowed(listing, path)) {
        return;
    }
    if (S_ISDIR(info.st_mode)) {
        listing->visit(listing->context, name, true);
    } else if (S_ISREG(info.st_mode) && is_scene(name) == listing->scenes) {
        listing->visit(listing->context, name, false);
    }
}

void scene_files(Server *server, const Analysis *analysis, const char *from, Str folder,
                 bool scenes, FileVisit *visit, void *context)
{
    enum { MOST = 2000 };
    const Listing listing = {server, analysis, scenes, visit, context};
    char given[PATH_MAX];
    const char *path;
    snprintf(given, sizeof given, "%.*s.", (int)(folder.length < 4000 ? folder.length : 4000),
             folder.at);
    if (sandbox_resolve(&analysis->sandbox, &server->scratch, from, str_from(given), &path) !=
            IO_OK ||
        !is_allowed(&listing, path)) {
        return;
    }
    DIR *list = opendir(path);
    const struct dirent *entry;
    for (int i = 0; list && i < MOST && (entry = readdir(list)); ++i) {
        look_at(&listing, path, entry->d_name);
    }
    if (list) {
        closedir(list);
    }
}
