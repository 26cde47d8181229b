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

// Has the system provide the memory of a part of a block now, for a block that will be used whole.
// It comes in half of the time then; and where pages of zeroed memory are read before they are
// written, by several threads, the system would interrupt all of them for each page. The bytes stay
// what they are; where the system can't, nothing happens.
void mem_populate(void *part, size_t bytes);

// For tests: after `allocations` more successful calls every further one fails, in any thread.
// UINT64_MAX (the default) never fails.
void mem_fail_after(uint64_t allocations);
// Allocations asked for so far, in this process.
uint64_t mem_allocation_count(void);
// Blocks that exist now: the same before and after what gives all back.
uint64_t mem_live_count(void);

#endif
