#include "../test_support.h"
#include "schema/schema.h"

#include <math.h>
#include <string.h>

typedef struct Ball {
    Vec3 center;
    double radius;
    int32_t style;
} Ball;

static const char *const styles[] = {"solid", "hollow", NULL};
static const Param ball_params[] = {
    {.name = "center",
     .type = PARAM_VEC3,
     PARAM_AT(Ball, center),
     .dims = DIM_BIT(DIM_LENGTH),
     .default_text = "(0, 0, 0)",
     .doc = "Its middle."},
    {.name = "radius",
     .type = PARAM_NUMBER,
     PARAM_AT(Ball, radius),
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .flags = PARAM_EXCLUDE_MIN,
     .default_text = "1",
     .doc = "Its radius."},
    {.name = "style",
     .type = PARAM_CHOICE,
     PARAM_AT(Ball, style),
     .choices = styles,
     .default_text = "\"solid\"",
     .doc = "How it is made."},
};
static const NodeType ball = {.name = "sphere",
                              .category = CATEGORY_SHAPE,
                              .params = ball_params,
                              .param_count = 3,
                              .size = sizeof(Ball),
                              .doc = "A ball."};
static const NodeType matte = {
    .name = "lambert", .category = CATEGORY_MATERIAL, .doc = "A matte surface."};
static const NodeType glossy = {
    .name = "burley", .category = CATEGORY_MATERIAL, .doc = "A glossy surface."};
static const NodeType lamp = {
    .name = "spot_light", .category = CATEGORY_LIGHT, .doc = "A lamp with a cone."};
static const NodeType product = {
    .name = "burleys", .category = CATEGORY_TEXTURE, .internal = true, .doc = "Not written."};
static const NodeType *const types[] = {&ball, &matte, &glossy, &lamp, &product};
static const Schema schema = {types, TEST_COUNT(types)};

static void units_have_their_factors(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        Dim dim;
        double si;
    } expected[] = {
        {"deg", DIM_ANGLE, PI / 180}, {"rad", DIM_ANGLE, 1},
        {"turn", DIM_ANGLE, 2 * PI},  {"km", DIM_LENGTH, 1000},
        {"m", DIM_LENGTH, 1},         {"cm", DIM_LENGTH, 0.01},
        {"mm", DIM_LENGTH, 0.001},    {"um", DIM_LENGTH, 1e-6},
        {"nm", DIM_LENGTH, 1e-9},     {"s", DIM_TIME, 1},
        {"ms", DIM_TIME, 0.001},      {"K", DIM_TEMPERATURE, 1},
        {"W", DIM_POWER, 1},          {"kW", DIM_POWER, 1000},
        {"lm", DIM_LUMINOUS_FLUX, 1}, {"cd", DIM_LUMINOUS_INTENSITY, 1},
        {"lx", DIM_ILLUMINANCE, 1},   {"nit", DIM_LUMINANCE, 1},
    };
    assert_int_equal(schema_unit_count, TEST_COUNT(expected));
    for (size_t i = 0; i < TEST_COUNT(expected); ++i) {
        const UnitInfo *unit = unit_find(str_from(expected[i].name));
        assert_non_null(unit);
        assert_string_equal(unit->name, expected[i].name);
        assert_int_equal(unit->dim, expected[i].dim);
        assert_true(unit->factor == expected[i].si);
    }
    assert_null(unit_find(STR("")));
    assert_null(unit_find(STR("M")));
    assert_null(unit_find(STR("degree")));
    assert_null(unit_find(STR("de")));
}

static void every_number_has_a_name(void **state)
{
    (void)state;
    for (int i = 0; i < DIM_COUNT; ++i) {
        assert_true(strlen(dim_info((Dim)i)->name) > 0);
        assert_true((strlen(dim_info((Dim)i)->si_unit) > 0) == (i != DIM_NONE));
        const UnitInfo *unit = unit_find(str_from(dim_info((Dim)i)->si_unit));
        assert_true(i == DIM_NONE || (unit && unit->dim == (Dim)i && unit->factor == 1));
    }
    assert_string_equal(category_name(CATEGORY_FALLOFF), "falloff");
    assert_int_equal(param_type_size(PARAM_VEC3), sizeof(Vec3));
    assert_int_equal(param_type_size(PARAM_FACE_LIST), sizeof(FaceList));
    assert_string_equal(param_type_name(PARAM_COLOR_TEX), "color or texture");
}

static void kinds_and_fields_are_found(void **state)
{
    (void)state;
    assert_int_equal(schema_find(&schema, STR("sphere")), 0);
    assert_int_equal(schema_find(&schema, STR("spot_light")), 3);
    assert_int_equal(schema_find(&schema, STR("burleys")), 4);
    assert_int_equal(schema_find(&schema, STR("spot")), -1);
    assert_int_equal(schema_find(&schema, STR("spheres")), -1);
    assert_int_equal(schema_find(&schema, STR("")), -1);
    // A slice isn't ended by a NUL.
    assert_int_equal(schema_find(&schema, (Str){"spherekind", 6}), 0);
    assert_int_equal(node_type_find_param(&ball, STR("radius")), 1);
    assert_int_equal(node_type_find_param(&ball, STR("radiu")), -1);
    assert_int_equal(node_type_find_param(&matte, STR("radius")), -1);
}

