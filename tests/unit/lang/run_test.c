// Runs as a whole: limits, deep recursion, memory that runs out, hashes, params.
#include "../test_support.h"
#include "lang_fixture.h"

#include "base/mem.h"
#include "base/noise.h"

static Setup setup_with(const char *limit)
{
    Setup setup = {.limits = limits_default()};
    assert_true(limits_set(&setup.limits, str_from(limit)));
    return setup;
}

static void limits_are_parsed(void **state)
{
    (void)state;
    Limits limits = limits_default();
    assert_int_equal(limits.call_depth, 1000);
    assert_true(limits_set(&limits, STR("call_depth=12")));
    assert_true(limits_set(&limits, STR("objects=1_000")));
    assert_int_equal(limits.call_depth, 12);
    assert_int_equal(limits.objects, 1000);
    assert_false(limits_set(&limits, STR("call_depth")));
    assert_false(limits_set(&limits, STR("call_depth=")));
    assert_false(limits_set(&limits, STR("call_depth=-1")));
    assert_false(limits_set(&limits, STR("depth=1")));
    assert_false(limits_set(&limits, STR("steps=99999999999999999999")));
    assert_true(limits_set(&limits, STR("steps=18446744073709551615")));
    assert_false(limits_set(&limits, STR("steps=18446744073709551616")));
    assert_false(limits_set(&limits, STR("steps=_1")));
}

// The deepest that the limits allow: each call goes through 190 brackets.
static void deep_calls_of_deep_expressions(void **state)
{
    (void)state;
    char text[4096] = "fn f(n) = if (n == 0) 0 else ";
    for (int i = 0; i < 190; ++i) {
        strcat(text, "(1 + ");
    }
    strcat(text, "f(n - 1)");
    for (int i = 0; i < 190; ++i) {
        strcat(text, ")");
    }
    strcat(text, "\nprint(f(990))");
    Fixture f = load(text);
    assert_string_equal(f.diagnostics, "");
    assert_string_equal(f.printed, "188100\n");
    unload(&f);
    f = load_with(text, setup_with("call_depth=100000000"));
    assert_true(f.good);
    unload(&f);
}

static void the_stack_is_guarded(void **state)
{
    (void)state;
    Fixture f = load_with("fn f(n) = 1 + f(n + 1)\nlet _a = f(0)\nlet _b = \"go on\" + 1",
                          setup_with("call_depth=100000000"));
    assert_non_null(strstr(f.diagnostics, "error[E0704]"));
    assert_non_null(strstr(f.diagnostics, "error[E0405]")); // the next statement is evaluated
    unload(&f);
    // How much of the stack a level takes is the compiler's business.
    Setup small = setup_with("steps=100000000");
    small.stack = 4 << 20;
    f = load_with(
        "let deep = fold(range(300000), group {}, fn(inner, i) = group { items: [inner] })"
        "\ndeep\nball {}",
        small);
    assert_non_null(strstr(f.diagnostics, "error[E0704]"));
    unload(&f);
    f = load_with("let deep = fold(range(300000), [], fn(inner, i) = [inner])\n"
                  "print(deep == deep)",
                  small);
    assert_non_null(strstr(f.diagnostics, "error[E0704]"));
    unload(&f);
    f = load_with("let deep = fold(range(300000), [], fn(inner, i) = [inner])\n"
                  "print(len(str(deep)) > 0)",
                  small);
    assert_non_null(strstr(f.diagnostics, "error[E0704]"));
    assert_string_equal(f.printed, "");
    unload(&f);
}

// An editor's way to give up.
static void a_stop_from_outside_ends_it(void **state)
{
    (void)state;
    atomic_int stop = 0;
    for (int stopped = 0; stopped < 2; ++stopped) {
        Fixture f;
        prepare(&f, &(Setup){.limits = limits_default()}, NULL);
        f.lang.stop = &stop;
        atomic_store(&stop, stopped);
        lang_load_text(&f.lang, STR("for (i in 0..9) { ball {} }"), NULL, "test.scn", &f.scene);
        collect(&f);
        assert_string_equal(f.diagnostics, "");
        assert_int_equal(f.scene.nodes[CATEGORY_SHAPE].count, stopped ? 0 : 10);
        unload(&f);
    }
}

