// Thermal radiation and its color.
#ifndef BASE_BLACKBODY_H
#define BASE_BLACKBODY_H

#include "base/vec.h"

// Planck's law: spectral radiance in W/m²/sr/m of a black body of `temperature` kelvin at a
// wavelength in metres, both > 0. 2 h c² / λ⁵ / (exp(h c / (λ k T)) - 1) with the exact SI
// constants of 2019.
double planck_radiance(double wavelength, double temperature);

// The CIE 1931 2° color matching functions at a wavelength in nanometres, by the multi-lobe fit of
// Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching
// Functions", JCGT 2(2), 2013 (equation 4).
Vec3 cie_xyz_fit(double nanometres);

// The color of a black body in linear Rec.709, scaled so that its luminance is 1. Components that
// lie outside the gamut (blue below about 1900 K) are cut to 0 before scaling. Temperatures from
// 300 K upwards; below, the visible part is too small for numbers to hold and the result is that of
// 300 K.
void blackbody_color(double temperature, double rgb[3]);

#endif
