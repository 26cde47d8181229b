// From .scn text to the film's bytes: the same for any number of threads, other for another seed,
// and settings of the text arrive where they should.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "../trust.h"
#include "loaded.h"

static const char room[] =
    "film { width: 40, height: 30 }\n"
    "render { samples: 80, bounces: 4, seed: 3 }\n"
    "camera { position: (0, 1, 4), look_at: (0, 0.5, 0), fov: 50deg, aperture: 2cm }\n"
    "plane { point: (0, 0, 0), normal: (0, 1, 0)\n"
    "        material: lambert { color: checker { a: gray(0.2), b: gray(0.8) } } }\n"
    "for (i in 0..<3) {\n"
    "  sphere { center: (i - 1, 0.5, 0), radius: 0.4, material: lambert { color: rgb(0.7, 0.4, 0.1 "
    "* i) } }\n"
    "}\n"
    "point_light { position: (2, 3, 2), power: 60W }\n"
    "area_light { shape: sphere { center: (-2, 3, 1), radius: 0.3 }, radiance: 20 }\n"
    "environment_light { color: rgb(0.2, 0.3, 0.5) }\n";

static Renderer *rendered(Loaded *l, RenderOptions options)
{
    Renderer *r = renderer_new(&l->scene, &options, &l->lang.sink);
    assert_non_null(r);
    RenderStats stats;
    assert_true(renderer_run(r, &stats));
    assert_false(stats.stopped);
    assert_int_equal(stats.bad_samples, 0);
    return r;
}

static long compared, different; // films, whose bytes should be the same

static bool same(const Renderer *a, const Renderer *b)
{
    const Film *x = renderer_film(a), *y = renderer_film(b);
    const size_t n = film_pixel_count(x);
    return n == film_pixel_count(y) && memcmp(x->pixels, y->pixels, n * sizeof *x->pixels) == 0 &&
           !x->gains == !y->gains &&
           (!x->gains || memcmp(x->gains, y->gains, n * sizeof *x->gains) == 0) &&
           (!x->aovs || memcmp(x->aovs, y->aovs, n * sizeof *x->aovs) == 0);
}

// Threads and tiles, with and without layers.
static void check_threads_and_tiles(Loaded *l, RenderOptions options, const char *what)
{
    static const struct {
        unsigned threads;
        int tile_width, tile_height;
    } ways[] = {{2, 0, 0}, {8, 0, 0}, {8, 1, 1}, {2, 7, 300}, {3, 64, 2}};
    for (int aovs = 0; aovs < 2; ++aovs) {
        options.threads = 1;
        options.aovs = aovs;
        Renderer *one = rendered(l, options);
        for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
            RenderOptions other = options;
            other.threads = ways[i].threads;
            other.tile_width = ways[i].tile_width;
            other.tile_height = ways[i].tile_height;
            Renderer *many = rendered(l, other);
            ++compared;
            if (!same(one, many)) {
                ++different;
                print_message("%s: other bytes for %u threads, tiles of %d x %d\n", what,
                              other.threads, other.tile_width, other.tile_height);
            }
            renderer_free(many);
        }
        renderer_free(one);
    }
}

static void threads_and_tiles_change_nothing(void **state)
{
    (void)state;
    Loaded l;
    load(&l, room);
    check_threads_and_tiles(&l, (RenderOptions){.seed = -1}, "room");
    for (int i = 0; integrator_classes[i]; ++i) {
        check_threads_and_tiles(
            &l, (RenderOptions){.seed = -1, .samples = 5, .integrator = integrator_classes[i]},
            integrator_classes[i]->name);
    }
    assert_int_equal(different, 0);
    unload(&l);
}

static void stopping_rules_change_nothing(void **state)
{
    (void)state;
    char text[1200];
    const char *samples = strstr(room, "samples: 80");
    snprintf(text, sizeof text, "%.*ssamples: 400, stop: until { error: 0.2 }%s",
             (int)(samples - room), room, samples + strlen("samples: 80"));
    Loaded l;
    load(&l, text);
    check_threads_and_tiles(&l, (RenderOptions){.seed = -1}, "stopping rule");
    Renderer *r = rendered(&l, (RenderOptions){.seed = -1});
    const Film *film = renderer_film(r);
    uint32_t most = 0;
    for (size_t p = 0; p < film_pixel_count(film); ++p) {
        most = film->pixels[p].samples > most ? film->pixels[p].samples : most;
    }
    assert_true(film->samples_done < most); // it does adapt
    assert_true(trust_none("27 threads and tiles, films of other bytes", different, compared));
    renderer_free(r);
    unload(&l);
}

