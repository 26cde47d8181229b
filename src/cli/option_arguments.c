#include "cli/option_arguments.h"

#include "base/number.h"
#include "render/film.h"
#include "watch/tev.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_THREADS = 4096, LONGEST_SIDE = 1 << 20 };

static const int64_t MOST_FRAMES = 1000000, LAST_FRAME = 1000000000;
static const int64_t MOST_MEASURED = INT64_C(1000000000000);

bool option_wrong(const OptionParser *parser, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("scnrender: ", parser->err);
    vfprintf(parser->err, format, arguments);
    fputc('\n', parser->err);
    va_end(arguments);
    return false;
}

bool option_out_of_memory(const OptionParser *parser)
{
    parser->options->out_of_memory = true;
    return option_wrong(parser, "not enough memory");
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

static bool take_number(const OptionParser *parser, OptionId id, const char *text, int64_t min,
                        int64_t max, int64_t *number)
{
    return whole_number(text, text + strlen(text), min, max, number) ||
           option_wrong(parser, "`--%s` takes a whole number from %lld to %lld, not `%s`",
                        option_infos[id].name, (long long)min, (long long)max, text);
}

static bool take_size(const OptionParser *parser, OptionId id, const char *text, int *width,
                      int *height)
{
    const char *x = strpbrk(text, "xX");
    int64_t w, h;
    if (!x || !whole_number(text, x, 1, LONGEST_SIDE, &w) ||
        !whole_number(x + 1, text + strlen(text), 1, LONGEST_SIDE, &h)) {
        return option_wrong(parser, "`--%s` takes a size like %s (sides of 1 to %d), not `%s`",
                            option_infos[id].name, id == OPTION_TILE ? "32x16" : "960x540",
                            LONGEST_SIDE, text);
    }
    *width = (int)w;
    *height = (int)h;
    return true;
}

// "90", "1.5s"
static bool take_seconds(const OptionParser *parser, OptionId id, const char *text, double *seconds)
{
    double value = 0;
    const char *end = number_parse(text, text + strlen(text), &value);
    if (!end || (*end && strcmp(end, "s") != 0) || !isfinite(value) || !(value > 0)) {
        return option_wrong(parser, "`--%s` takes a number of seconds greater than 0, not `%s`",
                            option_infos[id].name, text);
    }
    *seconds = value;
    return true;
}

// "0..63": both ends are meant, as in the language.
static bool take_range(const OptionParser *parser, const char *text)
{
    const char *dots = strstr(text, "..");
    int64_t first, last;
    if (!dots || !whole_number(text, dots, 0, MOST_SAMPLES - 1, &first) ||
        !whole_number(dots + 2, text + strlen(text), 0, MOST_SAMPLES - 1, &last) || first > last) {
        return option_wrong(parser,
                            "`--sample-range` takes the numbers of the first and the last sample, "
                            "like 64..127, not `%s`",
                            text);
    }
    parser->options->range_first = first;
    parser->options->range_last = last;
    return true;
}

// "0..99", "0..99:3", or one number.
static bool take_frames(const OptionParser *parser, const char *text)
{
    FrameRange *frames = &parser->options->frames;
    const char *dots = strstr(text, ".."), *end = text + strlen(text);
    const char *colon = dots ? strchr(dots, ':') : NULL;
    *frames = (FrameRange){.step = 1};
    bool good = whole_number(text, dots ? dots : end, -LAST_FRAME, LAST_FRAME, &frames->first);
    frames->last = frames->first;
    if (good && dots) {
        good =
            whole_number(dots + 2, colon ? colon : end, frames->first, LAST_FRAME, &frames->last);
    }
    if (good && colon) {
        good = whole_number(colon + 1, end, 1, LAST_FRAME, &frames->step);
    }
    if (!good) {
        return option_wrong(
            parser,
            "`--frames` takes the numbers of the first and the last frame, like 0..99, or "
            "0..99:5 for every fifth, not `%s`",
            text);
    }
    return (frames->last - frames->first) / frames->step < MOST_FRAMES ||
           option_wrong(parser, "`--frames` takes at most %lld frames", (long long)MOST_FRAMES);
}

static bool take_fps(const OptionParser *parser, const char *text)
{
    double number;
    const char *end = number_parse(text, text + strlen(text), &number);
    if (!end || *end || !(number >= 0.01 && number <= 1000)) {
        return option_wrong(parser, "`--fps` takes frames a second from 0.01 to 1000, not `%s`",
                            text);
    }
    parser->options->fps = number;
    return true;
}

static bool take_sweep(const OptionParser *parser, const char *text)
{
    Options *options = parser->options;
    Sweep *sweep = &parser->sweeps[options->sweep_count];
    char message[300];
    if (!sweep_parse(&options->arena, text, sweep, message, sizeof message)) {
        return option_wrong(parser, "`--sweep %s`: %s", text, message);
    }
    for (size_t i = 0; i < options->sweep_count; ++i) {
        if (strcmp(options->sweeps[i].name, sweep->name) == 0) {
            return option_wrong(parser, "`%s` is swept twice", sweep->name);
        }
    }
    ++options->sweep_count;
    return true;
}

// "1,2.5,-3", perhaps with blanks and in parentheses.
static bool take_point(const OptionParser *parser, const char *text)
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
        return option_wrong(parser, "`--at` takes a point like 1,2.5,-3, not `%s`", text);
    }
    parser->options->at = vec3(numbers[0], numbers[1], numbers[2]);
    parser->options->has_at = true;
    return true;
}

