// Statements evaluated while the rest of the file is still text. A file of a million literal
// spheres would else have a tree of 250 MB, which costs more time than reading it.
//
// Names mean what they mean whatever the order of items, so a statement may be evaluated early only
// if nothing that follows can change it: if its names are built in and not declared later, or stand
// for `let`s and `param`s of which the same holds. That is tried with the statements that consist
// of one kind with its fields, from the top of the file to the first item that must wait, and their
// nodes are forgotten. All that was done is refused where it turns out that it may not be what
// would have come out otherwise: where a later item declares a name that was taken for a built-in
// one, where anything is reported meanwhile, or an error at any time (a limit would be passed at
// another place). Then the file is read anew, and as a whole. So early evaluation changes nothing
// but time and memory.
#include "lang/aside.h"
#include "lang/resolve.h"

enum {
    FIRST_SLOTS = 64,     // of the file's frame
    ENOUGH_REPEATS = 64,  // one after the other, before statements are evaluated beside one another
    FEW_REPEATS = 2,      // the same, for tests
    UNIT_BYTES = 1 << 18, // of text that one thread takes at a time
    FEW_BYTES = 64,       // the same, for tests
    LEAST_UNITS = 4,      // worth the threads' start
};

typedef struct Early {
    Eval *ev;
    Module *module;
    Parser *parser;
    Resolver resolver;
    DiagMark mark;
    uint32_t declared; // items that stay in the file and were declared
    uint32_t repeated; // statements one after the other that were repeated
} Early;

// The file's frame grows with its names. No value holds it yet: functions wait.
static void make_slots(Early *e)
{
    Module *module = e->module;
    Env *old = module->env;
    if (old && e->resolver.next_slot <= old->slot_count) {
        return;
    }
    const uint32_t count = old ? e->resolver.next_slot * 2 : FIRST_SLOTS;
    Env *env = env_new(e->ev, NULL, module, count);
    if (old) {
        memcpy(env->slots, old->slots, old->slot_count * sizeof *env->slots);
    }
    module->env = env;
}

static bool is_refused(Early *e)
{
    e->ev->refused = e->ev->refused || e->resolver.refused || diag_is_since(e->ev->sink, e->mark);
    return e->ev->refused;
}

// Whether a statement is one kind that stands for itself, and means the same whatever follows.
static bool may_be_early(Early *e, AstId item)
{
    const Ast *ast = &e->module->ast;
    const AstNode *node = ast_node(ast, ast_node(ast, item)->a);
    const Eval *ev = e->ev;
    if (node->tag != AST_KIND || !node->a || node->a >= ev->symbol_count ||
        !ev->symbols[node->a].kind) {
        return false;
    }
    const NodeType *type = ev->kinds[ev->symbols[node->a].kind - 1].type;
    return type->role == ROLE_PLAIN && resolver_knows(&e->resolver, item);
}

// True when more may follow.
static bool run_resolved(Early *e, AstId item)
{
    Eval *ev = e->ev;
    RegionMark region = region_enter(ev);
    run_items(ev, e->module->env, &item, 1);
    region_leave(ev, region);
    ev->early = true;
    return !is_refused(e) && go_on(ev);
}

// Likewise; a statement that was just read.
static bool run_statement(Early *e, AstId item)
{
    Eval *ev = e->ev;
    if (!may_be_early(e, item)) {
        return false;
    }
    if (parser_learn(e->parser, item)) {
        resolver_resolve(&e->resolver, item);
        parser_take_out(e->parser, true);
        return !is_refused(e) && run_resolved(e, item);
    }
    const size_t constants = e->module->constants.count;
    RegionMark region = region_enter(ev); // of what the resolver makes, colors
    resolver_resolve(&e->resolver, item);
    const bool more = !is_refused(e) && run_resolved(e, item);
    region_leave(ev, region);
    e->module->constants.count = constants;
    parser_take_out(e->parser, false);
    return more;
}

