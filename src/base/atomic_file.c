#include "base/io.h"

#include "base/hash.h"
#include "base/mem.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { MOST_LINKS = 40, MOST_TRIES = 100, MOST_SHOWN = 160 };

// Names being built: a path never exceeds PATH_MAX, else the kernel would not take it.
typedef struct PathBuffer {
    char at[PATH_MAX];
} PathBuffer;

// The reason must fit the message, whatever the name's length.
static bool refuse(char *error, size_t error_size, const char *path, const char *why)
{
    int shown = strlen(path) > MOST_SHOWN ? MOST_SHOWN : (int)strlen(path);
    snprintf(error, error_size, "can't write `%.*s%s`: %s", shown, path, path[shown] ? "..." : "",
             why);
    return false;
}

static size_t folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

// The file that `path` stands for, links followed, whether or not there is one yet.
static bool follow_links(const char *path, PathBuffer *out)
{
    if (strlen(path) >= sizeof out->at) {
        errno = ENAMETOOLONG;
        return false;
    }
    memcpy(out->at, path, strlen(path) + 1);
    for (int links = 0; links < MOST_LINKS; ++links) {
        char target[PATH_MAX];
        ssize_t length = readlink(out->at, target, sizeof target);
        if (length < 0) {
            return errno == EINVAL || errno == ENOENT; // no link
        }
        size_t keep = target[0] == '/' ? 0 : folder_length(out->at);
        if (keep + (size_t)length >= sizeof out->at) {
            errno = ENAMETOOLONG;
            return false;
        }
        memcpy(out->at + keep, target, (size_t)length);
        out->at[keep + (size_t)length] = '\0';
    }
    errno = ELOOP;
    return false;
}

// Fills *target with the file to be replaced. False with a message where it can't be.
static bool find_target(const char *path, PathBuffer *target, char *error, size_t error_size)
{
    if (!*path || !follow_links(path, target)) {
        return refuse(error, error_size, path, strerror(*path ? errno : ENOENT));
    }
    struct stat info;
    if (stat(target->at, &info) != 0) {
        return errno == ENOENT || refuse(error, error_size, path, strerror(errno));
    }
    if (S_ISDIR(info.st_mode)) {
        return refuse(error, error_size, path, strerror(EISDIR));
    }
    if (!S_ISREG(info.st_mode)) {
        return refuse(error, error_size, path, "it is not a regular file");
    }
    return true;
}

// Names beside the target: hidden, unlike each other, ending in .tmp. As much of the target's name
// is kept as fits.
static bool temporary_beside(const char *target, unsigned attempt, PathBuffer *out)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    uint64_t tag = hash_u64((uint64_t)now.tv_nsec ^ (uint64_t)now.tv_sec << 30 ^
                            (uint64_t)getpid() << 44 ^ attempt);
    size_t folder = folder_length(target), name = strlen(target + folder);
    if (name > NAME_MAX - 16) {
        name = NAME_MAX - 16;
    }
    int length = snprintf(out->at, sizeof out->at, "%.*s.%.*s.%08x.tmp", (int)folder, target,
                          (int)name, target + folder, (unsigned)(tag >> 32));
    if (length < 0 || (size_t)length >= sizeof out->at) {
        errno = ENAMETOOLONG;
        return false;
    }
    return true;
}

