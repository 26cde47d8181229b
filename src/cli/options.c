#include "cli/option_arguments.h"

#include <math.h>
#include <string.h>

#define ON(command) (1u << COMMAND_##command)
#define ON_ALL      (~0u)
#define ON_PICTURES (ON(RENDER) | ON(WATCH))
#define ON_SCENES                                                                                  \
    (ON(RENDER) | ON(WATCH) | ON(CHECK) | ON(TEST) | ON(FURNACE) | ON(LIGHTS) | ON(PARAMS) |       \
     ON(EXPORT))

const CommandInfo command_infos[COMMAND_COUNT] = {
#define COMMAND(id, name, operand, fewest, most, text)                                             \
    [COMMAND_##id] = {name, operand, fewest, most, text},
#include "cli/options.def"
};

const OptionInfo option_infos[OPTION_COUNT] = {
#define OPTION(id, letter, name, argument, commands, text)                                         \
    [OPTION_##id] = {letter, name, argument, commands, text},
#include "cli/options.def"
};

enum { CHECKPOINT_SECONDS = 60, FRAMES_A_SECOND = 24, FARTHEST_NAME = 3 };

_Static_assert(OPTION_COUNT <= 64 && COMMAND_COUNT <= 32, "a bit each");

// --- Names ---------------------------------------------------------------------------------------

static const char *command_name(size_t i)
{
    return i < COMMAND_COUNT ? command_infos[i].name : NULL;
}

static const char *option_name(size_t i)
{
    return i < OPTION_COUNT ? option_infos[i].name : NULL;
}

const char *nearest_name(const char *name, const char *(*name_of)(size_t i))
{
    size_t nearest = strlen(name) / 3 + 1;
    nearest = nearest < FARTHEST_NAME ? nearest : FARTHEST_NAME;
    const char *found = NULL;
    for (size_t i = 0; name_of(i); ++i) {
        size_t distance = str_distance(str_from(name), str_from(name_of(i)), nearest);
        if (distance <= nearest && (!found || distance < nearest)) {
            nearest = distance;
            found = name_of(i);
        }
    }
    return found;
}

Command command_find(const char *name)
{
    int i = 0;
    while (i < COMMAND_COUNT && strcmp(command_infos[i].name, name) != 0) {
        ++i;
    }
    return (Command)i;
}

// The option called by `length` characters of a name; OPTION_COUNT where there is none.
static OptionId find_option(const char *name, size_t length)
{
    int i = 0;
    while (i < OPTION_COUNT && !str_equal(str_from(option_infos[i].name), (Str){name, length})) {
        ++i;
    }
    return (OptionId)i;
}

static OptionId find_letter(char letter)
{
    int i = 0;
    while (i < OPTION_COUNT && option_infos[i].letter != letter) {
        ++i;
    }
    return (OptionId)i;
}

// --- The line ------------------------------------------------------------------------------------

// "--samples=9": whether the argument stands in the same word; else it is the next one.
static bool parse_long(OptionParser *parser, char **argv, int argc, int *at, OptionId *id,
                       const char **argument)
{
    const char *name = argv[*at] + 2, *equals = strchr(name, '=');
    size_t length = equals ? (size_t)(equals - name) : strlen(name);
    *id = find_option(name, length);
    if (*id == OPTION_COUNT) {
        char shown[64];
        snprintf(shown, sizeof shown, "%.*s", (int)(length < 60 ? length : 60), name);
        const char *near = nearest_name(shown, option_name);
        return near ? option_wrong(parser, "there is no option `--%s`; did you mean `--%s`?", shown,
                                   near)
                    : option_wrong(parser, "there is no option `--%s`; see `scnrender --help`",
                                   shown);
    }
    bool wants = option_wants_argument(*id);
    if (equals && !*option_infos[*id].argument) {
        return option_wrong(parser, "`--%s` takes no argument", option_infos[*id].name);
    }
    *argument = equals ? equals + 1 : NULL;
    if (wants && !equals) {
        if (*at + 1 >= argc) {
            return option_wrong(parser, "`--%s` wants an argument: %s", option_infos[*id].name,
                                option_infos[*id].argument);
        }
        *argument = argv[++*at];
    }
    return true;
}

// "-o x", "-ox", "-qo x"; *letter is the place within the word.
static bool parse_letter(OptionParser *parser, char **argv, int argc, int *at, const char **letter,
                         OptionId *id, const char **argument)
{
    *id = find_letter(**letter);
    if (*id == OPTION_COUNT) {
        return option_wrong(parser, "there is no option `-%c`; see `scnrender --help`", **letter);
    }
    ++*letter;
    *argument = NULL;
    if (option_wants_argument(*id)) {
        if (!**letter && *at + 1 >= argc) {
            return option_wrong(parser, "`-%c` wants an argument: %s", option_infos[*id].letter,
                                option_infos[*id].argument);
        }
        *argument = **letter ? *letter : argv[++*at];
        *letter = "";
    }
    return true;
}

typedef struct Words {
    const char **operands;
    int count;
    uint64_t given; // bit of each option
} Words;

static bool parse_words(OptionParser *parser, int argc, char **argv, Words *words)
{
    bool only_operands = false;
    for (int at = 1; at < argc; ++at) {
        const char *word = argv[at], *argument = NULL;
        OptionId id;
        if (only_operands || word[0] != '-' || strcmp(word, "-") == 0) {
            words->operands[words->count++] = word;
        } else if (strcmp(word, "--") == 0) {
            only_operands = true;
        } else if (word[1] == '-') {
            if (!parse_long(parser, argv, argc, &at, &id, &argument) ||
                !option_take(parser, id, argument)) {
                return false;
            }
            words->given |= UINT64_C(1) << id;
        } else {
            for (const char *letter = word + 1; *letter;) {
                if (!parse_letter(parser, argv, argc, &at, &letter, &id, &argument) ||
                    !option_take(parser, id, argument)) {
                    return false;
                }
                words->given |= UINT64_C(1) << id;
            }
        }
    }
    return true;
}

// The first operand may name a command; the others are its own.
static bool choose_command(OptionParser *parser, Words *words)
{
    Options *options = parser->options;
    options->command = COMMAND_RENDER;
    Command named = words->count > 0 ? command_find(words->operands[0]) : COMMAND_COUNT;
    if (named != COMMAND_COUNT) {
        options->command = named;
        ++words->operands;
        --words->count;
    }
    if (parser->version) {
        options->command = COMMAND_VERSION;
        return true;
    }
    if (parser->help) {
        options->operand = named == COMMAND_COUNT ? NULL : command_infos[named].name;
        options->command = COMMAND_HELP;
        return true;
    }
    const CommandInfo *info = &command_infos[options->command];
    if (words->count < info->fewest) {
        return named == COMMAND_COUNT
                   ? option_wrong(parser, "no scene is named; see `scnrender --help`")
                   : option_wrong(parser, "`%s` wants an operand: %s", info->name, info->operand);
    }
    if (words->count > info->most) {
        const char *near =
            named == COMMAND_COUNT ? nearest_name(words->operands[0], command_name) : NULL;
        if (near) {
            return option_wrong(parser, "there is no command `%s`; did you mean `%s`?",
                                words->operands[0], near);
        }
        return option_wrong(parser, "one operand too many: `%s`", words->operands[info->most]);
    }
    options->operand = words->count > 0 ? words->operands[0] : NULL;
    options->operands = words->operands;
    options->operand_count = (size_t)words->count;
    for (int id = 0; id < OPTION_COUNT; ++id) {
        if (words->given & UINT64_C(1) << id &&
            !(option_infos[id].commands & 1u << options->command)) {
            return option_wrong(parser, "`%s` doesn't take `--%s`", info->name,
                                option_infos[id].name);
        }
    }
    if (options->samples > MOST_SAMPLES && options->command != COMMAND_TEST) {
        return option_wrong(parser, "`--samples` takes a whole number from 1 to %lld, not %lld",
                            (long long)MOST_SAMPLES, (long long)options->samples);
    }
    if (options->command == COMMAND_EXPORT && !options->target) {
        return option_wrong(parser, "`export` wants `--to povray`, `--to blender` or `--to json`");
    }
    return options->command != COMMAND_MERGE || options->output ||
           option_wrong(parser, "`merge` wants `-o FILE`: where the picture goes");
}

// What is said of one picture can't be said of many.
static bool check_series(const OptionParser *parser, const Words *words)
{
    static const OptionId of_one[] = {OPTION_CHECKPOINT, OPTION_SAMPLE_RANGE, OPTION_DUMP};
    const Options *options = parser->options;
    const bool film = options->frames.step != 0, sheet = options->sweep_count > 0;
    if (film && sheet) {
        return option_wrong(parser, "either `--frames` or `--sweep`");
    }
    if (!film && words->given & UINT64_C(1) << OPTION_FPS) {
        return option_wrong(parser, "`--fps` wants `--frames A..B`");
    }
    if (!film && !sheet && options->again) {
        return option_wrong(parser, "`--again` wants `--frames` or `--sweep`");
    }
    for (size_t i = 0; (film || sheet) && i < sizeof of_one / sizeof of_one[0]; ++i) {
        if (words->given & UINT64_C(1) << of_one[i]) {
            return option_wrong(parser, "`--%s` is for one picture, not for `--%s`",
                                option_infos[of_one[i]].name, film ? "frames" : "sweep");
        }
    }
    return true;
}

// Options that mean something with others only.
static bool check_together(const OptionParser *parser, const Words *words)
{
    static const struct {
        OptionId given;
        const char *without;
    } needs[] = {
        {OPTION_RESUME, "`--resume` wants `--checkpoint FILE`: what to go on from"},
        {OPTION_CHECKPOINT_INTERVAL, "`--checkpoint-interval` wants `--checkpoint FILE`"},
        {OPTION_SAMPLE_RANGE,
         "`--sample-range` wants `--checkpoint FILE`: where the part is kept for `merge`"},
    };
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        if (words->given & UINT64_C(1) << needs[i].given && !parser->options->checkpoint) {
            return option_wrong(parser, "%s", needs[i].without);
        }
    }
    return check_series(parser, words);
}

bool options_parse(Options *options, int argc, char **argv, FILE *err)
{
    *options = (Options){.seed = -1,
                         .exposure = NAN,
                         .tone = -1,
                         .range_last = -1,
                         .checkpoint_interval = CHECKPOINT_SECONDS,
                         .fps = FRAMES_A_SECOND,
                         .limits = limits_default()};
    size_t most = argc > 0 ? (size_t)argc : 0, aovs = 0;
    for (size_t i = 0; i < most; ++i) { // a list may stand in one word
        for (const char *at = argv[i]; *at; ++at) {
            aovs += *at == ',';
        }
    }
    OptionParser parser = {.options = options,
                           .err = err,
                           .aovs = arena_array(&options->arena, most + aovs, sizeof *parser.aovs),
                           .folders = arena_array(&options->arena, most, sizeof *parser.folders),
                           .settings = arena_array(&options->arena, most, sizeof *parser.settings),
                           .sweeps = arena_array(&options->arena, most, sizeof *parser.sweeps)};
    Words words = {.operands = arena_array(&options->arena, most, sizeof *words.operands)};
    if (!parser.aovs || !parser.folders || !parser.settings || !parser.sweeps || !words.operands) {
        return option_out_of_memory(&parser);
    }
    options->aovs = parser.aovs;
    options->folders = parser.folders;
    options->settings = parser.settings;
    options->sweeps = parser.sweeps;
    return parse_words(&parser, argc, argv, &words) && choose_command(&parser, &words) &&
           check_together(&parser, &words);
}

void options_free(Options *options)
{
    arena_free(&options->arena);
}
