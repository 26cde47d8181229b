#include "base/io.h"

#include "base/mem.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/openat2.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { READ_FLAGS = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC };

static const uint64_t DEFAULT_MAX_FILE_BYTES = (uint64_t)1 << 34;

void sandbox_init(Sandbox *sandbox)
{
    *sandbox = (Sandbox){.max_file_bytes = DEFAULT_MAX_FILE_BYTES};
}

void sandbox_free(Sandbox *sandbox)
{
    for (int i = 0; i < sandbox->root_count; ++i) {
        close(sandbox->roots[i].fd);
        mem_free(sandbox->roots[i].path);
        mem_free(sandbox->roots[i].given);
    }
    sandbox->root_count = 0;
}

// --- Names ---------------------------------------------------------------------------------------

// Writes `path`, which begins with "/", without empty, "." and ".." parts to `out` (at least as
// long). ".." at the top stays at the top.
static void normalize(const char *path, size_t length, char *out)
{
    size_t end = 0, at = 0;
    while (at < length) {
        while (at < length && path[at] == '/') {
            ++at;
        }
        size_t begin = at;
        while (at < length && path[at] != '/') {
            ++at;
        }
        size_t part = at - begin;
        if (part == 0 || (part == 1 && path[begin] == '.')) {
            continue;
        }
        if (part == 2 && path[begin] == '.' && path[begin + 1] == '.') {
            while (end > 0 && out[--end] != '/') {
            }
            continue;
        }
        out[end++] = '/';
        memmove(out + end, path + begin, part);
        end += part;
    }
    if (end == 0) {
        out[end++] = '/';
    }
    out[end] = '\0';
}

// The part of `path` below `folder` ("." for the folder itself), or NULL if it isn't below.
static const char *below(const char *folder, const char *path)
{
    size_t length = strcmp(folder, "/") == 0 ? 0 : strlen(folder);
    if (strncmp(folder, path, length) != 0 || (path[length] != '/' && path[length] != '\0')) {
        return NULL;
    }
    const char *rest = path + length;
    while (*rest == '/') {
        ++rest;
    }
    return *rest ? rest : ".";
}

static const char *below_root(const struct SandboxRoot *root, const char *path)
{
    const char *rest = below(root->path, path);
    return rest ? rest : below(root->given, path);
}

// The absolute, normalized form of a path from the command line (mem), or NULL with *error.
static char *absolute_path(const char *path, IoError *error)
{
    char folder[PATH_MAX] = "";
    size_t length = strlen(path);
    *error = length >= PATH_MAX ? IO_NOT_FOUND : IO_NO_MEMORY;
    if (length >= PATH_MAX) {
        return NULL;
    }
    if (path[0] != '/' && !getcwd(folder, sizeof folder)) {
        *error = IO_NOT_FOUND;
        return NULL;
    }
    size_t folder_length = strlen(folder);
    char *whole = mem_alloc(folder_length + length + 2, 1);
    if (whole) {
        memcpy(whole, folder, folder_length);
        whole[folder_length] = '/';
        memcpy(whole + folder_length + 1, path, length);
        normalize(whole, folder_length + 1 + length, whole);
    }
    return whole;
}

IoError sandbox_allow(Sandbox *sandbox, const char *folder)
{
    const int most = (int)(sizeof sandbox->roots / sizeof sandbox->roots[0]);
    if (sandbox->root_count == most) {
        return IO_TOO_LARGE;
    }
    char real[PATH_MAX];
    if (!realpath(folder, real)) {
        return errno == ELOOP ? IO_NOT_FOUND : io_error_from_errno(errno);
    }
    int fd = open(real, O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) {
        return errno == ENOTDIR ? IO_NOT_REGULAR : io_error_from_errno(errno);
    }
    IoError error = IO_NO_MEMORY;
    char *given = absolute_path(folder, &error), *path = mem_alloc(strlen(real) + 1, 1);
    if (!given || !path) {
        mem_free(given);
        mem_free(path);
        close(fd);
        return given ? IO_NO_MEMORY : error;
    }
    memcpy(path, real, strlen(real) + 1);
    sandbox->roots[sandbox->root_count++] = (struct SandboxRoot){fd, path, given};
    return IO_OK;
}

