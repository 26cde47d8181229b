// Writers of the flat scene for other programs.
//
// What a target can't say is never silent: the writer says it by export_note, with the place in the
// scene and what is written instead, and the list heads the file (where its format has comments).
#ifndef EXPORT_EXPORT_H
#define EXPORT_EXPORT_H

#include "scene/scene.h"

#include <stdio.h>

// What has no exact partner in the target.
typedef struct ExportNote {
    Span at;          // at.file = 0: nowhere in the scene
    const char *text; // one line, in the list's arena
} ExportNote;

typedef struct ExportNotes {
    Arena arena;
    ARRAY(ExportNote) list; // in the order of the scene's text
    bool out_of_memory;
} ExportNotes;

// An export under way, as its writer sees it.
typedef struct Export {
    const Scene *scene;
    Sources *sources;  // may be NULL: then places are not told
    const char *title; // the scene's name, for a comment
    FILE *out;
    ExportNotes *notes; // that were found in a first pass
    bool collecting;    // the first pass: notes are kept, and what is written is thrown away
} Export;

typedef struct ExportTarget {
    const char *name, *program, *extension; // "povray", "POV-Ray 3.7", "pov"
    const char *doc;
    void (*write)(Export *e);
} ExportTarget;

// All targets; one without a name ends them.
extern const ExportTarget export_targets[];
// NULL where there is none of that name.
const ExportTarget *export_target_find(const char *name);

// Finds what the target can't say, writing nothing. False when memory runs out or the throw-away
// file can't be opened. `notes` is empty before, and to be freed with export_notes_free.
bool export_check(const ExportTarget *target, const Scene *scene, Sources *sources,
                  ExportNotes *notes);
// Writes the scene; `notes` are those of export_check. Write errors are left in ferror(out).
void export_write(const ExportTarget *target, const Scene *scene, Sources *sources,
                  const char *title, ExportNotes *notes, FILE *out);
void export_notes_free(ExportNotes *notes);

// --- For the writers -----------------------------------------------------------------------------

// Says what has no partner and what is done instead. Repeated notes are kept once.
void export_note(Export *e, Span at, const char *format, ...) __attribute__((format(printf, 3, 4)));
// "shelf.scn:8", or "" where the place isn't known. A buffer of `size` bytes takes the text.
const char *export_place(const Export *e, Span at, char *buffer, size_t size);
// The notes, a line each, every line begun by `prefix`.
void export_write_notes(const Export *e, const char *prefix);

#endif
