// Marble, clouds, rust: smooth random values.
#include "base/noise.h"
#include "render/textures/space.h"

typedef struct Noise {
    ColorTex a, b;
    double scale, gain, lacunarity;
    int64_t octaves;
    int32_t style, space;
} Noise;

enum { STYLE_SMOOTH, STYLE_TURBULENT };
static const char *const STYLES[] = {"smooth", "turbulent", NULL};

static const Param PARAMS[] = {
    {.name = "a",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(Noise, a),
     .default_text = "gray(0)",
     .doc = "The color where the noise is lowest."},
    {.name = "b",
     .type = PARAM_COLOR_TEX,
     PARAM_AT(Noise, b),
     .default_text = "gray(1)",
     .doc = "The color where it is highest."},
    {.name = "scale",
     .type = PARAM_NUMBER,
     PARAM_AT(Noise, scale),
     .dims = DIM_BIT(DIM_NONE),
     .default_text = "1",
     .doc = "Bumps of the coarsest octave in a metre (or, in uv, in one unit)."},
    {.name = "octaves",
     .type = PARAM_INT,
     PARAM_AT(Noise, octaves),
     .min = 1,
     .max = 16,
     .default_text = "1",
     .doc = "How many sizes of bumps are added up, each finer and flatter than the one before."},
    {.name = "gain",
     .type = PARAM_NUMBER,
     PARAM_AT(Noise, gain),
     .dims = DIM_BIT(DIM_NONE),
     .min = 0,
     .max = 1,
     .default_text = "0.5",
     .doc = "The height of an octave over that of the one before."},
    {.name = "lacunarity",
     .type = PARAM_NUMBER,
     PARAM_AT(Noise, lacunarity),
     .dims = DIM_BIT(DIM_NONE),
     .min = 1,
     .max = 16,
     .default_text = "2",
     .doc = "How much finer an octave is than the one before."},
    {.name = "style",
     .type = PARAM_CHOICE,
     PARAM_AT(Noise, style),
     .choices = STYLES,
     .default_text = "\"smooth\"",
     .doc = "\"turbulent\" folds each octave at its middle: creases as in marble and flames."},
    {.name = "space",
     .type = PARAM_CHOICE,
     PARAM_AT(Noise, space),
     .choices = texture_spaces,
     .default_text = "\"object\"",
     .doc = "In texture coordinates, in the shape's own space, or in the world."},
};

// In [0, 1].
static double height(const Noise *noise, Vec3 p)
{
    double sum = 0, total = 0, weight = 1, frequency = noise->scale;
    for (int64_t i = 0; i < noise->octaves; ++i) {
        // Octaves are moved apart, since each is 0 at whole coordinates.
        const double n = noise3(add(scale(p, frequency), scale(vec3(17.3, 31.7, 5.9), (double)i)));
        sum += weight * (noise->style == STYLE_TURBULENT ? fabs(n) : 0.5 + 0.5 * n);
        total += weight;
        weight *= noise->gain;
        frequency *= noise->lacunarity;
    }
    return smaller(larger(sum / total, 0), 1);
}

static Rgb color(const TextureSet *set, const void *params, const void *data,
                 const Surface *surface)
{
    (void)data;
    const Noise *noise = params;
    const double t = height(noise, texture_point(noise->space, surface));
    return rgb_lerp(color_tex(set, &noise->a, surface), color_tex(set, &noise->b, surface),
                    (float)t);
}

static Rgb mean(const TextureSet *set, const void *params, const void *data)
{
    (void)data;
    const Noise *noise = params;
    const float middle = noise->style == STYLE_TURBULENT ? 0.2f : 0.5f;
    return rgb_lerp(color_tex_mean(set, &noise->a), color_tex_mean(set, &noise->b), middle);
}

const TextureClass noise_texture = {
    .node =
        {.name = "noise",
         .category = CATEGORY_TEXTURE,
         .params = PARAMS,
         .param_count = sizeof PARAMS / sizeof *PARAMS,
         .size = sizeof(Noise),
         .doc = "Smooth random values between two colors or textures: clouds, marble, rust, bumps. "
                "The same at the same point of every run. A `gradient` with `value: noise { … }` "
                "gives it more than two colors.",
         .formula =
             "a (1 - t) + b t;  smooth: t = (1 + Σ gain^i n(lacunarity^i scale p) / Σ gain^i)/2,\n"
             "turbulent: t = Σ gain^i |n(…)| / Σ gain^i;  n gradient noise (Perlin 2002)",
         .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                    "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: (0, 0, "
                    "1.5) }, radiance: 12 }\n"
                    "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], space: "
                    "\"uv\" } }\n"
                    "plane {\n"
                    "  material: lambert { color: checker { a: gray(0.6), b: gray(0.35), space: "
                    "\"world\", scale: 2 } }\n"
                    "}\n"
                    "for (i in 0..2) {\n"
                    "  sphere {\n"
                    "    center: (1.05 * (i - 1), 0.5, 0), radius: 0.5\n"
                    "    material: lambert {\n"
                    "      color: noise {\n"
                    "        a: #5a4632\n"
                    "        b: #f2e8d8\n"
                    "        scale: 5\n"
                    "        octaves: [1, 6, 6][i]\n"
                    "        style: if (i == 2) \"turbulent\" else \"smooth\"\n"
                    "      }\n"
                    "    }\n"
                    "  }\n"
                    "}"},
    .color = color,
    .mean = mean,
};
