// Sharing of noisy light among neighbouring pixels.
//
// A sample's place within its pixel's filter is drawn with the filter's density, and it counts once
// (filter.h). Filters of neighbours overlap, so that a neighbour might have drawn the same place,
// and what was found there says as much about its pixel. Here it does: a sample taken at x for
// pixel p counts for each pixel q with the weight
//
//     w_q(x) = f_q(x) / Σ_r f_r(x)
//
// where f are the filters' densities and r goes over all pixels of the picture (Veach and Guibas
// 1995, the balance heuristic; each pixel takes as many samples). Σ_p E_p[w_q L] = ∫ f_q L, the
// same pixel as before, from 2.2 times as many samples with the filter "blackman_harris".
//
// But the weights vary over a pixel, and light that varies little is better found by samples that
// count once. So only that is shared which comes by chance from beyond the surface that is seen
// first: light that was scattered twice or more, and where the first scattering was one of several
// that might have been (not in a mirror). What lies on the surface that is seen, lamps and what
// they light, its edges and shadows and textures, stays with the pixel's own samples, which are
// stratified over it.
//
// Even so a pixel's own samples are worth more to it than others', being stratified together: it
// shows a part of what sharing changes (film.c), whose mean is 0 whatever the part.
//
// What is kept of sharing is the gain: for q the sum of w_q L over the neighbours' samples and of
// (w_q - 1) L over its own. A picture without it is as right, and noisier. Gains
// are rounded to whole numbers of a quantum that is far less than the picture's light and added as
// such, so that bytes depend on neither threads nor tiles nor passes.
#ifndef RENDER_SHARE_H
#define RENDER_SHARE_H

#include "base/vec.h"
#include "render/filter.h"
#include "render/tiles.h"

#include <stdbool.h>

struct Renderer;

enum {
    SHARE_WIDTH = 4, // pixels: wider filters don't share
    SHARE_REACH = SHARE_WIDTH - 1,
    SHARE_SIDE = 2 * SHARE_REACH + 1,
};

// Whole numbers of quanta; doubles hold their sums exactly. The last is 0.
typedef struct ShareQuanta {
    double color[4];
} ShareQuanta;

// What the samples of one pixel bring to it (in the middle) and to those around it.
typedef struct SharePatch {
    ShareQuanta at[SHARE_SIDE][SHARE_SIDE];
} SharePatch;

// What the samples of a tile bring to its pixels and to those around it.
typedef struct ShareWindow {
    ShareQuanta *sums; // rows from the top; the first pixel is (x0, y0)
    int64_t x0, y0;
    size_t columns, rows;
    SharePatch patch; // of the present pixel
} ShareWindow;

// The densities, in one direction, with which the filters of the pixels around have a place drawn.
typedef struct ShareDensities {
    int first, count; // from the own pixel
    double over_sum;  // 1 over their sum
    double items[SHARE_WIDTH];
} ShareDensities;

typedef struct Sharing {
    double per_radiance;                // quanta
    ShareDensities cells[FILTER_CELLS]; // for places in each cell of the own pixel's filter
    bool has_cells;                     // they are filled
    ShareWindow *windows;               // of each thread; NULL: nothing is shared
} Sharing;

// Makes the renderer ready to share, if its picture is such; its world, camera, filter and film
// are. A few trial paths, which count for nothing else, tell the quantum. False when memory runs
// out.
bool share_begin(struct Renderer *r);
void share_end(struct Renderer *r);
// Goes on with gains that a film had from elsewhere, in quanta of their own.
void share_use_quantum(struct Renderer *r, double quantum);
// Fills the table of cells, as share_begin does; for tests.
void share_fill_cells(Sharing *sharing, const PixelFilter *filter);

// A tile's window, empty, for the thread that renders it; and the window's sums to the film's
// gains.
ShareWindow *share_open(struct Renderer *r, unsigned worker, const Tile *tile);
void share_close(struct Renderer *r, ShareWindow *window);
// Notes what a sample brings that was taken at the given offset, in pixels, from the centre of
// pixel (x, y). What was noted of a pixel counts once it is kept.
void share_add(const struct Renderer *r, ShareWindow *window, uint32_t x, uint32_t y,
               const double offset[2], Rgb light);
void share_keep(const struct Renderer *r, ShareWindow *window, uint32_t x, uint32_t y);
void share_drop(ShareWindow *window);

#endif
