#include "lang/survey.h"

#include "base/mem.h"
#include "lang/eval.h"

struct Survey {
    Lang *lang;
    Eval *ev;
    Scene scene; // stays empty
};

static void read_files(Eval *ev, uint32_t file)
{
    if (setjmp(ev->on_oom) != 0) {
        report_full(ev);
        return;
    }
    kinds_init(ev);
    ev->region = 1;
    ev->arena = &ev->regions[1];
    module_load_text(ev, file, false);
}

// Nothing may jump any more.
static void end_jumps(Eval *ev)
{
    for (int i = 0; i < REGION_COUNT; ++i) {
        ev->regions[i].on_oom = NULL;
    }
    ev->scene->arena.on_oom = NULL;
}

Survey *survey_open(Lang *lang, Str text, const char *path, const char *shown)
{
    uint32_t file = sources_add(&lang->sources, shown, path, text, (Span){0});
    Survey *survey = mem_alloc_zeroed(1, sizeof *survey);
    bool has_scene = survey && scene_init(&survey->scene, lang->schema, lang->sandbox);
    if (has_scene && file) {
        survey->lang = lang;
        survey->ev = eval_new(lang, &survey->scene, 0);
    }
    if (!survey || !survey->ev) {
        diag_report(&lang->sink, E0001, (Span){0}, "out of memory");
        if (has_scene) {
            scene_free(&survey->scene);
        }
        mem_free(survey);
        return NULL;
    }
    read_files(survey->ev, file);
    end_jumps(survey->ev);
    return survey;
}

void survey_free(Survey *survey)
{
    if (survey) {
        eval_free(survey->ev);
        scene_free(&survey->scene);
        mem_free(survey);
    }
}

// --- Files -----------------------------------------------------------------------------------

static const Module *module_at(const Survey *survey, uint32_t file)
{
    return survey->ev->modules.items[file];
}

uint32_t survey_file_count(const Survey *survey)
{
    return (uint32_t)survey->ev->modules.count;
}

const Ast *survey_ast(const Survey *survey, uint32_t file)
{
    return &module_at(survey, file)->ast;
}

int64_t survey_find_file(const Survey *survey, const char *real)
{
    for (uint32_t i = 0; i < survey_file_count(survey); ++i) {
        const Source *source = source_get(&survey->lang->sources, module_at(survey, i)->file);
        if (source->real && strcmp(source->real, real) == 0) {
            return i;
        }
    }
    return -1;
}

int64_t survey_import(const Survey *survey, uint32_t file, AstId item)
{
    return (int64_t)survey_ast(survey, file)->nodes.items[item].aux - 1;
}

AstId survey_find_global(const Survey *survey, uint32_t file, Str name)
{
    const Module *module = module_at(survey, file);
    Symbol symbol = interned(survey->ev->names, name);
    int64_t slot = symbol ? module_find(module, symbol) : -1;
    return slot >= 0 ? module->globals.items[slot].item : 0;
}

// --- Names -----------------------------------------------------------------------------------

static Meaning name_meaning(uint32_t file, const AstNode *node)
{
    switch ((NameKind)node->op) {
    case NAME_VARIABLE:
    case NAME_LET:
    case NAME_GLOBAL:
    case NAME_NAMESPACE:
        return (Meaning){.kind = MEANS_ITEM, .file = file, .item = node->b};
    case NAME_BUILTIN:
        return (Meaning){.kind = MEANS_BUILTIN, .number = node->a};
    case NAME_CONSTANT:
        return (Meaning){.kind = MEANS_CONSTANT, .number = node->a};
    case NAME_BAD:
        break;
    }
    return (Meaning){.kind = MEANS_NOTHING};
}

Meaning survey_meaning(const Survey *survey, uint32_t file, AstId id)
{
    const AstNode *node = ast_node(survey_ast(survey, file), id);
    if (node->tag == AST_NAME) {
        return name_meaning(file, node);
    }
    if (node->tag == AST_MEMBER && node->op == MEMBER_GLOBAL) {
        const Module *module = module_at(survey, node->aux);
        return (Meaning){
            .kind = MEANS_ITEM, .file = node->aux, .item = module->globals.items[node->b].item};
    }
    return (Meaning){.kind = MEANS_NOTHING};
}

