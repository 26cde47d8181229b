// Files: parsing, and the imports between them. A file is read once, however many import it.
#include "base/hash.h"
#include "lang/numeric.h"

static const uint32_t *item_words(const Module *module, AstId item)
{
    return &module->ast.extra.items[module->ast.nodes.items[item].b];
}

Span item_name_span(const Module *module, AstId item)
{
    const AstNode *node = &module->ast.nodes.items[item];
    const uint32_t *words = item_words(module, item);
    switch ((AstTag)node->tag) {
    case AST_LET:
    case AST_PARAM:
    case AST_FN:
    case AST_FOR:
        return (Span){module->file, words[0], words[1]};
    case AST_IMPORT:
        return (Span){module->file, words[1], words[2]};
    default:
        return ast_span(&module->ast, item);
    }
}

Symbol item_symbol(const Module *module, AstId item)
{
    const AstNode *node = &module->ast.nodes.items[item];
    return node->tag == AST_IMPORT ? item_words(module, item)[0] : node->a;
}

int64_t module_find(const Module *module, Symbol name)
{
    uint32_t at = hash_u32(name) & module->global_mask;
    for (; module->global_slots && module->global_slots[at]; at = (at + 1) & module->global_mask) {
        if (module->globals.items[module->global_slots[at] - 1].name == name) {
            return module->global_slots[at] - 1;
        }
    }
    return -1;
}

static void module_free(Module *module)
{
    parser_free(module->parser);
    ast_free(&module->ast);
    array_free(&module->globals);
    array_free(&module->constants);
    numeric_free(module);
}

void modules_free(Eval *ev)
{
    for (size_t i = 0; i < ev->modules.count; ++i) {
        module_free(ev->modules.items[i]);
    }
    array_free(&ev->modules);
}

// --- Imports ---------------------------------------------------------------------------------

static const Module *find_loaded(const Eval *ev, const char *real)
{
    for (size_t i = 0; i < ev->modules.count; ++i) {
        const char *other = source_get(&ev->lang->sources, ev->modules.items[i]->file)->real;
        if (other && strcmp(other, real) == 0) {
            return ev->modules.items[i];
        }
    }
    return NULL;
}

// How the file is shown: as written in the import, after the folder of the importing file as that
// is shown.
static const char *shown_path(Eval *ev, uint32_t from, Str written)
{
    const char *outer = source_get(&ev->lang->sources, from)->path;
    const char *slash = strrchr(outer, '/');
    int folder = slash && written.length && written.at[0] != '/' ? (int)(slash + 1 - outer) : 0;
    return arena_printf(ev->arena, "%.*s%s", folder, outer, written.at);
}

static uint32_t read_source(Eval *ev, const char *real, const char *shown, Span at, Span path_at)
{
    Lang *lang = ev->lang;
    Str given;
    if (lang->find_given && lang->find_given(lang->find_given_context, real, &given)) {
        uint32_t file = sources_add(&lang->sources, shown, real, given, at);
        if (!file) {
            out_of_memory(ev);
        }
        return file;
    }
    FileBytes bytes;
    IoError error = sandbox_read(lang->sandbox, real, &bytes);
    if (error == IO_OK && bytes.size > lang->limits.file_bytes) {
        file_bytes_free(&bytes);
        error = IO_TOO_LARGE;
    }
    if (error == IO_NO_MEMORY) {
        out_of_memory(ev);
    }
    if (error != IO_OK) {
        report(ev, E0601, path_at, "`%s` can't be read: %s", shown, io_error_text(error));
        return 0;
    }
    if (!array_push(&lang->files, bytes)) {
        file_bytes_free(&bytes);
        out_of_memory(ev);
    }
    uint32_t file = sources_add(&lang->sources, shown, real, (Str){bytes.bytes, bytes.size}, at);
    if (!file) {
        out_of_memory(ev);
    }
    return file;
}

static void report_import_cycle(Eval *ev, Span at, Str written)
{
    Diag *diag = report(ev, E0602, at, "`%s` imports itself", written.at);
    diag_label(ev->sink, diag, "this file is still being read");
    diag_note(ev->sink, diag, "move what both files need into a third one");
}

// The file that an import names: relative to the file that it stands in; but where there is no such
// file and the name begins with std/, that of the standard library.
static IoError find_file(Eval *ev, const Module *module, Str written, const char **real)
{
    const Sandbox *sandbox = ev->lang->sandbox;
    const char *from = source_get(&ev->lang->sources, module->file)->real;
    const IoError error = sandbox_resolve(sandbox, ev->arena, from, written, real);
    const bool library =
        ev->lang->library && written.length > 4 && memcmp(written.at, "std/", 4) == 0;
    if (!library || (error == IO_OK && sandbox_has(sandbox, *real))) {
        return error;
    }
    return sandbox_resolve(sandbox, ev->arena, ev->lang->library, written, real);
}

