// Runs .scn programs and holds them to what they say in comments:
//
//     // expect: text          what print() writes, line by line, in order
//     // set: name=value       a setting, as --set
//     // limit: name=N         a limit, as --limit
//     // moment: FRAME FPS     the picture of a film that it is
//     // count: shapes=3       what the scene holds then: a category's plural, or instances,
//                              prototypes, transforms, meshes
//     //! text                 the diagnostics, exactly as written to a pipe; or, for programs
//     whose
//                              last byte matters, the file PROGRAM.txt beside
//
// Each is run as a whole and with statements evaluated as they are read, and both on one thread and
// on three, which must make no difference to any of these nor to the scene.
//
// usage: run [--update | --stops N] FILE|FOLDER…
// Files in folders called lib are not programs but imported. --update writes the diagnostics into
// the programs instead of comparing. --stops runs each program up to N times for each way in which
// an evaluation may end halfway (an allocation fails, a limit is
// reached, the stack is used up),
// halfway being somewhere else each time: it must come to what the whole program comes to or end
// with an error.
#include "base/mem.h"
#include "lang/lang.h"
#include "render/render.h"
#include "scene/dump.h"

#include <dirent.h>
#include <limits.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

typedef struct Text {
    char *at;
    size_t length;
} Text;

typedef struct Program {
    char path[PATH_MAX + 256];
    Text source;
    Text expected_print, expected_diagnostics;
    char *settings[16];
    size_t setting_count;
    Limits limits;
    Moment moment;
    char *counts[32];
    size_t count_count;
} Program;

static void append(Text *text, const char *bytes, size_t length)
{
    text->at = realloc(text->at, text->length + length + 1);
    if (!text->at) {
        abort();
    }
    memcpy(text->at + text->length, bytes, length);
    text->length += length;
    text->at[text->length] = '\0';
}

static bool read_text(const char *path, Text *out)
{
    *out = (Text){0};
    append(out, "", 0);
    FILE *file = fopen(path, "rb");
    if (!file) {
        return false;
    }
    char buffer[4096];
    for (size_t n; (n = fread(buffer, 1, sizeof buffer, file)) > 0;) {
        append(out, buffer, n);
    }
    fclose(file);
    return true;
}

// The rest of a line after `key`, or NULL.
static const char *after(const char *line, const char *end, const char *key)
{
    size_t length = strlen(key);
    for (const char *at = line; at + length <= end; ++at) {
        if (memcmp(at, key, length) == 0) {
            return at + length;
        }
    }
    return NULL;
}

static char *copy_rest(const char *begin, const char *end)
{
    return strndup(begin, (size_t)(end - begin));
}

static void read_expectations(Program *program)
{
    const char *at = program->source.at, *stop = at + program->source.length;
    while (at < stop) {
        const char *end = memchr(at, '\n', (size_t)(stop - at));
        end = end ? end : stop;
        const char *rest;
        if (strncmp(at, "//!", 3) == 0) {
            const char *from = at + 3 + (at[3] == ' ');
            append(&program->expected_diagnostics, from, (size_t)(end - from));
            append(&program->expected_diagnostics, "\n", 1);
        } else if ((rest = after(at, end, "// expect: ")) != NULL) {
            append(&program->expected_print, rest, (size_t)(end - rest));
            append(&program->expected_print, "\n", 1);
        } else if ((rest = after(at, end, "// set: ")) && program->setting_count < 16) {
            program->settings[program->setting_count++] = copy_rest(rest, end);
        } else if ((rest = after(at, end, "// count: ")) && program->count_count < 32) {
            program->counts[program->count_count++] = copy_rest(rest, end);
        } else if ((rest = after(at, end, "// moment: ")) != NULL) {
            char *fps;
            program->moment.frame = strtod(rest, &fps);
            program->moment.time = program->moment.frame / strtod(fps, NULL);
        } else if ((rest = after(at, end, "// limit: ")) != NULL) {
            Str assignment = {rest, (size_t)(end - rest)};
            if (!limits_set(&program->limits, assignment)) {
                printf("%s: bad limit\n", program->path);
            }
        }
        at = end + 1;
    }
    Text beside;
    char path[PATH_MAX + 512];
    snprintf(path, sizeof path, "%s.txt", program->path);
    if (read_text(path, &beside)) {
        free(program->expected_diagnostics.at);
        program->expected_diagnostics = beside;
    } else {
        free(beside.at);
    }
}

static void free_program(Program *program)
{
    for (size_t i = 0; i < program->setting_count; ++i) {
        free(program->settings[i]);
    }
    for (size_t i = 0; i < program->count_count; ++i) {
        free(program->counts[i]);
    }
    free(program->source.at);
    free(program->expected_print.at);
    free(program->expected_diagnostics.at);
}

