// The driver: the same bytes for any number of threads, for runs stopped and continued, and for
// ranges of samples rendered apart; progress and figures; what can't be rendered.
//
// The light comes from an integrator that is made here, so that the tests are of the driver alone:
// it hashes the ray and the next sample numbers.
#include "render/render.h"

#include "base/hash.h"
#include "base/mem.h"
#include "near.h"
#include "render/camera.h"
#include "render/filter.h"

#include <stdlib.h>
#include <string.h>

// --- Integrators ---------------------------------------------------------------------------------

static uint32_t hash_double(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (uint32_t)(hash_u64(bits) >> 32);
}

static Rgb hashed_radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                           IntegratorStats *stats)
{
    (void)world;
    stats->rays += 2;
    stats->shadow_rays += 1;
    const uint32_t key = hash_combine(hash_double(ray->direction.x), hash_double(ray->direction.y));
    if (aov && key % 4 != 0) {
        *aov = (AovSample){
            .albedo = {sampler_1d(sampler), 0.5f, 0.25f},
            .normal = neg(ray->direction),
            .position = add_scaled(ray->origin, ray->direction, 3),
            .object = key % 7 + 1,
            .material = key % 3 + 1,
        };
    }
    sampler_seek(sampler, 8); // with and without aov the same
    const float v = sampler_1d(sampler);
    return rgb(v * exp2f((float)(key % 25) - 12), v, hash_to_float(key));
}
static const IntegratorClass hashed = {
    .name = "hashed", .doc = "of the test", .radiance = hashed_radiance};

static Rgb constant_radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                             IntegratorStats *stats)
{
    (void)world, (void)ray, (void)sampler, (void)aov, (void)stats;
    return rgb(0.25f, 1, 3.7f);
}
static const IntegratorClass constant = {
    .name = "constant", .doc = "of the test", .radiance = constant_radiance};

// Every fourth sample or so is bad.
static Rgb bad_radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                        IntegratorStats *stats)
{
    (void)world, (void)ray, (void)aov, (void)stats;
    const int pick = (int)(sampler_1d(sampler) * 8);
    return pick == 0   ? rgb(NAN, 1, 1)
           : pick == 1 ? rgb(1, INFINITY, 1)
           : pick == 2 ? rgb(1, 1, -1)
                       : rgb(1, 1, 1);
}
static const IntegratorClass bad = {.name = "bad", .doc = "of the test", .radiance = bad_radiance};

// --- A scene with a camera and settings ----------------------------------------------------------

typedef struct Fixture {
    Arena arena;
    DiagSink sink;
    Sandbox sandbox;
    Scene scene;
} Fixture;

static void add_setting(Scene *scene, const char *kind, const void *params)
{
    const int type = schema_find(scene->schema, str_from(kind));
    assert_true(type >= 0);
    const SceneNode node = {.material = NONE_ID};
    assert_true(scene_add_node(scene, (uint16_t)type, params, node) != NONE_ID);
}

enum { W = 37, H = 21 };

static CameraParams view(void)
{
    CameraParams camera = {.position = {0, 0, 5}, .fov = 0.7, .up = {0, 1, 0}};
    assert_true(affine_look_at(camera.position, vec3(0, 0, 0), camera.up, &camera.frame));
    return camera;
}

static void fixture_init(Fixture *f, int64_t samples)
{
    memset(f, 0, sizeof *f);
    diag_sink_init(&f->sink, &f->arena);
    sandbox_init(&f->sandbox);
    assert_true(scene_init(&f->scene, render_schema(), &f->sandbox));
    const CameraParams camera = view();
    const FilmParams film = {.width = W, .height = H, .filter = FILTER_BLACKMAN_HARRIS};
    RenderParams render = scene_render(&f->scene);
    render.samples = samples;
    render.seed = 5;
    add_setting(&f->scene, "camera", &camera);
    add_setting(&f->scene, "film", &film);
    add_setting(&f->scene, "render", &render);
}

static void fixture_free(Fixture *f)
{
    scene_free(&f->scene);
    sandbox_free(&f->sandbox);
    diag_sink_free(&f->sink);
    arena_free(&f->arena);
}

static RenderOptions options_with(unsigned threads)
{
    return (RenderOptions){.threads = threads, .seed = -1, .aovs = true, .integrator = &hashed};
}

static Renderer *rendered(Fixture *f, RenderOptions options, RenderStats *stats)
{
    Renderer *r = renderer_new(&f->scene, &options, &f->sink);
    assert_non_null(r);
    assert_true(renderer_run(r, stats));
    return r;
}