Str survey_name(const Survey *survey, uint32_t file, AstId item)
{
    return symbol_name(survey->ev->names, item_symbol(module_at(survey, file), item));
}

Span survey_name_span(const Survey *survey, uint32_t file, AstId item)
{
    const Module *module = module_at(survey, file);
    Span span = item_name_span(module, item);
    if (module->ast.nodes.items[item].tag == AST_PARAMETER) {
        span.end = span.begin + (uint32_t)survey_name(survey, file, item).length;
    }
    return span;
}

Quantity survey_number(const Survey *survey, uint32_t file, AstId id)
{
    const AstNode *node = ast_node(survey_ast(survey, file), id);
    return (Quantity){ast_number(node), node->op};
}

// --- Colors ----------------------------------------------------------------------------------

// A number written out, perhaps negated or computed of such.
static bool is_written_out(const Ast *ast, AstId id, int depth)
{
    const AstNode *node = ast_node(ast, id);
    enum { DEEPEST = 16 };
    switch ((AstTag)node->tag) {
    case AST_NUMBER:
        return true;
    case AST_COLOR:
        return node->op == COLOR_DECODED;
    case AST_UNARY:
        return depth < DEEPEST && is_written_out(ast, node->a, depth + 1);
    case AST_BINARY:
        return depth < DEEPEST && is_written_out(ast, node->a, depth + 1) &&
               is_written_out(ast, node->b, depth + 1);
    default:
        return false;
    }
}

static bool is_color_call(const Ast *ast, const AstNode *call)
{
    static const char *const names[] = {"rgb", "srgb", "hsv", "gray", "blackbody"};
    const AstNode *callee = ast_node(ast, call->a);
    if (callee->tag != AST_NAME || callee->op != NAME_BUILTIN) {
        return false;
    }
    bool known = false;
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        known = known || strcmp(names[i], builtins[callee->a].name) == 0;
    }
    uint32_t count = ast_list_count(ast, call->b);
    for (uint32_t i = 0; i < count && known; ++i) {
        known = is_written_out(ast, ast_list_items(ast, call->b)[i], 0);
    }
    return known && count > 0;
}

// Evaluates for once; mistakes go nowhere.
static Value evaluate_alone(Eval *ev, Env *env, AstId node)
{
    Value v = value_error();
    if (setjmp(ev->on_oom) == 0) {
        for (int i = 0; i < REGION_COUNT; ++i) {
            ev->regions[i].on_oom = &ev->on_oom;
        }
        v = eval(ev, env, node);
    }
    end_jumps(ev);
    return v;
}

bool survey_color(const Survey *survey, uint32_t file, AstId id, double color[3])
{
    const Module *module = module_at(survey, file);
    const AstNode *node = ast_node(&module->ast, id);
    bool is_color = node->tag == AST_COLOR && node->op == COLOR_DECODED;
    if (!is_color && (node->tag != AST_CALL || !is_color_call(&module->ast, node))) {
        return false;
    }
    Eval *ev = survey->ev;
    ArenaMark mark = arena_mark(ev->arena);
    Arena scratch = {0};
    DiagSink nowhere, *sink = ev->sink;
    diag_sink_init(&nowhere, &scratch);
    ev->sink = &nowhere;
    ev->stop = STOP_NOT;
    Value v = evaluate_alone(ev, module->env, id);
    ev->sink = sink;
    bool good = v.type == VALUE_COLOR;
    for (int i = 0; i < 3; ++i) {
        color[i] = good ? v.components[i] : 0;
    }
    arena_rewind(ev->arena, mark);
    diag_sink_free(&nowhere);
    arena_free(&scratch);
    return good;
}

const Param *survey_field(const Survey *survey, const NodeType *type, const AstNode *field,
                          CommonField *common)
{
    *common = 0;
    int number = schema_find(survey->lang->schema, str_from(type->name));
    int index = field_index(survey->ev, (uint32_t)number, field->a);
    if (index == FIELD_BAD || index == FIELD_ITEMS || index == FIELD_OF) {
        return NULL;
    }
    if (index & FIELD_COMMON) {
        *common = (CommonField)(index & 0xff);
        return NULL;
    }
    return &type->params[index - 1];
}