static void likely_names_are_suggested(void **state)
{
    (void)state;
    static const struct {
        const char *wrong, *right;
        Category category;
    } kinds[] = {
        {"shpere", "sphere", CATEGORY_COUNT},
        {"Sphere", "sphere", CATEGORY_COUNT},
        {"speher", "sphere", CATEGORY_SHAPE},
        {"lambertt", "lambert", CATEGORY_COUNT},
        {"spotlight", "spot_light", CATEGORY_COUNT},
        {"spot", "spot_light", CATEGORY_COUNT},
        {"burly", "burley", CATEGORY_MATERIAL},
        {"burley", NULL, CATEGORY_SHAPE},
        {"burleys", "burley", CATEGORY_COUNT},
        {"ggx", NULL, CATEGORY_COUNT},
        {"teapot", NULL, CATEGORY_COUNT},
        {"x", NULL, CATEGORY_COUNT},
        {"", NULL, CATEGORY_COUNT},
    };
    for (size_t i = 0; i < TEST_COUNT(kinds); ++i) {
        const char *got = schema_suggest_type(&schema, str_from(kinds[i].wrong), kinds[i].category);
        if (kinds[i].right) {
            assert_non_null(got);
            assert_string_equal(got, kinds[i].right);
        } else {
            assert_null(got);
        }
    }
    static const char *const fields[][2] = {
        {"radios", "radius"},    {"centre", "center"}, {"transfrom", "transform"},
        {"matrial", "material"}, {"Radius", "radius"}, {"colour", NULL},
        {"exponent", NULL},      {"nam", "name"},
    };
    for (size_t i = 0; i < TEST_COUNT(fields); ++i) {
        const char *got = node_type_suggest_param(&ball, str_from(fields[i][0]));
        if (fields[i][1]) {
            assert_non_null(got);
            assert_string_equal(got, fields[i][1]);
        } else {
            assert_null(got);
        }
    }
    assert_string_equal(node_type_suggest_param(&lamp, STR("colour")), "color");
    char longest[200];
    memset(longest, 'r', sizeof longest);
    assert_null(node_type_suggest_param(&ball, (Str){longest, sizeof longest}));
}

// The table above with one field changed must be found wanting, and the message must say where.
static void check_one(const Param *changed, const char *expected)
{
    Param params[3];
    memcpy(params, ball_params, sizeof params);
    params[1] = *changed;
    NodeType type = ball;
    type.params = params;
    const NodeType *const one[] = {&matte, &type};
    char message[256];
    const char *wrong = schema_check(&(Schema){one, 2}, message, sizeof message);
    assert_non_null(wrong);
    assert_string_equal(wrong, expected);
}

static void mistakes_in_tables_are_found(void **state)
{
    (void)state;
    char message[256];
    assert_null(schema_check(&schema, message, sizeof message));
    Param param = ball_params[1];
    param.name = "center";
    check_one(&param, "sphere.center: the name stands twice");
    param.name = "name";
    check_one(&param, "sphere.name: a common field of every shape has that name");
    param = ball_params[1];
    param.offset = sizeof(Ball) - 4;
    check_one(&param, "sphere.radius: its value lies beyond the kind's struct");
    param.offset = offsetof(Ball, center) + 8;
    check_one(&param, "sphere.radius: shares its bytes with `center`");
    param.offset = offsetof(Ball, radius) + 1;
    check_one(&param, "sphere.radius: its offset doesn't suit its type");
    param = ball_params[1];
    param.doc = NULL;
    check_one(&param, "sphere.radius: has no manual");
    param = ball_params[1];
    param.max = 0;
    param.min = 1;
    check_one(&param, "sphere.radius: its range is empty");
    param = ball_params[1];
    param.default_text = NULL;
    check_one(&param, "sphere.radius: has no default and isn't required");
    param = ball_params[1];
    param.flags |= PARAM_REQUIRED;
    check_one(&param, "sphere.radius: has a default that can't come to be used");
    param = ball_params[1];
    param.type = PARAM_CHOICE;
    check_one(&param, "sphere.radius: has no choices");
    param.choices = styles;
    check_one(&param, "sphere.radius: its dimensions don't suit its type");
    param.dims = 0;
    check_one(&param, "sphere.radius: its default isn't one of its choices");
    const NodeType *const twice[] = {&ball, &ball};
    assert_string_equal(schema_check(&(Schema){twice, 2}, message, sizeof message),
                        "sphere: two kinds have that name");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(units_have_their_factors),
        cmocka_unit_test(every_number_has_a_name),
        cmocka_unit_test(kinds_and_fields_are_found),
        cmocka_unit_test(likely_names_are_suggested),
        cmocka_unit_test(mistakes_in_tables_are_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
