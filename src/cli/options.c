#include "cli/options.h"

#include "base/number.h"
#include "render/film.h"
#include "watch/tev.h"

#include <errno.h>
#include <limits.h>
#include <stdarg.h>
#include <stdlib.h>
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

enum { CHECKPOINT_SECONDS = 60 };
enum { MOST_THREADS = 4096, LONGEST_SIDE = 1 << 20, FARTHEST_NAME = 3 };

static const int64_t MOST_SAMPLES = INT32_MAX, MOST_MEASURED = INT64_C(1000000000000);
_Static_assert(OPTION_COUNT <= 64 && COMMAND_COUNT <= 32, "a bit each");

// What is being parsed. Lists have room for every argument of the command line.
typedef struct Parser {
    Options *options;
    FILE *err;
    const char **aovs, **folders;
    ParamSetting *settings;
    bool help, version;
} Parser;

static bool wrong(const Parser *parser, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static bool wrong(const Parser *parser, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("scnrender: ", parser->err);
    vfprintf(parser->err, format, arguments);
    fputc('\n', parser->err);
    va_end(arguments);
    return false;
}

// --- Names ---------------------------------------------------------------------------------------

static const char *command_name(size_t i)
{
    return i < COMMAND_COUNT ? command_infos[i].name : NULL;
}

static const char *option_name(size_t i)
{
    return i < OPTION_COUNT ? option_infos[i].name : NULL;
}

static const char *limit_name(size_t i)
{
    static const char *const names[] = {
#define LIMIT(id, value, text) #id,
        LIMITS(LIMIT)
#undef LIMIT
    };
    return i < sizeof names / sizeof names[0] ? names[i] : NULL;
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

// --- Arguments -----------------------------------------------------------------------------------

// A whole number in [min, max] that fills the text up to `end`.
static bool whole_number(const char *text, const char *end, int64_t min, int64_t max,
                         int64_t *number)
{
    char *stop;
    errno = 0;
    long long value = strtoll(text, &stop, 10);
    if (text == end || stop != end || *text == ' ' || *text == '+' || errno == ERANGE ||
        value < min || value > max) {
        return false;
    }
    *number = value;
    return true;
}

static bool take_number(const Parser *parser, OptionId id, const char *text, int64_t min,
                        int64_t max, int64_t *number)
{
    return whole_number(text, text + strlen(text), min, max, number) ||
           wrong(parser, "`--%s` takes a whole number from %lld to %lld, not `%s`",
                 option_infos[id].name, (long long)min, (long long)max, text);
}

static bool take_size(const Parser *parser, OptionId id, const char *text, int *width, int *height)
{
    const char *x = strpbrk(text, "xX");
    int64_t w, h;
    if (!x || !whole_number(text, x, 1, LONGEST_SIDE, &w) ||
        !whole_number(x + 1, text + strlen(text), 1, LONGEST_SIDE, &h)) {
        return wrong(parser, "`--%s` takes a size like %s (sides of 1 to %d), not `%s`",
                     option_infos[id].name, id == OPTION_TILE ? "32x16" : "960x540", LONGEST_SIDE,
                     text);
    }
    *width = (int)w;
    *height = (int)h;
    return true;
}

// "90", "1.5s"
static bool take_seconds(const Parser *parser, OptionId id, const char *text, double *seconds)
{
    double value = 0;
    const char *end = number_parse(text, text + strlen(text), &value);
    if (!end || (*end && strcmp(end, "s") != 0) || !isfinite(value) || !(value > 0)) {
        return wrong(parser, "`--%s` takes a number of seconds greater than 0, not `%s`",
                     option_infos[id].name, text);
    }
    *seconds = value;
    return true;
}

// "0..63": both ends are meant, as in the language.
static bool take_range(const Parser *parser, const char *text)
{
    const char *dots = strstr(text, "..");
    int64_t first, last;
    if (!dots || !whole_number(text, dots, 0, MOST_SAMPLES - 1, &first) ||
        !whole_number(dots + 2, text + strlen(text), 0, MOST_SAMPLES - 1, &last) || first > last) {
        return wrong(parser,
                     "`--sample-range` takes the numbers of the first and the last sample, "
                     "like 64..127, not `%s`",
                     text);
    }
    parser->options->range_first = first;
    parser->options->range_last = last;
    return true;
}

// "1,2.5,-3", perhaps with blanks and in parentheses.
static bool take_point(const Parser *parser, const char *text)
{
    double numbers[3];
    const char *at = text, *end = text + strlen(text);
    bool good = true, open = *at == '(';
    at += open;
    for (int i = 0; good && i < 3; ++i) {
        at += strspn(at, " ");
        at = number_parse(at, end, &numbers[i]);
        good = at && isfinite(numbers[i]);
        if (good) {
            at += strspn(at, " ");
            good = i == 2 || *at++ == ',';
        }
    }
    good = good && (!open || *at++ == ')') && at == end;
    if (!good) {
        return wrong(parser, "`--at` takes a point like 1,2.5,-3, not `%s`", text);
    }
    parser->options->at = vec3(numbers[0], numbers[1], numbers[2]);
    parser->options->has_at = true;
    return true;
}

static bool take_exposure(const Parser *parser, const char *text)
{
    const char *end = number_parse(text, text + strlen(text), &parser->options->exposure);
    if (!end || *end || fabs(parser->options->exposure) > 30) {
        return wrong(parser, "`--exposure` takes stops from -30 to 30, not `%s`", text);
    }
    return true;
}

static bool take_confidence(const Parser *parser, const char *text)
{
    double number;
    const char *end = number_parse(text, text + strlen(text), &number);
    if (!end || *end || !(number >= 0.5 && number < 1)) {
        return wrong(parser, "`--confidence` takes a number from 0.5 to below 1, not `%s`", text);
    }
    parser->options->confidence = number;
    return true;
}

static bool take_setting(const Parser *parser, const char *text)
{
    const char *equals = strchr(text, '=');
    if (!equals || equals == text) {
        return wrong(parser, "`--set` takes NAME=VALUE, not `%s`", text);
    }
    parser->settings[parser->options->setting_count++] = (ParamSetting){
        .name = {text, (size_t)(equals - text)},
        .value = str_from(equals + 1),
    };
    return true;
}

static bool take_limit(const Parser *parser, const char *text)
{
    if (limits_set(&parser->options->limits, str_from(text))) {
        return true;
    }
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)strcspn(text, "="), text);
    const char *near = nearest_name(name, limit_name);
    bool known = near && strcmp(near, name) == 0;
    return known  ? wrong(parser, "`--limit %s=N` takes a whole number, not `%s`", name, text)
           : near ? wrong(parser, "`%s` is not a limit; did you mean `%s`?", name, near)
                  : wrong(parser,
                          "`--limit` takes NAME=N, not `%s`; `scnrender help check` lists "
                          "the names",
                          text);
}

