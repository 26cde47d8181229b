#include "lsp/tree.h"

// --- Children ------------------------------------------------------------------------------------

typedef struct Walk {
    const Ast *ast;
    TreeVisit *visit;
    void *context;
} Walk;

static void one(const Walk *walk, AstId child)
{
    if (child) {
        walk->visit(walk->context, child);
    }
}

static void list(const Walk *walk, uint32_t at)
{
    for (uint32_t i = 0; i < ast_list_count(walk->ast, at); ++i) {
        one(walk, ast_list_items(walk->ast, at)[i]);
    }
}

void tree_children(const Ast *ast, AstId id, TreeVisit *visit, void *context)
{
    const Walk walk = {ast, visit, context};
    const AstNode *node = ast_node(ast, id);
    const uint32_t *words = ast->extra.items;
    switch ((AstTag)node->tag) {
    case AST_FILE:
    case AST_BLOCK:
    case AST_VECTOR:
    case AST_LIST:
        list(&walk, node->a);
        break;
    case AST_PARAM:
        one(&walk, words[node->b + 3]);
        one(&walk, words[node->b + 4]);
        one(&walk, words[node->b + 5]);
        break;
    case AST_LET:
        one(&walk, words[node->b + 2]);
        break;
    case AST_FN:
        list(&walk, words[node->b + 3]);
        one(&walk, words[node->b + 2]);
        break;
    case AST_FOR:
        one(&walk, words[node->b + 2]);
        one(&walk, words[node->b + 3]);
        break;
    case AST_IF:
        one(&walk, node->a);
        one(&walk, words[node->b]);
        one(&walk, words[node->b + 1]);
        break;
    case AST_EXPECT:
        one(&walk, node->a);
        one(&walk, words[node->b]);
        one(&walk, words[node->b + 1]);
        break;
    case AST_IMPORT:
    case AST_EMIT:
    case AST_UNARY:
    case AST_MEMBER:
        one(&walk, node->a);
        break;
    case AST_RANGE:
    case AST_BINARY:
    case AST_INDEX:
        one(&walk, node->a);
        one(&walk, node->b);
        break;
    case AST_CALL:
    case AST_WITH:
        one(&walk, node->a);
        list(&walk, node->b);
        break;
    case AST_KIND:
        list(&walk, node->b);
        break;
    case AST_PARAMETER:
    case AST_ARGUMENT:
    case AST_FIELD:
        one(&walk, node->b);
        break;
    default: // leaves
        break;
    }
}

typedef struct Search {
    const Ast *ast;
    uint32_t offset;
    AstId inside, touching; // the child that holds the byte, and one that ends before it
} Search;

static void look(void *context, AstId child)
{
    Search *search = context;
    const AstNode *node = ast_node(search->ast, child);
    if (node->begin <= search->offset && search->offset < node->end) {
        search->inside = search->inside ? search->inside : child;
    } else if (node->end == search->offset && node->begin < node->end) {
        search->touching = child;
    }
}

void tree_path(const Ast *ast, uint32_t offset, TreePath *path)
{
    path->count = 0;
    AstId id = ast->nodes.count > 1 ? ast->root : 0;
    while (id && path->count < TREE_DEEPEST) {
        path->nodes[path->count++] = id;
        Search search = {.ast = ast, .offset = offset};
        tree_children(ast, id, look, &search);
        id = search.inside ? search.inside : search.touching;
    }
}

// --- Kinds and functions -------------------------------------------------------------------------

const NodeType *tree_kind(const Analysis *analysis, const AstNode *kind)
{
    const Schema *schema = analysis->lang.schema;
    int number = kind->a ? schema_find(schema, tree_symbol(analysis, kind->a)) : -1;
    return number >= 0 && !schema->types[number]->internal ? schema->types[number] : NULL;
}

enum { MOST_STEPS = 32 }; // of following names; a chain may lead in a circle

