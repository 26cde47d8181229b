#include "base/thread.h"

#include "base/mem.h"

#include <limits.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_THREADS = 4096 };

// --- Processors ----------------------------------------------------------------------------------

static unsigned affinity_count(void)
{
    for (int most = 1024; most <= 1 << 20; most *= 4) { // more processors than `most`: EINVAL
        cpu_set_t *set = CPU_ALLOC((size_t)most);
        if (!set) {
            break;
        }
        size_t size = CPU_ALLOC_SIZE((size_t)most);
        int count = sched_getaffinity(0, size, set) == 0 ? CPU_COUNT_S(size, set) : 0;
        CPU_FREE(set);
        if (count > 0) {
            return (unsigned)count;
        }
    }
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 ? (unsigned)online : 1;
}

// Reads "quota period" (v2: one file, "max" for none) into *processors, rounded up.
static void apply_quota(double quota, double period, unsigned *processors)
{
    if (quota > 0 && period > 0) {
        double allowed = quota / period;
        unsigned whole = allowed < *processors ? (unsigned)allowed : *processors;
        if ((double)whole < allowed && whole < *processors) {
            ++whole;
        }
        *processors = whole > 0 ? whole : 1;
    }
}

static bool read_numbers(const char *path, const char *format, double *first, double *second)
{
    FILE *file = fopen(path, "re");
    if (!file) {
        return false;
    }
    int read = second ? fscanf(file, format, first, second) : fscanf(file, format, first);
    fclose(file);
    return read == (second ? 2 : 1);
}

static void quota_of_folder(const char *folder, bool v2, unsigned *processors)
{
    char path[PATH_MAX + 64];
    double quota = 0, period = 0;
    if (v2) {
        snprintf(path, sizeof path, "%s/cpu.max", folder);
        if (read_numbers(path, "%lf %lf", &quota, &period)) {
            apply_quota(quota, period, processors);
        }
        return;
    }
    snprintf(path, sizeof path, "%s/cpu.cfs_quota_us", folder);
    bool has_quota = read_numbers(path, "%lf", &quota, NULL);
    snprintf(path, sizeof path, "%s/cpu.cfs_period_us", folder);
    if (has_quota && read_numbers(path, "%lf", &period, NULL)) {
        apply_quota(quota, period, processors);
    }
}

// The quotas of a group and of all groups around it. In a container the group's name is often the
// host's and isn't there; its own group is then the root of the mount.
static void quota_of_group(const char *mount, const char *group, bool v2, unsigned *processors)
{
    char folder[PATH_MAX];
    int length = snprintf(folder, sizeof folder, "%s%s", mount, group);
    if (length < 0 || (size_t)length >= sizeof folder) {
        return;
    }
    size_t shortest = strlen(mount);
    while (strlen(folder) > shortest) {
        quota_of_folder(folder, v2, processors);
        *strrchr(folder, '/') = '\0';
    }
    quota_of_folder(mount, v2, processors);
}

static void apply_cgroups(unsigned *processors)
{
    FILE *file = fopen("/proc/self/cgroup", "re");
    if (!file) {
        return;
    }
    char line[PATH_MAX + 64];
    while (fgets(line, sizeof line, file)) { // "number:controllers:/group"
        line[strcspn(line, "\n")] = '\0';
        char *controllers = strchr(line, ':');
        char *group = controllers ? strchr(controllers + 1, ':') : NULL;
        if (!group || group[1] != '/') {
            continue;
        }
        *group++ = '\0';
        ++controllers;
        if (*controllers == '\0') {
            quota_of_group("/sys/fs/cgroup", group, true, processors);
        } else if (strcmp(controllers, "cpu") == 0 || strncmp(controllers, "cpu,", 4) == 0 ||
                   strstr(controllers, ",cpu,") ||
                   (strlen(controllers) > 4 &&
                    strcmp(controllers + strlen(controllers) - 4, ",cpu") == 0)) {
            quota_of_group("/sys/fs/cgroup/cpu", group, false, processors);
        }
    }
    fclose(file);
}

unsigned thread_processor_count(void)
{
    unsigned processors = affinity_count();
    apply_cgroups(&processors);
    return processors > 0 ? processors : 1;
}

// --- Threads -------------------------------------------------------------------------------------

bool thread_start(pthread_t *thread, const pthread_attr_t *attributes, void *(*work)(void *),
                  void *argument)
{
    static const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT};
    sigset_t others, before;
    sigfillset(&others);
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i) {
        sigdelset(&others, faults[i]);
    }
    pthread_sigmask(SIG_BLOCK, &others, &before);
    bool started = pthread_create(thread, attributes, work, argument) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return started;
}

// Holds a thread until all have been started.
static void *wait_for_all(void *gate)
{
    pthread_mutex_lock(gate);
    pthread_mutex_unlock(gate);
    return NULL;
}

bool thread_can_start(unsigned count)
{
    enum { MOST_TRIED = 256 };
    pthread_t threads[MOST_TRIED];
    count = count < MOST_TRIED ? count : MOST_TRIED;
    pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER;
    unsigned started = 0;
    pthread_mutex_lock(&gate);
    while (started < count && thread_start(&threads[started], NULL, wait_for_all, &gate)) {
        ++started;
    }
    pthread_mutex_unlock(&gate);
    for (unsigned i = 0; i < started; ++i) {
        pthread_join(threads[i], NULL);
    }
    return started == count;
}

// --- Parallel loops ------------------------------------------------------------------------------

typedef struct Loop {
    uint64_t count;
    _Atomic uint64_t next;
    ParallelWork *work;
    void *context;
    const atomic_int *stop;
} Loop;

typedef struct Worker {
    Loop *loop;
    unsigned number;
    pthread_t thread;
} Worker;

static void run_items(Loop *loop, unsigned worker)
{
    while (!loop->stop || !atomic_load_explicit(loop->stop, memory_order_relaxed)) {
        uint64_t item = atomic_fetch_add_explicit(&loop->next, 1, memory_order_relaxed);
        if (item >= loop->count) {
            break;
        }
        loop->work(loop->context, item, worker);
    }
}

static void *worker_main(void *argument)
{
    const Worker *worker = argument;
    run_items(worker->loop, worker->number);
    return NULL;
}

// Starts workers 1 … wanted - 1 in workers[0 …]; how many it could.
static unsigned start_workers(Loop *loop, Worker *workers, unsigned wanted)
{
    unsigned started = 0;
    while (started + 1 < wanted) {
        Worker *worker = &workers[started];
        worker->loop = loop;
        worker->number = started + 1;
        if (!thread_start(&worker->thread, NULL, worker_main, worker)) {
            break;
        }
        ++started;
    }
    return started;
}

void parallel_for(uint64_t count, unsigned threads, ParallelWork *work, void *context,
                  const atomic_int *stop)
{
    Loop loop = {.count = count, .work = work, .context = context, .stop = stop};
    unsigned wanted = threads < MOST_THREADS ? threads : MOST_THREADS;
    if (wanted > count) {
        wanted = (unsigned)count;
    }
    Worker *workers = wanted > 1 ? mem_alloc(wanted - 1, sizeof *workers) : NULL;
    unsigned started = workers ? start_workers(&loop, workers, wanted) : 0;
    run_items(&loop, 0);
    for (unsigned i = 0; i < started; ++i) {
        pthread_join(workers[i].thread, NULL);
    }
    mem_free(workers);
}
