#include "base/shading_models.h"

#include "base/fresnel.h"

double phong_model(Vec3 n, Vec3 v, Vec3 l, double e, double k)
{
    if (!(dot(n, l) > 0)) {
        return 0;
    }
    return k * pow(fmax(0, dot(reflect(l, n), v)), e);
}

// The unit vector half-way between a and b; zero where they are opposite.
static Vec3 half_way(Vec3 a, Vec3 b)
{
    Vec3 h = add(a, b);
    double l = length(h);
    return l > 0 ? scale(h, 1 / l) : h;
}

double blinn_phong_model(Vec3 n, Vec3 v, Vec3 l, double e, double k)
{
    double cosine = dot(n, half_way(l, v));
    if (!(dot(n, l) > 0) || !(cosine > 0)) {
        return 0;
    }
    return k * pow(cosine, e);
}

static double rim(double f90, double cosine)
{
    return 1 + (f90 - 1) * fresnel_schlick(0, cosine);
}

double burley_model(Vec3 n, Vec3 wi, Vec3 wo, double roughness, double k)
{
    double ci = dot(n, wi), co = dot(n, wo), cos_d = dot(wi, half_way(wi, wo));
    if (!(ci > 0 && co > 0)) {
        return 0;
    }
    double f90 = 0.5 + 2 * roughness * cos_d * cos_d;
    return k / PI * rim(f90, ci) * rim(f90, co);
}

double ggx_model(Vec3 wi, Vec3 wo, Frame frame, Ggx ggx, double f0)
{
    Vec3 i = to_local(&frame, wi), o = to_local(&frame, wo), h = half_way(i, o);
    if (!(i.z > 0 && o.z > 0)) {
        return 0;
    }
    return fresnel_schlick(f0, dot(i, h)) * ggx_d(ggx, h) * ggx_g2(ggx, i, o) / (4 * i.z * o.z);
}