const NodeType *tree_infer_kind(const Analysis *analysis, uint32_t file, AstId id)
{
    for (int step = 0; id && step < MOST_STEPS; ++step) {
        const Ast *ast = survey_ast(analysis->survey, file);
        const AstNode *node = ast_node(ast, id);
        switch ((AstTag)node->tag) {
        case AST_KIND:
            return tree_kind(analysis, node);
        case AST_WITH:
        case AST_CALL:
            id = node->a;
            break;
        case AST_IF:
        case AST_LET:
            id = tree_words(ast, node)[node->tag == AST_LET ? 2 : 0];
            break;
        case AST_FN:
            id = tree_words(ast, node)[2];
            break;
        case AST_NAME:
        case AST_MEMBER: {
            Meaning meaning = survey_meaning(analysis->survey, file, id);
            id = meaning.kind == MEANS_ITEM ? meaning.item : 0;
            file = meaning.file;
            break;
        }
        default:
            return NULL;
        }
    }
    return NULL;
}

AstId tree_function(const Analysis *analysis, uint32_t *file, AstId id)
{
    for (int step = 0; id && step < MOST_STEPS; ++step) {
        const Ast *ast = survey_ast(analysis->survey, *file);
        const AstNode *node = ast_node(ast, id);
        if (node->tag == AST_FN) {
            return id;
        }
        if (node->tag == AST_LET) {
            id = tree_words(ast, node)[2];
        } else if (node->tag == AST_NAME || node->tag == AST_MEMBER) {
            Meaning meaning = survey_meaning(analysis->survey, *file, id);
            id = meaning.kind == MEANS_ITEM ? meaning.item : 0;
            *file = meaning.file;
        } else {
            return 0;
        }
    }
    return 0;
}

AstId tree_parameter_at(const Ast *ast, AstId fn, uint32_t index)
{
    uint32_t parameters = tree_words(ast, ast_node(ast, fn))[3];
    return index < ast_list_count(ast, parameters) ? ast_list_items(ast, parameters)[index] : 0;
}

AstId tree_parameter(const Ast *ast, AstId fn, Symbol name)
{
    AstId parameter = 0;
    for (uint32_t i = 0; name && (parameter = tree_parameter_at(ast, fn, i)); ++i) {
        if (ast_node(ast, parameter)->a == name) {
            return parameter;
        }
    }
    return 0;
}

Str tree_text(const Analysis *analysis, uint32_t file)
{
    const Ast *ast = survey_ast(analysis->survey, file);
    const Source *source = source_get(&analysis->lang.sources, ast->file);
    return source ? source->text : STR("");
}

const char *tree_file_path(const Analysis *analysis, uint32_t file)
{
    const Ast *ast = survey_ast(analysis->survey, file);
    const Source *source = source_get(&analysis->lang.sources, ast->file);
    return source ? source->real : NULL;
}

// --- What stands at a place ----------------------------------------------------------------------

typedef struct Finder {
    const Analysis *analysis;
    const Ast *ast;
    uint32_t offset;
    TreePath path;
} Finder;

static const AstNode *up(const Finder *f, size_t levels)
{
    return levels < f->path.count ? ast_node(f->ast, f->path.nodes[f->path.count - 1 - levels])
                                  : NULL;
}

static bool covers(Target *target, const Finder *f, uint32_t begin, uint32_t end)
{
    target->begin = begin;
    target->end = end;
    return begin < end && begin <= f->offset && f->offset <= end;
}

static bool covers_name(Target *target, const Finder *f, const AstNode *node, Symbol name)
{
    uint32_t length = (uint32_t)tree_symbol(f->analysis, name).length;
    return name && covers(target, f, node->begin, node->begin + length);
}

static void declared(Target *target, AstId item)
{
    target->kind = TARGET_NAME;
    target->meaning = (Meaning){.kind = MEANS_ITEM, .item = item};
}

// The kind that a FIELD on the path belongs to.
static const NodeType *field_owner(const Finder *f, size_t level)
{
    const AstNode *owner = up(f, level + 1);
    if (!owner) {
        return NULL;
    }
    return owner->tag == AST_KIND   ? tree_kind(f->analysis, owner)
           : owner->tag == AST_WITH ? tree_infer_kind(f->analysis, 0, owner->a)
                                    : NULL;
}

static void find_field(Target *target, const Finder *f, const AstNode *field, size_t level)
{
    target->type = field_owner(f, level);
    if (target->type) {
        target->param = survey_field(f->analysis->survey, target->type, field, &target->common);
    }
}

