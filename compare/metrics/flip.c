#include "flip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Section 4.1.3 and 4.3.
static const double QC = 0.7, PC = 0.4, PT = 0.95, QF = 0.5, FEATURE_WIDTH = 0.082;
static const double PI = 3.14159265358979323846;

double flip_pixels_per_degree(double distance, double width, double resolution)
{
    return distance * (resolution / width) * (PI / 180);
}

// --- Colors --------------------------------------------------------------------------------------

static const double TO_XYZ[3][3] = {
    {10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
    {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};

// X, Y, Z over those of white.
static void to_relative_xyz(const double rgb[3], double out[3])
{
    for (int i = 0; i < 3; ++i) {
        double white = TO_XYZ[i][0] + TO_XYZ[i][1] + TO_XYZ[i][2];
        out[i] = (TO_XYZ[i][0] * rgb[0] + TO_XYZ[i][1] * rgb[1] + TO_XYZ[i][2] * rgb[2]) / white;
    }
}

// Y, Cx, Cz: linear in light, so that it can be filtered.
static void to_opponent(const double rgb[3], double out[3])
{
    double t[3];
    to_relative_xyz(rgb, t);
    out[0] = 116 * t[1] - 16;
    out[1] = 500 * (t[0] - t[1]);
    out[2] = 200 * (t[1] - t[2]);
}

static double determinant(const double m[3][3])
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

// By Cramer's rule.
static void from_opponent(const double opponent[3], double out[3])
{
    double y = (opponent[0] + 16) / 116;
    const double t[3] = {y + opponent[1] / 500, y, y - opponent[2] / 200};
    for (int column = 0; column < 3; ++column) {
        double m[3][3];
        memcpy(m, TO_XYZ, sizeof m);
        for (int row = 0; row < 3; ++row) {
            m[row][column] = t[row] * (TO_XYZ[row][0] + TO_XYZ[row][1] + TO_XYZ[row][2]);
        }
        out[column] = fmin(fmax(determinant((const double(*)[3])m) / determinant(TO_XYZ), 0), 1);
    }
}

static double lab_curve(double t)
{
    const double d = 6.0 / 29;
    return t > d * d * d ? cbrt(t) : t / (3 * d * d) + 4.0 / 29;
}

// L*a*b* with Hunt's effect: chroma counts less where it is dark.
static void to_hunt_lab(const double rgb[3], double out[3])
{
    double t[3];
    to_relative_xyz(rgb, t);
    double x = lab_curve(t[0]), y = lab_curve(t[1]), z = lab_curve(t[2]);
    out[0] = 116 * y - 16;
    out[1] = 0.01 * out[0] * 500 * (x - y);
    out[2] = 0.01 * out[0] * 200 * (y - z);
}

// The HyAB distance of Abasi, Amani Tehran and Fairchild.
static double hyab(const double a[3], const double b[3])
{
    return fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]);
}

static double distance(const double reference[3], const double test[3])
{
    double a[3], b[3];
    to_hunt_lab(reference, a);
    to_hunt_lab(test, b);
    return pow(hyab(a, b), QC);
}

// Up to PC of the largest distance, that of green and blue, fills [0, PT]; the rest [PT, 1].
double flip_color_difference(const double reference[3], const double test[3])
{
    static const double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    double largest = distance(green, blue), knee = PC * largest;
    double d = distance(reference, test);
    return d < knee ? PT / knee * d : fmin(PT + (d - knee) / (largest - knee) * (1 - PT), 1);
}

// --- Kernels -------------------------------------------------------------------------------------

static bool kernel_alloc(FlipKernel *kernel, double radius)
{
    int side = 2 * (int)radius + 1;
    kernel->radius = (int)radius;
    kernel->weights = malloc((size_t)side * (size_t)side * sizeof *kernel->weights);
    return kernel->weights != NULL;
}

void flip_kernel_free(FlipKernel *kernel)
{
    free(kernel->weights);
    kernel->weights = NULL;
}

