#include "base/module.h"

#include <dlfcn.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct Search {
    const char *name;
    void *module;
    char *message;
    size_t message_size, length;
    bool found;     // a file is there, even if the loader refuses it
    bool only_look; // don't load it
} Search;

static void say(Search *search, const char *text)
{
    size_t room = search->message_size - search->length;
    int written = search->message_size > search->length
                      ? snprintf(search->message + search->length, room, "%s", text)
                      : 0;
    search->length += written < 0 ? 0 : (size_t)written < room ? (size_t)written : room - 1;
}

// True when the search is over: the module is there, for better or worse.
static bool try_folder(Search *search, const char *folder, size_t length, const char *below)
{
    char path[PATH_MAX];
    int wanted =
        snprintf(path, sizeof path, "%.*s%s/%s.so", (int)length, folder, below, search->name);
    if (length == 0 || length >= PATH_MAX || wanted < 0 || (size_t)wanted >= sizeof path) {
        return false;
    }
    if (access(path, F_OK) != 0) {
        say(search, search->length ? ", " : "no such module in ");
        path[(size_t)wanted - strlen(search->name) - strlen("/.so")] = '\0';
        say(search, path);
        return false;
    }
    search->found = true;
    if (search->only_look) {
        return true;
    }
    // Its own symbols first: a library must not be bound to a function of ours by its name.
    search->module = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!search->module) {
        const char *error = dlerror();
        search->length = 0;
        say(search, error ? error : "the loader refused it");
    }
    return true;
}

static bool try_list(Search *search, const char *list)
{
    while (list && *list) {
        size_t length = strcspn(list, ":");
        if (try_folder(search, list, length, "")) {
            return true;
        }
        list += length + (list[length] == ':');
    }
    return false;
}

// The folder of the running program, without a slash at its end; its length, or 0.
static size_t program_folder(char *out, size_t size)
{
    ssize_t length = readlink("/proc/self/exe", out, size - 1);
    while (length > 0 && out[length - 1] != '/') {
        --length;
    }
    if (length <= 1) {
        return 0;
    }
    out[length - 1] = '\0';
    return (size_t)length - 1;
}

static void look_everywhere(Search *search)
{
    if (search->message_size) {
        search->message[0] = '\0';
    }
    if (!*search->name || strchr(search->name, '/')) {
        say(search, "not the name of a module");
        return;
    }
    if (try_list(search, secure_getenv("SCNRENDER_MODULES"))) {
        return;
    }
    char program[PATH_MAX];
    const size_t length = program_folder(program, sizeof program);
    if (length == 0) {
        say(search, search->length ? "" : "the program's own folder is unknown");
        return;
    }
    static const char *const below[] = {"/../lib/scnrender", "/../lib64/scnrender",
                                        "/../lib/x86_64-linux-gnu/scnrender",
                                        "/../lib/aarch64-linux-gnu/scnrender"};
    for (size_t i = 0; i < sizeof below / sizeof below[0]; ++i) {
        if (try_folder(search, program, length, below[i])) {
            break;
        }
    }
}

void *module_open(const char *name, char *message, size_t message_size)
{
    Search search = {.name = name, .message = message, .message_size = message_size};
    look_everywhere(&search);
    return search.module;
}

bool module_exists(const char *name)
{
    Search search = {.name = name, .only_look = true};
    look_everywhere(&search);
    return search.found;
}

void *module_symbol(void *module, const char *symbol)
{
    return dlsym(module, symbol);
}

static bool folder_at(const char *folder, const char *below, const char *name, char *out,
                      size_t size)
{
    const int wanted = snprintf(out, size, "%s%s/%s", folder, below, name);
    return *folder && wanted > 0 && (size_t)wanted < size && access(out, R_OK | X_OK) == 0;
}

bool data_folder(const char *name, char *out, size_t size)
{
    const char *given = secure_getenv("SCNRENDER_DATA");
    char program[PATH_MAX];
    return (given && folder_at(given, "", name, out, size)) ||
           (program_folder(program, sizeof program) &&
            folder_at(program, "/../share/scnrender", name, out, size));
}
