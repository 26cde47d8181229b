#include "render/distribution.h"

#include "base/vec.h"

#include <math.h>

// Moves the excess of rich slots to poor ones until every slot holds one item and at most one
// alias. `scaled` are chances times count; `work` has room for count indices.
static void fill_slots(AliasTable *table, double *scaled, uint32_t *work)
{
    uint32_t poor = 0, rich = table->count; // two stacks that grow towards each other
    for (uint32_t i = 0; i < table->count; ++i) {
        if (scaled[i] < 1) {
            work[poor++] = i;
        } else {
            work[--rich] = i;
        }
    }
    while (poor > 0 && rich < table->count) {
        uint32_t low = work[--poor], high = work[rich];
        table->threshold[low] = (float)scaled[low];
        table->alias[low] = high;
        scaled[high] -= 1 - scaled[low];
        if (scaled[high] < 1) {
            ++rich;
            work[poor++] = high;
        }
    }
    // What is left is full, up to rounding.
    while (poor > 0) {
        table->threshold[work[--poor]] = 1;
    }
    while (rich < table->count) {
        table->threshold[work[rich++]] = 1;
    }
}

bool alias_table_build(AliasTable *table, Arena *arena, const double *weights, uint32_t count)
{
    *table = (AliasTable){.count = count};
    table->threshold = arena_array(arena, count + 1, sizeof *table->threshold);
    table->alias = arena_array(arena, count + 1, sizeof *table->alias);
    table->chance = arena_array(arena, count + 1, sizeof *table->chance);
    double *scaled = arena_array(arena, count + 1, sizeof *scaled);
    uint32_t *work = arena_array(arena, count + 1, sizeof *work);
    if (!table->threshold || !table->alias || !table->chance || !scaled || !work) {
        return false;
    }
    for (uint32_t i = 0; i < count; ++i) {
        table->total += weights[i];
    }
    for (uint32_t i = 0; i < count; ++i) {
        double chance = table->total > 0 ? weights[i] / table->total : 1.0 / count;
        table->chance[i] = (float)chance;
        table->alias[i] = i;
        scaled[i] = chance * count;
    }
    fill_slots(table, scaled, work);
    return true;
}

uint32_t alias_table_choose(const AliasTable *table, double u)
{
    double place = u * table->count;
    uint32_t slot = (uint32_t)place;
    if (slot >= table->count) {
        slot = table->count - 1;
    }
    return place - slot < (double)table->threshold[slot] ? slot : table->alias[slot];
}

bool grid_allocate(Grid *grid, Arena *arena, uint32_t width, uint32_t height)
{
    *grid = (Grid){.width = width, .height = height};
    if (width == 0 || height == 0 || width > INT32_MAX || height > INT32_MAX) {
        return false;
    }
    size_t per_row = (size_t)width + 1;
    grid->rows = arena_array(arena, (size_t)height + 1, sizeof *grid->rows);
    grid->cells = arena_array(arena, height, per_row * sizeof *grid->cells);
    grid->row_guide = arena_array(arena, height, sizeof *grid->row_guide);
    grid->cell_guide = arena_array(arena, height, width * sizeof *grid->cell_guide);
    return grid->rows && grid->cells && grid->row_guide && grid->cell_guide;
}

// guide[k] is the interval that k / count falls into, or one before.
static void fill_guide(const double *sums, uint32_t count, uint32_t *guide)
{
    uint32_t i = 0;
    for (uint32_t k = 0; k < count; ++k) {
        const double at = (double)k / count * sums[count];
        while (i + 1 < count && sums[i + 1] <= at) {
            ++i;
        }
        guide[k] = i;
    }
}

void grid_sum(Grid *grid)
{
    size_t per_row = (size_t)grid->width + 1;
    grid->rows[0] = 0;
    for (uint32_t y = 0; y < grid->height; ++y) {
        double *row = grid->cells + y * per_row;
        row[0] = 0;
        for (uint32_t x = 0; x < grid->width; ++x) {
            row[x + 1] += row[x];
        }
        grid->rows[y + 1] = grid->rows[y] + row[grid->width];
        fill_guide(row, grid->width, grid->cell_guide + (size_t)y * grid->width);
    }
    fill_guide(grid->rows, grid->height, grid->row_guide);
}

// The interval of the cumulative sums that u falls into: never an empty one.
static uint32_t choose(const double *sums, uint32_t count, const uint32_t *guide, double u,
                       double *within)
{
    double at = u * sums[count];
    if (!(at < sums[count])) {
        at = nextafter(sums[count], 0);
    }
    const uint32_t part = (uint32_t)(u * count);
    uint32_t i = guide[part < count ? part : count - 1];
    while (i > 0 && sums[i] > at) { // where a part's border was rounded
        --i;
    }
    while (sums[i + 1] <= at) {
        ++i;
    }
    *within = smaller((at - sums[i]) / (sums[i + 1] - sums[i]), 1 - 0x1p-53);
    return i;
}

bool grid_choose(const Grid *grid, double u, double v, uint32_t *x, uint32_t *y, double *in_x,
                 double *in_y)
{
    if (!(grid->rows[grid->height] > 0)) {
        return false;
    }
    *y = choose(grid->rows, grid->height, grid->row_guide, v, in_y);
    *x = choose(grid->cells + *y * ((size_t)grid->width + 1), grid->width,
                grid->cell_guide + (size_t)*y * grid->width, u, in_x);
    return true;
}

double grid_chance(const Grid *grid, uint32_t x, uint32_t y)
{
    const double *row = grid->cells + y * ((size_t)grid->width + 1);
    double total = grid->rows[grid->height];
    return total > 0 ? (row[x + 1] - row[x]) / total : 0;
}
