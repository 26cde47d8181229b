// Memory from the C library. This is the only file that calls malloc, realloc and free (shims
// around other people's libraries excepted), so that a test can make every allocation fail in turn.
#ifndef BASE_MEM_H
#define BASE_MEM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// All three return NULL when memory is exhausted, when `count * size` overflows, or when the fault
// counter below has run out. Freshly allocated bytes are not cleared, except by mem_alloc_zeroed.
void *mem_alloc(size_t count, size_t size);
void *mem_alloc_zeroed(size_t count, size_t size);
void *mem_realloc(void *block, size_t count, size_t size);
void mem_free(void *block);

// For tests: after `allocations` more successful calls every further one fails, in any thread.
// UINT64_MAX (the default) never fails.
void mem_fail_after(uint64_t allocations);
// Allocations asked for so far, in this process.
uint64_t mem_allocation_count(void);
// Blocks that exist now: the same before and after what gives all back.
uint64_t mem_live_count(void);

#endif
