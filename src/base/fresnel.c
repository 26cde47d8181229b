#include "base/fresnel.h"

// cos_t from Snell's law; negative under total internal reflection.
static double snell(double cos_i, double eta)
{
    double sin2 = (1 - cos_i * cos_i) / (eta * eta);
    return sin2 <= 1 ? sqrt(1 - sin2) : -1;
}

double fresnel_dielectric(double cos_i, double eta, double *cos_t)
{
    double ct = snell(cos_i, eta);
    if (cos_t) {
        *cos_t = greater(ct, 0);
    }
    if (ct < 0) {
        return 1;
    }
    double rs = (cos_i - eta * ct) / (cos_i + eta * ct);
    double rp = (ct - eta * cos_i) / (ct + eta * cos_i);
    // Along a grazing ray between equal media both quotients are 0/0: nothing is reflected.
    double f = 0.5 * (rs * rs + rp * rp);
    return isfinite(f) ? f : 0;
}

double fresnel_schlick(double f0, double cos_i)
{
    double m = lesser(greater(1 - cos_i, 0), 1), m2 = m * m;
    return f0 + (1 - f0) * m2 * m2 * m;
}

double fresnel_f0(double eta)
{
    double q = (1 - eta) / (1 + eta);
    return q * q;
}

double fresnel_dielectric_schlick(double cos_i, double eta, double *cos_t)
{
    double ct = snell(cos_i, eta);
    if (cos_t) {
        *cos_t = greater(ct, 0);
    }
    if (ct < 0) {
        return 1;
    }
    // No interface at all: the formula alone would reflect at grazing angles.
    return eta == 1 ? 0 : fresnel_schlick(fresnel_f0(eta), eta < 1 ? ct : cos_i);
}

double fresnel_conductor(double cos_i, double eta, double k)
{
    double c2 = cos_i * cos_i, s2 = 1 - c2;
    double eta2 = eta * eta, k2 = k * k;
    double t0 = eta2 - k2 - s2;
    double a2b2 = sqrt(t0 * t0 + 4 * eta2 * k2); // a² + b²
    double a = sqrt(greater(0.5 * (a2b2 + t0), 0));
    double t1 = a2b2 + c2, t2 = 2 * a * cos_i;
    double rs = (t1 - t2) / (t1 + t2);
    double t3 = c2 * a2b2 + s2 * s2, t4 = t2 * s2;
    double rp = rs * (t3 - t4) / (t3 + t4);
    double f = 0.5 * (rp + rs);
    return isfinite(f) ? f : 1; // 0/0 at the very edge, cos_i = 0
}

Rgb fresnel_metal(double cos_i, Rgb eta, Rgb k)
{
    return rgb((float)fresnel_conductor(cos_i, (double)eta.r, (double)k.r),
               (float)fresnel_conductor(cos_i, (double)eta.g, (double)k.g),
               (float)fresnel_conductor(cos_i, (double)eta.b, (double)k.b));
}

double fresnel_conductor_f0(double eta, double k)
{
    return ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k);
}

double fresnel_dielectric_mean(double eta)
{
    if (eta < 1) {
        return 1 - eta * eta * (1 - fresnel_dielectric_mean(1 / eta));
    }
    if (eta < 1 + 1e-5) {
        return (eta - 1) / 3; // its tangent; the closed form is 0/0 here
    }
    double n = eta, n2 = n * n, n4 = n2 * n2;
    double up = n2 + 1, down = n4 - 1;
    return 0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
           n2 * (n2 - 1) * (n2 - 1) / (up * up * up) * log((n - 1) / (n + 1)) -
           2 * n2 * n * (n2 + 2 * n - 1) / (up * down) +
           8 * n4 * (n4 + 1) / (up * down * down) * log(n);
}

double fresnel_schlick_mean(double f0)
{
    return f0 + (1 - f0) / 21;
}

double fresnel_conductor_mean(double eta, double k)
{
    enum { N = 256 }; // midpoints; the integrand is smooth
    double sum = 0;
    for (int i = 0; i < N; ++i) {
        double c = (i + 0.5) / N;
        sum += 2 * c * fresnel_conductor(c, eta, k) / N;
    }
    return sum;
}

bool refract(Vec3 w, Vec3 n, double eta, Vec3 *wt)
{
    double ct = snell(dot(w, n), eta);
    if (ct < 0) {
        return false;
    }
    *wt = refract_with(w, n, eta, ct);
    return true;
}
