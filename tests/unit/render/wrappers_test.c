// two_sided, mask, normal_map, bump_map: materials made of others.
#include "bsdf_check.h"
#include "render/material_report.h"

static Bench bench;

static int setup(void **state)
{
    (void)state;
    bench_init(&bench);
    return 0;
}
static int teardown(void **state)
{
    (void)state;
    bench_free(&bench);
    return 0;
}

// Seen as the renderer would: with the frame that shading_point makes.
static ShadingPoint seen_from(Vec3 wo)
{
    ShadingPoint point;
    bench.surface.front = dot(wo, bench.surface.geometric) > 0;
    shading_point(&bench.world, &bench.surface, neg(wo), &point);
    return point;
}

static void sides(void **state)
{
    (void)state;
    bench_material(&bench, "emissive", "radiance=1,2,3");
    bench_material(&bench, "burley", "color=0.7");
    bench_material(&bench, "emissive", "radiance=5 base=#1");
    uint32_t sheet = bench_material(&bench, "two_sided", "front=#0 back=#2");
    uint32_t same = bench_material(&bench, "two_sided", "front=#2");
    assert_int_equal(material_lobes(&bench.world, sheet), LOBE_EMIT | LOBE_REFLECT | LOBE_SMOOTH);
    // What the back emits shines backwards.
    bench.surface.front = true;
    assert_true(material_emitted(&bench.world, sheet, &bench.surface).b == 3);
    assert_true(material_emitted(&bench.world, same, &bench.surface).b == 5);
    bench.surface.front = false;
    assert_true(material_emitted(&bench.world, sheet, &bench.surface).b == 5);
    assert_true(material_emitted(&bench.world, same, &bench.surface).b == 5);
    assert_true(material_emitted_mean(&bench.world, sheet).b == 8);
    // Only the back reflects.
    Vec3 wo = direction(30, 0), wi = direction(50, 100);
    ShadingPoint point = bench_point(&bench, wo);
    assert_true(rgb_is_black(material_eval(&point, sheet, wi).value));
    assert_true(material_eval(&point, same, wi).value.g > 0);
    wo.z = -wo.z, wi.z = -wi.z;
    point = bench_point(&bench, wo);
    assert_true(near_relative((double)material_eval(&point, sheet, wi).value.g,
                              (double)material_eval(&point, 1, wi).value.g, 1e-6));
    check_chi2(&bench, "two_sided", sheet, 100000, true, 4);
    check_weights(&bench, "two_sided", sheet, 10000);
    // Glass can't be a side, not even within others.
    bench_material(&bench, "fresnel", "");
    bench_material(&bench, "mix", "a=#1 b=#5");
    assert_int_equal(bench_material(&bench, "two_sided", "front=#6"), NONE_ID);
    assert_int_equal(bench.reported, E0952);
    assert_int_equal(bench_material(&bench, "two_sided", "front=#1 back=#5"), NONE_ID);
    assert_int_equal(bench.reported, E0952);
}

static void masks(void **state)
{
    (void)state;
    bench_material(&bench, "lambert", "color=0.8");
    bench_material(&bench, "mirror", "color=0.5");
    bench_material(&bench, "mix", "a=#0 b=#1 weight=0.25");
    uint32_t mask = bench_material(&bench, "mask", "opacity=0.3 base=#2");
    uint32_t twice = bench_material(&bench, "mask", "opacity=0.5 base=#3");
    assert_true(material_lobes(&bench.world, mask) ==
                (LOBE_PASS | LOBE_REFLECT | LOBE_SMOOTH | LOBE_DELTA));
    assert_near((double)material_pass(&bench.world, mask, &bench.surface).g, 0.7, 1e-6);
    assert_near((double)material_pass(&bench.world, twice, &bench.surface).g, 0.85, 1e-6);
    Vec3 wo = direction(40, 70), wi = direction(20, 200);
    ShadingPoint point = bench_point(&bench, wo);
    assert_near((double)material_eval(&point, mask, wi).value.g, 0.3 * 0.75 * 0.8 / PI * wi.z,
                1e-6);
    BsdfSample s;
    assert_true(material_sample(&point, mask, 0.5f, 0.1f, 0.2f, &s));
    assert_true((s.lobes & LOBE_PASS) && length(add(s.wi, wo)) == 0 && s.weight.g == 1);
    BsdfSample delta[DELTA_ROOM];
    assert_int_equal(material_deltas(&point, mask, delta, DELTA_ROOM), 1);
    assert_near((double)delta[0].weight.g, 0.3 * 0.25 * 0.5, 1e-6);
    check_chi2(&bench, "mask", mask, 200000, false, 4);
    check_chi2(&bench, "mask", mask, 200000, true, 4);
    check_weights(&bench, "mask", twice, 100000);
    check_reciprocity(&bench, "mask", twice, 1000000, 1, 1);
    // All that isn't absorbed is reflected or passes.
    double expected = 0.7 + 0.3 * (0.75 * 0.8 + 0.25 * 0.5);
    assert_near((double)albedo_by_sampling(&bench, mask, wo, 100000, NULL).g, expected, 2e-3);
    // A texture says where.
    uint32_t texture = bench_texture(&bench, "vertex_color", "");
    char text[64];
    snprintf(text, sizeof text, "opacity=#%u base=#0", texture);
    uint32_t textured = bench_material(&bench, "mask", text);
    bench.surface.color = rgb_gray(0);
    assert_true(material_pass(&bench.world, textured, &bench.surface).r == 1);
    assert_true(rgb_is_black(material_eval(&point, textured, wi).value));
    bench.surface.color = rgb_gray(1);
    assert_true(rgb_is_black(material_pass(&bench.world, textured, &bench.surface)));
}

