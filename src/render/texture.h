// Values that vary over a surface: one file a kind in textures/, one row in nodes.def.
//
// A texture gives a linear Rec.709 colour; where a number is wanted it is the colour's luminance.
#ifndef RENDER_TEXTURE_H
#define RENDER_TEXTURE_H

#include "base/diag.h"
#include "render/accel.h"

struct TextureImage; // texture_image.h
typedef struct TextureSet TextureSet;

// What a texture's prepare is given.
typedef struct TexturePrepare {
    const Scene *scene;
    TextureSet *set; // textures inside stand at lower ids and are ready
    Arena *arena;    // lives as long as the set
    DiagSink *sink;
    Span at; // of the texture's node
} TexturePrepare;

typedef struct TextureClass {
    NodeType node; // first: a TextureClass is a NodeType
    // Makes what look-ups need, in the arena. False after a report. NULL: nothing to make.
    bool (*prepare)(const TexturePrepare *prepare, const void *params, const void **data);
    // Of surface it uses uv, p, object_p and color alone. Thread-safe.
    Rgb (*color)(const TextureSet *set, const void *params, const void *data,
                 const Surface *surface);
    // About the mean over a surface. NULL: not known, taken as 0.5.
    Rgb (*mean)(const TextureSet *set, const void *params, const void *data);
} TextureClass;

// All textures of a scene, ready. NULL after a report (every failing texture is reported, at its
// own place).
TextureSet *texture_set_build(const Scene *scene, DiagSink *sink);
void texture_set_free(TextureSet *set);
// The decoded file, read once for all that name it. `encoding` is one of TextureEncoding. NULL
// after a report at `at`.
const struct TextureImage *texture_set_image(TextureSet *set, const Scene *scene, const char *path,
                                             int32_t encoding, DiagSink *sink, Span at);

Rgb texture_color(const TextureSet *set, uint32_t id, const Surface *surface);
Rgb texture_mean(const TextureSet *set, uint32_t id);

// The value of a field that may be a texture.
static inline Rgb color_tex(const TextureSet *set, const ColorTex *value, const Surface *surface)
{
    return value->texture == NONE_ID
               ? value->value
               : rgb_mul(value->value, texture_color(set, value->texture, surface));
}
// The same for its mean over a surface.
static inline Rgb color_tex_mean(const TextureSet *set, const ColorTex *value)
{
    return value->texture == NONE_ID ? value->value
                                     : rgb_mul(value->value, texture_mean(set, value->texture));
}
static inline float number_tex(const TextureSet *set, const NumberTex *value,
                               const Surface *surface)
{
    return value->texture == NONE_ID
               ? (float)value->value
               : (float)value->value * luminance(texture_color(set, value->texture, surface));
}
// A pair; a texture gives both numbers.
static inline Vec2 pair_tex(const TextureSet *set, const PairTex *value, const Surface *surface)
{
    double factor = value->texture == NONE_ID
                        ? 1
                        : (double)luminance(texture_color(set, value->texture, surface));
    return (Vec2){value->value.x * factor, value->value.y * factor};
}
// A color held to be no less than 0; what isn't a number becomes 0.
static inline Rgb positive_color(Rgb c)
{
    return rgb(c.r > 0 ? c.r : 0, c.g > 0 ? c.g : 0, c.b > 0 ? c.b : 0);
}
static inline Rgb positive_tex(const TextureSet *set, const ColorTex *value, const Surface *surface)
{
    return positive_color(color_tex(set, value, surface));
}
// x held to [0, 1]; what isn't a number becomes 0.
static inline float unit_clamp(float x)
{
    const float positive = x > 0 ? x : 0; // as processors have it in one instruction
    return positive < 1 ? positive : 1;
}
static inline Rgb unit_color(Rgb c)
{
    return rgb(unit_clamp(c.r), unit_clamp(c.g), unit_clamp(c.b));
}
// A fraction: a number held to [0, 1].
static inline float fraction_tex(const TextureSet *set, const NumberTex *value,
                                 const Surface *surface)
{
    return unit_clamp(number_tex(set, value, surface));
}
// A reflectance: the same, held to [0, 1].
static inline Rgb reflectance_tex(const TextureSet *set, const ColorTex *value,
                                  const Surface *surface)
{
    return unit_color(color_tex(set, value, surface));
}

#endif
