#include "../test_support.h"

#include "../../render/scene_maker.h"
#include "../../render/statistics.h"
#include "base/noise.h"
#include "render/texture.h"
#include "render/texture_image.h"

// 3 × 2 texels whose red counts 0 to 5 from the top left.
static Rgb texels[6];
static TextureImage image = {.width = 3, .height = 2, .texels = texels};

static int set_up(void **state)
{
    (void)state;
    for (int i = 0; i < 6; ++i) {
        texels[i] = rgb((float)i, 1, 0);
    }
    return 0;
}

static double look(double u, double v, TextureFilter filter, TextureWrap wrap)
{
    return (double)texture_image_look_up(&image, u, v, filter, wrap, wrap).r;
}

static void texels_lie_at_their_centres(void **state)
{
    (void)state;
    for (int y = 0; y < 2; ++y) {
        for (int x = 0; x < 3; ++x) {
            double u = (x + 0.5) / 3, v = 1 - (y + 0.5) / 2;
            for (TextureWrap wrap = WRAP_REPEAT; wrap <= WRAP_BLACK; ++wrap) {
                assert_true(NEAR(look(u, v, FILTER_NEAREST, wrap), 3 * y + x, 0));
                assert_true(NEAR(look(u, v, FILTER_BILINEAR, wrap), 3 * y + x, 1e-6));
            }
        }
    }
    // Half way between four texels: their mean.
    assert_true(NEAR(look(1.0 / 3, 0.5, FILTER_BILINEAR, WRAP_CLAMP), 2, 1e-6));
}

static void outside_follows_the_wrap(void **state)
{
    (void)state;
    for (double u = -2.9; u < 3; u += 0.17) {
        for (double v = -2.9; v < 3; v += 0.19) {
            for (TextureFilter f = FILTER_BILINEAR; f <= FILTER_NEAREST; ++f) {
                double repeated = look(u - floor(u), v - floor(v), f, WRAP_REPEAT);
                assert_true(NEAR(look(u, v, f, WRAP_REPEAT), repeated, 1e-5));
                double mu = fabs(u - 2 * floor(u / 2 + 0.5)), mv = fabs(v - 2 * floor(v / 2 + 0.5));
                assert_true(NEAR(look(u, v, f, WRAP_MIRROR), look(mu, mv, f, WRAP_MIRROR), 1e-5));
                double cu = fmin(fmax(u, 0), 1), cv = fmin(fmax(v, 0), 1);
                assert_true(NEAR(look(u, v, f, WRAP_CLAMP), look(cu, cv, f, WRAP_CLAMP), 1e-5));
            }
            bool outside = u < 0 || u >= 1 || v <= 0 || v > 1;
            Rgb black = texture_image_look_up(&image, u, v, FILTER_NEAREST, WRAP_BLACK, WRAP_BLACK);
            assert_true((black.g == 0) == outside);
        }
    }
}

static void wild_coordinates_are_safe(void **state)
{
    (void)state;
    const double wild[] = {INFINITY, -INFINITY, NAN, 1e300, -1e300, 1e18, -1e18, 1e-320};
    for (size_t i = 0; i < TEST_COUNT(wild); ++i) {
        for (size_t k = 0; k < TEST_COUNT(wild); ++k) {
            for (TextureWrap wrap = WRAP_REPEAT; wrap <= WRAP_BLACK; ++wrap) {
                assert_true(isfinite(look(wild[i], wild[k], FILTER_BILINEAR, wrap)));
                assert_true(isfinite(look(wild[i], wild[k], FILTER_NEAREST, wrap)));
            }
        }
    }
}

static void srgb_curve(void **state)
{
    (void)state;
    assert_true(NEAR(srgb_decode(0), 0, 0) && NEAR(srgb_decode(1), 1, 1e-6));
    assert_true(NEAR(srgb_decode(0.5f), 0.21404114, 1e-6));
    assert_true(NEAR(srgb_decode(0.04045f), 0.04045 / 12.92, 1e-8));
    assert_true(NEAR(srgb_decode(200 / 255.0f), 0.57758044, 1e-6));
}

typedef struct Lab {
    SceneMaker maker;
    TextureSet *set;
} Lab;

static Rgb at_uv(const Lab *lab, uint32_t id, double u, double v)
{
    Surface surface = {.uv = {u, v}, .color = {0.25f, 0.5f, 0.75f}};
    return texture_color(lab->set, id, &surface);
}

