// The syntax tree of one file: an array of small nodes and an array of extra words for lists, both
// indexed by 32-bit numbers (after Zig's compiler). A million literal spheres make ten million
// nodes, so a node has 20 bytes and no pointer.
#ifndef LANG_AST_H
#define LANG_AST_H

#include "base/array.h"
#include "base/diag.h"
#include "base/source.h"
#include "base/str.h"

#include <stddef.h>
#include <string.h>

typedef uint32_t AstId; // index into Ast.nodes; 0 is none

// AST(tag, what `a` and `b` hold).  "list" is an index into Ast.extra where a count stands,
// followed by that many words.
#define AST_NODES(AST)                                                                             \
    AST(NONE, "")                                                                                  \
    AST(ERROR, "what could not be parsed; already reported")                                       \
    /* items */                                                                                    \
    AST(FILE, "a: list of items")                                                                  \
    AST(IMPORT, "a: STRING node, b: extra -> {symbol of the namespace, name_begin, name_end}")     \
    AST(PARAM, "a: symbol, b: extra -> {name_begin, name_end, type symbol, default, range, "       \
               "description STRING or 0, type_begin, type_end}")                                   \
    AST(LET, "a: symbol, b: extra -> {name_begin, name_end, value}")                               \
    AST(FN, "a: symbol (0: anonymous), b: extra -> {name_begin, name_end, body, parameter list "   \
            "index}; body is an expression or a BLOCK")                                            \
    AST(PARAMETER, "a: symbol, b: default or 0")                                                   \
    AST(FOR, "a: symbol, b: extra -> {name_begin, name_end, sequence, body}")                      \
    AST(IF, "a: condition, b: extra -> {then, else or 0}; as item (BLOCKs) or expression")         \
    AST(EMIT, "a: expression standing as a statement")                                             \
    AST(EXPECT, "a: what is expected to hold, b: extra -> {0, 0, record}; or, with `within`, a: "  \
                "value, b: extra -> {tolerance, target, record}, aux 1: a percentage; record is "  \
                "the evaluator's own")                                                             \
    AST(BLOCK, "a: list of items")                                                                 \
    /* expressions */                                                                              \
    AST(NUMBER, "payload: double as written; aux: index of the unit + 1 in schema_units, 0 none")  \
    AST(STRING, "a: symbol of the unescaped text")                                                 \
    AST(COLOR, "a: 0xRRGGBB as written, sRGB-encoded")                                             \
    AST(BOOL, "a: 0 or 1")                                                                         \
    AST(NAME, "a: symbol")                                                                         \
    AST(VECTOR, "a: list of 2 to 4 expressions")                                                   \
    AST(LIST, "a: list of elements: expressions, or FORs and IFs whose bodies are elements; such " \
              "an IF may lack its else, and then gives none")                                      \
    AST(RANGE, "a, b: ends; aux 1: without the last (..<)")                                        \
    AST(UNARY, "op, a: operand")                                                                   \
    AST(BINARY, "op, a, b: operands; aux: the evaluator's own")                                    \
    AST(INDEX, "a: value, b: index")                                                               \
    AST(MEMBER, "a: value, b: symbol")                                                             \
    AST(CALL,                                                                                      \
        "a: callee, b: list of arguments (expressions or ARGUMENTs); aux: the evaluator's own")    \
    AST(ARGUMENT, "a: symbol, b: value: an argument by name; its name starts at begin")            \
    AST(KIND, "a: symbol, b: list of FIELDs and items; the name starts at begin")                  \
    AST(FIELD, "a: symbol, b: value; the name starts at begin")                                    \
    AST(WITH, "a: value, b: list of FIELDs")

typedef enum AstTag {
#define AST(tag, doc) AST_##tag,
    AST_NODES(AST)
#undef AST
        AST_TAG_COUNT
} AstTag;

// OPERATOR(id, text, binding power): larger binds tighter; POWER binds to the right.
#define OPERATORS(OPERATOR)                                                                        \
    OPERATOR(OR, "or", 1)                                                                          \
    OPERATOR(AND, "and", 2)                                                                        \
    OPERATOR(NOT, "not", 3)                                                                        \
    OPERATOR(EQUAL, "==", 4)                                                                       \
    OPERATOR(NOT_EQUAL, "!=", 4)                                                                   \
    OPERATOR(LESS, "<", 4)                                                                         \
    OPERATOR(LESS_EQUAL, "<=", 4)                                                                  \
    OPERATOR(GREATER, ">", 4)                                                                      \
    OPERATOR(GREATER_EQUAL, ">=", 4)                                                               \
    OPERATOR(ADD, "+", 6)                                                                          \
    OPERATOR(SUBTRACT, "-", 6)                                                                     \
    OPERATOR(MULTIPLY, "*", 7)                                                                     \
    OPERATOR(DIVIDE, "/", 7)                                                                       \
    OPERATOR(MODULO, "%", 7)                                                                       \
    OPERATOR(NEGATE, "-", 8)                                                                       \
    OPERATOR(POWER, "^", 9)

typedef enum Operator {
#define OPERATOR(id, text, power) OP_##id,
    OPERATORS(OPERATOR)
#undef OPERATOR
        OP_COUNT
} Operator;

typedef struct AstNode {
    uint8_t tag; // AstTag
    uint8_t op;  // Operator
    uint16_t aux;
    uint32_t begin, end; // bytes in the file
    uint32_t a, b;
} AstNode;

// A comment, kept for the formatter: its bytes in the file, in order.
typedef struct AstComment {
    uint32_t begin, end;
} AstComment;

