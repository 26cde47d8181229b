// What `scnrender test` says of a measured value.
#include "cli/progress.h"
#include "cli/test_report.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

static const char *const channel_names[] = {"r", "g", "b"};

__attribute__((format(printf, 3, 4))) static void append(char *text, size_t size,
                                                         const char *format, ...)
{
    size_t length = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text + length, size - length, format, arguments);
    va_end(arguments);
}

// "0.1803 ± 0.0004": two digits of the interval's half width, and the mean to the same place.
typedef struct Figure {
    char mean[64], half[64];
} Figure;

static Figure figure(double mean, double half)
{
    Figure text;
    double digits = half > 0 ? 1 - floor(log10(half)) : 0;
    int places = digits < 0 ? 0 : digits > 12 ? 12 : (int)digits;
    snprintf(text.mean, sizeof text.mean, "%.*f", places, mean);
    snprintf(text.half, sizeof text.half, "%.*f", places, half);
    return text;
}

static void append_mean(MeasuredText *text, const MeterResult *result)
{
    Figure figures[3];
    bool same = true;
    for (uint32_t c = 0; c < result->channels; ++c) {
        figures[c] = figure(result->mean[c], result->half[c]);
        same = same && strcmp(figures[c].mean, figures[0].mean) == 0 &&
               strcmp(figures[c].half, figures[0].half) == 0;
    }
    char *to = text->value;
    size_t size = sizeof text->value;
    if (same) {
        append(to, size, "%s ± %s%s", figures[0].mean, figures[0].half,
               result->channels == 3 ? " in r, g and b" : "");
    } else {
        append(to, size, "rgb(%s, %s, %s) ± (%s, %s, %s)", figures[0].mean, figures[1].mean,
               figures[2].mean, figures[0].half, figures[1].half, figures[2].half);
    }
}

static bool is_nowhere(const MeterResult *result)
{
    return result->samples > 0 && isnan(result->mean[0]);
}

static void describe_value(const TestCase *test, MeasuredText *text)
{
    const SceneMeasure *measure = test->expectation->measure;
    const MeterResult *result = test->measured;
    char samples[32], seconds[32];
    count_text((double)result->samples, samples, sizeof samples);
    duration_text(test->seconds, seconds, sizeof seconds);
    text->value[0] = '\0';
    if (measure->what) {
        append(text->value, sizeof text->value, "%s is ", measure->what);
    }
    if (result->samples == 0) {
        append(text->value, sizeof text->value, "not measured");
        return;
    }
    if (is_nowhere(result)) {
        append(text->value, sizeof text->value, "no ray meets it");
    } else {
        append_mean(text, result);
        append(text->value, sizeof text->value, "%s%s (%.6g%% confidence)",
               *measure->unit ? " " : "", measure->unit, 100 * result->confidence);
    }
    append(text->value, sizeof text->value, ", %s samples, %s", samples, seconds);
    if (result->bad_samples > 0) {
        append(text->value, sizeof text->value, "; %llu of them negative or not finite",
               (unsigned long long)result->bad_samples);
    }
}

// The channel that is farthest off, as a multiple of what is allowed.
static uint32_t worst_channel(const SceneMeasure *measure, const MeterResult *result)
{
    uint32_t worst = 0;
    double most = -INFINITY;
    for (uint32_t c = 0; c < result->channels; ++c) {
        double off = result->mean[c] - measure->target[c];
        off = measure->relation == MEASURE_WITHIN  ? fabs(off)
              : measure->relation == MEASURE_BELOW ? off
                                                   : -off;
        if (off > most) {
            most = off;
            worst = c;
        }
    }
    return worst;
}

static void describe_failure(const TestCase *test, MeasuredText *text)
{
    const SceneMeasure *measure = test->expectation->measure;
    const MeterResult *result = test->measured;
    uint32_t c = worst_channel(measure, result);
    const char *subject = result->channels == 3 ? channel_names[c] : "it";
    double off = fabs(result->mean[c] - measure->target[c]);
    char *to = text->wrong;
    size_t size = sizeof text->wrong;
    if (measure->relation != MEASURE_WITHIN) {
        snprintf(to, size, "%s is not %s %.6g%s", subject,
                 measure->relation == MEASURE_BELOW ? "below" : "above", measure->target[c],
                 measure->unit);
    } else if (measure->percentage > 0) {
        double whole = 100 * measure->allowed / measure->percentage;
        snprintf(to, size, "%s is %.3g%% off %.6g%s, and %.3g%% is allowed", subject,
                 100 * off / whole, measure->target[c], measure->unit, measure->percentage);
    } else {
        snprintf(to, size, "%s is %.3g%s off %.6g%s, and %.3g%s is allowed", subject, off,
                 measure->unit, measure->target[c], measure->unit, measure->allowed, measure->unit);
    }
}

// Samples are doubled: the first such number that is likely to do.
static double enough_samples(const MeterResult *result)
{
    double samples = (double)result->samples;
    while (samples < 1.5 * result->needed) {
        samples *= 2;
    }
    return samples;
}

static void describe_doubt(const TestCase *test, MeasuredText *text)
{
    static const double WORTH_SAYING = 1e13;
    const MeterResult *result = test->measured;
    char needed[32];
    count_text(result->needed, needed, sizeof needed);
    const char *why = result->stopped      ? "interrupted before it could be told"
                      : is_nowhere(result) ? "there is nothing to judge"
                                           : NULL;
    if (why) {
        snprintf(text->wrong, sizeof text->wrong, "%s", why);
    } else if (result->needed < WORTH_SAYING) {
        snprintf(text->wrong, sizeof text->wrong,
                 "too uncertain to tell: about %s samples would decide (--samples %.0f)", needed,
                 enough_samples(result));
    } else {
        snprintf(text->wrong, sizeof text->wrong, "it lies too near to the limit to tell");
    }
}

void measured_text(const TestCase *test, MeasuredText *text)
{
    text->wrong[0] = '\0';
    describe_value(test, text);
    if (test->verdict == VERDICT_FAIL) {
        describe_failure(test, text);
    } else if (test->verdict == VERDICT_UNDECIDED) {
        describe_doubt(test, text);
    }
}
