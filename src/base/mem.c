#include "base/mem.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

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

void *mem_alloc(size_t count, size_t size)
{
    size_t bytes;
    return may_allocate(count, size, &bytes) ? counted(malloc(bytes)) : NULL;
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
    return may_allocate(count, size, &bytes) ? realloc(block, bytes) : NULL;
}

void mem_free(void *block)
{
    if (block) {
        atomic_fetch_sub_explicit(&live, 1, memory_order_relaxed);
        free(block);
    }
}

void mem_populate(void *part, size_t bytes)
{
#ifdef MADV_POPULATE_WRITE
    enum { PAGE = 4096 }; // or a multiple of it: then the last page comes when it is reached
    const uintptr_t begin = (uintptr_t)part & ~(uintptr_t)(PAGE - 1);
    const uintptr_t end = ((uintptr_t)part + bytes + PAGE - 1) & ~(uintptr_t)(PAGE - 1);
    if (bytes > 0) {
        madvise((void *)begin, end - begin, MADV_POPULATE_WRITE);
    }
#else
    (void)part, (void)bytes;
#endif
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
