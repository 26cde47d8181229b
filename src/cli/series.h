// Many pictures of one scene, one after the other, in a folder: of a sweep, or of a film. Those
// that are there already are left, and whatever ends the series, what is done stays.
#ifndef CLI_SERIES_H
#define CLI_SERIES_H

#include "cli/interrupt.h"
#include "cli/load.h"
#include "cli/record.h"
#include "cli/told.h"

typedef struct Series {
    const Options *options; // of the command line
    size_t count;           // of all pictures
    const char *folder;     // where they lie
    // so far
    size_t number;         // of the picture at hand, from 1
    size_t rendered, kept; // in this run, before it
    // private
    Arena arena;
    Loading loading; // for its sandbox
    Interrupt interrupt;
    Told told;
    RecordChecker checker;
    struct PictureCache *pictures;
    struct MeshCache *meshes;
} Series;

typedef struct SeriesPicture {
    const char *stem;             // of its files' names
    const char *type, *also;      // "png"; and what it is written as, too, without layers, or NULL
    const ParamSetting *settings; // after those of the command line
    size_t setting_count;
    Moment moment;
    bool *moves, *no_such_param; // as in RenderTask
} SeriesPicture;

// `name` without its extension is the folder, which is made where there is none. An ExitCode, after
// a message if it isn't EXIT_OK. series_end in any case.
int series_begin(Series *series, const Options *options, const char *name, size_t count);
// Makes the next picture, or finds it made. EXIT_OK; EXIT_DIAGNOSTICS: it has errors, which were
// told; anything else ends the series, and was told unless it was interrupted (>= EXIT_SIGNAL).
int series_make(Series *series, const SeriesPicture *picture);
// "FOLDER/STEM.TYPE", in the series' arena; NULL without memory.
const char *series_path(Series *series, const char *stem, const char *type);
// True once a signal came: 128 + its number, else 0.
int series_interrupted(const Series *series);
void series_end(Series *series);

// The name of a file beside the scene, of the scene's name and an ending (".sweep.png"), in
// `arena`. NULL after a message: memory ran out.
const char *series_default_name(const Options *options, Arena *arena, const char *ending);

#endif
