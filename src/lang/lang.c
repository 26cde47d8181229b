// One run: from a file to the scene, on a stack of its own and with one place to land when memory
// runs out.
#include "lang/lang.h"

#include "base/big_stack.h"
#include "base/mem.h"
#include "base/module.h"
#include "lang/eval.h"
#include "lang/lexer.h"
#include "lang/params.h"

#include <limits.h>
#include <string.h>
#include <xxhash.h>

bool lang_init(Lang *lang, const Schema *schema, Sandbox *sandbox)
{
    *lang = (Lang){.schema = schema, .sandbox = sandbox, .limits = limits_default()};
    sources_init(&lang->sources, &lang->arena);
    interner_init(&lang->names, &lang->arena);
    diag_sink_init(&lang->sink, &lang->arena);
    return true;
}

IoError lang_use_library(Lang *lang)
{
    char folder[PATH_MAX];
    if (!data_folder("std", folder, sizeof folder)) {
        return IO_OK;
    }
    lang->library = arena_copy_string(&lang->arena, folder, strlen(folder));
    return lang->library ? sandbox_allow(lang->sandbox, folder) : IO_NO_MEMORY;
}

void lang_free(Lang *lang)
{
    diag_sink_free(&lang->sink);
    interner_free(&lang->names);
    sources_free(&lang->sources);
    for (size_t i = 0; i < lang->files.count; ++i) {
        file_bytes_free(&lang->files.items[i]);
    }
    array_free(&lang->files);
    arena_free(&lang->arena);
}

// --- Sources ---------------------------------------------------------------------------------

static bool report_no_memory(Lang *lang)
{
    diag_report(&lang->sink, E0001, (Span){0}, "out of memory");
    return false;
}

static uint32_t add_text(Lang *lang, Str text, const char *path, const char *shown)
{
    char *copy = arena_copy_string(&lang->arena, text.at, text.length);
    uint32_t file =
        copy ? sources_add(&lang->sources, shown, path, (Str){copy, text.length}, (Span){0}) : 0;
    return file ? file : report_no_memory(lang);
}

// The number of the source, or 0 after a report.
static uint32_t add_file(Lang *lang, const char *path, const char *shown)
{
    Str given;
    if (lang->find_given && lang->find_given(lang->find_given_context, path, &given)) {
        uint32_t number = sources_add(&lang->sources, shown, path, given, (Span){0});
        return number ? number : report_no_memory(lang);
    }
    if (lang->given_path && strcmp(path, lang->given_path) == 0) {
        return add_text(lang, lang->given_text, path, shown);
    }
    FileBytes bytes;
    IoError error = sandbox_read(lang->sandbox, path, &bytes);
    if (error == IO_OK && bytes.size > lang->limits.file_bytes) {
        file_bytes_free(&bytes);
        error = IO_TOO_LARGE;
    }
    if (error != IO_OK) {
        diag_report(&lang->sink, E0601, (Span){0}, "`%s` can't be read: %s", shown,
                    io_error_text(error));
        return 0;
    }
    if (!array_push(&lang->files, bytes)) {
        file_bytes_free(&bytes);
        return report_no_memory(lang);
    }
    uint32_t file =
        sources_add(&lang->sources, shown, path, (Str){bytes.bytes, bytes.size}, (Span){0});
    return file ? file : report_no_memory(lang);
}

// --- The evaluator ---------------------------------------------------------------------------

typedef struct Run {
    Lang *lang;
    Scene *scene;
    uint32_t file;
    FILE *params_to; // write the params as JSON, and nothing else
    bool whole;      // the file is read before anything is evaluated
    bool refused;    // that it isn't was no good
} Run;

Eval *eval_new(Lang *lang, Scene *scene, uintptr_t floor)
{
    Eval *ev = mem_alloc_zeroed(1, sizeof *ev);
    if (!ev) {
        return NULL;
    }
    ev->lang = lang;
    ev->names = &lang->names;
    ev->sink = &lang->sink;
    ev->scene = scene;
    ev->oldest_forced = UINT64_MAX;
    // What is left below holds the deepest thing that doesn't check for itself: a kind's `finish`,
    // which may load a mesh.
    ev->stack_floor =
        lang->stack ? (uintptr_t)__builtin_frame_address(0) - lang->stack : floor + (512 << 10);
    ev->memory.limit = lang->limits.memory;
    for (int i = 0; i < REGION_COUNT; ++i) {
        ev->regions[i].on_oom = &ev->on_oom;
        ev->regions[i].family = &ev->memory;
    }
    ev->arena = &ev->regions[0];
    scene->arena.on_oom = &ev->on_oom;
    interner_init(&ev->strings, &scene->arena);
    return ev;
}

