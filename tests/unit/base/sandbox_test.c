// The sandbox: what a scene may read, and every way out that was thought of.
#include "base/io.h"
#include "base/mem.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

// base/        the working folder of the test
//   scenes/    allowed
//     a.scn  lib/b.scn  links…
//   secret/key.txt
typedef struct Place {
    char base[64];
    Sandbox sandbox;
    Arena arena;
} Place;

static char *path_of(Place *place, const char *name)
{
    return arena_printf(&place->arena, "%s/%s", place->base, name);
}

static void write_text(Place *place, const char *name, const char *text)
{
    FILE *file = fopen(path_of(place, name), "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void make_folder(Place *place, const char *name)
{
    assert_int_equal(mkdir(path_of(place, name), 0755), 0);
}

static void make_link(Place *place, const char *target, const char *name)
{
    assert_int_equal(symlink(target, path_of(place, name)), 0);
}

static int set_up(void **state)
{
    Place *place = calloc(1, sizeof *place);
    strcpy(place->base, "/tmp/scn_sandbox_XXXXXX");
    assert_non_null(mkdtemp(place->base));
    make_folder(place, "scenes");
    make_folder(place, "scenes/lib");
    make_folder(place, "secret");
    make_folder(place, "scenes-not");
    write_text(place, "scenes/a.scn", "inside");
    write_text(place, "scenes/lib/b.scn", "deep");
    write_text(place, "secret/key.txt", "secret");
    write_text(place, "scenes-not/key.txt", "secret");
    make_link(place, "../secret/key.txt", "scenes/out.txt");
    make_link(place, path_of(place, "secret/key.txt"), "scenes/out_absolute.txt");
    make_link(place, "../secret", "scenes/out_folder");
    make_link(place, "lib/b.scn", "scenes/in.scn");
    make_link(place, path_of(place, "scenes/lib/b.scn"), "scenes/in_absolute.scn");
    make_link(place, "loop", "scenes/loop");
    make_link(place, "/proc/self/root", "scenes/magic");
    make_link(place, "/dev/zero", "scenes/zero");
    assert_int_equal(mkfifo(path_of(place, "scenes/fifo"), 0644), 0);
    sandbox_init(&place->sandbox);
    assert_int_equal(sandbox_allow(&place->sandbox, path_of(place, "scenes")), IO_OK);
    *state = place;
    return 0;
}

static int tear_down(void **state)
{
    Place *place = *state;
    char *command = arena_printf(&place->arena, "rm -rf '%s'", place->base);
    assert_int_equal(system(command), 0);
    sandbox_free(&place->sandbox);
    arena_free(&place->arena);
    free(place);
    return 0;
}

// What reading `name`, an absolute path or one below the base, gives; the content in *text.
static IoError read_name(Place *place, const char *name, const char **text)
{
    FileBytes bytes;
    const char *path = name[0] == '/' ? name : path_of(place, name);
    IoError error = sandbox_read(&place->sandbox, path, &bytes);
    *text = "";
    if (error == IO_OK) {
        assert_int_equal(bytes.bytes[bytes.size], 0);
        *text = arena_copy_string(&place->arena, bytes.bytes, bytes.size);
        file_bytes_free(&bytes);
    }
    return error;
}

static void check_reading(Place *place)
{
    static const struct {
        const char *name;
        IoError error;
        const char *text;
    } cases[] = {
        {"scenes/a.scn", IO_OK, "inside"},
        {"scenes/lib/b.scn", IO_OK, "deep"},
        {"scenes/in.scn", IO_OK, "deep"},
        {"scenes/in_absolute.scn", IO_OK, "deep"},
        {"scenes/none.scn", IO_NOT_FOUND, ""},
        {"scenes/a.scn/b", IO_NOT_FOUND, ""},
        {"scenes", IO_NOT_REGULAR, ""},
        {"scenes/lib", IO_NOT_REGULAR, ""},
        {"scenes/fifo", IO_NOT_REGULAR, ""},
        {"secret/key.txt", IO_OUTSIDE, ""},
        {"scenes-not/key.txt", IO_OUTSIDE, ""}, // a prefix of the name isn't the folder
        {"scenes/../secret/key.txt", IO_OUTSIDE, ""},
        {"scenes/lib/../../secret/key.txt", IO_OUTSIDE, ""},
        {"scenes/out.txt", IO_OUTSIDE, ""},
        {"scenes/out_absolute.txt", IO_OUTSIDE, ""},
        {"scenes/out_folder/key.txt", IO_OUTSIDE, ""},
        {"scenes/loop", IO_OUTSIDE, ""},
        {"scenes/magic/etc/passwd", IO_OUTSIDE, ""},
        {"scenes/zero", IO_OUTSIDE, ""},
        {"/etc/passwd", IO_OUTSIDE, ""},
        {"/proc/self/root/etc/passwd", IO_OUTSIDE, ""},
        {"/dev/zero", IO_OUTSIDE, ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const char *text;
        IoError error = read_name(place, cases[i].name, &text);
        if (error != cases[i].error || strcmp(text, cases[i].text) != 0) {
            fail_msg("%s: %s, \"%s\"", cases[i].name, io_error_text(error), text);
        }
    }
}

static void test_reading(void **state)
{
    check_reading(*state);
}

// Forks a child in which openat2 fails like in an old kernel (or, with EPERM, like in an old
// container), and tries all of it again there.
static void check_without_openat2(Place *place, unsigned code)
{
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct sock_filter rules[] = {
            BPF_STMT(BPF_LD | BPF_W | BPF_ABS, 0),
            BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_openat2, 0, 1),
            BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | code),
            BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        };
        struct sock_fprog program = {sizeof rules / sizeof rules[0], rules};
        if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
            prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0) {
            _exit(77);
        }
        if (syscall(SYS_openat2, AT_FDCWD, "/", NULL, 0) != -1 || errno != (int)code) {
            _exit(78);
        }
        check_reading(place);
        _exit(0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    if (WEXITSTATUS(status) == 77) {
        skip();
    }
    assert_int_equal(WEXITSTATUS(status), 0);
}

static void test_reading_without_openat2(void **state)
{
    check_without_openat2(*state, ENOSYS);
}

static void test_reading_with_openat2_forbidden(void **state)
{
    check_without_openat2(*state, EPERM);
}

static void test_socket_and_device(void **state)
{
    Place *place = *state;
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%s/scenes/socket", place->base);
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&address, sizeof address), 0);
    const char *text;
    assert_int_equal(read_name(place, "scenes/socket", &text), IO_NOT_REGULAR);
    close(fd);
    assert_int_equal(sandbox_allow(&place->sandbox, "/dev"), IO_OK);
    assert_int_equal(read_name(place, "/dev/zero", &text), IO_NOT_REGULAR);
    assert_int_equal(read_name(place, "scenes/zero", &text), IO_NOT_REGULAR);
}

