// The evaluator at its edges: each step may be the last, and schemas without what the renderer's
// has.
#include "../test_support.h"
#include "lang_fixture.h"

// Each limit of steps below what the text needs ends it with one error.
static void each_step_may_be_the_last(const char *text, unsigned least)
{
    unsigned steps = 0;
    for (bool good = false; !good; ++steps) {
        Setup setup = {.limits = limits_default()};
        setup.limits.steps = steps;
        Fixture f = load_with(text, setup);
        good = f.good;
        assert_true(good || strstr(f.diagnostics, "error[E0708]"));
        assert_int_equal(f.lang.sink.errors, !good);
        unload(&f);
    }
    assert_true(steps > least);
}

// Long strings cost steps wherever they are gone through.
static void steps_are_counted_everywhere(void **state)
{
    (void)state;
    static const char a[] = "let a = \"0123456789abcdef0123456789abcdef\"\n"
                            "let b = a + a + a + a + a + a + a + a\n";
    static const struct {
        const char *text;
        unsigned least;
    } uses[] = {
        {"let _b = len(b)", 8},
        {"let _b = sort([b])", 8},
        {"let _b = sort([b, a, b])", 30},
        {"let _b = random(b)", 8},
        {"let _b = random([1, 2, [3, (1, 2)]])", 4},
        {"let _b = b == b", 8},
        {"let _b = [b] == [b]", 8},
        {"let _b = str(b, b)", 16},
        {"let _b = [for (i in 1..9) i]", 9},
        {"let _b = map([b, b], len)", 16},
        {"let _b = everything { string: b, strings: [b, a] }", 17},
        {"ball { name: b }", 8},
        {"expect b == b", 8},
    };
    for (size_t i = 0; i < sizeof uses / sizeof *uses; ++i) {
        char text[512];
        snprintf(text, sizeof text, "%s%s", a, uses[i].text);
        each_step_may_be_the_last(text, uses[i].least + 35); // which `a + a + …` takes
    }
}

static void measures_are_limited(void **state)
{
    (void)state;
    Fixture f = load("for (i in 1..100000) { expect luminance(radiance()) < i }");
    assert_string_equal(f.diagnostics, "");
    assert_int_equal(f.scene.expectations.count, 100000);
    unload(&f);
    f = load("for (i in 0..100000) { expect luminance(radiance()) < i }");
    assert_false(f.good);
    assert_non_null(strstr(f.diagnostics, "error[E0707]: more than 100000 measured expectations"));
    unload(&f);
}

// --- Other schemas -------------------------------------------------------------------------------

static const NodeType few_types[] = {
    {.name = "lump", .category = CATEGORY_SHAPE, .size = 1, .doc = "d"},
    {.name = "plain", .category = CATEGORY_TEXTURE, .size = 1, .doc = "d"},
};
static const NodeType *const few_type_list[] = {&few_types[0], &few_types[1]};
static const Schema few = {few_type_list, 2};

static Fixture load_few(const char *text)
{
    Fixture f = {0};
    sandbox_init(&f.sandbox);
    assert_true(lang_init(&f.lang, &few, &f.sandbox));
    assert_true(scene_init(&f.scene, &few, &f.sandbox));
    f.lang.print_to = open_memstream(&f.printed, &f.printed_size);
    f.good = lang_load_text(&f.lang, str_from(text), NULL, "test.scn", &f.scene);
    collect(&f);
    return f;
}

// No groups, no arithmetic of textures, no film, and a shape whose bounds nobody knows.
static void a_schema_of_few_kinds(void **state)
{
    (void)state;
    Fixture f = load_few("lump {}\nlump { name: \"b\" }");
    assert_string_equal(f.diagnostics, "");
    assert_int_equal(f.scene.nodes[CATEGORY_SHAPE].count, 2);
    unload(&f);
    f = load_few("let _a = bounds(lump {})");
    assert_non_null(strstr(f.diagnostics, "error[E0508]: a part of this shape has no end"));
    unload(&f);
    f = load_few("let _a = plain {} * 2");
    assert_non_null(
        strstr(f.diagnostics, "error[E0405]: `*` doesn't take the texture `plain` and a number"));
    unload(&f);
    f = load_few("expect luminance(radiance()) < 1");
    assert_string_equal(f.diagnostics, "");
    unload(&f);
    f = load_few("expect luminance(radiance(region((0, 0), (1, 1)))) < 1");
    assert_non_null(strstr(f.diagnostics, "which has 0 × 0 pixels"));
    unload(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_are_counted_everywhere),
        cmocka_unit_test(measures_are_limited),
        cmocka_unit_test(a_schema_of_few_kinds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
