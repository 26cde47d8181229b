#include "cli/told.h"

#include <string.h>
#include <xxhash.h>

static uint64_t hash_text(const char *text, uint64_t seed)
{
    return text ? XXH3_64bits_withSeed(text, strlen(text), seed) : seed;
}

// Files are numbered anew for each picture: their names count. What it says counts, too, since it
// may name a value that differs from picture to picture.
static uint64_t hash_of(const Diag *diag, const Sources *sources)
{
    const Source *source = source_get(sources, diag->at.file);
    const uint32_t place[3] = {(uint32_t)diag->code, diag->at.begin, diag->at.end};
    uint64_t hash = XXH3_64bits(place, sizeof place);
    hash = hash_text(source ? source->path : "", hash);
    hash = hash_text(diag->message, hash);
    return hash_text(diag->label, hash);
}

static bool is_told(const Told *told, uint64_t hash)
{
    for (size_t i = 0; i < told->hashes.count; ++i) {
        if (told->hashes.items[i] == hash) {
            return true;
        }
    }
    return false;
}

bool told_keep_new(Told *told, DiagSink *sink, const Sources *sources)
{
    Diag *kept = arena_array(sink->arena, (size_t)sink->count + 1, sizeof *kept);
    uint32_t count = 0, errors = 0, warnings = 0;
    for (uint32_t i = 0; kept && i < sink->count; ++i) {
        const uint64_t hash = hash_of(&sink->items[i], sources);
        if (is_told(told, hash)) {
            continue;
        }
        kept[count++] = sink->items[i];
        errors += sink->items[i].severity == SEVERITY_ERROR;
        warnings += sink->items[i].severity == SEVERITY_WARNING;
        if (!array_push(&told->hashes, hash)) {
            return false;
        }
    }
    sink->items = kept;
    sink->count = count;
    sink->errors = errors;
    sink->warnings = warnings;
    sink->dropped = 0;
    return kept != NULL;
}

void told_free(Told *told)
{
    array_free(&told->hashes);
}