static void test_second_folder(void **state)
{
    Place *place = *state;
    const char *text;
    assert_int_equal(sandbox_allow(&place->sandbox, path_of(place, "secret")), IO_OK);
    assert_int_equal(read_name(place, "secret/key.txt", &text), IO_OK);
    assert_int_equal(read_name(place, "scenes/out.txt", &text), IO_OK);
    assert_string_equal(text, "secret");
    assert_int_equal(read_name(place, "scenes-not/key.txt", &text), IO_OUTSIDE);
}

static void test_folders_that_cannot_be_allowed(void **state)
{
    Place *place = *state;
    assert_int_equal(sandbox_allow(&place->sandbox, path_of(place, "none")), IO_NOT_FOUND);
    assert_int_equal(sandbox_allow(&place->sandbox, path_of(place, "scenes/a.scn")),
                     IO_NOT_REGULAR);
    assert_int_equal(sandbox_allow(&place->sandbox, ""), IO_NOT_FOUND);
    assert_int_equal(place->sandbox.root_count, 1);
}

static void test_folder_named_through_a_link(void **state)
{
    Place *place = *state;
    make_link(place, "scenes", "alias");
    Sandbox sandbox;
    sandbox_init(&sandbox);
    assert_int_equal(sandbox_allow(&sandbox, path_of(place, "alias/")), IO_OK);
    FileBytes bytes;
    assert_int_equal(sandbox_read(&sandbox, path_of(place, "alias/a.scn"), &bytes), IO_OK);
    file_bytes_free(&bytes);
    assert_int_equal(sandbox_read(&sandbox, path_of(place, "scenes/a.scn"), &bytes), IO_OK);
    file_bytes_free(&bytes);
    sandbox_free(&sandbox);
}

