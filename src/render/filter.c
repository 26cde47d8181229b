#include "render/filter.h"

#include "base/hot.h"
#include "base/vec.h"

double filter_default_width(FilterKind kind)
{
    switch (kind) {
    case FILTER_BOX:
        return 1;
    case FILTER_TENT:
        return 2;
    case FILTER_GAUSSIAN:
    case FILTER_BLACKMAN_HARRIS:
        break;
    case FILTER_CENTER:
        return 0;
    }
    return 3;
}

double filter_cumulative(FilterKind kind, double x)
{
    switch (kind) {
    case FILTER_BOX:
    case FILTER_CENTER: // of width 0
        return x;
    case FILTER_TENT:
        return x < 0.5 ? 2 * x * x : 1 - 2 * (1 - x) * (1 - x);
    case FILTER_GAUSSIAN: {
        // Cut at three standard deviations to either side.
        const double cut = erf(3 / sqrt(2));
        return 0.5 + 0.5 * erf((6 * x - 3) / sqrt(2)) / cut;
    }
    case FILTER_BLACKMAN_HARRIS:
        break;
    }
    // Harris 1978: a0 - a1 cos 2πx + a2 cos 4πx - a3 cos 6πx, integrated and divided by a0.
    const double a0 = 0.35875, a1 = 0.48829, a2 = 0.14128, a3 = 0.01168, t = 2 * PI * x;
    return x - (a1 * sin(t) - a2 * sin(2 * t) / 2 + a3 * sin(3 * t) / 3) / (2 * PI * a0);
}

void filter_init(PixelFilter *filter, FilterKind kind, double width)
{
    filter->kind = kind;
    filter->width = width > 0 && kind != FILTER_CENTER ? width : filter_default_width(kind);
    filter->cells = filter->width > 0 ? FILTER_CELLS / filter->width : 0;
    // The left half, mirrored, so that the mean is exactly 0.
    filter->mass[0] = 0;
    filter->mass[FILTER_CELLS] = 1;
    for (int i = 1; i <= FILTER_CELLS / 2; ++i) {
        const double mass = filter_cumulative(kind, (double)i / FILTER_CELLS);
        filter->mass[i] = i == FILTER_CELLS / 2 ? 0.5 : fmax(mass, filter->mass[i - 1]);
        filter->mass[FILTER_CELLS - i] = 1 - filter->mass[i];
    }
    for (int i = 0; i < FILTER_CELLS; ++i) {
        filter->stretch[i] = 1 / (FILTER_CELLS * (filter->mass[i + 1] - filter->mass[i]));
        filter->density[i] = 1 / (filter->stretch[i] * filter->width);
    }
    uint16_t cell = 0;
    for (int i = 0; i < FILTER_CELLS; ++i) {
        while (filter->mass[cell + 1] <= (double)i / FILTER_CELLS) {
            ++cell;
        }
        filter->guide[i] = cell;
    }
}

HOT double filter_sample(const PixelFilter *filter, float u)
{
    if (!(filter->width > 0)) {
        return 0;
    }
    const double v = (double)u;
    int cell = filter->guide[(int)(v * FILTER_CELLS)];
    cell += filter->mass[cell + 1] <= v; // no branch: half of the numbers take either
    while (filter->mass[cell + 1] <= v) {
        ++cell;
    }
    const double x = cell * (1.0 / FILTER_CELLS) + (v - filter->mass[cell]) * filter->stretch[cell];
    return (x - 0.5) * filter->width;
}
