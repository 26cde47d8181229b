#include "render/share.h"

#include "base/clones.h"
#include "base/mem.h"
#include "render/renderer.h"

#include <math.h>
#include <string.h>

// A quantum is the power of two next to 2^-QUANTUM_BITS of the mean light that is shared. Sums of
// doubles are exact up to 2^53: a sample of at most MOST_QUANTA, times the 64 that a pixel takes at
// once, times the 49 pixels at most from which they come, stays below that.
enum { QUANTUM_BITS = 28 };
#define MOST_QUANTA 0x1p41
// Seeds as far from the samples' own as another picture's.
enum { SHARE_STREAM = 0x632be5ab };
enum { TRIALS = 16 }; // a side

// --- Making ready --------------------------------------------------------------------------------

static double trial(const Renderer *r, uint32_t i, uint32_t j)
{
    Sampler sampler;
    IntegratorStats stats = {0};
    Ray ray;
    float lens_u, lens_v;
    Rgb indirect;
    sampler_start(&sampler, r->seed ^ SHARE_STREAM, i, j, 0);
    sampler_2d(&sampler, &lens_u, &lens_v);
    sampler_2d(&sampler, &lens_u, &lens_v);
    if (!camera_ray(&r->camera, (i + 0.5) / TRIALS, (j + 0.5) / TRIALS, lens_u, lens_v, &ray)) {
        return 0;
    }
    r->integrator->for_film(r->world, &ray, &sampler, false, NULL, &indirect, &stats);
    return rgb_is_finite(indirect) ? (double)luminance(indirect) : 0;
}

// 0: none was found.
static double mean_to_share(const Renderer *r)
{
    double sum = 0;
    for (uint32_t j = 0; j < TRIALS; ++j) {
        for (uint32_t i = 0; i < TRIALS; ++i) {
            sum += trial(r, i, j);
        }
    }
    return sum / (TRIALS * TRIALS);
}

static uint32_t reach_of(const PixelFilter *filter)
{
    return (uint32_t)ceil(filter->width) - 1;
}

static bool may_share(const Renderer *r)
{
    return r->integrator->for_film && !r->rule && r->world->bounces >= 2 &&
           r->filter.kind != FILTER_CENTER && r->filter.width > 1 && r->filter.width <= SHARE_WIDTH;
}

// The pixels around whose filters reach a place, by the densities with which they have it drawn.
static void densities_around(const PixelFilter *filter, uint32_t own, uint32_t size, double offset,
                             ShareDensities *out)
{
    const uint32_t reach = reach_of(filter);
    const int left = (int)(own < reach ? own : reach);
    const int right = (int)(size - 1 - own < reach ? size - 1 - own : reach);
    // No more than so many on either side, towards which less than half a width is left.
    const int before = (int)(filter->width / 2 - offset), after = (int)(filter->width / 2 + offset);
    const int last = after < right ? after : right;
    out->first = -(before < left ? before : left);
    out->count = 0;
    double sum = 0;
    for (int k = out->first; k <= last && out->count < SHARE_WIDTH; ++k) {
        const double density = filter_density(filter, offset - k);
        out->items[out->count++] = density;
        sum += density;
    }
    out->over_sum = 1 / sum;
}

// Where a pixel is as wide as a whole number of the filter's cells, all places of a cell lie in one
// cell of each neighbour's, too.
void share_fill_cells(Sharing *sharing, const PixelFilter *filter)
{
    const uint32_t reach = reach_of(filter);
    sharing->has_cells = filter->cells == floor(filter->cells);
    for (int cell = 0; sharing->has_cells && cell < FILTER_CELLS; ++cell) {
        const double middle = (cell + 0.5 - FILTER_CELLS / 2) / filter->cells;
        densities_around(filter, reach, 2 * reach + 1, middle, &sharing->cells[cell]);
    }
}

void share_use_quantum(Renderer *r, double quantum)
{
    r->film.quantum = quantum;
    r->sharing.per_radiance = 1 / quantum;
}

bool share_begin(Renderer *r)
{
    const double mean = may_share(r) ? mean_to_share(r) : 0;
    if (!(mean > 0)) {
        return true;
    }
    const double quantum = exp2(floor(log2(mean)) - QUANTUM_BITS);
    if (!film_share(&r->film, quantum, reach_of(&r->filter))) {
        return false;
    }
    share_use_quantum(r, quantum);
    share_fill_cells(&r->sharing, &r->filter);
    r->sharing.windows = mem_alloc_zeroed(r->options.threads, sizeof *r->sharing.windows);
    const size_t border = 2 * (size_t)r->film.reach;
    const size_t columns = r->tiles.tile_width + border, rows = r->tiles.tile_height + border;
    bool ok = r->sharing.windows;
    for (unsigned i = 0; ok && i < r->options.threads; ++i) {
        ShareWindow *window = &r->sharing.windows[i];
        *window = (ShareWindow){.columns = columns, .rows = rows};
        window->sums = mem_alloc_zeroed(columns * rows, sizeof *window->sums);
        ok = window->sums;
    }
    return ok;
}