// "albedo,normal"; the names are checked by who knows them.
static bool take_aovs(const Parser *parser, const char *text)
{
    Options *options = parser->options;
    for (;;) {
        size_t length = strcspn(text, ",");
        if (length == 0) {
            return wrong(parser, "`--aov` takes names with commas between them");
        }
        const char *name = arena_copy_string(&options->arena, text, length);
        if (!name) {
            return wrong(parser, "not enough memory");
        }
        parser->aovs[options->aov_count++] = name;
        if (!text[length]) {
            return true;
        }
        text += length + 1;
    }
}

static bool take_word(const Parser *parser, OptionId id, const char *text, const char *const *words,
                      const char *listed, int *number)
{
    for (int i = 0; words[i]; ++i) {
        if (strcmp(words[i], text) == 0) {
            *number = i;
            return true;
        }
    }
    return wrong(parser, "`--%s` takes %s, not `%s`", option_infos[id].name, listed, text);
}

static const char *target_name(size_t i)
{
    return export_targets[i].name;
}

static bool take_target(const Parser *parser, OptionId id, const char *text)
{
    parser->options->target = export_target_find(text);
    if (parser->options->target) {
        return true;
    }
    const char *near = nearest_name(text, target_name);
    if (near) {
        return wrong(parser, "`--%s` doesn't know `%s`; did you mean `%s`?", option_infos[id].name,
                     text, near);
    }
    return wrong(parser, "`--%s` takes povray, blender or json, not `%s`", option_infos[id].name,
                 text);
}

