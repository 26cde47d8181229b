#include "lsp/context.h"

#include "lang/lexer.h"

// --- Brackets ------------------------------------------------------------------------------------

enum { DEEPEST = 256 };

typedef enum BraceKind { BRACE_BLOCK, BRACE_KIND, BRACE_WITH } BraceKind;

typedef struct Bracket {
    uint32_t token; // that opens it; UINT32_MAX: the file
    BraceKind brace;
    uint32_t head;  // first token of what stands before it: a kind's name, a callee
    uint32_t field; // the token of the field or argument name at hand, or UINT32_MAX
    uint32_t commas;
    // ( of a call; of a function's parameters or of a `for`; of an `if`
    bool is_call, is_header, is_condition;
} Bracket;

typedef struct Scan {
    const DocumentTokens *tokens;
    Str text;
    uint32_t *significant; // tokens that are no comments
    uint32_t count;        // of them, up to the place
    Bracket stack[DEEPEST];
    uint32_t depth;
    uint32_t condition_end; // the `)` of the last `if`'s condition
} Scan;

static const DocumentToken *token(const Scan *scan, uint32_t i)
{
    return i < scan->count ? &scan->tokens->items[scan->significant[i]] : NULL;
}

static uint8_t kind_at(const Scan *scan, uint32_t i)
{
    const DocumentToken *found = token(scan, i);
    return found ? found->kind : TOKEN_END;
}

static Str token_text(const Scan *scan, uint32_t i)
{
    const DocumentToken *found = token(scan, i);
    return found ? (Str){scan->text.at + found->begin, found->end - found->begin} : STR("");
}

static bool ends_value(uint8_t kind)
{
    switch (kind) {
    case TOKEN_NAME:
    case TOKEN_NUMBER:
    case TOKEN_STRING:
    case TOKEN_COLOR:
    case TOKEN_TRUE:
    case TOKEN_FALSE:
    case TOKEN_RIGHT_PAREN:
    case TOKEN_RIGHT_BRACKET:
    case TOKEN_RIGHT_BRACE:
        return true;
    default:
        return false;
    }
}

// The first token of `a.b.c` that ends with token `last`.
static uint32_t chain_begin(const Scan *scan, uint32_t last)
{
    while (last >= 2 && kind_at(scan, last - 1) == TOKEN_DOT &&
           kind_at(scan, last - 2) == TOKEN_NAME) {
        last -= 2;
    }
    return last;
}

static void open_bracket(Scan *scan, uint32_t i)
{
    Bracket bracket = {.token = i, .head = UINT32_MAX, .field = UINT32_MAX};
    uint8_t before = i > 0 ? kind_at(scan, i - 1) : TOKEN_END;
    uint8_t kind = kind_at(scan, i);
    if (before == TOKEN_NAME) {
        bracket.head = kind == TOKEN_LEFT_BRACE ? i - 1 : chain_begin(scan, i - 1);
    }
    if (kind == TOKEN_LEFT_BRACE) {
        bracket.brace = before == TOKEN_NAME   ? BRACE_KIND
                        : before == TOKEN_WITH ? BRACE_WITH
                                               : BRACE_BLOCK;
    } else if (kind == TOKEN_LEFT_PAREN) {
        bool declares = before == TOKEN_FN || before == TOKEN_FOR ||
                        (before == TOKEN_NAME && i > 1 && kind_at(scan, i - 2) == TOKEN_FN);
        bracket.is_header = declares;
        bracket.is_condition = before == TOKEN_IF;
        bracket.is_call = before == TOKEN_NAME && !declares;
    }
    if (scan->depth < DEEPEST) {
        scan->stack[scan->depth] = bracket;
    }
    ++scan->depth;
}

static Bracket *top(Scan *scan)
{
    return &scan->stack[(scan->depth < DEEPEST ? scan->depth : DEEPEST) - 1];
}

