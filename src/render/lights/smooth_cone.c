// Falloff between two angles.
#include "render/lights/smooth_cone.h"

enum { INNER, OUTER };

static const Param PARAMS[] = {
    [INNER] = {.name = "inner",
               .type = PARAM_NUMBER,
               PARAM_AT(SmoothCone, inner),
               .dims = DIM_BIT(DIM_ANGLE),
               .min = 0,
               .max = PI / 2,
               .flags = PARAM_REQUIRED | PARAM_EXCLUDE_MIN,
               .doc = "Up to this angle from the axis the intensity is full."},
    [OUTER] = {.name = "outer",
               .type = PARAM_NUMBER,
               PARAM_AT(SmoothCone, outer),
               .dims = DIM_BIT(DIM_ANGLE),
               .min = 0,
               .max = PI / 2,
               .flags = PARAM_REQUIRED | PARAM_EXCLUDE_MIN,
               .doc = "From this angle on there is none."},
};

static bool finish(NodeFinish *finish)
{
    const SmoothCone *cone = finish->params;
    if (!(cone->inner < cone->outer)) {
        finish->report(finish, OUTER, E0936,
                       "`outer` of `smooth_cone` must be greater than `inner`");
        return false;
    }
    return true;
}

static double factor(const void *params, double cos_angle)
{
    const SmoothCone *cone = params;
    double angle = acos(fmin(fmax(cos_angle, -1), 1));
    if (angle <= cone->inner) {
        return 1;
    }
    if (angle >= cone->outer) {
        return 0;
    }
    double rest = 1 - (angle - cone->inner) / (cone->outer - cone->inner);
    return rest * rest;
}

// With Δ = θ1 - θ0, ∫ (1 - (θ - θ0)/Δ)² sin θ dθ from θ0 to θ1 is
// cos θ0 + 2 sin θ0 / Δ - 2 (cos θ0 - cos θ1) / Δ², the last difference taken as a product of
// sines; for a narrow edge, where that cancels, its series in Δ.
static double edge_integral(const SmoothCone *cone)
{
    double width = cone->outer - cone->inner, middle = (cone->outer + cone->inner) / 2;
    double sine = sin(cone->inner), cosine = cos(cone->inner);
    if (width < 1e-3) {
        return width * (sine / 3 + width * (cosine / 12 - width * sine / 60));
    }
    double difference = 2 * sin(middle) * sin(width / 2);
    return cosine + 2 * (sine - difference / width) / width;
}

static double integral(const void *params)
{
    const SmoothCone *cone = params;
    return 2 * PI * (2 * pow(sin(cone->inner / 2), 2) + edge_integral(cone));
}

static double reach(const void *params)
{
    const SmoothCone *cone = params;
    return cone->outer;
}

const FalloffClass smooth_cone_falloff = {
    .node =
        {.name = "smooth_cone",
         .category = CATEGORY_FALLOFF,
         .params = PARAMS,
         .param_count = sizeof PARAMS / sizeof *PARAMS,
         .size = sizeof(SmoothCone),
         .doc = "A beam that is full up to one angle from the axis and ends at another (the "
                "slides' spot light of two angles).",
         .formula = "g(θ) = 1 for θ ≤ θ0; (1 - (θ - θ0)/(θ1 - θ0))² between; 0 for θ ≥ θ1; "
                    "0 < θ0 = inner < θ1 = outer ≤ 90°",
         .example =
             "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
             "environment_light { radiance: 0.03 }\n"
             "plane { material: lambert { color: gray(0.6) } }\n"
             "plane { point: (0, 0, -1), normal: (0, 0, 1), material: lambert { color: gray(0.6) } "
             "}\n"
             "for (i in 0..2) {\n"
             "  spot_light {\n"
             "    position: (1.1 * (i - 1), 1.5, -0.4), direction: (0, -1, -0.4), intensity: 4\n"
             "    falloff: smooth_cone { inner: [1deg, 15deg, 24deg][i], outer: 25deg }\n"
             "  }\n"
             "}",
         .finish = finish},
    .factor = factor,
    .integral = integral,
    .reach = reach,
};