// More expressions of numbers alone than are numbered, and more work in making steps of them than
// is done: the rest is evaluated as a tree.
static void steps_of_numbers_are_bounded(void **state)
{
    (void)state;
    enum { MANY = 70000, LONG = 120, ROWS = 300 };
    for (int round = 0; round < 2; ++round) {
        char *text;
        size_t size;
        FILE *out = open_memstream(&text, &size);
        fputs("let a = 1\nlet xs = [", out);
        for (int i = 0; i < (round ? ROWS : MANY); ++i) {
            fprintf(out, "%d", i);
            for (int k = 0; k < (round ? LONG : 1); ++k) {
                fputs(" + a", out);
            }
            fputs(",\n", out);
        }
        fputs("]\nprint(xs[0], xs[len(xs) - 1])", out);
        fclose(out);
        Fixture f = load_with(text, (Setup){.limits = limits_default()});
        assert_string_equal(f.diagnostics, "");
        char want[64];
        snprintf(want, sizeof want, "%d %d\n", round ? LONG : 1, round ? ROWS - 1 + LONG : MANY);
        assert_string_equal(f.printed, want);
        unload(&f);
        free(text);
    }
}

static void memory_is_limited(void **state)
{
    (void)state;
    Fixture f = load_with("let a = [for (i in 0..<9000000) (i, i, i)]\nprint(len(a))",
                          setup_with("memory=50000000"));
    assert_non_null(strstr(f.diagnostics, "error[E0709]"));
    unload(&f);
}

// Loops give back what they use: ten million iterations in a few megabytes.
static void iterations_give_memory_back(void **state)
{
    (void)state;
    Fixture f = load_with("fn f(v) = length(v * 2 + (1, 1, 1))\n"
                          "let shared = [for (i in 0..<10) (i, i, i)]\n"
                          "for (i in 0..<300000) {\n"
                          "  let v = (i, i + 1, i + 2)\n"
                          "  for (j in 0..<1) { if (f(v + shared[j]) < 0) { ball {} } }\n"
                          "}\n"
                          "print(sum([for (i in 0..<300000) f((i, 0, 0))]) > 0)",
                          setup_with("memory=30000000"));
    assert_string_equal(f.diagnostics, "");
    assert_string_equal(f.printed, "true\n");
    unload(&f);
}

static const char *const broad =
    "param n: int = 3 in 1..9\n"
    "let red = everything { string: \"red\", numbers: [1, 2, 3], color_tex: plain {} * 0.5 }\n"
    "fn pair(gap, r = 0.5) { ball { center: (gap, 0, 0), radius: r }  ball { center: (-gap, 0, 0) "
    "} }\n"
    "let tree = group { material: red  pair(2)  for (i in 0..<n) { ball { center: (i, 1, 0) } } }\n"
    "for (i in 0..<n) { instance { of: tree, transform: [scale(2), translate(i, 0, 0)] } }\n"
    "lamp { shape: ball {}, name: \"lamp\" }\n"
    "for (i in 0..2) { expect n + i < 4 and len(str(i)) == 1 }\n"
    "expect [n, 2] within 10% of [4, 2]\n"
    "expect radiance(ray((0, 0, 0), (0, 0, 1))) / 2 within 1% of 0.5\n"
    "print(sort([3, 1, 2]), bounds(tree), str(red), [for (x in 1..3) if (x > 1) x])\n";

// Each allocation fails in turn: a clean report, no leak (under the sanitizer), no crash.
static void every_allocation_may_fail(void **state)
{
    (void)state;
    size_t failures = 0;
    for (uint64_t n = 0;; ++n) {
        Sandbox sandbox;
        Lang lang;
        Scene scene;
        sandbox_init(&sandbox);
        assert_true(lang_init(&lang, &test_schema, &sandbox));
        assert_true(scene_init(&scene, &test_schema, &sandbox));
        mem_fail_after(n);
        bool good = lang_load_text(&lang, str_from(broad), NULL, "test.scn", &scene);
        mem_fail_after(UINT64_MAX);
        if (!good) {
            bool said = lang.sink.out_of_memory;
            for (uint32_t i = 0; i < lang.sink.count; ++i) {
                said = said || lang.sink.items[i].code == E0001;
            }
            assert_true(said);
        }
        scene_free(&scene);
        lang_free(&lang);
        sandbox_free(&sandbox);
        if (good) {
            break;
        }
        ++failures;
    }
    assert_true(failures > 20);
}

