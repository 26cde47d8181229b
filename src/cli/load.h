// A scene on its way from the command line's file to the flat scene, with everything that has to be
// given back; and how its diagnostics are shown.
#ifndef CLI_LOAD_H
#define CLI_LOAD_H

#include "cli/options.h"
#include "lang/lang.h"
#include "scene/scene.h"

typedef struct Loading {
    const Options *options;
    struct Told *told; // diagnostics that aren't shown again; NULL: all are
    Lang lang;
    Scene scene;
    Sandbox sandbox;
    FileBytes text;    // of standard input or a pipe; else empty
    const char *path;  // absolute
    const char *shown; // as the user named it, "<stdin>"
    bool is_text;      // `text` is the scene; there is no file at `path`
    bool has_lang, has_scene;
} Loading;

// Finds the scene that the options name, opens the sandbox for it and prepares `lang` and `scene`.
// EXIT_OK, or an ExitCode after a message. loading_free in any case.
int loading_begin(Loading *loading, const Options *options);
// Evaluates the scene. False when it has errors.
bool loading_evaluate(Loading *loading);
// Writes the diagnostics to standard error, in the form that was asked for, and says how many.
// EXIT_OK, EXIT_DIAGNOSTICS if there was an error, or EXIT_NO_MEMORY.
int loading_report(Loading *loading);
// The same for the diagnostics of any sink.
int report_diagnostics(const Options *options, const DiagSink *sink, Sources *sources);
void loading_free(Loading *loading);
// The same in parts that may be given back at once, by threads: the scene, and all else.
enum { LOADING_PARTS = 2 };
void loading_free_part(Loading *loading, unsigned part);

// A message of the program itself on standard error, "scnrender: …"; returns `code`.
int complain(int code, const char *format, ...) __attribute__((format(printf, 2, 3)));
// That memory ran out; EXIT_NO_MEMORY.
int complain_no_memory(void);

// How much of a file's name stands before its extension: what is made of the scene `a/b.scn` is
// called `a/b` and something else.
size_t stem_length(const char *name);

#endif
