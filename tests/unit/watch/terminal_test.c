// A session on a terminal, and for tev: what the keys do, and the bytes that are sent.
#include "watch/terminal.h"
#include "watch/tev.h"

#include "../test_support.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

static char path[] = "/tmp/scnrender_terminal.XXXXXX";

static const char scene[] =
    "film { width: 24, height: 16 }\nrender { samples: 4 }\n"
    "camera { name: \"a\", position: (0, 0, 5), look_at: (0, 0, 0) }\n"
    "camera { name: \"b\", position: (5, 0, 0), look_at: (0, 0, 0) }\n"
    "param size: length = 1m in 0m..2m \"Its radius\"\n"
    "sphere { name: \"ball\", radius: size }\nenvironment_light { radiance: 1 }\n";

static Session *start(void)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(scene, file);
    fclose(file);
    SessionOptions options = {.scene = {.file = path, .limits = limits_default()}, .seed = -1};
    char message[200];
    Session *session = session_new(&options, message, sizeof message);
    assert_non_null(session);
    return session;
}

static void wait_until_done(Session *session)
{
    for (int i = 0; i < 1000 && session_status(session).phase != PHASE_DONE; ++i) {
        nanosleep(&(struct timespec){0, 10000000}, NULL);
    }
    assert_int_equal(session_status(session).phase, PHASE_DONE);
}

static TerminalWish press(Terminal *terminal, const char *keys)
{
    size_t used;
    TerminalWish wish = terminal_keys(terminal, keys, strlen(keys), &used);
    assert_int_equal(used, strlen(keys));
    return wish;
}

static bool command_has(Session *session, const char *text)
{
    Text command = session_command(session);
    bool has = strstr(command.bytes, text) != NULL;
    text_free(&command);
    return has;
}

static void draws_and_obeys(void **state)
{
    (void)state;
    char message[300];
    Session *session = start();
    Terminal *terminal = terminal_new(session, "blocks", message, sizeof message);
    if (!terminal) { // built without libchafa
        session_free(session);
        skip();
    }
    wait_until_done(session);
    Text screen = {0};
    terminal_draw(terminal, (TerminalSize){40, 12, 0, 0}, true, &screen);
    assert_non_null(strstr(screen.bytes, "\x1b[11;1H")); // the line before the last
    assert_non_null(strstr(screen.bytes, " done  4 of 4 samples"));
    text_free(&screen);
    terminal_draw(terminal, (TerminalSize){1, 1, 0, 0}, true, &screen); // too small to say anything
    assert_int_equal(screen.length, 0);

    assert_int_equal(press(terminal, "\x1b[C"), WISH_REDRAW);
    assert_true(command_has(session, "--camera 'camera { position: (0.435"));
    press(terminal, "0");
    assert_false(command_has(session, "--camera"));
    press(terminal, "c");
    assert_true(command_has(session, "--camera b"));
    press(terminal, "c\x1b[1;2A\x1b[1;2B+");
    assert_true(command_has(session, "position: (0, 0, 4.5)"));
    press(terminal, "eee");
    assert_true(command_has(session, "--exposure 1"));
    press(terminal, "t");
    assert_true(command_has(session, "--tone linear"));
    wait_until_done(session);
    press(terminal, "\t]");
    assert_true(command_has(session, "--set size=1.05m"));
    press(terminal, "r");
    assert_false(command_has(session, "--set"));
    assert_int_equal(press(terminal, "s"), WISH_SAVE);
    wait_until_done(session);
    press(terminal, "i");
    terminal_draw(terminal, (TerminalSize){100, 12, 1000, 240}, false, &screen);
    assert_non_null(strstr(screen.bytes, "in the middle: ball sphere"));
    text_free(&screen);
    assert_int_equal(press(terminal, "q"), WISH_QUIT);
    size_t used;
    assert_int_equal(terminal_keys(terminal, "\x1b[1;", 4, &used), WISH_NOTHING);
    assert_int_equal(used, 0); // half a key waits for the other half

    static const char *const modes[] = {"sixel", "kitty"}, *const begins[] = {"\x1bP", "\x1b_G"};
    for (size_t i = 0; i < 2; ++i) {
        Terminal *other = terminal_new(session, modes[i], message, sizeof message);
        assert_non_null(other);
        terminal_draw(other, (TerminalSize){40, 12, 400, 240}, true, &screen);
        assert_non_null(strstr(screen.bytes, begins[i]));
        text_free(&screen);
        terminal_free(other);
    }
    assert_null(terminal_new(session, "paper", message, sizeof message));
    terminal_free(terminal);
    session_free(session);
}

// --- tev -----------------------------------------------------------------------------------------

