#include "base/mem.h"

#ifdef __linux__
#include <malloc.h>
#endif
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { HUGE_FROM = 16 << 20 }; // bytes

static _Atomic uint64_t allocations;
static _Atomic uint64_t fail_from = UINT64_MAX;
static _Atomic uint64_t live; // blocks that were not given back

static bool may_allocate(size_t count, size_t size, size_t *bytes)
{
    if (__builtin_mul_overflow(count, size, bytes) || *bytes > PTRDIFF_MAX) {
        return false;
    }
    if (*bytes == 0) {
        *bytes = 1;
    }
    return atomic_fetch_add_explicit(&allocations, 1, memory_order_relaxed) <
           atomic_load_explicit(&fail_from, memory_order_relaxed);
}

static void *counted(void *block)
{
    if (block) {
        atomic_fetch_add_explicit(&live, 1, memory_order_relaxed);
    }
    return block;
}

// Asks for huge pages in a big block: a tree of 200 MB else costs 50,000 page faults, a third of
// the time that parsing takes (tests/bench/parse_bench.c). glibc maps big blocks alone, behind a
// header of 16 bytes; all of the mapping is advised, since mremap, with which realloc grows it,
// can't move two halves that differ.
static void *with_huge_pages(void *block, size_t bytes)
{
#if defined MADV_HUGEPAGE && defined __GLIBC__
    enum { HEADER = 16, PAGE = 4096 };
    if (block && bytes >= HUGE_FROM) {
        uintptr_t first = (uintptr_t)block - HEADER;
        uintptr_t last = (uintptr_t)block + malloc_usable_size(block);
        if (first % PAGE == 0 && last % PAGE == 0) { // else it isn't what was expected
            (void)madvise((void *)first, last - first, MADV_HUGEPAGE); // only a hint
        }
    }
#endif
    (void)bytes;
    return block;
}

void *mem_alloc(size_t count, size_t size)
{
    size_t bytes;
    return may_allocate(count, size, &bytes) ? counted(with_huge_pages(malloc(bytes), bytes))
                                             : NULL;
}

void *mem_alloc_zeroed(size_t count, size_t size)
{
    size_t bytes;
    return may_allocate(count, size, &bytes) ? counted(calloc(1, bytes)) : NULL;
}

void *mem_realloc(void *block, size_t count, size_t size)
{
    size_t bytes;
    if (!block) {
        return mem_alloc(count, size);
    }
    return may_allocate(count, size, &bytes) ? with_huge_pages(realloc(block, bytes), bytes) : NULL;
}

void mem_free(void *block)
{
    if (block) {
        atomic_fetch_sub_explicit(&live, 1, memory_order_relaxed);
        free(block);
    }
}

void mem_fail_after(uint64_t more)
{
    uint64_t now = atomic_load_explicit(&allocations, memory_order_relaxed);
    atomic_store_explicit(&fail_from, more > UINT64_MAX - now ? UINT64_MAX : now + more,
                          memory_order_relaxed);
}

uint64_t mem_allocation_count(void)
{
    return atomic_load_explicit(&allocations, memory_order_relaxed);
}

uint64_t mem_live_count(void)
{
    return atomic_load_explicit(&live, memory_order_relaxed);
}
