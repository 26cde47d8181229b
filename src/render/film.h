// The film: what a picture's samples add up to, and the pictures that are developed from it.
//
// Sums are double, of fixed blocks of SAMPLE_BLOCK samples: within a block in the order of the
// samples, then block after block. A pixel's sums thus depend only on its samples, not on threads,
// tiles or passes; and a film made of parts (ranges of samples rendered apart) by film_merge has
// the bytes of one rendered whole.
#ifndef RENDER_FILM_H
#define RENDER_FILM_H

#include "base/vec.h"
#include "render/integrator.h"
#include "schema/schema.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { SAMPLE_BLOCK = 64 };

typedef enum ToneCurve { TONE_SRGB, TONE_LINEAR, TONE_ACES, TONE_FILMIC } ToneCurve;
extern const char *const tone_names[]; // by ToneCurve; NULL at the end

typedef struct FilmParams { // the `film` kind
    int64_t width, height;
    int32_t filter;      // FilterKind (filter.h)
    double filter_width; // pixels, whole width; 0: the filter's own
    double exposure;     // stops
    int32_t tone;        // ToneCurve
    const char *file;    // or NULL
    StringList aovs;
} FilmParams;

// One pixel's sums.
typedef struct FilmPixel {
    double sum[3];     // of radiance, W/m²/sr
    double square_sum; // of the samples' luminance squared, for the variance
    uint32_t samples;  // how many, those of value 0 included
    uint32_t unused;   // (so that a pixel's bytes are all defined)
} FilmPixel;

// Sums over the samples that hit something.
typedef struct AovPixel {
    double albedo[3], normal[3], position[3], depth;
    uint32_t object, material; // of the first sample that hit; id + 1, 0 none
    uint32_t hits;
    uint32_t unused;
} AovPixel;

// What sharing (share.h) adds to a pixel's sum, in quanta of the film: whole numbers, so that their
// sum is the same in whatever order threads and tiles add them.
typedef struct FilmGain {
    int64_t sum[3];
} FilmGain;

typedef struct Film {
    uint32_t width, height;
    uint32_t first_sample; // number of the first sample: 0, or a part's multiple of SAMPLE_BLOCK
    uint32_t samples_done; // of every pixel (single pixels may have more)
    FilmPixel *pixels;     // width * height, rows from the top
    AovPixel *aovs;        // as many; NULL unless asked for
    // Parts (first_sample > 0) keep their blocks apart, so that they can be added in order later:
    // the sums of block b of pixel p are blocks[b * width * height + p]. NULL otherwise.
    FilmPixel *blocks;
    AovPixel *aov_blocks;
    uint32_t block_count;
    // Of sharing: NULL, 0, 0 without. A gain is that of all samples, the first blocks' and later
    // ones' alike.
    FilmGain *gains;
    double quantum; // W/m²/sr, a power of two
    uint32_t reach; // pixels from one to the farthest with which it shares
} Film;

// A black film. `samples` is how many a part will hold at most (ignored where first_sample = 0).
// False when memory runs out, the size overflows, or first_sample is no multiple of SAMPLE_BLOCK;
// *film is then empty. Give it back with film_free.
bool film_init(Film *film, uint32_t width, uint32_t height, uint32_t first_sample, uint32_t samples,
               bool aovs);
// Lets it share. False when memory runs out.
bool film_share(Film *film, double quantum, uint32_t reach);
void film_free(Film *film);
// Has the system provide the memory of a film that isn't huge, by `threads`: for one of which all
// pixels will be filled soon.
void film_populate(const Film *film, unsigned threads);
static inline size_t film_pixel_count(const Film *film)
{
    return (size_t)film->width * film->height;
}

// Adds one sample, or the sums of a later block, to a pixel's.
void film_pixel_add(FilmPixel *pixel, Rgb radiance);
// The same for one whose luminance has the given variance beside that which the samples' scatter
// shows.
void film_pixel_add_varying(FilmPixel *pixel, Rgb radiance, double variance);
void film_pixel_join(FilmPixel *pixel, const FilmPixel *block);
void film_aov_add(AovPixel *pixel, const AovSample *sample);
void film_aov_join(AovPixel *pixel, const AovPixel *block);

typedef enum FilmMerge {
    FILM_MERGED,
    FILM_MERGE_SIZE,       // the pictures' sizes or AOVs differ
    FILM_MERGE_GAP,        // `part` doesn't begin where `film` ends
    FILM_MERGE_INCOMPLETE, // `film` ends within a block, or pixels of either lack samples
    FILM_MERGE_NOT_HEAD,   // `film` doesn't begin at sample 0
} FilmMerge;
// Appends the samples of `part` (and leaves it as it is). Films of ranges that follow one another,
// joined in order, equal the film of the whole range bit by bit. Anything but FILM_MERGED leaves
// `film` as it was.
FilmMerge film_merge(Film *film, const Film *part);

// What the picture shows of a pixel: the mean of its samples and most of its gain. Where those with
// which it shares have not all been given the same number of samples, as after a stop, it is the
// former alone; `even`: all pixels are known to have the same number.
Rgb film_color(const Film *film, size_t pixel, bool even);
// Whether all pixels have the same number of samples.
bool film_is_even(const Film *film);
// The mean of a pixel's own samples.
Rgb film_mean(const FilmPixel *pixel);
// Its luminance; 0 without samples.
double film_luminance(const FilmPixel *pixel);
// The variance of the mean's luminance, estimated from the samples; 0 for fewer than two. What is
// shared varies less.
double film_variance(const FilmPixel *pixel);

// Writes width * height * channels floats, rows from the top. channels is 3, or 4 with the fraction
// of samples that hit something as alpha (1 without AOVs). linear: the colours as they are, scene
// linear Rec.709, without exposure and tone curve, as EXR wants them. Otherwise the exposure and
// the tone curve of `params` are applied, and the result lies in [0, 1], encoded for a display
// (TONE_LINEAR: not encoded). Rows are shared by `threads` (0 counts as 1).
void film_develop(const Film *film, const FilmParams *params, int channels, bool linear,
                  unsigned threads, float *out);

// Colour (linear Rec.709, after exposure) to a display's: see tone.c for the curves.
Rgb tone_apply(ToneCurve tone, Rgb color);
// Its two steps: what a display shall emit, in [0, 1]; and that, channel by channel, as it is sent.
Rgb tone_curve(ToneCurve tone, Rgb color);
float tone_encode(ToneCurve tone, float shown);

// The arbitrary output variables.
typedef struct FilmAov {
    const char *name; // as in film { aovs: ["albedo"] } and as the layer's name
    int channels;
    const char *const *suffixes; // of the channels' names
    bool uint32_ids;             // exact whole numbers
    const char *doc;
} FilmAov;
enum {
    AOV_ALBEDO,
    AOV_NORMAL,
    AOV_DEPTH,
    AOV_POSITION,
    AOV_OBJECT_ID,
    AOV_MATERIAL_ID,
    AOV_VARIANCE,
    AOV_ALPHA,
    AOV_COUNT
};
extern const FilmAov film_aovs[AOV_COUNT];
// The AOV_ of that name, or -1.
int film_find_aov(Str name);
// Writes width * height * channels floats: means over the samples that hit something, 0 where none
// did. Only AOV_VARIANCE can be had of a film without AOVs; false for the others then.
bool film_aov(const Film *film, int aov, float *out);

#endif
