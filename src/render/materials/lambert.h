#ifndef RENDER_MATERIALS_LAMBERT_H
#define RENDER_MATERIALS_LAMBERT_H

#include "render/material.h"

typedef struct Lambert {
    ColorTex color;
} Lambert;

extern const MaterialClass lambert_material;
// What shapes without a material are made of.
extern const Lambert lambert_default;

#endif