// Creates the temporary file; its descriptor, or -1 with a message.
static int create_temporary(const char *path, PathBuffer *target, PathBuffer *temporary,
                            char *error, size_t error_size)
{
    if (!find_target(path, target, error, error_size)) {
        return -1;
    }
    for (unsigned attempt = 0; attempt < MOST_TRIES; ++attempt) {
        if (!temporary_beside(target->at, attempt, temporary)) {
            break;
        }
        int fd = open(temporary->at, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (fd >= 0) {
            return fd;
        }
        if (errno != EEXIST) {
            break;
        }
    }
    refuse(error, error_size, path, strerror(errno));
    return -1;
}

// Has the name itself survive a power cut. Not every file system can; then nothing is lost but
// this.
static void flush_folder(const char *path)
{
    PathBuffer folder = {"."};
    size_t length = folder_length(path);
    if (length > 0) {
        memcpy(folder.at, path, length);
        folder.at[length] = '\0';
    }
    int fd = open(folder.at, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
}

// Gives a file that was opened without a name the one at which it is renamed.
static bool name_it(int fd, const char *name)
{
    char link[32];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    return linkat(AT_FDCWD, link, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0;
}

// Gives the file the permissions of the one that it replaces, flushes and renames it. Closes fd.
static bool commit(int fd, bool nameless, const char *temporary, const char *target,
                   const char *path, char *error, size_t error_size)
{
    struct stat old;
    if (stat(target, &old) == 0 && S_ISREG(old.st_mode)) {
        (void)!fchmod(fd, old.st_mode & 0777); // on file systems without permissions it can't
    }
    // EINVAL, ENOTSUP: nothing here can be flushed, and that is no fault of the file's.
    bool good = fsync(fd) == 0 || errno == EINVAL || errno == ENOTSUP;
    int code = errno;
    if (good && nameless && !name_it(fd, temporary)) {
        good = false;
        code = errno;
    }
    if (close(fd) != 0 && good) {
        good = false;
        code = errno;
    }
    if (good && rename(temporary, target) != 0) {
        good = false;
        code = errno;
    }
    if (!good) {
        unlink(temporary);
        return refuse(error, error_size, path, strerror(code));
    }
    flush_folder(target);
    return true;
}

// --- With a stream -------------------------------------------------------------------------------

// A file without a name, in the folder where it shall have one: a program that is killed while it
// writes leaves nothing behind. -1 where the file system, or a missing /proc, doesn't allow it.
static int open_nameless(const char *target)
{
    PathBuffer folder = {"."};
    size_t length = folder_length(target);
    if (length > 0) {
        memcpy(folder.at, target, length);
        folder.at[length] = '\0';
    }
    if (access("/proc/self/fd", X_OK) != 0) {
        return -1;
    }
    return open(folder.at, O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
}

static char *copy(const char *text)
{
    size_t size = strlen(text) + 1;
    char *copied = mem_alloc(size, 1);
    if (copied) {
        memcpy(copied, text, size);
    }
    return copied;
}

static void forget(AtomicFile *file)
{
    mem_free(file->path);
    mem_free(file->temporary);
    *file = (AtomicFile){0};
}

bool atomic_file_open(AtomicFile *file, const char *path, char *error, size_t error_size)
{
    *file = (AtomicFile){0};
    PathBuffer target, temporary;
    if (!find_target(path, &target, error, error_size)) {
        return false;
    }
    int fd = temporary_beside(target.at, 0, &temporary) ? open_nameless(target.at) : -1;
    file->nameless = fd >= 0;
    if (fd < 0) {
        fd = create_temporary(path, &target, &temporary, error, error_size);
    }
    if (fd < 0) {
        return false;
    }
    file->path = copy(target.at);
    file->temporary = copy(temporary.at);
    file->stream = file->path && file->temporary ? fdopen(fd, "w+") : NULL;
    if (!file->stream) {
        close(fd);
        unlink(temporary.at);
        forget(file);
        return refuse(error, error_size, path, strerror(ENOMEM));
    }
    return true;
}

bool atomic_file_commit(AtomicFile *file, char *error, size_t error_size)
{
    bool failed = ferror(file->stream) != 0; // of an earlier write, whose errno is gone
    errno = 0;
    if (fflush(file->stream) != 0 || failed) {
        int code = errno ? errno : EIO;
        refuse(error, error_size, file->path, strerror(code));
        atomic_file_abandon(file);
        return false;
    }
    int fd = dup(fileno(file->stream)); // fclose would close it before it is flushed
    int code = errno;
    fclose(file->stream);
    file->stream = NULL;
    bool good;
    if (fd < 0) {
        unlink(file->temporary);
        good = refuse(error, error_size, file->path, strerror(code));
    } else {
        good =
            commit(fd, file->nameless, file->temporary, file->path, file->path, error, error_size);
    }
    forget(file);
    return good;
}

void atomic_file_abandon(AtomicFile *file)
{
    if (file->stream) {
        fclose(file->stream);
    }
    if (file->temporary) {
        unlink(file->temporary); // nothing, where it has no name yet
    }
    forget(file);
}

// --- With a name ---------------------------------------------------------------------------------

char *atomic_temporary_name(Arena *arena, const char *path, char *error, size_t error_size)
{
    PathBuffer target, temporary;
    int fd = create_temporary(path, &target, &temporary, error, error_size);
    if (fd < 0) {
        return NULL;
    }
    close(fd);
    char *name = arena_copy_string(arena, temporary.at, strlen(temporary.at));
    if (!name) {
        unlink(temporary.at);
        refuse(error, error_size, path, strerror(ENOMEM));
    }
    return name;
}

bool atomic_rename(const char *temporary, const char *path, char *error, size_t error_size)
{
    PathBuffer target;
    if (!find_target(path, &target, error, error_size)) {
        unlink(temporary);
        return false;
    }
    int fd = open(temporary, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0) {
        int code = errno;
        unlink(temporary);
        return refuse(error, error_size, path, strerror(code));
    }
    return commit(fd, false, temporary, target.at, path, error, error_size);
}

void atomic_discard(const char *temporary)
{
    unlink(temporary);
}