static double gaussians(FlipChannel channel, double x2)
{
    // Table 1: a1, b1, a2, b2 of each channel.
    static const double parameters[3][4] = {
        {1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};
    const double *p = parameters[channel];
    return p[0] * sqrt(PI / p[1]) * exp(-PI * PI * x2 / p[1]) +
           p[2] * sqrt(PI / p[3]) * exp(-PI * PI * x2 / p[3]);
}

bool flip_contrast_kernel(FlipChannel channel, double pixels_per_degree, FlipKernel *out)
{
    const double widest = sqrt(0.04 / (2 * PI * PI)); // the largest standard deviation, degrees
    if (!kernel_alloc(out, ceil(3 * widest * pixels_per_degree))) {
        return false;
    }
    double sum = 0, *weight = out->weights;
    for (int y = -out->radius; y <= out->radius; ++y) {
        for (int x = -out->radius; x <= out->radius; ++x) {
            double r2 = (double)(x * x + y * y) / (pixels_per_degree * pixels_per_degree);
            sum += *weight++ = gaussians(channel, r2);
        }
    }
    while (weight != out->weights) {
        *--weight /= sum;
    }
    return true;
}

bool flip_feature_kernel(bool points, double pixels_per_degree, FlipKernel *out)
{
    double deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree, s2 = deviation * deviation;
    if (!kernel_alloc(out, ceil(3 * deviation))) {
        return false;
    }
    double positive = 0, negative = 0, *weight = out->weights;
    for (int y = -out->radius; y <= out->radius; ++y) {
        for (int x = -out->radius; x <= out->radius; ++x) {
            double g = exp(-(x * x + y * y) / (2 * s2));
            *weight = points ? (x * x / s2 - 1) * g : -x * g;
            *(*weight > 0 ? &positive : &negative) += fabs(*weight);
            ++weight;
        }
    }
    while (weight != out->weights) {
        --weight;
        *weight /= *weight > 0 ? positive : negative;
    }
    return true;
}

// --- Filtering -----------------------------------------------------------------------------------

typedef struct Plane {
    int width, height;
    double *values;
} Plane;

static int clamp_index(int i, int count)
{
    return i < 0 ? 0 : i >= count ? count - 1 : i;
}

// At a pixel; beyond its edge the picture goes on as it ends. `turned`: along y instead of x.
static double filtered(const Plane *plane, const FlipKernel *kernel, int x, int y, bool turned)
{
    int side = 2 * kernel->radius + 1;
    double sum = 0;
    for (int j = 0; j < side; ++j) {
        int row = clamp_index(y + j - kernel->radius, plane->height);
        for (int i = 0; i < side; ++i) {
            int column = clamp_index(x + i - kernel->radius, plane->width);
            double weight = kernel->weights[turned ? i * side + j : j * side + i];
            sum += weight * plane->values[(size_t)row * (size_t)plane->width + (size_t)column];
        }
    }
    return sum;
}

static double feature(const Plane *plane, const FlipKernel *kernel, int x, int y)
{
    return hypot(filtered(plane, kernel, x, y, false), filtered(plane, kernel, x, y, true));
}

typedef struct Sides {
    Plane channels[2][3]; // opponent channels of reference and test
    Plane gray[2];        // (Y + 16)/116, unfiltered
    FlipKernel contrast[3], edges, points;
} Sides;

static double clip(float x)
{
    return x > 0 ? fmin((double)x, 1) : 0; // NaN is 0
}

static bool fill(const float *picture, int width, int height, Plane channels[3], Plane *gray)
{
    size_t count = (size_t)width * (size_t)height;
    for (int c = 0; c < 4; ++c) {
        Plane *plane = c < 3 ? &channels[c] : gray;
        *plane = (Plane){width, height, malloc(count * sizeof(double))};
        if (!plane->values) {
            return false;
        }
    }
    for (size_t i = 0; i < count; ++i) {
        const double rgb[3] = {clip(picture[3 * i]), clip(picture[3 * i + 1]),
                               clip(picture[3 * i + 2])};
        double opponent[3];
        to_opponent(rgb, opponent);
        for (int c = 0; c < 3; ++c) {
            channels[c].values[i] = opponent[c];
        }
        gray->values[i] = (opponent[0] + 16) / 116;
    }
    return true;
}

static double pixel_error(const Sides *s, int x, int y)
{
    double seen[2][3], edge[2], spot[2];
    for (int side = 0; side < 2; ++side) {
        double opponent[3];
        for (int c = 0; c < 3; ++c) {
            opponent[c] = filtered(&s->channels[side][c], &s->contrast[c], x, y, false);
        }
        from_opponent(opponent, seen[side]);
        edge[side] = feature(&s->gray[side], &s->edges, x, y);
        spot[side] = feature(&s->gray[side], &s->points, x, y);
    }
    double color = flip_color_difference(seen[0], seen[1]);
    double most = fmax(fabs(edge[0] - edge[1]), fabs(spot[0] - spot[1]));
    return pow(color, 1 - pow(most / sqrt(2), QF)); // section 4.4
}

bool flip(const float *reference, const float *test, int width, int height,
          double pixels_per_degree, float *error)
{
    Sides s = {0};
    bool ok = fill(reference, width, height, s.channels[0], &s.gray[0]) &&
              fill(test, width, height, s.channels[1], &s.gray[1]) &&
              flip_feature_kernel(false, pixels_per_degree, &s.edges) &&
              flip_feature_kernel(true, pixels_per_degree, &s.points);
    for (int c = 0; c < 3 && ok; ++c) {
        ok = flip_contrast_kernel((FlipChannel)c, pixels_per_degree, &s.contrast[c]);
    }
    for (int y = 0; y < height && ok; ++y) {
        for (int x = 0; x < width; ++x) {
            error[(size_t)y * (size_t)width + (size_t)x] = (float)pixel_error(&s, x, y);
        }
    }
    for (int c = 0; c < 3; ++c) {
        free(s.channels[0][c].values);
        free(s.channels[1][c].values);
        flip_kernel_free(&s.contrast[c]);
    }
    free(s.gray[0].values);
    free(s.gray[1].values);
    flip_kernel_free(&s.edges);
    flip_kernel_free(&s.points);
    return ok;
}
