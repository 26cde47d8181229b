#include "cli/test_report.h"

#include "base/utf8.h"
#include "scene/json.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TEXT_COLUMN = 18, LONGEST_SOURCE = 160 };

static const char *const verdict_names[VERDICT_COUNT] = {"pass", "fail", "undecided", "not run"};
static const char *const verdict_words[VERDICT_COUNT] = {"pass", "FAIL", "????", "----"};
static const char *const verdict_colors[VERDICT_COUNT] = {"\33[32m", "\33[1;31m", "\33[1;33m",
                                                          "\33[33m"};

void test_report_begin(TestReport *report, const Options *options, FILE *out)
{
    const char *no_color = getenv("NO_COLOR"), *term = getenv("TERM");
    bool plain = (no_color && *no_color) || (term && strcmp(term, "dumb") == 0);
    *report = (TestReport){.out = out,
                           .json = options->json_report,
                           .quiet = options->quiet,
                           .colored = !plain && isatty(fileno(out))};
    if (report->json) {
        fputs("{\"files\": [", out);
    }
}

// --- Text ----------------------------------------------------------------------------------------

void put_clean(FILE *out, Str text)
{
    for (size_t i = 0; i < text.length;) {
        uint32_t code;
        int length = utf8_decode(text.at + i, text.at + text.length, &code);
        if (code == UTF8_INVALID || utf8_is_control(code)) {
            fputs("\xef\xbf\xbd", out);
        } else {
            fwrite(text.at + i, 1, (size_t)length, out);
        }
        i += (size_t)length;
    }
}

// The source of an expectation on one line, cut where it is long.
static Str source_text(Loading *loading, Span at)
{
    const Source *source = source_get(&loading->lang.sources, at.file);
    size_t most = at.end - at.begin;
    char *copy = arena_alloc(&loading->lang.arena, most + 4);
    size_t length = 0;
    for (uint32_t i = at.begin; copy && i < at.end && length < LONGEST_SOURCE; ++i) {
        char c = source->text.at[i];
        bool blank = c == ' ' || c == '\t' || c == '\r' || c == '\n';
        if (!blank || (length && copy[length - 1] != ' ')) {
            copy[length++] = blank ? ' ' : c;
        }
    }
    if (length == LONGEST_SOURCE) {
        while (length > 0 && ((unsigned char)copy[length - 1] & 0xc0) == 0x80) {
            --length;
        }
        memcpy(copy + length - 1, "…", 3);
        length += 2;
    }
    return copy ? (Str){copy, length} : (Str){"", 0};
}

static const char *file_of(const Loading *loading, Span at)
{
    const Source *source = source_get(&loading->lang.sources, at.file);
    return source ? source->path : "?";
}

static void put_line(const TestReport *report, const char *text)
{
    fprintf(report->out, "%*s", TEXT_COLUMN, "");
    put_clean(report->out, str_from(text));
    fputc('\n', report->out);
}

// "line 12", or "lib/shelf.scn:4" for an expectation of an imported function.
static void put_place(const TestReport *report, Loading *loading, Span at)
{
    Place place = source_place(&loading->lang.sources, at.file, at.begin);
    const char *file = file_of(loading, at);
    if (strcmp(file, loading->shown) == 0) {
        fprintf(report->out, "line %-4u ", (unsigned)place.line);
    } else {
        put_clean(report->out, str_from(file));
        fprintf(report->out, ":%u  ", (unsigned)place.line);
    }
}

static void put_times(const TestReport *report, const SceneExpectation *expectation)
{
    if (expectation->times > 1 && expectation->fails) {
        fprintf(report->out, "  (%llu of %llu times; the first:)",
                (unsigned long long)expectation->fails, (unsigned long long)expectation->times);
    } else if (expectation->times == 0) {
        fputs("  (never run)", report->out);
    } else if (expectation->times > 1) {
        fprintf(report->out, "  (%llu times)", (unsigned long long)expectation->times);
    }
}

static void put_part(FILE *out, const ExpectationPart *part)
{
    put_clean(out, str_from(part->text));
    fputs(" is ", out);
    put_clean(out, str_from(part->value));
}

