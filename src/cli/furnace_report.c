#include "cli/furnace_report.h"

#include "base/statistics.h"
#include "cli/test_report.h"
#include "scene/json.h"

#include <math.h>
#include <string.h>

static const char *const channel_names[] = {"r", "g", "b"};

// --- Figures -------------------------------------------------------------------------------------

static const double *values_of(const FurnacePoint *point, FurnaceCurve curve)
{
    return curve == CURVE_REFLECTED     ? point->reflected
           : curve == CURVE_TRANSMITTED ? point->transmitted
                                        : point->total;
}

static const double *errors_of(const FurnacePoint *point, FurnaceCurve curve)
{
    return curve == CURVE_REFLECTED     ? point->reflected_error
           : curve == CURVE_TRANSMITTED ? point->transmitted_error
                                        : point->total_error;
}

double furnace_value(const FurnacePoint *point, FurnaceCurve curve, int channel)
{
    return values_of(point, curve)[channel];
}

double furnace_half_width(const FurnacePoint *point, FurnaceCurve curve, int channel)
{
    return student_quantile(1e-3, FURNACE_REPLICATES - 1) * errors_of(point, curve)[channel];
}

bool furnace_is_colored(const FurnaceReport *report)
{
    for (int side = 0; side <= report->both_sides; ++side) {
        for (int i = 0; i < FURNACE_ANGLES; ++i) {
            const double *t = report->sides[side][i].total;
            if (fmax(fabs(t[0] - t[1]), fabs(t[1] - t[2])) > 1e-3) {
                return true;
            }
        }
    }
    return false;
}

bool furnace_transmits(const FurnaceReport *report)
{
    return (report->lobes & (LOBE_TRANSMIT | LOBE_PASS)) != 0;
}

// --- Words ---------------------------------------------------------------------------------------

static void describe_extreme(const FurnaceReport *report, const FurnaceExtreme *extreme, char *text,
                             size_t size)
{
    snprintf(text, size, "%.4f at %.3g degrees%s", extreme->value, extreme->angle * 180 / PI,
             report->both_sides && !extreme->front ? " from behind" : "");
}

void furnace_words(const FurnaceReport *report, FurnaceWords *words)
{
    char most[80], least[80];
    describe_extreme(report, &report->most, most, sizeof most);
    describe_extreme(report, &report->least, least, sizeof least);
    if (report->energy == FURNACE_BROKEN) {
        snprintf(words->energy, sizeof words->energy, "gains: %.2g%% more than falls on it (%s)",
                 100 * (report->most.value - 1), most);
    } else {
        snprintf(words->energy, sizeof words->energy, "kept: at most %s, at least %s", most, least);
    }
    if (report->reciprocity == FURNACE_NOT_ASKED) {
        snprintf(words->reciprocity, sizeof words->reciprocity,
                 "not asked: it scatters in single directions only");
    } else {
        snprintf(words->reciprocity, sizeof words->reciprocity, "%s %.2g, over %d pairs",
                 report->reciprocity == FURNACE_HOLDS ? "holds to" : "broken: off by up to",
                 report->asymmetry, FURNACE_PAIRS);
    }
    if (report->sampling == FURNACE_NOT_ASKED) {
        snprintf(words->sampling, sizeof words->sampling,
                 "not asked: it scatters in single directions only");
    } else {
        snprintf(words->sampling, sizeof words->sampling, "%s (chi-squared, p = %.2g)",
                 report->sampling == FURNACE_HOLDS ? "has the density it says"
                                                   : "doesn't have the density it says",
                 report->sampling_p);
    }
}

bool furnace_is_bad(const FurnaceReport *report)
{
    bool laws = report->energy == FURNACE_BROKEN || report->reciprocity == FURNACE_BROKEN;
    return report->sampling == FURNACE_BROKEN || (laws && !report->caveat);
}

// --- Text ----------------------------------------------------------------------------------------

enum { LABEL_WIDTH = 14, SHOWN_ANGLES = 7 };
static const int shown[SHOWN_ANGLES] = {0, 6, 12, 18, 24, 30, 34}; // 0, 15, … 75, 85 degrees

static void write_row(FILE *out, const FurnacePoint *points, FurnaceCurve curve, int channel,
                      bool colored)
{
    static const char *const names[] = {"reflected", "transmitted", "together"};
    char label[32];
    double widest = 0;
    snprintf(label, sizeof label, "%s%s%s", names[curve], colored ? " " : "",
             colored ? channel_names[channel] : "");
    fprintf(out, "  %-*s", LABEL_WIDTH, label);
    for (int i = 0; i < SHOWN_ANGLES; ++i) {
        const FurnacePoint *point = &points[shown[i]];
        fprintf(out, " %7.4f", furnace_value(point, curve, channel));
        widest = fmax(widest, furnace_half_width(point, curve, channel));
    }
    fprintf(out, "  ± %.1g\n", widest);
}

static void write_side(FILE *out, const FurnaceReport *report, int side)
{
    bool colored = furnace_is_colored(report);
    int last = furnace_transmits(report) ? CURVE_TOTAL : CURVE_REFLECTED;
    fprintf(out, "  %-*s", LABEL_WIDTH,
            report->both_sides ? side ? "from behind" : "from the front" : "degrees");
    for (int i = 0; i < SHOWN_ANGLES; ++i) {
        fprintf(out, " %7.0f", report->sides[side][shown[i]].angle * 180 / PI);
    }
    fputc('\n', out);
    for (int curve = 0; curve <= last; ++curve) {
        for (int channel = 0; channel < (colored ? 3 : 1); ++channel) {
            write_row(out, report->sides[side], (FurnaceCurve)curve, channel, colored);
        }
    }
}

