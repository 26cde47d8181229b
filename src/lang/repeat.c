// Statements that repeat one another but for their numbers. Programs write scenes of a million
//
//     sphere { center: (4.7, -0.12, 3), radius: 0.02, material: clay }
//
// that differ in nothing else. A statement that was read and resolved is kept as a pattern: the
// bytes between its numbers, and its nodes. Where the text that follows has the same bytes with
// other numbers between, the same tokens and so the same tree would come out of it; and as names
// mean the same wherever a statement stands in its file, they would be resolved to the same. So the
// pattern's nodes are given the new numbers and spans, and neither lexer, parser nor resolver runs.
//
// Only plain numbers (lexer_plain_number) may differ, and the sign only of those that are a whole
// component, element, argument or field: elsewhere `-2` and `2` could bind differently (`-2 ^ 2`).
#include "lang/lexer_internal.h"
#include "lang/parser_internal.h"

enum {
    MOST_HOLES = 32,      // numbers in a statement
    MOST_NODES = 128,     // of a statement
    FIRST_BUDGET = 32,    // statements that may be learnt at once, and
    STATEMENTS_EACH = 64, // one more for so many: little is lost where nothing repeats
    NO_HOLE = 255,
};

// A number that may differ. Offsets are from the begin of the pattern's text.
typedef struct Hole {
    uint32_t begin, end; // with the sign
    uint32_t node;       // NUMBER, counted from the pattern's first
    bool any_sign;
} Hole;

// Where a node's ends lie, and in which pieces of the text between the holes.
typedef struct NodeEnds {
    uint32_t begin, end;
    uint8_t begin_piece, end_piece;
} NodeEnds;

typedef struct Pattern {
    AstId item, first; // the statement, and the first of its nodes, which follow one another
    uint32_t begin;    // of its text in the file
    uint32_t length;
    uint32_t hole_count, node_count;
    Hole holes[MOST_HOLES];
    NodeEnds ends[MOST_NODES];
} Pattern;

struct Repeats {
    uint32_t read; // statements that were not repeated
    uint32_t learnt;
    uint32_t count;
    uint8_t order[PARSE_PATTERNS]; // of patterns, the one used last first
    Pattern patterns[PARSE_PATTERNS];
};

Repeats *repeats_new(void)
{
    Repeats *repeats = mem_alloc(1, sizeof *repeats);
    if (repeats) {
        repeats->read = repeats->learnt = repeats->count = 0;
    }
    return repeats;
}

// The pattern at place `place` of the order comes first.
static void move_to_front(uint8_t *order, uint32_t place)
{
    const uint8_t number = order[place];
    memmove(order + 1, order, place);
    order[0] = number;
}

// --- Learning ------------------------------------------------------------------------------------

typedef struct Learner {
    const Parser *parser;
    AstNode *nodes; // the statement's
    Pattern *pattern;
    uint8_t hole_of[MOST_NODES];
} Learner;

static const char *text_of(const Learner *l)
{
    return l->parser->lexer.begin + l->pattern->begin;
}

// False where there are too many.
static bool find_holes(Learner *l)
{
    Pattern *pattern = l->pattern;
    const char *stop = text_of(l) + pattern->length;
    for (uint32_t i = 0; i < pattern->node_count; ++i) {
        const AstNode *node = &l->nodes[i];
        l->hole_of[i] = NO_HOLE;
        if (node->tag != AST_NUMBER || node->aux) {
            continue;
        }
        const uint32_t begin = node->begin - pattern->begin, end = node->end - pattern->begin;
        double number;
        if (lexer_plain_number(text_of(l) + begin, stop, &number) != text_of(l) + end) {
            continue; // it must be written as it is
        }
        if (pattern->hole_count == MOST_HOLES) {
            return false;
        }
        l->hole_of[i] = (uint8_t)pattern->hole_count;
        pattern->holes[pattern->hole_count++] = (Hole){begin, end, i, false};
    }
    return pattern->hole_count > 0;
}

static AstNode negative_number(const AstNode *unary, const AstNode *operand)
{
    const double number = -ast_number(operand);
    AstNode node = {.tag = AST_NUMBER, .begin = unary->begin, .end = unary->end};
    memcpy((char *)&node + offsetof(AstNode, a), &number, sizeof number);
    return node;
}

// An expression that stands for itself: where it is a number its sign may differ. That of a negated
// one becomes part of the number, which doesn't change the value.
static void free_sign(Learner *l, AstId id)
{
    AstNode *node = &l->nodes[id - l->pattern->first];
    if (node->tag == AST_NUMBER) {
        const uint8_t hole = l->hole_of[id - l->pattern->first];
        if (hole != NO_HOLE) {
            l->pattern->holes[hole].any_sign = true;
        }
        return;
    }
    if (node->tag != AST_UNARY || node->op != OP_NEGATE || !node->a) {
        return;
    }
    const uint32_t operand = node->a - l->pattern->first;
    const uint8_t number = l->hole_of[operand];
    if (l->nodes[operand].tag != AST_NUMBER || number == NO_HOLE ||
        l->nodes[operand].begin != node->begin + 1) {
        return;
    }
    Hole *hole = &l->pattern->holes[number];
    *node = negative_number(node, &l->nodes[operand]);
    --hole->begin;
    hole->node = id - l->pattern->first;
    hole->any_sign = true;
}

