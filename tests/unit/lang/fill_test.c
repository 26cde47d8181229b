// Filling of parameter structs, `finish`, `with`, and what is kept in the scene.
#include "../test_support.h"
#include "lang_fixture.h"

static void check_defaults(const Everything *e)
{
    assert_true(e->flag);
    assert_int_equal(e->whole, 7);
    assert_true(e->number == 3); // 1.5, doubled by finish
    assert_true(fabs(e->angle - 40 * PI / 180) < 1e-15);
    assert_true(e->pair.x == 0.5 && e->pair.y == 0.5);
    assert_true(e->vec2.x == 1 && e->vec2.y == 2);
    assert_true(e->vec3.x == 1 && e->vec3.y == 2 && e->vec3.z == 3);
    assert_true(e->direction.y == 1);
    assert_true(e->color.r == 1 && e->color.g == 0.5f && e->color.b == 0.25f);
    assert_true(e->emission.is_number && e->emission.value.g == 1 && e->emission.dim == DIM_NONE);
    assert_true(e->emission.texture == NONE_ID);
    assert_true(e->number_tex.value == 0.25 && e->number_tex.texture == NONE_ID);
    assert_true(e->pair_tex.value.y == 0.2 && e->pair_tex.texture == NONE_ID);
    assert_true(e->color_tex.value.b == 0.5f && e->color_tex.texture == NONE_ID);
    assert_string_equal(e->string, "text");
    assert_null(e->file);
    assert_int_equal(e->choice, 1);
    assert_int_equal(e->node, 0);
    assert_true(e->optional == NONE_ID);
    assert_int_equal(e->numbers.count, 2);
    assert_int_equal(e->vec2s.count, 0);
    assert_int_equal(e->set, 0);
}

static void defaults_are_evaluated(void **state)
{
    (void)state;
    Fixture f = load("ball { material: everything {} }");
    assert_true(f.good);
    assert_int_equal(f.scene.nodes[CATEGORY_MATERIAL].count, 1);
    check_defaults(scene_params(&f.scene, scene_node(&f.scene, CATEGORY_MATERIAL, 0)));
    unload(&f);
}

static void every_type_is_filled(void **state)
{
    (void)state;
    Fixture f = load(
        "ball { material: everything {\n"
        "  flag: false, whole: -3, number: 20cm, angle: 0.5turn, quantity: 800lm, pair: (3, 4),\n"
        "  vec2: (5, 6), vec3: (1m, 0, 2cm), direction: (0, 3, 4), color: #fff,\n"
        "  emission: 5nit, number_tex: plain {}, pair_tex: (0.1, 0.3), color_tex: plain {},\n"
        "  string: \"h\\u{e9}\", choice: \"blue\", node: plain {} * 0.5, optional: plain {},\n"
        "  numbers: 1..3, vec2s: [(1, 2)], vec3s: [for (i in 0..<3) (i, 0, 0)],\n"
        "  colors: [#000, gray(2)], faces: [[0, 1, 2], (3, 4, 5, 6)], strings: [\"a\", \"b\"]\n"
        "} }");
    assert_string_equal(f.diagnostics, "");
    const Everything *e = scene_params(&f.scene, scene_node(&f.scene, CATEGORY_MATERIAL, 0));
    assert_false(e->flag);
    assert_int_equal(e->whole, -3);
    assert_true(e->number == 0.4);
    assert_true(fabs(e->angle - PI) < 1e-15);
    assert_true(e->quantity.value == 800 && e->quantity.dim == DIM_LUMINOUS_FLUX);
    assert_true(e->pair.x == 3 && e->pair.y == 4);
    assert_true(e->vec2.x == 5 && e->vec2.y == 6);
    assert_true(e->vec3.x == 1 && e->vec3.y == 0 && e->vec3.z == 0.02);
    assert_true(fabs(e->direction.y - 0.6) < 1e-15 && fabs(e->direction.z - 0.8) < 1e-15);
    assert_true(e->color.r == 1 && e->color.b == 1);
    assert_true(e->emission.value.r == 5 && e->emission.dim == DIM_LUMINANCE);
    assert_true(e->number_tex.value == 1 && e->number_tex.texture != NONE_ID);
    assert_true(e->pair_tex.value.x == 0.1 && e->pair_tex.value.y == 0.3);
    assert_true(e->color_tex.texture == e->number_tex.texture); // equal textures are one
    assert_string_equal(e->string, "h\xc3\xa9");
    assert_int_equal(e->choice, 2);
    assert_true(e->optional == e->number_tex.texture);
    assert_int_equal(e->numbers.count, 3);
    assert_true(e->numbers.items[2] == 3);
    assert_int_equal(e->vec2s.count, 1);
    assert_int_equal(e->vec3s.count, 3);
    assert_true(e->vec3s.items[2].x == 2);
    assert_true(e->colors.count == 2 && e->colors.items[1].g == 2);
    assert_int_equal(e->faces.count, 2);
    assert_int_equal(e->faces.index_count, 7);
    assert_int_equal(e->faces.sizes[1], 4);
    assert_int_equal(e->faces.indices[6], 6);
    assert_string_equal(e->strings.items[1], "b");
    const SceneNode *texture = scene_node(&f.scene, CATEGORY_TEXTURE, e->node);
    assert_int_equal(texture->type, TYPE_MATH);
    const TextureMath *math = scene_params(&f.scene, texture);
    assert_int_equal(math->op, 2);
    assert_true(math->a.texture == e->number_tex.texture && math->b.value.r == 0.5f);
    unload(&f);
}

