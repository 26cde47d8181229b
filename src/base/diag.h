// Diagnostics: what a user is told, and where.
//
//   error[E0301]: `roughnes` is not a field of `burley`
//     --> shelf.scn:8:47
//      |
//    8 |   base: burley { color: srgb(0.6, 0.1, 0.1), roughnes: 0.7 } }
//      |                                              ^^^^^^^^ did you mean `roughness`?
//      = note: burley takes color, roughness
//
// Every code stands once in diag_codes.def, with the paragraph and the example that
// `scnrender explain CODE` shows.
#ifndef BASE_DIAG_H
#define BASE_DIAG_H

#include "base/arena.h"
#include "base/source.h"

#include <stdbool.h>
#include <stdio.h>

typedef enum Severity { SEVERITY_NOTE, SEVERITY_WARNING, SEVERITY_ERROR } Severity;

// DIAG(code, severity, title, paragraph, example): a DiagCode for each row.
typedef enum DiagCode {
#define DIAG(code, severity, title, paragraph, example) code,
#include "base/diag_codes.def"
#undef DIAG
    DIAG_CODE_COUNT
} DiagCode;

typedef struct DiagInfo {
    const char *name; // "E0301"
    Severity severity;
    const char *title, *paragraph, *example;
} DiagInfo;

// One link of the chain that led to a diagnostic: "in the call of `lamp`" at a place.
typedef struct DiagFrame {
    Span at;
    const char *text;
    struct DiagFrame *next; // outwards
} DiagFrame;

typedef struct DiagNote {
    const char *text;
    struct DiagNote *next;
} DiagNote;

typedef struct Diag {
    DiagCode code;
    Severity severity;
    Span at;             // at.file = 0: nowhere in a source
    const char *message; // the headline
    const char *label;   // under the carets; may be NULL
    DiagNote *notes;     // in order
    DiagFrame *frames;   // innermost first
    Span fix_at;         // a change that would mend it, for editors; fix_text = NULL: none
    const char *fix_text;
} Diag;

// Collects the diagnostics of a run. All strings are copied into its arena.
typedef struct DiagSink {
    Arena *arena;
    Diag *items;
    uint32_t count, capacity;
    uint32_t errors, warnings;
    uint32_t dropped;   // beyond the limit
    uint32_t limit;     // most diagnostics kept
    bool out_of_memory; // a diagnostic could not be kept for want of memory
    // A chain put on every diagnostic that is reported while it is set (the evaluator's call
    // stack).
    DiagFrame *frames;
    uint32_t *slots; // hash table of kept diagnostics by code and span: index + 1, 0 = free
    uint32_t slot_mask;
    Diag spare; // handed out where a diagnostic isn't kept
} DiagSink;

enum { DIAG_DEFAULT_LIMIT = 100 };

void diag_sink_init(DiagSink *sink, Arena *arena);
void diag_sink_free(DiagSink *sink);

// Adds a diagnostic and returns it, to be given a label, notes or a fix. Never returns NULL: past
// the limit, or without memory, it is a spare one that is not kept (but still counted); but past
// the limit an error takes the place of a warning while there is one. The pointer
// is good until the next diag_report. A second diagnostic with the same code and span is dropped
// and not counted. None of these functions uses the arena's jump.
Diag *diag_report(DiagSink *sink, DiagCode code, Span at, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
// What was reported since a mark is forgotten by diag_rewind.
typedef struct DiagMark {
    uint32_t count, errors, warnings, dropped;
    bool out_of_memory;
} DiagMark;
DiagMark diag_mark(const DiagSink *sink);
bool diag_is_since(const DiagSink *sink, DiagMark mark); // whether anything was
void diag_rewind(DiagSink *sink, DiagMark mark);
// False for the spare one: then finding out what to suggest is lost time. (A mebibyte can hold half
// a million errors.)
bool diag_is_kept(const DiagSink *sink, const Diag *diag);
void diag_label(DiagSink *sink, Diag *diag, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void diag_note(DiagSink *sink, Diag *diag, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
// "did you mean `text`?" (or "remove it", for no text) as the label unless there is one, and as a
// fix that replaces span `at`.
void diag_suggest(DiagSink *sink, Diag *diag, Span at, const char *text);
void diag_frame(DiagSink *sink, Diag *diag, Span at, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

const DiagInfo *diag_info(DiagCode code);
// By name ("E0301", any case); DIAG_CODE_COUNT where there is none.
DiagCode diag_find(Str name);

typedef enum DiagColor { DIAG_PLAIN, DIAG_COLORED } DiagColor;

// Writes all diagnostics, sorted by file and place; errors and warnings in the order of the source.
// Tabs are expanded to stops of 4, bytes that aren't UTF-8 and control characters (also those that
// would turn the direction of the text) are shown as U+FFFD, and of a long line only the part
// around the span is shown.
void diag_write_text(const DiagSink *sink, Sources *sources, FILE *out, DiagColor color);
// One JSON object a line: {"code","severity","message","label","file","line","column","end_line",
// "end_column","begin","end","notes":[…],"chain":[{"file","line","column","text"}],"fix":{…}}.
// Where memory ran out, an E0001 without a place ends both.
void diag_write_json(const DiagSink *sink, Sources *sources, FILE *out);

#endif