static void put_parts(const TestReport *report, const SceneExpectation *expectation)
{
    for (uint32_t i = 0; i < expectation->part_count; ++i) {
        fprintf(report->out, "%*s", TEXT_COLUMN, "");
        put_part(report->out, &expectation->parts[i]);
        fputc('\n', report->out);
    }
}

static void put_parts_in_a_row(const TestReport *report, const SceneExpectation *expectation)
{
    for (uint32_t i = 0; i < expectation->part_count; ++i) {
        fprintf(report->out, "%*s", i ? 0 : TEXT_COLUMN, "");
        put_part(report->out, &expectation->parts[i]);
        fputs(i + 1 < expectation->part_count ? ", " : "\n", report->out);
    }
}

static void write_text(const TestReport *report, Loading *loading, const TestCase *test)
{
    FILE *out = report->out;
    const SceneExpectation *expectation = test->expectation;
    fprintf(out, "  %s%s%s  ", report->colored ? verdict_colors[test->verdict] : "",
            verdict_words[test->verdict], report->colored ? "\33[0m" : "");
    put_place(report, loading, expectation->at);
    put_clean(out, source_text(loading, expectation->at));
    put_times(report, expectation);
    fputc('\n', out);
    if (test->measured) {
        MeasuredText text;
        measured_text(test, &text);
        put_line(report, text.value);
        if (*text.wrong) {
            put_line(report, text.wrong);
        }
    } else if (expectation->fails) {
        put_line(report, expectation->wrong);
    }
    if (test->verdict != VERDICT_PASS) {
        put_parts(report, expectation);
    } else if (test->repeated) {
        put_parts_in_a_row(report, expectation);
    }
}

// --- JSON ----------------------------------------------------------------------------------------

static void write_json_text(FILE *out, Loading *loading, Str text)
{
    const char *copy = arena_copy_string(&loading->lang.arena, text.at, text.length);
    json_string(out, copy ? copy : "");
}

// A number, or [r, g, b].
static void write_json_channels(FILE *out, const double *values, uint32_t channels)
{
    if (channels == 1) {
        json_number(out, values[0]);
    } else {
        json_vec3(out, vec3(values[0], values[1], values[2]));
    }
}

static void write_json_measured(FILE *out, const TestCase *test)
{
    static const char *const relations[] = {
        [MEASURE_WITHIN] = "within", [MEASURE_BELOW] = "below", [MEASURE_ABOVE] = "above"};
    const SceneMeasure *measure = test->expectation->measure;
    const MeterResult *result = test->measured;
    fputs(", \"measured\": ", out);
    write_json_channels(out, result->mean, result->channels);
    fputs(", \"half_width\": ", out);
    write_json_channels(out, result->half, result->channels);
    fputs(", \"confidence\": ", out);
    json_number(out, result->confidence);
    fprintf(out, ", \"relation\": \"%s\", \"target\": ", relations[measure->relation]);
    write_json_channels(out, measure->target, result->channels);
    if (measure->relation == MEASURE_WITHIN) {
        fputs(", \"tolerance\": ", out);
        json_number(out, measure->allowed);
    }
    fprintf(out, ", \"unit\": \"%s\", \"samples\": %llu, \"bad_samples\": %llu", measure->unit,
            (unsigned long long)result->samples, (unsigned long long)result->bad_samples);
    if (test->verdict == VERDICT_UNDECIDED && isfinite(result->needed)) {
        fputs(", \"needed\": ", out);
        json_number(out, round(result->needed));
    }
    fputs(", \"seconds\": ", out);
    json_number(out, test->seconds);
}

static void write_json_parts(FILE *out, const SceneExpectation *expectation)
{
    fputs(", \"values\": {", out);
    for (uint32_t i = 0; i < expectation->part_count; ++i) {
        fputs(i ? ", " : "", out);
        json_string(out, expectation->parts[i].text);
        fputs(": ", out);
        json_string(out, expectation->parts[i].value);
    }
    fputc('}', out);
}

