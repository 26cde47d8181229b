#include "cli/sweep.h"

#include "base/clock.h"
#include "base/mem.h"
#include "cli/series.h"
#include "cli/sheet.h"
#include "image/image.h"

#include <math.h>
#include <string.h>
#include <xxhash.h>

enum { MOST_CELLS = 10000, MOST_SWEEPS = 64, LONGEST_STEM = 120, STEM_SIZE = LONGEST_STEM + 24 };

// How often the sheet is put on the disk before all of it is done.
static const double SHEET_SECONDS = 15;

typedef struct SweepRun {
    const Options *options;
    Arena arena;
    Series series;
    const char *output;
    size_t count; // of pictures
    SheetCell *cells;
    size_t failed;
    double sheet_at; // when the sheet is due, s
} SweepRun;

// --- Before --------------------------------------------------------------------------------------

static int choose_output(SweepRun *run)
{
    const Options *options = run->options;
    run->output =
        options->output ? options->output : series_default_name(options, &run->arena, ".sweep.png");
    if (!run->output) {
        return EXIT_NO_MEMORY;
    }
    if (!image_can_write(run->output)) {
        return complain(EXIT_USAGE, "`%s` is not of a type that can be written: %s", run->output,
                        image_extensions());
    }
    return image_is_linear(run->output, 0)
               ? complain(EXIT_USAGE,
                          "the sheet is a picture for display, like sheet.png; each picture's EXR "
                          "stands in the folder beside it")
               : EXIT_OK;
}

static int count_cells(SweepRun *run)
{
    const Options *options = run->options;
    if (options->sweep_count > MOST_SWEEPS) {
        return complain(EXIT_USAGE, "more than %d sweeps", MOST_SWEEPS);
    }
    run->count = 1;
    for (size_t i = 0; i < options->sweep_count; ++i) {
        const Sweep *sweep = &options->sweeps[i];
        for (size_t k = 0; k < options->setting_count; ++k) {
            if (str_equal(options->settings[k].name, str_from(sweep->name))) {
                return complain(EXIT_USAGE, "`%s` is both set and swept", sweep->name);
            }
        }
        run->count *= sweep->count; // both at most 10,000
        if (run->count > MOST_CELLS) {
            return complain(EXIT_USAGE, "more than %d pictures", MOST_CELLS);
        }
    }
    run->cells = arena_array(&run->arena, run->count, sizeof *run->cells);
    for (size_t i = 0; run->cells && i < run->count; ++i) {
        run->cells[i] = (SheetCell){NULL, "not rendered"};
    }
    return run->cells ? EXIT_OK : complain_no_memory();
}

// --- One picture ---------------------------------------------------------------------------------

static size_t value_of(const SweepRun *run, size_t cell, size_t sweep)
{
    for (size_t i = 0; i < sweep; ++i) {
        cell /= run->options->sweeps[i].count;
    }
    return cell % run->options->sweeps[sweep].count;
}

static bool is_plain(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           (c && strchr("._-+=,#", c));
}

// "alpha=0.05,ior=1.3": named after its values, so that a sweep of more values finds what is there.
// What a name had better not hold is replaced, and where that could make two alike, a hash is
// added.
static void stem_of(const SweepRun *run, size_t cell, char stem[STEM_SIZE])
{
    const Options *options = run->options;
    size_t length = 0;
    bool changed = false;
    uint64_t hash = 0;
    for (size_t i = 0; i < options->sweep_count; ++i) {
        const Sweep *sweep = &options->sweeps[i];
        const char *value = sweep->values[value_of(run, cell, i)];
        const char *const parts[] = {i ? "," : "", sweep->name, "=", value};
        hash = XXH3_64bits_withSeed(value, strlen(value), hash);
        for (size_t p = 0; p < 4; ++p) {
            for (const char *at = parts[p]; *at; ++at) {
                changed |= length == LONGEST_STEM || !is_plain(*at) || (p == 3 && *at == ',');
                if (length < LONGEST_STEM) {
                    stem[length++] = is_plain(*at) ? *at : '_';
                }
            }
        }
    }
    stem[length] = '\0';
    if (changed) {
        snprintf(stem + length, STEM_SIZE - length, "-%08x", (unsigned)(hash >> 32));
    }
}

static void say_failed(const SweepRun *run, size_t cell)
{
    fputs("scnrender: there is no picture for", stderr);
    for (size_t i = 0; i < run->options->sweep_count; ++i) {
        const Sweep *sweep = &run->options->sweeps[i];
        fprintf(stderr, "%s %s = %s", i ? "," : "", sweep->name,
                sweep->values[value_of(run, cell, i)]);
    }
    fputc('\n', stderr);
}