static void free_signs_of(Learner *l, uint32_t list)
{
    const Ast *ast = l->parser->ast;
    for (uint32_t i = 0; i < ast_list_count(ast, list); ++i) {
        free_sign(l, ast_list_items(ast, list)[i]);
    }
}

static void free_signs(Learner *l)
{
    for (uint32_t i = 0; i < l->pattern->node_count; ++i) {
        const AstNode *node = &l->nodes[i];
        switch ((AstTag)node->tag) {
        case AST_VECTOR:
        case AST_LIST:
            free_signs_of(l, node->a);
            break;
        case AST_CALL:
            free_signs_of(l, node->b);
            break;
        case AST_FIELD:
        case AST_ARGUMENT:
            free_sign(l, node->b);
            break;
        default:
            break;
        }
    }
}

// The piece of text that `offset` lies in: its first byte for a begin, behind its last for an end.
static uint8_t piece_of(const Pattern *pattern, uint32_t offset, bool is_end)
{
    uint8_t piece = 0;
    while (piece < pattern->hole_count &&
           (is_end ? offset >= pattern->holes[piece].end : offset > pattern->holes[piece].begin)) {
        ++piece;
    }
    return piece;
}

static void find_ends(Learner *l)
{
    Pattern *pattern = l->pattern;
    for (uint32_t i = 0; i < pattern->node_count; ++i) {
        const uint32_t begin = l->nodes[i].begin - pattern->begin;
        const uint32_t end = l->nodes[i].end - pattern->begin;
        pattern->ends[i] =
            (NodeEnds){begin, end, piece_of(pattern, begin, false), piece_of(pattern, end, true)};
    }
}

bool parser_learn(Parser *p, AstId item)
{
    Repeats *repeats = p->repeats;
    if (!repeats) {
        return false;
    }
    const AstNode *node = ast_node(p->ast, item);
    const size_t node_count = p->ast->nodes.count - p->item_nodes;
    ++repeats->read;
    if (repeats->learnt >= FIRST_BUDGET + repeats->read / STATEMENTS_EACH ||
        node_count > MOST_NODES) {
        return false;
    }
    const bool is_new = repeats->count < PARSE_PATTERNS;
    const uint8_t number = is_new ? (uint8_t)repeats->count : repeats->order[PARSE_PATTERNS - 1];
    Pattern *pattern = &repeats->patterns[number];
    Pattern made = {.item = item,
                    .first = (AstId)p->item_nodes,
                    .begin = node->begin,
                    .length = node->end - node->begin,
                    .node_count = (uint32_t)node_count};
    Learner learner = {.parser = p, .nodes = &p->ast->nodes.items[made.first], .pattern = &made};
    if (!find_holes(&learner)) {
        return false;
    }
    free_signs(&learner);
    find_ends(&learner);
    *pattern = made;
    ++repeats->learnt;
    if (is_new) {
        repeats->order[repeats->count++] = number;
    }
    move_to_front(repeats->order, repeats->count - 1);
    return true;
}

// --- Repeating -----------------------------------------------------------------------------------

typedef struct Match {
    double numbers[MOST_HOLES];
    uint32_t shifts[MOST_HOLES + 1]; // of each piece: from the pattern's text to the file
    const char *end;
} Match;

static const char *match_piece(const char *at, const char *end, const char *text, uint32_t length)
{
    return (size_t)(end - at) >= length && memcmp(at, text, length) == 0 ? at + length : NULL;
}

static const char *match_number(const char *at, const char *end, bool any_sign, double *out)
{
    const bool negative = any_sign && at < end && *at == '-';
    at = lexer_plain_number(at + negative, end, out);
    if (negative) {
        *out = -*out;
    }
    return at;
}

// Of a statement that begins at `at`.
static bool is_match(const Parser *p, const Pattern *pattern, const char *at, Match *match)
{
    const char *begin = p->lexer.begin, *end = p->lexer.end, *text = begin + pattern->begin;
    uint32_t offset = 0; // in the pattern's text
    for (uint32_t i = 0; i < pattern->hole_count; ++i) {
        const Hole *hole = &pattern->holes[i];
        match->shifts[i] = lexer_offset(&p->lexer, at) - offset;
        at = match_piece(at, end, text + offset, hole->begin - offset);
        at = at ? match_number(at, end, hole->any_sign, &match->numbers[i]) : NULL;
        if (!at) {
            return false;
        }
        offset = hole->end;
    }
    match->shifts[pattern->hole_count] = lexer_offset(&p->lexer, at) - offset;
    match->end = match_piece(at, end, text + offset, pattern->length - offset);
    return match->end != NULL;
}