void share_end(Renderer *r)
{
    for (unsigned i = 0; r->sharing.windows && i < r->options.threads; ++i) {
        mem_free(r->sharing.windows[i].sums);
    }
    mem_free(r->sharing.windows);
}

// --- Tiles ---------------------------------------------------------------------------------------

ShareWindow *share_open(Renderer *r, unsigned worker, const Tile *tile)
{
    if (!r->sharing.windows) {
        return NULL;
    }
    ShareWindow *window = &r->sharing.windows[worker];
    window->x0 = (int64_t)tile->x0 - r->film.reach;
    window->y0 = (int64_t)tile->y0 - r->film.reach;
    return window;
}

static void add_gain(FilmGain *gain, ShareQuanta *sum)
{
    for (int i = 0; i < 3; ++i) {
        if (sum->color[i] != 0) {
            __atomic_fetch_add(&gain->sum[i], (int64_t)sum->color[i], __ATOMIC_RELAXED);
        }
    }
    *sum = (ShareQuanta){{0}};
}

void share_close(Renderer *r, ShareWindow *window)
{
    for (size_t j = 0; window && j < window->rows; ++j) {
        const int64_t y = window->y0 + (int64_t)j;
        for (size_t i = 0; y >= 0 && y < r->film.height && i < window->columns; ++i) {
            const int64_t x = window->x0 + (int64_t)i;
            if (x >= 0 && x < r->film.width) {
                FilmGain *gain = &r->film.gains[(size_t)y * r->film.width + (size_t)x];
                add_gain(gain, &window->sums[j * window->columns + i]);
            }
        }
    }
}

// --- Samples -------------------------------------------------------------------------------------

// The same, from the table where the pixel isn't near the picture's rim.
static inline const ShareDensities *densities_at(const Renderer *r, uint32_t own, uint32_t size,
                                                 double offset, ShareDensities *room)
{
    const Sharing *sharing = &r->sharing;
    if (sharing->has_cells && own >= r->film.reach && size - own > r->film.reach) {
        return &sharing->cells[filter_cell(&r->filter, offset)];
    }
    densities_around(&r->filter, own, size, offset, room);
    return room;
}

// All four numbers at once, rounded to the nearest whole ones if they are below 2^51.
typedef double Four __attribute__((vector_size(32)));

#define WHOLE(x) (((x) + 0x1.8p52) - 0x1.8p52)

// `light` in radiance, of which a quantum is 1/per_radiance.
VECTOR_CLONES static void add_to_patch(SharePatch *patch, const ShareDensities *across,
                                       const ShareDensities *down, Rgb light, double per_radiance)
{
    const Four quanta = (Four){(double)light.r, (double)light.g, (double)light.b, 0} * per_radiance;
    const double scale = across->over_sum * down->over_sum;
    for (int j = 0; j < down->count; ++j) {
        ShareQuanta *to = &patch->at[SHARE_REACH + down->first + j][SHARE_REACH + across->first];
        const double row = down->items[j] * scale;
        for (int i = 0; i < across->count; ++i) {
            Four sum;
            memcpy(&sum, &to[i], sizeof sum);
            sum += WHOLE(quanta * (across->items[i] * row));
            memcpy(&to[i], &sum, sizeof sum);
        }
    }
    Four own;
    memcpy(&own, &patch->at[SHARE_REACH][SHARE_REACH], sizeof own);
    own -= WHOLE(quanta);
    memcpy(&patch->at[SHARE_REACH][SHARE_REACH], &own, sizeof own);
}

void share_add(const Renderer *r, ShareWindow *window, uint32_t x, uint32_t y,
               const double offset[2], Rgb light)
{
    const double scale = r->sharing.per_radiance, most = (double)rgb_max(light) * scale;
    if (!(most > 0 && most < MOST_QUANTA)) {
        return; // a pixel keeps what is too bright for itself
    }
    ShareDensities across, down;
    add_to_patch(&window->patch, densities_at(r, x, r->film.width, offset[0], &across),
                 densities_at(r, y, r->film.height, offset[1], &down), light, scale);
}

void share_drop(ShareWindow *window)
{
    window->patch = (SharePatch){0};
}

void share_keep(const Renderer *r, ShareWindow *window, uint32_t x, uint32_t y)
{
    const size_t reach = r->film.reach, side = 2 * reach + 1, skip = SHARE_REACH - reach;
    const size_t left = (size_t)(x - window->x0) - reach, top = (size_t)(y - window->y0) - reach;
    for (size_t j = 0; j < side; ++j) {
        ShareQuanta *to = &window->sums[(top + j) * window->columns + left];
        ShareQuanta *from = &window->patch.at[skip + j][skip];
        for (size_t i = 0; i < side; ++i) {
            for (int c = 0; c < 4; ++c) {
                to[i].color[c] += from[i].color[c];
                from[i].color[c] = 0;
            }
        }
    }
}
