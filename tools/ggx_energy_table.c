// Makes the tables of src/render/ggx_energy.c: the albedo of perfectly reflecting GGX facets.
//
//   cc -O2 -Isrc tools/ggx_energy_table.c src/base/microfacet.c -lm -o /tmp/table
//   /tmp/table energy > src/render/ggx_energy_table.inc
//   cc -O2 -Isrc tools/ggx_energy_table.c src/base/microfacet.c src/render/ggx_energy.c -lm \
//     -DWITH_TABLE -o /tmp/table
//   /tmp/table mean > src/render/ggx_energy_mean.inc      (zeros at first, so that it compiles)
#include "render/ggx_energy.h"
#include "base/microfacet.h"

#include <stdio.h>
#include <string.h>

// The mean of G2/G1 over the visible normals, by midpoints. Density is moved to where the normals
// lean most (v = 1 - t³), and only half of the circle is needed.
static double albedo(double alpha, double mu)
{
    enum { N = 512 };
    Ggx ggx = {alpha, alpha};
    Vec3 wo = vec3(sqrt(1 - mu * mu), 0, mu);
    double sum = 0;
    for (int i = 0; i < N; ++i) {
        for (int j = 0; j < N; ++j) {
            double t = (j + 0.5) / N;
            Vec3 m = ggx_sample_visible(ggx, wo, (i + 0.5) / N / 2, 1 - t * t * t);
            Vec3 wi = sub(scale(m, 2 * dot(wo, m)), wo);
            if (wi.z > 0) {
                sum += 3 * t * t * ggx_g2(ggx, wi, wo) / ggx_g1(ggx, wo);
            }
        }
    }
    return sum / N / N;
}

static void print_energy(void)
{
    for (int j = 0; j < GGX_ENERGY_ROWS; ++j) {
        double alpha = fmax((double)j / (GGX_ENERGY_ROWS - 1), 1e-4);
        printf("{");
        for (int i = 0; i < GGX_ENERGY_COLUMNS; ++i) {
            double x = sin(0.5 * PI * i / (GGX_ENERGY_COLUMNS - 1));
            double mu = fmin(1, alpha * x * x / (1 + alpha - x * x));
            printf("%.0f,%s", i == 0 ? 1e6 : 1e6 * albedo(alpha, mu), i % 8 == 7 ? "\n" : " ");
        }
        printf("},\n");
    }
}

#ifdef WITH_TABLE
static void print_mean(void)
{
    enum { N = 200000 };
    for (int j = 0; j < GGX_ENERGY_ROWS; ++j) {
        double sum = 0;
        for (int i = 0; i < N; ++i) {
            double mu = (i + 0.5) / N;
            sum += 2 * mu * ggx_energy((double)j / (GGX_ENERGY_ROWS - 1), mu) / N;
        }
        printf("%.0f,%s", 1e6 * sum, j % 8 == 7 ? "\n" : " ");
    }
}
#endif

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "energy") == 0) {
        print_energy();
        return 0;
    }
#ifdef WITH_TABLE
    if (argc == 2 && strcmp(argv[1], "mean") == 0) {
        print_mean();
        return 0;
    }
#endif
    fprintf(stderr, "usage: table energy|mean\n");
    return 2;
}
