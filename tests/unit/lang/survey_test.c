// Surveys: what names mean without evaluating, over texts given in place of files; and values
// observed while evaluating, and evaluation that is stopped.
#include "lang/survey.h"

#include "../test_support.h"

#include "lang_fixture.h"

#include "base/mem.h"

typedef struct Surveyed {
    Fixture fixture;
    Survey *survey;
    const char *text;
} Surveyed;

static bool find_library(void *context, const char *path, Str *text)
{
    (void)context;
    *text = STR("let red = 1\nfn f(x) = x\n");
    return strcmp(path, "/scenes/library.scn") == 0;
}

// The survey refers to the fixture, which stays where it is.
static void begin(Surveyed *s, const char *text)
{
    s->text = text;
    prepare(&s->fixture, &(Setup){.limits = limits_default()}, "/");
    s->fixture.lang.find_given = find_library;
    s->survey = survey_open(&s->fixture.lang, str_from(text), "/scenes/test.scn", "test.scn");
    assert_non_null(s->survey);
}

static void end(Surveyed *s)
{
    survey_free(s->survey);
    collect(&s->fixture);
    unload(&s->fixture);
}

// The node with this tag that begins at the last place where `mark` stands.
static AstId node_at(const Surveyed *s, AstTag tag, const char *mark)
{
    const Ast *ast = survey_ast(s->survey, 0);
    uint32_t begin = 0;
    for (const char *at = s->text; (at = strstr(at, mark)); ++at) {
        begin = (uint32_t)(at - s->text);
    }
    for (AstId id = 1; id < ast->nodes.count; ++id) {
        if (ast_node(ast, id)->tag == tag && ast_node(ast, id)->begin == begin) {
            return id;
        }
    }
    fail_msg("no such node at `%s`", mark);
    return 0;
}

static void expect_item(const Surveyed *s, AstTag tag, const char *mark, uint32_t file,
                        const char *name, AstTag declared)
{
    Meaning meaning = survey_meaning(s->survey, 0, node_at(s, tag, mark));
    assert_int_equal(meaning.kind, MEANS_ITEM);
    assert_int_equal(meaning.file, file);
    assert_true(str_equal(survey_name(s->survey, file, meaning.item), str_from(name)));
    assert_int_equal(ast_node(survey_ast(s->survey, file), meaning.item)->tag, declared);
    Span at = survey_name_span(s->survey, file, meaning.item);
    assert_int_equal(at.end - at.begin, strlen(name));
}

static void names_lead_to_their_declarations(void **state)
{
    (void)state;
    Surveyed s;
    begin(&s, "import \"library.scn\" as lib\n"
              "let a = lib.red\n"
              "fn g(p, q = a) = [for (i in 0..<3) max(i, pi) + q]\n"
              "let b = lib.f(g(a, q: 2))\n"
              "let c = unknown + b\n");
    assert_int_equal(survey_file_count(s.survey), 2);
    assert_int_equal(survey_find_file(s.survey, "/scenes/library.scn"), 1);
    expect_item(&s, AST_MEMBER, "lib.red", 1, "red", AST_LET);
    expect_item(&s, AST_MEMBER, "lib.f", 1, "f", AST_FN);
    expect_item(&s, AST_NAME, "lib.f", 0, "lib", AST_IMPORT);
    expect_item(&s, AST_NAME, "i, pi", 0, "i", AST_FOR);
    expect_item(&s, AST_NAME, "q]", 0, "q", AST_PARAMETER);
    expect_item(&s, AST_NAME, "g(a", 0, "g", AST_FN);
    expect_item(&s, AST_NAME, "a, q", 0, "a", AST_LET);
    Meaning builtin = survey_meaning(s.survey, 0, node_at(&s, AST_NAME, "max"));
    assert_int_equal(builtin.kind, MEANS_BUILTIN);
    assert_string_equal(lang_builtins[builtin.number].name, "max");
    Meaning constant = survey_meaning(s.survey, 0, node_at(&s, AST_NAME, "pi"));
    assert_int_equal(constant.kind, MEANS_CONSTANT);
    assert_string_equal(lang_constants[constant.number].name, "pi");
    Meaning bad = survey_meaning(s.survey, 0, node_at(&s, AST_NAME, "unknown"));
    assert_int_equal(bad.kind, MEANS_NOTHING);
    assert_int_equal(s.fixture.lang.sink.errors, 1);
    end(&s);
}

