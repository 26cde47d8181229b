// Calling a function on a stack of known size.
#ifndef BASE_BIG_STACK_H
#define BASE_BIG_STACK_H

#include <stddef.h>
#include <stdint.h>

// Calls work(context, floor) in a thread whose stack has `bytes` (pages are taken only when
// touched), or fewer, halved until the system grants it; in the caller's own thread, taken to have
// 1 MiB left, where no thread can be made. `floor` is the lowest address that the stack reaches.
// Returns when work has.
void call_on_big_stack(size_t bytes, void (*work)(void *context, uintptr_t floor), void *context);

#endif