// --- Running ---------------------------------------------------------------------------------

static long count_of(const Scene *scene, const char *what)
{
    for (int category = 0; category < CATEGORY_COUNT; ++category) {
        size_t length = strlen(category_name((Category)category));
        if (strncmp(what, category_name((Category)category), length) == 0 && what[length] == 's') {
            return (long)scene->nodes[category].count;
        }
    }
    return strncmp(what, "instances", 9) == 0     ? (long)scene->instances.count
           : strncmp(what, "prototypes", 10) == 0 ? (long)scene->prototypes.count - 1
           : strncmp(what, "transforms", 10) == 0 ? (long)scene->transforms.count
           : strncmp(what, "meshes", 6) == 0      ? (long)scene->meshes.count
                                                  : -1;
}

static bool check_counts(const Program *program, const Scene *scene)
{
    bool good = true;
    for (size_t i = 0; i < program->count_count; ++i) {
        char *rest = program->counts[i];
        for (char *word; (word = strtok_r(rest, " ", &rest)) != NULL;) {
            const char *equals = strchr(word, '=');
            long wanted = equals ? strtol(equals + 1, NULL, 10) : -2, is = count_of(scene, word);
            if (wanted != is) {
                printf("%s: count: %s, but there are %ld\n", program->path, word, is);
                good = false;
            }
        }
    }
    return good;
}

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

typedef struct Outcome {
    char *print, *diagnostics, *scene;
    size_t print_size, diagnostics_size, scene_size;
    uint64_t allocations;
    bool good, counts_good;
    bool said; // that it ended halfway
} Outcome;

static void free_outcome(Outcome *outcome)
{
    free(outcome->print);
    free(outcome->diagnostics);
    free(outcome->scene);
}

// How a run is made, and where it ends halfway.
typedef struct Way {
    bool whole, watched, beside, walked;
    uint64_t allocations; // that succeed
    size_t stack;         // Lang.stack
    size_t limit;         // 1 + the offset in Limits of one that is `least`; 0: none
    uint64_t least;
} Way;

static const Way at_once = {.whole = true, .allocations = UINT64_MAX};

static bool run_program(const Program *program, Way way, Outcome *outcome)
{
    Sandbox sandbox;
    Lang lang;
    Scene scene;
    char folder[PATH_MAX + 256];
    *outcome = (Outcome){0};
    snprintf(folder, sizeof folder, "%s", program->path);
    *strrchr(folder, '/') = '\0';
    sandbox_init(&sandbox);
    if (sandbox_allow(&sandbox, folder) != IO_OK || !lang_init(&lang, render_schema(), &sandbox) ||
        !scene_init(&scene, render_schema(), &sandbox)) {
        return false;
    }
    ParamSetting settings[16];
    for (size_t i = 0; i < program->setting_count; ++i) {
        const char *equals = strchr(program->settings[i], '=');
        settings[i] = (ParamSetting){
            {program->settings[i], (size_t)(equals - program->settings[i])}, str_from(equals + 1)};
    }
    Observations observed = {0};
    lang.whole = way.whole;
    lang.threads = way.beside ? 3 : 1;
    lang.aside_always = way.beside;
    lang.walked = way.walked;
    lang.observed = way.watched ? &observed : NULL;
    lang.testing = lang.bindings = way.watched;
    lang.stack = way.stack;
    lang.limits = program->limits;
    if (way.limit) {
        memcpy((char *)&lang.limits + way.limit - 1, &way.least, sizeof way.least);
    }
    lang.sink.limit = (uint32_t)lang.limits.diagnostics;
    lang.moment = program->moment;
    lang.settings = settings;
    lang.setting_count = program->setting_count;
    lang.print_to = open_memstream(&outcome->print, &outcome->print_size);
    const uint64_t before = mem_allocation_count();
    mem_fail_after(way.allocations);
    outcome->good = lang_load(&lang, program->path, base_name(program->path), &scene);
    mem_fail_after(UINT64_MAX);
    outcome->allocations = mem_allocation_count() - before;
    outcome->said = lang.sink.out_of_memory || lang.sink.dropped;
    for (uint32_t i = 0; i < lang.sink.count; ++i) {
        DiagCode code = lang.sink.items[i].code;
        outcome->said = outcome->said || code == E0001 || (code >= E0701 && code <= E0712);
    }
    outcome->counts_good =
        way.allocations < UINT64_MAX || way.limit || way.stack || check_counts(program, &scene);
    fclose(lang.print_to);
    FILE *diagnostics = open_memstream(&outcome->diagnostics, &outcome->diagnostics_size);
    diag_write_text(&lang.sink, &lang.sources, diagnostics, DIAG_PLAIN);
    fclose(diagnostics);
    FILE *dump = open_memstream(&outcome->scene, &outcome->scene_size);
    if (outcome->good) { // else it may be anything
        scene_dump_json(&scene, &lang.sources, dump);
    }
    fclose(dump);
    observations_free(&observed);
    scene_free(&scene);
    lang_free(&lang);
    sandbox_free(&sandbox);
    return true;
}

