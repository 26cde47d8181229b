// Preloaded into the program (LD_PRELOAD), makes an allocation of its own fail, and tells at the
// end how many there were and which of them were never given back. What libraries allocate for
// themselves is let through.
//     FAULT_AT=N     the Nth allocation fails (0: none); FAULT_ON=1: all from there on
//     FAULT_FD=FD    where "allocations live\n" is written at the end
#include <link.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *block, size_t size);
extern void __libc_free(void *block);

enum { SLOTS = 1 << 20 };

static struct {
    uintptr_t begin, end; // of the program's code
    uint64_t fail_at, count, live;
    bool goes_on;
    int fd;
    pthread_mutex_t mutex;
    void *blocks[SLOTS]; // a hash table of what is live; (void *)1: was given back
} the = {.fd = -1, .mutex = PTHREAD_MUTEX_INITIALIZER};

static int find_program(struct dl_phdr_info *info, size_t size, void *unused)
{
    (void)size;
    (void)unused;
    for (int i = 0; i < info->dlpi_phnum; ++i) {
        const ElfW(Phdr) *part = &info->dlpi_phdr[i];
        if (part->p_type == PT_LOAD && (part->p_flags & PF_X)) {
            the.begin = info->dlpi_addr + part->p_vaddr;
            the.end = the.begin + part->p_memsz;
        }
    }
    return 1; // the first is the program
}

__attribute__((constructor)) static void begin(void)
{
    const char *at = getenv("FAULT_AT"), *on = getenv("FAULT_ON"), *fd = getenv("FAULT_FD");
    the.fail_at = at ? strtoull(at, NULL, 10) : 0;
    the.goes_on = on && *on == '1';
    the.fd = fd ? atoi(fd) : -1;
    dl_iterate_phdr(find_program, NULL);
}

__attribute__((destructor)) static void end(void)
{
    char text[64];
    int length = snprintf(text, sizeof text, "%llu %llu\n", (unsigned long long)the.count,
                          (unsigned long long)the.live);
    if (the.fd >= 0 && length > 0) {
        (void)!write(the.fd, text, (size_t)length);
    }
}

static bool is_own(const void *caller)
{
    return (uintptr_t)caller >= the.begin && (uintptr_t)caller < the.end;
}

static bool fails(const void *caller)
{
    if (!is_own(caller)) {
        return false;
    }
    pthread_mutex_lock(&the.mutex);
    ++the.count;
    bool failing =
        the.fail_at && (the.goes_on ? the.count >= the.fail_at : the.count == the.fail_at);
    pthread_mutex_unlock(&the.mutex);
    return failing;
}

static size_t slot_of(const void *block)
{
    return ((uintptr_t)block >> 4) * 0x9e3779b97f4a7c15u >> 44;
}

static void *keep(void *block, const void *caller)
{
    if (block && is_own(caller)) {
        pthread_mutex_lock(&the.mutex);
        size_t slot = slot_of(block);
        while ((uintptr_t)the.blocks[slot] > 1) {
            slot = (slot + 1) % SLOTS;
        }
        the.blocks[slot] = block;
        ++the.live;
        pthread_mutex_unlock(&the.mutex);
    }
    return block;
}

static void forget(const void *block)
{
    pthread_mutex_lock(&the.mutex);
    size_t slot = slot_of(block);
    while (block && the.blocks[slot] && the.blocks[slot] != block) {
        slot = (slot + 1) % SLOTS;
    }
    if (block && the.blocks[slot]) {
        the.blocks[slot] = (void *)1;
        --the.live;
    }
    pthread_mutex_unlock(&the.mutex);
}

void *malloc(size_t size)
{
    const void *caller = __builtin_return_address(0);
    return fails(caller) ? NULL : keep(__libc_malloc(size), caller);
}

void *calloc(size_t count, size_t size)
{
    const void *caller = __builtin_return_address(0);
    return fails(caller) ? NULL : keep(__libc_calloc(count, size), caller);
}

void *realloc(void *block, size_t size)
{
    const void *caller = __builtin_return_address(0);
    if (fails(caller)) {
        return NULL;
    }
    forget(block);
    void *grown = __libc_realloc(block, size);
    keep(grown ? grown : block, caller);
    return grown;
}

void free(void *block)
{
    forget(block);
    __libc_free(block);
}
