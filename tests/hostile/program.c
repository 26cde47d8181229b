#include "program.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static _Noreturn void become(const char *program, const char *const *arguments, const char *folder,
                             int errors)
{
    char *list[MOST_ARGUMENTS + 2] = {(char *)(size_t)program};
    for (int i = 0; arguments[i] && i < MOST_ARGUMENTS; ++i) {
        list[i + 1] = (char *)(size_t)arguments[i];
    }
    int nothing = open("/dev/null", O_RDWR);
    dup2(nothing, STDIN_FILENO);
    dup2(nothing, STDOUT_FILENO);
    dup2(errors, STDERR_FILENO);
    if (!folder || chdir(folder) == 0) {
        execv(program, list);
    }
    _exit(127);
}

// Reads standard error to its end; all but the beginning is thrown away. False when time is up.
static bool read_errors(int fd, double until, ProgramRun *out)
{
    size_t length = 0;
    char more[4096];
    for (;;) {
        struct pollfd waiting = {.fd = fd, .events = POLLIN};
        double left = until - now();
        if (left <= 0 || (poll(&waiting, 1, (int)(left * 1000) + 1) == 0)) {
            return false;
        }
        ssize_t got = read(fd, more, sizeof more);
        if (got == 0) {
            break;
        }
        size_t room = sizeof out->errors - 1 - length;
        size_t kept = got > 0 && (size_t)got < room ? (size_t)got : got > 0 ? room : 0;
        memcpy(out->errors + length, more, kept);
        length += kept;
        out->errors[length] = '\0';
    }
    return true;
}

void program_run(const char *program, const char *const *arguments, const char *folder,
                 unsigned seconds, ProgramRun *out)
{
    *out = (ProgramRun){.status = 127};
    int ends[2];
    if (pipe(ends) != 0) {
        perror("pipe");
        exit(2);
    }
    fcntl(ends[0], F_SETFD, FD_CLOEXEC);
    pid_t child = fork();
    if (child == 0) {
        become(program, arguments, folder, ends[1]);
    }
    close(ends[1]);
    if (!read_errors(ends[0], now() + seconds, out)) {
        kill(child, SIGKILL);
    }
    close(ends[0]);
    int status;
    struct rusage usage = {0};
    while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
    }
    out->status = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    out->cpu_seconds = (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
                       1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
    out->peak_kib = usage.ru_maxrss;
}

void program_write(const char *folder, const char *name, const char *bytes, size_t size)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *out = fopen(path, "wb");
    if (!out || fwrite(bytes, 1, size, out) != size || fclose(out) != 0) {
        perror(path);
        exit(2);
    }
}

uint32_t program_random(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*state >> 33);
}

void worst_take(Worst *worst, const ProgramRun *run, const char *name)
{
    if (run->cpu_seconds > worst->seconds) {
        worst->seconds = run->cpu_seconds;
        snprintf(worst->slowest, sizeof worst->slowest, "%s", name);
    }
    if (run->peak_kib > worst->kib) {
        worst->kib = run->peak_kib;
        snprintf(worst->largest, sizeof worst->largest, "%s", name);
    }
}

bool program_takes(int argc, char **argv, unsigned number)
{
    unsigned long every = argc > 3 ? strtoul(argv[3], NULL, 10) : 1;
    return every < 2 || number % every == 0;
}
