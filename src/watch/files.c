#include "watch/files.h"

#include "base/array.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum {
    SLOW_POLL = 1000, // ms between looks beside inotify
    FAST_POLL = 250,  // and without it
    SETTLE = 60,      // ms that a missing or empty file is given to come back
    MOST_FILES = 4096,
    EVENTS = IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_CREATE | IN_DELETE | IN_ATTRIB,
};

// What tells one state of a file from another.
typedef struct FileState {
    bool there;
    dev_t device;
    ino_t inode;
    off_t size;
    struct timespec modified, changed;
} FileState;

typedef struct WatchedFile {
    char *path;
    FileState state;
} WatchedFile;

struct FileWatch {
    void (*changed)(void *context);
    void *context;
    int notify, wake; // inotify's descriptor, or -1; an eventfd
    pthread_t thread;
    bool started;
    pthread_mutex_t lock; // of what follows
    ARRAY(WatchedFile) files;
    bool closing, told; // told: changed() was called since file_watch_begin
};

// --- States --------------------------------------------------------------------------------------

static FileState state_of(const char *path)
{
    struct stat info;
    if (stat(path, &info) != 0) {
        return (FileState){.there = false};
    }
    return (FileState){true, info.st_dev, info.st_ino, info.st_size, info.st_mtim, info.st_ctim};
}

static bool same_time(struct timespec a, struct timespec b)
{
    return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

static bool same_state(const FileState *a, const FileState *b)
{
    return a->there == b->there &&
           (!a->there ||
            (a->device == b->device && a->inode == b->inode && a->size == b->size &&
             same_time(a->modified, b->modified) && same_time(a->changed, b->changed)));
}

typedef enum Finding { UNCHANGED, CHANGED, UNSETTLED } Finding;

// UNSETTLED: a file is missing or empty that wasn't, as between an editor's two steps of saving.
static Finding look(FileWatch *watch)
{
    Finding finding = UNCHANGED;
    pthread_mutex_lock(&watch->lock);
    for (size_t i = 0; !watch->told && finding != UNSETTLED && i < watch->files.count; ++i) {
        const WatchedFile *file = &watch->files.items[i];
        FileState now = state_of(file->path);
        if (!same_state(&file->state, &now)) {
            bool gone =
                file->state.there && (!now.there || (now.size == 0 && file->state.size > 0));
            finding = gone ? UNSETTLED : CHANGED;
        }
    }
    pthread_mutex_unlock(&watch->lock);
    return finding;
}

static void tell(FileWatch *watch)
{
    pthread_mutex_lock(&watch->lock);
    bool tell_now = !watch->told && !watch->closing;
    watch->told = true;
    pthread_mutex_unlock(&watch->lock);
    if (tell_now) {
        watch->changed(watch->context);
    }
}

// --- The thread ----------------------------------------------------------------------------------

static void drain(int fd)
{
    char buffer[4096];
    while (read(fd, buffer, sizeof buffer) > 0) {
    }
}

static bool is_closing(FileWatch *watch)
{
    pthread_mutex_lock(&watch->lock);
    bool closing = watch->closing;
    pthread_mutex_unlock(&watch->lock);
    return closing;
}

static void *watch_files(void *context)
{
    FileWatch *watch = context;
    struct pollfd fds[2] = {{watch->wake, POLLIN, 0}, {watch->notify, POLLIN, 0}};
    while (!is_closing(watch)) {
        poll(fds, 2, watch->notify >= 0 ? SLOW_POLL : FAST_POLL);
        drain(watch->wake);
        if (watch->notify >= 0) {
            drain(watch->notify);
        }
        Finding finding = look(watch);
        if (finding == UNSETTLED) {
            poll(fds, 1, SETTLE);
            finding = look(watch);
        }
        if (finding != UNCHANGED) {
            tell(watch);
        }
    }
    return NULL;
}

FileWatch *file_watch_new(void (*changed)(void *context), void *context, bool polling)
{
    FileWatch *watch = mem_alloc_zeroed(1, sizeof *watch);
    if (!watch) {
        return NULL;
    }
    watch->changed = changed;
    watch->context = context;
    watch->told = true; // until file_watch_begin
    pthread_mutex_init(&watch->lock, NULL);
    watch->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    watch->notify = polling ? -1 : inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    watch->started =
        watch->wake >= 0 && pthread_create(&watch->thread, NULL, watch_files, watch) == 0;
    if (!watch->started) {
        file_watch_free(watch);
        return NULL;
    }
    return watch;
}

static void forget_files(FileWatch *watch)
{
    for (size_t i = 0; i < watch->files.count; ++i) {
        mem_free(watch->files.items[i].path);
    }
    watch->files.count = 0;
}

void file_watch_free(FileWatch *watch)
{
    if (!watch) {
        return;
    }
    if (watch->started) {
        pthread_mutex_lock(&watch->lock);
        watch->closing = true;
        pthread_mutex_unlock(&watch->lock);
        (void)!write(watch->wake, &(uint64_t){1}, sizeof(uint64_t));
        pthread_join(watch->thread, NULL);
    }
    if (watch->wake >= 0) {
        close(watch->wake);
    }
    if (watch->notify >= 0) {
        close(watch->notify);
    }
    forget_files(watch);
    array_free(&watch->files);
    pthread_mutex_destroy(&watch->lock);
    mem_free(watch);
}

// --- The files -----------------------------------------------------------------------------------

void file_watch_begin(FileWatch *watch)
{
    pthread_mutex_lock(&watch->lock);
    forget_files(watch);
    watch->told = false;
    pthread_mutex_unlock(&watch->lock);
}

static bool is_known(const FileWatch *watch, const char *path)
{
    for (size_t i = 0; i < watch->files.count; ++i) {
        if (strcmp(watch->files.items[i].path, path) == 0) {
            return true;
        }
    }
    return false;
}

// Asks inotify for the file's folder: a file that is replaced has another inode, its name stays.
// Asking again for a folder changes nothing.
static void notify_of(const FileWatch *watch, const char *path, char *folder)
{
    const char *slash = strrchr(path, '/');
    size_t length = !slash ? 0 : slash == path ? 1 : (size_t)(slash - path);
    memcpy(folder, length ? path : ".", length ? length : 1);
    folder[length ? length : 1] = '\0';
    if (watch->notify >= 0) {
        inotify_add_watch(watch->notify, folder, EVENTS | IN_ONLYDIR);
    }
}

void file_watch_add(FileWatch *watch, const char *path)
{
    size_t size = strlen(path) + 1;
    char *copy = mem_alloc(size, 1), *folder = mem_alloc(size + 1, 1);
    if (copy && folder) {
        memcpy(copy, path, size);
        pthread_mutex_lock(&watch->lock);
        if (watch->files.count < MOST_FILES && !is_known(watch, path)) {
            notify_of(watch, path, folder);
            WatchedFile file = {copy, state_of(path)};
            copy = array_push(&watch->files, file) ? NULL : copy;
        }
        pthread_mutex_unlock(&watch->lock);
    }
    mem_free(copy);
    mem_free(folder);
}
