// Discrete choices by weight: what lights and environments are chosen with.
#ifndef RENDER_DISTRIBUTION_H
#define RENDER_DISTRIBUTION_H

#include "base/arena.h"

#include <stdbool.h>
#include <stdint.h>

// Walker's alias method, built as by Vose 1991: a choice in constant time.
typedef struct AliasTable {
    uint32_t count;
    double total;     // of the weights
    float *threshold; // by slot: below it the slot itself, else its alias
    uint32_t *alias;
    float *chance; // of each item
} AliasTable;

// Weights are finite and not negative. False when memory runs out. With a total of zero every item
// has the same chance.
bool alias_table_build(AliasTable *table, Arena *arena, const double *weights, uint32_t count);
// The item that u in [0, 1) chooses; count must not be 0. u wants log2(count) bits beyond the
// precision of the chances.
uint32_t alias_table_choose(const AliasTable *table, double u);

// Cells of a grid, row by row: a row by its weight, then a cell in it, both by inverting cumulative
// sums, so that strata of (u, v) stay strata. A guide (Chen and Asau 1974) tells where among n sums
// to begin for each n-th part of [0, 1), and from there it is one step on average.
typedef struct Grid {
    uint32_t width, height;
    double *cells;        // height rows of width + 1 cumulative weights, from 0
    double *rows;         // height + 1 cumulative weights of rows
    uint32_t *cell_guide; // height rows of width
    uint32_t *row_guide;  // height
} Grid;

// False when memory runs out or the sizes overflow. Fill grid->cells[y (width + 1) + x + 1] with
// the weight of cell (x, y), then call grid_sum.
bool grid_allocate(Grid *grid, Arena *arena, uint32_t width, uint32_t height);
void grid_sum(Grid *grid);
// The cell (*x, *y) that (u, v) in [0, 1)² chooses, and where in it, in [0, 1)². Cells of no weight
// are never chosen; false where no cell has any.
bool grid_choose(const Grid *grid, double u, double v, uint32_t *x, uint32_t *y, double *in_x,
                 double *in_y);
// The chance of a cell.
double grid_chance(const Grid *grid, uint32_t x, uint32_t y);

#endif
