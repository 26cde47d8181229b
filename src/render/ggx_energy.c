#include "render/ggx_energy.h"

#include "base/vec.h"

enum { ROWS = GGX_ENERGY_ROWS, COLUMNS = GGX_ENERGY_COLUMNS };

// Made by tools/ggx_energy_table.c, as is MEAN: albedo in 1e-6.
static const int ENERGY[ROWS][COLUMNS] = {
#include "render/ggx_energy_table.inc"
};
static const int MEAN[ROWS] = {
#include "render/ggx_energy_mean.inc"
};

// A Catmull-Rom spline through the values at places 0 to count - 1, spaced by `stride`; at the
// ends the values go on in a straight line.
static double spline(const int *values, int count, int stride, int place, double f)
{
    double p[4];
    for (int k = 0; k < 4; ++k) {
        int i = place - 1 + k;
        if (i < 0) {
            p[k] = 2.0 * values[0] - values[stride];
        } else if (i >= count) {
            p[k] = 2.0 * values[(count - 1) * stride] - values[(count - 2) * stride];
        } else {
            p[k] = values[i * stride];
        }
    }
    return p[1] + 0.5 * f *
                      (p[2] - p[0] +
                       f * (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3] +
                            f * (3 * (p[1] - p[2]) + p[3] - p[0])));
}

// The cell that x in [0, 1] lies in, and where in it.
static int cell(double x, int count, double *f)
{
    double place = fmin(fmax(x, 0), 1) * (count - 1);
    int i = (int)place;
    i = i > count - 2 ? count - 2 : i;
    *f = place - i;
    return i;
}

double ggx_energy(double alpha, double mu)
{
    double y = mu + alpha > 0 ? mu * (1 + alpha) / (mu + alpha) : 0, fx, fy;
    int column = cell(asin(sqrt(fmin(fmax(y, 0), 1))) * (2 / PI), COLUMNS, &fx),
        row = cell(alpha, ROWS, &fy);
    double p[4]; // of the four rows around; rows go on beyond the table in a straight line
    for (int k = 0; k < 4; ++k) {
        int j = row - 1 + k;
        j = j < 0 ? 0 : j >= ROWS ? ROWS - 1 : j;
        p[k] = spline(ENERGY[j], COLUMNS, 1, column, fx);
    }
    if (row == 0) {
        p[0] = 2 * p[1] - p[2];
    } else if (row == ROWS - 2) {
        p[3] = 2 * p[2] - p[1];
    }
    double e =
        p[1] +
        0.5 * fy *
            (p[2] - p[0] +
             fy * (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3] + fy * (3 * (p[1] - p[2]) + p[3] - p[0])));
    return fmin(fmax(e * 1e-6, 0), 1);
}

double ggx_energy_mean(double alpha)
{
    double f;
    int row = cell(alpha, ROWS, &f);
    return fmin(spline(MEAN, ROWS, 1, row, f) * 1e-6, 1);
}
