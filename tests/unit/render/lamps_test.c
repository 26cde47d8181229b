// Edges of lamps: which pixels are marked, and that the pictures' means stay what they are.
#include "../test_support.h"

#include "../../render/scene_maker.h"
#include "base/hash.h"
#include "base/mem.h"
#include "render/lamps.h"

extern const IntegratorClass path_integrator;

enum { WIDTH = 32, HEIGHT = 24 };

// What lamps may be seen by: themselves, cut-outs, glass that absorbs and glass that the camera
// looks through; one smaller than a pixel, one cut by the picture's rim, one behind a pillar.
static void put_scene(SceneMaker *m, const char *filter, double aperture)
{
    PUT(m, "film", {"width", {WIDTH}}, {"height", {HEIGHT}}, {"filter", {0}, filter});
    PUT(m, "render", {"samples", {16}}, {"bounces", {3}});
    PUT(m, "camera", {"position", {0, 1, 6}}, {"look_at", {0, 1, 0}}, {"fov", {0.6}},
        {"aperture", {aperture}});
    const uint32_t matt = PUT(m, "lambert", {"color", {0.5}});
    const uint32_t lamp = PUT(m, "emissive", {"radiance", {20}});
    const uint32_t half = PUT(m, "mask", {"base", {lamp}}, {"opacity", {0.5}});
    const uint32_t glass = PUT(m, "fresnel", {"ior", {1.5}}, {"absorption", {1, 2, 3}});
    PUT(m, "environment_light", {"radiance", {0.3}});
    PUT(m, "plane", {"material", {matt}});
    PUT(m, "sphere", {"center", {-1, 1, 0}}, {"radius", {0.3}}, {"material", {lamp}});
    PUT(m, "sphere", {"center", {0.9, 0.8, 0}}, {"radius", {0.03}}, {"material", {lamp}});
    PUT(m, "sphere", {"center", {0.2, 0.5, 0}}, {"radius", {0.3}}, {"material", {glass}});
    PUT(m, "sphere", {"center", {0.2, 0.9, -2}}, {"radius", {0.2}}, {"material", {lamp}});
    PUT(m, "rectangle", {"corner", {0.3, 1.3, 0}}, {"u", {0.7, 0, 0}}, {"v", {0.1, 0.4, 0}},
        {"material", {half}});
    PUT(m, "rectangle", {"corner", {-0.5, 1.8, 0}}, {"u", {1, 0, 0}}, {"v", {0, 2, 0}},
        {"material", {lamp}});
    PUT(m, "box", {"min", {-1.1, 0, 1}}, {"max", {-0.9, 1.1, 1.2}}, {"material", {matt}});
}

// Sums over pixels of a picture's luminance, and of each pixel's square.
typedef struct Sums {
    double mean[WIDTH * HEIGHT], square[WIDTH * HEIGHT];
} Sums;

static void add_picture(SceneMaker *m, const IntegratorClass *integrator, int64_t seed, Sums *sums)
{
    const RenderOptions options = {.threads = 1, .seed = seed, .integrator = integrator};
    Renderer *r = renderer_new(&m->scene, &options, &m->sink);
    assert_non_null(r);
    RenderStats stats;
    assert_true(renderer_run(r, &stats));
    assert_int_equal(stats.bad_samples, 0);
    for (int p = 0; p < WIDTH * HEIGHT; ++p) {
        const double l = film_luminance(&renderer_film(r)->pixels[p]);
        sums->mean[p] += l;
        sums->square[p] += l * l;
    }
    renderer_free(r);
}

// The picture's mean and its squared standard error, of `count` independent pictures.
static double mean_of(const Sums *sums, int count, double *error2)
{
    double mean = 0;
    *error2 = 0;
    for (int p = 0; p < WIDTH * HEIGHT; ++p) {
        const double m = sums->mean[p] / count;
        mean += m / (WIDTH * HEIGHT);
        *error2 += (sums->square[p] / count - m * m) / (count - 1);
    }
    *error2 /= (double)(WIDTH * HEIGHT) * (WIDTH * HEIGHT);
    return mean;
}

// Rays of their own to the edges of lamps leave each picture's mean where it was (family of three,
// |z| < 4: 2e-4 of false alarms), and take most of its error away.
static void the_mean_stays(void **state)
{
    (void)state;
    enum { PICTURES = 48 };
    const struct {
        const char *filter;
        double aperture;
    } views[] = {{"box", 0}, {"blackman_harris", 0}, {"box", 0.2}};
    IntegratorClass whole = path_integrator;
    whole.lamps = NULL;
    for (size_t k = 0; k < TEST_COUNT(views); ++k) {
        SceneMaker maker;
        maker_init(&maker);
        put_scene(&maker, views[k].filter, views[k].aperture);
        Sums apart = {0}, together = {0};
        for (int i = 0; i < PICTURES; ++i) {
            add_picture(&maker, &path_integrator, 100 + i, &apart);
            add_picture(&maker, &whole, 1000 + i, &together);
        }
        double error2, whole_error2;
        const double mean = mean_of(&apart, PICTURES, &error2);
        const double plain = mean_of(&together, PICTURES, &whole_error2);
        const double error = sqrt(error2 + whole_error2);
        printf("%s: apart %g ± %g, together %g ± %g; a bias of %.2f %% would be found\n",
               views[k].filter, mean, sqrt(error2), plain, sqrt(whole_error2),
               100 * 4 * error / plain);
        assert_true(fabs(mean - plain) < 4 * error);
        assert_true(error2 < whole_error2 / 3);
        maker_free(&maker);
    }
}