// The scene read twice, and its accelerator built by other numbers of threads.
static void reading_again_changes_nothing(void **state)
{
    (void)state;
    Loaded a, b;
    load(&a, room);
    load(&b, room);
    Renderer *x = rendered(&a, (RenderOptions){.threads = 1, .seed = -1});
    Renderer *y = rendered(&b, (RenderOptions){.threads = 4, .seed = -1});
    assert_true(same(x, y));
    renderer_free(x);
    renderer_free(y);
    unload(&a);
    unload(&b);
}

static void ranges_join_to_the_whole(void **state)
{
    (void)state;
    Loaded l;
    load(&l, room);
    Renderer *whole = rendered(&l, (RenderOptions){.threads = 2, .seed = -1, .aovs = true});
    Renderer *head =
        rendered(&l, (RenderOptions){.threads = 1, .seed = -1, .aovs = true, .samples = 64});
    Renderer *tail = rendered(
        &l,
        (RenderOptions){.threads = 2, .seed = -1, .aovs = true, .samples = 16, .first_sample = 64});
    Film joined = *renderer_film(head);
    assert_false(same(whole, head));
    assert_int_equal(film_merge(&joined, renderer_film(tail)), FILM_MERGED);
    assert_true(trust_none("27 ranges of samples joined, films of other bytes", !same(whole, head),
                           1)); // `joined` shares the pixels of `head`
    renderer_free(whole);
    renderer_free(head);
    renderer_free(tail);
    unload(&l);
}

static void seeds_change_the_noise_only(void **state)
{
    (void)state;
    Loaded l;
    load(&l, room);
    double mean[3];
    Renderer *r[3];
    const int64_t seeds[] = {-1, 3, 4};
    for (int i = 0; i < 3; ++i) {
        r[i] = rendered(&l, (RenderOptions){.threads = 2, .seed = seeds[i], .samples = 32});
        const Film *film = renderer_film(r[i]);
        mean[i] = 0;
        for (size_t p = 0; p < film_pixel_count(film); ++p) {
            mean[i] += film->pixels[p].sum[1] / 32 / (double)film_pixel_count(film);
        }
    }
    assert_true(same(r[0], r[1])); // 3 is the scene's own
    assert_false(same(r[0], r[2]));
    assert_true(mean[0] > 0.05);
    assert_true(mean[2] / mean[0] > 0.97 && mean[2] / mean[0] < 1.03);
    for (int i = 0; i < 3; ++i) {
        renderer_free(r[i]);
    }
    unload(&l);
}

static void settings_arrive(void **state)
{
    (void)state;
    Loaded l;
    load(&l, "film { width: 12, height: 7, filter: \"tent\", tone: \"aces\", exposure: -1.5\n"
             "       aovs: [\"albedo\", \"depth\"] }\n"
             "render { samples: 5, seed: 9, sampling: \"bsdf\", shadows: false, clamp: 10 }\n"
             "camera { position: (0, 0, 5), direction: (0, 0, -1) }\n"
             "sphere {}\n");
    const FilmParams film = scene_film(&l.scene);
    assert_int_equal(film.width, 12);
    assert_int_equal(film.height, 7);
    assert_int_equal(film.filter, 1);
    assert_int_equal(film.tone, TONE_ACES);
    assert_true(film.exposure == -1.5);
    assert_true(film.filter_width == 0); // its own
    assert_int_equal(film.aovs.count, 2);
    assert_string_equal(film.aovs.items[1], "depth");
    const RenderParams render = scene_render(&l.scene);
    assert_int_equal(render.samples, 5);
    assert_int_equal(render.bounces, 12);
    assert_int_equal(render.seed, 9);
    assert_int_equal(render.sampling, SAMPLING_BSDF);
    assert_false(render.shadows);
    assert_true(render.russian_roulette);
    assert_true(render.clamp == 10);
    assert_string_equal(integrator_classes[render.integrator]->name, "path");
    Renderer *r = rendered(&l, (RenderOptions){.threads = 1, .seed = -1});
    assert_int_equal(renderer_film(r)->width, 12);
    assert_int_equal(renderer_film(r)->samples_done, 5);
    renderer_free(r);
    unload(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_and_tiles_change_nothing),
        cmocka_unit_test(stopping_rules_change_nothing),
        cmocka_unit_test(reading_again_changes_nothing),
        cmocka_unit_test(ranges_join_to_the_whole),
        cmocka_unit_test(seeds_change_the_noise_only),
        cmocka_unit_test(settings_arrive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
