// The command line, parsed.
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include "base/arena.h"
#include "base/vec.h"
#include "cli/sweep_values.h"
#include "export/export.h"
#include "lang/lang.h"

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef enum ExitCode {
    EXIT_OK = 0,
    EXIT_DIAGNOSTICS = 1, // the scene has errors
    EXIT_USAGE = 2,
    EXIT_FILES = 3, // a file can't be read or written
    EXIT_NO_MEMORY = 4,
    EXIT_SIGNAL = 128, // + the signal that ended rendering early
} ExitCode;

typedef enum Command {
#define COMMAND(id, name, operand, fewest, most, text) COMMAND_##id,
#include "cli/options.def"
    COMMAND_COUNT
} Command;

typedef enum OptionId {
#define OPTION(id, letter, name, argument, commands, text) OPTION_##id,
#include "cli/options.def"
    OPTION_COUNT
} OptionId;

typedef enum Dump { DUMP_NOTHING, DUMP_TOKENS, DUMP_AST, DUMP_SCENE } Dump;

// --frames first..last:step
typedef struct FrameRange {
    int64_t first, last;
    int64_t step; // > 0; 0: there is none
} FrameRange;

typedef struct Options {
    Arena arena;        // lists below
    bool out_of_memory; // so options_parse failed
    Command command;
    const char *operand; // the first, or NULL
    const char *const *operands;
    size_t operand_count;
    const char *output, *camera;
    int64_t samples, seed;           // 0, -1: the scene's
    int width, height;               // 0: the scene's
    unsigned threads;                // 0: one a processor
    int bits;                        // 0: the type's
    int tile_width, tile_height;     // 0: the renderer's own
    double time_limit;               // seconds; 0: none
    const char *checkpoint;          // or NULL
    double checkpoint_interval;      // seconds
    int64_t range_first, range_last; // --sample-range; last < 0: none
    const Sweep *sweeps;
    size_t sweep_count;
    FrameRange frames;
    double fps;      // --fps, of --frames
    bool again;      // --again
    double exposure; // stops; NAN: the scene's
    int tone;        // ToneCurve; -1: the scene's
    Dump dump;
    bool json, quiet, has_at, resume;
    bool check, diff;           // of fmt
    uint16_t port;              // of watch; 0: any
    bool poll;                  // of watch
    const char *terminal;       // of watch: "" or how to draw; NULL: a page is wanted
    const char *tev;            // of watch: HOST:PORT; NULL: no tev
    bool json_report;           // --json
    double confidence;          // of test; 0: the scene's
    bool example;               // of explain
    Vec3 at;                    // --at
    const ExportTarget *target; // --to, --for; or NULL
    const char *const *aovs;    // names
    size_t aov_count;
    const ParamSetting *settings;
    size_t setting_count;
    const char *const *folders; // --allow-path
    size_t folder_count;
    Limits limits;
} Options;

// Parses the command line into *options, to be freed with options_free whatever happens. False
// after a message on `err`: a wrong use. Strings point into argv.
bool options_parse(Options *options, int argc, char **argv, FILE *err);
void options_free(Options *options);

typedef struct CommandInfo {
    const char *name, *operand;
    int fewest, most;
    const char *text;
} CommandInfo;
extern const CommandInfo command_infos[COMMAND_COUNT];

typedef struct OptionInfo {
    char letter;
    const char *name, *argument;
    unsigned commands; // bit of each Command that takes it
    const char *text;
} OptionInfo;
extern const OptionInfo option_infos[OPTION_COUNT];

// Does the option want an argument? One in brackets may be left out, and is given as
// --option=argument only.
static inline bool option_wants_argument(OptionId id)
{
    return *option_infos[id].argument && *option_infos[id].argument != '[';
}

// COMMAND_COUNT where there is none of that name.
Command command_find(const char *name);
// The nearest name of a list, for "did you mean"; NULL where none is near. name_of(i) is NULL at
// the end.
const char *nearest_name(const char *name, const char *(*name_of)(size_t i));

#endif
