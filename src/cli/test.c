// scnrender test FILE…: runs what scenes expect of themselves.
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/test_report.h"

#include "base/clock.h"
#include "base/mem.h"

#include <errno.h>
#include <fts.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct Testing {
    const Options *options;
    TestReport report;
    Interrupt interrupt;
    int code; // the worst that wasn't a failed expectation
} Testing;

static bool stopped(const Testing *testing)
{
    return atomic_load(&testing->interrupt.signal) != 0;
}

static void keep_worst(Testing *testing, int code)
{
    testing->code = code > testing->code ? code : testing->code;
}

// --- One file ------------------------------------------------------------------------------------

static bool has_measures(const Scene *scene)
{
    for (size_t i = 0; i < scene->expectations.count; ++i) {
        if (scene->expectations.items[i].measure) {
            return true;
        }
    }
    return false;
}

static Meter *new_meter(Testing *testing, Loading *loading)
{
    const Options *options = testing->options;
    MeterOptions meter_options = {.threads = options->threads,
                                  .samples = options->samples,
                                  .seed = options->seed,
                                  .confidence = options->confidence,
                                  .stop = &testing->interrupt.signal};
    return meter_new(&loading->scene, &meter_options, &loading->lang.sink);
}

static bool is_repeated(const SceneExpectationArray *all, size_t i)
{
    Span at = all->items[i].at;
    for (size_t k = i > 0 ? i - 1 : 0; k <= i + 1 && k < all->count; ++k) {
        Span other = all->items[k].at;
        if (k != i && other.file == at.file && other.begin == at.begin) {
            return true;
        }
    }
    return false;
}

// On a terminal, what is being measured; wiped by the next call, of NULL.
static void show_progress(const Testing *testing, Loading *loading,
                          const SceneExpectation *expectation)
{
    if (testing->report.quiet || !isatty(STDERR_FILENO)) {
        return;
    }
    if (expectation) {
        Span at = expectation->at;
        Place place = source_place(&loading->lang.sources, at.file, at.begin);
        fprintf(stderr, "  ....  line %u: measuring", (unsigned)place.line);
    } else {
        fputs("\r\33[K", stderr);
    }
    fflush(stderr);
}

static void test_measured(Testing *testing, Loading *loading, Meter *meter, size_t i)
{
    const SceneExpectation *expectation = &loading->scene.expectations.items[i];
    static const Verdict verdicts[] = {[METER_MET] = VERDICT_PASS,
                                       [METER_NOT_MET] = VERDICT_FAIL,
                                       [METER_UNDECIDED] = VERDICT_UNDECIDED};
    MeterResult result;
    double began = clock_seconds();
    show_progress(testing, loading, expectation);
    bool measured = meter_measure(meter, expectation->measure, &result);
    show_progress(testing, loading, NULL);
    if (!measured) {
        keep_worst(testing, complain(EXIT_NO_MEMORY, "not enough memory to measure"));
    }
    test_report_case(&testing->report, loading,
                     &(TestCase){expectation, verdicts[result.verdict], &result,
                                 clock_seconds() - began,
                                 is_repeated(&loading->scene.expectations, i)});
}

static void test_scene(Testing *testing, Loading *loading, Meter *meter)
{
    const SceneExpectationArray *all = &loading->scene.expectations;
    for (size_t i = 0; i < all->count && !stopped(testing); ++i) {
        const SceneExpectation *expectation = &all->items[i];
        if (expectation->measure) {
            test_measured(testing, loading, meter, i);
            continue;
        }
        Verdict verdict = expectation->fails   ? VERDICT_FAIL
                          : expectation->times ? VERDICT_PASS
                                               : VERDICT_NOT_RUN;
        test_report_case(&testing->report, loading,
                         &(TestCase){.expectation = expectation, .verdict = verdict});
    }
}

// `found`: not named, but found in a folder, where a file without expectations is passed over.
static int test_loaded(Testing *testing, Loading *loading, bool found)
{
    loading->lang.testing = true;
    bool good = loading_evaluate(loading);
    Meter *meter = NULL;
    if (good && has_measures(&loading->scene)) {
        meter = new_meter(testing, loading);
        good = meter != NULL;
    }
    int code = loading_report(loading);
    if (!good) {
        code = code == EXIT_OK ? EXIT_DIAGNOSTICS : code;
        test_report_file(&testing->report, loading->shown, "the scene has errors");
    } else if (loading->scene.expectations.count || !found) {
        test_report_file(&testing->report, loading->shown, NULL);
        test_scene(testing, loading, meter);
    }
    meter_free(meter);
    return code;
}

static void test_file(Testing *testing, const char *name, bool found)
{
    Options options = *testing->options;
    options.operand = name;
    Loading loading;
    int code = loading_begin(&loading, &options);
    if (code != EXIT_OK) {
        test_report_file(&testing->report, name, "the file can't be read");
    } else {
        code = test_loaded(testing, &loading, found);
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
    for (FTSENT *entry; (entry = fts_read(tree)) != NULL && !stopped(testing);) {
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
        keep_worst(testing, complain_no_memory());
    }
    mem_free(copy);
}

static int exit_code(const Testing *testing)
{
    const uint64_t *verdicts = testing->report.verdicts;
    uint64_t bad = verdicts[VERDICT_FAIL] + verdicts[VERDICT_UNDECIDED];
    if (stopped(testing)) {
        return EXIT_SIGNAL + atomic_load(&testing->interrupt.signal);
    }
    if (bad + verdicts[VERDICT_PASS] == 0 && testing->code == EXIT_OK) {
        return complain(EXIT_DIAGNOSTICS, "nothing was tested: no `expect` was run");
    }
    return testing->code == EXIT_OK && bad ? EXIT_DIAGNOSTICS : testing->code;
}

int command_test(const Options *options)
{
    Testing testing = {.options = options};
    double began = clock_seconds();
    test_report_begin(&testing.report, options, stdout);
    interrupt_begin(&testing.interrupt);
    interrupt_heed(&testing.interrupt);
    for (size_t i = 0; i < options->operand_count && !stopped(&testing); ++i) {
        test_operand(&testing, options->operands[i]);
    }
    testing.report.seconds = clock_seconds() - began;
    test_report_end(&testing.report);
    int code = exit_code(&testing);
    interrupt_end(&testing.interrupt);
    return code;
}