static bool take(Parser *parser, OptionId id, const char *text)
{
    static const char *const stages[] = {"tokens", "ast", "scene", NULL};
    static const char *const forms[] = {"text", "json", NULL};
    static const char *const depths[] = {"8", "16", "32", NULL};
    Options *options = parser->options;
    int64_t number = 0;
    int word = 0;
    bool good = true;
    switch (id) {
    case OPTION_OUTPUT:
        options->output = text;
        return *text || wrong(parser, "`--output` takes the name of a file");
    case OPTION_SAMPLES:
        return take_number(parser, id, text, 1, MOST_MEASURED, &options->samples);
    case OPTION_SIZE:
        return take_size(parser, id, text, &options->width, &options->height);
    case OPTION_TILE:
        return take_size(parser, id, text, &options->tile_width, &options->tile_height);
    case OPTION_TIME_LIMIT:
        return take_seconds(parser, id, text, &options->time_limit);
    case OPTION_CHECKPOINT:
        options->checkpoint = text;
        return *text || wrong(parser, "`--checkpoint` takes the name of a file");
    case OPTION_RESUME:
        options->resume = true;
        return true;
    case OPTION_CHECKPOINT_INTERVAL:
        return take_seconds(parser, id, text, &options->checkpoint_interval);
    case OPTION_SAMPLE_RANGE:
        return take_range(parser, text);
    case OPTION_CAMERA:
        options->camera = text;
        return true;
    case OPTION_SEED:
        return take_number(parser, id, text, 0, INT64_MAX, &options->seed);
    case OPTION_THREADS:
        good = take_number(parser, id, text, 1, MOST_THREADS, &number);
        options->threads = (unsigned)number;
        return good;
    case OPTION_EXPOSURE:
        return take_exposure(parser, text);
    case OPTION_TONE:
        good =
            take_word(parser, id, text, tone_names, "srgb, linear, aces or filmic", &options->tone);
        return good;
    case OPTION_PORT:
        good = take_number(parser, id, text, 0, UINT16_MAX, &number);
        options->port = (uint16_t)number;
        return good;
    case OPTION_TERMINAL:
        options->terminal = text ? text : "";
        return true;
    case OPTION_TEV:
        options->tev = text ? text : TEV_ADDRESS;
        return true;
    case OPTION_POLL:
        options->poll = true;
        return true;
    case OPTION_AT:
        return take_point(parser, text);
    case OPTION_AOV:
        return take_aovs(parser, text);
    case OPTION_BITS:
        good = take_word(parser, id, text, depths, "8, 16 or 32", &word);
        options->bits = 8 << word;
        return good;
    case OPTION_TO:
    case OPTION_FOR:
        return take_target(parser, id, text);
    case OPTION_DUMP:
        good = take_word(parser, id, text, stages, "tokens, ast or scene", &word);
        options->dump = (Dump)(DUMP_TOKENS + word);
        return good;
    case OPTION_CONFIDENCE:
        return take_confidence(parser, text);
    case OPTION_JSON:
        options->json_report = true;
        return true;
    case OPTION_SET:
        return take_setting(parser, text);
    case OPTION_LIMIT:
        return take_limit(parser, text);
    case OPTION_ALLOW_PATH:
        parser->folders[options->folder_count++] = text;
        return true;
    case OPTION_DIAGNOSTICS:
        good = take_word(parser, id, text, forms, "text or json", &word);
        options->json = word == 1;
        return good;
    case OPTION_QUIET:
        options->quiet = true;
        return true;
    case OPTION_CHECK:
        options->check = true;
        return true;
    case OPTION_EXAMPLE:
        options->example = true;
        return true;
    case OPTION_DIFF:
        options->diff = true;
        return true;
    case OPTION_STDIO:
        return true;
    case OPTION_HELP:
        parser->help = true;
        return true;
    case OPTION_VERSION:
        parser->version = true;
        return true;
    case OPTION_COUNT:
        break;
    }
    return false;
}

// --- The line ------------------------------------------------------------------------------------

// "--samples=9": whether the argument stands in the same word; else it is the next one.
static bool parse_long(Parser *parser, char **argv, int argc, int *at, OptionId *id,
                       const char **argument)
{
    const char *name = argv[*at] + 2, *equals = strchr(name, '=');
    size_t length = equals ? (size_t)(equals - name) : strlen(name);
    *id = find_option(name, length);
    if (*id == OPTION_COUNT) {
        char shown[64];
        snprintf(shown, sizeof shown, "%.*s", (int)(length < 60 ? length : 60), name);
        const char *near = nearest_name(shown, option_name);
        return near ? wrong(parser, "there is no option `--%s`; did you mean `--%s`?", shown, near)
                    : wrong(parser, "there is no option `--%s`; see `scnrender --help`", shown);
    }
    bool wants = option_wants_argument(*id);
    if (equals && !*option_infos[*id].argument) {
        return wrong(parser, "`--%s` takes no argument", option_infos[*id].name);
    }
    *argument = equals ? equals + 1 : NULL;
    if (wants && !equals) {
        if (*at + 1 >= argc) {
            return wrong(parser, "`--%s` wants an argument: %s", option_infos[*id].name,
                         option_infos[*id].argument);
        }
        *argument = argv[++*at];
    }
    return true;
}

