// A picture cut into tiles, in an order in which neighbours follow one another.
#ifndef RENDER_TILES_H
#define RENDER_TILES_H

#include <stdbool.h>
#include <stdint.h>

#define TILE_SIZE 16u // pixels: the side of a tile unless another is asked for

typedef struct TileList {
    uint32_t width, height;           // pixels
    uint32_t tile_width, tile_height; // pixels; tiles at the right and lower edge may be smaller
    uint32_t columns;                 // of tiles
    uint64_t count;
    uint32_t *order; // the tiles' numbers, counted row by row, in the order of rendering
} TileList;

typedef struct Tile {
    uint32_t x0, y0, x1, y1; // pixels; x1 and y1 excluded
} Tile;

// Tiles in the order of a Hilbert curve. All sides at least 1, and width times height at most 2^32.
// False when memory runs out; tiles_free is then fine.
bool tiles_init(TileList *tiles, uint32_t width, uint32_t height, uint32_t tile_width,
                uint32_t tile_height);
void tiles_free(TileList *tiles);
Tile tile_at(const TileList *tiles, uint64_t number);

#endif
