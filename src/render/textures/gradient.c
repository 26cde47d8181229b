// Colours along a line, about a point, or in place of another texture's values.
#include "render/textures/space.h"

typedef struct Gradient {
    RgbList colors;
    NumberList positions; // as long as colors, once finished
    Vec3 from, to;
    NumberTex value;
    int32_t form, space, wrap;
    bool has_value;
} Gradient;

enum { COLORS, POSITIONS, FROM, TO, FORM, VALUE, SPACE, WRAP };
enum { FORM_LINEAR, FORM_RADIAL };
static const char *const FORMS[] = {"linear", "radial", NULL};
enum { ENDS_CLAMP, ENDS_REPEAT, ENDS_MIRROR };
static const char *const WRAPS[] = {"clamp", "repeat", "mirror", NULL};

static const Param PARAMS[] = {
    [COLORS] = {.name = "colors",
                .type = PARAM_COLOR_LIST,
                PARAM_AT(Gradient, colors),
                .flags = PARAM_REQUIRED,
                .doc = "The colors, in order; between two of them lie their mixtures."},
    [POSITIONS] = {.name = "positions",
                   .type = PARAM_NUMBER_LIST,
                   PARAM_AT(Gradient, positions),
                   .flags = PARAM_NO_DEFAULT,
                   .doc = "Where each color stands, rising, usually from 0 to 1. Two at the same "
                          "place make an edge. Without it they stand evenly from 0 to 1."},
    [FROM] = {.name = "from",
              .type = PARAM_VEC3,
              PARAM_AT(Gradient, from),
              .dims = DIM_BIT(DIM_NONE) | DIM_BIT(DIM_LENGTH),
              .default_text = "(0, 0, 0)",
              .doc = "The point of position 0; in uv its first two numbers count."},
    [TO] = {.name = "to",
            .type = PARAM_VEC3,
            PARAM_AT(Gradient, to),
            .dims = DIM_BIT(DIM_NONE) | DIM_BIT(DIM_LENGTH),
            .default_text = "(0, 1, 0)",
            .doc = "The point of position 1."},
    [FORM] = {.name = "form",
              .type = PARAM_CHOICE,
              PARAM_AT(Gradient, form),
              .choices = FORMS,
              .default_text = "\"linear\"",
              .doc = "Along the line, or by the distance from its beginning."},
    [VALUE] = {.name = "value",
               .type = PARAM_NUMBER_TEX,
               PARAM_AT(Gradient, value),
               .flags = PARAM_NO_DEFAULT,
               .doc = "A texture whose value is the position, in place of `from` and `to`."},
    [SPACE] = {.name = "space",
               .type = PARAM_CHOICE,
               PARAM_AT(Gradient, space),
               .choices = texture_spaces,
               .default_text = "\"object\"",
               .doc = "In texture coordinates, in the shape's own space, or in the world."},
    [WRAP] = {.name = "wrap",
              .type = PARAM_CHOICE,
              PARAM_AT(Gradient, wrap),
              .choices = WRAPS,
              .default_text = "\"clamp\"",
              .doc = "What follows beyond 0 and 1: the outer colors, or all of them over again, or "
                     "to and fro."},
};

// --- The author's fields ------------------------------------------------------------------------

static bool even_positions(NodeFinish *finish, Gradient *gradient)
{
    const uint32_t count = gradient->colors.count;
    double *items = arena_array(&finish->scene->arena, count, sizeof *items);
    if (!items) {
        finish->report(finish, -1, E0001, "out of memory");
        return false;
    }
    for (uint32_t i = 0; i < count; ++i) {
        items[i] = count > 1 ? (double)i / (count - 1) : 0;
    }
    gradient->positions = (NumberList){items, count};
    return true;
}

static bool check_positions(NodeFinish *finish, const Gradient *gradient)
{
    const NumberList *positions = &gradient->positions;
    if (positions->count != gradient->colors.count) {
        finish->report(finish, POSITIONS, E0953, "%u positions for %u colors", positions->count,
                       gradient->colors.count);
        return false;
    }
    for (uint32_t i = 1; i < positions->count; ++i) {
        if (positions->items[i] < positions->items[i - 1]) {
            finish->report(finish, POSITIONS, E0953, "positions must rise: %g stands before %g",
                           positions->items[i - 1], positions->items[i]);
            return false;
        }
    }
    return true;
}

