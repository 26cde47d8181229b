#include "cli/interrupt.h"

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

static void *wait_for_signals(void *context)
{
    Interrupt *interrupt = context;
    int first = 0, second = 0;
    if (sigwait(&interrupt->waited, &first) != 0) {
        return NULL;
    }
    if (!atomic_load(&interrupt->heeded)) {
        end_by(first);
    }
    atomic_store(&interrupt->signal, first);
    if (sigwait(&interrupt->waited, &second) == 0) {
        end_by(second);
    }
    return NULL;
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
    interrupt->begun =
        any && pthread_create(&interrupt->thread, NULL, wait_for_signals, interrupt) == 0;
    if (!interrupt->begun) {
        pthread_sigmask(SIG_SETMASK, &interrupt->before, NULL);
    }
}

void interrupt_end(Interrupt *interrupt)
{
    if (interrupt->begun) {
        pthread_cancel(interrupt->thread); // it waits in sigwait, which can be cancelled
        pthread_join(interrupt->thread, NULL);
        pthread_sigmask(SIG_SETMASK, &interrupt->before, NULL);
        interrupt->begun = false;
    }
}