static bool same_film(const Film *a, const Film *b)
{
    const size_t n = film_pixel_count(a);
    return n == film_pixel_count(b) && a->samples_done == b->samples_done &&
           memcmp(a->pixels, b->pixels, n * sizeof *a->pixels) == 0 && !a->gains == !b->gains &&
           (!a->gains || memcmp(a->gains, b->gains, n * sizeof *a->gains) == 0) &&
           !a->aovs == !b->aovs && (!a->aovs || memcmp(a->aovs, b->aovs, n * sizeof *a->aovs) == 0);
}

// --- Bytes
// -----------------------------------------------------------------------------------------

static void bytes_do_not_depend_on_threads(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 150); // two whole blocks and a part
    Renderer *one = rendered(&f, options_with(1), NULL);
    assert_int_equal(renderer_film(one)->samples_done, 150);
    const unsigned threads[] = {2, 3, 8, 0};
    for (int i = 0; i < 4; ++i) {
        Renderer *many = rendered(&f, options_with(threads[i]), NULL);
        assert_true(same_film(renderer_film(one), renderer_film(many)));
        renderer_free(many);
    }
    // Without layers the picture is the same, too.
    RenderOptions plain = options_with(2);
    plain.aovs = false;
    Renderer *bare = rendered(&f, plain, NULL);
    assert_null(renderer_film(bare)->aovs);
    assert_memory_equal(renderer_film(one)->pixels, renderer_film(bare)->pixels,
                        W * H * sizeof(FilmPixel));
    renderer_free(bare);
    renderer_free(one);
    fixture_free(&f);
}

static void seeds_give_other_bytes(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 4);
    RenderOptions options = options_with(2);
    Renderer *a = rendered(&f, options, NULL);
    options.seed = 5; // the scene's own
    Renderer *b = rendered(&f, options, NULL);
    options.seed = 6;
    Renderer *c = rendered(&f, options, NULL);
    assert_true(same_film(renderer_film(a), renderer_film(b)));
    int same = 0;
    for (int p = 0; p < W * H; ++p) {
        same += renderer_film(a)->pixels[p].sum[1] == renderer_film(c)->pixels[p].sum[1];
    }
    assert_int_equal(same, 0);
    renderer_free(a);
    renderer_free(b);
    renderer_free(c);
    fixture_free(&f);
}

// Stops after a number of samples drawn at random, in the middle of tiles and blocks.
typedef struct Stopper {
    atomic_int stop;
    atomic_long left;
} Stopper;
static Stopper *stopper_of_the_test; // an integrator has no context of its own

static Rgb stopping_radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                             IntegratorStats *stats)
{
    if (atomic_fetch_sub(&stopper_of_the_test->left, 1) == 1) {
        atomic_store(&stopper_of_the_test->stop, 1);
    }
    return hashed_radiance(world, ray, sampler, aov, stats);
}
static const IntegratorClass stopping = {
    .name = "stopping", .doc = "of the test", .radiance = stopping_radiance};

static void stopped_runs_go_on_to_the_same_bytes(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 140);
    Renderer *whole = rendered(&f, options_with(1), NULL);
    for (unsigned threads = 1; threads <= 8; threads *= 2) {
        Stopper stopper;
        atomic_init(&stopper.stop, 0);
        atomic_init(&stopper.left, 0);
        stopper_of_the_test = &stopper;
        RenderOptions options = options_with(threads);
        options.integrator = &stopping;
        options.stop = &stopper.stop;
        Renderer *r = renderer_new(&f.scene, &options, &f.sink);
        assert_non_null(r);
        RenderStats stats;
        int stops = -1;
        do {
            ++stops;
            assert_in_range(stops, 0, 60);
            atomic_store(&stopper.stop, 0);
            atomic_store(&stopper.left, 2500 + (long)(hash_u32((uint32_t)stops) % 9000));
            assert_true(renderer_run(r, &stats));
        } while (stats.stopped);
        assert_true(stops > 5);
        assert_true(same_film(renderer_film(whole), renderer_film(r)));
        assert_int_equal(stats.samples, 140 * W * H);
        renderer_free(r);
    }
    renderer_free(whole);
    fixture_free(&f);
}

