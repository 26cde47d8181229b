#include "base/blackbody.h"

double planck_radiance(double wavelength, double temperature)
{
    const double h = 6.62607015e-34, c = 299792458, k = 1.380649e-23;
    double l2 = wavelength * wavelength;
    return 2 * h * c * c / (l2 * l2 * wavelength) / expm1(h * c / (wavelength * k * temperature));
}

// A Gaussian with another width on each side.
static double lobe(double x, double height, double center, double left, double right)
{
    double t = (x - center) * (x < center ? left : right);
    return height * exp(-0.5 * t * t);
}

Vec3 cie_xyz_fit(double nm)
{
    return vec3(lobe(nm, 0.362, 442.0, 0.0624, 0.0374) + lobe(nm, 1.056, 599.8, 0.0264, 0.0323) +
                    lobe(nm, -0.065, 501.1, 0.0490, 0.0382),
                lobe(nm, 0.821, 568.8, 0.0213, 0.0247) + lobe(nm, 0.286, 530.9, 0.0613, 0.0322),
                lobe(nm, 1.217, 437.0, 0.0845, 0.0278) + lobe(nm, 0.681, 459.0, 0.0385, 0.0725));
}

void blackbody_color(double temperature, double rgb[3])
{
    temperature = fmax(temperature, 300);
    // Scaled by the value at 780 nm or at the peak, so that cold bodies don't underflow.
    double scale_by = planck_radiance(fmin(780e-9, 2.897771955e-3 / temperature), temperature);
    Vec3 xyz = vec3(0, 0, 0);
    for (int nm = 360; nm <= 830; ++nm) {
        xyz = add_scaled(xyz, cie_xyz_fit(nm), planck_radiance(nm * 1e-9, temperature) / scale_by);
    }
    // IEC 61966-2-1: XYZ (D65) to linear Rec.709.
    rgb[0] = 3.2404541621141054 * xyz.x - 1.5371385127977166 * xyz.y - 0.49853140955601583 * xyz.z;
    rgb[1] =
        -0.96926603050518312 * xyz.x + 1.8760108454466942 * xyz.y + 0.041556017530349834 * xyz.z;
    rgb[2] =
        0.055643430959114726 * xyz.x - 0.20402591351675387 * xyz.y + 1.0572251882231791 * xyz.z;
    for (int i = 0; i < 3; ++i) {
        rgb[i] = fmax(rgb[i], 0);
    }
    double y = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    for (int i = 0; i < 3; ++i) {
        rgb[i] /= y;
    }
}
