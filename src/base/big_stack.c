#include "base/big_stack.h"

#include "base/thread.h"

enum { SMALLEST = 4 << 20, CALLERS = 1 << 20 };

typedef struct BigStack {
    size_t bytes;
    void (*work)(void *context, uintptr_t floor);
    void *context;
} BigStack;

static void run(const BigStack *call)
{
    uintptr_t here = (uintptr_t)__builtin_frame_address(0);
    call->work(call->context, here > call->bytes ? here - call->bytes : 0);
}

static void *begin(void *call)
{
    run(call);
    return NULL;
}

static bool run_in_thread(BigStack *call)
{
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes) != 0) {
        return false;
    }
    pthread_t thread;
    bool started = pthread_attr_setstacksize(&attributes, call->bytes) == 0;
    // Guard page, thread descriptor and the frames so far also lie in it.
    call->bytes -= 64 * 1024;
    started = started && thread_start(&thread, &attributes, begin, call);
    pthread_attr_destroy(&attributes);
    if (started) {
        pthread_join(thread, NULL);
    }
    return started;
}

void call_on_big_stack(size_t bytes, void (*work)(void *context, uintptr_t floor), void *context)
{
    for (; bytes >= SMALLEST; bytes /= 2) {
        BigStack call = {bytes, work, context};
        if (run_in_thread(&call)) {
            return;
        }
    }
    run(&(BigStack){CALLERS, work, context});
}
