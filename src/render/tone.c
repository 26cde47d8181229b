// Tone curves: from scene-linear Rec.709, exposure applied, to what a display is sent.
#include "render/film.h"

const char *const tone_names[] = {"srgb", "linear", "aces", "filmic", NULL};

static float clamp01(float x)
{
    // A comparison with NaN is false, so that NaN becomes 0.
    return x > 0 ? (x < 1 ? x : 1) : 0;
}

// The opto-electronic transfer function of IEC 61966-2-1, on [0, 1].
static float srgb_encode(float x)
{
    const double v = (double)x;
    return (float)(v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055);
}

static Rgb clipped(Rgb c)
{
    return rgb(clamp01(c.r), clamp01(c.g), clamp01(c.b));
}

static Rgb multiply(const float m[3][3], Rgb c)
{
    return rgb(m[0][0] * c.r + m[0][1] * c.g + m[0][2] * c.b,
               m[1][0] * c.r + m[1][1] * c.g + m[1][2] * c.b,
               m[2][0] * c.r + m[2][1] * c.g + m[2][2] * c.b);
}

// Stephen Hill's fit of the ACES reference rendering transform with the sRGB output transform
// (2016, as published in "BakingLab" by Pettineo and Neubelt): a rational function between two
// matrices; its result is linear.
static Rgb aces_fitted(Rgb c)
{
    static const float to_rrt[3][3] = {{0.59719f, 0.35458f, 0.04823f},
                                       {0.07600f, 0.90834f, 0.01566f},
                                       {0.02840f, 0.13383f, 0.83777f}};
    static const float from_odt[3][3] = {{1.60475f, -0.53108f, -0.07367f},
                                         {-0.10208f, 1.10813f, -0.00605f},
                                         {-0.00327f, -0.07276f, 1.07602f}};
    const Rgb v = multiply(to_rrt, c);
    float in[3] = {v.r, v.g, v.b}, fit[3];
    for (int i = 0; i < 3; ++i) {
        // In double, and no further than where the curve has long been flat: a float's square
        // overflows.
        const double x = fmin((double)in[i], 1e6);
        fit[i] = (float)((x * (x + 0.0245786) - 0.000090537) /
                         (x * (0.983729 * x + 0.4329510) + 0.238081));
    }
    return multiply(from_odt, rgb(fit[0], fit[1], fit[2]));
}

// Hable 2010, "Uncharted 2: HDR Lighting" (GDC), with the constants of its slides.
static double hable(double x)
{
    const double a = 0.15, b = 0.50, c = 0.10, d = 0.20, e = 0.02, f = 0.30;
    return (x * (a * x + c * b) + d * e) / (x * (a * x + b) + d * f) - e / f;
}

// The same slides' exposure bias of 2 and linear white point of 11.2.
static float hable_scaled(float x)
{
    return (float)(hable(fmin(2 * (double)x, 1e6)) / hable(11.2));
}

Rgb tone_curve(ToneCurve tone, Rgb c)
{
    // Light is not negative; and what isn't finite is shown as black or white.
    c = rgb(c.r > 0 ? c.r : 0, c.g > 0 ? c.g : 0, c.b > 0 ? c.b : 0);
    switch (tone) {
    case TONE_ACES:
        return clipped(aces_fitted(c));
    case TONE_FILMIC:
        return clipped(rgb(hable_scaled(c.r), hable_scaled(c.g), hable_scaled(c.b)));
    case TONE_LINEAR:
    case TONE_SRGB:
        break;
    }
    return clipped(c);
}

float tone_encode(ToneCurve tone, float shown)
{
    return tone == TONE_LINEAR ? shown : srgb_encode(shown);
}

Rgb tone_apply(ToneCurve tone, Rgb c)
{
    c = tone_curve(tone, c);
    return rgb(tone_encode(tone, c.r), tone_encode(tone, c.g), tone_encode(tone, c.b));
}
