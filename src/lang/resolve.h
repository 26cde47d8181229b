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
    bool known; // its value may be asked for before the whole file was read
} Binding;

typedef struct Resolver {
    Eval *ev;
    Module *module;
    Ast *ast;
    uint32_t *current; // by symbol: its innermost binding, or 0
    uint32_t symbols;  // how many symbols there is room for
    Binding *bindings; // in the arena; [0] is unused
    uint32_t binding_count, binding_capacity;
    uint32_t next_slot; // of the frame at hand
    uint16_t frame, function;
    uint32_t scope, scope_count;
    uint32_t comparisons; // of names for suggestions, so far
    bool *relied;         // by symbol: it was taken for a built-in name (resolver_knows)
    bool refused;         // and then declared
} Resolver;

// Of one file. Enough for dozens of wrong names among ten thousand; a file of more than that gets
// its other diagnostics without suggestions, rather than much later.
enum { MOST_COMPARISONS = 400000 };

typedef struct ScopeMark {
    uint32_t bindings;
    uint32_t scope;
} ScopeMark;

// Begins with a file, whose scope is opened; its items are declared and then resolved.
void resolver_begin(Resolver *r, Eval *ev, Module *module);
// Makes room for names that were met since.
void resolver_make_room(Resolver *r);
// Declares what an item at the top of the file declares.
void resolver_declare(Resolver *r, AstId item);
// Resolves one of these items; once each.
void resolver_resolve(Resolver *r, AstId item);
// Warns of what was not used, and makes the file's names known to others.
void resolver_end(Resolver *r);
// Whether an expression, or a statement of one expression, means the same whatever the rest of the
// file says: it consists of literals, kinds with their fields, built-in names that are not declared
// so far, and names that are `known`. It was not resolved yet.
bool resolver_knows(Resolver *r, AstId id);
// Resolves a LET, or a PARAM, that was declared, where its value depends on nothing but built-in
// names and names that are `known`, and makes its name one of these. Else it is left as it is, and
// false returned.
bool resolver_learn(Resolver *r, AstId item);

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
