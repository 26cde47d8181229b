// Statistics for tests whose results are random: distributions, running means, chi-squared tests.
// Every test states its significance; a family of K tests at the whole's α uses α' of Šidák.
#ifndef TEST_STATISTICS_H
#define TEST_STATISTICS_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define NEAR(a, b, tolerance) (fabs((double)(a) - (double)(b)) <= (tolerance))

// The level of each of `count` independent tests that makes the whole family's `alpha`.
static inline double sidak(double alpha, double count)
{
    return -expm1(log1p(-alpha) / count);
}

// The regularized upper incomplete gamma function Q(a, x): by its series or its continued fraction
// (Numerical Recipes, 6.2).
static inline double gamma_q(double a, double x)
{
    if (!(x > 0)) {
        return 1;
    }
    double front = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1) {
        double term = 1 / a, sum = term;
        for (double n = a + 1; fabs(term) > 1e-16 * fabs(sum); ++n) {
            term *= x / n;
            sum += term;
        }
        return 1 - sum * front;
    }
    double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
    for (int i = 1; i < 100000; ++i) {
        double an = -i * (i - a);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        double delta = d * c;
        h *= delta;
        if (fabs(delta - 1) < 1e-15) {
            break;
        }
    }
    return front * h;
}

// The chance that chi-squared with `freedom` degrees of freedom is at least `value`.
static inline double chi_squared_p(double value, double freedom)
{
    return gamma_q(freedom / 2, value / 2);
}

// The regularized incomplete beta function I_x(a, b) (Numerical Recipes, 6.4).
static inline double beta_i(double a, double b, double x)
{
    if (x <= 0 || x >= 1) {
        return x <= 0 ? 0 : 1;
    }
    if (x > (a + 1) / (a + b + 2)) {
        return 1 - beta_i(b, a, 1 - x);
    }
    double front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x)) / a;
    double c = 1, d = 1 / (1 - (a + b) * x / (a + 1)), h = d;
    for (int m = 1; m < 10000; ++m) {
        double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        d = 1 / (1 + even * d);
        c = 1 + even / c;
        h *= d * c;
        double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / (1 + odd * d);
        c = 1 + odd / c;
        h *= d * c;
        if (fabs(d * c - 1) < 1e-15) {
            break;
        }
    }
    return front * h;
}

// The chance that Student's t with `freedom` degrees of freedom is at least |t| away from zero.
static inline double student_p(double t, double freedom)
{
    return beta_i(freedom / 2, 0.5, freedom / (freedom + t * t));
}

// The t that student_p takes to `p`.
static inline double student_quantile(double p, double freedom)
{
    double low = 0, high = 1e6;
    for (int i = 0; i < 200; ++i) {
        double middle = (low + high) / 2;
        if (student_p(middle, freedom) > p) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return (low + high) / 2;
}

// Welford's running mean and variance.
typedef struct Running {
    double count, mean, square;
} Running;

static inline void running_add(Running *r, double x)
{
    double delta = x - r->mean;
    r->count += 1;
    r->mean += delta / r->count;
    r->square += delta * (x - r->mean);
}

// The standard error of the mean.
static inline double running_error(const Running *r)
{
    return r->count > 1 ? sqrt(r->square / (r->count - 1) / r->count) : INFINITY;
}

// Pearson's test: observed counts against expected ones. Cells of fewer than 5 expected are pooled
// (in order). The p-value; 0 where something was observed that can't be.
static inline double chi_squared_test(const double *observed, const double *expected, size_t count)
{
    double sum = 0, freedom = -1, pooled_o = 0, pooled_e = 0;
    for (size_t i = 0; i < count; ++i) {
        if (expected[i] <= 0 && observed[i] > 0) {
            return 0;
        }
        pooled_o += observed[i];
        pooled_e += expected[i];
        if (pooled_e >= 5) {
            sum += (pooled_o - pooled_e) * (pooled_o - pooled_e) / pooled_e;
            freedom += 1;
            pooled_o = pooled_e = 0;
        }
    }
    if (pooled_e > 0) { // the rest joins as one cell: less than 5 expected, but not forgotten
        sum += (pooled_o - pooled_e) * (pooled_o - pooled_e) / fmax(pooled_e, 1);
        freedom += 1;
    }
    return freedom < 1 ? 1 : chi_squared_p(sum, freedom);
}

// A generator for tests: PCG32 (O'Neill 2014).
typedef struct TestRandom {
    uint64_t state;
} TestRandom;

static inline uint32_t test_random_u32(TestRandom *random)
{
    uint64_t old = random->state;
    random->state = old * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(((old >> 18) ^ old) >> 27), turn = (uint32_t)(old >> 59);
    return (x >> turn) | (x << (-turn & 31));
}
static inline float test_random(TestRandom *random)
{
    return (float)(test_random_u32(random) >> 8) * 0x1p-24f;
}

#endif