static bool finish(NodeFinish *finish)
{
    Gradient *gradient = finish->params;
    gradient->has_value = finish->set >> VALUE & 1;
    if (gradient->colors.count == 0) {
        finish->report(finish, COLORS, E0953, "a gradient needs at least one color");
        return false;
    }
    if (gradient->has_value && (finish->set >> FROM & 1 || finish->set >> TO & 1)) {
        finish->report(finish, VALUE, E0953, "either `value`, or `from` and `to`");
        return false;
    }
    if (!gradient->has_value) {
        gradient->value = (NumberTex){0, NONE_ID};
        if (!(length_squared(sub(gradient->to, gradient->from)) > 0)) {
            finish->report(finish, finish->set >> TO & 1 ? TO : FROM, E0953,
                           "`from` and `to` are the same point");
            return false;
        }
    }
    return finish->set >> POSITIONS & 1 ? check_positions(finish, gradient)
                                        : even_positions(finish, gradient);
}

// --- At a point ---------------------------------------------------------------------------------

static double position(const TextureSet *set, const Gradient *gradient, const Surface *surface)
{
    if (gradient->has_value) {
        return (double)number_tex(set, &gradient->value, surface);
    }
    const Vec3 along = sub(gradient->to, gradient->from);
    const Vec3 p = sub(texture_point(gradient->space, surface), gradient->from);
    return gradient->form == FORM_RADIAL ? length(p) / length(along)
                                         : dot(p, along) / length_squared(along);
}

static double wrapped(int32_t wrap, double t)
{
    switch (wrap) {
    case ENDS_REPEAT:
        return t - floor(t);
    case ENDS_MIRROR:
        t = t / 2 - floor(t / 2);
        return 1 - fabs(1 - 2 * t);
    default:
        return t;
    }
}

static Rgb color_at(const Gradient *gradient, double t)
{
    const double *at = gradient->positions.items;
    const Rgb *colors = gradient->colors.items;
    uint32_t low = 0, high = gradient->colors.count; // at[low] <= t < at[high]
    if (!(t >= at[0])) {
        return colors[0];
    }
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (at[middle] <= t) {
            low = middle;
        } else {
            high = middle;
        }
    }
    if (high == gradient->colors.count) {
        return colors[low];
    }
    return rgb_lerp(colors[low], colors[high], (float)((t - at[low]) / (at[high] - at[low])));
}

static Rgb color(const TextureSet *set, const void *params, const void *data,
                 const Surface *surface)
{
    (void)data;
    const Gradient *gradient = params;
    return color_at(gradient, wrapped(gradient->wrap, position(set, gradient, surface)));
}

static Rgb mean(const TextureSet *set, const void *params, const void *data)
{
    (void)set, (void)data;
    const Gradient *gradient = params;
    Rgb sum = {0, 0, 0};
    for (int i = 0; i < 16; ++i) {
        sum = rgb_add(sum, color_at(gradient, (i + 0.5) / 16));
    }
    return rgb_scale(sum, 1.0f / 16);
}

const TextureClass gradient_texture = {
    .node = {.name = "gradient",
             .category = CATEGORY_TEXTURE,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(Gradient),
             .doc = "Colors that run into each other along a line, or outwards from a point; or "
                    "colors for the values of another texture.",
             .formula = "t = (p - from)·(to - from)/|to - from|², or |p - from|/|to - from|, or "
                        "value; linear between the colors at the positions around t",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane {\n"
                        "  material: lambert { color: checker { a: gray(0.6), b: gray(0.35), "
                        "space: \"world\", scale: 2 } }\n"
                        "}\n"
                        "for (i in 0..2) {\n"
                        "  sphere {\n"
                        "    center: (1.05 * (i - 1), 0.5, 0), radius: 0.5\n"
                        "    material: lambert {\n"
                        "      color: [\n"
                        "        gradient { colors: [#1d3557, #f1faee, #e63946], from: (0, 0, 0), "
                        "to: (0, 1, 0) },\n"
                        "        gradient {\n"
                        "          colors: [#fff, #d62828]\n"
                        "          positions: [0.5, 0.5]\n"
                        "          to: (0.1, 0.1, 0)\n"
                        "          wrap: \"repeat\"\n"
                        "        },\n"
                        "        gradient { colors: [#264653, #e9c46a, #e76f51], value: noise { "
                        "scale: 5, octaves: 4 } }\n"
                        "      ][i]\n"
                        "    }\n"
                        "  }\n"
                        "}",
             .finish = finish},
    .color = color,
    .mean = mean,
};