static bool compare(const Program *program, const char *what, Text expected, const char *is)
{
    const char *wanted = expected.at ? expected.at : "";
    if (strcmp(wanted, is) == 0) {
        return true;
    }
    printf("%s: %s differ\n--- expected\n%s--- found\n%s---\n", program->path, what, wanted, is);
    return false;
}

// What came out of the whole file in order, and of another way.
static bool is_same(const Program *program, const Outcome *whole, const Outcome *other,
                    const char *how)
{
    const char *what = strcmp(whole->diagnostics, other->diagnostics) != 0 ? "diagnostics"
                       : strcmp(whole->print, other->print) != 0           ? "printed lines"
                       : strcmp(whole->scene, other->scene) != 0           ? "scene"
                                                                           : NULL;
    if (what) {
        printf("%s: %s: not the same when statements are evaluated %s\n", program->path, what, how);
    }
    return !what;
}

static bool other_ways_agree(const Program *program, const Outcome *whole)
{
    static const char *const how[] = {"beside one another", "as they are read",
                                      "as they are read, and beside one another",
                                      "without steps for numbers"};
    bool good = true;
    for (int i = 1; good && i < 5; ++i) {
        Way way = at_once;
        way.beside = i == 1 || i == 3;
        way.whole = i == 1 || i == 4;
        way.walked = i == 4;
        Outcome other;
        good = run_program(program, way, &other) && is_same(program, whole, &other, how[i - 1]);
        free_outcome(&other);
    }
    return good;
}

static void write_lines(FILE *out, const char *text)
{
    while (*text) {
        size_t length = strcspn(text, "\n");
        fprintf(out, length ? "//! %.*s\n" : "//!%.*s\n", (int)length, text);
        text += length + (text[length] == '\n');
    }
}

// Puts the diagnostics at the end of the program in place of those there.
static void update(const Program *program, const Outcome *outcome)
{
    char beside[PATH_MAX + 512];
    snprintf(beside, sizeof beside, "%s.txt", program->path);
    struct stat info;
    if (stat(beside, &info) == 0) {
        FILE *out = fopen(beside, "wb");
        fwrite(outcome->diagnostics, 1, outcome->diagnostics_size, out);
        fclose(out);
        return;
    }
    const char *marks = strstr(program->source.at, "\n//!");
    size_t keep = marks ? (size_t)(marks + 1 - program->source.at) : program->source.length;
    FILE *out = fopen(program->path, "wb");
    if (!out) {
        return;
    }
    fwrite(program->source.at, 1, keep, out);
    write_lines(out, outcome->diagnostics);
    fclose(out);
}

static bool test_program(const char *path, bool updating)
{
    Program program = {.limits = limits_default()};
    Outcome outcome;
    snprintf(program.path, sizeof program.path, "%s", path);
    if (!read_text(path, &program.source)) {
        printf("%s: can't be read\n", path);
        return false;
    }
    read_expectations(&program);
    bool good = run_program(&program, at_once, &outcome);
    if (updating && good) {
        update(&program, &outcome);
    } else if (good) {
        good = compare(&program, "diagnostics", program.expected_diagnostics, outcome.diagnostics);
    }
    good = good && outcome.counts_good &&
           compare(&program, "printed lines", program.expected_print, outcome.print);
    good = good && other_ways_agree(&program, &outcome);
    free_outcome(&outcome);
    free_program(&program);
    return good;
}

// --- Ending halfway --------------------------------------------------------------------------

// False when it came to something else and didn't say why. `ended`: whether it ended halfway.
static bool stop_once(const Program *program, const Outcome *whole, Way way, bool *ended)
{
    Outcome outcome;
    if (!run_program(program, way, &outcome)) {
        return false;
    }
    *ended = outcome.said && !whole->said;
    bool good = outcome.good ? whole->good && strcmp(outcome.scene, whole->scene) == 0
                             : outcome.said || !whole->good;
    if (!good) {
        printf("%s: ended halfway without saying so: %llu allocations, a stack of %zu, "
               "limit %zu: %llu\n%s",
               program->path, (unsigned long long)way.allocations, way.stack,
               way.limit / sizeof(uint64_t), (unsigned long long)way.least, outcome.diagnostics);
    }
    free_outcome(&outcome);
    return good;
}

