// Scopes of the resolver: which declaration a name means. See resolve.c.
#ifndef LANG_RESOLVE_H
#define LANG_RESOLVE_H

#include "lang/eval.h"

typedef enum BindingKind {
    BINDING_LET,
    BINDING_FN,
    BINDING_PARAM,
    BINDING_IMPORT,
    BINDING_PARAMETER, // of a function
    BINDING_LOOP,      // the variable of a for
} BindingKind;

typedef struct Binding {
    Symbol name;
    uint32_t hidden; // the binding of the same name that this one hides; 0: none
    uint32_t scope;  // number of the scope
    uint32_t slot;
    AstId item;
    uint16_t frame;    // 0: the file's
    uint16_t function; // nesting of functions
    BindingKind kind;
    bool used;
    bool quiet; // no warning where it isn't used
} Binding;

typedef struct Resolver {
    Eval *ev;
    Module *module;
    Ast *ast;
    uint32_t *current; // by symbol: its innermost binding, or 0
    Binding *bindings; // in the arena; [0] is unused
    uint32_t binding_count, binding_capacity;
    uint32_t next_slot; // of the frame at hand
    uint16_t frame, function;
    uint32_t scope, scope_count;
    uint32_t comparisons; // of names for suggestions, so far
} Resolver;

// Of one file. Enough for dozens of wrong names among ten thousand; a file of more than that gets
// its other diagnostics without suggestions, rather than much later.
enum { MOST_COMPARISONS = 400000 };

typedef struct ScopeMark {
    uint32_t bindings;
    uint32_t scope;
} ScopeMark;

ScopeMark scope_begin(Resolver *r);
// Warns of what was not used.
void scope_end(Resolver *r, ScopeMark mark);
// A new slot for `name`; reports names that are taken.
Binding *scope_declare(Resolver *r, Symbol name, BindingKind kind, AstId item, Span at);
// The binding that `name` means here, now counted as used; or NULL.
Binding *scope_find(Resolver *r, Symbol name);
// The nearest visible name, built-ins included; an empty one where none is near, or where too many
// were looked for.
Str scope_suggest(Resolver *r, Str name);

#endif