static void take(Scan *scan, uint32_t i)
{
    switch (kind_at(scan, i)) {
    case TOKEN_LEFT_BRACE:
    case TOKEN_LEFT_PAREN:
    case TOKEN_LEFT_BRACKET:
        open_bracket(scan, i);
        break;
    case TOKEN_RIGHT_BRACE:
        while (scan->depth > 1 && kind_at(scan, top(scan)->token) != TOKEN_LEFT_BRACE) {
            --scan->depth; // forgotten
        }
        scan->depth -= scan->depth > 1;
        break;
    case TOKEN_RIGHT_PAREN:
    case TOKEN_RIGHT_BRACKET:
        if (scan->depth > 1 && kind_at(scan, top(scan)->token) != TOKEN_LEFT_BRACE) {
            scan->condition_end = top(scan)->is_condition ? i : scan->condition_end;
            --scan->depth;
        }
        break;
    case TOKEN_COMMA:
        ++top(scan)->commas;
        top(scan)->field = UINT32_MAX;
        break;
    case TOKEN_COLON:
        if (i > 0 && kind_at(scan, i - 1) == TOKEN_NAME) {
            top(scan)->field = i - 1;
        }
        break;
    default:
        break;
    }
}

// --- What may follow -----------------------------------------------------------------------------

static void collect_given(Scan *scan, const Bracket *bracket, Context *context)
{
    uint32_t depth = 0;
    for (uint32_t i = bracket->token + 1; i < scan->count; ++i) {
        uint8_t kind = kind_at(scan, i);
        bool opens =
            kind == TOKEN_LEFT_BRACE || kind == TOKEN_LEFT_PAREN || kind == TOKEN_LEFT_BRACKET;
        bool closes =
            kind == TOKEN_RIGHT_BRACE || kind == TOKEN_RIGHT_PAREN || kind == TOKEN_RIGHT_BRACKET;
        depth += opens;
        depth -= closes && depth > 0;
        if (kind == TOKEN_COLON && depth == 0 && context->given_fields < CONTEXT_GIVEN) {
            context->given[context->given_fields++] = token_text(scan, i - 1);
        }
    }
}

// Where a number's unit begins.
static uint32_t unit_begin(Str text, const DocumentToken *number)
{
    uint32_t at = number->begin;
    while (at < number->end && (text.at[at] == '.' || text.at[at] == '_' ||
                                (text.at[at] >= '0' && text.at[at] <= '9'))) {
        ++at;
    }
    bool exponent = at + 1 < number->end && (text.at[at] | 0x20) == 'e' &&
                    (text.at[at + 1] == '-' || text.at[at + 1] == '+' ||
                     (text.at[at + 1] >= '0' && text.at[at + 1] <= '9'));
    if (exponent) {
        for (at += 2; at < number->end && text.at[at] >= '0' && text.at[at] <= '9'; ++at) {
        }
    }
    return at;
}

static const NodeType *bracket_type(const Analysis *analysis, const Scan *scan,
                                    const Bracket *bracket)
{
    if (bracket->brace == BRACE_KIND) {
        int number = schema_find(analysis->lang.schema, token_text(scan, bracket->head));
        return number >= 0 && !analysis->lang.schema->types[number]->internal
                   ? analysis->lang.schema->types[number]
                   : NULL;
    }
    uint32_t value = bracket->token - 2; // `value with {`
    AstId item = kind_at(scan, value) == TOKEN_NAME
                     ? context_find(analysis, token(scan, value)->begin, token_text(scan, value))
                     : 0;
    if (item) {
        return tree_infer_kind(analysis, 0, item);
    }
    TreePath path;
    tree_path(survey_ast(analysis->survey, 0), token(scan, value) ? token(scan, value)->begin : 0,
              &path);
    return path.count > 0 ? tree_infer_kind(analysis, 0, path.nodes[path.count - 1]) : NULL;
}

static void describe_brackets(const Analysis *analysis, Scan *scan, Context *context)
{
    for (uint32_t level = scan->depth < DEEPEST ? scan->depth : DEEPEST; level-- > 1;) {
        const Bracket *bracket = &scan->stack[level];
        uint8_t kind = kind_at(scan, bracket->token);
        bool is_innermost = level == scan->depth - 1;
        if (kind == TOKEN_LEFT_BRACKET && is_innermost) {
            context->in_list = true;
        }
        if (kind == TOKEN_LEFT_PAREN && bracket->is_call && !context->in_call) {
            uint32_t last = bracket->token - 1;
            context->in_call = true;
            context->callee_begin = token(scan, bracket->head)->begin;
            context->callee_end = token(scan, last)->end;
            context->argument = bracket->commas;
            context->argument_name =
                bracket->field == UINT32_MAX ? STR("") : token_text(scan, bracket->field);
            uint8_t before = kind_at(scan, scan->count - 1);
            context->argument_begins =
                is_innermost && (before == TOKEN_LEFT_PAREN || before == TOKEN_COMMA);
        }
        if (kind == TOKEN_LEFT_BRACE) {
            if (bracket->brace != BRACE_BLOCK) {
                context->in_with = bracket->brace == BRACE_WITH;
                context->type = bracket_type(analysis, scan, bracket);
                context->field =
                    bracket->field == UINT32_MAX ? STR("") : token_text(scan, bracket->field);
                collect_given(scan, bracket, context);
            }
            return;
        }
    }
}

