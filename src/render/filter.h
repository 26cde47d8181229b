// Pixel filters, by importance sampling: a sample's place within the filter is drawn with the
// filter's density and then counts once (Ernst, Stamminger and Greiner 2006, "Filter Importance
// Sampling"), so that a pixel's samples are its own. (What is noisy in them it shares with its
// neighbours: share.h.) All filters are separable, symmetric and nowhere negative.
#ifndef RENDER_FILTER_H
#define RENDER_FILTER_H

#include <stdint.h>

typedef enum FilterKind {
    FILTER_BOX,             // flat; width 1
    FILTER_TENT,            // 1 - |x|; width 2
    FILTER_GAUSSIAN,        // standard deviation a sixth of the width; width 3
    FILTER_BLACKMAN_HARRIS, // the four-term window; width 3
    FILTER_CENTER,          // the pixel's centre alone; has no width
} FilterKind;

enum { FILTER_CELLS = 240 }; // a whole number of them in a pixel, for the usual widths

typedef struct PixelFilter {
    FilterKind kind;
    double width;                  // of the whole support, pixels
    double cells;                  // in a pixel
    double mass[FILTER_CELLS + 1]; // integral of the density up to each cell's start
    double stretch[FILTER_CELLS];  // a cell's width over its mass, in parts of the support
    double density[FILTER_CELLS];  // its mass over its width in pixels
    uint16_t guide[FILTER_CELLS];  // the cell where a search for u in [i, i + 1) / CELLS begins
} PixelFilter;

double filter_default_width(FilterKind kind);
// width: of the whole support, in pixels; 0: the filter's own.
void filter_init(PixelFilter *filter, FilterKind kind, double width);
// The share of the filter's integral that lies left of `x`, where x = 0 is the support's left end
// and 1 its right one.
double filter_cumulative(FilterKind kind, double x);
// The offset from the pixel's centre, in pixels, for u in [0, 1).
double filter_sample(const PixelFilter *filter, float u);
// The cell of an offset; -1: it has none. What filter_sample gives has one, though rounding may
// bring it out of the support. Not for FILTER_CENTER.
static inline int filter_cell(const PixelFilter *filter, double offset)
{
    const double x = offset * filter->cells + FILTER_CELLS / 2, rounding = 1e-9;
    if (!(x >= -rounding && x < FILTER_CELLS + rounding)) {
        return -1;
    }
    const int cell = (int)x;
    return cell < FILTER_CELLS ? cell : FILTER_CELLS - 1;
}
// The density, over pixels, with which it chooses an offset.
static inline double filter_density(const PixelFilter *filter, double offset)
{
    const int cell = filter_cell(filter, offset);
    return cell < 0 ? 0 : filter->density[cell];
}

#endif
