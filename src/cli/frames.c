#include "cli/frames.h"

#include "cli/film_file.h"
#include "cli/series.h"
#include "image/image.h"

#include <string.h>

enum { FEWEST_DIGITS = 4, STEM_SIZE = 24 };

typedef struct Frames {
    const Options *options;
    Series series;
    const char *output;
    bool film;
    const char *type; // of the pictures
    int digits;       // of their numbers
    size_t count;
} Frames;

static int64_t number_of(const Frames *frames, size_t i)
{
    return frames->options->frames.first + (int64_t)i * frames->options->frames.step;
}

static void stem_of(const Frames *frames, size_t i, char stem[STEM_SIZE])
{
    snprintf(stem, STEM_SIZE, "%0*lld", frames->digits, (long long)number_of(frames, i));
}

static int digits_of(int64_t number)
{
    char text[STEM_SIZE];
    return snprintf(text, sizeof text, "%lld", (long long)number);
}

// --- Before --------------------------------------------------------------------------------------

static int choose_output(Frames *frames, Arena *arena)
{
    const Options *options = frames->options;
    frames->output =
        options->output ? options->output : series_default_name(options, arena, ".frames.png");
    if (!frames->output) {
        return EXIT_NO_MEMORY;
    }
    frames->film = film_file_is(frames->output);
    const char *dot = strrchr(frames->output, '.');
    frames->type = frames->film || !dot ? "png" : dot + 1;
    if (!frames->film && !image_can_write(frames->output)) {
        return complain(EXIT_USAGE, "`%s` is neither of a picture's type (%s) nor of a film's (%s)",
                        frames->output, image_extensions(), film_file_extensions());
    }
    return frames->film ? film_file_check(frames->output) : EXIT_OK;
}

static void count_frames(Frames *frames)
{
    const FrameRange *range = &frames->options->frames;
    frames->count = (size_t)((range->last - range->first) / range->step) + 1;
    const int first = digits_of(range->first), last = digits_of(range->last);
    frames->digits = first > last ? first : last;
    frames->digits = frames->digits < FEWEST_DIGITS ? FEWEST_DIGITS : frames->digits;
}

// --- Pictures ------------------------------------------------------------------------------------

static int make_picture(Frames *frames, size_t i)
{
    char stem[STEM_SIZE];
    const double frame = (double)number_of(frames, i);
    bool moves = true;
    stem_of(frames, i, stem);
    const SeriesPicture picture = {.stem = stem,
                                   .type = frames->type,
                                   .moment = {frame, frame / frames->options->fps},
                                   .moves = &moves};
    const int code = series_make(&frames->series, &picture);
    if (code == EXIT_OK && i == 0 && !moves && frames->count > 1 && !frames->options->quiet) {
        complain(EXIT_OK, "the scene names neither `frame` nor `time`: all pictures will be alike");
    }
    return code == EXIT_DIAGNOSTICS
               ? complain(code, "frame %lld can't be rendered", (long long)frame)
               : code;
}

static int make_pictures(Frames *frames)
{
    int code = EXIT_OK;
    for (size_t i = 0; code == EXIT_OK && i < frames->count; ++i) {
        code = make_picture(frames, i);
    }
    return code;
}

// --- The film ------------------------------------------------------------------------------------

static const char *picture_name(void *context, size_t i)
{
    Frames *frames = context;
    char stem[STEM_SIZE];
    stem_of(frames, i, stem);
    return series_path(&frames->series, stem, frames->type);
}

static int film_stopped(void *context)
{
    const Frames *frames = context;
    return series_interrupted(&frames->series);
}

static int make_film(Frames *frames)
{
    const FilmFile film = {.path = frames->output,
                           .rate = frames->options->fps / (double)frames->options->frames.step,
                           .count = frames->count,
                           .picture = picture_name,
                           .stopped = film_stopped,
                           .context = frames};
    const int code = film_file_write(&film);
    if (code == EXIT_OK && !frames->options->quiet) {
        fprintf(stderr, "%s: %zu pictures, %.4g s\n", film.path, film.count,
                (double)film.count / film.rate);
    }
    return code;
}

// --- All -----------------------------------------------------------------------------------------

static void say_what_is_there(const Frames *frames, int code)
{
    const Series *series = &frames->series;
    const size_t done = series->rendered + series->kept;
    if (code >= EXIT_SIGNAL) {
        complain(code, "interrupted; `%s` has %zu of %zu pictures; the same command goes on",
                 series->folder, done, frames->count);
    } else if (code == EXIT_OK && !frames->options->quiet) {
        fprintf(stderr, "%s: %zu picture%s, %zu of them rendered now\n", series->folder, done,
                done == 1 ? "" : "s", series->rendered);
    }
}

static int run(Frames *frames)
{
    int code = series_begin(&frames->series, frames->options, frames->output, frames->count);
    if (code != EXIT_OK) {
        return code;
    }
    code = make_pictures(frames);
    say_what_is_there(frames, code);
    if (code == EXIT_OK && frames->film) {
        code = make_film(frames);
        if (code >= EXIT_SIGNAL) {
            complain(code, "interrupted; the pictures are there, the film isn't made");
        }
    }
    return code;
}

int frames_render(const Options *options)
{
    Frames frames = {.options = options};
    Arena arena = {0};
    int code = choose_output(&frames, &arena);
    if (code == EXIT_OK) {
        count_frames(&frames);
        code = run(&frames);
        series_end(&frames.series);
    }
    arena_free(&arena);
    return code;
}
