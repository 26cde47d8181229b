// Growable arrays of one element type:
//
//     typedef ARRAY(Vec3) Vec3Array;
//     Vec3Array points = {0};
//     if (!array_push(&points, p)) { out of memory }
//     for (size_t i = 0; i < points.count; ++i) use(points.items[i]);
//     array_free(&points);
#ifndef BASE_ARRAY_H
#define BASE_ARRAY_H

#include "base/mem.h"

#define ARRAY(Type)                                                                                \
    struct {                                                                                       \
        Type *items;                                                                               \
        size_t count, capacity;                                                                    \
    }

// True when `more` further items fit, making room if need be; false when memory ran out, and then
// the array is as it was.
#define array_reserve(array, more)                                                                 \
    array_grow((void **)(void *)&(array)->items, &(array)->capacity, (array)->count,               \
               (size_t)(more), sizeof *(array)->items)

// Appends one item; false when memory ran out.
#define array_push(array, ...)                                                                     \
    (array_reserve(array, 1) ? ((array)->items[(array)->count++] = (__VA_ARGS__), true) : false)

#define array_free(array)                                                                          \
    (mem_free((array)->items), (array)->items = NULL, (array)->count = (array)->capacity = 0)

static inline bool array_grow(void **items, size_t *capacity, size_t count, size_t more,
                              size_t size)
{
    if (more <= *capacity - count) {
        return true;
    }
    size_t wanted = *capacity + *capacity / 2 + 8;
    if (wanted < count + more) {
        wanted = count + more;
    }
    void *grown = wanted < count ? NULL : mem_realloc(*items, wanted, size);
    if (!grown) {
        return false;
    }
    *items = grown;
    *capacity = wanted;
    return true;
}

#endif
