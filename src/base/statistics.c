#include "base/statistics.h"

double sidak(double alpha, double count)
{
    return -expm1(log1p(-alpha) / count);
}

// The regularized upper incomplete gamma function Q(a, x): by its series or its continued fraction
// (Numerical Recipes, 6.2).
double gamma_q(double a, double x)
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

double chi_squared_p(double value, double freedom)
{
    return gamma_q(freedom / 2, value / 2);
}

// The regularized incomplete beta function I_x(a, b) (Numerical Recipes, 6.4).
double beta_i(double a, double b, double x)
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

double student_p(double t, double freedom)
{
    return beta_i(freedom / 2, 0.5, freedom / (freedom + t * t));
}

double student_quantile(double p, double freedom)
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

double chi_squared_test(const double *observed, const double *expected, size_t count)
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
