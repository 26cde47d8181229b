// scnrender test FILE…: runs what scenes expect of themselves.
#include "cli/commands.h"
#include "cli/test_report.h"

#include "base/mem.h"

#include <errno.h>
#include <fts.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

typedef struct Testing {
    const Options *options;
    TestReport report;
    int code; // the worst that wasn't a failed expectation
} Testing;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void keep_worst(Testing *testing, int code)
{
    testing->code = code > testing->code ? code : testing->code;
}

// --- One file ------------------------------------------------------------------------------------

static void test_scene(Testing *testing, Loading *loading)
{
    const SceneExpectationArray *all = &loading->scene.expectations;
    for (size_t i = 0; i < all->count; ++i) {
        const SceneExpectation *expectation = &all->items[i];
        Verdict verdict = expectation->fails   ? VERDICT_FAIL
                          : expectation->times ? VERDICT_PASS
                                               : VERDICT_NOT_RUN;
        test_report_expectation(&testing->report, loading, expectation, verdict);
    }
}

// `found`: not named, but found in a folder, where a file without expectations is passed over.
static void test_file(Testing *testing, const char *name, bool found)
{
    Options options = *testing->options;
    options.operand = name;
    Loading loading;
    int code = loading_begin(&loading, &options);
    if (code != EXIT_OK) {
        test_report_file(&testing->report, name, "the file can't be read");
    } else {
        loading.lang.testing = true;
        bool good = loading_evaluate(&loading);
        code = loading_report(&loading);
        if (!good) {
            test_report_file(&testing->report, loading.shown, "the scene has errors");
        } else if (loading.scene.expectations.count || !found) {
            test_report_file(&testing->report, loading.shown, NULL);
            test_scene(testing, &loading);
        }
    }
    keep_worst(testing, code);
    loading_free(&loading);
}

// --- Folders -------------------------------------------------------------------------------------

static int compare_entries(const FTSENT **a, const FTSENT **b)
{
    return strcmp((*a)->fts_name, (*b)->fts_name);
}

static bool is_scene(const FTSENT *entry)
{
    size_t length = entry->fts_namelen;
    return entry->fts_info == FTS_F && length > 4 &&
           strcmp(entry->fts_name + length - 4, ".scn") == 0;
}

// All scenes of a folder and those below it, in the order of their names; links are not followed.
static void test_folder(Testing *testing, char *name)
{
    char *roots[] = {name, NULL};
    FTS *tree = fts_open(roots, FTS_PHYSICAL | FTS_NOCHDIR, compare_entries);
    if (!tree) {
        keep_worst(testing, complain(EXIT_FILES, "can't read `%s`: %s", name, strerror(errno)));
        return;
    }
    for (FTSENT *entry; (entry = fts_read(tree)) != NULL;) {
        bool hidden = entry->fts_level > 0 && entry->fts_name[0] == '.';
        if (hidden && entry->fts_info == FTS_D) {
            fts_set(tree, entry, FTS_SKIP);
        } else if (entry->fts_info == FTS_DNR || entry->fts_info == FTS_ERR) {
            keep_worst(testing, complain(EXIT_FILES, "can't read `%s`: %s", entry->fts_path,
                                         strerror(entry->fts_errno)));
        } else if (!hidden && is_scene(entry)) {
            test_file(testing, entry->fts_path, true);
        }
    }
    fts_close(tree);
}

static void test_operand(Testing *testing, const char *name)
{
    struct stat info;
    if (strcmp(name, "-") == 0 || stat(name, &info) != 0 || !S_ISDIR(info.st_mode)) {
        test_file(testing, name, false);
        return;
    }
    char *copy = mem_alloc_zeroed(strlen(name) + 1, 1);
    if (copy) {
        test_folder(testing, strcpy(copy, name));
    } else {
        keep_worst(testing, complain(EXIT_NO_MEMORY, "not enough memory"));
    }
    mem_free(copy);
}

int command_test(const Options *options)
{
    Testing testing = {.options = options};
    double began = now();
    test_report_begin(&testing.report, options, stdout);
    for (size_t i = 0; i < options->operand_count; ++i) {
        test_operand(&testing, options->operands[i]);
    }
    testing.report.seconds = now() - began;
    test_report_end(&testing.report);
    uint64_t passed = testing.report.verdicts[VERDICT_PASS];
    uint64_t failed = testing.report.verdicts[VERDICT_FAIL];
    if (passed + failed == 0 && testing.code == EXIT_OK) {
        return complain(EXIT_DIAGNOSTICS, "nothing was tested: there is no `expect` in it");
    }
    keep_worst(&testing, failed ? EXIT_DIAGNOSTICS : EXIT_OK);
    return testing.code;
}
