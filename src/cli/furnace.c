// scnrender furnace FILE: every material of a scene in light from all around.
#include "cli/commands.h"
#include "cli/furnace_report.h"
#include "cli/interrupt.h"

#include <string.h>
#include <unistd.h>

enum { MOST_SUBJECTS = 400 };

typedef struct FurnaceRun {
    Loading loading;
    Interrupt interrupt;
    World *world;
    FurnaceSubjects subjects;
    size_t left_out; // of the subjects, beyond the most
} FurnaceRun;

// --- Which materials -----------------------------------------------------------------------------

static FurnaceSubject *find_subject(FurnaceRun *run, uint32_t material)
{
    for (size_t i = 0; i < run->subjects.count; ++i) {
        if (run->subjects.items[i].material == material) {
            return &run->subjects.items[i];
        }
    }
    return NULL;
}

static void add_subject(FurnaceRun *run, uint32_t material, const char *name, Span at)
{
    const Scene *scene = &run->loading.scene;
    if (run->subjects.count == MOST_SUBJECTS) {
        ++run->left_out;
        return;
    }
    const SceneNode *node = scene_node(scene, CATEGORY_MATERIAL, material);
    run->subjects.items[run->subjects.count++] = (FurnaceSubject){
        .name = name, .kind = scene_node_type(scene, node)->name, .material = material, .at = at};
}

// "white, paper": equal materials are one.
static bool add_name(FurnaceRun *run, FurnaceSubject *subject, const char *name)
{
    if (strlen(subject->name) + strlen(name) < 120) {
        subject->name = arena_printf(&run->loading.lang.arena, "%s, %s", subject->name, name);
    }
    return subject->name != NULL;
}

static void add_used(FurnaceRun *run, uint32_t material)
{
    const Scene *scene = &run->loading.scene;
    if (material == NONE_ID || find_subject(run, material)) {
        return;
    }
    const SceneNode *node = scene_node(scene, CATEGORY_MATERIAL, material);
    add_subject(run, material, scene->names.items[node->name], node->at);
}

// Those that the file names, then those of shapes and instances that have no name.
static bool find_subjects(FurnaceRun *run)
{
    const Scene *scene = &run->loading.scene;
    run->subjects.items =
        arena_array(&run->loading.lang.arena, MOST_SUBJECTS, sizeof *run->subjects.items);
    bool good = run->subjects.items != NULL;
    for (size_t i = 0; good && i < scene->bindings.count; ++i) {
        const SceneBinding *binding = &scene->bindings.items[i];
        FurnaceSubject *known = find_subject(run, binding->material);
        if (known) {
            good = add_name(run, known, binding->name);
        } else {
            add_subject(run, binding->material, binding->name, binding->at);
        }
    }
    for (size_t i = 0; good && i < scene->nodes[CATEGORY_SHAPE].count; ++i) {
        add_used(run, scene->nodes[CATEGORY_SHAPE].items[i].material);
    }
    for (size_t i = 0; good && i < scene->instances.count; ++i) {
        add_used(run, scene->instances.items[i].material);
    }
    return good;
}

// --- Measuring -----------------------------------------------------------------------------------

static int stop_code(const FurnaceRun *run)
{
    int number = atomic_load(&run->interrupt.signal);
    return number ? EXIT_SIGNAL + number : EXIT_OK;
}

static int measure(FurnaceRun *run)
{
    const Options *options = run->loading.options;
    FurnaceOptions furnace = {.threads = options->threads,
                              .samples = options->samples,
                              .seed = options->seed > 0 ? (uint32_t)options->seed : 0,
                              .stop = &run->interrupt.signal};
    bool text = !options->json_report && !options->quiet;
    for (size_t i = 0; i < run->subjects.count; ++i) {
        FurnaceSubject *subject = &run->subjects.items[i];
        if (!furnace_measure(run->world, subject->material, &furnace, &subject->report)) {
            return complain_no_memory();
        }
        if (subject->report.stopped) {
            return complain(stop_code(run), "interrupted after %zu of %zu materials", i,
                            run->subjects.count);
        }
        if (text || (!options->json_report && furnace_is_bad(&subject->report))) {
            fputs(i ? "\n" : "", stdout);
            furnace_write_text(stdout, &run->loading, subject);
            fflush(stdout);
        }
    }
    return EXIT_OK;
}

// --- Delivery ------------------------------------------------------------------------------------

static int write_plot(FurnaceRun *run, const char *name)
{
    char message[512];
    AtomicFile file;
    if (!atomic_file_open(&file, name, message, sizeof message)) {
        return complain(EXIT_FILES, "%s", message);
    }
    furnace_write_svg(file.stream, &run->loading, &run->subjects);
    if (!atomic_file_commit(&file, message, sizeof message)) {
        return complain(EXIT_FILES, "%s", message);
    }
    return EXIT_OK;
}

static int deliver(FurnaceRun *run)
{
    const Options *options = run->loading.options;
    int code = EXIT_OK;
    if (options->json_report) {
        furnace_write_json(stdout, &run->loading, &run->subjects);
    }
    if (options->output) {
        code = write_plot(run, options->output);
    }
    if (run->left_out) {
        complain(EXIT_OK, "%zu more materials are left out; %d are the most", run->left_out,
                 MOST_SUBJECTS);
    }
    for (size_t i = 0; code == EXIT_OK && i < run->subjects.count; ++i) {
        code = furnace_is_bad(&run->subjects.items[i].report) ? EXIT_DIAGNOSTICS : EXIT_OK;
    }
    return code;
}

static int run_furnace(FurnaceRun *run)
{
    Loading *loading = &run->loading;
    loading->lang.bindings = true;
    if (loading_evaluate(loading)) {
        run->world = world_build(&loading->scene, loading->options->threads, &loading->lang.sink);
    }
    int code = loading_report(loading);
    if (!run->world) {
        return code != EXIT_OK ? code : EXIT_DIAGNOSTICS;
    }
    if (!find_subjects(run)) {
        return complain_no_memory();
    }
    if (run->subjects.count == 0) {
        return complain(EXIT_DIAGNOSTICS, "`%s` has no materials", loading->shown);
    }
    interrupt_heed(&run->interrupt);
    code = measure(run);
    return code == EXIT_OK ? deliver(run) : code;
}

static bool is_svg(const char *name)
{
    size_t length = strlen(name);
    return length > 4 && strcmp(name + length - 4, ".svg") == 0;
}

int command_furnace(const Options *options)
{
    if (options->output && !is_svg(options->output)) {
        return complain(EXIT_USAGE, "a plot is an .svg, which `%s` isn't", options->output);
    }
    FurnaceRun run = {0};
    int code = loading_begin(&run.loading, options);
    if (code == EXIT_OK) {
        interrupt_begin(&run.interrupt);
        code = run_furnace(&run);
        interrupt_end(&run.interrupt);
    }
    world_free(run.world);
    loading_free(&run.loading);
    return code;
}
