#include "../test_support.h"
#include "schema/manual.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct Lamp {
    Quantity power;
    double cone;
    Vec3 direction;
    NumberTex dim;
    int32_t shape;
    uint32_t falloff;
} Lamp;

static const char *const shapes[] = {"round", "square", NULL};
static const Param params[] = {
    {.name = "power",
     .type = PARAM_QUANTITY,
     PARAM_AT(Lamp, power),
     .dims = DIM_BIT(DIM_POWER) | DIM_BIT(DIM_LUMINOUS_FLUX),
     .si = "W",
     .min = 0,
     .max = INFINITY,
     .flags = PARAM_REQUIRED,
     .doc = "The whole output, a | b."},
    {.name = "cone",
     .type = PARAM_NUMBER,
     PARAM_AT(Lamp, cone),
     .dims = DIM_BIT(DIM_ANGLE),
     .min = 0,
     .max = PI,
     .flags = PARAM_EXCLUDE_MIN,
     .default_text = "40deg",
     .doc = "Its cone's width, from side to side, measured at the lamp and not at the ground below "
            "it."},
    {.name = "direction",
     .type = PARAM_VEC3,
     PARAM_AT(Lamp, direction),
     .flags = PARAM_UNIT_VECTOR,
     .default_text = "(0, -1, 0)",
     .doc = "Where to."},
    {.name = "dim",
     .type = PARAM_NUMBER_TEX,
     PARAM_AT(Lamp, dim),
     .min = 0,
     .max = 1,
     .default_text = "1",
     .doc = "A factor."},
    {.name = "shape",
     .type = PARAM_CHOICE,
     PARAM_AT(Lamp, shape),
     .choices = shapes,
     .default_text = "\"round\"",
     .doc = "Of the spot."},
    {.name = "falloff",
     .type = PARAM_NODE,
     PARAM_AT(Lamp, falloff),
     .category = CATEGORY_FALLOFF,
     .flags = PARAM_NO_DEFAULT,
     .doc = "From the axis."},
};
static const NodeType lamp = {.name = "lamp",
                              .category = CATEGORY_LIGHT,
                              .params = params,
                              .param_count = TEST_COUNT(params),
                              .size = sizeof(Lamp),
                              .doc = "A lamp.",
                              .formula = "I = P / 4 pi",
                              .example = "lamp {\n  power: 60W\n}"};
static const NodeType hidden = {.name = "hidden", .category = CATEGORY_LIGHT, .internal = true};
static const NodeType *const types[] = {&hidden, &lamp};
static const Schema schema = {types, 2};

static void expect(char *text, const char *expected)
{
    assert_string_equal(text, expected);
    free(text);
}

static void a_kind_as_text(void **state)
{
    (void)state;
    char *text;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    manual_write_kind(&lamp, out, MANUAL_TEXT);
    fclose(out);
    expect(text, "lamp: a light\n"
                 "\n"
                 "A lamp.\n"
                 "\n"
                 "Fields:\n"
                 "  power           power or luminous flux, bare in W; at least 0; required\n"
                 "                  The whole output, a | b.\n"
                 "  cone            angle; above 0deg and at most 180deg; default 40deg\n"
                 "                  Its cone's width, from side to side, measured at the lamp and\n"
                 "                  not at the ground below it.\n"
                 "  direction       direction; default (0, -1, 0)\n"
                 "                  Where to.\n"
                 "  dim             number or texture; 0 to 1; default 1\n"
                 "                  A factor.\n"
                 "  shape           \"round\", \"square\"; default \"round\"\n"
                 "                  Of the spot.\n"
                 "  falloff         falloff\n"
                 "                  From the axis.\n"
                 "\n"
                 "Fields of every light:\n"
                 "  transform       A transform, or a list of transforms applied first to last.\n"
                 "  name            A name for messages, layers of object ids and `--camera`.\n"
                 "  color           The light's color, which a numeric strength is multiplied by;\n"
                 "                  `rgb(1, 1, 1)` unless given.\n"
                 "\n"
                 "Formula:\n"
                 "\n"
                 "    I = P / 4 pi\n"
                 "\n"
                 "Example:\n"
                 "\n"
                 "    lamp {\n"
                 "      power: 60W\n"
                 "    }\n");
}

static void a_chapter_as_markdown(void **state)
{
    (void)state;
    char *text;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    manual_write_category(&schema, CATEGORY_LIGHT, out, MANUAL_MARKDOWN);
    fclose(out);
    expect(text,
           "\n## Lights\n"
           "\nEvery light takes:\n"
           "\n| field | takes | meaning |\n"
           "|---|---|---|\n"
           "| `transform` | transform, or a list of them | A transform, or a list of transforms "
           "applied first to last. |\n"
           "| `name` | string | A name for messages, layers of object ids and `--camera`. |\n"
           "| `color` | color | The light's color, which a numeric strength is multiplied by; "
           "`rgb(1, 1, 1)` unless given. |\n"
           "\n### `lamp`\n"
           "\nA lamp.\n"
           "\n| field | takes | range | default | meaning |\n"
           "|---|---|---|---|---|\n"
           "| `power` | power or luminous flux, bare in W | at least 0 | required | The whole "
           "output, a \\| b. |\n"
           "| `cone` | angle | above 0deg and at most 180deg | `40deg` | Its cone's width, from "
           "side to side, measured at the lamp and not at the ground below it. |\n"
           "| `direction` | direction |  | `(0, -1, 0)` | Where to. |\n"
           "| `dim` | number or texture | 0 to 1 | `1` | A factor. |\n"
           "| `shape` | \"round\", \"square\" |  | `\"round\"` | Of the spot. |\n"
           "| `falloff` | falloff |  |  | From the axis. |\n"
           "\n```text\nI = P / 4 pi\n```\n"
           "\n![lamp](kinds/lamp.png)\n"
           "\n```scn\nlamp {\n  power: 60W\n}\n```\n");
    out = open_memstream(&text, &size);
    manual_write_category(&schema, CATEGORY_LIGHT, out, MANUAL_TEXT);
    fclose(out);
    expect(text, "light: lamp\n");
}

static void units_in_order(void **state)
{
    (void)state;
    char *text;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    manual_write_units(out, MANUAL_MARKDOWN);
    fclose(out);
    assert_non_null(strstr(text, "\n| `deg` | angle | 0.01745329252 rad |\n"));
    assert_non_null(strstr(text, "\n| `kW` | power | 1000 W |\n"));
    assert_true(strstr(text, "`deg`") < strstr(text, "`nit`"));
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_kind_as_text),
        cmocka_unit_test(a_chapter_as_markdown),
        cmocka_unit_test(units_in_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