static bool take_exposure(const OptionParser *parser, const char *text)
{
    const char *end = number_parse(text, text + strlen(text), &parser->options->exposure);
    if (!end || *end || fabs(parser->options->exposure) > 30) {
        return option_wrong(parser, "`--exposure` takes stops from -30 to 30, not `%s`", text);
    }
    return true;
}

static bool take_confidence(const OptionParser *parser, const char *text)
{
    double number;
    const char *end = number_parse(text, text + strlen(text), &number);
    if (!end || *end || !(number >= 0.5 && number < 1)) {
        return option_wrong(parser, "`--confidence` takes a number from 0.5 to below 1, not `%s`",
                            text);
    }
    parser->options->confidence = number;
    return true;
}

static bool take_setting(const OptionParser *parser, const char *text)
{
    const char *equals = strchr(text, '=');
    if (!equals || equals == text) {
        return option_wrong(parser, "`--set` takes NAME=VALUE, not `%s`", text);
    }
    parser->settings[parser->options->setting_count++] = (ParamSetting){
        .name = {text, (size_t)(equals - text)},
        .value = str_from(equals + 1),
    };
    return true;
}

static bool take_limit(const OptionParser *parser, const char *text)
{
    if (limits_set(&parser->options->limits, str_from(text))) {
        return true;
    }
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)strcspn(text, "="), text);
    const char *near = nearest_name(name, limit_name);
    bool known = near && strcmp(near, name) == 0;
    return known ? option_wrong(parser, "`--limit %s=N` takes a whole number, not `%s`", name, text)
           : near ? option_wrong(parser, "`%s` is not a limit; did you mean `%s`?", name, near)
                  : option_wrong(parser,
                                 "`--limit` takes NAME=N, not `%s`; `scnrender help check` lists "
                                 "the names",
                                 text);
}

// "albedo,normal"; the names are checked by who knows them.
static bool take_aovs(const OptionParser *parser, const char *text)
{
    Options *options = parser->options;
    for (;;) {
        size_t length = strcspn(text, ",");
        if (length == 0) {
            return option_wrong(parser, "`--aov` takes names with commas between them");
        }
        const char *name = arena_copy_string(&options->arena, text, length);
        if (!name) {
            return option_out_of_memory(parser);
        }
        parser->aovs[options->aov_count++] = name;
        if (!text[length]) {
            return true;
        }
        text += length + 1;
    }
}

static bool take_word(const OptionParser *parser, OptionId id, const char *text,
                      const char *const *words, const char *listed, int *number)
{
    for (int i = 0; words[i]; ++i) {
        if (strcmp(words[i], text) == 0) {
            *number = i;
            return true;
        }
    }
    return option_wrong(parser, "`--%s` takes %s, not `%s`", option_infos[id].name, listed, text);
}

static const char *target_name(size_t i)
{
    return export_targets[i].name;
}

static bool take_target(const OptionParser *parser, OptionId id, const char *text)
{
    parser->options->target = export_target_find(text);
    if (parser->options->target) {
        return true;
    }
    const char *near = nearest_name(text, target_name);
    if (near) {
        return option_wrong(parser, "`--%s` doesn't know `%s`; did you mean `%s`?",
                            option_infos[id].name, text, near);
    }
    return option_wrong(parser, "`--%s` takes povray, blender or json, not `%s`",
                        option_infos[id].name, text);
}

bool option_take(OptionParser *parser, OptionId id, const char *text)
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
        return *text || option_wrong(parser, "`--output` takes the name of a file");
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
        return *text || option_wrong(parser, "`--checkpoint` takes the name of a file");
    case OPTION_RESUME:
        options->resume = true;
        return true;
    case OPTION_CHECKPOINT_INTERVAL:
        return take_seconds(parser, id, text, &options->checkpoint_interval);
    case OPTION_SAMPLE_RANGE:
        return take_range(parser, text);
    case OPTION_SWEEP:
        return take_sweep(parser, text);
    case OPTION_FRAMES:
        return take_frames(parser, text);
    case OPTION_FPS:
        return take_fps(parser, text);
    case OPTION_AGAIN:
        options->again = true;
        return true;
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