void eval_free(Eval *ev)
{
    ev->scene->arena.on_oom = NULL;
    asides_free(ev);
    interner_free(&ev->strings);
    modules_free(ev);
    array_free(&ev->stack);
    array_free(&ev->material_parts);
    array_free(&ev->texture_parts);
    for (int i = 0; i < REGION_COUNT; ++i) {
        arena_free(&ev->regions[i]);
    }
    mem_free(ev);
}

void report_full(Eval *ev)
{
    ev->calls = NULL;
    if (ev->memory.refused) {
        Diag *diag = diag_report(ev->sink, E0709, (Span){0},
                                 "evaluation needs more than %llu bytes of memory",
                                 (unsigned long long)ev->lang->limits.memory);
        diag_note(ev->sink, diag, "--limit memory=N raises this");
    } else {
        report_no_memory(ev->lang);
    }
}

// --- Evaluation of a scene -------------------------------------------------------------------

static AstTag global_tag(const Module *module, uint32_t slot)
{
    return (AstTag)module->ast.nodes.items[module->globals.items[slot].item].tag;
}

// All lets (or params) of a file, so that each error is found, whatever is used.
static void force_globals(Eval *ev, Module *module, AstTag tag)
{
    for (uint32_t slot = 0; slot < module->globals.count && go_on(ev); ++slot) {
        if (global_tag(module, slot) == tag) {
            force_slot(ev, module->env, slot, module->globals.items[slot].item);
        }
    }
}

static void emit_file(Eval *ev, Module *module)
{
    Emitter emitter = {.is_identity = true, .material = NONE_ID};
    ev->emitter = &emitter;
    const Ast *ast = &module->ast;
    uint32_t list = ast->nodes.items[ast->root].a;
    uint32_t count = ast_list_count(ast, list);
    for (uint32_t i = 0; i < count && go_on(ev); ++i) {
        RegionMark region = region_enter(ev);
        run_items(ev, module->env, ast_list_items(ast, list) + i, 1);
        region_leave(ev, region);
    }
}

static void keep_params(Eval *ev, Module *module)
{
    for (uint32_t slot = 0; slot < module->globals.count; ++slot) {
        if (global_tag(module, slot) != AST_PARAM) {
            continue;
        }
        const Global *global = &module->globals.items[slot];
        TextBuffer text = {0};
        text_add_value(ev, &text, force_slot(ev, module->env, slot, global->item), true);
        SceneParam param = {keep_string(ev, symbol_name(ev->names, global->name)),
                            keep_string(ev, (Str){text.text, text.length})};
        if (!array_push(&ev->scene->params, param)) {
            out_of_memory(ev);
        }
    }
}

enum { MOST_BINDINGS = 10000, MOST_IN_A_LIST = 1000 };

// A material that a name stands for, or those of a list.
static void keep_binding(Eval *ev, const char *name, Value v, Span at)
{
    if (v.type == VALUE_LIST && v.count <= MOST_IN_A_LIST) {
        for (uint32_t i = 0; i < v.count; ++i) {
            TextBuffer text = {0};
            text_add(ev, &text, "%s[%u]", name, i);
            if (v.items[i].type != VALUE_LIST) { // lists of lists are no palette
                keep_binding(ev, text.text, v.items[i], at);
            }
        }
        return;
    }
    bool is_material =
        v.type == VALUE_NODE && ev->kinds[v.node->type].type->category == CATEGORY_MATERIAL;
    if (!is_material || ev->scene->bindings.count == MOST_BINDINGS) {
        return;
    }
    SceneBinding binding = {keep_string(ev, str_from(name)), node_scene_id(ev, v.node), at};
    if (!array_push(&ev->scene->bindings, binding)) {
        out_of_memory(ev);
    }
}

