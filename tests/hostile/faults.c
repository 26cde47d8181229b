#include "faults.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { MOST_CALLS = 6, SECONDS = 120 };

const char *fault_preload;

// The system calls of a kind, ended by -1, and the error that they give.
typedef struct KindInfo {
    int calls[MOST_CALLS];
    int error;
} KindInfo;

static const KindInfo infos[] = {
    [FAULT_NONE] = {{-1}, 0},
    [FAULT_ALLOCATION] = {{-1}, 0},
    [FAULT_PAGES] = {{__NR_mmap, __NR_mremap, -1}, ENOMEM},
    [FAULT_THREAD] = {{__NR_clone, __NR_clone3, -1}, EAGAIN},
    [FAULT_OPEN] = {{-1}, EMFILE}, // openat and openat2 are always looked at
    [FAULT_READ] = {{__NR_read, __NR_pread64, -1}, EIO},
    [FAULT_WRITE] = {{__NR_write, __NR_pwrite64, __NR_writev, -1}, ENOSPC},
    [FAULT_FLUSH] = {{__NR_fsync, __NR_fdatasync, -1}, EIO},
#ifdef __NR_rename
    [FAULT_RENAME] = {{__NR_rename, __NR_renameat, __NR_renameat2, -1}, EACCES},
#else
    [FAULT_RENAME] = {{__NR_renameat, __NR_renameat2, -1}, EACCES},
#endif
    [FAULT_LINK] = {{__NR_linkat, -1}, EPERM},
    [FAULT_CLOSE] = {{__NR_close, -1}, EIO},
};

// --- The child -----------------------------------------------------------------------------------

static int install_filter(const KindInfo *info)
{
    struct sock_filter code[MOST_CALLS + 6];
    unsigned short length = 0, calls = 0;
    while (info->calls[calls] >= 0) {
        ++calls;
    }
    code[length++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS,
                                                  (unsigned)offsetof(struct seccomp_data, nr));
    for (unsigned short i = 0; i < calls; ++i) {
        code[length++] = (struct sock_filter)BPF_JUMP(
            BPF_JMP | BPF_JEQ | BPF_K, (unsigned)info->calls[i], (unsigned char)(calls - i + 2), 0);
    }
    code[length++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_openat2, 2, 0);
    code[length++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_openat, 1, 0);
    code[length++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    code[length++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_USER_NOTIF);
    struct sock_fprog program = {length, code};
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) {
        return -1;
    }
    return (int)syscall(__NR_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_NEW_LISTENER,
                        &program);
}

static void send_fd(int to, int fd)
{
    char space[CMSG_SPACE(sizeof fd)] = {0}, byte = fd >= 0;
    struct iovec text = {&byte, 1};
    struct msghdr message = {.msg_iov = &text, .msg_iovlen = 1};
    if (fd >= 0) {
        message.msg_control = space;
        message.msg_controllen = sizeof space;
        struct cmsghdr *head = CMSG_FIRSTHDR(&message);
        head->cmsg_level = SOL_SOCKET;
        head->cmsg_type = SCM_RIGHTS;
        head->cmsg_len = CMSG_LEN(sizeof fd);
        memcpy(CMSG_DATA(head), &fd, sizeof fd);
    }
    (void)!sendmsg(to, &message, 0);
}

static int receive_fd(int from)
{
    int fd = -1;
    char space[CMSG_SPACE(sizeof fd)] = {0}, byte;
    struct iovec text = {&byte, 1};
    struct msghdr message = {
        .msg_iov = &text, .msg_iovlen = 1, .msg_control = space, .msg_controllen = sizeof space};
    if (recvmsg(from, &message, MSG_CMSG_CLOEXEC) > 0 && CMSG_FIRSTHDR(&message)) {
        memcpy(&fd, CMSG_DATA(CMSG_FIRSTHDR(&message)), sizeof fd);
    }
    return fd;
}

typedef struct Child {
    const char *const *command;
    const char *folder;
    FaultKind kind;
    uint64_t at;
    bool goes_on;
    int errors, report, socket;
} Child;

static _Noreturn void become(const Child *child)
{
    int nothing = open("/dev/null", O_RDONLY);
    int output = open("/dev/null", O_WRONLY);
    dup2(nothing, STDIN_FILENO);
    dup2(output, STDOUT_FILENO);
    dup2(child->errors, STDERR_FILENO);
    if (child->kind == FAULT_ALLOCATION) {
        char at[32], report[32];
        snprintf(at, sizeof at, "%llu", (unsigned long long)child->at);
        snprintf(report, sizeof report, "%d", child->report);
        setenv("FAULT_AT", at, 1);
        setenv("FAULT_ON", child->goes_on ? "1" : "0", 1);
        setenv("FAULT_FD", report, 1);
        setenv("LD_PRELOAD", fault_preload, 1);
    }
    if (child->folder && chdir(child->folder) != 0) {
        _exit(126);
    }
    if (child->kind > FAULT_ALLOCATION) {
        int listener = install_filter(&infos[child->kind]);
        send_fd(child->socket, listener);
        if (listener < 0) {
            _exit(126);
        }
    }
    execv(child->command[0], (char *const *)(size_t)child->command);
    _exit(127);
}

// --- The parent ----------------------------------------------------------------------------------

typedef struct Watch {
    FaultKind kind;
    uint64_t at, count;
    bool goes_on, started; // started: the scene has been opened
} Watch;

static void read_path(pid_t task, uint64_t address, char *out, size_t size)
{
    struct iovec here = {out, size - 1}, there = {(void *)(size_t)address, size - 1};
    ssize_t got = process_vm_readv(task, &here, 1, &there, 1, 0);
    if (got < 0) { // it may end before the page does
        here.iov_len = there.iov_len =
            4096 - address % 4096 < size ? 4096 - address % 4096 : size - 1;
        got = process_vm_readv(task, &here, 1, &there, 1, 0);
    }
    out[got > 0 ? got : 0] = '\0';
}