static void write_json(const TestReport *report, Loading *loading, const TestCase *test)
{
    FILE *out = report->out;
    const SceneExpectation *expectation = test->expectation;
    Place place = source_place(&loading->lang.sources, expectation->at.file, expectation->at.begin);
    fputs(report->any_expectation ? ",\n    {" : "\n    {", out);
    json_key(out, "file");
    json_string(out, file_of(loading, expectation->at));
    fprintf(out, ", \"line\": %u, \"column\": %u, ", (unsigned)place.line, (unsigned)place.column);
    json_key(out, "text");
    write_json_text(out, loading, source_text(loading, expectation->at));
    fprintf(out, ", \"verdict\": \"%s\", \"times\": %llu", verdict_names[test->verdict],
            (unsigned long long)expectation->times);
    if (test->measured) {
        write_json_measured(out, test);
    } else {
        fprintf(out, ", \"fails\": %llu", (unsigned long long)expectation->fails);
    }
    if (expectation->fails) {
        fputs(", \"wrong\": ", out);
        json_string(out, expectation->wrong);
    }
    if (expectation->part_count) {
        write_json_parts(out, expectation);
    }
    fputc('}', out);
}

// --- Together ------------------------------------------------------------------------------------

static void end_file(TestReport *report)
{
    if (report->json && report->any_file) {
        fputs(report->any_expectation ? "\n  ]}" : "]}", report->out);
    }
    report->any_expectation = false;
}

void test_report_file(TestReport *report, const char *shown, const char *error)
{
    end_file(report);
    ++report->files;
    report->broken += error != NULL;
    if (report->json) {
        fputs(report->any_file ? ",\n  {" : "\n  {", report->out);
        json_key(report->out, "file");
        json_string(report->out, shown);
        fputs(", \"error\": ", report->out);
        json_string(report->out, error);
        fputs(", \"expectations\": [", report->out);
    } else if (error || !report->quiet) {
        put_clean(report->out, str_from(shown));
        fprintf(report->out, "%s%s\n", error ? ": can't be tested: " : "", error ? error : "");
    }
    report->any_file = true;
    fflush(report->out);
}

void test_report_case(TestReport *report, Loading *loading, const TestCase *test)
{
    bool good = test->verdict == VERDICT_PASS || test->verdict == VERDICT_NOT_RUN;
    ++report->verdicts[test->verdict];
    if (report->json) {
        write_json(report, loading, test);
    } else if (!good || !report->quiet) {
        if (report->quiet) {
            put_clean(report->out, str_from(loading->shown));
            fputs(":\n", report->out);
        }
        write_text(report, loading, test);
    }
    report->any_expectation = true;
    fflush(report->out);
}

static void write_count(FILE *out, uint64_t count, const char *what)
{
    fprintf(out, "%llu %s%s", (unsigned long long)count, what, count == 1 ? "" : "s");
}

void test_report_end(TestReport *report)
{
    FILE *out = report->out;
    const uint64_t *verdicts = report->verdicts;
    unsigned long long passed = verdicts[VERDICT_PASS], failed = verdicts[VERDICT_FAIL];
    unsigned long long undecided = verdicts[VERDICT_UNDECIDED], unrun = verdicts[VERDICT_NOT_RUN];
    end_file(report);
    if (report->json) {
        fprintf(out,
                "\n], \"passed\": %llu, \"failed\": %llu, \"undecided\": %llu, "
                "\"not_run\": %llu, \"broken_files\": %llu}\n",
                passed, failed, undecided, unrun, (unsigned long long)report->broken);
        return;
    }
    if (report->quiet) {
        return;
    }
    fputs(report->any_file ? "\n" : "", out);
    write_count(out, passed + failed + undecided + unrun, "expectation");
    fputs(" in ", out);
    write_count(out, report->files, "file");
    fprintf(out, ": %llu passed, %llu failed", passed, failed);
    if (undecided) {
        fprintf(out, ", %llu undecided", undecided);
    }
    if (unrun) {
        fprintf(out, ", %llu never run", unrun);
    }
    if (report->broken) {
        fputs("; ", out);
        write_count(out, report->broken, "file");
        fputs(" couldn't be tested", out);
    }
    fprintf(out, " (%.1f s)\n", report->seconds);
}