static void checker_alternates(void **state)
{
    (void)state;
    Lab lab;
    maker_init(&lab.maker);
    uint32_t uv = PUT(&lab.maker, "checker", {"a", {1}}, {"b", {0.5}}, {"scale", {4, 2, 0}});
    uint32_t space = PUT(&lab.maker, "checker", {"a", {1}}, {"b", {0.5}}, {"scale", {2}},
                         {"space", .text = "object"});
    uint32_t nested = PUT(&lab.maker, "checker", {"a", {uv}, .texture = true}, {"b", {3}});
    lab.set = texture_set_build(&lab.maker.scene, &lab.maker.sink);
    assert_non_null(lab.set);
    for (int i = -8; i < 8; ++i) {
        for (int k = -8; k < 8; ++k) {
            double expected = (i + k) % 2 == 0 ? 1 : 0.5;
            assert_true(NEAR(at_uv(&lab, uv, (i + 0.5) / 4, (k + 0.5) / 2).r, expected, 0));
            // A flat face on a boundary has one colour although its points are rounded.
            Surface up = {.object_p = {(i + 0.5) / 2, 1e-12, (k + 0.5) / 2}}, down = up;
            down.object_p.y = -1e-12;
            assert_true(NEAR(texture_color(lab.set, space, &up).r, expected, 0));
            assert_true(NEAR(texture_color(lab.set, space, &down).r, expected, 0));
        }
    }
    assert_true(NEAR(at_uv(&lab, nested, 0.3, 0.2).r, 0.5, 0));
    assert_true(NEAR(at_uv(&lab, nested, 1.3, 0.2).r, 3, 0));
    assert_true(NEAR(texture_mean(lab.set, nested).r, 0.5 * (0.75 + 3), 1e-6));
    texture_set_free(lab.set);
    maker_free(&lab.maker);
}

static void arithmetic_is_by_component(void **state)
{
    (void)state;
    static const char *const OPS[] = {"add", "subtract", "multiply", "divide"};
    const double expected[] = {2.25, -1.75, 0.5, 0.125};
    Lab lab;
    maker_init(&lab.maker);
    uint32_t vertex = PUT_DEFAULT(&lab.maker, "vertex_color"), results[4];
    for (int i = 0; i < 4; ++i) {
        results[i] = PUT(&lab.maker, "texture_math", {"op", .text = OPS[i]},
                         {"a", {vertex}, .texture = true}, {"b", {2, 4, 0}});
    }
    lab.set = texture_set_build(&lab.maker.scene, &lab.maker.sink);
    assert_non_null(lab.set);
    for (int i = 0; i < 4; ++i) {
        assert_true(NEAR(at_uv(&lab, results[i], 0, 0).r, expected[i], 1e-6));
    }
    assert_true(at_uv(&lab, results[3], 0, 0).b == 0); // divided by zero
    // A number is the luminance of the color.
    NumberTex number = {2, vertex};
    Surface surface = {.color = {0.25f, 0.5f, 0.75f}};
    assert_true(NEAR(number_tex(lab.set, &number, &surface),
                     2 * (0.2126 * 0.25 + 0.7152 * 0.5 + 0.0722 * 0.75), 1e-6));
    ColorTex color = {{3, 1, -1}, vertex};
    Rgb held = reflectance_tex(lab.set, &color, &surface);
    assert_true(held.r == 0.75f && held.g == 0.5f && held.b == 0);
    texture_set_free(lab.set);
    maker_free(&lab.maker);
}

