// The base protocol's frames, whatever pieces they come in and whatever stands between them.
#include "lsp/frames.h"

#include "../test_support.h"

#include <stdio.h>

static void give(Frames *frames, const char *bytes, size_t size)
{
    char *room = frames_room(frames, size);
    assert_non_null(room);
    memcpy(room, bytes, size);
    frames_added(frames, size);
}

static void expect_body(Frames *frames, const char *text)
{
    Str body;
    assert_int_equal(frames_next(frames, &body), FRAME_BODY);
    assert_int_equal(body.length, strlen(text));
    assert_memory_equal(body.at, text, body.length);
}

static void expect(Frames *frames, FrameResult result)
{
    Str body;
    assert_int_equal(frames_next(frames, &body), result);
}

static void takes_frames_in_pieces_of_any_size(void **state)
{
    (void)state;
    static const char both[] = "Content-Length: 7\r\n\r\n{\"a\":1}"
                               "Content-Type: x\r\ncontent-length:\t2 \r\n\r\n[]"
                               "Content-Length: 0\n\n";
    for (size_t piece = 1; piece < sizeof both; ++piece) {
        Frames frames = {0};
        static const char *const bodies[] = {"{\"a\":1}", "[]", ""};
        size_t found = 0, size = sizeof both - 1;
        for (size_t at = 0; at < size; at += piece) {
            give(&frames, both + at, piece < size - at ? piece : size - at);
            Str body;
            while (frames_next(&frames, &body) == FRAME_BODY) {
                assert_true(str_equal(body, str_from(bodies[found])));
                ++found;
            }
        }
        assert_int_equal(found, 3);
        frames_free(&frames);
    }
}

static void leaves_out_what_is_no_frame(void **state)
{
    (void)state;
    Frames frames = {0};
    static const char text[] = "GET / HTTP/1.1\r\n\r\n"
                               "Content-Length: -1\r\n\r\n"
                               "Content-Length: 99999999999999999999\r\n\r\n"
                               "left over\r\nContent-Length: 1\r\n\r\n1";
    give(&frames, text, sizeof text - 1);
    expect(&frames, FRAME_BAD);
    expect(&frames, FRAME_BAD);
    expect(&frames, FRAME_BAD);
    expect_body(&frames, "1");
    expect(&frames, FRAME_MORE);
    frames_free(&frames);
}

static void gives_up_on_a_header_without_end(void **state)
{
    (void)state;
    Frames frames = {0};
    char line[1000];
    memset(line, 'x', sizeof line);
    int bad = 0;
    for (int i = 0; i < 200; ++i) {
        give(&frames, line, sizeof line);
        Str body;
        bad += frames_next(&frames, &body) == FRAME_BAD;
        assert_true(frames.bytes.count - frames.taken <= FRAME_HEADER_MOST + sizeof line);
    }
    assert_int_equal(bad, 200 * 1000 / FRAME_HEADER_MOST);
    give(&frames, "\r\nContent-Length: 1\r\n\r\n1", 25);
    expect_body(&frames, "1");
    frames_free(&frames);
}

static void skips_the_bytes_of_a_message_that_is_too_large(void **state)
{
    (void)state;
    Frames frames = {0};
    char header[64];
    size_t left = (size_t)FRAME_BODY_MOST + 1;
    int size = snprintf(header, sizeof header, "Content-Length: %zu\r\n\r\n", left);
    give(&frames, header, (size_t)size);
    expect(&frames, FRAME_BAD);
    static char some[1 << 20];
    while (left > 0) {
        size_t now = left < sizeof some ? left : sizeof some;
        give(&frames, some, now);
        left -= now;
        expect(&frames, FRAME_MORE);
        assert_int_equal(frames.bytes.count - frames.taken, 0);
    }
    give(&frames, "Content-Length: 1\r\n\r\n1", 23);
    expect_body(&frames, "1");
    frames_free(&frames);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(takes_frames_in_pieces_of_any_size),
        cmocka_unit_test(leaves_out_what_is_no_frame),
        cmocka_unit_test(gives_up_on_a_header_without_end),
        cmocka_unit_test(skips_the_bytes_of_a_message_that_is_too_large),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
