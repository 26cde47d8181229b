// What may be written at a place, from the tokens before it: they tell also where half a line is
// missing.
#ifndef LSP_CONTEXT_H
#define LSP_CONTEXT_H

#include "lsp/tree.h"

typedef enum ContextKind {
    CONTEXT_NOTHING, // a comment; a name being declared
    CONTEXT_ITEM,    // an item may begin
    CONTEXT_VALUE,   // a value
    CONTEXT_FIELD,   // a field, or an item in a kind that takes some
    CONTEXT_MEMBER,  // behind a point
    CONTEXT_UNIT,    // behind the digits of a number
    CONTEXT_STRING,  // in a string
    CONTEXT_TYPE,    // of a param
    CONTEXT_AS,      // behind an import's path
} ContextKind;

enum { CONTEXT_GIVEN = 64 };

typedef struct Context {
    ContextKind kind;
    uint32_t begin, end;  // what is written already: of a word, of a unit, of a string's inside
    const NodeType *type; // of the kind around, as far as known
    bool in_with, in_list, in_import;
    Str field;             // whose value it is; empty: none
    uint32_t given_fields; // of the kind around
    Str given[CONTEXT_GIVEN];
    uint32_t member_of; // CONTEXT_MEMBER: the token before the point
    // The innermost call around: its callee's tokens, the place of its bracket, the argument at
    // hand.
    bool in_call;
    uint32_t callee_begin, callee_end, argument;
    Str argument_name;
    bool argument_begins; // nothing of the argument stands there yet
} Context;

void context_at(Server *server, Document *document, uint32_t offset, Context *context);

// Names that are visible at a place, the innermost first; the callback gets the item (LET, FN,
// PARAM, IMPORT, PARAMETER, FOR).
typedef void ScopeVisit(void *context, AstId item);
void context_names(const Analysis *analysis, uint32_t offset, ScopeVisit *visit, void *context);
// The item that `name` means there, or 0.
AstId context_find(const Analysis *analysis, uint32_t offset, Str name);

#endif