// Takes the text, unless what follows goes on with it.
static bool pass_text(Parser *p, const char *end)
{
    const Token first = p->token;
    const char *at = p->lexer.at;
    const uint32_t previous_end = p->previous_end;
    p->previous_end = lexer_offset(&p->lexer, end);
    p->lexer.at = end;
    lexer_next(&p->lexer, &p->token);
    if (parse_at(p, TOKEN_DOT) || parse_at(p, TOKEN_LEFT_PAREN) ||
        parse_at(p, TOKEN_LEFT_BRACKET) || parse_at(p, TOKEN_WITH)) {
        p->token = first;
        p->lexer.at = at;
        p->previous_end = previous_end;
        return false;
    }
    parse_item_comma(p);
    return true;
}

static void fill_nodes(Ast *ast, const Pattern *pattern, const Match *match)
{
    AstNode *nodes = &ast->nodes.items[pattern->first];
    for (uint32_t i = 0; i < pattern->node_count; ++i) {
        const NodeEnds *ends = &pattern->ends[i];
        nodes[i].begin = ends->begin + match->shifts[ends->begin_piece];
        nodes[i].end = ends->end + match->shifts[ends->end_piece];
    }
    for (uint32_t i = 0; i < pattern->hole_count; ++i) {
        memcpy((char *)&nodes[pattern->holes[i].node] + offsetof(AstNode, a), &match->numbers[i],
               sizeof match->numbers[i]);
    }
}

static void read_repeat(Parser *p, void *with)
{
    AstId *found = with;
    Repeats *repeats = p->repeats;
    Match match;
    for (uint32_t i = 0; i < repeats->count; ++i) {
        const Pattern *pattern = &repeats->patterns[repeats->order[i]];
        if (!is_match(p, pattern, p->lexer.begin + p->token.begin, &match)) {
            continue;
        }
        if (pass_text(p, match.end)) {
            fill_nodes(p->ast, pattern, &match);
            *found = pattern->item;
            move_to_front(repeats->order, i);
        }
        return;
    }
}

AstId parser_repeat_item(Parser *p)
{
    AstId found = 0;
    if (!parse_at(p, TOKEN_NAME) || !p->repeats || p->repeats->count == 0 ||
        !parse_guarded(p, read_repeat, &found)) {
        return 0;
    }
    return found;
}

// --- Repeating ahead -----------------------------------------------------------------------------

RepeatRun parser_run(const Parser *p)
{
    RepeatRun run = {.at = p->lexer.begin + p->token.begin, .end = p->lexer.end};
    memcpy(run.order, p->repeats->order, sizeof run.order);
    return run;
}

const char *parser_find_repeat(const Parser *p, const char *from)
{
    const Repeats *repeats = p->repeats;
    const Pattern *pattern = &repeats->patterns[repeats->order[0]];
    const char *text = p->lexer.begin + pattern->begin, *end = p->lexer.end;
    while (from < end) {
        const char *line = memchr(from, '\n', (size_t)(end - from));
        if (!line || match_piece(line + 1, end, text, pattern->holes[0].begin)) {
            return line ? line + 1 : NULL;
        }
        from = line + 1;
    }
    return NULL;
}

// Whether a statement may end before `next`, and another begin there: what would go on with it
// is no name, but for `with`.
static bool is_border(const Parser *p, const char *next)
{
    static const char with[] = "with";
    const size_t length = sizeof with - 1;
    return next == p->lexer.end ||
           (char_is(*next, CHAR_LETTER) &&
            ((size_t)(p->lexer.end - next) < length || memcmp(next, with, length) != 0));
}

AstId parser_run_item(const Parser *p, RepeatRun *run, Ast *ast)
{
    const Repeats *repeats = p->repeats;
    Match match;
    for (uint32_t i = 0; i < repeats->count; ++i) {
        const Pattern *pattern = &repeats->patterns[run->order[i]];
        if (!is_match(p, pattern, run->at, &match)) {
            continue;
        }
        const char *next = lexer_next_begin(match.end, p->lexer.end);
        if (!is_border(p, next)) {
            return 0;
        }
        run->behind = match.end;
        run->at = next;
        fill_nodes(ast, pattern, &match);
        move_to_front(run->order, i);
        return pattern->item;
    }
    return 0;
}

void parser_pass_run(Parser *p, const RepeatRun *run)
{
    p->previous_end = lexer_offset(&p->lexer, run->behind);
    p->lexer.at = run->behind;
    lexer_next(&p->lexer, &p->token);
}