static void colors_written_out_have_a_value(void **state)
{
    (void)state;
    Surveyed s;
    begin(&s, "let a = rgb(1/4, -1, 2)\nlet b = #ff0000\nlet x = 1\n"
              "let c = gray(x)\nlet d = hsv(1, 1, 1)\n");
    double color[3];
    assert_true(survey_color(s.survey, 0, node_at(&s, AST_CALL, "rgb"), color));
    assert_true(color[0] == 0.25 && color[1] == -1 && color[2] == 2);
    assert_true(survey_color(s.survey, 0, node_at(&s, AST_COLOR, "#ff"), color));
    assert_true(color[0] == 1 && color[1] == 0 && color[2] == 0);
    assert_false(survey_color(s.survey, 0, node_at(&s, AST_CALL, "gray"), color));
    assert_false(survey_color(s.survey, 0, node_at(&s, AST_CALL, "hsv"), color)); // a bare hue
    assert_int_equal(s.fixture.lang.sink.errors, 0); // and nothing is said of it
    end(&s);
}

static void half_texts_are_surveyed(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "",       "let",  "let a = ", "fn f(a", "a.",     "[for (",       "\"",
        "#",      "/*",   "fn (",     "}",      "with {", "everything {", "0..<",
        "import", "\xff", "param a:", "if (",   "a with", "(1,"};
    for (size_t i = 0; i < TEST_COUNT(texts); ++i) {
        Surveyed s;
        begin(&s, texts[i]);
        const Ast *ast = survey_ast(s.survey, 0);
        for (AstId id = 1; id < ast->nodes.count; ++id) {
            double color[3];
            survey_meaning(s.survey, 0, id);
            survey_color(s.survey, 0, id, color);
        }
        end(&s);
    }
}

static void what_is_not_there_is_not_found(void **state)
{
    (void)state;
    Surveyed s;
    begin(&s, "let a = 1");
    assert_int_equal(survey_find_file(s.survey, "/scenes/test.scn"), 0);
    assert_int_equal(survey_find_file(s.survey, "/scenes/other.scn"), -1);
    assert_true(survey_find_global(s.survey, 0, STR("a")) != 0);
    assert_true(survey_find_global(s.survey, 0, STR("b")) == 0);
    assert_true(survey_find_global(s.survey, 0, STR("sin")) == 0);
    end(&s);
    begin(&s, "");
    assert_true(survey_find_global(s.survey, 0, STR("sin")) == 0);
    end(&s);
    Fixture f;
    prepare(&f, &(Setup){.limits = limits_default()}, "/");
    Survey *survey = survey_open(&f.lang, STR("let a = 1"), NULL, "test.scn"); // not a file
    assert_non_null(survey);
    assert_int_equal(survey_find_file(survey, "/scenes/test.scn"), -1);
    survey_free(survey);
    survey_free(NULL);
    collect(&f);
    unload(&f);
}

