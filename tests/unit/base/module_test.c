#include "../test_support.h"
#include "base/module.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void real_modules_are_loaded(void **state)
{
    (void)state;
    char message[512] = "";
    void *module = module_open("scn_assimp", message, sizeof message);
    if (!module) {
        fail_msg("%s", message);
    }
    assert_non_null(module_symbol(module, "scn_mesh_import"));
    assert_null(module_symbol(module, "scn_no_such_symbol"));
    assert_ptr_equal(module_open("scn_assimp", message, sizeof message), module);
    assert_true(module_exists("scn_assimp"));
}

static void what_is_missing_is_said(void **state)
{
    (void)state;
    char message[1024] = "";
    assert_null(module_open("scn_none", message, sizeof message));
    assert_non_null(strstr(message, "no such module in "));
    assert_non_null(strstr(message, "/../lib/scnrender"));
    char little[8];
    assert_null(module_open("scn_none", little, sizeof little));
    assert_string_equal(little, "no such");
    assert_null(module_open("scn_none", little, 0));
    assert_false(module_exists("scn_none"));
}

// A name is a name, not a path.
static void paths_are_refused(void **state)
{
    (void)state;
    static const char *const names[] = {"", "/etc/passwd", "../scn_assimp", "a/b"};
    for (size_t i = 0; i < TEST_COUNT(names); ++i) {
        char message[64];
        assert_null(module_open(names[i], message, sizeof message));
        assert_string_equal(message, "not the name of a module");
        assert_false(module_exists(names[i]));
    }
}

static void the_variable_comes_first(void **state)
{
    (void)state;
    char folder[] = "/tmp/scn_modules_XXXXXX", path[64], message[512];
    assert_non_null(mkdtemp(folder));
    strcat(strcpy(path, folder), "/scn_broken.so");
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("not a library", file);
    fclose(file);
    char folders[128];
    snprintf(folders, sizeof folders, "/nowhere::%s", folder);
    setenv("SCNRENDER_MODULES", folders, 1);
    assert_null(module_open("scn_broken", message, sizeof message));
    assert_non_null(strstr(message, path)); // the loader's own words name the file
    assert_true(module_exists("scn_broken"));
    assert_non_null(module_open("scn_assimp", message, sizeof message));
    assert_null(module_open("scn_none", message, sizeof message));
    assert_non_null(strstr(message, "/nowhere, "));
    unsetenv("SCNRENDER_MODULES");
    remove(path);
    remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(real_modules_are_loaded),
        cmocka_unit_test(what_is_missing_is_said),
        cmocka_unit_test(paths_are_refused),
        cmocka_unit_test(the_variable_comes_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
