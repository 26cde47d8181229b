// What a run of the language had to say, kept after it: its diagnostics, and the values of lets.
// Passed from the process that evaluates as JSON.
#ifndef LSP_REPORT_H
#define LSP_REPORT_H

#include "base/array.h"
#include "base/diag.h"
#include "lang/lang.h"

#include <cjson/cJSON.h>

// Bytes [begin, end) of the file at `path` (absolute); NULL: nowhere.
typedef struct FilePlace {
    const char *path;
    uint32_t begin, end;
} FilePlace;

typedef struct ReportLink {
    FilePlace at;
    const char *text;
} ReportLink;

typedef struct ReportItem {
    DiagCode code;
    Severity severity;
    FilePlace at, fix_at;
    const char *message, *label, *fix_text; // label and fix_text may be NULL
    const char **notes;
    ReportLink *links; // the chain of calls and imports
    uint32_t note_count, link_count;
    bool gone; // its text was changed meanwhile
} ReportItem;

typedef struct ReportValue {
    FilePlace name;
    uint32_t times;
    bool varies;
    const char *type, *text;
} ReportValue;

// Begin with zeros.
typedef struct Report {
    Arena arena; // strings and lists
    ARRAY(ReportItem) items;
    ARRAY(ReportValue) values;
} Report;

void report_free(Report *report);
// Adds what `lang` reported and observed (may be NULL). False without memory.
bool report_take(Report *report, Lang *lang, const Observations *observed);
// Bytes [begin, end) of a file were replaced by `length` others: places move along; what stood
// there is gone.
void report_edit(Report *report, const char *path, uint32_t begin, uint32_t end, uint32_t length);
// Whether it holds the same diagnostic.
bool report_has(const Report *report, const ReportItem *item);

// What the name at byte `begin` of a file came to, or NULL. In reports that were read.
const ReportValue *report_value(const Report *report, const char *path, uint32_t begin);

cJSON *report_to_json(const Report *report);
// False where it is no report, or without memory; what could be read is in it.
bool report_from_json(Report *report, const cJSON *json);

#endif
