// Paths that are guided to light by way of glass: densities, and the mean.
#include "../test_support.h"

#include "../../render/scene_maker.h"
#include "base/hash.h"
#include "render/integrator.h"
#include "render/world.h"

extern const IntegratorClass path_integrator;

// A glass ball over a floor, under a lamp of `half` the width of the ball.
static World *ball(SceneMaker *m, double half)
{
    PUT(m, "render", {"caustics", {0}, "guided"});
    const uint32_t matt = PUT(m, "lambert", {"color", {0.5}});
    const uint32_t glass = PUT(m, "fresnel", {"ior", {1.5}});
    const uint32_t lamp = PUT(m, "emissive", {"radiance", {10}});
    PUT(m, "plane", {"material", {matt}});
    PUT(m, "sphere", {"center", {0, 1.02, 0}}, {"material", {glass}});
    PUT(m, "rectangle", {"corner", {-half, 4, -half}}, {"u", {2 * half, 0, 0}},
        {"v", {0, 0, 2 * half}}, {"material", {lamp}});
    World *world = world_build(&m->scene, 1, &m->sink);
    assert_non_null(world);
    return world;
}

static float number(uint32_t i, uint32_t dimension)
{
    return hash_to_float(hash_combine(hash_u32(i), dimension));
}

// Half of the directions by the cell, half from all around, both weighted by the density of either:
// the mean of 1 / density is 4π, and that of the cell's part 1. Off by what the cell's density
// isn't that of its samples.
static void density_is_of_the_samples(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    World *world = ball(&maker, 0.2);
    assert_non_null(world->guide);
    enum { COUNT = 200000 };
    const Vec3 points[] = {{0.01, 0, 0.02}, {0.4, 0, -0.3}, {2, 0, 1}};
    for (size_t k = 0; k < TEST_COUNT(points); ++k) {
        const GuideCell *cell = guide_find(world->guide, points[k]);
        assert_non_null(cell);
        double sphere = 0, whole = 0;
        for (uint32_t i = 0; i < COUNT; ++i) {
            const float u = number(i, 1), v = number(i, 2);
            Vec3 w;
            if (i % 2) {
                w = guide_sample(cell, points[k], number(i, 3), u, v);
            } else {
                const double z = 2 * (double)u - 1, r = sqrt(1 - z * z), phi = 2 * PI * (double)v;
                w = vec3(r * cos(phi), r * sin(phi), z);
            }
            assert_true(fabs(length(w) - 1) < 1e-12);
            const double pdf = (double)guide_pdf(cell, points[k], w);
            const double both = 0.5 * pdf + 0.5 / (4 * PI);
            sphere += 1 / both / COUNT;
            whole += pdf / both / COUNT;
        }
        // Standard errors are below 4π / √COUNT and 1 / √COUNT.
        assert_true(fabs(sphere - 4 * PI) < 5 * 4 * PI / sqrt(COUNT));
        assert_true(fabs(whole - 1) < 5 / sqrt(COUNT));
    }
    world_free(world);
    maker_free(&maker);
}

// The mean radiance from a point of the floor, and the squared standard error.
static double mean(const World *world, Vec3 to, uint32_t samples, double *error2)
{
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < samples; ++i) {
        Sampler sampler;
        IntegratorStats stats = {0};
        sampler_start(&sampler, 1, i, 0, 0); // each a pixel of its own: independent
        const Vec3 from = vec3(0, 0.2, 8);
        const Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
        const double l =
            (double)luminance(path_integrator.radiance(world, &ray, &sampler, NULL, &stats));
        sum += l;
        squares += l * l;
    }
    *error2 = (squares / samples - sum / samples * sum / samples) / samples;
    return sum / samples;
}

// The mean is that without a guide; biases of some per cent would be found in the caustic, and of
// 4 % beside it, where the noise is a third.
static void the_mean_stays(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    World *world = ball(&maker, 0.2);
    assert_non_null(world->guide);
    const Guide *guide = world->guide;
    const Vec3 points[] = {{0.15, 0, 0.1}, {0.3, 0, 0.2}, {0.6, 0, -0.3}, {1.5, 0, 1}};
    for (size_t k = 0; k < TEST_COUNT(points); ++k) {
        double error2, plain_error2;
        world->guide = guide;
        const double guided = mean(world, points[k], 100000, &error2);
        world->guide = NULL;
        const double plain = mean(world, points[k], 200000, &plain_error2);
        printf("guided %g ± %g, plain %g ± %g\n", guided, sqrt(error2), plain, sqrt(plain_error2));
        assert_true(fabs(guided - plain) < 4 * sqrt(error2 + plain_error2));
        assert_true(error2 < plain_error2 * 2);
    }
    world_free(world);
    maker_free(&maker);
}

// Without mirrors, or lamps that rays can find, there is nothing to know.
static void nothing_where_there_is_none(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    PUT(&maker, "render", {"caustics", {0}, "guided"});
    const uint32_t glass = PUT(&maker, "fresnel", {"ior", {1.5}});
    PUT_DEFAULT(&maker, "plane");
    PUT(&maker, "sphere", {"center", {0, 1.5, 0}}, {"material", {glass}});
    PUT(&maker, "point_light", {"position", {0, 4, 0}});
    World *world = world_build(&maker.scene, 1, &maker.sink);
    assert_non_null(world);
    assert_null(world->guide);
    world_free(world);
    maker_free(&maker);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(density_is_of_the_samples),
        cmocka_unit_test(the_mean_stays),
        cmocka_unit_test(nothing_where_there_is_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
