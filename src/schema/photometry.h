// From lumens, candelas, lux and nits to watts.
#ifndef SCHEMA_PHOTOMETRY_H
#define SCHEMA_PHOTOMETRY_H

#include "schema/schema.h"

// lm/W of a linear Rec.709 luminance: what turns radiometric RGB into photometric quantities.
#define LUMENS_PER_WATT 683.0

// A quantity times a light's colour, in radiometric RGB. A photometric one (lm, cd, lx, nit) is
// divided by 683 lm/W and by the colour's luminance, so that 683 times the luminance of the result
// is the quantity itself. False where it is photometric and the colour has no luminance.
bool quantity_to_rgb(Quantity quantity, Rgb color, Rgb *out);
// An emission: a number as above; a colour or the factor of a texture stands for itself.
bool emission_to_rgb(const Emission *emission, Rgb color, Rgb *out);

#endif
