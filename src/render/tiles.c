#include "render/tiles.h"

#include "base/mem.h"

#include <stdlib.h>

static uint32_t ceil_divide(uint32_t a, uint32_t b)
{
    return a / b + (a % b != 0);
}

// The distance of (x, y) along the Hilbert curve that fills a square of `side` (a power of two).
static uint64_t hilbert_distance(uint64_t side, uint64_t x, uint64_t y)
{
    uint64_t distance = 0;
    for (uint64_t s = side / 2; s > 0; s /= 2) {
        const uint64_t right = (x & s) > 0, low = (y & s) > 0;
        distance += s * s * ((3 * right) ^ low);
        if (!low) { // turn the quarter, so that the curve goes on where it left
            if (right) {
                x = side - 1 - x;
                y = side - 1 - y;
            }
            const uint64_t old = x;
            x = y;
            y = old;
        }
    }
    return distance;
}

typedef struct Place {
    uint64_t distance;
    uint32_t index;
} Place;

static int compare_places(const void *a, const void *b)
{
    const uint64_t x = ((const Place *)a)->distance, y = ((const Place *)b)->distance;
    return x < y ? -1 : x > y;
}

bool tiles_init(TileList *tiles, uint32_t width, uint32_t height, uint32_t tile_width,
                uint32_t tile_height)
{
    const uint32_t columns = ceil_divide(width, tile_width);
    const uint32_t rows = ceil_divide(height, tile_height);
    *tiles = (TileList){.width = width,
                        .height = height,
                        .tile_width = tile_width,
                        .tile_height = tile_height,
                        .columns = columns};
    tiles->count = (uint64_t)columns * rows;
    tiles->order = mem_alloc(tiles->count, sizeof *tiles->order);
    Place *places = mem_alloc(tiles->count, sizeof *places);
    if (!tiles->order || !places) {
        mem_free(places);
        tiles_free(tiles);
        return false;
    }
    uint64_t side = 1;
    while (side < columns || side < rows) {
        side *= 2;
    }
    for (uint32_t y = 0, i = 0; y < rows; ++y) {
        for (uint32_t x = 0; x < columns; ++x, ++i) {
            places[i] = (Place){hilbert_distance(side, x, y), i};
        }
    }
    qsort(places, tiles->count, sizeof *places, compare_places);
    for (uint64_t i = 0; i < tiles->count; ++i) {
        tiles->order[i] = places[i].index;
    }
    mem_free(places);
    return true;
}

void tiles_free(TileList *tiles)
{
    mem_free(tiles->order);
    *tiles = (TileList){0};
}

Tile tile_at(const TileList *tiles, uint64_t number)
{
    const uint32_t index = tiles->order[number];
    const uint32_t w = tiles->tile_width, h = tiles->tile_height;
    const uint32_t x = index % tiles->columns * w, y = index / tiles->columns * h;
    return (Tile){
        .x0 = x,
        .y0 = y,
        .x1 = tiles->width - x < w ? tiles->width : x + w,
        .y1 = tiles->height - y < h ? tiles->height : y + h,
    };
}