// Behind token `last`, on the way to a new word.
static ContextKind follow(Scan *scan, Context *context)
{
    uint32_t last = scan->count - 1; // UINT32_MAX: nothing stands before
    uint8_t before = scan->count ? kind_at(scan, last) : TOKEN_END;
    Bracket *bracket = top(scan);
    uint8_t around = bracket->token == UINT32_MAX ? TOKEN_END : kind_at(scan, bracket->token);
    bool in_body = around == TOKEN_END || around == TOKEN_LEFT_BRACE;
    switch (before) {
    case TOKEN_DOT:
        context->member_of = last >= 1 ? scan->significant[last - 1] : UINT32_MAX;
        return CONTEXT_MEMBER;
    case TOKEN_LET:
    case TOKEN_FN:
    case TOKEN_PARAM:
    case TOKEN_AS:
        return CONTEXT_NOTHING;
    case TOKEN_IMPORT:
        context->in_import = true;
        return CONTEXT_NOTHING;
    case TOKEN_COLON:
        return last >= 2 && kind_at(scan, last - 2) == TOKEN_PARAM ? CONTEXT_TYPE : CONTEXT_VALUE;
    default:
        break;
    }
    if (before == TOKEN_STRING && last >= 1 && kind_at(scan, last - 1) == TOKEN_IMPORT) {
        return CONTEXT_AS;
    }
    if (before == TOKEN_RIGHT_PAREN && scan->condition_end == last) {
        return CONTEXT_VALUE;
    }
    bool begins = before == TOKEN_LEFT_PAREN || before == TOKEN_COMMA;
    if (around == TOKEN_LEFT_PAREN && bracket->is_header && begins) {
        return CONTEXT_NOTHING; // a parameter's or variable's name
    }
    bool item =
        before == TOKEN_END ||
        (in_body && (before == TOKEN_LEFT_BRACE || before == TOKEN_COMMA || ends_value(before)));
    if (item && around == TOKEN_LEFT_BRACE && bracket->brace != BRACE_BLOCK) {
        bracket->field = UINT32_MAX;
        return CONTEXT_FIELD;
    }
    return item ? CONTEXT_ITEM : CONTEXT_VALUE;
}

static void scan_to(Scan *scan, uint32_t offset, const DocumentToken **at)
{
    *at = NULL;
    scan->depth = 1;
    scan->stack[0] = (Bracket){.token = UINT32_MAX, .head = UINT32_MAX, .field = UINT32_MAX};
    for (size_t i = 0; i < scan->tokens->count; ++i) {
        const DocumentToken *found = &scan->tokens->items[i];
        if (found->begin >= offset) {
            break;
        }
        bool word = found->kind == TOKEN_NAME || found->kind == TOKEN_NUMBER ||
                    (found->kind >= TOKEN_IMPORT && found->kind <= TOKEN_NOT);
        bool holds = found->end > offset || (found->end == offset && word);
        if (holds) {
            *at = found;
            return;
        }
        if (found->kind != TOKEN_KIND_COUNT) {
            scan->significant[scan->count++] = (uint32_t)i;
            take(scan, scan->count - 1);
        } else if (found->end == offset && scan->text.at[found->begin + 1] == '/') {
            *at = found; // at the end of a line's comment
            return;
        }
    }
}

// A string that isn't closed ends with its line.
static bool is_closed(Str text, const DocumentToken *string)
{
    return string->end - string->begin >= 2 && text.at[string->end - 1] == '"';
}