// Behind lamps that fill the picture, and without lamps, there is nothing to gain.
static void nothing_where_no_edge_is(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    PUT(&maker, "film", {"width", {WIDTH}}, {"height", {HEIGHT}});
    PUT(&maker, "render", {"samples", {4}}, {"bounces", {0}});
    PUT(&maker, "camera", {"position", {0, 0, 6}}, {"look_at", {0, 0, 0}});
    PUT(&maker, "point_light", {"position", {0, 4, 0}});
    const uint32_t lamp = PUT(&maker, "emissive", {"radiance", {20}});
    World *world = world_build(&maker.scene, 1, &maker.sink);
    assert_non_null(world);
    Camera camera;
    camera_prepare(&camera, &maker.scene, 0, WIDTH, HEIGHT);
    uint8_t *marks;
    assert_true(lamp_marks(world, &camera, WIDTH, HEIGHT, 0.5, &marks));
    assert_null(marks);
    world_free(world);
    PUT(&maker, "rectangle", {"corner", {-9, -9, 0}}, {"u", {18, 0, 0}}, {"v", {0, 18, 0}},
        {"material", {lamp}});
    Renderer *r =
        renderer_new(&maker.scene, &(RenderOptions){.threads = 1, .seed = -1}, &maker.sink);
    RenderStats stats;
    assert_non_null(r);
    assert_true(renderer_run(r, &stats));
    // The trials, once each, and a path for each sample.
    assert_int_equal(stats.rays, WIDTH * HEIGHT * (16 + 4));
    renderer_free(r);
    maker_free(&maker);
}

// What is marked is where the box is seen: points of random boxes, by rays through all of the lens.
static void boxes_are_where_they_are_seen(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 4000; ++i) {
        float n[16];
        for (uint32_t k = 0; k < 16; ++k) {
            n[k] = hash_to_float(hash_combine(hash_u32(i), k));
        }
        CameraParams params = {
            .position = {1, 2, 3}, .fov = 0.3 + (double)n[0], .height = 2, .focus_distance = 4};
        params.projection = i % 2 ? CAMERA_PERSPECTIVE : CAMERA_ORTHOGRAPHIC;
        params.aperture = i % 3 ? (double)n[1] : 0;
        assert_true(affine_look_at(params.position, vec3((double)n[2], (double)n[3], 0),
                                   vec3(0, 1, 0), &params.frame));
        const Affine stretch = affine_scaling(vec3(1, 1, 0.5 + (double)n[4]));
        Camera camera;
        camera_setup(&camera, &params, &stretch, 40, 30);
        // A point that a ray meets, in a box.
        const double x = 2 * (double)n[5] - 0.5, y = 2 * (double)n[6] - 0.5;
        Ray ray;
        assert_true(camera_ray(&camera, x, y, n[7], n[8], &ray));
        const Vec3 p = add_scaled(ray.origin, ray.direction, 1 + 6 * (double)n[9]);
        const Box3 box = {sub(p, vec3((double)n[10], (double)n[11], (double)n[12])),
                          add(p, vec3((double)n[13], (double)n[14], (double)n[15]))};
        FilmBox seen;
        if (camera_film_box(&camera, box, &seen)) {
            assert_true(seen.x0 <= x + 1e-9 && x <= seen.x1 + 1e-9);
            assert_true(seen.y0 <= y + 1e-9 && y <= seen.y1 + 1e-9);
        }
        // A point's box is a point to a pinhole.
        if (params.aperture <= 0) {
            assert_true(camera_film_box(&camera, (Box3){p, p}, &seen));
            assert_true(fabs(seen.x0 - x) + fabs(seen.x1 - x) < 1e-9);
            assert_true(fabs(seen.y0 - y) + fabs(seen.y1 - y) < 1e-9);
        }
    }
    Camera camera;
    CameraParams params = {.fov = 1, .projection = CAMERA_FISHEYE};
    const Affine identity = affine_identity();
    params.frame = identity;
    camera_setup(&camera, &params, &identity, 40, 30);
    FilmBox seen;
    const Box3 before = {{-1, -1, -3}, {1, 1, -2}}, about = {{-1, -1, -3}, {1, 1, 2}};
    assert_false(camera_film_box(&camera, before, &seen));
    params.projection = CAMERA_PERSPECTIVE;
    camera_setup(&camera, &params, &identity, 40, 30);
    assert_true(camera_film_box(&camera, before, &seen));
    assert_false(camera_film_box(&camera, about, &seen));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_mean_stays),
        cmocka_unit_test(nothing_where_no_edge_is),
        cmocka_unit_test(boxes_are_where_they_are_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
