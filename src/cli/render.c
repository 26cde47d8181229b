// scnrender FILE: a picture, a sheet of them (--sweep) or a film (--frames); or, with --dump, one
// of the stages on the way.
#include "cli/commands.h"
#include "cli/frames.h"
#include "cli/load.h"
#include "cli/rendering.h"
#include "cli/sweep.h"
#include "scene/dump.h"

static int write_dump(Loading *loading)
{
    Lang *lang = &loading->lang;
    switch (loading->options->dump) {
    case DUMP_TOKENS:
        lang_dump_tokens(lang, loading->path, loading->shown, stdout);
        break;
    case DUMP_AST:
        lang_dump_ast(lang, loading->path, loading->shown, stdout);
        break;
    default:
        if (loading_evaluate(loading)) {
            scene_dump_json(&loading->scene, &lang->sources, stdout);
        }
    }
    return loading_report(loading);
}

static int dump(const Options *options)
{
    Loading loading;
    int code = loading_begin(&loading, options);
    if (code == EXIT_OK) {
        code = write_dump(&loading);
    }
    loading_free(&loading);
    return code;
}

static int render(const Options *options)
{
    const RenderTask task = {.options = options};
    Interrupt interrupt = {0};
    const int code = render_picture(&task, &interrupt);
    interrupt_end(&interrupt);
    return code;
}

int command_render(const Options *options)
{
    return options->dump != DUMP_NOTHING ? dump(options)
           : options->sweep_count > 0    ? sweep_render(options)
           : options->frames.step != 0   ? frames_render(options)
                                         : render(options);
}