// The color that stands for a normal.
static void normal_fields(char text[96], Vec3 n, uint32_t base, double strength)
{
    snprintf(text, 96, "base=#%u map=%.9g,%.9g,%.9g strength=%g", base, 0.5 + 0.5 * n.x,
             0.5 + 0.5 * n.y, 0.5 + 0.5 * n.z, strength);
}

// Lambert about a tilted normal; nothing where wi is behind the surface or behind that normal.
static void normals_tilt(void **state)
{
    (void)state;
    uint32_t lambert = bench_material(&bench, "lambert", "color=0.6");
    Vec3 n = normalize(vec3(0.4, -0.3, 0.8));
    char text[96];
    normal_fields(text, n, lambert, 1);
    uint32_t tilted = bench_material(&bench, "normal_map", text);
    normal_fields(text, n, lambert, 0);
    uint32_t flat = bench_material(&bench, "normal_map", text);
    Random random = {6};
    int lit = 0;
    for (int i = 0; i < 20000; ++i) {
        Vec3 wo = random_direction(&random), wi = random_direction(&random);
        ShadingPoint point = seen_from(wo);
        double value = (double)material_eval(&point, tilted, to_local(&point.frame, wi)).value.g;
        if (wo.z * wi.z < 0) {
            assert_true(value == 0); // no light leaks
            continue;
        }
        double side = wo.z > 0 ? 1 : -1;
        if (dot(wo, n) * side > 1e-2) { // else n is bent
            double expected = fmax(0, dot(wi, n) * side) * 0.6 / PI;
            assert_near(value, expected, 1e-6);
            lit += expected > 0;
        }
        assert_true(value >= 0 && value <= 0.6 / PI + 1e-6);
        double plain = (double)material_eval(&point, flat, to_local(&point.frame, wi)).value.g;
        assert_near(plain, 0.6 / PI * fabs(wi.z), 1e-6);
    }
    assert_true(lit > 4000);
    // Turned and mirrored texture coordinates turn the tilt.
    bench.surface.tangent = vec3(0, 2, 0);
    bench.surface.bitangent = vec3(3, 0, 0);
    ShadingPoint point = seen_from(vec3(0, 0, 1));
    Vec3 expected = normalize(vec3(n.y, n.x, n.z));
    double value = (double)material_eval(&point, tilted, to_local(&point.frame, expected)).value.g;
    assert_near(value, 0.6 / PI, 1e-6);
    bench.surface.tangent = vec3(1, 0, 0);
    bench.surface.bitangent = vec3(0, 1, 0);
}

static void normal_maps_are_consistent(void **state)
{
    (void)state;
    uint32_t ggx = bench_material(&bench, "ggx", "f0=1 alpha=0.3");
    uint32_t mirror = bench_material(&bench, "mirror", "");
    uint32_t glass = bench_material(&bench, "fresnel", "alpha=0.3");
    char text[96];
    normal_fields(text, normalize(vec3(0.5, 0.2, 1)), ggx, 1.5);
    uint32_t tilted = bench_material(&bench, "normal_map", text);
    check_chi2(&bench, "normal_map", tilted, 200000, false, 4);
    check_weights(&bench, "normal_map", tilted, 100000);
    check_energy(&bench, "normal_map", tilted, 0, 4000);
    normal_fields(text, normalize(vec3(0.2, 0.1, 1)), glass, 1);
    uint32_t wavy = bench_material(&bench, "normal_map", text);
    check_weights(&bench, "wavy glass", wavy, 100000);
    check_energy(&bench, "wavy glass", wavy, 0, 4000);
    Medium medium;
    assert_true(material_medium(&bench.world, wavy, &medium) && medium.ior == 1.5);
    // A tilted mirror reflects about the tilted normal.
    Vec3 n = normalize(vec3(0.1, 0.2, 1)), wo = direction(20, 30);
    normal_fields(text, n, mirror, 1);
    uint32_t turned = bench_material(&bench, "normal_map", text);
    ShadingPoint point = seen_from(wo);
    BsdfSample s;
    assert_true(material_sample(&point, turned, 0, 0, 0, &s));
    Vec3 expected = sub(scale(n, 2 * dot(wo, n)), wo);
    assert_near(length(sub(from_local(&point.frame, s.wi), expected)), 0, 1e-6);
    assert_int_equal(material_deltas(&point, turned, &s, 1), 1);
    assert_near(length(sub(from_local(&point.frame, s.wi), expected)), 0, 1e-6);
}

