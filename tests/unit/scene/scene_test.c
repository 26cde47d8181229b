#include "../test_support.h"
#include "scene/scene.h"

#include <string.h>

typedef struct Ball {
    double radius;
} Ball;
static const NodeType ball = {.name = "sphere", .category = CATEGORY_SHAPE, .size = sizeof(Ball)};
static const NodeType lamp = {.name = "lamp", .category = CATEGORY_LIGHT, .size = sizeof(Vec3)};
static const NodeType bare = {.name = "vertex_color", .category = CATEGORY_TEXTURE};
static const NodeType film = {
    .name = "film", .category = CATEGORY_SETTING, .size = sizeof(int64_t)};
static const NodeType *const types[] = {&ball, &lamp, &bare, &film};
static const Schema schema = {types, TEST_COUNT(types)};
enum { BALL, LAMP, BARE, FILM };

static void nodes_keep_their_parameters(void **state)
{
    (void)state;
    Scene scene;
    assert_true(scene_init(&scene, &schema, NULL));
    enum { COUNT = 10000 };
    for (uint32_t i = 0; i < COUNT; ++i) {
        Ball params = {i * 0.5};
        assert_int_equal(scene_add_node(&scene, BALL, &params,
                                        (SceneNode){.material = NONE_ID, .at = {1, i, i + 1}}),
                         i);
        assert_int_equal(scene_add_node(&scene, BARE, NULL, (SceneNode){0}), i);
    }
    for (uint32_t i = 0; i < COUNT; ++i) {
        const SceneNode *node = scene_node(&scene, CATEGORY_SHAPE, i);
        const Ball *params = scene_params(&scene, node);
        assert_true(params->radius == i * 0.5 && node->at.begin == i);
        assert_ptr_equal(scene_node_type(&scene, node), &ball);
        assert_non_null(scene_params(&scene, scene_node(&scene, CATEGORY_TEXTURE, i)));
    }
    assert_int_equal(scene.prototypes.items[0].shape_count, COUNT);
    scene_free(&scene);
    scene_free(&scene); // harmless
}

static void lights_begin_white(void **state)
{
    (void)state;
    Scene scene;
    assert_true(scene_init(&scene, &schema, NULL));
    assert_int_equal(scene_add_node(&scene, LAMP, &(Vec3){1, 2, 3}, (SceneNode){0}), 0);
    assert_int_equal(scene_add_node(&scene, LAMP, &(Vec3){1, 2, 3}, (SceneNode){0}), 1);
    assert_int_equal(scene.light_colors.count, 2);
    assert_true(scene.light_colors.items[1].g == 1.0f);
    scene_free(&scene);
}

static void transforms_have_inverses(void **state)
{
    (void)state;
    Scene scene;
    assert_true(scene_init(&scene, &schema, NULL));
    Affine identity = affine_identity();
    assert_int_equal(scene_add_transform(&scene, &identity), 0);
    Affine turn = affine_rotation(vec3(1, 2, 3), 0.7), move = affine_translation(vec3(5, -6, 1e6));
    Affine both = affine_multiply(&move, &turn);
    uint32_t id = scene_add_transform(&scene, &both);
    assert_int_equal(id, 1);
    assert_int_equal(scene_add_transform(&scene, &both), 1);
    assert_int_equal(scene_add_transform(&scene, &turn), 2);
    Vec3 p = vec3(0.3, -0.4, 0.5);
    Vec3 back =
        transform_point(&scene.inverses.items[id], transform_point(&scene.transforms.items[id], p));
    assert_true(length(sub(back, p)) < 1e-9);
    Affine flat = affine_scaling(vec3(1, 0, 1));
    assert_int_equal(scene_add_transform(&scene, &flat), NONE_ID);
    Affine wild = affine_translation(vec3(0, INFINITY, 0));
    assert_int_equal(scene_add_transform(&scene, &wild), NONE_ID);
    wild.m[1][3] = NAN;
    assert_int_equal(scene_add_transform(&scene, &wild), NONE_ID);
    assert_int_equal(scene.transforms.count, 3);
    assert_int_equal(scene.inverses.count, 3);
    scene_free(&scene);
}

static void names_settings_and_prototypes(void **state)
{
    (void)state;
    Scene scene;
    assert_true(scene_init(&scene, &schema, NULL));
    assert_int_equal(scene_add_name(&scene, STR("")), 0);
    assert_int_equal(scene_add_name(&scene, (Str){"left wall", 4}), 1);
    assert_int_equal(scene_add_name(&scene, STR("left")), 1);
    assert_int_equal(scene_add_name(&scene, STR("right")), 2);
    assert_string_equal(scene.names.items[1], "left");
    assert_null(scene_setting(&scene, "film"));
    int64_t width = 320;
    scene_add_node(&scene, FILM, &width, (SceneNode){0});
    width = 640;
    scene_add_node(&scene, FILM, &width, (SceneNode){0});
    const int64_t *got = scene_setting(&scene, "film");
    assert_true(got && *got == 640);
    assert_null(scene_setting(&scene, "render"));
    assert_int_equal(scene_add_prototype(&scene, 1, (Span){1, 2, 3}), 1);
    scene_add_node(&scene, BALL, &(Ball){1}, (SceneNode){.prototype = 1});
    assert_int_equal(scene.prototypes.items[0].shape_count, 0);
    assert_int_equal(scene.prototypes.items[1].shape_count, 1);
    assert_int_equal(scene_add_instance(&scene, (SceneInstance){.prototype = 1}), 0);
    assert_int_equal(scene_add_mesh(&scene, (Mesh){0}), 0);
    scene_free(&scene);
}

// Makes one of everything; false as soon as something fails.
static bool fill(Scene *scene)
{
    Affine move = affine_translation(vec3(1, 2, 3));
    return scene_init(scene, &schema, NULL) &&
           scene_add_node(scene, BALL, &(Ball){1}, (SceneNode){0}) != NONE_ID &&
           scene_add_node(scene, LAMP, &(Vec3){1, 2, 3}, (SceneNode){0}) != NONE_ID &&
           scene_add_transform(scene, &move) != NONE_ID &&
           scene_add_name(scene, STR("ball")) != NONE_ID &&
           scene_add_prototype(scene, 1, (Span){0}) != NONE_ID &&
           scene_add_instance(scene, (SceneInstance){.prototype = 1}) != NONE_ID &&
           scene_add_mesh(scene, (Mesh){0}) != NONE_ID;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    bool done = false;
    unsigned failures = 0;
    for (; !done && failures < 1000; failures += !done) {
        Scene scene = {0};
        mem_fail_after(failures);
        done = fill(&scene);
        mem_fail_after(UINT64_MAX);
        if (scene.tables) {
            assert_int_equal(scene.transforms.count, scene.inverses.count);
            assert_true(scene.light_colors.count <= scene.nodes[CATEGORY_LIGHT].count);
        }
        scene_free(&scene);
    }
    assert_true(done);
    assert_true(failures >= 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_keep_their_parameters),
        cmocka_unit_test(lights_begin_white),
        cmocka_unit_test(transforms_have_inverses),
        cmocka_unit_test(names_settings_and_prototypes),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
