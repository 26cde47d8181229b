#include "base/microfacet.h"

#include "base/angle.h"

double ggx_d(Ggx ggx, Vec3 m)
{
    if (m.z < 0) {
        return 0;
    }
    double x = m.x / ggx.alpha_x, y = m.y / ggx.alpha_y;
    double s = x * x + y * y + m.z * m.z;
    return 1 / (PI * ggx.alpha_x * ggx.alpha_y * s * s);
}

double ggx_lambda(Ggx ggx, Vec3 w)
{
    double x = ggx.alpha_x * w.x, y = ggx.alpha_y * w.y;
    return 0.5 * (sqrt(1 + (x * x + y * y) / (w.z * w.z)) - 1);
}

double ggx_g1(Ggx ggx, Vec3 w)
{
    return 1 / (1 + ggx_lambda(ggx, w));
}

double ggx_g2(Ggx ggx, Vec3 wi, Vec3 wo)
{
    return 1 / (1 + (ggx_lambda(ggx, wi) + ggx_lambda(ggx, wo))); // symmetric to the last bit
}

Vec3 ggx_sample_visible(Ggx ggx, Vec3 wo, double u, double v)
{
    // In the space where the facets are those of a hemisphere …
    Vec3 w = normalize(vec3(wo.x * ggx.alpha_x, wo.y * ggx.alpha_y, wo.z));
    // … the mirrored directions fill a spherical cap uniformly.
    const Vec2 around = circle_point(u);
    double z = (1 - v) * (1 + w.z) - w.z;
    double r = sqrt(greater(0, 1 - z * z));
    Vec3 h = add(vec3(r * around.x, r * around.y, z), w);
    return normalize(vec3(h.x * ggx.alpha_x, h.y * ggx.alpha_y, greater(h.z, 0)));
}

double ggx_visible_pdf(Ggx ggx, Vec3 wo, Vec3 m)
{
    return ggx_g1(ggx, wo) * greater(0, dot(wo, m)) * ggx_d(ggx, m) / fabs(wo.z);
}