static bool ends_with(const char *text, const char *end)
{
    size_t length = strlen(text), wanted = strlen(end);
    return length >= wanted && strcmp(text + length - wanted, end) == 0;
}

// A regular file, named or not; for a write, the standard output as well.
static bool is_file(const struct seccomp_notif *call, bool output)
{
    char link[64];
    struct stat info;
    int fd = (int)call->data.args[0];
    if (fd <= STDERR_FILENO) {
        return output && fd == STDOUT_FILENO;
    }
    snprintf(link, sizeof link, "/proc/%d/fd/%d", (int)call->pid, fd);
    return stat(link, &info) == 0 && S_ISREG(info.st_mode);
}

static bool is_written(const struct seccomp_notif *call)
{
    char link[64];
    struct stat info;
    snprintf(link, sizeof link, "/proc/%d/fd/%d", (int)call->pid, (int)call->data.args[0]);
    return is_file(call, false) && lstat(link, &info) == 0 && (info.st_mode & 0200);
}

static bool is_of_kind(const Watch *watch, const struct seccomp_notif *call)
{
    const int nr = call->data.nr;
    if (nr == __NR_openat || nr == __NR_openat2) {
        return watch->kind == FAULT_OPEN;
    }
    switch (watch->kind) {
    case FAULT_PAGES: // mmap of a file is no allocation
        return nr != __NR_mmap || (int)call->data.args[4] < 0;
    case FAULT_READ:
        return is_file(call, false);
    case FAULT_WRITE:
        return is_file(call, true);
    case FAULT_CLOSE:
        return is_written(call);
    default:
        return true;
    }
}

static bool shall_fail(Watch *watch, const struct seccomp_notif *call)
{
    if (call->data.nr == __NR_openat && !watch->started) {
        char path[4096];
        read_path((pid_t)call->pid, call->data.args[1], path, sizeof path);
        watch->started = ends_with(path, "scene.scn");
    }
    if (call->data.nr == __NR_openat2) {
        watch->started = true;
    }
    if (!watch->started || !is_of_kind(watch, call)) {
        return false;
    }
    ++watch->count;
    return watch->at && (watch->goes_on ? watch->count >= watch->at : watch->count == watch->at);
}

static void answer(Watch *watch, int listener)
{
    struct seccomp_notif call;
    memset(&call, 0, sizeof call);
    if (ioctl(listener, SECCOMP_IOCTL_NOTIF_RECV, &call) != 0) {
        return;
    }
    struct seccomp_notif_resp reply = {.id = call.id};
    if (shall_fail(watch, &call)) {
        reply.error = -infos[watch->kind].error;
    } else {
        reply.flags = SECCOMP_USER_NOTIF_FLAG_CONTINUE;
    }
    (void)ioctl(listener, SECCOMP_IOCTL_NOTIF_SEND, &reply);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// Until standard error is closed, which is when the program has ended.
static bool watch_program(Watch *watch, int errors, int listener, FaultRun *out)
{
    size_t length = 0;
    const double until = now() + SECONDS;
    for (;;) {
        struct pollfd waiting[2] = {{errors, POLLIN, 0}, {listener, POLLIN, 0}};
        if (poll(waiting, listener >= 0 ? 2 : 1, 1000) < 0 || now() > until) {
            return false;
        }
        if (waiting[1].revents & POLLIN) {
            answer(watch, listener);
        } else if (waiting[1].revents) {
            listener = -1;
        }
        if (!waiting[0].revents) {
            continue;
        }
        char more[4096];
        ssize_t got = read(errors, more, sizeof more);
        if (got <= 0) {
            return true;
        }
        size_t room = sizeof out->errors - 1 - length;
        size_t kept = (size_t)got < room ? (size_t)got : room;
        memcpy(out->errors + length, more, kept);
        length += kept;
        out->errors[length] = '\0';
    }
}

static void read_report(int fd, FaultRun *out)
{
    char text[64] = "";
    unsigned long long count, live;
    ssize_t got = read(fd, text, sizeof text - 1);
    out->live = -1;
    if (got > 0 && sscanf(text, "%llu %llu", &count, &live) == 2) {
        out->count = count;
        out->live = (int64_t)live;
    }
}

bool fault_run(const char *const *command, const char *folder, FaultKind kind, uint64_t at,
               bool goes_on, FaultRun *out)
{
    *out = (FaultRun){.status = 127};
    int errors[2], report[2], sockets[2];
    if (pipe2(errors, O_CLOEXEC) != 0 || pipe(report) != 0 ||
        socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets) != 0) {
        perror("pipe");
        exit(2);
    }
    fcntl(report[0], F_SETFD, FD_CLOEXEC);
    Child child = {command, folder, kind, at, goes_on, errors[1], report[1], sockets[1]};
    pid_t pid = fork();
    if (pid == 0) {
        become(&child);
    }
    close(errors[1]);
    close(report[1]);
    close(sockets[1]);
    const bool filters = kind > FAULT_ALLOCATION;
    int listener = filters ? receive_fd(sockets[0]) : -1;
    Watch watch = {.kind = kind, .at = at, .goes_on = goes_on};
    if (!watch_program(&watch, errors[0], listener, out)) {
        kill(pid, SIGKILL);
    }
    int status;
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
    }
    out->status = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    out->count = watch.count;
    if (kind == FAULT_ALLOCATION) {
        read_report(report[0], out);
    }
    close(errors[0]);
    close(report[0]);
    close(sockets[0]);
    if (listener >= 0) {
        close(listener);
    }
    return !filters || listener >= 0;
}