static void a_stop_before_the_start_leaves_black(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 8);
    atomic_int stop;
    atomic_init(&stop, 1);
    RenderOptions options = options_with(2);
    options.stop = &stop;
    RenderStats stats;
    Renderer *r = rendered(&f, options, &stats);
    assert_true(stats.stopped);
    assert_int_equal(stats.samples, 0);
    float out[3 * W * H];
    film_develop(renderer_film(r), renderer_film_params(r), 3, false, 2, out);
    assert_true(out[0] == 0 && out[3 * W * H - 1] == 0);
    renderer_free(r);
    fixture_free(&f);
}

static void ranges_join_to_the_same_bytes(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 300);
    Renderer *whole = rendered(&f, options_with(2), NULL);
    static const int64_t cuts[][4] = {{0, 64, 192, 300}, {0, 128, 192, 300}, {0, 192, 256, 300}};
    for (size_t c = 0; c < 3; ++c) {
        Renderer *parts[3];
        for (int i = 0; i < 3; ++i) {
            RenderOptions options = options_with(1 + (unsigned)i);
            options.first_sample = cuts[c][i];
            options.samples = cuts[c][i + 1] - cuts[c][i];
            parts[i] = rendered(&f, options, NULL);
        }
        // The test joins into the first renderer's own film, which it may: it owns the renderer.
        Film joined = *renderer_film(parts[0]);
        for (int i = 1; i < 3; ++i) {
            assert_int_equal(film_merge(&joined, renderer_film(parts[i])), FILM_MERGED);
        }
        assert_true(same_film(renderer_film(whole), &joined));
        for (int i = 0; i < 3; ++i) {
            renderer_free(parts[i]);
        }
    }
    renderer_free(whole);
    fixture_free(&f);
}

// --- Light, figures, progress
// ----------------------------------------------------------------------

static void constant_light_is_exact(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 100);
    RenderOptions options = options_with(2);
    options.integrator = &constant;
    for (int32_t filter = FILTER_BOX; filter <= FILTER_BLACKMAN_HARRIS; ++filter) {
        const FilmParams film = {.width = W, .height = H, .filter = filter, .filter_width = 5};
        add_setting(&f.scene, "film", &film);
        Renderer *r = rendered(&f, options, NULL);
        for (int p = 0; p < W * H; ++p) {
            const Rgb mean = film_mean(&renderer_film(r)->pixels[p]);
            assert_true(mean.r == 0.25f && mean.g == 1 && mean.b == 3.7f);
            assert_near(film_variance(&renderer_film(r)->pixels[p]), 0, 1e-15);
        }
        renderer_free(r);
    }
    fixture_free(&f);
}

static void bad_samples_are_counted_and_black(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 64);
    RenderOptions options = options_with(2);
    options.integrator = &bad;
    RenderStats stats;
    Renderer *r = rendered(&f, options, &stats);
    double sum = 0;
    for (int p = 0; p < W * H; ++p) {
        sum += renderer_film(r)->pixels[p].sum[0];
    }
    assert_near(sum, (double)(64 * W * H - stats.bad_samples), 0);
    assert_near((double)stats.bad_samples / (64 * W * H), 3.0 / 8, 0.01);
    renderer_free(r);
    fixture_free(&f);
}

typedef struct Watch {
    int calls, passes;
    uint32_t done[32];
    double fraction;
    atomic_int inside;
} Watch;

static void watch(void *context, const RenderProgress *progress)
{
    Watch *w = context;
    assert_int_equal(atomic_fetch_add(&w->inside, 1), 0); // one at a time
    assert_true(progress->fraction >= w->fraction && progress->fraction <= 1);
    assert_true(progress->seconds >= 0 && progress->seconds_left >= 0);
    w->fraction = progress->fraction;
    ++w->calls;
    if (progress->pass_done) {
        assert_in_range(w->passes, 0, 31);
        w->done[w->passes++] = progress->film->samples_done;
        assert_int_equal(progress->samples, (uint64_t)progress->film->samples_done * W * H);
    }
    atomic_fetch_sub(&w->inside, 1);
}

static void progress_and_figures_add_up(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 200);
    Watch w = {.calls = 0};
    RenderOptions options = options_with(4);
    options.progress = watch;
    options.context = &w;
    RenderStats stats;
    Renderer *r = rendered(&f, options, &stats);
    static const uint32_t passes[] = {1, 4, 16, 64, 128, 192, 200};
    assert_int_equal(w.passes, 7);
    assert_memory_equal(w.done, passes, sizeof passes);
    assert_true(w.fraction == 1);
    assert_false(stats.stopped);
    assert_int_equal(stats.samples, 200 * W * H);
    assert_int_equal(stats.rays, 2 * 200 * W * H);
    assert_int_equal(stats.shadow_rays, 200 * W * H);
    assert_true(stats.render_seconds > 0 && stats.build_seconds >= 0);
    renderer_free(r);
    fixture_free(&f);
}