// Each place that goes a level deeper is the first one too deep somewhere here.
static void nesting_is_limited_everywhere(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "let _a = [if (true) 1 else 2]",
        "let _a = [for (i in 0..1) [i]]",
        "let _a = [if (true) if (true) 1 else 2 else 3]",
        "if (false) { } else if (false) { } else if (true) { ball { } }",
        "for (i in 0..1) for (k in 0..1) { ball { } }",
        "for (i in 0..1) ball { }",
        "if (true) ball { }",
        "fn _f(x = 1, y = (2)) = x + y",
        "fn _f(x) ball { radius: x }",
        "expect 1 within (1) of 1",
        "expect 1 within 10% of 1",
        "let _a = 1 + 2 + 3 + 4 == -(-(-1)) ^ 2 ^ 2",
        "let _a = ((((1))))",
        "let _a = not not not true",
        "let _a = ball { } with { radius: 2 } with { radius: 3 }",
        "let _a = if (true) 1 else if (true) 2 else 3",
        "group { group { group { ball { } } } }",
        "let _a = (fn(x) = fn(y) = x)(1)(2)",
        "if (1 = 1) { }",
        "x = ((1))",
        "ball { radius = ((1)) }",
        "ball { 1 with { } }",
        "if (true) { } else if (true) { }",
        "fn _f(x: ((1))) = x",
        "fn _f() ball { radius: ((1)) }",
        "let _a = [if (true) ((1)) else if (false) ((2)) else ((3))]",
        "expect 1 within ((((1)))) of 1",
        "let _a = 1 + 1 = ((2))",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        bool deep_before = true, ever = false;
        for (unsigned most = 0; most < 12; ++most) {
            char limit[32];
            snprintf(limit, sizeof limit, "nesting=%u", most);
            Fixture f = load_with(texts[i], setup_with(limit));
            bool deep = strstr(f.diagnostics, "error[E0701]") != NULL;
            assert_true(deep_before || !deep);
            deep_before = deep;
            ever = ever || deep;
            unload(&f);
        }
        assert_true(ever && !deep_before);
    }
}

// Both sides of an `=` that was meant to compare are counted together.
static void long_chains_are_limited(void **state)
{
    (void)state;
    static const char *const beginnings[] = {"let _a = 1", "if (1", "let _a = 1 = 1"};
    for (size_t i = 0; i < sizeof beginnings / sizeof *beginnings; ++i) {
        bool deep = false;
        for (unsigned count = 990; count < 1010; ++count) {
            char text[4096];
            snprintf(text, sizeof text, "%s", beginnings[i]);
            for (unsigned k = 0; k < count; ++k) {
                strcat(text, "+1");
            }
            strcat(text, i == 1 ? " = 2) {}" : "");
            Fixture f = load_with(text, setup_with("nesting=2"));
            bool too_long = strstr(f.diagnostics, "operations in a row") != NULL;
            assert_true(too_long || !deep);
            deep = too_long;
            unload(&f);
        }
        assert_true(deep);
    }
}

// A text may end anywhere: in a number, an escape, a comment, a block. What ends in the middle of
// something is an error or fine, and all of it is read.
static void texts_end_anywhere(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "let _a = 1_000_.5e+12 m + 0x1F + 3 with { } 2cm withal",
        "let _a = \"\\u{1F600} \\n \\\\ \xff\xfe é\" + #ffcc00",
        "let _a = \"open\r\nlet _b = \"\\\r\n",
        "let _a = 1e99999999999999 + 1e-9999999999 + 0e123456789",
        "\xff\xff\xff",
        "é = 1 /* within /* two */ */ let ü: 2 // \xc3",
        "ball { radius 2, center: (1, 2 } ] ) [ { ball { }",
        "scn 1\nball { } scn 2\nscn 1.5\nscn 1m",
        "import \"a.scn\" as a\nparam p: int = 3 in 1..9 \"text\"\nexpect p within 10% of 3",
        "scn\n: 2",
        "3 ball { } = 4 } ) ]",
        "let _a = 12 m with { radius: 2 }",
        "let _a = 12 m withal",
        "let _a = 12 m\t\r\n with_",
        "a_name_that_is_longer_than_forty_characters_are = 3",
        "ball { } scn 1",
        "scn 2\n",
        "scn 1cm\n",
        "if true { } else { }",
        "if (true { } else { }",
        "let _a = if true 1 else 2",
        "let _a = 1_",
        "let _a = 1__0 + 1_.5",
        "\xff\xfe\xff let _a = 1",
        "ball { radius 1 }",
        "ball ( ) ] }",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        const size_t length = strlen(texts[i]);
        for (size_t end = 0; end <= length; ++end) {
            char *text = strndup(texts[i], end); // so that a sanitizer knows where it ends
            Fixture f = load(text);
            assert_true(f.good || strstr(f.diagnostics, "error[E"));
            unload(&f);
            free(text);
        }
    }
}

