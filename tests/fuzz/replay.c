// Replays a corpus through a fuzz target: every file as it is, cut off, and damaged in a thousand
// (or the number given) ways that are the same every time. Usage: replay FOLDER [DAMAGED] For
// builds without libFuzzer; a sanitizer, or the target's own abort, makes it fail.
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

enum { LARGEST = 1 << 20, DAMAGED = 1000 };

// Exactly `size` bytes in memory, so that a sanitizer sees a read behind them.
static void run(const uint8_t *bytes, size_t size)
{
    uint8_t *exact = malloc(size ? size : 1);
    if (exact) {
        memcpy(exact, bytes, size);
        LLVMFuzzerTestOneInput(exact, size);
    }
    free(exact);
}

static uint64_t next_random(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return *state >> 33;
}

// Sets, swaps, removes and repeats a few bytes.
static size_t damage(uint8_t *bytes, size_t size, uint64_t *random)
{
    static const uint8_t telling[] = {0, 1, 0x7f, 0x80, 0xff, '\n', '\r', ' ', '-', '9', '.', '"'};
    for (uint64_t times = 1 + next_random(random) % 4; times > 0 && size > 0; --times) {
        size_t at = (size_t)(next_random(random) % size), run_length = 1 + at % 8;
        switch (next_random(random) % 4) {
        case 0:
            bytes[at] = telling[next_random(random) % sizeof telling];
            break;
        case 1:
            bytes[at] = (uint8_t)next_random(random);
            break;
        case 2:
            run_length = run_length < size - at ? run_length : size - at;
            memmove(bytes + at, bytes + at + run_length, size - at - run_length);
            size -= run_length;
            break;
        default:
            if (size + run_length < LARGEST) {
                memmove(bytes + at + run_length, bytes + at, size - at);
                size += run_length;
            }
        }
    }
    return size;
}

static void replay(const uint8_t *bytes, size_t size, int damaged)
{
    uint8_t *copy = malloc(LARGEST);
    uint64_t random = 1;
    run(bytes, size);
    for (size_t cut = 0; damaged > 0 && cut < size; cut += 1 + size / (unsigned)damaged * 5) {
        run(bytes, cut);
    }
    for (int i = 0; copy && i < damaged; ++i) {
        memcpy(copy, bytes, size);
        run(copy, damage(copy, size, &random));
    }
    free(copy);
}

int main(int count, char **arguments)
{
    DIR *folder = count >= 2 ? opendir(arguments[1]) : NULL;
    uint8_t *bytes = malloc(LARGEST);
    int files = 0, damaged = count > 2 ? atoi(arguments[2]) : DAMAGED;
    for (struct dirent *entry; folder && bytes && (entry = readdir(folder));) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", arguments[1], entry->d_name);
        FILE *file = entry->d_name[0] == '.' ? NULL : fopen(path, "rb");
        if (file) {
            replay(bytes, fread(bytes, 1, LARGEST, file), damaged);
            fclose(file);
            ++files;
        }
    }
    free(bytes);
    if (folder) {
        closedir(folder);
    }
    printf("%d files\n", files);
    return files ? 0 : 1;
}
