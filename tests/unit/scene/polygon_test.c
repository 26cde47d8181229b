#include "../test_support.h"
#include "scene/polygon.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double polygon_area(const Vec3 *p, uint32_t count)
{
    Vec3 sum = vec3(0, 0, 0);
    for (uint32_t i = 1; i + 1 < count; ++i) {
        sum = add(sum, cross(sub(p[i], p[0]), sub(p[i + 1], p[0])));
    }
    return length(sum) / 2;
}

// The triangles of a simple polygon cover it once: all are wound alike, their areas add up to the
// polygon's, and every side of it belongs to one triangle.
static void check(const Vec3 *p, uint32_t count)
{
    PolygonScratch scratch = {0};
    uint32_t *triangles = malloc(3 * sizeof *triangles * count);
    assert_int_equal(polygon_triangulate(&scratch, p, count, triangles), POLYGON_OK);
    Vec3 normal = vec3(0, 0, 0);
    for (uint32_t i = 1; i + 1 < count; ++i) {
        normal = add(normal, cross(sub(p[i], p[0]), sub(p[i + 1], p[0])));
    }
    normal = normalize(normal);
    double area = 0;
    uint32_t sides = 0;
    for (uint32_t t = 0; t < count - 2; ++t) {
        const uint32_t *c = triangles + 3 * t;
        assert_true(c[0] < count && c[1] < count && c[2] < count);
        Vec3 n = cross(sub(p[c[1]], p[c[0]]), sub(p[c[2]], p[c[0]]));
        assert_true(dot(n, normal) >= -1e-12);
        area += length(n) / 2;
        for (int k = 0; k < 3; ++k) {
            sides += (c[k] + 1) % count == c[(k + 1) % 3];
        }
    }
    assert_int_equal(sides, count);
    assert_true(fabs(area - polygon_area(p, count)) <= 1e-9 * area);
    polygon_scratch_free(&scratch);
    free(triangles);
}

// In a plane that leans, so that no axis is special.
static void check_flat(const double (*xy)[2], uint32_t count)
{
    Vec3 p[64], back[64];
    Affine lean = affine_rotation(vec3(1, 2, -0.5), 1.1);
    for (uint32_t i = 0; i < count; ++i) {
        p[i] = transform_point(&lean, vec3(xy[i][0], xy[i][1], 0));
        back[count - 1 - i] = p[i];
    }
    check(p, count);
    check(back, count); // wound the other way
    for (uint32_t start = 1; start < count; ++start) {
        Vec3 turned[64];
        for (uint32_t i = 0; i < count; ++i) {
            turned[i] = p[(i + start) % count];
        }
        check(turned, count);
    }
}

static void convex_and_concave(void **state)
{
    (void)state;
    static const double square[][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const double dart[][2] = {{0, 0}, {2, -1}, {0, 3}, {-2, -1}};
    static const double l_shape[][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    static const double in_line[][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {0, 2}};
    static const double star[][2] = {{0, 3},       {-0.7, 1}, {-2.9, 0.9}, {-1.1, -0.4},
                                     {-1.8, -2.4}, {0, -1.2}, {1.8, -2.4}, {1.1, -0.4},
                                     {2.9, 0.9},   {0.7, 1}};
    static const double comb[][2] = {{0, 0}, {9, 0}, {9, 5}, {8, 5}, {8, 1}, {6, 1},
                                     {6, 5}, {5, 5}, {5, 1}, {3, 1}, {3, 5}, {2, 5},
                                     {2, 1}, {1, 1}, {1, 5}, {0, 5}};
    static const double spiral[][2] = {{0, 0}, {10, 0}, {10, 10}, {2, 10}, {2, 4}, {6, 4},
                                       {6, 6}, {4, 6},  {4, 8},   {8, 8},  {8, 2}, {0, 2}};
    check_flat(square, TEST_COUNT(square));
    check_flat(dart, TEST_COUNT(dart));
    check_flat(l_shape, TEST_COUNT(l_shape));
    check_flat(in_line, TEST_COUNT(in_line));
    check_flat(star, TEST_COUNT(star));
    check_flat(comb, TEST_COUNT(comb));
    check_flat(spiral, TEST_COUNT(spiral));
}

static void many_corners(void **state)
{
    (void)state;
    enum { COUNT = 100000 };
    Vec3 *p = malloc(COUNT * sizeof *p);
    for (int i = 0; i < 4000; ++i) {
        double angle = 2 * PI * i / 4000, radius = 1 + 0.3 * sin(17 * angle);
        p[i] = vec3(radius * cos(angle), 2, -radius * sin(angle));
    }
    check(p, 4000);
    for (int i = 0; i < COUNT; ++i) {
        p[i] = vec3(cos(2 * PI * i / COUNT), sin(2 * PI * i / COUNT), 5);
    }
    check(p, COUNT); // convex: any number
    p[77] = vec3(0, 0, 5);
    PolygonScratch scratch = {0};
    uint32_t *triangles = malloc(3 * COUNT * sizeof *triangles);
    assert_int_equal(polygon_triangulate(&scratch, p, COUNT, triangles), POLYGON_TOO_LONG);
    polygon_scratch_free(&scratch);
    free(triangles);
    free(p);
}

// What isn't a simple polygon still gives count - 2 triangles of its own corners.
static void crooked_polygons_end(void **state)
{
    (void)state;
    static const Vec3 bow_tie[] = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
    static const Vec3 pentagram[] = {
        {0, 1, 0}, {0.59, -0.81, 0}, {-0.95, 0.31, 0}, {0.95, 0.31, 0}, {-0.59, -0.81, 0}};
    static const Vec3 line[] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}};
    static const Vec3 point[] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
    static const Vec3 bent[] = {{0, 0, 0}, {1, 0, 0.3}, {1, 1, 0}, {0, 1, 0.3}, {-0.5, 0.5, 1}};
    static const struct {
        const Vec3 *p;
        uint32_t count;
    } all[] = {{bow_tie, 4}, {pentagram, 5}, {line, 5}, {point, 4}, {bent, 5}};
    PolygonScratch scratch = {0};
    for (size_t i = 0; i < TEST_COUNT(all); ++i) {
        uint32_t triangles[16];
        memset(triangles, 0xff, sizeof triangles);
        assert_int_equal(polygon_triangulate(&scratch, all[i].p, all[i].count, triangles),
                         POLYGON_OK);
        for (uint32_t c = 0; c < 3 * (all[i].count - 2); ++c) {
            assert_true(triangles[c] < all[i].count);
        }
        assert_int_equal(triangles[3 * (all[i].count - 2)], UINT32_MAX);
    }
    polygon_scratch_free(&scratch);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(convex_and_concave),
        cmocka_unit_test(many_corners),
        cmocka_unit_test(crooked_polygons_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