static void test_size_limit(void **state)
{
    Place *place = *state;
    const char *text;
    place->sandbox.max_file_bytes = 5;
    assert_int_equal(read_name(place, "scenes/a.scn", &text), IO_TOO_LARGE);
    place->sandbox.max_file_bytes = 6;
    assert_int_equal(read_name(place, "scenes/a.scn", &text), IO_OK);
    FileBytes bytes;
    assert_int_equal(file_read(path_of(place, "scenes/a.scn"), 5, &bytes), IO_TOO_LARGE);
}

static void test_forbidden(void **state)
{
    Place *place = *state;
    if (geteuid() == 0) {
        skip(); // nothing is forbidden to root
    }
    const char *text;
    assert_int_equal(chmod(path_of(place, "scenes/a.scn"), 0), 0);
    assert_int_equal(read_name(place, "scenes/a.scn", &text), IO_FORBIDDEN);
}

static void check_resolved(Place *place, const char *from, const char *path, const char *expected)
{
    const char *out;
    IoError error = sandbox_resolve(&place->sandbox, &place->arena, from, str_from(path), &out);
    assert_int_equal(error, expected ? IO_OK : IO_OUTSIDE);
    if (expected) {
        assert_string_equal(out, path_of(place, expected));
    } else {
        assert_null(out);
    }
}

static void test_resolving(void **state)
{
    Place *place = *state;
    const char *from = path_of(place, "scenes/lib/b.scn");
    check_resolved(place, from, "c.scn", "scenes/lib/c.scn");
    check_resolved(place, from, "./c.scn", "scenes/lib/c.scn");
    check_resolved(place, from, "../a.scn", "scenes/a.scn");
    check_resolved(place, from, "x//../.././a.scn", "scenes/a.scn");
    check_resolved(place, NULL, "a.scn", "scenes/a.scn");
    check_resolved(place, from, path_of(place, "scenes/a.scn"), "scenes/a.scn");
    check_resolved(place, from, "../..", NULL);
    check_resolved(place, from, "../../secret/key.txt", NULL);
    check_resolved(place, from, "../../scenes-not/key.txt", NULL);
    check_resolved(place, from, "../../../../../../../../../../etc/passwd", NULL);
    check_resolved(place, from, "/etc/passwd", NULL);
    check_resolved(place, from, "/", NULL);
}

static void test_resolving_odd_names(void **state)
{
    Place *place = *state;
    const char *out;
    char nul[] = "a.scn\0/../../secret/key.txt";
    assert_int_equal(
        sandbox_resolve(&place->sandbox, &place->arena, NULL, (Str){nul, sizeof nul - 1}, &out),
        IO_NOT_FOUND);
    char *longest = calloc(1, 3 * PATH_MAX);
    memset(longest, 'x', 3 * PATH_MAX - 1);
    assert_int_equal(sandbox_resolve(&place->sandbox, &place->arena, NULL, str_from(longest), &out),
                     IO_NOT_FOUND);
    longest[300] = '\0'; // fits a path, but no file system's names
    assert_int_equal(sandbox_resolve(&place->sandbox, &place->arena, NULL, str_from(longest), &out),
                     IO_OK);
    const char *text;
    assert_int_equal(read_name(place, out, &text), IO_NOT_FOUND);
    free(longest);
    assert_int_equal(sandbox_resolve(&place->sandbox, &place->arena, NULL, STR(""), &out), IO_OK);
    assert_int_equal(read_name(place, out, &text), IO_NOT_REGULAR);
}

