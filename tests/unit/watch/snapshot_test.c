// What a page is sent is, byte for byte, what an 8-bit file of the same film holds.
#include "base/hash.h"
#include "watch/snapshot.h"

#include "../test_support.h"

#include <stdlib.h>
#include <string.h>

enum { SIDE = 512 };

static float value_of(uint32_t i)
{
    static const float odd[] = {0,  1,   0.0031308f, 1e-30f, 1e30f,
                                -1, NAN, INFINITY,   0.5f,   0.99999994f};
    if (i < TEST_COUNT(odd)) {
        return odd[i];
    }
    // Evenly over what is shown, and over the powers of two below it.
    float u = hash_to_float(hash_u32(i));
    return i % 2 ? 1.1f * u : exp2f(-14 * u);
}

static void every_byte_is_that_of_a_file(void **state)
{
    (void)state;
    float *radiance = malloc((size_t)SIDE * SIDE * 3 * sizeof *radiance);
    unsigned char *rgba = malloc((size_t)SIDE * SIDE * 4);
    assert_non_null(radiance);
    assert_non_null(rgba);
    for (uint32_t i = 0; i < SIDE * SIDE * 3; ++i) {
        radiance[i] = value_of(i);
    }
    Snapshot snapshot = {.width = SIDE, .height = SIDE, .radiance = radiance};
    for (int tone = TONE_SRGB; tone <= TONE_FILMIC; ++tone) {
        snapshot_develop(&snapshot, 0.5, (ToneCurve)tone, rgba);
        for (uint32_t p = 0; p < SIDE * SIDE; ++p) {
            Rgb in = rgb_scale(rgb(radiance[3 * p], radiance[3 * p + 1], radiance[3 * p + 2]),
                               (float)exp2(0.5));
            Rgb out = tone_apply((ToneCurve)tone, in);
            const float channels[] = {out.r, out.g, out.b};
            for (uint32_t c = 0; c < 3; ++c) {
                if (rgba[4 * p + c] != (unsigned char)(channels[c] * 255.0f + 0.5f)) {
                    fail_msg("%s: %a gives %u, not %g", tone_names[tone],
                             (double)radiance[3 * p + c], rgba[4 * p + c],
                             (double)channels[c] * 255);
                }
            }
            assert_int_equal(rgba[4 * p + 3], 255);
        }
    }
    free(radiance);
    free(rgba);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_byte_is_that_of_a_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