void context_at(Server *server, Document *document, uint32_t offset, Context *context)
{
    *context = (Context){.begin = offset, .end = offset};
    const Analysis *analysis = document_analysis(server, document);
    const DocumentTokens *tokens = document_tokens(server, document);
    Scan *scan = arena_alloc_zeroed(&server->scratch, sizeof *scan);
    if (scan) {
        scan->significant =
            arena_array(&server->scratch, tokens->count + 1, sizeof *scan->significant);
    }
    if (!analysis || !scan || !scan->significant) {
        return;
    }
    scan->tokens = tokens;
    scan->text = buffer_content(&document->text);
    const DocumentToken *at;
    scan_to(scan, offset, &at);
    const DocumentToken *last = token(scan, scan->count - 1);
    if (!at && last && last->kind == TOKEN_STRING && last->end == offset &&
        !is_closed(scan->text, last)) {
        at = last;
        --scan->count;
    }
    if (at && at->kind == TOKEN_KIND_COUNT) {
        return;
    }
    if (at) {
        context->begin = at->begin;
        context->end = at->end;
    }
    context->kind = follow(scan, context);
    if (at && at->kind == TOKEN_STRING) {
        context->kind = CONTEXT_STRING;
        context->begin = at->begin + 1;
        context->end = is_closed(scan->text, at) ? at->end - 1 : at->end;
    } else if (at && at->kind == TOKEN_NUMBER) {
        uint32_t unit = unit_begin(scan->text, at);
        context->kind = offset < unit ? CONTEXT_NOTHING : CONTEXT_UNIT;
        context->begin = unit;
    } else if (at && at->kind != TOKEN_NAME &&
               !(at->kind >= TOKEN_IMPORT && at->kind <= TOKEN_NOT)) {
        context->begin = context->end = offset;
    }
    if (scan->count > 0 || context->kind == CONTEXT_STRING) {
        describe_brackets(analysis, scan, context);
    }
}

// --- Names in scope ------------------------------------------------------------------------------

typedef struct ScopeWalk {
    const Ast *ast;
    uint32_t offset;
    ScopeVisit *visit;
    void *context;
} ScopeWalk;

static void visit_items(const ScopeWalk *walk, uint32_t list)
{
    for (uint32_t i = 0; i < ast_list_count(walk->ast, list); ++i) {
        AstId item = ast_list_items(walk->ast, list)[i];
        uint8_t tag = ast_node(walk->ast, item)->tag;
        if (tag == AST_LET || tag == AST_FN || tag == AST_PARAM || tag == AST_IMPORT) {
            walk->visit(walk->context, item);
        }
    }
}

static void visit_scope(const ScopeWalk *walk, AstId id)
{
    const AstNode *node = ast_node(walk->ast, id);
    switch ((AstTag)node->tag) {
    case AST_FILE:
    case AST_BLOCK:
        visit_items(walk, node->a);
        break;
    case AST_KIND:
        visit_items(walk, node->b);
        break;
    case AST_FN: {
        uint32_t list = tree_words(walk->ast, node)[3];
        for (uint32_t i = 0; i < ast_list_count(walk->ast, list); ++i) {
            walk->visit(walk->context, ast_list_items(walk->ast, list)[i]);
        }
        break;
    }
    case AST_FOR:
        walk->visit(walk->context, id);
        break;
    default:
        break;
    }
}

void context_names(const Analysis *analysis, uint32_t offset, ScopeVisit *visit, void *context)
{
    ScopeWalk walk = {survey_ast(analysis->survey, 0), offset, visit, context};
    // Blanks behind what is being written belong to it.
    Str text = tree_text(analysis, 0);
    while (offset > 0 && offset <= text.length &&
           (text.at[offset - 1] == ' ' || text.at[offset - 1] == '\t')) {
        --offset;
    }
    TreePath inner, outer;
    tree_path(walk.ast, offset, &inner);
    tree_path(walk.ast, walk.offset, &outer);
    const TreePath *path = outer.count > inner.count ? &outer : &inner;
    for (size_t i = path->count; i-- > 0;) {
        visit_scope(&walk, path->nodes[i]);
    }
}

typedef struct NameSearch {
    const Analysis *analysis;
    Str name;
    AstId found;
} NameSearch;

static void compare_name(void *context, AstId item)
{
    NameSearch *search = context;
    if (!search->found && str_equal(survey_name(search->analysis->survey, 0, item), search->name)) {
        search->found = item;
    }
}

AstId context_find(const Analysis *analysis, uint32_t offset, Str name)
{
    NameSearch search = {.analysis = analysis, .name = name};
    context_names(analysis, offset, compare_name, &search);
    return search.found;
}
