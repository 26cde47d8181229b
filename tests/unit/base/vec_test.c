// Boxes and affine maps.
#include "base/vec.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const Box3 box = {{-1, 2, 3}, {4, 5, 6}};

static void assert_same_box(Box3 a, Box3 b)
{
    assert_true(a.min.x == b.min.x && a.min.y == b.min.y && a.min.z == b.min.z);
    assert_true(a.max.x == b.max.x && a.max.y == b.max.y && a.max.z == b.max.z);
}

static void an_empty_box_adds_nothing(void **state)
{
    (void)state;
    assert_true(box3_is_empty(box3_empty()));
    assert_false(box3_is_empty(box));
    assert_same_box(box3_union(box, box3_empty()), box);
    assert_same_box(box3_union(box3_empty(), box), box);
    assert_true(box3_is_empty(box3_union(box3_empty(), box3_empty())));
}

static void unions_hold_both(void **state)
{
    (void)state;
    const Box3 other = {{0, -7, 4}, {9, -6, 5}};
    const Box3 want = {{-1, -7, 3}, {9, 5, 6}};
    assert_same_box(box3_union(box, other), want);
    assert_same_box(box3_union(other, box), want);
    assert_same_box(box3_add(box, vec3(0, 9, 4)), (Box3){{-1, 2, 3}, {4, 9, 6}});
}

static void boxes_are_turned(void **state)
{
    (void)state;
    const Affine turn = affine_rotation(vec3(0, 0, 1), PI / 2); // x to y, y to -x
    const Box3 turned = transform_box(&turn, box);
    assert_true(fabs(turned.min.x + 5) < 1e-12 && fabs(turned.max.x + 2) < 1e-12);
    assert_true(fabs(turned.min.y + 1) < 1e-12 && fabs(turned.max.y - 4) < 1e-12);
    assert_true(turned.min.z == 3 && turned.max.z == 6);
}

// To the bit what its corners have, whatever the map.
static void boxes_are_as_wide_as_their_corners(void **state)
{
    (void)state;
    const Box3 boxes[] = {
        box, {{-3, 0, 1e-9}, {0.1, 7, 1e9}}, {{-INFINITY, 0, 0}, {1, 1, INFINITY}}};
    for (int i = 0; i < 60; ++i) {
        const Affine turn = affine_rotation(vec3(i % 7 - 3, 1, i % 5), 0.37 * i);
        const Affine size = affine_scaling(vec3(1 - i % 3, 0.3 * i - 4, 2));
        const Affine place = affine_translation(vec3(0.1 * i, -3, 1e3)),
                     at = affine_multiply(&place, &turn);
        const Affine map = i % 4 ? affine_multiply(&at, &size) : size;
        const Box3 from = boxes[i % 3], found = transform_box(&map, from);
        Box3 want = box3_empty();
        for (int corner = 0; corner < 8; ++corner) {
            want = box3_add(want, transform_point(&map, box3_corner(from, corner)));
        }
        assert_same_box(found, want);
    }
}

static void maps_are_undone_by_their_inverse(void **state)
{
    (void)state;
    const Affine a = affine_rotation(vec3(1, 2, -1), 0.7), b = affine_scaling(vec3(2, -3, 0.5));
    const Affine c = affine_translation(vec3(10, 20, 30));
    const Affine ab = affine_multiply(&a, &b), map = affine_multiply(&c, &ab);
    Affine inverse;
    assert_true(affine_inverse(&map, &inverse));
    const Vec3 p = vec3(0.3, -4, 8);
    const Vec3 back = transform_point(&inverse, transform_point(&map, p));
    assert_true(length(sub(back, p)) < 1e-12);
    assert_true(fabs(affine_determinant(&map) + 3) < 1e-12);
    const Affine flat = affine_scaling(vec3(1, 0, 1));
    assert_false(affine_inverse(&flat, &inverse));
}

static void looking_needs_a_direction_and_an_up(void **state)
{
    (void)state;
    Affine map;
    const Vec3 eye = vec3(1, 2, 3);
    assert_false(affine_look_at(eye, eye, vec3(0, 1, 0), &map));
    assert_false(affine_look_at(eye, vec3(1, 9, 3), vec3(0, 1, 0), &map));
    assert_true(affine_look_at(eye, vec3(1, 2, -3), vec3(0, 1, 0), &map));
    assert_true(affine_look_at(vec3(0, 0, 0), vec3(0, 0, -1), vec3(0, 5, 0), &map));
    assert_true(affine_is_identity(&map));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_box_adds_nothing),
        cmocka_unit_test(unions_hold_both),
        cmocka_unit_test(boxes_are_turned),
        cmocka_unit_test(boxes_are_as_wide_as_their_corners),
        cmocka_unit_test(maps_are_undone_by_their_inverse),
        cmocka_unit_test(looking_needs_a_direction_and_an_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