// Likewise; an item of another sort.
static bool take_item(Early *e, AstId item)
{
    const AstTag tag = (AstTag)e->module->ast.nodes.items[item].tag;
    if (tag != AST_LET && tag != AST_FN && tag != AST_PARAM) {
        // What imported files bring comes before all statements.
        e->ev->refused = e->ev->refused || (tag == AST_IMPORT && e->ev->early);
        return false;
    }
    resolver_declare(&e->resolver, item);
    ++e->declared;
    make_slots(e);
    const bool learnt = tag != AST_FN && resolver_learn(&e->resolver, item);
    if (tag == AST_PARAM && !learnt) {
        e->ev->refused = e->ev->refused || e->ev->early;
        return false;
    }
    return !is_refused(e);
}

// --- Beside one another ------------------------------------------------------------------------

// The file, with nodes of a thread's own, into which the numbers of repeated statements go.
typedef struct Copy {
    Module module;
    Env *env;
} Copy;

typedef struct Beside {
    const Parser *parser;
    Copy *copies; // by thread
    RepeatRun *runs;
} Beside;

static bool copy_file(Copy *copy, const Module *module)
{
    const size_t nodes = module->ast.nodes.count;
    const size_t bytes = sizeof *copy->env + module->env->slot_count * sizeof(Value);
    copy->module = *module;
    copy->module.ast.nodes.items = mem_alloc(nodes, sizeof *copy->module.ast.nodes.items);
    copy->env = mem_alloc(1, bytes);
    if (!copy->module.ast.nodes.items || !copy->env) {
        return false;
    }
    memcpy(copy->module.ast.nodes.items, module->ast.nodes.items,
           nodes * sizeof *module->ast.nodes.items);
    memcpy(copy->env, module->env, bytes);
    copy->env->module = &copy->module;
    copy->module.env = copy->env;
    return true;
}

static bool run_repeats(Eval *ev, void *context, uint32_t unit, unsigned worker)
{
    const Beside *beside = context;
    Copy *copy = &beside->copies[worker];
    RepeatRun *run = &beside->runs[unit];
    while (run->at < run->end && !ev->stop) {
        const AstId item = parser_run_item(beside->parser, run, &copy->module.ast);
        if (!item) {
            break;
        }
        RegionMark region = region_enter(ev);
        run_items(ev, copy->env, &item, 1);
        region_leave(ev, region);
    }
    return run->at == run->end; // else the next begins within a statement
}

// Cuts the text at what seem to be borders of statements.
static uint32_t cut_runs(const Early *e, RepeatRun *runs, uint32_t most)
{
    const size_t bytes = e->ev->lang->aside_always ? FEW_BYTES : UNIT_BYTES;
    RepeatRun run = parser_run(e->parser);
    const char *end = run.end;
    uint32_t count = 0;
    while (count < most && (size_t)(end - run.at) > bytes) {
        run.end = parser_find_repeat(e->parser, run.at + bytes);
        if (!run.end) {
            break;
        }
        runs[count++] = run;
        run.at = run.end;
    }
    return count;
}

static void run_beside(Early *e, const Beside *beside, uint32_t most)
{
    Eval *ev = e->ev;
    const uint32_t least = ev->lang->aside_always ? 1 : LEAST_UNITS;
    for (;;) {
        const uint32_t count = cut_runs(e, beside->runs, most);
        if (count < least || aside_units(ev) == 0) {
            return;
        }
        const uint32_t done = aside_run(ev, run_repeats, (void *)(uintptr_t)beside, count);
        uint32_t last = done; // + 1: the last that read anything
        while (last > 0 && !beside->runs[last - 1].behind) {
            --last;
        }
        if (last > 0) {
            parser_pass_run(e->parser, &beside->runs[last - 1]);
        }
        if (last < count || beside->runs[last - 1].at != beside->runs[last - 1].end) {
            return;
        }
    }
}

