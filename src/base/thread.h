// Worker threads.
#ifndef BASE_THREAD_H
#define BASE_THREAD_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

// Processors that this process may run on (its affinity and cgroup quota respected), at least 1.
unsigned thread_processor_count(void);

// Starts a thread that signals pass by: they are for the threads that are there already. A fault of
// the thread's own (SIGSEGV and its like) is not held back, so that a handler can tell of it.
// `attributes` may be NULL. False where no thread can be made.
bool thread_start(pthread_t *thread, const pthread_attr_t *attributes, void *(*work)(void *),
                  void *argument);

// Whether `count` more threads can be had at once (of 256 at most): for libraries that end the
// program where they can't start one. True says how it was a moment ago, no more.
bool thread_can_start(unsigned count);

// Calls work(context, item, worker) once for each item in [0, count), from `threads` threads of
// which the caller is one (worker 0); worker < threads. Items are handed out in order. Returns when
// all are done, or, once *stop is non-zero (it may be NULL), when those begun are done. If threads
// can't be made it goes on with those it has; 0 threads count as 1. Signals go to the caller only.
typedef void ParallelWork(void *context, uint64_t item, unsigned worker);
void parallel_for(uint64_t count, unsigned threads, ParallelWork *work, void *context,
                  const atomic_int *stop);

#endif