static void colors_that_are_computed_have_none(void **state)
{
    (void)state;
    static const struct {
        const char *text, *call;
        bool has;
    } cases[] = {
        {"let a = gray(0.5 + 0.25)", "gray", true},
        {"let a = gray(sqrt(2))", "gray", false},
        {"let a = gray()", "gray", false},
        {"let a = gray(#fff)", "gray", false}, // which evaluating finds
        {"let a = gray(\"\")", "gray", false},
        {"let a = gray(1 - pi)", "gray", false},
        {"let a = gray(pi - 1)", "gray", false},
        {"let a = gray(-(-(-(-(1)))))", "gray", true},
        {"let a = gray(-(-(-(-(-(-(-(-(-(-(-(-(-(-(-(-(-(-(1)))))))))))))))))))", "gray", false},
        {"let a = gray(1+1+1+1+1+1+1+1+1+1+1+1+1+1+1+1+1+1+1)", "gray", false},
        {"let a = sqrt(2)", "sqrt", false},
        {"let a = (fn(x) = x)(2)", "(fn", false},
        {"fn f(x) = x\nlet a = f(2)", "f(2", false},
        {"let a = blackbody(6500K)", "blackbody", true},
    };
    for (size_t i = 0; i < TEST_COUNT(cases); ++i) {
        Surveyed s;
        double color[3];
        begin(&s, cases[i].text);
        AstId id = node_at(&s, AST_CALL, cases[i].call);
        assert_int_equal(survey_color(s.survey, 0, id, color), cases[i].has);
        mem_fail_after(0); // what it needs may be there
        survey_color(s.survey, 0, id, color);
        mem_fail_after(UINT64_MAX);
        end(&s);
    }
}

// Each allocation of a survey and of the files that it reads fails in turn.
static void surveys_without_memory(void **state)
{
    (void)state;
    static const char text[] =
        "import \"library.scn\" as lib\nimport \"/scenes/library.scn\" as b\n"
        "let a = [lib.red, rgb(1, 0, 0), b.red]\nball { radius: -1 }\n";
    bool whole = false;
    for (uint64_t n = 0; !whole; ++n) {
        Fixture f;
        prepare(&f, &(Setup){.limits = limits_default()}, "/");
        f.lang.find_given = find_library;
        mem_fail_after(n);
        Survey *survey = survey_open(&f.lang, str_from(text), "/scenes/test.scn", "test.scn");
        mem_fail_after(UINT64_MAX);
        assert_true(survey || f.lang.sink.errors > 0 || f.lang.sink.out_of_memory);
        whole = survey && f.lang.sink.errors == 0 && !f.lang.sink.out_of_memory;
        survey_free(survey);
        collect(&f);
        unload(&f);
        assert_true(n < 10000);
    }
}

// --- Evaluation ----------------------------------------------------------------------------------

static const Observation *observed(const Observations *all, const Fixture *f, const char *name)
{
    for (size_t i = 0; i < all->items.count; ++i) {
        const Observation *seen = &all->items.items[i];
        const Source *source = source_get(&f->lang.sources, seen->name.file);
        Str is = {source->text.at + seen->name.begin, seen->name.end - seen->name.begin};
        if (str_equal(is, str_from(name))) {
            return seen;
        }
    }
    fail_msg("`%s` was not observed", name);
    return NULL;
}

static void values_are_observed(void **state)
{
    (void)state;
    Observations all = {0};
    Fixture f;
    prepare(&f, &(Setup){.limits = limits_default()}, NULL);
    f.lang.observed = &all;
    const char *text = "let a = 20cm + 5cm\nlet b = [for (i in 0..<100) i]\nlet c = 1 / 3\n"
                       "fn f(x) { let inner = x * 2  let same = 7 }\nlet d = [f(1), f(2)]\n"
                       "param p: angle = 90deg\n";
    f.good = lang_load_text(&f.lang, str_from(text), "/test.scn", "test.scn", &f.scene);
    assert_string_equal(observed(&all, &f, "a")->text, "0.25m");
    assert_string_equal(observed(&all, &f, "a")->type, "a length");
    assert_string_equal(observed(&all, &f, "b")->text, "[0, 1, 2, 3, … 100 in all]");
    assert_string_equal(observed(&all, &f, "c")->text, "0.333333");
    assert_string_equal(observed(&all, &f, "p")->text, "90deg");
    assert_int_equal(observed(&all, &f, "a")->times, 1);
    observations_free(&all);
    collect(&f);
    unload(&f);
}