static void settings_change_hash_and_params(void **state)
{
    (void)state;
    ParamSetting settings[] = {{STR("n"), STR("5")}};
    Fixture a = load(broad), b = load(broad);
    Fixture c = load_with(
        broad, (Setup){.limits = limits_default(), .settings = settings, .setting_count = 1});
    assert_true(a.good && b.good && c.good);
    assert_true(a.scene.hash == b.scene.hash && a.scene.hash != c.scene.hash);
    assert_string_equal(a.scene.params.items[0].name, "n");
    assert_string_equal(a.scene.params.items[0].value_text, "3");
    assert_string_equal(c.scene.params.items[0].value_text, "5");
    assert_int_equal(a.scene.instances.count, 3);
    assert_int_equal(c.scene.instances.count, 5);
    assert_int_equal(a.scene.prototypes.count, 2);
    assert_int_equal(a.scene.prototypes.items[1].shape_count, 5);
    unload(&a);
    unload(&b);
    unload(&c);
}

static void params_are_listed_as_json(void **state)
{
    (void)state;
    char folder[] = "/tmp/scn_params_XXXXXX";
    assert_non_null(mkdtemp(folder));
    write_file(folder, "a.scn",
               "param n: int = 3 in 1..9 \"How \\\"many\\\"\"\n"
               "param size: length = 20cm\n"
               "param mode: string = \"a\" in [\"a\", \"b\"]\n"
               "print(n, size, mode)\nball { radius: -1 }\n");
    Sandbox sandbox;
    Lang lang;
    sandbox_init(&sandbox);
    assert_int_equal(sandbox_allow(&sandbox, folder), IO_OK);
    assert_true(lang_init(&lang, &test_schema, &sandbox));
    ParamSetting settings[] = {{STR("size"), STR("1m")}};
    lang.settings = settings;
    lang.setting_count = 1;
    char path[128], *text;
    size_t size;
    snprintf(path, sizeof path, "%s/a.scn", folder);
    FILE *out = open_memstream(&text, &size);
    assert_true(lang_params_json(&lang, path, "a.scn", out));
    fclose(out);
    assert_string_equal(
        text,
        "[\n"
        "  {\"name\": \"n\", \"type\": \"int\", \"default\": 3, \"value\": 3, \"min\": 1, "
        "\"max\": 9, \"description\": \"How \\\"many\\\"\"},\n"
        "  {\"name\": \"size\", \"type\": \"length\", \"default\": \"0.2m\", \"value\": \"1m\", "
        "\"description\": \"\"},\n"
        "  {\"name\": \"mode\", \"type\": \"string\", \"default\": \"a\", \"value\": \"a\", "
        "\"choices\": [\"a\", \"b\"], \"description\": \"\"}\n"
        "]\n");
    free(text);
    lang_free(&lang);
    sandbox_free(&sandbox);
    remove_folder(folder);
}

typedef bool Writer(Lang *lang, const char *path, const char *shown, FILE *out);

// What `writer` says of a file with these lines, beside two that it may import; to be freed. *good:
// what it returns.
static char *written_of(const char *lines, Writer *writer, bool *good)
{
    char folder[] = "/tmp/scn_written_XXXXXX", path[128], *text;
    size_t size;
    assert_non_null(mkdtemp(folder));
    write_file(folder, "a.scn", lines);
    write_file(folder, "lib.scn", "param a: int = 1\nlet b = a");
    write_file(folder, "broken.scn", "param a: int = ");
    snprintf(path, sizeof path, "%s/a.scn", folder);
    Sandbox sandbox;
    Lang lang;
    sandbox_init(&sandbox);
    assert_int_equal(sandbox_allow(&sandbox, folder), IO_OK);
    assert_true(lang_init(&lang, &test_schema, &sandbox));
    FILE *out = open_memstream(&text, &size);
    *good = writer(&lang, path, "a.scn", out);
    fclose(out);
    lang_free(&lang);
    sandbox_free(&sandbox);
    remove_folder(folder);
    return text;
}

