// A camera that is moved by hand: the moves' geometry, and its text, which must give the same
// camera.
#include "render/render.h"
#include "watch/pose.h"

#include "../test_support.h"

static CameraPose pose(void)
{
    return (CameraPose){.position = {0, 1, 5},
                        .target = {0, 1, 0},
                        .up = {0, 1, 0},
                        .fov = 40 * PI / 180,
                        .projection = CAMERA_PERSPECTIVE};
}

static void assert_near(Vec3 a, Vec3 b, double by)
{
    assert_true(length(sub(a, b)) < by);
}

static void orbit_keeps_the_distance_and_turns_about_up(void **state)
{
    (void)state;
    CameraPose p = pose();
    pose_orbit(&p, PI / 2, 0);
    assert_near(p.position, vec3(5, 1, 0), 1e-12);
    pose_orbit(&p, 0, PI / 6);
    assert_near(p.position, vec3(5 * cos(PI / 6), 1 + 2.5, 0), 1e-12);
    assert_near(p.target, vec3(0, 1, 0), 1e-15);
}

static void orbit_stops_short_of_the_poles(void **state)
{
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2) {
        CameraPose p = pose();
        pose_orbit(&p, 0, sign * 10);
        Affine view;
        assert_true(affine_look_at(p.position, p.target, p.up, &view));
        assert_true(fabs(length(sub(p.position, p.target)) - 5) < 1e-12);
        // … and comes back on the side on which it went.
        pose_orbit(&p, 0, -sign * 89 * PI / 180);
        assert_near(p.position, vec3(0, 1, 5), 1e-9);
    }
}

static void pan_moves_by_parts_of_the_picture(void **state)
{
    (void)state;
    CameraPose p = pose();
    double height = 2 * 5 * tan(20 * PI / 180);
    pose_pan(&p, 1, 0.5);
    assert_near(p.target, vec3(height, 1 + height / 2, 0), 1e-12);
    assert_near(sub(p.position, p.target), vec3(0, 0, 5), 1e-12);
}

static void dolly_scales_the_distance(void **state)
{
    (void)state;
    CameraPose p = pose();
    pose_dolly(&p, 0.5);
    assert_near(p.position, vec3(0, 1, 2.5), 1e-12);
}

// What the text says is the pose, to the digits that it has.
static void check_text(const CameraPose *p, double by)
{
    Text text = {0};
    CameraParams params;
    char message[200] = "";
    pose_text(p, render_schema(), &text);
    if (!camera_from_text(render_schema(), text.bytes, &params, message, sizeof message)) {
        fail_msg("%s: %s", text.bytes, message);
    }
    assert_near(params.position, p->position, by);
    assert_near(params.look_at, p->target, by);
    assert_int_equal(params.projection, p->projection);
    assert_true(fabs(params.aperture - p->aperture) <= 1e-4 * p->aperture);
    if (p->focus_distance > 0) {
        assert_true(fabs(params.focus_distance - p->focus_distance) <= 1e-4 * p->focus_distance);
    }
    text_free(&text);
}

static void the_text_gives_the_same_camera(void **state)
{
    (void)state;
    CameraPose p = pose();
    check_text(&p, 1e-12);
    pose_orbit(&p, 0.3, 0.2);
    check_text(&p, 5e-4);
    p.aperture = 0.0123;
    p.focus_distance = 4.56;
    p.up = normalize(vec3(0.1, 1, 0));
    check_text(&p, 5e-4);
    p.projection = CAMERA_FISHEYE;
    p.aperture = p.focus_distance = 0;
    check_text(&p, 5e-4);
    p.projection = CAMERA_ORTHOGRAPHIC;
    p.height = 3;
    check_text(&p, 5e-4);
    // Far away and small: digits follow the distance, not the numbers' size.
    p = (CameraPose){.position = {1e6, 2e-3, 0}, .target = {1e6, 0, 0}, .up = {0, 0, 1}, .fov = 1};
    check_text(&p, 1e-6);
}

static void a_camera_becomes_a_pose_and_back(void **state)
{
    (void)state;
    CameraParams params;
    char message[200];
    assert_true(camera_from_text(render_schema(),
                                 "camera { position: (1, 2, 3), look_at: (0, 0.5, 0), "
                                 "aperture: 1cm, fov: 50deg, transform: translate(1, 0, 0) }",
                                 &params, message, sizeof message));
    Camera camera;
    Affine identity = affine_identity();
    camera_setup(&camera, &params, &identity, 64, 40);
    CameraPose p = pose_from_camera(&camera, length(vec3(1, 1.5, 3)));
    assert_near(p.position, vec3(2, 2, 3), 1e-12);
    assert_near(p.target, vec3(1, 0.5, 0), 1e-12);
    assert_near(p.up, vec3(0, 1, 0), 1e-12);
    assert_true(p.focus_distance == 0); // that of look_at is the usual one
    assert_true(fabs(p.aperture - 0.01) < 1e-15);
}

static void other_texts_are_no_cameras(void **state)
{
    (void)state;
#define GOOD "camera { position: (0, 0, 1), look_at: (0, 0, 0) }"
    static const char *const texts[] = {
        "",
        "sphere {}",
        "camera { position: (0, 0, 1) }",
        "camera {",
        (GOOD " " GOOD),
        ("import \"/etc/passwd\" as p\n" GOOD),
        ("fn f(n) = f(n + 1)\nlet _x = f(0)\n" GOOD),
    };
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        CameraParams params;
        char message[200] = "";
        assert_false(camera_from_text(render_schema(), texts[i], &params, message, sizeof message));
        assert_true(*message);
    }
}

static void shell_words_are_quoted(void **state)
{
    (void)state;
    Text text = {0};
    text_shell_word(&text, "plain-word_1.scn");
    text_shell_word(&text, "two words");
    text_shell_word(&text, "it's $HOME");
    text_shell_word(&text, "");
    assert_string_equal(text.bytes, "plain-word_1.scn 'two words' 'it'\\''s $HOME' ''");
    text_free(&text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orbit_keeps_the_distance_and_turns_about_up),
        cmocka_unit_test(orbit_stops_short_of_the_poles),
        cmocka_unit_test(pan_moves_by_parts_of_the_picture),
        cmocka_unit_test(dolly_scales_the_distance),
        cmocka_unit_test(the_text_gives_the_same_camera),
        cmocka_unit_test(a_camera_becomes_a_pose_and_back),
        cmocka_unit_test(other_texts_are_no_cameras),
        cmocka_unit_test(shell_words_are_quoted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