static void finish_sees_what_was_given(void **state)
{
    (void)state;
    Fixture f = load("ball { material: everything { whole: 2, string: \"x\" } }");
    const Everything *e = scene_params(&f.scene, scene_node(&f.scene, CATEGORY_MATERIAL, 0));
    assert_true(e->set == (1u << 1 | 1u << 14));
    unload(&f);
}

// `with` starts from what stood before `finish`, which runs again.
static void with_finishes_anew(void **state)
{
    (void)state;
    Fixture f = load("let a = everything { number: 5 }\nball { material: a with { whole: 3 } }\n"
                     "ball { material: a }");
    assert_int_equal(f.scene.nodes[CATEGORY_MATERIAL].count, 2);
    for (uint32_t i = 0; i < 2; ++i) {
        const Everything *e = scene_params(&f.scene, scene_node(&f.scene, CATEGORY_MATERIAL, i));
        assert_true(e->number == 10);
        assert_int_equal(e->finished, 1);
    }
    unload(&f);
}

static void finish_reports_at_the_field(void **state)
{
    (void)state;
    Fixture f = load("let a = everything { flag: false, whole: 9 }\nball { material: a }\n"
                     "fn make(n) = everything { flag: false } with { whole: n }\n"
                     "ball { material: make(9) }");
    assert_false(f.good);
    assert_string_equal(f.diagnostics,
                        "error[E0404]: 9 is not for everything\n"
                        "  --> test.scn:1:42\n"
                        "   |\n"
                        " 1 | let a = everything { flag: false, whole: 9 }\n"
                        "   |                                          ^\n"
                        "\n"
                        "error[E0404]: 9 is not for everything\n"
                        "  --> test.scn:3:55\n"
                        "   |\n"
                        " 3 | fn make(n) = everything { flag: false } with { whole: n }\n"
                        "   |                                                       ^\n"
                        "   = in the call of `make`\n"
                        "  --> test.scn:4:18\n");
    unload(&f);
}