typedef ARRAY(AstNode) AstNodeArray;
typedef ARRAY(uint32_t) AstWordArray;
typedef ARRAY(AstComment) AstCommentArray;

typedef struct Ast {
    uint32_t file;      // number of the source
    uint32_t version;   // of the header `scn N`; 0 if there is none
    AstId root;         // a FILE node
    AstNodeArray nodes; // [0] is unused
    AstWordArray extra; // [0] is a count of 0: the empty list
    AstCommentArray comments;
} Ast;

void ast_free(Ast *ast);

static inline const AstNode *ast_node(const Ast *ast, AstId id)
{
    return &ast->nodes.items[id];
}
static inline double ast_number(const AstNode *node)
{
    double number;
    memcpy(&number, (const char *)node + offsetof(AstNode, a), sizeof number);
    return number;
}
static inline Span ast_span(const Ast *ast, AstId id)
{
    return (Span){ast->file, ast->nodes.items[id].begin, ast->nodes.items[id].end};
}
static inline uint32_t ast_list_count(const Ast *ast, uint32_t list)
{
    return ast->extra.items[list];
}
static inline const uint32_t *ast_list_items(const Ast *ast, uint32_t list)
{
    return ast->extra.items + list + 1;
}

const char *ast_tag_name(AstTag tag);   // "LET", "KIND", …
const char *operator_text(Operator op); // "+", "and", …

// Writes the tree as S-expressions with spans, one item a line group; ends with a newline.
void ast_dump(const Ast *ast, const Interner *names, FILE *out);

// How deep a tree can get. `nesting` counts brackets, blocks, prefix operators and right-hand
// operands, and costs the parser stack, so more than PARSE_NESTING_MOST is taken as that. Chains
// (`1 + 1 + 1 …`, `a.b.c …`) lean to the left without nesting; they are limited so that no path
// from a root to a leaf has more than ast_deepest(limits) nodes: a recursive walk is safe with a
// stack for that many (2,600 for the default 200).
typedef struct ParseLimits {
    uint32_t nesting;
} ParseLimits;

enum { PARSE_NESTING_MOST = 2000, PARSE_CHAIN_MOST = 1000 };

static inline uint32_t ast_deepest(ParseLimits limits)
{
    uint32_t nesting = limits.nesting < PARSE_NESTING_MOST ? limits.nesting : PARSE_NESTING_MOST;
    return 8 * nesting + PARSE_CHAIN_MOST;
}

// Parses the whole text of source `file` into *ast (to be given back with ast_free, also after
// errors). Every error is reported to `sink`; parsing goes on after each at the next item, so that
// one run reports several. True when there was none. Comments are kept only if `keep_comments`.
// When memory runs out it reports E0001 and returns false.
bool parse(Ast *ast, const Sources *sources, uint32_t file, Interner *names, ParseLimits limits,
           bool keep_comments, DiagSink *sink);

// Parsing bit by bit, so that items can be evaluated, and their nodes forgotten, while the rest of
// the file is still text. Errors are reported as by parse(); nothing else may be done with *ast
// meanwhile but to read it and to change its nodes.
typedef struct Parser Parser;

// NULL (E0001 is reported) without memory. To be given back with parser_free.
Parser *parser_new(Ast *ast, const Sources *sources, uint32_t file, Interner *names,
                   ParseLimits limits, DiagSink *sink);
void parser_free(Parser *parser);
// Whether items were read that are in the file.
bool parser_has_items(const Parser *parser);
// Reads the next item at the top of the file. 0 at the end of the file, and where it could not be
// read, which was reported.
AstId parser_read_item(Parser *parser);
// Takes the item that was read last out of the file again, and forgets its nodes unless they are to
// be kept.
void parser_take_out(Parser *parser, bool keep_nodes);
// Reads what is left, and makes ast->root of all items that were not taken out. False where memory
// ran out, then or before.
bool parser_finish(Parser *parser);
bool parser_at_end(const Parser *parser);
bool parser_is_out_of_memory(const Parser *parser);

// Statements that repeat one another but for their numbers need to be read and resolved once (see
// repeat.c). Of the item that parser_read_item has just read, which is a statement: true where it
// may be repeated. Then its nodes are to be kept, once they are resolved.
bool parser_learn(Parser *parser, AstId item);
// Reads the next item where it repeats one that was learnt: that one's nodes with the numbers and
// spans of this one. It is not in the file. Else 0, and nothing was read.
AstId parser_repeat_item(Parser *parser);

// Such statements read ahead, in several places at a time; the parser stays as it is meanwhile.
enum { PARSE_PATTERNS = 8 }; // are kept at a time
typedef struct RepeatRun {
    const char *at;                // where the next statement begins
    const char *behind;            // the end of the last one; NULL: none was read
    const char *end;               // no statement that begins here or later is read
    uint8_t order[PARSE_PATTERNS]; // in which patterns are tried
} RepeatRun;
// A run that begins where the parser stands and ends with the text.
RepeatRun parser_run(const Parser *parser);
// Where a statement like the last one that was repeated seems to begin, at `from` or behind it;
// NULL where none does.
const char *parser_find_repeat(const Parser *parser, const char *from);
// As parser_repeat_item, with nodes of its own: a copy of the parser's. 0 where no statement
// repeats one that was learnt, or something follows that isn't a statement.
AstId parser_run_item(const Parser *parser, RepeatRun *run, Ast *ast);
// What a run has read, which it must have, counts as read.
void parser_pass_run(Parser *parser, const RepeatRun *run);

#endif
