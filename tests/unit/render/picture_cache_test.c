// Pictures that are kept between scenes: found by their files' bytes and encoding, dropped when a
// whole scene did without them, and alive for as long as anybody holds them.
#include "render/picture_cache.h"

#include "../test_support.h"

static SharedPicture *make(uint64_t digest, int32_t encoding)
{
    SharedPicture *picture = shared_picture_new(2, 1);
    assert_non_null(picture);
    picture->digest[0] = digest;
    picture->encoding = encoding;
    picture->image.texels[0] = rgb((float)digest, 0, 0);
    return picture;
}

static bool has(PictureCache *cache, uint64_t digest, int32_t encoding)
{
    SharedPicture *found = picture_cache_find(cache, (uint64_t[]){digest, 0}, encoding);
    assert_true(!found || found->image.texels[0].r == (float)digest);
    shared_picture_release(found);
    return found != NULL;
}

static void what_is_asked_for_stays(void **state)
{
    (void)state;
    PictureCache *cache = picture_cache_new();
    SharedPicture *one = make(1, 0), *two = make(2, 0);
    picture_cache_add(cache, one);
    picture_cache_add(cache, two);
    assert_true(has(cache, 1, 0));
    assert_false(has(cache, 1, 1));
    assert_false(has(cache, 3, 0));
    picture_cache_turn(cache);
    assert_true(has(cache, 1, 0)); // this scene asks for the first one only
    picture_cache_turn(cache);
    assert_true(has(cache, 1, 0));
    assert_false(has(cache, 2, 0));
    assert_true(two->image.texels[0].r == 2); // and who holds the other has it still
    picture_cache_free(cache);
    assert_true(one->image.texels[0].r == 1);
    shared_picture_release(one);
    shared_picture_release(two);
}

static void without_a_cache_nothing_is_kept(void **state)
{
    (void)state;
    SharedPicture *one = make(1, 0);
    picture_cache_add(NULL, one);
    picture_cache_turn(NULL);
    assert_false(has(NULL, 1, 0));
    shared_picture_release(one);
    picture_cache_free(NULL);
}

static void sizes_are_checked(void **state)
{
    (void)state;
    assert_null(shared_picture_new(0, 5));
    assert_null(shared_picture_new(5, -1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_asked_for_stays),
        cmocka_unit_test(without_a_cache_nothing_is_kept),
        cmocka_unit_test(sizes_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
