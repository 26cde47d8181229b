// Starts a program, sends it a signal when it has worked for a while, and tells how long it then
// went on:
//     stop_check SIGNAL DELAY_MS PROGRAM ARGUMENTS…
// prints "STATUS WALL_SECONDS CPU_SECONDS", with a shell's status. The delay is CPU time (of all
// its threads), so that the signal comes in the same phase on a busy machine.
#include <math.h>
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

// Seconds of CPU time that a running process has used.
static double used(pid_t pid)
{
    clockid_t clock;
    struct timespec t = {0};
    if (clock_getcpuclockid(pid, &clock) == 0) {
        clock_gettime(clock, &t);
    }
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void wait_until_used(pid_t pid, double seconds)
{
    const struct timespec step = {0, 500000};
    siginfo_t info = {0};
    while (used(pid) < seconds &&
           waitid(P_PID, (id_t)pid, &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0) {
        nanosleep(&step, NULL);
    }
}

static double seconds_of(struct timeval t)
{
    return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}

int main(int argc, char **argv)
{
    if (argc < 4) {
        return 2;
    }
    const pid_t pid = fork();
    if (pid < 0) {
        return 2;
    }
    if (pid == 0) {
        signal(SIGINT, SIG_DFL); // shells start background jobs with it ignored
        execvp(argv[3], argv + 3);
        _exit(127);
    }
    wait_until_used(pid, 1e-3 * (double)strtol(argv[2], NULL, 10));
    const double before = used(pid), began = now();
    kill(pid, atoi(argv[1]));
    int status;
    struct rusage usage;
    if (wait4(pid, &status, 0, &usage) != pid) {
        return 2;
    }
    const double cpu = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime) - before;
    printf("%d %.3f %.3f\n", WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status),
           now() - began, fmax(cpu, 0));
    return 0;
}