static bool stop_everywhere(const char *path, unsigned runs)
{
    enum { STACK = 24 << 10, FEWEST = 40 };
    static const size_t limits[] = {offsetof(Limits, pixels),       offsetof(Limits, steps),
                                    offsetof(Limits, objects),      offsetof(Limits, list_length),
                                    offsetof(Limits, parts),        offsetof(Limits, memory),
                                    offsetof(Limits, diagnostics),  offsetof(Limits, call_depth),
                                    offsetof(Limits, import_depth), offsetof(Limits, nesting)};
    Program program = {.limits = limits_default()};
    Outcome whole;
    snprintf(program.path, sizeof program.path, "%s", path);
    if (!read_text(path, &program.source)) {
        printf("%s: can't be read\n", path);
        return false;
    }
    read_expectations(&program);
    // A program that takes long ends by its own limits, and would take as long each time.
    program.limits.steps = program.limits.steps < 100000 ? program.limits.steps : 100000;
    bool good = run_program(&program, at_once, &whole), ended = true;
    for (uint64_t i = 0; good && i < runs; ++i) {
        Way way = at_once;
        way.whole = i % 3 != 0;
        way.watched = i % 3 == 1;
        way.beside = i % 2 == 0;
        way.allocations = i * whole.allocations / runs;
        good = stop_once(&program, &whole, way, &ended);
    }
    for (size_t k = 0; k < sizeof limits / sizeof *limits; ++k) {
        uint64_t least = 0;
        ended = true;
        for (unsigned i = 0; good && ended && i < runs; ++i) {
            Way way = at_once;
            way.whole = i % 2 != 0;
            way.beside = i % 3 == 0;
            way.limit = 1 + limits[k];
            way.least = least * (limits[k] == offsetof(Limits, memory) ? 4096 : 1);
            least += 1 + least / FEWEST;
            good = stop_once(&program, &whole, way, &ended);
        }
    }
    for (unsigned i = 0; good && i < runs; ++i) {
        Way way = at_once;
        way.stack = 1 + i * (size_t)STACK / runs;
        good = stop_once(&program, &whole, way, &ended);
    }
    free_outcome(&whole);
    free_program(&program);
    return good;
}

// --- Folders ---------------------------------------------------------------------------------

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static bool ends_with(const char *text, const char *end)
{
    size_t length = strlen(text), tail = strlen(end);
    return length >= tail && strcmp(text + length - tail, end) == 0;
}

typedef struct Task {
    bool updating;
    unsigned stops; // runs of each kind; 0: none but the usual
} Task;

static bool do_program(const char *path, Task task)
{
    return task.stops ? stop_everywhere(path, task.stops) : test_program(path, task.updating);
}

static void test_folder(const char *folder, Task task, size_t *count, size_t *failed)
{
    char *names[4096];
    size_t name_count = 0;
    DIR *listing = opendir(folder);
    if (!listing) {
        printf("%s: can't be read\n", folder);
        ++*failed;
        return;
    }
    for (struct dirent *entry; (entry = readdir(listing)) && name_count < 4096;) {
        if (ends_with(entry->d_name, ".scn")) {
            names[name_count++] = strdup(entry->d_name);
        }
    }
    closedir(listing);
    qsort(names, name_count, sizeof *names, compare_names);
    for (size_t i = 0; i < name_count; ++i) {
        char path[PATH_MAX + 256];
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        *failed += !do_program(path, task);
        ++*count;
        free(names[i]);
    }
}

int main(int argc, char **argv)
{
    Task task = {.updating = argc > 1 && strcmp(argv[1], "--update") == 0};
    if (argc > 2 && strcmp(argv[1], "--stops") == 0) {
        task.stops = (unsigned)strtoul(argv[2], NULL, 10);
    }
    size_t count = 0, failed = 0;
    for (int i = task.stops ? 3 : 1 + task.updating; i < argc; ++i) {
        char path[PATH_MAX];
        struct stat info;
        if (!realpath(argv[i], path) || stat(path, &info) != 0) {
            printf("%s: can't be read\n", argv[i]);
            ++failed;
        } else if (S_ISDIR(info.st_mode)) {
            test_folder(path, task, &count, &failed);
        } else {
            failed += !do_program(path, task);
            ++count;
        }
    }
    printf("%zu programs, %zu failed\n", count, failed);
    return failed || !count ? 1 : 0;
}