static int make_cell(SweepRun *run, size_t cell)
{
    const Options *options = run->options;
    ParamSetting settings[MOST_SWEEPS];
    char stem[STEM_SIZE];
    bool no_such_param = false;
    for (size_t i = 0; i < options->sweep_count; ++i) {
        const Sweep *sweep = &options->sweeps[i];
        settings[i] =
            (ParamSetting){str_from(sweep->name), str_from(sweep->values[value_of(run, cell, i)])};
    }
    stem_of(run, cell, stem);
    const SeriesPicture picture = {.stem = stem,
                                   .type = "exr",
                                   .also = "png",
                                   .settings = settings,
                                   .setting_count = options->sweep_count,
                                   .no_such_param = &no_such_param};
    const int code = series_make(&run->series, &picture);
    if (code == EXIT_OK) {
        const char *name = series_path(&run->series, stem, "png");
        run->cells[cell].picture = name;
        return name ? EXIT_OK : complain_no_memory();
    }
    if (code != EXIT_DIAGNOSTICS || no_such_param) {
        return code;
    }
    run->cells[cell].why = "has errors";
    ++run->failed;
    say_failed(run, cell);
    return EXIT_OK;
}

// --- The sheet -----------------------------------------------------------------------------------

// "shelf.scn", with what was set besides: "shelf.scn  count=9".
static const char *title(SweepRun *run)
{
    const Options *options = run->options;
    const char *slash = strrchr(options->operand, '/');
    const char *text = slash ? slash + 1 : options->operand;
    for (size_t i = 0; text && i < options->setting_count; ++i) {
        const ParamSetting *setting = &options->settings[i];
        text = arena_printf(&run->arena, "%s  %.*s=%.*s", text, (int)setting->name.length,
                            setting->name.at, (int)setting->value.length, setting->value.at);
    }
    return text;
}

static bool any_picture(const SweepRun *run)
{
    bool any = false;
    for (size_t i = 0; i < run->count; ++i) {
        any |= run->cells[i].picture != NULL;
    }
    return any;
}

static int write_sheet(SweepRun *run)
{
    const Sheet sheet = {.title = title(run),
                         .sweeps = run->options->sweeps,
                         .sweep_count = run->options->sweep_count,
                         .cells = run->cells,
                         .cell_count = run->count};
    char message[1024];
    if (!sheet.title) {
        return complain_no_memory();
    }
    const int code = sheet_write(&sheet, run->output, message, sizeof message);
    return code == EXIT_OK ? EXIT_OK : complain(code, "%s", message);
}

static int make_cells(SweepRun *run)
{
    int code = EXIT_OK;
    run->sheet_at = clock_seconds() + SHEET_SECONDS;
    for (size_t cell = 0; code == EXIT_OK && cell < run->count; ++cell) {
        code = make_cell(run, cell);
        if (code == EXIT_OK && clock_seconds() >= run->sheet_at && any_picture(run) &&
            cell + 1 < run->count) {
            code = write_sheet(run);
            run->sheet_at = clock_seconds() + SHEET_SECONDS;
        }
    }
    return code;
}

static void say_what_is_there(const SweepRun *run, int code)
{
    const Series *series = &run->series;
    const size_t done = series->rendered + series->kept;
    if (code >= EXIT_SIGNAL) {
        complain(code, "interrupted; `%s` has %zu of %zu pictures; the same command goes on",
                 done ? run->output : series->folder, done, run->count);
    } else if (code == EXIT_OK && !run->options->quiet) {
        char count[32];
        snprintf(count, sizeof count, done < run->count ? "%zu of %zu" : "%zu", done, run->count);
        fprintf(stderr, "%s: %s picture%s, %zu of them rendered now\n",
                done ? run->output : series->folder, count, run->count == 1 ? "" : "s",
                series->rendered);
    }
}

// Whatever ended it, what is there is shown.
static int run_sweep(SweepRun *run)
{
    int code = series_begin(&run->series, run->options, run->output, run->count);
    if (code != EXIT_OK) {
        return code;
    }
    code = make_cells(run);
    if (any_picture(run)) {
        const int written = write_sheet(run);
        code = code == EXIT_OK ? written : code;
    }
    say_what_is_there(run, code);
    return code == EXIT_OK && run->failed ? EXIT_DIAGNOSTICS : code;
}

int sweep_render(const Options *options)
{
    SweepRun run = {.options = options};
    int code = choose_output(&run);
    if (code == EXIT_OK) {
        code = count_cells(&run);
    }
    if (code == EXIT_OK) {
        code = run_sweep(&run);
        series_end(&run.series);
    }
    arena_free(&run.arena);
    return code;
}