static void a_light_owns_its_shape(void **state)
{
    (void)state;
    Fixture f = load("let l = lamp { shape: ball { radius: 2 transform: translate(1, 0, 0) }\n"
                     "  transform: translate(0, 1, 0), color: rgb(1, 2, 3) }\n"
                     "group { transform: scale(2)  l }\nl");
    assert_string_equal(f.diagnostics, "");
    assert_int_equal(f.scene.nodes[CATEGORY_LIGHT].count, 2);
    assert_int_equal(f.scene.nodes[CATEGORY_SHAPE].count, 2);
    for (uint32_t i = 0; i < 2; ++i) {
        const SceneNode *light = scene_node(&f.scene, CATEGORY_LIGHT, i);
        const Lamp *lamp = scene_params(&f.scene, light);
        assert_int_equal(lamp->shape, i);
        const SceneNode *shape = scene_node(&f.scene, CATEGORY_SHAPE, lamp->shape);
        assert_int_equal(shape->flags, NODE_LIGHT_ONLY);
        const Affine *map = &f.scene.transforms.items[shape->transform];
        double s = i == 0 ? 2 : 1;
        assert_true(map->m[0][3] == s && map->m[1][3] == s && map->m[0][0] == s);
        assert_true(f.scene.light_colors.items[i].b == 3);
    }
    unload(&f);
}

// The name of a file is relative to the file in which it is written, wherever it is used.
static void files_are_relative_to_who_names_them(void **state)
{
    (void)state;
    char folder[] = "/tmp/scn_fill_XXXXXX";
    assert_non_null(mkdtemp(folder));
    write_file(folder, "main.scn",
               "import \"lib/lib.scn\" as lib\n"
               "ball { material: lib.make(\"a.txt\") }\n"
               "ball { material: lib.own }\n");
    write_file(folder, "a.txt", "");
    char lib[128];
    snprintf(lib, sizeof lib, "%s/lib", folder);
    assert_int_equal(mkdir(lib, 0700), 0);
    write_file(lib, "lib.scn",
               "fn make(name) = everything { file: name }\n"
               "let own = everything { file: \"a.txt\" }\n");
    write_file(lib, "a.txt", "");
    Fixture f = load_file(folder, "main.scn");
    assert_string_equal(f.diagnostics, "");
    char expected[160];
    const Everything *e = scene_params(&f.scene, scene_node(&f.scene, CATEGORY_MATERIAL, 0));
    snprintf(expected, sizeof expected, "%s/a.txt", folder);
    assert_string_equal(e->file, expected);
    e = scene_params(&f.scene, scene_node(&f.scene, CATEGORY_MATERIAL, 1));
    snprintf(expected, sizeof expected, "%s/a.txt", lib);
    assert_string_equal(e->file, expected);
    unload(&f);
    remove_folder(lib);
    remove_folder(folder);
}

static void wrong_lists_are_reported_at_their_item(void **state)
{
    (void)state;
    Fixture f = load("ball { material: everything { numbers: [1, \"a\"] } }\n"
                     "ball { material: everything { vec3s: [(1, 2, 3), (1, 2)] } }\n"
                     "ball { material: everything { faces: [[0, 1, -2]] } }\n"
                     "ball { material: everything { colors: [(1, 1, 1)] } }\n"
                     "ball { material: everything { strings: 3 } }");
    assert_int_equal(f.lang.sink.errors, 5);
    assert_non_null(strstr(f.diagnostics, "`numbers` takes a list of numbers; item 1 is a string"));
    assert_non_null(strstr(f.diagnostics, "test.scn:1:44"));
    assert_non_null(strstr(f.diagnostics, "test.scn:2:50"));
    assert_non_null(strstr(f.diagnostics, "index 2 of face 0 is not a whole number from 0 on"));
    unload(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_evaluated),
        cmocka_unit_test(every_type_is_filled),
        cmocka_unit_test(finish_sees_what_was_given),
        cmocka_unit_test(with_finishes_anew),
        cmocka_unit_test(finish_reports_at_the_field),
        cmocka_unit_test(a_light_owns_its_shape),
        cmocka_unit_test(files_are_relative_to_who_names_them),
        cmocka_unit_test(wrong_lists_are_reported_at_their_item),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