IoError sandbox_resolve(const Sandbox *sandbox, Arena *arena, const char *from, Str path,
                        const char **out)
{
    *out = NULL;
    if (path.length >= PATH_MAX || memchr(path.at, '\0', path.length)) {
        return IO_NOT_FOUND;
    }
    const char *folder = "";
    size_t folder_length = 0;
    if (path.length == 0 || path.at[0] != '/') {
        if (from) {
            const char *slash = strrchr(from, '/');
            folder = from;
            folder_length = slash ? (size_t)(slash - from) : 0;
        } else if (sandbox->root_count > 0) {
            folder = sandbox->roots[0].path;
            folder_length = strlen(folder);
        }
    }
    char *whole = arena_alloc(arena, folder_length + path.length + 2);
    if (!whole) {
        return IO_NO_MEMORY;
    }
    memcpy(whole, folder, folder_length);
    whole[folder_length] = '/';
    memcpy(whole + folder_length + 1, path.at, path.length);
    normalize(whole, folder_length + 1 + path.length, whole);
    for (int i = 0; i < sandbox->root_count; ++i) {
        if (below_root(&sandbox->roots[i], whole)) {
            *out = whole;
            return IO_OK;
        }
    }
    *out = sandbox->allow_all ? whole : NULL;
    return sandbox->allow_all ? IO_OK : IO_OUTSIDE;
}

// --- Opening -------------------------------------------------------------------------------------

// Kernels before 5.6, and filters of system calls, have no openat2: opens part by part, following
// no link. -1 with errno; ELOOP where there is a link.
static int open_walking(int folder, const char *path)
{
    char part[NAME_MAX + 1];
    int at = folder;
    for (;;) {
        size_t length = strcspn(path, "/");
        if (length > NAME_MAX) {
            errno = ENAMETOOLONG;
            break;
        }
        memcpy(part, path, length);
        part[length] = '\0';
        path += length;
        while (*path == '/') {
            ++path;
        }
        struct stat info;
        if (strcmp(part, "..") == 0) {
            errno = EXDEV;
            break;
        }
        if (fstatat(at, part, &info, AT_SYMLINK_NOFOLLOW) != 0) {
            break;
        }
        if (S_ISLNK(info.st_mode)) {
            errno = ELOOP;
            break;
        }
        bool last = *path == '\0';
        int next =
            openat(at, part, O_NOFOLLOW | (last ? READ_FLAGS : O_PATH | O_DIRECTORY | O_CLOEXEC));
        int code = errno;
        if (at != folder) {
            close(at);
        }
        errno = code;
        if (next < 0 || last) {
            return next;
        }
        at = next;
    }
    int code = errno;
    if (at != folder) {
        close(at);
    }
    errno = code;
    return -1;
}

static int open_beneath(int folder, const char *path)
{
    struct open_how how = {.flags = READ_FLAGS, .resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS};
    long fd;
    int tries = 0;
    do { // EAGAIN: something was renamed while the kernel was looking
        fd = syscall(SYS_openat2, folder, path, &how, sizeof how);
    } while (fd < 0 && (errno == EINTR || errno == EAGAIN) && ++tries < 32);
    if (fd < 0 && (errno == ENOSYS || errno == EPERM)) {
        return open_walking(folder, path);
    }
    return (int)fd;
}

// Opens `path` below the first root that it lies in by name. -1 with errno; EXDEV where none does.
static int open_in_roots(const Sandbox *sandbox, const char *path)
{
    errno = EXDEV;
    int fd = -1;
    for (int i = 0; i < sandbox->root_count && fd < 0; ++i) {
        const char *rest = below_root(&sandbox->roots[i], path);
        if (rest) {
            fd = open_beneath(sandbox->roots[i].fd, rest);
        }
    }
    return fd;
}

static int open_allowed(const Sandbox *sandbox, const char *path)
{
    if (sandbox->allow_all) {
        return open(path, READ_FLAGS);
    }
    int fd = open_in_roots(sandbox, path);
    if (fd < 0 && (errno == EXDEV || errno == ELOOP)) {
        // A link that leads out of its folder may lead to another place that is allowed. What the
        // names say here is only a guess: opening checks it again.
        int code = errno;
        char real[PATH_MAX];
        fd = realpath(path, real) ? open_in_roots(sandbox, real) : -1;
        if (fd < 0 && errno != EACCES) {
            errno = code;
        }
    }
    return fd;
}

IoError sandbox_open(const Sandbox *sandbox, const char *path, int *fd, uint64_t *size)
{
    *size = 0;
    if (sandbox->on_open) {
        sandbox->on_open(sandbox->on_open_context, path);
    }
    *fd = open_allowed(sandbox, path);
    if (*fd < 0) {
        return io_error_from_errno(errno);
    }
    struct stat info;
    IoError error = IO_OK;
    if (fstat(*fd, &info) != 0) {
        error = IO_FAILED;
    } else if (!S_ISREG(info.st_mode)) {
        error = IO_NOT_REGULAR;
    } else if ((uint64_t)info.st_size > sandbox->max_file_bytes) {
        error = IO_TOO_LARGE;
    }
    if (error != IO_OK) {
        close(*fd);
        *fd = -1;
        return error;
    }
    *size = (uint64_t)info.st_size;
    return IO_OK;
}

bool sandbox_has(const Sandbox *sandbox, const char *path)
{
    int fd;
    uint64_t size;
    const bool found = sandbox_open(sandbox, path, &fd, &size) == IO_OK;
    if (found) {
        close(fd);
    }
    return found;
}