// "-o x", "-ox", "-qo x"; *letter is the place within the word.
static bool parse_letter(Parser *parser, char **argv, int argc, int *at, const char **letter,
                         OptionId *id, const char **argument)
{
    *id = find_letter(**letter);
    if (*id == OPTION_COUNT) {
        return wrong(parser, "there is no option `-%c`; see `scnrender --help`", **letter);
    }
    ++*letter;
    *argument = NULL;
    if (option_wants_argument(*id)) {
        if (!**letter && *at + 1 >= argc) {
            return wrong(parser, "`-%c` wants an argument: %s", option_infos[*id].letter,
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

static bool parse_words(Parser *parser, int argc, char **argv, Words *words)
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
                !take(parser, id, argument)) {
                return false;
            }
            words->given |= UINT64_C(1) << id;
        } else {
            for (const char *letter = word + 1; *letter;) {
                if (!parse_letter(parser, argv, argc, &at, &letter, &id, &argument) ||
                    !take(parser, id, argument)) {
                    return false;
                }
                words->given |= UINT64_C(1) << id;
            }
        }
    }
    return true;
}

// The first operand may name a command; the others are its own.
static bool choose_command(Parser *parser, Words *words)
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
                   ? wrong(parser, "no scene is named; see `scnrender --help`")
                   : wrong(parser, "`%s` wants an operand: %s", info->name, info->operand);
    }
    if (words->count > info->most) {
        const char *near =
            named == COMMAND_COUNT ? nearest_name(words->operands[0], command_name) : NULL;
        if (near) {
            return wrong(parser, "there is no command `%s`; did you mean `%s`?", words->operands[0],
                         near);
        }
        return wrong(parser, "one operand too many: `%s`", words->operands[info->most]);
    }
    options->operand = words->count > 0 ? words->operands[0] : NULL;
    options->operands = words->operands;
    options->operand_count = (size_t)words->count;
    for (int id = 0; id < OPTION_COUNT; ++id) {
        if (words->given & UINT64_C(1) << id &&
            !(option_infos[id].commands & 1u << options->command)) {
            return wrong(parser, "`%s` doesn't take `--%s`", info->name, option_infos[id].name);
        }
    }
    if (options->samples > MOST_SAMPLES && options->command != COMMAND_TEST) {
        return wrong(parser, "`--samples` takes a whole number from 1 to %lld, not %lld",
                     (long long)MOST_SAMPLES, (long long)options->samples);
    }
    if (options->command == COMMAND_EXPORT && !options->target) {
        return wrong(parser, "`export` wants `--to povray`, `--to blender` or `--to json`");
    }
    return options->command != COMMAND_MERGE || options->output ||
           wrong(parser, "`merge` wants `-o FILE`: where the picture goes");
}

// Options that mean something with others only.
static bool check_together(const Parser *parser, const Words *words)
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
            return wrong(parser, "%s", needs[i].without);
        }
    }
    return true;
}

bool options_parse(Options *options, int argc, char **argv, FILE *err)
{
    *options = (Options){.seed = -1,
                         .exposure = NAN,
                         .tone = -1,
                         .range_last = -1,
                         .checkpoint_interval = CHECKPOINT_SECONDS,
                         .limits = limits_default()};
    size_t most = argc > 0 ? (size_t)argc : 0, aovs = 0;
    for (size_t i = 0; i < most; ++i) { // a list may stand in one word
        for (const char *at = argv[i]; *at; ++at) {
            aovs += *at == ',';
        }
    }
    Parser parser = {.options = options,
                     .err = err,
                     .aovs = arena_array(&options->arena, most + aovs, sizeof *parser.aovs),
                     .folders = arena_array(&options->arena, most, sizeof *parser.folders),
                     .settings = arena_array(&options->arena, most, sizeof *parser.settings)};
    Words words = {.operands = arena_array(&options->arena, most, sizeof *words.operands)};
    if (!parser.aovs || !parser.folders || !parser.settings || !words.operands) {
        return wrong(&parser, "not enough memory");
    }
    options->aovs = parser.aovs;
    options->folders = parser.folders;
    options->settings = parser.settings;
    return parse_words(&parser, argc, argv, &words) && choose_command(&parser, &words) &&
           check_together(&parser, &words);
}

void options_free(Options *options)
{
    arena_free(&options->arena);
}
