// Files that appear whole or not at all.
#include "base/io.h"
#include "base/mem.h"

#include <dirent.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

typedef struct Place {
    char base[64], path[128];
    Arena arena;
} Place;

static int set_up(void **state)
{
    Place *place = calloc(1, sizeof *place);
    strcpy(place->base, "/tmp/scn_atomic_XXXXXX");
    assert_non_null(mkdtemp(place->base));
    snprintf(place->path, sizeof place->path, "%s/out.txt", place->base);
    *state = place;
    return 0;
}

static int tear_down(void **state)
{
    Place *place = *state;
    char *command = arena_printf(&place->arena, "rm -rf '%s'", place->base);
    assert_int_equal(system(command), 0);
    arena_free(&place->arena);
    free(place);
    return 0;
}

static int file_count(const char *folder)
{
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(directory));) {
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    }
    closedir(directory);
    return count;
}

static void check_content(const char *path, const char *expected)
{
    FileBytes bytes;
    assert_int_equal(file_read(path, 1 << 20, &bytes), IO_OK);
    assert_string_equal(bytes.bytes, expected);
    file_bytes_free(&bytes);
}

static void replace(const char *path, const char *text)
{
    AtomicFile file;
    char error[256] = "";
    assert_true(atomic_file_open(&file, path, error, sizeof error));
    fputs(text, file.stream);
    if (!atomic_file_commit(&file, error, sizeof error)) {
        fail_msg("%s", error);
    }
}

static void test_replacing(void **state)
{
    Place *place = *state;
    replace(place->path, "first");
    check_content(place->path, "first");
    AtomicFile file;
    char error[256];
    assert_true(atomic_file_open(&file, place->path, error, sizeof error));
    fputs("second", file.stream);
    fflush(file.stream);
    check_content(place->path, "first"); // until it is committed
    assert_int_equal(file_count(place->base), file.nameless ? 1 : 2);
    assert_true(atomic_file_commit(&file, error, sizeof error));
    check_content(place->path, "second");
    assert_int_equal(file_count(place->base), 1);
}

static void test_abandoning(void **state)
{
    Place *place = *state;
    replace(place->path, "old");
    AtomicFile file;
    char error[256];
    assert_true(atomic_file_open(&file, place->path, error, sizeof error));
    fputs("new", file.stream);
    atomic_file_abandon(&file);
    check_content(place->path, "old");
    assert_int_equal(file_count(place->base), 1);
}

