// What `scnrender furnace` found, as a table, as JSON and as a plot.
#ifndef CLI_FURNACE_REPORT_H
#define CLI_FURNACE_REPORT_H

#include "cli/load.h"
#include "render/furnace.h"

// A material, by what it is called: its binding or name, or where it stands.
typedef struct FurnaceSubject {
    const char *name, *kind;
    uint32_t material;
    Span at;
    FurnaceReport report;
} FurnaceSubject;

typedef struct FurnaceSubjects {
    FurnaceSubject *items;
    size_t count;
} FurnaceSubjects;

// The kinds of figures that a side has: what is reflected, what goes through, and both together.
typedef enum FurnaceCurve { CURVE_REFLECTED, CURVE_TRANSMITTED, CURVE_TOTAL } FurnaceCurve;
// Of one channel of a point, and the half width of its interval of 99.9 % confidence.
double furnace_value(const FurnacePoint *point, FurnaceCurve curve, int channel);
double furnace_half_width(const FurnacePoint *point, FurnaceCurve curve, int channel);
// Whether the channels differ by more than their errors.
bool furnace_is_colored(const FurnaceReport *report);
bool furnace_transmits(const FurnaceReport *report);

void furnace_write_text(FILE *out, Loading *loading, const FurnaceSubject *subject);
void furnace_write_json(FILE *out, Loading *loading, const FurnaceSubjects *subjects);
// An SVG picture with a panel for each material, to be read on light and dark pages.
void furnace_write_svg(FILE *out, Loading *loading, const FurnaceSubjects *subjects);

// "energy", "reciprocity", "sampling": a law and what was found, in words.
typedef struct FurnaceWords {
    char energy[200], reciprocity[200], sampling[200];
} FurnaceWords;
void furnace_words(const FurnaceReport *report, FurnaceWords *words);
// A law is broken that the material doesn't say it breaks.
bool furnace_is_bad(const FurnaceReport *report);

#endif
