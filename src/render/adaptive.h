// Adaptive sampling: cells of the picture are sampled until their error is small enough, without
// the stopping's pulling the mean.
//
// The trap: whoever stops a pixel as soon as its own samples look even stops early just where rare
// bright samples haven't come yet, and goes on where they have. Such a mean is too dark (Kirk and
// Arvo 1991, "Unbiased Sampling Techniques for Image Synthesis"). A mean of samples is unbiased
// only if what decides on their number is independent of them.
//
// So each pixel is sampled by two streams of their own seeds, 0 and 1, that know nothing of each
// other, and each decides for the other: stream 0 of a cell is averaged up to the number of samples
// at which stream 1 finds the error small enough, and the other way round. The number N0 of samples
// averaged of stream 0 is a function of stream 1 alone, so that E[mean of N0 samples | stream 1] is
// the pixel's light whatever N0 is; the same for N1; and the pixel, the even mean of the two means
// (not weighted by N0 and N1: that would bring the bias back), is unbiased. For that each stream
// has to be drawn on until it has decided, even where its own average is complete: samples that
// only decide are the method's price. Kirk and Arvo's own remedy, to throw the deciding samples
// away, costs about half of all samples where the number grows by doubling.
//
// A decision counts all pixels of a cell together, so that it rests on thousands of samples, the
// two streams mostly agree, and little is drawn in vain. Decisions fall between passes over the
// picture: bytes depend on neither threads nor tiles.
#ifndef RENDER_ADAPTIVE_H
#define RENDER_ADAPTIVE_H

#include "render/film.h"

enum { ADAPTIVE_CELL = 8 }; // pixels a side

// When it is good enough: the `until` kind.
typedef struct StopRule {
    double error, confidence;
} StopRule;

typedef struct AdaptiveCell {
    // How many samples of each stream are averaged, once the other has decided; 0: not yet.
    uint32_t enough[2];
} AdaptiveCell;

typedef struct AdaptiveState {
    uint32_t done;    // samples of each stream that all cells at work have
    uint32_t least;   // from so many on cells may be enough
    double floors[2]; // each stream's darkest luminance to which an error is relative; < 0: unknown
} AdaptiveState;

typedef struct Adaptive {
    double error, z;        // wanted; how many standard errors make the confidence
    uint32_t width, height; // pixels
    uint32_t columns, rows; // of cells
    uint32_t most;          // samples of a stream
    double expected;        // samples of both streams and all pixels, when all will be done
    AdaptiveState state;
    AdaptiveCell *cells;
    FilmPixel *streams[2]; // running sums
    FilmPixel *kept;       // of the stream that is complete, where only one is
} Adaptive;

// `samples`: the most of a pixel, both streams together. False when memory runs out; *adaptive is
// then empty. Give it back with adaptive_free.
bool adaptive_init(Adaptive *adaptive, uint32_t width, uint32_t height, StopRule rule,
                   uint32_t samples);
void adaptive_free(Adaptive *adaptive);

// Is there anything left to be drawn?
bool adaptive_finished(const Adaptive *adaptive);
// How many samples each stream shall have after the next pass.
uint32_t adaptive_next_target(const Adaptive *adaptive);
// The cell of a pixel; and whether it is at work.
static inline const AdaptiveCell *adaptive_cell(const Adaptive *a, uint32_t x, uint32_t y)
{
    return &a->cells[(size_t)(y / ADAPTIVE_CELL) * a->columns + x / ADAPTIVE_CELL];
}
static inline bool adaptive_at_work(const AdaptiveCell *cell)
{
    return cell->enough[0] == 0 || cell->enough[1] == 0;
}

// A pass has brought both streams of all cells at work to `done` samples: decides.
void adaptive_decide(Adaptive *adaptive, uint32_t done, Film *film);
// Brings the film's pixels, and film->samples_done, to what the streams hold, also in the middle of
// a pass.
void adaptive_show(const Adaptive *adaptive, Film *film);

// --- The error that was reached ------------------------------------------------------------------

// Of cells of a film. A cell's error is the half width of the confidence interval of its pixels'
// luminance (the root of their mean square), over the cell's mean luminance, or over a tenth of the
// picture's where that is more: darkness needn't be known better. The variance is that of the
// samples, as if they were independent; being stratified they are better than that.
typedef struct FilmError {
    double mean, worst; // of the cells: root mean square; the largest
    double met;         // the part of the cells whose error is at most `wanted`
} FilmError;
// NAN (and met = 0) where a pixel has fewer than two samples.
FilmError film_error(const Film *film, double confidence, double wanted);

#endif
