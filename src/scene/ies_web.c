// Intensities between the angles of a photometric table, and its flux.
#include "scene/ies.h"

// The cell of ascending `angles` that `angle` lies in and how far in it; false outside.
static bool find_cell(const double *angles, uint32_t count, double angle, uint32_t *cell,
                      double *part)
{
    // Angles computed from directions may be off by rounding: 90° is meant to be in 0 to 90.
    const double slack = 1e-9;
    if (!(angle >= angles[0] - slack && angle <= angles[count - 1] + slack)) {
        return false;
    }
    uint32_t low = 0, high = count - 1;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (angles[middle] <= angle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    *cell = low;
    *part = fmin(fmax((angle - angles[low]) / (angles[high] - angles[low]), 0), 1);
    return true;
}

// Brings a horizontal angle into the table's range.
static double fold(const IesWeb *web, double h)
{
    if (web->type != IES_TYPE_C) {
        return web->symmetry == IES_HALF ? fabs(h) : h;
    }
    h = h < 0 ? h + 2 * PI : h;
    switch (web->symmetry) {
    case IES_QUADRANT:
        h = h > PI ? 2 * PI - h : h;
        return h > PI / 2 ? PI - h : h;
    case IES_HALF:
        return h > PI ? 2 * PI - h : h;
    case IES_HALF_90:
        return h < PI / 2 ? PI - h : h > 3 * PI / 2 ? 3 * PI - h : h;
    default:
        return h;
    }
}

static double interpolate(const IesWeb *web, double vertical, double horizontal)
{
    uint32_t v, h = 0;
    double in_v, in_h = 0;
    if (web->mirror_vertical) {
        vertical = fabs(vertical);
    }
    if (!find_cell(web->vertical, web->vertical_count, vertical, &v, &in_v) ||
        (web->symmetry != IES_ROTATIONAL &&
         !find_cell(web->horizontal, web->horizontal_count, fold(web, horizontal), &h, &in_h))) {
        return 0;
    }
    const double *row = web->candela + (size_t)h * web->vertical_count + v;
    const double *next = web->symmetry == IES_ROTATIONAL ? row : row + web->vertical_count;
    double here = row[0] + (row[1] - row[0]) * in_v, there = next[0] + (next[1] - next[0]) * in_v;
    return here + (there - here) * in_h;
}

static double clamped_asin(double x)
{
    return asin(fmin(fmax(x, -1), 1));
}

double ies_candela(const IesWeb *web, double d, double u, double s)
{
    switch (web->type) {
    case IES_TYPE_B:
        return interpolate(web, atan2(u, d), clamped_asin(s));
    case IES_TYPE_A:
        return interpolate(web, clamped_asin(u), atan2(s, d));
    default:
        return interpolate(web, atan2(hypot(u, s), d), atan2(-s, u));
    }
}

// ∫ (a + (b - a) t) w(x) dx from x0 to x1, t the part of the way, for a weight whose integral up to
// x is W and whose W's integral is V: [(a + (b - a) t) W] - (b - a)/(x1 - x0) [V].
static double weighted(double a, double b, double x0, double x1, double w0, double w1, double v0,
                       double v1)
{
    return b * w1 - a * w0 - (b - a) / (x1 - x0) * (v1 - v0);
}

// Over a vertical angle's cell with weight sin (type C: W = -cos, V = -sin) or cos (type A: W =
// sin, V = -cos).
static double vertical_integral(const IesWeb *web, double a, double b, double x0, double x1)
{
    return web->type == IES_TYPE_C ? weighted(a, b, x0, x1, -cos(x0), -cos(x1), -sin(x0), -sin(x1))
                                   : weighted(a, b, x0, x1, sin(x0), sin(x1), -cos(x0), -cos(x1));
}

// The integral over one cell, bilinear in both angles: the solid angle's weight depends on one of
// them only, so the mean over the other is taken first.
static double cell_integral(const IesWeb *web, uint32_t v, uint32_t h)
{
    const double *row = web->candela + (size_t)h * web->vertical_count + v;
    const double *next = row + web->vertical_count;
    double v0 = web->vertical[v], v1 = web->vertical[v + 1];
    double h0 = web->horizontal[h], h1 = web->horizontal[h + 1];
    if (web->type == IES_TYPE_B) {
        double a = (row[0] + row[1]) / 2, b = (next[0] + next[1]) / 2;
        return (v1 - v0) * weighted(a, b, h0, h1, sin(h0), sin(h1), -cos(h0), -cos(h1));
    }
    double a = (row[0] + next[0]) / 2, b = (row[1] + next[1]) / 2;
    return (h1 - h0) * vertical_integral(web, a, b, v0, v1);
}

double ies_lumens(const IesWeb *web)
{
    double sum = 0;
    if (web->symmetry == IES_ROTATIONAL) {
        for (uint32_t v = 0; v + 1 < web->vertical_count; ++v) {
            sum += 2 * PI *
                   vertical_integral(web, web->candela[v], web->candela[v + 1], web->vertical[v],
                                     web->vertical[v + 1]);
        }
        return sum;
    }
    for (uint32_t h = 0; h + 1 < web->horizontal_count; ++h) {
        for (uint32_t v = 0; v + 1 < web->vertical_count; ++v) {
            sum += cell_integral(web, v, h);
        }
    }
    double copies = web->symmetry == IES_QUADRANT ? 4 : web->symmetry == IES_FULL ? 1 : 2;
    return sum * copies * (web->mirror_vertical ? 2 : 1);
}

double ies_reach(const IesWeb *web)
{
    if (web->type != IES_TYPE_C) {
        double v = fmax(-web->vertical[0], web->vertical[web->vertical_count - 1]);
        double h = fmax(-web->horizontal[0], web->horizontal[web->horizontal_count - 1]);
        return fmax(v, h) > PI / 2 + 1e-9 ? PI : PI / 2;
    }
    for (uint32_t v = web->vertical_count; v-- > 0;) {
        for (uint32_t h = 0; h < web->horizontal_count; ++h) {
            if (web->candela[(size_t)h * web->vertical_count + v] > 0) {
                return web->vertical[v + 1 < web->vertical_count ? v + 1 : v];
            }
        }
    }
    return 0;
}

double ies_tilt_factor(const IesWeb *web, double angle)
{
    if (web->tilt_count == 0) {
        return 1;
    }
    uint32_t last = web->tilt_count - 1;
    if (angle <= web->tilt_angles[0] || last == 0) {
        return web->tilt_factors[0];
    }
    uint32_t cell;
    double part;
    if (!find_cell(web->tilt_angles, web->tilt_count, angle, &cell, &part)) {
        return web->tilt_factors[last];
    }
    const double *factor = web->tilt_factors + cell;
    return factor[0] + (factor[1] - factor[0]) * part;
}
