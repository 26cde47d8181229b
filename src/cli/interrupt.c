#include "cli/interrupt.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

// As if nobody had caught it, so that a shell sees what happened.
static void end_by(int number)
{
    sigset_t one;
    sigemptyset(&one);
    sigaddset(&one, number);
    signal(number, SIG_DFL);
    pthread_sigmask(SIG_UNBLOCK, &one, NULL);
    kill(getpid(), number);
    pause();
}

// The next signal's number; 0 once the thread is to end. (It isn't cancelled: the sanitizers take
// what a cancelled thread leaves behind for faults.)
static int next_signal(const Interrupt *interrupt)
{
    struct pollfd fds[2] = {{interrupt->signals, POLLIN, 0}, {interrupt->wake, POLLIN, 0}};
    for (;;) {
        struct signalfd_siginfo info;
        int ready = poll(fds, 2, -1);
        if (ready > 0 && fds[1].revents) {
            return 0;
        }
        if (ready > 0 && read(interrupt->signals, &info, sizeof info) == (ssize_t)sizeof info) {
            return (int)info.ssi_signo;
        }
    }
}

static void *wait_for_signals(void *context)
{
    Interrupt *interrupt = context;
    int first = next_signal(interrupt);
    if (!first) {
        return NULL;
    }
    if (!atomic_load(&interrupt->heeded)) {
        end_by(first);
    }
    atomic_store(&interrupt->signal, first);
    int second = next_signal(interrupt);
    if (second) {
        end_by(second);
    }
    return NULL;
}

static void close_descriptors(const Interrupt *interrupt)
{
    if (interrupt->signals >= 0) {
        close(interrupt->signals);
    }
    if (interrupt->wake >= 0) {
        close(interrupt->wake);
    }
}

void interrupt_heed(Interrupt *interrupt)
{
    atomic_store(&interrupt->heeded, true);
}

void interrupt_begin(Interrupt *interrupt)
{
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
    atomic_init(&interrupt->signal, 0);
    atomic_init(&interrupt->heeded, false);
    sigemptyset(&interrupt->waited);
    bool any = false;
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; ++i) {
        struct sigaction action;
        if (sigaction(signals[i], NULL, &action) == 0 && action.sa_handler != SIG_IGN) {
            sigaddset(&interrupt->waited, signals[i]);
            any = true;
        }
    }
    pthread_sigmask(SIG_BLOCK, &interrupt->waited, &interrupt->before);
    interrupt->signals = signalfd(-1, &interrupt->waited, SFD_CLOEXEC | SFD_NONBLOCK);
    interrupt->wake = eventfd(0, EFD_CLOEXEC);
    interrupt->begun = any && interrupt->signals >= 0 && interrupt->wake >= 0 &&
                       pthread_create(&interrupt->thread, NULL, wait_for_signals, interrupt) == 0;
    if (!interrupt->begun) {
        close_descriptors(interrupt);
        pthread_sigmask(SIG_SETMASK, &interrupt->before, NULL);
    }
}

void interrupt_end(Interrupt *interrupt)
{
    if (interrupt->begun) {
        eventfd_write(interrupt->wake, 1);
        pthread_join(interrupt->thread, NULL);
        close_descriptors(interrupt);
        pthread_sigmask(SIG_SETMASK, &interrupt->before, NULL);
        interrupt->begun = false;
    }
}