// The number of the imported module + 1, or 0 after a report.
static uint32_t import_file(Eval *ev, Module *module, AstId item)
{
    const AstNode *node = &module->ast.nodes.items[item];
    Span at = ast_span(&module->ast, item);
    const AstNode *path = &module->ast.nodes.items[node->a];
    Span path_at = ast_span(&module->ast, node->a);
    Str written = symbol_name(ev->names, path->a);
    const char *real;
    IoError error = find_file(ev, module, written, &real);
    if (error != IO_OK) {
        report(ev, E0601, path_at, "`%s` can't be read: %s", written.at, io_error_text(error));
        return 0;
    }
    const Module *loaded = find_loaded(ev, real);
    if (loaded && !loaded->parsed) {
        report_import_cycle(ev, path_at, written);
        return 0;
    }
    if (loaded) {
        return loaded->number + 1;
    }
    if (ev->import_depth >= ev->lang->limits.import_depth || ev->modules.count >= UINT16_MAX - 1) {
        Diag *diag = report(ev, E0705, path_at, "imports are nested more than %llu deep",
                            (unsigned long long)ev->lang->limits.import_depth);
        diag_note(ev->sink, diag, "--limit import_depth=N raises this");
        return 0;
    }
    uint32_t file = read_source(ev, real, shown_path(ev, module->file, written), at, path_at);
    if (!file) {
        return 0;
    }
    ++ev->import_depth;
    const Module *imported = module_load_text(ev, file, true);
    --ev->import_depth;
    return imported->number + 1;
}

// Whether an item, or one in the blocks of a `for` or `if`, emits something. Expectations don't.
static bool emits(const Ast *ast, AstId item)
{
    const AstNode *node = ast_node(ast, item);
    bool found = false;
    switch ((AstTag)node->tag) {
    case AST_EMIT:
        return true;
    case AST_FOR:
        return emits(ast, ast->extra.items[node->b + 3]);
    case AST_IF:
        return emits(ast, ast->extra.items[node->b]) || emits(ast, ast->extra.items[node->b + 1]);
    case AST_BLOCK:
        for (uint32_t i = 0; i < ast_list_count(ast, node->a) && !found; ++i) {
            found = emits(ast, ast_list_items(ast, node->a)[i]);
        }
        return found;
    default:
        return false;
    }
}

// An import gives names only: what the file itself would emit is left out, and that is said.
static void warn_of_items(Eval *ev, const Module *module, AstId import)
{
    uint32_t number = module->ast.nodes.items[import].aux;
    const Module *imported = number ? ev->modules.items[number - 1] : NULL;
    if (!imported || imported->failed) {
        return;
    }
    const Ast *ast = &imported->ast;
    uint32_t list = ast->nodes.items[ast->root].a;
    for (uint32_t i = 0; i < ast_list_count(ast, list); ++i) {
        AstId item = ast_list_items(ast, list)[i];
        if (emits(ast, item)) {
            Place place =
                source_place(&ev->lang->sources, imported->file, ast->nodes.items[item].begin);
            Diag *diag = report(ev, W0601, ast_span(&module->ast, import),
                                "the items of the imported file are left out");
            diag_note(ev->sink, diag, "an import gives names only; the first item is at %s:%u:%u",
                      source_get(&ev->lang->sources, imported->file)->path, place.line,
                      place.column);
            return;
        }
    }
}

void load_imports(Eval *ev, Module *module)
{
    uint32_t list = module->ast.nodes.items[module->ast.root].a;
    for (uint32_t i = 0; i < ast_list_count(&module->ast, list); ++i) {
        AstId item = ast_list_items(&module->ast, list)[i];
        if (module->ast.nodes.items[item].tag == AST_IMPORT) {
            uint32_t number = import_file(ev, module, item);
            module->ast.nodes.items[item].aux = (uint16_t)number;
            warn_of_items(ev, module, item);
        }
    }
}

ParseLimits parse_limits(const Lang *lang)
{
    uint64_t nesting = lang->limits.nesting;
    return (ParseLimits){nesting < UINT32_MAX ? (uint32_t)nesting : UINT32_MAX};
}

Module *module_new(Eval *ev, uint32_t file, bool is_library)
{
    Module *module = ARENA_NEW(&ev->regions[0], Module);
    if (!array_push(&ev->modules, module)) {
        out_of_memory(ev);
    }
    module->number = (uint32_t)ev->modules.count - 1;
    module->file = file;
    module->is_library = is_library;
    return module;
}

Module *module_load_text(Eval *ev, uint32_t file, bool is_library)
{
    Module *module = module_new(ev, file, is_library);
    module->failed = !parse(&module->ast, &ev->lang->sources, file, ev->names,
                            parse_limits(ev->lang), false, ev->sink);
    if (module->ast.nodes.count > 1 && module->ast.root) {
        load_imports(ev, module);
        resolve_module(ev, module);
    }
    module->env = env_new(ev, NULL, module, module->slot_count);
    module->parsed = true;
    return module;
}
