// The language: from a .scn file to a flat scene.
#ifndef LANG_LANG_H
#define LANG_LANG_H

#include "base/array.h"
#include "base/diag.h"
#include "base/io.h"
#include "base/source.h"
#include "scene/scene.h"
#include "schema/schema.h"

#include <stdatomic.h>
#include <stdio.h>

// LIMIT(id, default, text): each can be raised on the command line with --limit id=N. The defaults
// stop a scene that runs away within about a second and 1 GiB.
#define LIMITS(LIMIT)                                                                              \
    LIMIT(nesting, 200, "levels of nested expressions and blocks")                                 \
    LIMIT(call_depth, 1000, "nested function calls")                                               \
    LIMIT(import_depth, 32, "nested imports")                                                      \
    LIMIT(file_bytes, 1 << 30, "bytes of one scene file")                                          \
    LIMIT(list_length, 10000000, "items of one list or range")                                     \
    LIMIT(objects, 10000000, "emitted shapes, lights and instances")                               \
    LIMIT(steps, 10000000, "calls, iterations and emitted items")                                  \
    LIMIT(parts, 10000, "parts of one material or texture")                                        \
    LIMIT(pixels, 1 << 26, "pixels of a picture")                                                  \
    LIMIT(memory, 1 << 30, "bytes of memory of the evaluator")                                     \
    LIMIT(diagnostics, 100, "diagnostics shown")

typedef struct Limits {
#define LIMIT(id, value, text) uint64_t id;
    LIMITS(LIMIT)
#undef LIMIT
} Limits;

Limits limits_default(void);
// "name=N"; false for an unknown name or a bad number.
bool limits_set(Limits *limits, Str assignment);

typedef struct ParamSetting { // --set name=value
    Str name, value;          // value: an expression of literals ("9", "0.2m", "\"text\"", "#fff"),
                              // a bare word is taken as a string
} ParamSetting;

// When a picture is of, where a scene moves.
typedef struct Moment {
    double frame; // a whole number
    double time;  // s
} Moment;

// What a `let` or `param` came to while a scene was evaluated, for editors.
typedef struct Observation {
    Span name;        // where it is declared
    uint32_t times;   // how often it was evaluated: once, but in functions and loops
    bool varies;      // not always to the same value
    const char *type; // in words: "a length"
    const char *text; // the first value, cut to a line: "0.25m", "[1, 2, 3, … 97 more]"
} Observation;

typedef struct Observations {
    ARRAY(Observation) items;
    ARRAY(uint32_t) slots; // hash table by place: index + 1
} Observations;

void observations_free(Observations *observations);

// One run of the language: sources, names, diagnostics. Not for two threads at once, but two may
// run side by side.
typedef struct Lang {
    Arena arena; // names, paths, diagnostics
    Sources sources;
    Interner names;
    DiagSink sink;
    const Schema *schema;
    Sandbox *sandbox;    // not owned
    const char *library; // folder of the standard library; NULL: none. See lang_use_library
    Limits limits;
    const ParamSetting *settings;
    size_t setting_count;
    Moment moment;
    bool moves;     // set by lang_load: some file of the scene names `frame` or `time`
    FILE *print_to; // where print() writes; NULL: nowhere
    // Where lang_load writes the params, too, as lang_params_json does, once their values are
    // known; NULL: nowhere.
    FILE *params_to;
    // What isn't met of what the scene expects is not warned of, and what was never run of it is
    // kept, too.
    bool testing;
    bool bindings; // the materials that the file names are put into the scene, used or not
    // The text that stands for the file at `given_path` (standard input); NULL: none. Not owned.
    const char *given_path;
    Str given_text;
    // More such texts, an editor's open buffers: true, and the text in *text, where one stands for
    // the file at `path` (absolute). It must stay as it is until lang_free. NULL: none.
    bool (*find_given)(void *context, const char *path, Str *text);
    void *find_given_context;
    const atomic_int *stop; // once it isn't zero evaluation ends, unfinished and without a report;
                            // NULL: never
    bool whole; // nothing is evaluated before all of the file was read: for tests, since this only
                // costs time and memory
    unsigned threads;       // that evaluate; 0 and 1: one. More make no difference but to time
    bool walked;            // numbers are computed as all other values are, for tests
    bool aside_always;      // more threads are used wherever they can be, for tests
    size_t stack;           // bytes of its stack that evaluation may use, for tests; 0: nearly all
    Observations *observed; // where values are kept; NULL: nowhere. The texts are the arena's.
    ARRAY(FileBytes) files; // the texts of the sources
} Lang;

bool lang_init(Lang *lang, const Schema *schema, Sandbox *sandbox);
void lang_free(Lang *lang);
// Lets `import "std/…"` find the standard library that came with the program, where there is one,
// and lets the sandbox read it.
IoError lang_use_library(Lang *lang);

// Reads, parses, resolves and evaluates the file at `path` (absolute, inside the sandbox; shown as
// `shown`) into *scene, which the caller has initialised. False when an error was reported; all
// errors that can be found are. Whatever happens, `lang` and `scene` can be freed.
bool lang_load(Lang *lang, const char *path, const char *shown, Scene *scene);
// The same for text in memory, e.g. stdin and tests; `path` is what relative names start from.
bool lang_load_text(Lang *lang, Str text, const char *path, const char *shown, Scene *scene);

// For --dump: the tokens one a line; the AST as S-expressions. False when errors were reported.
bool lang_dump_tokens(Lang *lang, const char *path, const char *shown, FILE *out);
bool lang_dump_ast(Lang *lang, const char *path, const char *shown, FILE *out);

// The declared `param`s of a file as a JSON array of {name, type, default, min, max, description},
// with the values they have under `settings`.
bool lang_params_json(Lang *lang, const char *path, const char *shown, FILE *out);

// The built-in functions, for the manual and for completion.
typedef struct BuiltinInfo {
    const char *name, *signature, *doc;
} BuiltinInfo;
extern const BuiltinInfo *const lang_builtins;
extern const size_t lang_builtin_count;

// Names of numbers: pi, tau, frame and time.
typedef struct ConstantInfo {
    const char *name, *doc;
    Dim dim;
    int moment;   // where it lies in a Moment; -1: it always is `value`
    double value; // in SI
} ConstantInfo;
extern const ConstantInfo lang_constants[];
extern const size_t lang_constant_count;

// The types of params: "int", "length", …
typedef struct ParamTypeName {
    const char *name, *doc;
} ParamTypeName;
extern const ParamTypeName lang_param_types[];
extern const size_t lang_param_type_count;

// The reserved words, in the order of the grammar.
extern const char *const lang_keywords[];
extern const size_t lang_keyword_count;

#endif
