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
#include "lang/resolve.h"

enum { FIRST_SLOTS = 64 }; // of the file's frame

typedef struct Early {
    Eval *ev;
    Module *module;
    Parser *parser;
    Resolver resolver;
    DiagMark mark;
    uint32_t declared; // items that stay in the file and were declared
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

static bool read_on(Early *e)
{
    const AstId again = parser_repeat_item(e->parser);
    if (again) {
        return !is_refused(e) && run_resolved(e, again);
    }
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
    module->parser = e.parser =
        parser_new(&module->ast, &ev->lang->sources, file, ev->names, parse_limits(ev), ev->sink);
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