static void expect_params(const char *lines, const char *expected)
{
    bool good;
    char *text = written_of(lines, lang_params_json, &good);
    if (!strstr(text, expected) || (!*expected && *text)) {
        fail_msg("%s\ngives %s\nand not %s", lines, text, expected);
    }
    free(text);
}

static void params_of_all_sorts_are_listed(void **state)
{
    (void)state;
    expect_params("let a = 1", "[]\n");
    expect_params("param a: bool = true", "\"default\": true, \"value\": true,");
    expect_params("param a: number = 0.5 in 0..<1",
                  "\"min\": 0, \"max\": 1, \"exclude_max\": true,");

    expect_params("param a: string = \"b\\n\\\\c\" \"x\\ty\"", "\"default\": \"b\\u000a\\\\c\"");
    expect_params("param a: string = \"\"", "\"default\": \"\"");
    expect_params("param a: vector = (1, 2)", "\"default\": \"(1, 2)\"");
    expect_params("param a: integer = 1", "\"type\": \"\", \"default\": 1, \"value\": null");
    expect_params("param a: integer = 1 in 0..3", "\"min\": 0, \"max\": 3");
    expect_params("param a: int = 1 in 2", "\"value\": null, \"description\"");
    expect_params("param a: int = 1 in [1, \"b\", [2, true]]",
                  "\"choices\": [1, \"b\", [2, true]]");
    expect_params("param a: length = 1 in 0..2", "\"min\": \"0m\", \"max\": \"2m\"");
    expect_params("param a: length = 1s", "\"default\": \"1s\", \"value\": null");
    expect_params("import \"lib.scn\" as lib\nimport \"lib.scn\" as again\nlet c = lib.b",
                  "\"name\": \"lib.a\"");
    expect_params("param b: int = 2\nimport \"lib.scn\" as lib\nlet c = lib.b", "\"name\": \"b\"");
    expect_params("import \"nowhere.scn\" as lib\nparam a: int = 2", "\"name\": \"a\"");
    expect_params("import \"a.scn\" as a\nparam b: int = 2", "\"name\": \"b\"");
    expect_params("import \"broken.scn\" as a\nparam b: int = 2", "");
}

static void tokens_of_all_kinds_are_dumped(void **state)
{
    (void)state;
    bool good;
    char *text = written_of("name 2cm 3 #00ff00 \"text\" + $", lang_dump_tokens, &good);
    assert_false(good); // for the last
    assert_string_equal(text, "0:4 name name\n5:8 number 2 cm\n9:10 number 3\n"
                              "11:18 color #00ff00\n19:25 string \"text\"\n26:27 +\n"
                              "28:29 error\n29:29 end\n");
    free(text);
}

static void noise_is_smooth_and_bounded(void **state)
{
    (void)state;
    double least = 1, most = -1;
    for (int i = 0; i < 20000; ++i) {
        Vec3 p = vec3(i * 0.137 - 500, i * 0.0713 + 3, i * 0.0311);
        double n = noise3(p), near = noise3(add(p, vec3(1e-6, 1e-6, 1e-6)));
        assert_true(fabs(near - n) < 1e-4);
        least = fmin(least, n);
        most = fmax(most, n);
    }
    assert_true(least >= -1 && least < -0.6);
    assert_true(most <= 1 && most > 0.6);
    assert_true(noise3(vec3(-3, 17, 1e15)) == 0);
    assert_true(isfinite(noise3(vec3(1e300, 0.5, -1e300))));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limits_are_parsed),
        cmocka_unit_test(deep_calls_of_deep_expressions),
        cmocka_unit_test(the_stack_is_guarded),
        cmocka_unit_test(a_stop_from_outside_ends_it),
        cmocka_unit_test(steps_of_numbers_are_bounded),
        cmocka_unit_test(memory_is_limited),
        cmocka_unit_test(iterations_give_memory_back),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(nesting_is_limited_everywhere),
        cmocka_unit_test(long_chains_are_limited),
        cmocka_unit_test(texts_end_anywhere),
        cmocka_unit_test(settings_change_hash_and_params),
        cmocka_unit_test(params_are_listed_as_json),
        cmocka_unit_test(params_of_all_sorts_are_listed),
        cmocka_unit_test(tokens_of_all_kinds_are_dumped),
        cmocka_unit_test(noise_is_smooth_and_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
