#include "render/ggx_energy.h"

enum { ROWS = GGX_ENERGY_ROWS, COLUMNS = GGX_ENERGY_COLUMNS };

// Made by tools/ggx_energy_table.c, as is MEAN: albedo in 1e-6.
static const int ENERGY[ROWS][COLUMNS] = {
#include "render/ggx_energy_table.inc"
};
static const int MEAN[ROWS] = {
#include "render/ggx_energy_mean.inc"
};

// A Catmull-Rom spline between p[1] and p[2].
static double catmull_rom(const double p[4], double f)
{
    return p[1] + 0.5 * f *
                      (p[2] - p[0] +
                       f * (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3] +
                            f * (3 * (p[1] - p[2]) + p[3] - p[0])));
}

// Through the values at places 0 to count - 1; at the ends they go on in a straight line.
static double spline(const int *values, int count, int place, double f)
{
    double p[4];
    for (int k = 0; k < 4; ++k) {
        int i = place - 1 + k;
        if (i < 0) {
            p[k] = 2.0 * values[0] - values[1];
        } else if (i >= count) {
            p[k] = 2.0 * values[count - 1] - values[count - 2];
        } else {
            p[k] = values[i];
        }
    }
    return catmull_rom(p, f);
}

// The cell that x in [0, 1] lies in, and where in it.
static int cell(double x, int count, double *f)
{
    double place = lesser(greater(x, 0), 1) * (count - 1);
    int i = (int)place;
    i = i > count - 2 ? count - 2 : i;
    *f = place - i;
    return i;
}

// Where the columns put mu: t in [0, 1]; and back.
static double column_of(double alpha, double mu)
{
    double y = mu + alpha > 0 ? mu * (1 + alpha) / (mu + alpha) : 0;
    return asin(sqrt(lesser(greater(y, 0), 1))) * (2 / PI);
}
static double mu_of(double alpha, double t)
{
    double x = sin(0.5 * PI * t);
    return lesser(1, alpha * x * x / (1 + alpha - x * x));
}

double ggx_energy(double alpha, double mu)
{
    double fx, fy;
    int column = cell(column_of(alpha, mu), COLUMNS, &fx), row = cell(alpha, ROWS, &fy);
    double p[4]; // of the four rows around; rows go on beyond the table in a straight line
    for (int k = 0; k < 4; ++k) {
        int j = row - 1 + k;
        j = j < 0 ? 0 : j >= ROWS ? ROWS - 1 : j;
        p[k] = spline(ENERGY[j], COLUMNS, column, fx);
    }
    if (row == 0) {
        p[0] = 2 * p[1] - p[2];
    } else if (row == ROWS - 2) {
        p[3] = 2 * p[2] - p[1];
    }
    return lesser(greater(catmull_rom(p, fy) * 1e-6, 0), 1);
}

double ggx_energy_mean(double alpha)
{
    double f;
    int row = cell(alpha, ROWS, &f);
    return lesser(spline(MEAN, ROWS, row, f) * 1e-6, 1);
}

// --- Pairs ------------------------------------------------------------------------------------

// The mean of G2/G1 over the visible normals, as the tables above were made, with fewer points.
static double pair_albedo(Ggx ggx, Vec3 wo)
{
    enum { N = 40 };
    double sum = 0;
    for (int i = 0; i < N * N; ++i) {
        double u = (i % N + 0.5) / N, t = (i / N + 0.5) / N;
        Vec3 m = ggx_sample_visible(ggx, wo, u, 1 - t * t * t);
        Vec3 wi = sub(scale(m, 2 * dot(wo, m)), wo);
        if (wi.z > 0) {
            sum += 3 * t * t * ggx_g2(ggx, wi, wo) / ggx_g1(ggx, wo);
        }
    }
    return sum / (N * N);
}

// Of the interpolated table.
static double pair_mean(const GgxPairEnergy *energy)
{
    enum { N = 64 };
    double sum = 0;
    for (int i = 0; i < N * N; ++i) {
        double mu2 = (i % N + 0.5) / N, phi = (i / N + 0.5) / N * PI / 2, s = sqrt(1 - mu2);
        sum += ggx_pair_energy(energy, vec3(s * cos(phi), s * sin(phi), sqrt(mu2)));
    }
    return sum / (N * N);
}

void ggx_pair_energy_make(Ggx ggx, GgxPairEnergy *out)
{
    out->alpha = sqrt(ggx.alpha_x * ggx.alpha_y);
    for (int j = 0; j < GGX_PAIR_ROWS; ++j) {
        double phi = 0.5 * PI * j / (GGX_PAIR_ROWS - 1);
        out->table[j][0] = 1;
        for (int i = 1; i < GGX_PAIR_COLUMNS; ++i) {
            double mu = mu_of(out->alpha, (double)i / (GGX_PAIR_COLUMNS - 1));
            double s = sqrt(1 - mu * mu);
            out->table[j][i] = (float)pair_albedo(ggx, vec3(s * cos(phi), s * sin(phi), mu));
        }
    }
    out->mean = pair_mean(out);
}

double ggx_pair_energy(const GgxPairEnergy *energy, Vec3 w)
{
    enum { LAST_ROW = GGX_PAIR_ROWS - 1, LAST_COLUMN = GGX_PAIR_COLUMNS - 1 };
    double fx, fy, p[4];
    int column = cell(column_of(energy->alpha, w.z), GGX_PAIR_COLUMNS, &fx);
    int row = cell(atan2(fabs(w.y), fabs(w.x)) * (2 / PI), GGX_PAIR_ROWS, &fy);
    for (int k = 0; k < 4; ++k) {
        int j = row - 1 + k; // mirrored at φ = 0 and π/2
        const float *values = energy->table[j < 0 ? -j : j > LAST_ROW ? 2 * LAST_ROW - j : j];
        double q[4];
        for (int n = 0; n < 4; ++n) {
            int i = column - 1 + n;
            q[n] = i < 0 ? 2 * (double)values[0] - (double)values[1]
                   : i > LAST_COLUMN
                       ? 2 * (double)values[LAST_COLUMN] - (double)values[LAST_COLUMN - 1]
                       : (double)values[i];
        }
        p[k] = catmull_rom(q, fx);
    }
    return lesser(greater(catmull_rom(p, fy), 0), 1);
}