static void write_place(FILE *out, Loading *loading, Span at)
{
    const Source *source = source_get(&loading->lang.sources, at.file);
    Place place = source_place(&loading->lang.sources, at.file, at.begin);
    put_clean(out, str_from(source ? source->path : "?"));
    fprintf(out, ":%u", (unsigned)place.line);
}

void furnace_write_text(FILE *out, Loading *loading, const FurnaceSubject *subject)
{
    const FurnaceReport *report = &subject->report;
    FurnaceWords words;
    put_clean(out, str_from(subject->name));
    fprintf(out, "%s%s (", *subject->name ? ", " : "", subject->kind);
    write_place(out, loading, subject->at);
    fputs(")\n", out);
    for (int side = 0; side <= report->both_sides; ++side) {
        write_side(out, report, side);
    }
    furnace_words(report, &words);
    fprintf(out, "  %-*s %s\n", LABEL_WIDTH, "energy", words.energy);
    fprintf(out, "  %-*s %s\n", LABEL_WIDTH, "reciprocity", words.reciprocity);
    fprintf(out, "  %-*s %s\n", LABEL_WIDTH, "sampling", words.sampling);
    if (report->caveat &&
        (report->energy == FURNACE_BROKEN || report->reciprocity == FURNACE_BROKEN)) {
        fprintf(out, "  %-*s %s\n", LABEL_WIDTH, "", report->caveat);
    }
}

// --- JSON ----------------------------------------------------------------------------------------

static void write_curve(FILE *out, const FurnacePoint *points, const char *key, FurnaceCurve curve,
                        bool error)
{
    fprintf(out, ",\n       \"%s\": [", key);
    for (int i = 0; i < FURNACE_ANGLES; ++i) {
        const double *v = error ? errors_of(&points[i], curve) : values_of(&points[i], curve);
        fputs(i ? ", " : "", out);
        json_vec3(out, vec3(v[0], v[1], v[2]));
    }
    fputc(']', out);
}

static void write_json_side(FILE *out, const FurnaceReport *report, int side)
{
    const FurnacePoint *points = report->sides[side];
    fprintf(out, "%s\n      {\"side\": \"%s\",\n       \"degrees\": [", side ? "," : "",
            !report->both_sides ? "either"
            : side              ? "back"
                                : "front");
    for (int i = 0; i < FURNACE_ANGLES; ++i) {
        fputs(i ? ", " : "", out);
        json_number(out, round(points[i].angle * 180 / PI * 1e6) / 1e6);
    }
    fputc(']', out);
    write_curve(out, points, "reflected", CURVE_REFLECTED, false);
    write_curve(out, points, "reflected_error", CURVE_REFLECTED, true);
    if (furnace_transmits(report)) {
        write_curve(out, points, "transmitted", CURVE_TRANSMITTED, false);
        write_curve(out, points, "transmitted_error", CURVE_TRANSMITTED, true);
        write_curve(out, points, "total", CURVE_TOTAL, false);
        write_curve(out, points, "total_error", CURVE_TOTAL, true);
    }
    fputc('}', out);
}

static void write_json_extreme(FILE *out, const char *key, const FurnaceExtreme *extreme)
{
    fprintf(out, ", \"%s\": {\"value\": ", key);
    json_number(out, extreme->value);
    fputs(", \"error\": ", out);
    json_number(out, extreme->error);
    fputs(", \"degrees\": ", out);
    json_number(out, round(extreme->angle * 180 / PI * 1e6) / 1e6);
    fprintf(out, ", \"side\": \"%s\"}", extreme->front ? "front" : "back");
}

static void write_json_laws(FILE *out, const FurnaceReport *report)
{
    static const char *const verdicts[] = {
        [FURNACE_NOT_ASKED] = "not asked", [FURNACE_HOLDS] = "holds", [FURNACE_BROKEN] = "broken"};
    fprintf(out, ",\n     \"energy\": {\"verdict\": \"%s\"", verdicts[report->energy]);
    write_json_extreme(out, "most", &report->most);
    write_json_extreme(out, "least", &report->least);
    fprintf(out, "},\n     \"reciprocity\": {\"verdict\": \"%s\", \"asymmetry\": ",
            verdicts[report->reciprocity]);
    json_number(out, report->asymmetry);
    fprintf(out,
            "},\n     \"sampling\": {\"verdict\": \"%s\", \"p\": ", verdicts[report->sampling]);
    json_number(out, report->sampling_p);
    fputs("},\n     \"caveat\": ", out);
    json_string(out, report->caveat);
}

static void write_json_subject(FILE *out, Loading *loading, const FurnaceSubject *subject)
{
    const FurnaceReport *report = &subject->report;
    const Source *source = source_get(&loading->lang.sources, subject->at.file);
    Place place = source_place(&loading->lang.sources, subject->at.file, subject->at.begin);
    fputs("\n    {\"name\": ", out);
    json_string(out, subject->name);
    fputs(", \"kind\": ", out);
    json_string(out, subject->kind);
    fputs(", \"file\": ", out);
    json_string(out, source ? source->path : NULL);
    fprintf(out, ", \"line\": %u,\n     \"sides\": [", (unsigned)place.line);
    for (int side = 0; side <= report->both_sides; ++side) {
        write_json_side(out, report, side);
    }
    fputc(']', out);
    write_json_laws(out, report);
    fputc('}', out);
}

void furnace_write_json(FILE *out, Loading *loading, const FurnaceSubjects *subjects)
{
    fputs("{\"materials\": [", out);
    for (size_t i = 0; i < subjects->count; ++i) {
        fputs(i ? "," : "", out);
        write_json_subject(out, loading, &subjects->items[i]);
    }
    fputs("\n]}\n", out);
}