// --- Settings and cameras
// ----------------------------------------------------------------------------

static void options_go_before_the_scene(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 200);
    RenderOptions options = options_with(1);
    options.width = 8;
    options.height = 6;
    options.samples = 3;
    options.seed = 77;
    Renderer *r = rendered(&f, options, NULL);
    assert_int_equal(renderer_film(r)->width, 8);
    assert_int_equal(renderer_film(r)->height, 6);
    assert_int_equal(renderer_film(r)->samples_done, 3);
    assert_int_equal(renderer_params(r)->seed, 77);
    assert_int_equal(renderer_film_params(r)->width, 8);
    renderer_free(r);
    fixture_free(&f);
}

static void defaults_are_the_tables(void **state)
{
    (void)state;
    Fixture f;
    memset(&f, 0, sizeof f);
    sandbox_init(&f.sandbox);
    assert_true(scene_init(&f.scene, render_schema(), &f.sandbox));
    const FilmParams film = scene_film(&f.scene);
    const RenderParams render = scene_render(&f.scene);
    const struct {
        const char *kind, *field;
        int64_t value;
    } numbers[] = {
        {"film", "width", film.width},
        {"film", "height", film.height},
        {"film", "exposure", (int64_t)film.exposure},
        {"render", "samples", render.samples},
        {"render", "bounces", render.bounces},
        {"render", "seed", render.seed},
        {"render", "shadows", render.shadows},
        {"render", "russian_roulette", render.russian_roulette},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
        const NodeType *type =
            render_schema()->types[schema_find(render_schema(), str_from(numbers[i].kind))];
        const Param *param = &type->params[node_type_find_param(type, str_from(numbers[i].field))];
        const int64_t wanted =
            strcmp(param->default_text, "true") == 0 ? 1 : strtoll(param->default_text, NULL, 10);
        assert_int_equal(numbers[i].value, wanted);
    }
    const struct {
        const char *kind, *field;
        int32_t value;
    } choices[] = {
        {"film", "filter", film.filter},
        {"film", "tone", film.tone},
        {"render", "integrator", render.integrator},
        {"render", "sampling", render.sampling},
        {"render", "caustics", render.caustics},
    };
    for (size_t i = 0; i < sizeof choices / sizeof *choices; ++i) {
        const NodeType *type =
            render_schema()->types[schema_find(render_schema(), str_from(choices[i].kind))];
        const Param *param = &type->params[node_type_find_param(type, str_from(choices[i].field))];
        char quoted[64];
        snprintf(quoted, sizeof quoted, "\"%s\"", param->choices[choices[i].value]);
        assert_string_equal(quoted, param->default_text);
    }
    // The choices are the classes, in their order.
    const NodeType *type = render_schema()->types[schema_find(render_schema(), STR("render"))];
    const Param *param = &type->params[node_type_find_param(type, STR("integrator"))];
    int i = 0;
    for (; integrator_classes[i]; ++i) {
        assert_string_equal(integrator_classes[i]->name, param->choices[i]);
    }
    assert_null(param->choices[i]);
    scene_free(&f.scene);
    sandbox_free(&f.sandbox);
}

static void the_schema_is_sound(void **state)
{
    (void)state;
    char message[300];
    const char *wrong = schema_check(render_schema(), message, sizeof message);
    if (wrong) {
        fail_msg("%s", wrong);
    }
}

static void impossible_pictures_are_refused(void **state)
{
    (void)state;
    static const struct {
        int width, height;
        int64_t samples, first;
        DiagCode code;
    } cases[] = {
        {1 << 16, (1 << 14) + 1, 1, 0, E0927},
        {4, 4, 1, 65, E0928},
        {4, 4, 1, -64, E0928},
        {4, 4, INT64_C(1) << 31, 64, E0928},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        Fixture f;
        fixture_init(&f, 1);
        RenderOptions options = options_with(1);
        options.width = cases[i].width;
        options.height = cases[i].height;
        options.samples = cases[i].samples;
        options.first_sample = cases[i].first;
        assert_null(renderer_new(&f.scene, &options, &f.sink));
        assert_int_equal(f.sink.errors, 1);
        assert_int_equal(f.sink.items[0].code, cases[i].code);
        fixture_free(&f);
    }
}