// Linear between the colors at their positions, along from → to; and by another texture's value.
static void gradients_run_between_colors(void **state)
{
    (void)state;
    static const Rgb COLORS[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const double PLACES[3] = {0, 0.25, 1};
    const MakerField colors = {"colors", .list = COLORS, .count = 3};
    const MakerField places = {"positions", .list = PLACES, .count = 3};
    Lab lab;
    maker_init(&lab.maker);
    uint32_t vertex = PUT_DEFAULT(&lab.maker, "vertex_color");
    uint32_t even = PUT(&lab.maker, "gradient", colors, {"from", {1, 0, 0}}, {"to", {3, 0, 0}});
    uint32_t placed = PUT(&lab.maker, "gradient", colors, places, {"space", .text = "world"},
                          {"wrap", .text = "repeat"});
    uint32_t round = PUT(&lab.maker, "gradient", colors, {"form", .text = "radial"},
                         {"to", {0, 0, 2}}, {"wrap", .text = "mirror"});
    uint32_t mapped = PUT(&lab.maker, "gradient", colors, {"value", {vertex}, .texture = true});
    lab.set = texture_set_build(&lab.maker.scene, &lab.maker.sink);
    assert_non_null(lab.set);
    for (int i = -20; i <= 40; ++i) {
        const double t = i / 20.0, held = fmin(fmax(t, 0), 1);
        Surface s = {.object_p = {1 + 2 * t, 5, -3}, .p = {7, t, 7}};
        Rgb c = texture_color(lab.set, even, &s);
        assert_true(NEAR(c.r, fmax(0, 1 - 2 * held), 1e-6));
        assert_true(NEAR(c.b, fmax(0, 2 * held - 1), 1e-6));
        assert_true(NEAR((double)c.r + (double)c.g + (double)c.b, 1, 1e-6));
        const double again = t - floor(t);
        c = texture_color(lab.set, placed, &s);
        assert_true(NEAR(c.r, fmax(0, 1 - 4 * again), 1e-6));
        assert_true(NEAR(c.b, fmax(0, (again - 0.25) / 0.75), 1e-6));
        const double way = fabs(t), back = way > 1 ? 2 - way : way;
        s.object_p = vec3(0, 2 * t, 0);
        c = texture_color(lab.set, round, &s);
        assert_true(NEAR(c.r, fmax(0, 1 - 2 * back), 1e-6));
        s.color = rgb_gray((float)t);
        c = texture_color(lab.set, mapped, &s);
        assert_true(NEAR(c.r, fmax(0, 1 - 2 * held), 1e-6));
    }
    const Rgb middle = texture_mean(lab.set, even); // of 16 samples
    assert_true(NEAR(middle.r, 0.25, 0.01) && NEAR(middle.g, 0.5, 0.01));
    texture_set_free(lab.set);
    maker_free(&lab.maker);
}

// t = (1 + Σ gain^i n(lacunarity^i scale p)/Σ gain^i)/2, within [0, 1], without jumps, the mean at
// the middle of the two colors.
static void noise_is_smooth(void **state)
{
    (void)state;
    Lab lab;
    maker_init(&lab.maker);
    uint32_t one = PUT(&lab.maker, "noise", {"scale", {2}});
    uint32_t many =
        PUT(&lab.maker, "noise", {"scale", {2}}, {"octaves", {5}}, {"a", {2}}, {"b", {6}});
    uint32_t folded = PUT(&lab.maker, "noise", {"style", .text = "turbulent"}, {"octaves", {3}});
    lab.set = texture_set_build(&lab.maker.scene, &lab.maker.sink);
    assert_non_null(lab.set);
    double sums[3] = {0};
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
        const double x = i * 0.0137;
        Surface s = {.object_p = {x, 0.7 * x, -0.3 * x}}, near = s;
        near.object_p.x += 1e-4;
        const double values[3] = {(double)texture_color(lab.set, one, &s).r,
                                  (double)texture_color(lab.set, many, &s).r,
                                  (double)texture_color(lab.set, folded, &s).r};
        assert_true(NEAR(values[0], 0.5 + 0.5 * noise3(scale(s.object_p, 2)), 1e-6));
        assert_true(NEAR(texture_color(lab.set, many, &near).r, values[1], 0.02));
        assert_true(values[1] >= 2 && values[1] <= 6 && values[2] >= 0 && values[2] <= 1);
        for (int k = 0; k < 3; ++k) {
            sums[k] += values[k] / n;
        }
    }
    assert_true(NEAR(sums[0], texture_mean(lab.set, one).r, 0.01));
    assert_true(NEAR(sums[1], texture_mean(lab.set, many).r, 0.04));
    assert_true(NEAR(sums[2], texture_mean(lab.set, folded).r, 0.03));
    texture_set_free(lab.set);
    maker_free(&lab.maker);
}

static void missing_picture_is_reported_once(void **state)
{
    (void)state;
    Lab lab;
    maker_init(&lab.maker);
    PUT(&lab.maker, "image", {"file", .text = "/nowhere/at/all.png"});
    PUT(&lab.maker, "image", {"file", .text = SCN_SOURCE_DIR "/LICENSE"});
    assert_null(texture_set_build(&lab.maker.scene, &lab.maker.sink));
    assert_true(lab.maker.sink.errors >= 1);
    for (uint32_t i = 0; i < lab.maker.sink.count; ++i) {
        assert_int_equal(lab.maker.sink.items[i].code, E0940);
    }
    maker_free(&lab.maker);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texels_lie_at_their_centres),
        cmocka_unit_test(outside_follows_the_wrap),
        cmocka_unit_test(wild_coordinates_are_safe),
        cmocka_unit_test(srgb_curve),
        cmocka_unit_test(checker_alternates),
        cmocka_unit_test(arithmetic_is_by_component),
        cmocka_unit_test(gradients_run_between_colors),
        cmocka_unit_test(noise_is_smooth),
        cmocka_unit_test(missing_picture_is_reported_once),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
