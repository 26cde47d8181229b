#include "schema/photometry.h"

static bool is_photometric(uint32_t dim)
{
    return dim == DIM_LUMINOUS_FLUX || dim == DIM_LUMINOUS_INTENSITY || dim == DIM_ILLUMINANCE ||
           dim == DIM_LUMINANCE;
}

bool quantity_to_rgb(Quantity quantity, Rgb color, Rgb *out)
{
    double factor = quantity.value;
    if (is_photometric(quantity.dim)) {
        double brightness =
            0.2126 * (double)color.r + 0.7152 * (double)color.g + 0.0722 * (double)color.b;
        if (!(brightness > 0)) {
            return false;
        }
        factor /= LUMENS_PER_WATT * brightness;
    }
    *out = rgb((float)(factor * (double)color.r), (float)(factor * (double)color.g),
               (float)(factor * (double)color.b));
    return true;
}

bool emission_to_rgb(const Emission *emission, Rgb color, Rgb *out)
{
    if (emission->is_number) {
        return quantity_to_rgb((Quantity){(double)emission->value.r, emission->dim}, color, out);
    }
    *out = emission->value;
    return true;
}
