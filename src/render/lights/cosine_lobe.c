// Falloff by a power of the cosine.
#include "render/attenuation.h"

typedef struct CosineLobe {
    double exponent;
} CosineLobe;

static const Param PARAMS[] = {
    {.name = "exponent",
     .type = PARAM_NUMBER,
     PARAM_AT(CosineLobe, exponent),
     .min = 1,
     .max = 1e9,
     .flags = PARAM_REQUIRED,
     .doc = "n: the greater, the narrower the beam. Half the intensity is left at the angle whose "
            "cosine is 2^(-1/n)."},
};

static double factor(const void *params, double cos_angle)
{
    const CosineLobe *lobe = params;
    return cos_angle > 0 ? pow(cos_angle, lobe->exponent) : 0;
}

static double integral(const void *params)
{
    const CosineLobe *lobe = params;
    return 2 * PI / (lobe->exponent + 1);
}

static double reach(const void *params)
{
    (void)params;
    return PI / 2;
}

const FalloffClass cosine_lobe_falloff = {
    .node =
        {.name = "cosine_lobe",
         .category = CATEGORY_FALLOFF,
         .params = PARAMS,
         .param_count = sizeof PARAMS / sizeof *PARAMS,
         .size = sizeof(CosineLobe),
         .doc = "A beam without an edge: it falls off with a power of the cosine of the angle "
                "from the axis (the slides' cosine lobe, `g(θ)` of spot lights).",
         .formula = "g(θ) = (cos θ)^n, n ≥ 1, and 0 beyond 90°; ∫ g dω = 2π / (n + 1)",
         .example =
             "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
             "environment_light { radiance: 0.03 }\n"
             "plane { material: lambert { color: gray(0.6) } }\n"
             "plane { point: (0, 0, -1), normal: (0, 0, 1), material: lambert { color: gray(0.6) } "
             "}\n"
             "for (i in 0..2) {\n"
             "  spot_light {\n"
             "    position: (1.1 * (i - 1), 1.5, -0.4), direction: (0, -1, -0.4), intensity: 4\n"
             "    falloff: cosine_lobe { exponent: [2, 10, 50][i] }\n"
             "  }\n"
             "}"},
    .factor = factor,
    .integral = integral,
    .reach = reach,
};