static void find_argument(Target *target, const Finder *f, const AstNode *argument)
{
    const AstNode *call = up(f, 1);
    if (!call || call->tag != AST_CALL || !covers_name(target, f, argument, argument->a)) {
        return;
    }
    uint32_t file = 0;
    AstId fn = tree_function(f->analysis, &file, call->a);
    AstId parameter =
        fn ? tree_parameter(survey_ast(f->analysis->survey, file), fn, argument->a) : 0;
    if (parameter) {
        target->kind = TARGET_NAME;
        target->meaning = (Meaning){.kind = MEANS_ITEM, .file = file, .item = parameter};
    }
}

static void find_string(Target *target, const Finder *f)
{
    target->kind = TARGET_STRING;
    const AstNode *parent = up(f, 1);
    if (parent && parent->tag == AST_IMPORT) {
        target->kind = TARGET_IMPORT;
        target->node = f->path.nodes[f->path.count - 2];
    } else if (parent && parent->tag == AST_FIELD) {
        find_field(target, f, parent, 1);
    }
}

static void find_member(Target *target, const Finder *f, const AstNode *node)
{
    const Ast *ast = f->ast;
    AstId id = f->path.nodes[f->path.count - 1];
    uint32_t value_end = ast_node(ast, node->a)->end;
    const char *text = tree_text(f->analysis, 0).at;
    uint32_t begin = node->end;
    while (begin > value_end && text[begin - 1] != '.' && (unsigned char)text[begin - 1] > ' ') {
        --begin;
    }
    if (covers(target, f, begin, node->end)) {
        target->meaning = survey_meaning(f->analysis->survey, 0, id);
        target->kind = target->meaning.kind == MEANS_NOTHING ? TARGET_NONE : TARGET_NAME;
    }
}

static void find_declaration(Target *target, const Finder *f, AstId id)
{
    Span name = survey_name_span(f->analysis->survey, 0, id);
    const AstNode *node = ast_node(f->ast, id);
    if (node->tag == AST_PARAM) {
        const uint32_t *words = tree_words(f->ast, node);
        if (covers(target, f, words[6], words[7])) {
            target->kind = TARGET_TYPE;
            return;
        }
    }
    if (covers(target, f, name.begin, name.end)) {
        declared(target, id);
    }
}

static void find_leaf(Target *target, const Finder *f)
{
    AstId id = f->path.nodes[f->path.count - 1];
    const AstNode *node = ast_node(f->ast, id);
    target->node = id;
    target->begin = node->begin;
    target->end = node->end;
    switch ((AstTag)node->tag) {
    case AST_LET:
    case AST_PARAM:
    case AST_FN:
    case AST_FOR:
    case AST_IMPORT:
    case AST_PARAMETER:
        find_declaration(target, f, id);
        break;
    case AST_NAME:
        target->meaning = survey_meaning(f->analysis->survey, 0, id);
        target->kind = target->meaning.kind == MEANS_NOTHING ? TARGET_NONE : TARGET_NAME;
        break;
    case AST_MEMBER:
        find_member(target, f, node);
        break;
    case AST_KIND:
        target->type = tree_kind(f->analysis, node);
        if (target->type && covers_name(target, f, node, node->a)) {
            target->kind = TARGET_KIND;
        }
        break;
    case AST_FIELD:
        find_field(target, f, node, 0);
        if (target->type && covers_name(target, f, node, node->a)) {
            target->kind = TARGET_FIELD;
        }
        break;
    case AST_ARGUMENT:
        find_argument(target, f, node);
        break;
    case AST_STRING:
        find_string(target, f);
        break;
    case AST_NUMBER:
        target->kind = TARGET_NUMBER;
        break;
    case AST_COLOR:
        target->kind = TARGET_COLOR;
        break;
    default:
        break;
    }
}

Target target_at(const Analysis *analysis, uint32_t offset)
{
    Finder f = {.analysis = analysis, .ast = survey_ast(analysis->survey, 0), .offset = offset};
    Target target = {.kind = TARGET_NONE};
    tree_path(f.ast, offset, &f.path);
    if (f.path.count > 0) {
        find_leaf(&target, &f);
    }
    return target;
}
