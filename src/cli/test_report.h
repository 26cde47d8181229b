// What `scnrender test` says: line by line as a test runner does, or as one JSON object.
#ifndef CLI_TEST_REPORT_H
#define CLI_TEST_REPORT_H

#include "cli/load.h"
#include "render/meter.h"

typedef enum Verdict {
    VERDICT_PASS,
    VERDICT_FAIL,
    VERDICT_UNDECIDED,
    VERDICT_NOT_RUN,
    VERDICT_COUNT
} Verdict;

// What a line of the report is about.
typedef struct TestCase {
    const SceneExpectation *expectation;
    Verdict verdict;
    const MeterResult *measured; // or NULL
    double seconds;              // that measuring took
    bool repeated;               // the same `expect` is measured again, with other values
} TestCase;

typedef struct TestReport {
    FILE *out;
    bool json, quiet, colored;
    bool any_file, any_expectation; // written before
    uint64_t files, verdicts[VERDICT_COUNT];
    uint64_t broken; // files that have errors or can't be read
    double seconds;
} TestReport;

void test_report_begin(TestReport *report, const Options *options, FILE *out);
// What follows is of this file. `error`: why nothing could be tested ("2 errors"); or NULL.
void test_report_file(TestReport *report, const char *shown, const char *error);
void test_report_case(TestReport *report, Loading *loading, const TestCase *test);
void test_report_end(TestReport *report);

// Text from a scene for a terminal: what isn't UTF-8 or would control the terminal becomes U+FFFD.
void put_clean(FILE *out, Str text);

// What was measured, in words: "0.1803 ± 0.0004 (99.9%), 65.5 k samples, 0.2 s", and, where that
// isn't as expected, why not, each on a line of its own.
typedef struct MeasuredText {
    char value[400], wrong[400]; // "": nothing to say
} MeasuredText;
void measured_text(const TestCase *test, MeasuredText *text);

#endif
