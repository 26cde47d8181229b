// Finds reads that a processor makes wait: of bytes that were stored shortly before, but not all by
// the one store that wrote the latest of them, which alone could pass them on
// (docs/performance.md). Reads what `valgrind --tool=lackey --trace-mem=yes` lists, and prints, for
// each pair of a reading and a writing instruction, how often that happened and their addresses;
// the commonest first. Usage: waits [WINDOW] <LIST   (WINDOW: instructions from the store to the
// read at most)
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

// As many instructions as a present processor has under way.
enum { WINDOW = 450 };

typedef struct Store {
    uint64_t address, size, time, writer;
} Store;

// The latest stores, round and round.
enum { STORES = 256 };
static Store stores[STORES];
static uint64_t store_count;

typedef struct Pair {
    uint64_t reader, writer, count;
} Pair;

// By hash, linearly probed.
enum { PAIRS = 1 << 16 };
static Pair pairs[PAIRS];
static unsigned pair_count;

static void count_pair(uint64_t reader, uint64_t writer)
{
    uint64_t at = (reader * 0x9e3779b97f4a7c15u ^ writer * 0xbf58476d1ce4e5b9u) >> 48;
    while (pairs[at].count && (pairs[at].reader != reader || pairs[at].writer != writer)) {
        at = (at + 1) % PAIRS;
    }
    if (pairs[at].count == 0 && ++pair_count == PAIRS) {
        fprintf(stderr, "waits: too many places\n");
        exit(1);
    }
    pairs[at] = (Pair){reader, writer, pairs[at].count + 1};
}

static void read_bytes(uint64_t address, uint64_t size, uint64_t reader, uint64_t now,
                       uint64_t window)
{
    for (uint64_t i = 1; i <= STORES && i <= store_count; ++i) {
        const Store *s = &stores[(store_count - i) % STORES];
        if (now - s->time > window) {
            return;
        }
        if (s->address < address + size && address < s->address + s->size) {
            if (address < s->address || s->address + s->size < address + size) {
                count_pair(reader, s->writer);
            }
            return;
        }
    }
}

static int by_count(const void *a, const void *b)
{
    const uint64_t x = ((const Pair *)a)->count, y = ((const Pair *)b)->count;
    return (x < y) - (x > y);
}

int main(int argc, char **argv)
{
    const uint64_t window = argc > 1 ? strtoull(argv[1], NULL, 10) : WINDOW;
    uint64_t now = 0, instruction = 0;
    char line[256];
    while (fgets(line, sizeof line, stdin)) {
        char *end;
        const bool fetched = line[0] == 'I';
        const bool read = line[1] == 'L' || line[1] == 'M',
                   written = line[1] == 'S' || line[1] == 'M';
        if (!fetched && (line[0] != ' ' || !(read || written))) {
            continue; // valgrind's own words
        }
        const uint64_t address = strtoull(line + 3, &end, 16);
        if (*end != ',') {
            continue;
        }
        const uint64_t size = strtoull(end + 1, NULL, 10);
        if (fetched) {
            instruction = address;
            ++now;
            continue;
        }
        if (read) {
            read_bytes(address, size, instruction, now, window);
        }
        if (written) {
            stores[store_count++ % STORES] = (Store){address, size, now, instruction};
        }
    }
    qsort(pairs, PAIRS, sizeof *pairs, by_count);
    for (unsigned i = 0; i < PAIRS && pairs[i].count; ++i) {
        printf("%" PRIu64 " %" PRIx64 " %" PRIx64 "\n", pairs[i].count, pairs[i].reader,
               pairs[i].writer);
    }
    return 0;
}