static void test_permissions_and_umask(void **state)
{
    Place *place = *state;
    mode_t before = umask(027);
    replace(place->path, "a");
    struct stat info;
    assert_int_equal(stat(place->path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0640);
    assert_int_equal(chmod(place->path, 0604), 0);
    replace(place->path, "b");
    assert_int_equal(stat(place->path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0604);
    umask(before);
}

static void test_link_stays(void **state)
{
    Place *place = *state;
    char *folder = arena_printf(&place->arena, "%s/real", place->base);
    char *link = arena_printf(&place->arena, "%s/link", place->base);
    assert_int_equal(mkdir(folder, 0755), 0);
    assert_int_equal(symlink("real/target", link), 0);
    for (int round = 0; round < 2; ++round) { // dangling first
        replace(link, round ? "again" : "once");
        struct stat info;
        assert_int_equal(lstat(link, &info), 0);
        assert_true(S_ISLNK(info.st_mode));
        check_content(arena_printf(&place->arena, "%s/real/target", place->base),
                      round ? "again" : "once");
        assert_int_equal(file_count(folder), 1);
    }
}

static void check_refused(Place *place, const char *path, const char *why)
{
    AtomicFile file;
    char error[256] = "";
    assert_false(atomic_file_open(&file, path, error, sizeof error));
    assert_non_null(strstr(error, why));
    error[0] = '\0';
    assert_null(atomic_temporary_name(&place->arena, path, error, sizeof error));
    assert_non_null(strstr(error, why));
}

static void test_what_is_refused(void **state)
{
    Place *place = *state;
    check_refused(place, place->base, "Is a directory");
    check_refused(place, "/dev/null", "not a regular file");
    check_refused(place, "", "No such file");
    check_refused(place, arena_printf(&place->arena, "%s/none/out.txt", place->base),
                  "No such file");
    char *loop = arena_printf(&place->arena, "%s/loop", place->base);
    assert_int_equal(symlink("loop", loop), 0);
    check_refused(place, loop, "symbolic links");
    char *fifo = arena_printf(&place->arena, "%s/fifo", place->base);
    assert_int_equal(mkfifo(fifo, 0644), 0);
    check_refused(place, fifo, "not a regular file");
    char *longest = arena_alloc(&place->arena, 8000);
    memset(longest, 'x', 7999);
    longest[7999] = '\0';
    check_refused(place, longest, "name too long");
    assert_int_equal(file_count(place->base), 2);
}

static void test_longest_name(void **state)
{
    Place *place = *state;
    char name[256];
    memset(name, 'n', 255);
    name[255] = '\0';
    char *path = arena_printf(&place->arena, "%s/%s", place->base, name);
    replace(path, "text");
    check_content(path, "text");
    assert_int_equal(file_count(place->base), 1);
}

// Every length at which the disk may be full, with small writes and with one large one.
static void test_failing_writes(void **state)
{
    Place *place = *state;
    replace(place->path, "old");
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit before, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    static const rlim_t room[] = {0, 1, 4095, 4096, 4097, 9999};
    for (size_t i = 0; i < sizeof room / sizeof room[0]; ++i) {
        for (int large = 0; large < 2; ++large) {
            AtomicFile file;
            char error[256] = "";
            assert_true(atomic_file_open(&file, place->path, error, sizeof error));
            small = (struct rlimit){room[i], before.rlim_max};
            assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
            static char text[10000];
            for (size_t k = 0; k < sizeof text; k += large ? sizeof text : 100) {
                fwrite(text, large ? sizeof text : 100, 1, file.stream);
            }
            bool committed = atomic_file_commit(&file, error, sizeof error);
            assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
            assert_false(committed);
            assert_non_null(strstr(error, "can't write"));
            check_content(place->path, "old");
            assert_int_equal(file_count(place->base), 1);
        }
    }
}

static void test_with_a_name(void **state)
{
    Place *place = *state;
    replace(place->path, "old");
    char error[256] = "";
    char *name = atomic_temporary_name(&place->arena, place->path, error, sizeof error);
    assert_non_null(name);
    FILE *file = fopen(name, "w");
    fputs("new", file);
    fclose(file);
    check_content(place->path, "old");
    assert_true(atomic_rename(name, place->path, error, sizeof error));
    check_content(place->path, "new");
    name = atomic_temporary_name(&place->arena, place->path, error, sizeof error);
    atomic_discard(name);
    assert_int_equal(file_count(place->base), 1);
    name = atomic_temporary_name(&place->arena, place->path, error, sizeof error);
    unlink(name); // the writer took it away
    assert_false(atomic_rename(name, place->path, error, sizeof error));
    check_content(place->path, "new");
    assert_int_equal(file_count(place->base), 1);
}

static void test_no_memory(void **state)
{
    Place *place = *state;
    for (uint64_t after = 0; after < 2; ++after) {
        AtomicFile file;
        char error[256] = "";
        mem_fail_after(after);
        bool opened = atomic_file_open(&file, place->path, error, sizeof error);
        mem_fail_after(UINT64_MAX);
        assert_false(opened);
        assert_int_equal(file_count(place->base), 0);
    }
    char error[256] = "";
    Arena full = {0};
    mem_fail_after(0);
    char *name = atomic_temporary_name(&full, place->path, error, sizeof error);
    mem_fail_after(UINT64_MAX);
    assert_null(name);
    assert_int_equal(file_count(place->base), 0);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(test_replacing),      TEST(test_abandoning),      TEST(test_permissions_and_umask),
        TEST(test_link_stays),     TEST(test_what_is_refused), TEST(test_longest_name),
        TEST(test_failing_writes), TEST(test_with_a_name),     TEST(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