static void test_large_and_empty_files(void **state)
{
    Place *place = *state;
    FileBytes bytes;
    static const size_t sizes[] = {0, 1, 4095, 4096, 65535, 65536, 65537, 3 << 20, (5 << 20) + 7};
    place->sandbox.threads = 3; // which share the last one
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        char *path = path_of(place, "scenes/sized");
        FILE *file = fopen(path, "w");
        for (size_t k = 0; k < sizes[i]; ++k) {
            putc((int)(k * 31 % 251), file);
        }
        fclose(file);
        assert_int_equal(sandbox_read(&place->sandbox, path, &bytes), IO_OK);
        assert_int_equal(bytes.size, sizes[i]);
        for (size_t k = 0; k < sizes[i]; ++k) {
            assert_int_equal((unsigned char)bytes.bytes[k], k * 31 % 251);
        }
        assert_int_equal(bytes.bytes[sizes[i]], 0);
        file_bytes_free(&bytes);
    }
}

static void test_reading_a_pipe(void **state)
{
    Place *place = *state;
    enum { SIZE = 200000 };
    char *path = path_of(place, "pipe");
    for (int round = 0; round < 2; ++round) {
        assert_int_equal(mkfifo(path, 0644), 0);
        pid_t child = fork();
        if (child == 0) {
            FILE *file = fopen(path, "w");
            for (int i = 0; i < SIZE; ++i) {
                putc(i % 127, file);
            }
            fclose(file);
            _exit(0);
        }
        FileBytes bytes;
        IoError error = file_read(path, round == 0 ? SIZE : SIZE - 1, &bytes);
        if (round == 0) {
            assert_int_equal(error, IO_OK);
            assert_int_equal(bytes.size, SIZE);
            assert_int_equal(bytes.bytes[SIZE - 1], (SIZE - 1) % 127);
            file_bytes_free(&bytes);
        } else {
            assert_int_equal(error, IO_TOO_LARGE);
        }
        waitpid(child, NULL, 0);
        unlink(path);
    }
}

static void test_no_memory(void **state)
{
    Place *place = *state;
    char *path = path_of(place, "scenes/a.scn");
    FileBytes bytes;
    mem_fail_after(0);
    IoError error = sandbox_read(&place->sandbox, path, &bytes);
    mem_fail_after(UINT64_MAX);
    assert_int_equal(error, IO_NO_MEMORY);
    assert_null(bytes.bytes);
    char *folder = path_of(place, "secret");
    for (uint64_t after = 0; after < 2; ++after) {
        mem_fail_after(after);
        error = sandbox_allow(&place->sandbox, folder);
        mem_fail_after(UINT64_MAX);
        assert_int_equal(error, IO_NO_MEMORY);
    }
    assert_int_equal(place->sandbox.root_count, 1);
}

// Large contents are hashed in pieces: the same by any number of threads, and another for a change
// of any part.
static void contents_have_hashes(void **state)
{
    (void)state;
    enum { SIZE = (4 << 20) + 7 };
    char *bytes = calloc(SIZE, 1);
    assert_non_null(bytes);
    const uint64_t hash = content_hash(bytes, SIZE, 1, 1);
    assert_true(content_hash(bytes, SIZE, 1, 3) == hash);
    assert_true(content_hash(bytes, SIZE, 2, 3) != hash);
    assert_true(content_hash(bytes, SIZE - 1, 1, 3) != hash);
    for (size_t at = 0; at < SIZE; at += at < SIZE - 8 ? SIZE / 40 : 1) {
        bytes[at] = 1;
        assert_true(content_hash(bytes, SIZE, 1, 2) != hash);
        bytes[at] = 0;
    }
    bytes[SIZE - 1] = 1;
    assert_true(content_hash(bytes, SIZE, 1, 2) != hash);
    free(bytes);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contents_have_hashes),
        TEST(test_reading),
        TEST(test_reading_without_openat2),
        TEST(test_reading_with_openat2_forbidden),
        TEST(test_socket_and_device),
        TEST(test_second_folder),
        TEST(test_folders_that_cannot_be_allowed),
        TEST(test_folder_named_through_a_link),
        TEST(test_size_limit),
        TEST(test_forbidden),
        TEST(test_resolving),
        TEST(test_resolving_odd_names),
        TEST(test_large_and_empty_files),
        TEST(test_reading_a_pipe),
        TEST(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
