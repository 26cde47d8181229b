#include "base/diag_write.h"

#include "base/mem.h"

// Whether the diagnostic with index a comes before that with index b.
static bool comes_before(const DiagSink *sink, uint32_t a, uint32_t b)
{
    Span p = sink->items[a].at, q = sink->items[b].at;
    if (p.file != q.file) {
        return p.file < q.file;
    }
    if (p.begin != q.begin) {
        return p.begin < q.begin;
    }
    return p.end != q.end ? p.end < q.end : a < b;
}

// Merges the sorted runs [begin, middle) and [middle, end) of `from` into `to`.
static void merge(const DiagSink *sink, const uint32_t *from, uint32_t *to, uint32_t begin,
                  uint32_t middle, uint32_t end)
{
    uint32_t left = begin, right = middle;
    for (uint32_t i = begin; i < end; ++i) {
        bool take_left =
            left < middle && (right >= end || !comes_before(sink, from[right], from[left]));
        to[i] = take_left ? from[left++] : from[right++];
    }
}

// A merge sort, since qsort has no way to hand the sink to its comparison.
uint32_t *diag_sorted(const DiagSink *sink)
{
    uint32_t count = sink->count;
    uint32_t *order = count ? mem_alloc(count, sizeof *order) : NULL;
    uint32_t *other = order ? mem_alloc(count, sizeof *other) : NULL;
    if (!other) {
        mem_free(order);
        return NULL;
    }
    for (uint32_t i = 0; i < count; ++i) {
        order[i] = i;
    }
    for (size_t width = 1; width < count; width *= 2) {
        for (size_t begin = 0; begin < count; begin += 2 * width) {
            size_t middle = begin + width < count ? begin + width : count;
            size_t end = begin + 2 * width < count ? begin + 2 * width : count;
            merge(sink, order, other, (uint32_t)begin, (uint32_t)middle, (uint32_t)end);
        }
        uint32_t *swap = order;
        order = other;
        other = swap;
    }
    mem_free(other);
    return order;
}