static uint32_t get_u32(const unsigned char *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static void packets_are_as_tev_reads_them(void **state)
{
    (void)state;
    Text packet = {0};
    tev_create_image(&packet, "a.scn", true, 3, 258);
    static const unsigned char create[] = {30,  0, 0, 0, 4,   1, 'a', '.', 's', 'c',
                                           'n', 0, 3, 0, 0,   0, 2,   1,   0,   0,
                                           3,   0, 0, 0, 'R', 0, 'G', 0,   'B', 0};
    assert_int_equal(packet.length, sizeof create);
    assert_memory_equal(packet.bytes, create, sizeof create);
    text_free(&packet);
}

static int listen_somewhere(uint16_t *port)
{
    int fd = socket(AF_INET, SOCK_STREAM, 0);
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof at;
    assert_int_equal(bind(fd, (struct sockaddr *)&at, sizeof at), 0);
    assert_int_equal(listen(fd, 4), 0);
    assert_int_equal(getsockname(fd, (struct sockaddr *)&at, &size), 0);
    *port = ntohs(at.sin_port);
    return fd;
}

static size_t read_all(int fd, unsigned char *to, size_t size)
{
    size_t done = 0;
    while (done < size) {
        ssize_t part = recv(fd, to + done, size - done, 0);
        if (part <= 0) {
            break;
        }
        done += (size_t)part;
    }
    return done;
}

// One packet, whole; its length.
static uint32_t read_packet(int fd, unsigned char *to, size_t room)
{
    assert_int_equal(read_all(fd, to, 4), 4);
    uint32_t length = get_u32(to);
    assert_true(length > 4 && length <= room);
    assert_int_equal(read_all(fd, to + 4, length - 4), length - 4);
    return length;
}

static void a_server_gets_the_pictures(void **state)
{
    (void)state;
    uint16_t port;
    int listener = listen_somewhere(&port);
    Session *session = start();
    char address[40], message[200];
    snprintf(address, sizeof address, "127.0.0.1:%u", port);
    TevSender *sender = tev_new(session, address, "ball.scn", message, sizeof message);
    assert_non_null(sender);
    int fd = accept(listener, NULL, NULL);
    static unsigned char packet[16384];
    // int32 length, type, grab focus, name, width, height, channel count and names
    static const unsigned char create[] = {0,   0,   0,   0, 4,  1,   'b', 'a', 'l', 'l', '.',
                                           's', 'c', 'n', 0, 24, 0,   0,   0,   16,  0,   0,
                                           0,   3,   0,   0, 0,  'R', 0,   'G', 0,   'B', 0};
    assert_int_equal(read_packet(fd, packet, sizeof packet), sizeof create);
    assert_memory_equal(packet + 4, create + 4, sizeof create - 4);
    // …, no focus, name, channels, x, y, width, height, offsets and strides of int64, then floats
    wait_until_done(session);
    nanosleep(&(struct timespec){0, 300000000}, NULL);
    const uint32_t head = 4 + 1 + 1 + 9 + 4 + 6 + 16 + 24 + 24, size = head + 24 * 16 * 12;
    assert_int_equal(read_packet(fd, packet, sizeof packet), size);
    static const unsigned char update[] = {6, 0, 'b', 'a', 'l', 'l', '.', 's', 'c', 'n', 0, 3, 0,
                                           0, 0, 'R', 0,   'G', 0,   'B', 0,   0,   0,   0, 0, 0,
                                           0, 0, 0,   24,  0,   0,   0,   16,  0,   0,   0};
    assert_memory_equal(packet + 4, update, sizeof update);
    for (uint32_t i = 0; i < 3; ++i) {
        assert_int_equal(get_u32(packet + 4 + sizeof update + 8 * i), i);
        assert_int_equal(get_u32(packet + 4 + sizeof update + 8 * i + 4), 0);
        assert_int_equal(get_u32(packet + 4 + sizeof update + 24 + 8 * i), 3);
    }
    float corner; // of the surroundings: exactly their radiance
    memcpy(&corner, packet + head, sizeof corner);
    assert_true(corner == 1);
    // It goes away and comes back: everything is sent anew.
    close(fd);
    session_set_look(session, 1, -1, message, sizeof message);
    session_reload(session);
    fd = accept(listener, NULL, NULL);
    assert_int_equal(read_packet(fd, packet, sizeof packet), sizeof create);
    assert_int_equal(packet[4], 4);
    tev_free(sender);
    close(fd);
    close(listener);
    session_free(session);
}

static void addresses_are_checked(void **state)
{
    (void)state;
    Session *session = start();
    static const char *const wrong[] = {"",         "host",    "host:", ":14158",
                                        "host:12x", "host:-1", "[]:1"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        char message[200] = "";
        assert_null(tev_new(session, wrong[i], "x", message, sizeof message));
        assert_true(*message);
    }
    session_free(session);
}

static int make_file(void **state)
{
    (void)state;
    int fd = mkstemp(path);
    return fd < 0 ? -1 : close(fd);
}

static int remove_file(void **state)
{
    (void)state;
    return unlink(path);
}

int main(void)
{
    setenv("SCNRENDER_MODULES", SCN_BINARY_DIR "/lib/scnrender", 1);
    setenv("TERM", "xterm-256color", 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(draws_and_obeys),
        cmocka_unit_test(packets_are_as_tev_reads_them),
        cmocka_unit_test(a_server_gets_the_pictures),
        cmocka_unit_test(addresses_are_checked),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}