// A step of the height by 1/100 m at an edge of a checker has the slope that the differences see;
// elsewhere nothing changes.
static void bumps_have_slopes(void **state)
{
    (void)state;
    uint32_t lambert = bench_material(&bench, "lambert", "color=1");
    uint32_t steps = bench_texture(&bench, "checker", "a=0 b=1 scale=4");
    char text[64];
    snprintf(text, sizeof text, "base=#%u map=#%u strength=0.01", lambert, steps);
    uint32_t bumpy = bench_material(&bench, "bump_map", text);
    bench.surface.tangent = vec3(0, 2, 0); // u runs along y, 2 m; v along -x, 5 m
    bench.surface.bitangent = vec3(-5, 0, 0);
    double rise = 0.01 / (2.0 / 2048);
    static const struct {
        Vec2 uv;
        double u, v; // slopes in parts of `rise`
    } PLACES[] = {{{0.25, 0.1}, 1, 0}, {{0.5, 0.1}, -1, 0}, {{0.3, 0.25}, 0, -1},
                  {{0.1, 0.75}, 0, 1}, {{0.1, 0.1}, 0, 0},  {{0.26, 0.74}, 0, 0}};
    for (size_t i = 0; i < TEST_COUNT(PLACES); ++i) {
        bench.surface.uv = PLACES[i].uv;
        ShadingPoint point = seen_from(vec3(0, 0, 1));
        // Height grows by rise per unit of u, that is rise/2 per metre of y.
        Vec3 n = normalize(vec3(PLACES[i].v * rise / 5, -PLACES[i].u * rise / 2, 1));
        double value = (double)material_eval(&point, bumpy, to_local(&point.frame, n)).value.g;
        assert_near(value, 1 / PI, 1e-6);
        Vec3 up = vec3(0, 0, 1);
        value = (double)material_eval(&point, bumpy, to_local(&point.frame, up)).value.g;
        assert_near(value, n.z / PI, 1e-6);
    }
}

static void photos_of_normals_are_noted(void **state)
{
    (void)state;
    bench_material(&bench, "lambert", "");
    assert_int_not_equal(bench_material(&bench, "normal_map", "base=#0 map=0.5,0.5,1"), NONE_ID);
    assert_int_equal(bench.reports, 0);
    static const struct {
        const char *fields;
        bool noted;
    } MAPS[] = {{"file=n.png", true},
                {"file=n.png encoding=linear", false},
                {"file=n.exr", false},
                {"file=n", true}};
    for (uint32_t i = 0; i < TEST_COUNT(MAPS); ++i) {
        int type; // the files aren't read: no texture set is built
        void *params = bench_params(&bench, "image", MAPS[i].fields, &type);
        assert_int_equal(scene_add_node(&bench.scene, (uint16_t)type, params, (SceneNode){0}), i);
        char text[64];
        snprintf(text, sizeof text, "base=#0 map=#%u", i);
        assert_int_not_equal(bench_material(&bench, "normal_map", text), NONE_ID);
        assert_int_equal(bench.reports, MAPS[i].noted);
        assert_true(!MAPS[i].noted || bench.reported == W0951);
    }
}

static void put_shape(const char *kind, uint32_t material)
{
    int type = schema_find(render_schema(), str_from(kind));
    void *params = arena_alloc_zeroed(&bench.arena, render_schema()->types[type]->size + 1);
    scene_add_node(&bench.scene, (uint16_t)type, params, (SceneNode){.material = material});
}

// Glass on what encloses nothing is reported.
static void open_glass_is_noted(void **state)
{
    (void)state;
    uint32_t white = bench_material(&bench, "lambert", "");
    uint32_t glass = bench_material(&bench, "fresnel", "");
    uint32_t inner = bench_material(&bench, "mix", "a=#0 b=#1");
    put_shape("sphere", glass);
    put_shape("plane", glass);
    put_shape("rectangle", white);
    put_shape("disc", NONE_ID);
    material_warn_open_glass(&bench.scene, &bench.sink);
    assert_int_equal(bench.sink.count, 0);
    put_shape("rectangle", inner);
    put_shape("cylinder", glass); // without caps
    material_warn_open_glass(&bench.scene, &bench.sink);
    assert_true(bench.sink.warnings >= 1 && bench.sink.items[0].code == W0950);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(sides, setup, teardown),
        cmocka_unit_test_setup_teardown(masks, setup, teardown),
        cmocka_unit_test_setup_teardown(normals_tilt, setup, teardown),
        cmocka_unit_test_setup_teardown(normal_maps_are_consistent, setup, teardown),
        cmocka_unit_test_setup_teardown(bumps_have_slopes, setup, teardown),
        cmocka_unit_test_setup_teardown(open_glass_is_noted, setup, teardown),
        cmocka_unit_test_setup_teardown(photos_of_normals_are_noted, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