static void keep_bindings(Eval *ev, Module *module)
{
    for (uint32_t slot = 0; slot < module->globals.count; ++slot) {
        const Global *global = &module->globals.items[slot];
        if (global_tag(module, slot) == AST_LET) {
            keep_binding(ev, symbol_name(ev->names, global->name).at,
                         force_slot(ev, module->env, slot, global->item),
                         item_name_span(module, global->item));
        }
    }
}

// The bytes of all files of the scene and the settings, and when it is, where it moves.
static uint64_t hash_scene(const Eval *ev)
{
    uint64_t hash = 0;
    const Lang *lang = ev->lang;
    for (size_t i = 0; i < ev->modules.count; ++i) {
        const Source *source = source_get(&lang->sources, ev->modules.items[i]->file);
        if (i == 0 || source->real) { // else defaults and settings
            hash = content_hash(source->text.at, source->text.length, hash, lang->threads);
        }
    }
    for (size_t i = 0; i < lang->setting_count; ++i) {
        hash = XXH3_64bits_withSeed(lang->settings[i].name.at, lang->settings[i].name.length, hash);
        hash =
            XXH3_64bits_withSeed(lang->settings[i].value.at, lang->settings[i].value.length, hash);
    }
    if (lang->moves) {
        hash = XXH3_64bits_withSeed(&lang->moment, sizeof lang->moment, hash);
    }
    return hash;
}

static void check_pixels(Eval *ev)
{
    const SceneNodeArray *settings = &ev->scene->nodes[CATEGORY_SETTING];
    for (size_t i = 0; i < settings->count; ++i) {
        const NodeType *type = scene_node_type(ev->scene, &settings->items[i]);
        int width = node_type_find_param(type, STR("width"));
        int height = node_type_find_param(type, STR("height"));
        if (width < 0 || height < 0 || type->params[width].type != PARAM_INT ||
            type->params[height].type != PARAM_INT) {
            continue;
        }
        int64_t size[2];
        const char *params = scene_params(ev->scene, &settings->items[i]);
        memcpy(&size[0], params + type->params[width].offset, sizeof size[0]);
        memcpy(&size[1], params + type->params[height].offset, sizeof size[1]);
        if ((double)size[0] * (double)size[1] > (double)ev->lang->limits.pixels) {
            Diag *diag = report(ev, E0711, settings->items[i].at, "a picture of %lld × %lld pixels",
                                (long long)size[0], (long long)size[1]);
            diag_note(ev->sink, diag, "--limit pixels=N raises the limit of %llu",
                      (unsigned long long)ev->lang->limits.pixels);
        }
    }
}

static bool any_failed(const Eval *ev)
{
    for (size_t i = 0; i < ev->modules.count; ++i) {
        if (ev->modules.items[i]->failed) {
            return true;
        }
    }
    return false;
}

// What can be put into the scene but by items.
static size_t count_nodes(const Scene *scene)
{
    size_t count = scene->transforms.count + scene->names.count;
    for (int i = 0; i < CATEGORY_COUNT; ++i) {
        count += scene->nodes[i].count;
    }
    return count;
}

static void evaluate(Eval *ev, const Run *run)
{
    ev->consed_nodes = arena_alloc_zeroed(ev->arena, CONS_SLOTS * sizeof *ev->consed_nodes);
    ev->consed_transforms = arena_alloc_zeroed(ev->arena, CONS_SLOTS * sizeof(ConsSlot));
    size_t words = ev->lang->setting_count / 64 + 1;
    ev->settings_used = arena_alloc_zeroed(ev->arena, words * sizeof *ev->settings_used);
    kinds_init(ev);
    ev->region = 1; // files; region 0 is never rewound
    ev->arena = &ev->regions[1];
    Module *module =
        run->whole ? module_load_text(ev, run->file, false) : module_load_early(ev, run->file);
    if (ev->refused || any_failed(ev)) {
        return;
    }
    const size_t files = ev->modules.count, nodes = count_nodes(ev->scene);
    for (size_t i = 0; i < files; ++i) {
        force_globals(ev, ev->modules.items[i], AST_PARAM);
    }
    ev->refused = ev->early && (ev->refused || count_nodes(ev->scene) != nodes);
    if (ev->refused) {
        return; // what params bring comes before what statements do
    }
    check_settings(ev, module);
    if (run->params_to) {
        params_write_json(ev, module, run->params_to);
        return;
    }
    if (ev->lang->params_to) {
        params_write_json(ev, module, ev->lang->params_to);
    }
    emit_file(ev, module);
    force_globals(ev, module, AST_LET);
    if (ev->refused) {
        return;
    }
    keep_params(ev, module);
    if (ev->lang->bindings) {
        keep_bindings(ev, module);
    }
    if (ev->lang->testing) {
        keep_unrun_expectations(ev, module);
    }
    check_pixels(ev);
    if (ev->sink->errors == 0) { // else what is missing may be what failed
        check_measures(ev);
    }
    ev->scene->hash = hash_scene(ev);
    ev->scene->camera = ev->scene->nodes[CATEGORY_CAMERA].count ? 0 : NONE_ID;
}

