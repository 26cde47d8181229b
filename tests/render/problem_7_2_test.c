// Problem 7.2 of the slides, by looking for the brightest pixel of the example's picture: the
// points that are derived in examples/slides/problem_7_2.scn.
#include "../unit/test_support.h"

#include "lang/lang.h"
#include "render/render.h"

#include <stdio.h>
#include <stdlib.h>

enum { SIZE = 400 };

typedef struct Brightest {
    double value;
    Vec3 at;
} Brightest;

static Brightest find_brightest(const Film *film)
{
    float *positions = malloc(sizeof(float) * 3 * film_pixel_count(film));
    assert_non_null(positions);
    assert_true(film_aov(film, AOV_POSITION, positions));
    Brightest best = {0};
    for (size_t i = 0; i < film_pixel_count(film); ++i) {
        double value = (double)film_mean(&film->pixels[i]).g;
        if (value > best.value) {
            const float *p = &positions[3 * i];
            best = (Brightest){value, vec3((double)p[0], (double)p[1], (double)p[2])};
        }
    }
    free(positions);
    return best;
}

// Renders the example with one ray through each pixel's centre.
static Brightest render(const char *model, const char *seen_from)
{
    const ParamSetting settings[] = {{STR("model"), str_from(model)},
                                     {STR("seen_from"), str_from(seen_from)}};
    const char *path = SCN_SOURCE_DIR "/examples/slides/problem_7_2.scn";
    Sandbox sandbox;
    Lang lang;
    Scene scene;
    sandbox_init(&sandbox);
    sandbox.allow_all = true;
    assert_true(lang_init(&lang, render_schema(), &sandbox));
    lang.settings = settings;
    lang.setting_count = TEST_COUNT(settings);
    assert_true(scene_init(&scene, render_schema(), &sandbox));
    if (!lang_load(&lang, path, path, &scene)) {
        diag_write_text(&lang.sink, &lang.sources, stderr, DIAG_PLAIN);
        fail();
    }
    const RenderOptions options = {
        .threads = 1, .width = SIZE, .height = SIZE, .samples = 1, .seed = -1, .aovs = true};
    Renderer *renderer = renderer_new(&scene, &options, &lang.sink);
    assert_non_null(renderer);
    assert_true(renderer_run(renderer, NULL));
    assert_int_equal(lang.sink.count, 0);
    Brightest found = find_brightest(renderer_film(renderer));
    renderer_free(renderer);
    scene_free(&scene);
    lang_free(&lang);
    sandbox_free(&sandbox);
    return found;
}

static void check(Brightest found, Vec3 at, double distance, double value, double below)
{
    if (!(length(sub(found.at, at)) <= distance)) {
        fail_msg("brightest at (%.4f, %.4f, %.4f), not (%.4f, %.4f, %.4f)", found.at.x, found.at.y,
                 found.at.z, at.x, at.y, at.z);
    }
    if (!(found.value <= value + 1e-6 && found.value >= value - below)) {
        fail_msg("as bright as %.6f, not %.6f", found.value, value);
    }
}

// A pixel is 0.16 degrees wide, 0.009 of the sphere where the highlight is: as r turns about thrice
// as far, (r·v)^20 is above cos(0.02)^20.
static void highlights(void **state)
{
    (void)state;
    const Vec3 bisector = {sqrt(0.5), sqrt(0.5), 0};
    check(render("phong", "observer"), bisector, 0.02, 1, 5e-3);
    check(render("blinn_phong", "observer"), bisector, 0.02, 1, 5e-3);
}

static void diffuse_maximum_is_seen_from_the_light(void **state)
{
    (void)state;
    check(render("diffuse", "light"), vec3(0, 1, 0), 0.01, 1, 1e-4);
}

// The observer sees the sphere ever brighter towards his horizon, where a pixel covers a long
// stretch of it: 0.003 off the horizon's ray is √(2 · 0.003 · …) ≈ 0.1 on the sphere.
static void diffuse_maximum_is_hidden_from_the_observer(void **state)
{
    (void)state;
    const double limit = (sqrt(3) - 1) / sqrt(5 - 2 * sqrt(3));
    Brightest found = render("diffuse", "observer");
    check(found, vec3(0.5, sqrt(0.75), 0), 0.12, limit, 0.06);
    assert_true(found.at.x > 0.5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(highlights),
        cmocka_unit_test(diffuse_maximum_is_seen_from_the_light),
        cmocka_unit_test(diffuse_maximum_is_hidden_from_the_observer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