static void values_of_all_sorts_are_observed(void **state)
{
    (void)state;
    static const struct {
        const char *value, *text;
    } cases[] = {
        {"true", "true"},
        {"false", "false"},
        {"1e20", "1e+20"},
        {"-0", "0"},
        {"1..3", "1..<4"},
        {"#fff", "rgb(1, 1, 1)"},
        {"ball {}", "ball { … }"},
        {"sin", "a function"},
        {"[[[[1]]]]", "[[[[, … 1 in all]]]]"},
        {"[[[[]]]]", "[[[[]]]]"},
        {"\"a\"", "\"a\""},
        {"\"éééééééééééééééééééééééééééééé\"", "\"éééééééééééééééééééééééééééééé\""},
        {"\"aééééééééééééééééééééééééééééééé\"", "\"aééééééééééééééééééééééééééééé…\""},
        {"[\"éééééééééééééééééééééééééééééé\", \"éééééééééééééééééééééééééééééé\", 1]",
         "[\"éééééééééééééééééééééééééééééé\", \"ééééééééééééééééééééééééé…"},
        {"[\"aééééééééééééééééééééééééééééé\", \"éééééééééééééééééééééééééééééé\", 1]",
         "[\"aééééééééééééééééééééééééééééé\", \"ééééééééééééééééééééééééé…"},
    };
    for (size_t i = 0; i < TEST_COUNT(cases); ++i) {
        Observations all = {0};
        Fixture f;
        char text[512];
        prepare(&f, &(Setup){.limits = limits_default()}, NULL);
        f.lang.observed = &all;
        snprintf(text, sizeof text, "let value = %s", cases[i].value);
        f.good = lang_load_text(&f.lang, str_from(text), "/test.scn", "test.scn", &f.scene);
        assert_string_equal(observed(&all, &f, "value")->text, cases[i].text);
        observations_free(&all);
        collect(&f);
        unload(&f);
    }
}

// More names than the table has room for at first, some with one value and some with many; and
// without memory.
static void many_values_are_observed(void **state)
{
    (void)state;
    char *text;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    for (int i = 0; i < 300; ++i) {
        fprintf(out, "let a%d = %d\n", i, i);
    }
    fprintf(out, "for (i in 0..3) { let same = 7  let other = i + same  ball { radius: other } }");
    fclose(out);
    bool whole = false;
    for (uint64_t n = 0; !whole; n += 1 + n / 50) {
        Observations all = {0};
        Fixture f;
        prepare(&f, &(Setup){.limits = limits_default()}, NULL);
        f.lang.observed = &all;
        mem_fail_after(n);
        f.good = lang_load_text(&f.lang, str_from(text), "/test.scn", "test.scn", &f.scene);
        mem_fail_after(UINT64_MAX);
        whole = f.good && all.items.count == 302;
        if (whole) {
            assert_false(observed(&all, &f, "same")->varies);
            assert_true(observed(&all, &f, "other")->varies);
            assert_int_equal(observed(&all, &f, "other")->times, 4);
            assert_string_equal(observed(&all, &f, "a299")->text, "299");
        }
        collect(&f);
        assert_true(n < 100000);
        observations_free(&all);
        unload(&f);
    }
    free(text);
}

