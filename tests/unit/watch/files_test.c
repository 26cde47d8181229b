// A change of a file is noticed however it is saved, with inotify and without.
#include "watch/files.h"

#include "../test_support.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static char folder[] = "/tmp/scnrender_files.XXXXXX";

static const char *path_of(const char *name)
{
    static char paths[4][200];
    static int turn;
    char *path = paths[turn++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static void put(const char *name, const char *text)
{
    FILE *file = fopen(path_of(name), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void pause_ms(long ms)
{
    nanosleep(&(struct timespec){ms / 1000, ms % 1000 * 1000000}, NULL);
}

static void count_change(void *context)
{
    atomic_fetch_add((atomic_int *)context, 1);
}

static bool happens(atomic_int *changes, int wanted)
{
    for (int i = 0; i < 500 && atomic_load(changes) < wanted; ++i) {
        pause_ms(10);
    }
    return atomic_load(changes) == wanted;
}

static void notices(bool polling)
{
    atomic_int changes = 0;
    FileWatch *watch = file_watch_new(count_change, &changes, polling);
    assert_non_null(watch);
    int wanted = 0;

    put("a.scn", "one");
    put("b.scn", "two");
    file_watch_begin(watch);
    file_watch_add(watch, path_of("a.scn"));
    file_watch_add(watch, path_of("b.scn"));
    file_watch_add(watch, path_of("missing.png"));
    pause_ms(polling ? 300 : 50);
    assert_int_equal(atomic_load(&changes), 0);

    put("b.scn", "written in place"); // and told once, though it goes on
    put("a.scn", "this one, too");
    assert_true(happens(&changes, ++wanted));

    file_watch_begin(watch);
    file_watch_add(watch, path_of("a.scn"));
    put(".a.scn.new", "saved by renaming");
    assert_int_equal(rename(path_of(".a.scn.new"), path_of("a.scn")), 0);
    assert_true(happens(&changes, ++wanted));

    file_watch_begin(watch);
    file_watch_add(watch, path_of("missing.png"));
    put("missing.png", "now it is there");
    assert_true(happens(&changes, ++wanted));

    file_watch_begin(watch);
    file_watch_add(watch, path_of("a.scn"));
    unlink(path_of("a.scn"));
    assert_true(happens(&changes, ++wanted));

    // Another file of the same folder is nobody's business; nor is one of an earlier version.
    file_watch_begin(watch);
    file_watch_add(watch, path_of("b.scn"));
    put("c.scn", "other");
    put("a.scn", "of earlier");
    pause_ms(polling ? 600 : 150);
    assert_int_equal(atomic_load(&changes), wanted);
    file_watch_free(watch);
}

static void is_told_by_inotify(void **state)
{
    (void)state;
    notices(false);
}

static void looks_without_inotify(void **state)
{
    (void)state;
    notices(true);
}

// A file that changes while it is being read has another state than it was added with.
static void a_change_between_adding_and_looking_counts(void **state)
{
    (void)state;
    atomic_int changes = 0;
    FileWatch *watch = file_watch_new(count_change, &changes, false);
    assert_non_null(watch);
    for (int i = 1; i <= 20; ++i) {
        char text[20];
        snprintf(text, sizeof text, "%*d", i % 7 + 1, i);
        file_watch_begin(watch);
        file_watch_add(watch, path_of("a.scn"));
        put("a.scn", text);
        assert_true(happens(&changes, i));
    }
    file_watch_free(watch);
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    static const char *const names[] = {"a.scn", "b.scn", "c.scn", "missing.png"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        unlink(path_of(names[i]));
    }
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(is_told_by_inotify),
        cmocka_unit_test(looks_without_inotify),
        cmocka_unit_test(a_change_between_adding_and_looking_counts),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
