// The texture that arithmetic on textures makes: `image { … } * 0.5`.
#ifndef RENDER_TEXTURES_TEXTURE_MATH_H
#define RENDER_TEXTURES_TEXTURE_MATH_H

#include "render/texture.h"

typedef enum TextureOp {
    TEXTURE_ADD,
    TEXTURE_SUBTRACT,
    TEXTURE_MULTIPLY,
    TEXTURE_DIVIDE
} TextureOp;

typedef struct TextureMath {
    int32_t op;
    ColorTex a, b; // a number is a gray
} TextureMath;

extern const TextureClass texture_math_texture;

#endif
