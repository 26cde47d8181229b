// The laws by which light falls off with distance.
#include "render/attenuation.h"

static double inverse_square(const void *params, double r)
{
    (void)params;
    return 1 / (r * r);
}

static bool always_natural(const void *params)
{
    (void)params;
    return true;
}

const AttenuationClass inverse_square_attenuation = {
    .node = {.name = "inverse_square",
             .category = CATEGORY_ATTENUATION,
             .doc = "The natural law: the only one that conserves energy.",
             .formula = "1 / r²",
             .example = "camera { position: (0, 2, 3.6), look_at: (0, 0.2, 0), fov: 32deg }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "for (i in 0..6) {\n"
                        "  cylinder {\n"
                        "    from: (0.5 * i - 1.5, 0, 0)\n"
                        "    to: (0.5 * i - 1.5, 0.5, 0)\n"
                        "    radius: 0.12\n"
                        "    material: lambert { color: #d0b090 }\n"
                        "  }\n"
                        "}\n"
                        "point_light { position: (-2, 0.8, 1), intensity: 6, attenuation: "
                        "inverse_square {} }\n"
                        "environment_light { radiance: 0.03 }"},
    .natural = always_natural,
    .factor = inverse_square,
};

static double constant(const void *params, double r)
{
    (void)params, (void)r;
    return 1;
}

const AttenuationClass constant_attenuation = {
    .node =
        {.name = "constant",
         .category = CATEGORY_ATTENUATION,
         .doc = "No falling off: the irradiance is the intensity at any distance. Not physical.",
         .formula = "1",
         .example =
             "camera { position: (0, 2, 3.6), look_at: (0, 0.2, 0), fov: 32deg }\n"
             "plane { material: lambert { color: gray(0.5) } }\n"
             "for (i in 0..6) {\n"
             "  cylinder {\n"
             "    from: (0.5 * i - 1.5, 0, 0)\n"
             "    to: (0.5 * i - 1.5, 0.5, 0)\n"
             "    radius: 0.12\n"
             "    material: lambert { color: #d0b090 }\n"
             "  }\n"
             "}\n"
             "point_light { position: (-2, 0.8, 1), intensity: 2.5, attenuation: constant {} }\n"
             "environment_light { radiance: 0.03 }"},
    .factor = constant,
};

typedef struct Polynomial {
    double a, b, c;
} Polynomial;

static const Param POLYNOMIAL_PARAMS[] = {
    {.name = "a",
     .type = PARAM_NUMBER,
     PARAM_AT(Polynomial, a),
     .min = 0,
     .max = INFINITY,
     .default_text = "0",
     .doc = "The constant term."},
    {.name = "b",
     .type = PARAM_NUMBER,
     PARAM_AT(Polynomial, b),
     .min = 0,
     .max = INFINITY,
     .si = "1/m",
     .default_text = "0",
     .doc = "The coefficient of r."},
    {.name = "c",
     .type = PARAM_NUMBER,
     PARAM_AT(Polynomial, c),
     .min = 0,
     .max = INFINITY,
     .si = "1/m²",
     .default_text = "1",
     .doc = "The coefficient of r²."},
};

static bool finish_polynomial(NodeFinish *finish)
{
    const Polynomial *polynomial = finish->params;
    if (!(polynomial->a + polynomial->b + polynomial->c > 0)) {
        finish->report(finish, -1, E0931, "one of a, b, c of `polynomial` must be greater than 0");
        return false;
    }
    return true;
}

static double polynomial(const void *params, double r)
{
    const Polynomial *p = params;
    return 1 / (p->a + p->b * r + p->c * r * r);
}

static bool polynomial_is_natural(const void *params)
{
    const Polynomial *p = params;
    return p->a == 0 && p->b == 0;
}

const AttenuationClass polynomial_attenuation = {
    .node = {.name = "polynomial",
             .category = CATEGORY_ATTENUATION,
             .params = POLYNOMIAL_PARAMS,
             .param_count = sizeof POLYNOMIAL_PARAMS / sizeof *POLYNOMIAL_PARAMS,
             .size = sizeof(Polynomial),
             .doc = "The law of early graphics hardware. Not physical, unless only c is set.",
             .formula = "1 / (a + b r + c r²)",
             .example = "camera { position: (0, 2, 3.6), look_at: (0, 0.2, 0), fov: 32deg }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "for (i in 0..6) {\n"
                        "  cylinder {\n"
                        "    from: (0.5 * i - 1.5, 0, 0)\n"
                        "    to: (0.5 * i - 1.5, 0.5, 0)\n"
                        "    radius: 0.12\n"
                        "    material: lambert { color: #d0b090 }\n"
                        "  }\n"
                        "}\n"
                        "point_light { position: (-2, 0.8, 1), intensity: 4, attenuation: "
                        "polynomial { a: 1, b: 0, c: 0.3 } }\n"
                        "environment_light { radiance: 0.03 }",
             .finish = finish_polynomial},
    .natural = polynomial_is_natural,
    .factor = polynomial,
};

typedef struct Window {
    double start, end;
} Window;

enum { START, END };

static const Param WINDOW_PARAMS[] = {
    [START] = {.name = "start",
               .type = PARAM_NUMBER,
               PARAM_AT(Window, start),
               .dims = DIM_BIT(DIM_LENGTH),
               .min = 0,
               .max = INFINITY,
               .flags = PARAM_REQUIRED,
               .doc = "Up to this distance nothing is lost."},
    [END] = {.name = "end",
             .type = PARAM_NUMBER,
             PARAM_AT(Window, end),
             .dims = DIM_BIT(DIM_LENGTH),
             .min = 0,
             .max = INFINITY,
             .flags = PARAM_REQUIRED | PARAM_EXCLUDE_MIN,
             .doc = "From this distance on nothing arrives."},
};

static bool finish_window(NodeFinish *finish)
{
    const Window *window = finish->params;
    if (!(window->start < window->end)) {
        finish->report(finish, END, E0931, "`end` of `window` must be greater than `start`");
        return false;
    }
    return true;
}

static double window(const void *params, double r)
{
    const Window *w = params;
    if (r <= w->start) {
        return 1;
    }
    if (r >= w->end) {
        return 0;
    }
    double rest = 1 - (r - w->start) / (w->end - w->start);
    return rest * rest;
}

const AttenuationClass window_attenuation = {
    .node = {.name = "window",
             .category = CATEGORY_ATTENUATION,
             .params = WINDOW_PARAMS,
             .param_count = sizeof WINDOW_PARAMS / sizeof *WINDOW_PARAMS,
             .size = sizeof(Window),
             .doc = "Full up to one distance, nothing from another on. Not physical.",
             .formula = "1 for r ≤ start; (1 - (r - start)/(end - start))² between; 0 for r ≥ end",
             .example = "camera { position: (0, 2, 3.6), look_at: (0, 0.2, 0), fov: 32deg }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "for (i in 0..6) {\n"
                        "  cylinder {\n"
                        "    from: (0.5 * i - 1.5, 0, 0)\n"
                        "    to: (0.5 * i - 1.5, 0.5, 0)\n"
                        "    radius: 0.12\n"
                        "    material: lambert { color: #d0b090 }\n"
                        "  }\n"
                        "}\n"
                        "point_light { position: (-2, 0.8, 1), intensity: 4, attenuation: window { "
                        "start: 1, end: 3 } }\n"
                        "environment_light { radiance: 0.03 }",
             .finish = finish_window},
    .factor = window,
};

double attenuation_factor(const Scene *scene, uint32_t attenuation, double r)
{
    if (attenuation == NONE_ID) {
        return 1 / (r * r);
    }
    const SceneNode *node = scene_node(scene, CATEGORY_ATTENUATION, attenuation);
    const AttenuationClass *class = (const AttenuationClass *)scene_node_type(scene, node);
    return class->factor(scene_params(scene, node), r);
}

bool attenuation_is_natural(const Scene *scene, uint32_t attenuation)
{
    if (attenuation == NONE_ID) {
        return true;
    }
    const SceneNode *node = scene_node(scene, CATEGORY_ATTENUATION, attenuation);
    const AttenuationClass *class = (const AttenuationClass *)scene_node_type(scene, node);
    return class->natural && class->natural(scene_params(scene, node));
}
