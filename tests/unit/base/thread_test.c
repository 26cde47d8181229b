// Parallel loops: every item once, in order of handing out, with any number of threads.
#include "base/mem.h"
#include "base/thread.h"

#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

enum { ITEMS = 20000 };

typedef struct Marks {
    atomic_uint done[ITEMS];
    atomic_uint wrong_worker;
    unsigned threads;
    atomic_int stop;
    uint64_t stop_at;
    _Atomic uint64_t last[64]; // of each worker, + 1
    atomic_uint out_of_order, total;
} Marks;

static void mark(void *context, uint64_t item, unsigned worker)
{
    Marks *marks = context;
    atomic_fetch_add(&marks->done[item], 1);
    atomic_fetch_add(&marks->total, 1);
    if (worker >= marks->threads && worker > 0) {
        atomic_fetch_add(&marks->wrong_worker, 1);
    }
    uint64_t before = atomic_exchange(&marks->last[worker % 64], item + 1);
    if (before > item) {
        atomic_fetch_add(&marks->out_of_order, 1);
    }
    if (item + 1 == marks->stop_at) {
        atomic_store(&marks->stop, 1);
    }
}

static void test_every_item_once(void **state)
{
    (void)state;
    static const unsigned threads[] = {0, 1, 2, 3, 8, 40, UINT32_MAX};
    static const uint64_t counts[] = {0, 1, 2, 7, ITEMS};
    for (size_t t = 0; t < sizeof threads / sizeof threads[0]; ++t) {
        for (size_t c = 0; c < sizeof counts / sizeof counts[0]; ++c) {
            if (threads[t] > 100 && counts[c] > 100) {
                continue; // thousands of threads prove nothing
            }
            Marks *marks = calloc(1, sizeof *marks);
            marks->threads = threads[t];
            parallel_for(counts[c], threads[t], mark, marks, NULL);
            for (uint64_t i = 0; i < ITEMS; ++i) {
                assert_int_equal(atomic_load(&marks->done[i]), i < counts[c]);
            }
            assert_int_equal(atomic_load(&marks->wrong_worker), 0);
            assert_int_equal(atomic_load(&marks->out_of_order), 0);
            free(marks);
        }
    }
}

static void test_stop(void **state)
{
    (void)state;
    for (unsigned threads = 1; threads <= 8; threads *= 2) {
        Marks *marks = calloc(1, sizeof *marks);
        marks->threads = threads;
        marks->stop_at = 100;
        parallel_for(ITEMS, threads, mark, marks, &marks->stop);
        unsigned total = atomic_load(&marks->total);
        // Items are handed out in order, so those before are begun, and begun ones are finished.
        for (uint64_t i = 0; i < 100; ++i) {
            assert_int_equal(atomic_load(&marks->done[i]), 1);
        }
        assert_in_range(total, 100, ITEMS - 1);
        if (threads == 1) {
            assert_int_equal(total, 100);
        }
        // Nothing is left out in the middle.
        for (uint64_t i = 0; i < ITEMS; ++i) {
            assert_int_equal(atomic_load(&marks->done[i]), i < total);
        }
        atomic_store(&marks->total, 0);
        parallel_for(ITEMS, threads, mark, marks, &marks->stop);
        assert_int_equal(atomic_load(&marks->total), 0);
        free(marks);
    }
}

static void test_without_memory(void **state)
{
    (void)state;
    Marks *marks = calloc(1, sizeof *marks);
    marks->threads = 4;
    mem_fail_after(0);
    parallel_for(ITEMS, 4, mark, marks, NULL);
    mem_fail_after(UINT64_MAX);
    assert_int_equal(atomic_load(&marks->total), ITEMS);
    free(marks);
}

// Where no thread's stack can be mapped, pthread_create fails and the caller does it all. Runs
// first: the stacks of threads that have ended are used again.
static void test_without_threads(void **state)
{
    (void)state;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    skip(); // they need the address space themselves
#else
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        Marks *marks = calloc(1, sizeof *marks);
        marks->threads = 4;
        struct rlimit none = {1 << 20, 1 << 20};
        if (setrlimit(RLIMIT_AS, &none) != 0) {
            _exit(77);
        }
        parallel_for(ITEMS, 4, mark, marks, NULL);
        bool alone = atomic_load(&marks->last[1]) == 0 && atomic_load(&marks->last[3]) == 0;
        _exit(atomic_load(&marks->total) == ITEMS && alone ? 0 : 1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
#endif
}

static void test_processor_count(void **state)
{
    (void)state;
    assert_true(thread_processor_count() >= 1);
    cpu_set_t before, one;
    assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
    assert_true(thread_processor_count() <= (unsigned)CPU_COUNT(&before));
    CPU_ZERO(&one);
    for (int i = 0; i < CPU_SETSIZE; ++i) {
        if (CPU_ISSET((size_t)i, &before)) {
            CPU_SET((size_t)i, &one);
            break;
        }
    }
    assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
    assert_int_equal(thread_processor_count(), 1);
    assert_int_equal(sched_setaffinity(0, sizeof before, &before), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_without_threads),
        cmocka_unit_test(test_every_item_once),
        cmocka_unit_test(test_stop),
        cmocka_unit_test(test_without_memory),
        cmocka_unit_test(test_processor_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