// What follows, as far as it repeats what was learnt.
static void read_beside(Early *e)
{
    const uint32_t most = aside_units(e->ev);
    const uint32_t threads = most < e->ev->lang->threads ? most : e->ev->lang->threads;
    Beside beside = {.parser = e->parser,
                     .copies = mem_alloc_zeroed(threads, sizeof *beside.copies),
                     .runs = mem_alloc(most, sizeof *beside.runs)};
    bool good = most && beside.copies && beside.runs;
    for (uint32_t i = 0; good && i < threads; ++i) {
        good = copy_file(&beside.copies[i], e->module);
    }
    if (good) {
        run_beside(e, &beside, most);
    }
    for (uint32_t i = 0; beside.copies && i < threads; ++i) {
        mem_free(beside.copies[i].module.ast.nodes.items);
        mem_free(beside.copies[i].env);
    }
    mem_free(beside.copies);
    mem_free(beside.runs);
}

static bool read_again(Early *e, AstId item)
{
    const bool always = e->ev->lang->aside_always;
    if (is_refused(e) || !run_resolved(e, item)) {
        return false;
    }
    if (++e->repeated == (always ? FEW_REPEATS : ENOUGH_REPEATS)) {
        e->repeated = 0;
        read_beside(e);
        return !is_refused(e) && go_on(e->ev);
    }
    return true;
}

static bool read_on(Early *e)
{
    const AstId again = parser_repeat_item(e->parser);
    if (again) {
        return read_again(e, again);
    }
    e->repeated = 0;
    const AstId item = parser_read_item(e->parser);
    resolver_make_room(&e->resolver);
    if (!item || parser_is_out_of_memory(e->parser) || is_refused(e)) {
        return false;
    }
    return e->module->ast.nodes.items[item].tag == AST_EMIT ? run_statement(e, item)
                                                            : take_item(e, item);
}

static void read_early(Early *e)
{
    if (parser_has_items(e->parser)) {
        return; // what stands in a header's place was read with it, and waits
    }
    while (!parser_at_end(e->parser) && read_on(e)) {
    }
}

// The items that were left, as ever.
static void resolve_rest(Early *e)
{
    const Ast *ast = &e->module->ast;
    const uint32_t list = ast_node(ast, ast->root)->a;
    const uint32_t count = ast_list_count(ast, list);
    resolver_make_room(&e->resolver);
    for (uint32_t i = e->declared; i < count; ++i) {
        resolver_declare(&e->resolver, ast_list_items(ast, list)[i]);
    }
    if (e->resolver.refused) { // a name that was relied on
        e->ev->refused = true;
        return;
    }
    for (uint32_t i = 0; i < count; ++i) {
        resolver_resolve(&e->resolver, ast_list_items(ast, list)[i]);
    }
    resolver_end(&e->resolver);
    make_slots(e);
}

// The tree is whole: what was left of the file is loaded as ever.
static void load_rest(Early *e)
{
    Module *module = e->module;
    if (e->ev->sink->errors != e->mark.errors) { // what could be read is looked through as a whole
        e->ev->refused = true;
        return;
    }
    load_imports(e->ev, module);
    resolve_rest(e);
    module->parsed = true;
}

Module *module_load_early(Eval *ev, uint32_t file)
{
    Early e = {.ev = ev, .module = module_new(ev, file, false), .mark = diag_mark(ev->sink)};
    Module *module = e.module;
    Emitter emitter = {.is_identity = true, .material = NONE_ID};
    ev->emitter = &emitter;
    module->parser = e.parser = parser_new(&module->ast, &ev->lang->sources, file, ev->names,
                                           parse_limits(ev->lang), ev->sink);
    resolver_begin(&e.resolver, ev, module);
    make_slots(&e);
    if (e.parser) {
        read_early(&e);
    }
    if (ev->refused) {
        return module;
    }
    module->failed = !e.parser || !parser_finish(e.parser); // memory ran out
    parser_free(e.parser);
    module->parser = NULL;
    if (!module->failed) {
        load_rest(&e);
    }
    return module;
}
