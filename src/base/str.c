#include "base/str.h"

#include "base/mem.h"

static uint32_t hash_name(Str name)
{
    // FNV-1a: names are short, and its loop is cheaper than a wide hash's set-up.
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < name.length; ++i) {
        hash = (hash ^ (unsigned char)name.at[i]) * 16777619u;
    }
    return hash ^ (hash >> 15);
}

void interner_init(Interner *interner, Arena *arena)
{
    *interner = (Interner){.arena = arena};
}

void interner_free(Interner *interner)
{
    mem_free(interner->names);
    mem_free(interner->slots);
    mem_free(interner->hashes);
    *interner = (Interner){0};
}

static Symbol out_of_memory(Interner *interner)
{
    if (interner->arena->on_oom) {
        longjmp(*interner->arena->on_oom, 1);
    }
    return 0;
}

static uint32_t find_slot(const Interner *interner, Str name, uint32_t hash)
{
    uint32_t slot = hash & interner->slot_mask;
    for (Symbol symbol; (symbol = interner->slots[slot]) != 0;
         slot = (slot + 1) & interner->slot_mask) {
        if (interner->hashes[symbol] == hash && str_equal(interner->names[symbol], name)) {
            break;
        }
    }
    return slot;
}

static bool grow(Interner *interner)
{
    uint32_t capacity = interner->capacity ? interner->capacity * 2 : 256;
    Str *names = mem_realloc(interner->names, capacity, sizeof *names);
    if (!names) {
        return false;
    }
    interner->names = names;
    uint32_t *hashes = mem_realloc(interner->hashes, capacity, sizeof *hashes);
    if (!hashes) {
        return false;
    }
    interner->hashes = hashes;
    uint32_t *slots = mem_alloc_zeroed((size_t)capacity * 2, sizeof *slots);
    if (!slots) {
        return false;
    }
    mem_free(interner->slots);
    interner->slots = slots;
    interner->slot_mask = capacity * 2 - 1;
    interner->capacity = capacity;
    for (Symbol symbol = 1; symbol <= interner->count; ++symbol) {
        slots[find_slot(interner, names[symbol], hashes[symbol])] = symbol;
    }
    return true;
}

Symbol intern(Interner *interner, Str name)
{
    if (interner->count + 2 > interner->capacity && !grow(interner)) {
        return out_of_memory(interner);
    }
    uint32_t hash = hash_name(name);
    uint32_t slot = find_slot(interner, name, hash);
    if (interner->slots[slot]) {
        return interner->slots[slot];
    }
    char *copy = arena_copy_string(interner->arena, name.at, name.length);
    if (!copy) {
        return 0;
    }
    Symbol symbol = ++interner->count;
    interner->names[symbol] = (Str){copy, name.length};
    interner->hashes[symbol] = hash;
    interner->slots[slot] = symbol;
    return symbol;
}

Symbol interned(const Interner *interner, Str name)
{
    return interner->capacity ? interner->slots[find_slot(interner, name, hash_name(name))] : 0;
}

Str symbol_name(const Interner *interner, Symbol symbol)
{
    return symbol && symbol <= interner->count ? interner->names[symbol] : STR("");
}

size_t str_distance(Str a, Str b, size_t limit)
{
    enum { LONGEST = 64 };
    size_t least = a.length > b.length ? a.length - b.length : b.length - a.length;
    if (a.length > LONGEST || b.length > LONGEST || least > limit) {
        return limit + 1;
    }
    // Only cells within `limit` of the diagonal can hold a distance of at most `limit` (E. Ukkonen,
    // Algorithms for approximate string matching, 1985); those beside them count as beyond it.
    size_t rows[3][LONGEST + 2];
    size_t *before = rows[0], *last = rows[1], *row = rows[2];
    for (size_t j = 0; j <= LONGEST + 1; ++j) {
        rows[0][j] = rows[2][j] = limit + 1;
        rows[1][j] = j;
    }
    for (size_t i = 1; i <= a.length; ++i) {
        size_t from = i > limit + 1 ? i - limit : 1,
               to = i + limit < b.length ? i + limit : b.length;
        row[from - 1] = from == 1 ? i : limit + 1;
        size_t nearest = row[from - 1];
        for (size_t j = from; j <= to; ++j) {
            size_t best = last[j - 1] + (a.at[i - 1] != b.at[j - 1]);
            if (last[j] + 1 < best) {
                best = last[j] + 1;
            }
            if (row[j - 1] + 1 < best) {
                best = row[j - 1] + 1;
            }
            if (i > 1 && j > 1 && a.at[i - 1] == b.at[j - 2] && a.at[i - 2] == b.at[j - 1] &&
                before[j - 2] + 1 < best) {
                best = before[j - 2] + 1;
            }
            row[j] = best;
            nearest = best < nearest ? best : nearest;
        }
        row[to + 1] = limit + 1;
        if (nearest > limit + 1) { // the row above was beyond it, too, so no swap leads back
            return limit + 1;
        }
        size_t *spare = before;
        before = last;
        last = row;
        row = spare;
    }
    return last[b.length] <= limit ? last[b.length] : limit + 1;
}

size_t str_suggestion_limit(Str name)
{
    return name.length < 4 ? 1 : name.length < 6 ? 2 : name.length < 15 ? name.length / 3 : 5;
}
