// Statistics: distributions, running means, chi-squared tests.
#ifndef BASE_STATISTICS_H
#define BASE_STATISTICS_H

#include <math.h>
#include <stddef.h>

// The level of each of `count` independent tests that makes the whole family's `alpha`.
double sidak(double alpha, double count);

// The regularized upper incomplete gamma function Q(a, x): by its series or its continued fraction
// (Numerical Recipes, 6.2).
double gamma_q(double a, double x);

// The chance that chi-squared with `freedom` degrees of freedom is at least `value`.
double chi_squared_p(double value, double freedom);

// The regularized incomplete beta function I_x(a, b) (Numerical Recipes, 6.4).
double beta_i(double a, double b, double x);

// The chance that Student's t with `freedom` degrees of freedom is at least |t| away from zero.
double student_p(double t, double freedom);

// The t that student_p takes to `p`.
double student_quantile(double p, double freedom);

// Pearson's test: observed counts against expected ones. Cells of fewer than 5 expected are pooled
// (in order). The p-value; 0 where something was observed that can't be.
double chi_squared_test(const double *observed, const double *expected, size_t count);

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

#endif
