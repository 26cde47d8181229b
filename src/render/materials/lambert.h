#ifndef RENDER_MATERIALS_LAMBERT_H
#define RENDER_MATERIALS_LAMBERT_H

#include "render/material.h"

typedef struct Lambert {
    ColorTex color;
} Lambert;

extern const MaterialClass lambert_material;
// What shapes without a material are made of.
extern const Lambert lambert_default;
// What the shape of an area_light without a material is made of: it emits, and reflects nothing.
extern const Lambert lambert_black;

#endif
