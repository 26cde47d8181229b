#include "lang/resolve.h"

// What may hide what. A `let` never rebinds, and people who come from other languages would take
// `let n = 2` in a block for an assignment: so `let` and `fn` hide nothing but built-ins. Loop
// variables may hide names of the file and, inside a function, what lies outside of it; parameters
// may hide anything, since a function's text says what they are.

ScopeMark scope_begin(Resolver *r)
{
    ScopeMark mark = {r->binding_count, r->scope};
    r->scope = ++r->scope_count;
    return mark;
}

static const char *binding_word(BindingKind kind)
{
    switch (kind) {
    case BINDING_LET:
        return "let";
    case BINDING_FN:
        return "function";
    case BINDING_PARAM:
        return "param";
    case BINDING_IMPORT:
        return "import";
    case BINDING_PARAMETER:
        return "parameter";
    case BINDING_LOOP:
        return "loop variable";
    }
    return "name";
}

static Span binding_span(const Resolver *r, const Binding *binding)
{
    Span span = item_name_span(r->module, binding->item);
    if (binding->kind == BINDING_PARAMETER) {
        span.end = span.begin + (uint32_t)symbol_name(r->ev->names, binding->name).length;
    }
    return span;
}

static void warn_if_unused(Resolver *r, const Binding *binding)
{
    Str name = symbol_name(r->ev->names, binding->name);
    bool asked_for = r->ev->lang->bindings && binding->frame == 0; // what a file has to offer
    if (binding->used || binding->quiet || asked_for || r->module->failed ||
        r->module->is_library || (name.length && name.at[0] == '_')) {
        return;
    }
    Diag *diag = report(r->ev, W0301, binding_span(r, binding), "%s `%s` is never used",
                        binding_word(binding->kind), name.at);
    diag_note(r->ev->sink, diag, "a name that begins with `_` may stay unused");
}

void scope_end(Resolver *r, ScopeMark mark)
{
    for (uint32_t i = r->binding_count; i-- > mark.bindings;) {
        Binding *binding = &r->bindings[i];
        r->current[binding->name] = binding->hidden;
    }
    for (uint32_t i = mark.bindings; i < r->binding_count; ++i) {
        warn_if_unused(r, &r->bindings[i]);
    }
    r->binding_count = mark.bindings;
    r->scope = mark.scope;
}

static bool may_hide(const Resolver *r, BindingKind kind, const Binding *outer)
{
    switch (kind) {
    case BINDING_PARAMETER:
        return true;
    case BINDING_LOOP:
        return outer->frame == 0 || outer->function < r->function;
    default:
        return false;
    }
}

static void report_taken(Resolver *r, Symbol name, BindingKind kind, Binding *taken, Span at)
{
    taken->used = true; // as far as anyone can tell
    Eval *ev = r->ev;
    const char *text = symbol_name(ev->names, name).at;
    Place place = source_place(&ev->lang->sources, r->module->file, binding_span(r, taken).begin);
    if (taken->scope == r->scope) {
        Diag *diag = report(ev, E0304, at, "`%s` is declared twice", text);
        diag_label(ev->sink, diag, "already declared on line %u", place.line);
        return;
    }
    Diag *diag = report(ev, E0305, at, "%s `%s` hides the %s of line %u", binding_word(kind), text,
                        binding_word(taken->kind), place.line);
    diag_label(ev->sink, diag, "choose another name");
    if (kind == BINDING_LET) {
        diag_note(ev->sink, diag, "a `let` never changes another; it makes a new name");
    }
}

static void push_binding(Resolver *r, Binding binding)
{
    if (r->binding_count + 1 >= r->binding_capacity) {
        uint32_t capacity = r->binding_capacity ? r->binding_capacity * 2 : 64;
        Binding *grown = arena_array(r->ev->arena, capacity, sizeof *grown);
        if (r->bindings) {
            memcpy(grown, r->bindings, r->binding_count * sizeof *grown);
        }
        r->bindings = grown;
        r->binding_capacity = capacity;
    }
    r->bindings[r->binding_count++] = binding;
}

Binding *scope_declare(Resolver *r, Symbol name, BindingKind kind, AstId item, Span at)
{
    uint32_t hidden = name ? r->current[name] : 0; // 0: missing, which the parser has reported
    bool is_taken = false;
    if (hidden) {
        Binding *outer = &r->bindings[hidden];
        is_taken = outer->scope == r->scope || !may_hide(r, kind, outer);
        if (is_taken) {
            report_taken(r, name, kind, outer, at);
        }
    }
    Binding binding = {.name = name,
                       .hidden = hidden,
                       .scope = r->scope,
                       .slot = r->next_slot++,
                       .item = item,
                       .frame = r->frame,
                       .function = r->function,
                       .kind = kind,
                       .used = is_taken};
    push_binding(r, binding);
    if (name) {
        r->current[name] = r->binding_count - 1;
    }
    return &r->bindings[r->binding_count - 1];
}

Binding *scope_find(Resolver *r, Symbol name)
{
    uint32_t found = r->current[name];
    if (!found) {
        return NULL;
    }
    r->bindings[found].used = true;
    return &r->bindings[found];
}

Str scope_suggest(Resolver *r, Str name)
{
    Str best = {0};
    size_t distance = SIZE_MAX;
    for (uint32_t i = r->binding_count; i-- > 1 && r->comparisons < MOST_COMPARISONS;) {
        ++r->comparisons;
        suggest_name(name, symbol_name(r->ev->names, r->bindings[i].name), &best, &distance);
    }
    for (uint32_t i = 0; i < builtin_count; ++i) {
        suggest_name(name, str_from(builtins[i].name), &best, &distance);
    }
    for (size_t i = 0; i < lang_constant_count; ++i) {
        suggest_name(name, str_from(lang_constants[i].name), &best, &distance);
    }
    return best;
}
