// scnrender lsp: serves an editor over standard input and output.
#include "cli/commands.h"
#include "cli/load.h"

#include "base/big_stack.h"
#include "lsp/lsp.h"
#include "render/light_report.h"
#include "render/material_report.h"
#include "render/render.h"

#include <unistd.h>

enum {
    STACK_BYTES = 64 << 20, // for deep scenes under a raised limit
    STEPS = 50000000,
    OBJECTS = 2000000,
};

static const uint64_t MEMORY = (uint64_t)2 << 30;

// What a scene with no error is held to by `check`, too.
static void check_scene(const Scene *scene, DiagSink *sink)
{
    light_warn_enclosed(scene, 1, sink);
    material_warn_open_glass(scene, sink);
}

typedef struct Serving {
    LspHost host;
    LspEnd end;
} Serving;

static void serve(void *context, uintptr_t floor)
{
    (void)floor;
    Serving *serving = context;
    serving->end = lsp_serve(&serving->host, STDIN_FILENO, STDOUT_FILENO);
}

// Somebody waits at a keyboard: unless they were set, limits are lower than for a picture.
static uint64_t lowered(uint64_t limit, uint64_t standard, uint64_t low)
{
    return limit == standard ? low : limit;
}

int command_lsp(const Options *options)
{
    Serving serving = {.host = {.schema = render_schema(),
                                .check = check_scene,
                                .limits = options->limits,
                                .folders = options->folders,
                                .folder_count = options->folder_count,
                                .version = SCN_VERSION,
                                .evaluates = true}};
    Limits standard = limits_default(), *limits = &serving.host.limits;
    limits->steps = lowered(limits->steps, standard.steps, STEPS);
    limits->objects = lowered(limits->objects, standard.objects, OBJECTS);
    limits->memory = lowered(limits->memory, standard.memory, MEMORY);
    call_on_big_stack(STACK_BYTES, serve, &serving);
    return serving.end == LSP_ENDED       ? EXIT_OK
           : serving.end == LSP_ABANDONED ? EXIT_DIAGNOSTICS
                                          : EXIT_NO_MEMORY;
}