// Texts that stand for files, and files that aren't there.
static void given_texts_are_loaded(void **state)
{
    (void)state;
    Fixture f;
    prepare(&f, &(Setup){.limits = limits_default()}, "/");
    f.lang.find_given = find_library;
    assert_true(lang_load(&f.lang, "/scenes/library.scn", "library.scn", &f.scene));
    collect(&f);
    unload(&f);
    prepare(&f, &(Setup){.limits = limits_default()}, "/");
    f.lang.find_given = find_library;
    f.lang.given_path = "/scenes/-";
    f.lang.given_text = STR("import \"library.scn\" as lib\nball { radius: lib.red }");
    assert_true(lang_load(&f.lang, "/scenes/-", "-", &f.scene));
    assert_int_equal(f.scene.nodes[CATEGORY_SHAPE].count, 1);
    collect(&f);
    unload(&f);
    prepare(&f, &(Setup){.limits = limits_default()}, "/");
    f.lang.given_path = "/scenes/-";
    assert_false(lang_load(&f.lang, "/nowhere/at/all.scn", "all.scn", &f.scene));
    assert_false(lang_dump_tokens(&f.lang, "/nowhere/at/all.scn", "all.scn", stdout));
    assert_false(lang_dump_ast(&f.lang, "/nowhere/at/all.scn", "all.scn", stdout));
    collect(&f);
    assert_non_null(strstr(f.diagnostics, "error[E0601]: `all.scn` can't be read"));
    unload(&f);
    prepare(&f, &(Setup){.limits = limits_default()}, "/");
    f.lang.find_given = find_library;
    f.good = lang_load_text(&f.lang,
                            STR("import \"/scenes/library.scn\" as lib\n"
                                "import \"/scenes/library.scn\" as again\n"
                                "ball { radius: lib.red + again.red }"),
                            NULL, "somewhere/test.scn", &f.scene);
    collect(&f);
    assert_string_equal(f.diagnostics, "");
    unload(&f);
}

// What an editor offers to choose from is bounded.
static void bindings_are_limited(void **state)
{
    (void)state;
    Fixture f;
    prepare(&f, &(Setup){.limits = limits_default()}, NULL);
    f.lang.bindings = true;
    const char *text = "let many = [for (i in 0..1000) everything { whole: 1 }]\n"
                       "let few = [everything {}, [everything {}], 3]\n"
                       "let one = everything {}\n"
                       "let other = 3\n";
    f.good = lang_load_text(&f.lang, str_from(text), "/test.scn", "test.scn", &f.scene);
    assert_true(f.good);
    assert_int_equal(f.scene.bindings.count, 2);
    collect(&f);
    unload(&f);
    prepare(&f, &(Setup){.limits = limits_default()}, NULL);
    f.lang.bindings = true;
    char *long_text;
    size_t size;
    FILE *out = open_memstream(&long_text, &size);
    fprintf(out, "let all = [for (i in 0..<1000) everything { whole: 1 }]\n");
    for (int i = 0; i < 10; ++i) {
        fprintf(out, "let list%d = all\n", i);
    }
    fclose(out);
    f.good = lang_load_text(&f.lang, str_from(long_text), "/test.scn", "test.scn", &f.scene);
    assert_true(f.good);
    assert_int_equal(f.scene.bindings.count, 10000);
    free(long_text);
    collect(&f);
    unload(&f);
}

static void evaluation_stops_when_asked(void **state)
{
    (void)state;
    atomic_int stop = 1;
    Fixture f;
    prepare(&f, &(Setup){.limits = limits_default()}, NULL);
    f.lang.stop = &stop;
    const char *text = "let a = sum([for (i in 0..<100000) sum([for (j in 0..<100000) j])])\n"
                       "print(a)\n";
    f.good = lang_load_text(&f.lang, str_from(text), "/test.scn", "test.scn", &f.scene);
    assert_int_equal(f.lang.sink.count, 0);
    collect(&f);
    assert_string_equal(f.printed, "");
    unload(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_lead_to_their_declarations),
        cmocka_unit_test(colors_written_out_have_a_value),
        cmocka_unit_test(half_texts_are_surveyed),
        cmocka_unit_test(what_is_not_there_is_not_found),
        cmocka_unit_test(colors_that_are_computed_have_none),
        cmocka_unit_test(surveys_without_memory),
        cmocka_unit_test(values_are_observed),
        cmocka_unit_test(values_of_all_sorts_are_observed),
        cmocka_unit_test(many_values_are_observed),
        cmocka_unit_test(given_texts_are_loaded),
        cmocka_unit_test(bindings_are_limited),
        cmocka_unit_test(evaluation_stops_when_asked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
