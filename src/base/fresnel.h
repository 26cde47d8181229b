// Reflection and refraction at a smooth interface. Cosines are of angles to the interface's normal;
// eta is the index of refraction on the far side over that on the near side (where the light or the
// viewer is): nt/ni in the slides, whose r is 1/eta.
#ifndef BASE_FRESNEL_H
#define BASE_FRESNEL_H

#include "base/vec.h"

// The fraction of unpolarised light that a dielectric reflects (slides, section 3.2):
//   F = 1/2 [((ni ci - nt ct)/(ni ci + nt ct))² + ((ni ct - nt ci)/(ni ct + nt ci))²]
// with cos_i in [0, 1], eta > 0; 1 under total internal reflection. *cos_t (may be NULL) gets the
// cosine of the refracted direction, 0 under total internal reflection.
double fresnel_dielectric(double cos_i, double eta, double *cos_t);
// Schlick's approximation of the same (slides, sections 3.2 and 3.4), f0 + (1 - f0)(1 - c)^5. Seen
// from the denser side, c is the cosine in the thinner medium, so that both directions of a ray
// agree, as they do with the exact formula; 1 under total internal reflection.
double fresnel_dielectric_schlick(double cos_i, double eta, double *cos_t);
// f0 + (1 - f0)(1 - cos_i)^5
double fresnel_schlick(double f0, double cos_i);
// ((ni - nt)/(ni + nt))²: reflection along the normal.
double fresnel_f0(double eta);
// The fraction that a conductor of complex index eta + i k (over that of the medium before it)
// reflects of unpolarised light (Born and Wolf, 14.2).
double fresnel_conductor(double cos_i, double eta, double k);
// The same for red, green and blue.
Rgb fresnel_metal(double cos_i, Rgb eta, Rgb k);
// The same along the normal: ((eta - 1)² + k²)/((eta + 1)² + k²).
double fresnel_conductor_f0(double eta, double k);

// Means over a uniformly lit hemisphere, 2 ∫ F(c) c dc over [0, 1].
// Dielectrics: closed form (Walsh 1926), of relative error below 1e-5; for eta < 1 by
// 1 - eta² (1 - mean of 1/eta), which conservation of energy asks for.
double fresnel_dielectric_mean(double eta);
double fresnel_schlick_mean(double f0);
double fresnel_conductor_mean(double eta, double k); // by quadrature

// 2 (w·n) n - w: w mirrored about n.
static inline Vec3 reflect(Vec3 w, Vec3 n)
{
    return sub(scale(n, 2 * dot(w, n)), w);
}
// Snell's law (slides, section 3.2): the direction into which w (pointing away from the interface,
// w·n > 0) is refracted, wt = (r ci - ct) n - r wi with r = 1/eta, given the cosine that
// fresnel_dielectric found.
static inline Vec3 refract_with(Vec3 w, Vec3 n, double eta, double cos_t)
{
    double r = 1 / eta;
    return normalize(sub(scale(n, r * dot(w, n) - cos_t), scale(w, r)));
}
// False under total internal reflection; *wt is then untouched.
bool refract(Vec3 w, Vec3 n, double eta, Vec3 *wt);

#endif
