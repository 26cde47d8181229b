#include "render/textures/texture_math.h"

static const char *const OPS[] = {"add", "subtract", "multiply", "divide", NULL};

static const Param PARAMS[] = {
    {.name = "op",
     .type = PARAM_CHOICE,
     PARAM_AT(TextureMath, op),
     .flags = PARAM_REQUIRED,
     .choices = OPS,
     .doc = "What is done, component by component."},
    {.name = "a",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(TextureMath, a),
     .flags = PARAM_REQUIRED,
     .doc = "The left operand."},
    {.name = "b",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(TextureMath, b),
     .flags = PARAM_REQUIRED,
     .doc = "The right operand."},
};

static float divide(float a, float b)
{
    return b == 0 ? 0 : a / b;
}

static Rgb apply(int32_t op, Rgb a, Rgb b)
{
    switch ((TextureOp)op) {
    case TEXTURE_ADD:
        return rgb_add(a, b);
    case TEXTURE_SUBTRACT:
        return rgb(a.r - b.r, a.g - b.g, a.b - b.b);
    case TEXTURE_DIVIDE:
        return rgb(divide(a.r, b.r), divide(a.g, b.g), divide(a.b, b.b));
    case TEXTURE_MULTIPLY:
    default:
        return rgb_mul(a, b);
    }
}

static Rgb color(const TextureSet *set, const void *params, const void *data,
                 const Surface *surface)
{
    (void)data;
    const TextureMath *math = params;
    return apply(math->op, color_tex(set, &math->a, surface), color_tex(set, &math->b, surface));
}

static Rgb mean(const TextureSet *set, const void *params, const void *data)
{
    (void)data;
    const TextureMath *math = params;
    return apply(math->op, color_tex_mean(set, &math->a), color_tex_mean(set, &math->b));
}

const TextureClass texture_math_texture = {
    .node = {.name = "texture_math",
             .category = CATEGORY_TEXTURE,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(TextureMath),
             .internal = true,
             .doc = "What arithmetic on textures makes. Dividing by zero gives zero."},
    .color = color,
    .mean = mean,
};