static void run_on_stack(void *context, uintptr_t floor)
{
    Run *run = context;
    const uint32_t errors = run->lang->sink.errors;
    Eval *ev = eval_new(run->lang, run->scene, floor);
    if (!ev) {
        report_no_memory(run->lang);
        return;
    }
    if (setjmp(ev->on_oom) == 0) {
        evaluate(ev, run);
    } else {
        report_full(ev);
    }
    run->refused = ev->refused || (ev->early && ev->sink->errors != errors);
    eval_free(ev);
}

// First with statements evaluated as they are read and, where that may not be right, anew.
static void run_twice(Run *run)
{
    Lang *lang = run->lang;
    const DiagMark mark = diag_mark(&lang->sink);
    const uint32_t sources = lang->sources.count;
    const uint_least64_t content = lang->sandbox ? atomic_load(&lang->sandbox->content_hash) : 0;
    // Who watches would see the first try, and params are written but once.
    run->whole = lang->whole || lang->observed || run->params_to || lang->params_to;
    call_on_big_stack(STACK_BYTES, run_on_stack, run);
    if (!run->refused) {
        return;
    }
    diag_rewind(&lang->sink, mark);
    sources_rewind(&lang->sources, sources);
    if (lang->sandbox) {
        atomic_store(&lang->sandbox->content_hash, content);
    }
    run->whole = true;
    if (scene_clear(run->scene)) {
        call_on_big_stack(STACK_BYTES, run_on_stack, run);
    } else {
        report_no_memory(lang);
    }
}

static bool run_file(Lang *lang, uint32_t file, Scene *scene, FILE *params_to)
{
    if (!file) {
        return false;
    }
    Run run = {.lang = lang, .scene = scene, .file = file, .params_to = params_to};
    run_twice(&run);
    if (lang->sink.out_of_memory) {
        report_no_memory(lang);
    }
    return lang->sink.errors == 0;
}

bool lang_load(Lang *lang, const char *path, const char *shown, Scene *scene)
{
    return run_file(lang, add_file(lang, path, shown), scene, NULL);
}

bool lang_load_text(Lang *lang, Str text, const char *path, const char *shown, Scene *scene)
{
    return run_file(lang, add_text(lang, text, path, shown), scene, NULL);
}

bool lang_params_json(Lang *lang, const char *path, const char *shown, FILE *out)
{
    Scene scene;
    if (!scene_init(&scene, lang->schema, lang->sandbox)) {
        return report_no_memory(lang);
    }
    bool good = run_file(lang, add_file(lang, path, shown), &scene, out);
    scene_free(&scene);
    return good;
}

// --- Dumps -----------------------------------------------------------------------------------

bool lang_dump_tokens(Lang *lang, const char *path, const char *shown, FILE *out)
{
    uint32_t file = add_file(lang, path, shown);
    return file && lexer_dump(&lang->sources, file, &lang->names, &lang->sink, out);
}

bool lang_dump_ast(Lang *lang, const char *path, const char *shown, FILE *out)
{
    uint32_t file = add_file(lang, path, shown);
    if (!file) {
        return false;
    }
    Ast ast = {0};
    bool good =
        parse(&ast, &lang->sources, file, &lang->names, parse_limits(lang), false, &lang->sink);
    ast_dump(&ast, &lang->names, out);
    ast_free(&ast);
    return good;
}
