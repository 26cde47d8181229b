// Ctrl-C, SIGTERM and SIGHUP while a picture is rendered: the first asks for an end, the second
// ends the program at once. Before anything is there to be kept the first does. A thread of its own
// waits for them, so that there is no signal handler and nothing global.
#ifndef CLI_INTERRUPT_H
#define CLI_INTERRUPT_H

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>

typedef struct Interrupt {
    atomic_int signal;  // the first that came, or 0: the renderer's `stop`
    atomic_bool heeded; // there is something to be kept
    sigset_t waited, before;
    int signals, wake; // descriptors: a signalfd, an eventfd that ends the thread
    pthread_t thread;
    bool begun;
} Interrupt;

// From now on the signals (but those that the program was started to ignore) are taken. Call it
// before other threads are started. Where no thread can be had, they go on ending the program at
// once.
void interrupt_begin(Interrupt *interrupt);
// From now on the program looks at `signal`; until then a signal ends it at once.
void interrupt_heed(Interrupt *interrupt);
// Ends the thread; the signals do what they did before. Nothing where it wasn't begun.
void interrupt_end(Interrupt *interrupt);

#endif