static void want_of_memory_is_told(void **state)
{
    (void)state;
    for (uint64_t allowed = 0;; ++allowed) {
        Fixture f;
        fixture_init(&f, 1);
        // Room for diagnostics is made before memory runs out.
        diag_report(&f.sink, W0921, (Span){0}, "made before");
        const RenderOptions options = options_with(2);
        mem_fail_after(allowed);
        Renderer *r = renderer_new(&f.scene, &options, &f.sink);
        mem_fail_after(UINT64_MAX);
        const bool made = r != NULL;
        assert_true(made ? f.sink.errors == 0 : f.sink.errors > 0);
        renderer_free(r);
        fixture_free(&f);
        if (made) {
            assert_true(allowed > 3);
            return;
        }
    }
}

static void cameras_are_chosen(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 1);
    Renderer *r = rendered(&f, options_with(1), NULL);
    assert_int_equal(f.sink.count, 0);
    Renderer *again;
    // A second camera: the first is used, with a warning, until one is chosen.
    CameraParams other = view();
    other.frame = affine_translation(vec3(9, 9, 9));
    const int type = schema_find(f.scene.schema, STR("camera"));
    const uint32_t name = scene_add_name(&f.scene, STR("side"));
    const SceneNode node = {.material = NONE_ID, .name = name};
    const uint32_t side = scene_add_node(&f.scene, (uint16_t)type, &other, node);
    assert_int_equal(scene_find_camera(&f.scene, STR("side")), side);
    assert_true(scene_find_camera(&f.scene, STR("front")) == NONE_ID);
    f.scene.camera = NONE_ID;
    again = rendered(&f, options_with(1), NULL);
    assert_true(same_film(renderer_film(r), renderer_film(again)));
    assert_int_equal(f.sink.items[0].code, W0922);
    renderer_free(again);
    f.scene.camera = side;
    again = rendered(&f, options_with(1), NULL);
    assert_false(same_film(renderer_film(r), renderer_film(again)));
    assert_int_equal(f.sink.count, 1);
    renderer_free(again);
    renderer_free(r);
    fixture_free(&f);
}

static void a_scene_without_camera_is_seen(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f, 1);
    f.scene.nodes[CATEGORY_CAMERA].count = 0;
    f.scene.camera = NONE_ID;
    // A sphere somewhere: the middle of the picture shows it, the corners don't.
    const int type = schema_find(f.scene.schema, STR("sphere"));
    const NodeType *sphere = f.scene.schema->types[type];
    _Alignas(16) char params[256] = {0};
    assert_true(sphere->size <= sizeof params);
    const Vec3 center = vec3(30, -70, 500);
    const double radius = 0.25;
    memcpy(params + sphere->params[node_type_find_param(sphere, STR("center"))].offset, &center,
           sizeof center);
    memcpy(params + sphere->params[node_type_find_param(sphere, STR("radius"))].offset, &radius,
           sizeof radius);
    const SceneNode node = {.material = NONE_ID};
    assert_true(scene_add_node(&f.scene, (uint16_t)type, params, node) != NONE_ID);
    RenderOptions options = options_with(1);
    options.integrator = NULL;
    Renderer *r = rendered(&f, options, NULL);
    assert_int_equal(f.sink.items[0].code, W0921);
    assert_int_equal(f.sink.errors, 0);
    const AovPixel *aovs = renderer_film(r)->aovs;
    assert_int_equal(aovs[H / 2 * W + W / 2].hits, 1);
    assert_int_equal(aovs[H / 2 * W + W / 2].object, 1);
    assert_int_equal(aovs[0].hits, 0);
    assert_int_equal(aovs[H * W - 1].hits, 0);
    renderer_free(r);
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_do_not_depend_on_threads),
        cmocka_unit_test(seeds_give_other_bytes),
        cmocka_unit_test(stopped_runs_go_on_to_the_same_bytes),
        cmocka_unit_test(a_stop_before_the_start_leaves_black),
        cmocka_unit_test(ranges_join_to_the_same_bytes),
        cmocka_unit_test(constant_light_is_exact),
        cmocka_unit_test(bad_samples_are_counted_and_black),
        cmocka_unit_test(progress_and_figures_add_up),
        cmocka_unit_test(options_go_before_the_scene),
        cmocka_unit_test(defaults_are_the_tables),
        cmocka_unit_test(the_schema_is_sound),
        cmocka_unit_test(impossible_pictures_are_refused),
        cmocka_unit_test(want_of_memory_is_told),
        cmocka_unit_test(cameras_are_chosen),
        cmocka_unit_test(a_scene_without_camera_is_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
