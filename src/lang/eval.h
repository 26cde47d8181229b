// The evaluator from inside: shared by the files of lang/, seen by nobody else.
//
// A file is a Module; its names were resolved to slots of frames (Env). Only files, function calls
// and loop iterations make a frame: blocks inside take slots of the frame around them, since each
// runs at most once per frame. A `let` is evaluated when its slot is first read, so the order of
// items doesn't matter.
//
// Memory: temporaries of one emitted statement or loop iteration are given back when it is done.
// Each such nesting level has its own arena (a "region"), so that a `let` of an outer block that is
// first read inside a loop is kept with its block: it is evaluated in the region of its frame.
#ifndef LANG_EVAL_H
#define LANG_EVAL_H

#include "lang/lang.h"
#include "lang/value.h"

typedef struct Module Module;
typedef struct Eval Eval;

// --- Frames and modules ----------------------------------------------------------------------

typedef struct Env {
    struct Env *parent;
    Module *module;
    uint64_t serial; // counts up with each frame made
    uint32_t region; // where it lies, and where its lets are evaluated
    uint32_t slot_count;
    Value slots[];
} Env;

struct Closure {
    Env *env;
    AstId fn; // of env->module
};

typedef struct Global {
    Symbol name;
    AstId item; // LET, FN, PARAM or IMPORT
    bool used;
} Global;

struct Module {
    uint32_t number; // in Eval.modules
    uint32_t file;
    Ast ast;
    bool is_library;        // imported
    bool parsed;            // false while it is being read, for cycles
    Parser *parser;         // while it is being read bit by bit; else NULL
    bool failed;            // could not be parsed: its names are unknown, and that was reported
    ARRAY(Global) globals;  // names of the file itself, by slot
    uint32_t *global_slots; // hash table of globals: slot + 1
    uint32_t global_mask;
    uint32_t slot_count;     // of the frame: globals and names of blocks at file level
    ARRAY(Value) constants;  // colors, decoded
    struct Numeric *numeric; // see numeric.h; NULL: none
    Env *env;
};

// What a NAME was resolved to, in AstNode.op; a: slot (or builtin, constant, module), b: the
// declaring node, aux: how many frames up.
typedef enum NameKind {
    NAME_BAD, // unknown; reported
    NAME_VARIABLE,
    NAME_LET, // let, fn or param: may have to be evaluated first
    NAME_GLOBAL,
    NAME_BUILTIN,
    NAME_CONSTANT,
    NAME_NAMESPACE,
} NameKind;

// LET.op and PARAM.op of what was resolved before the others.
enum { ITEM_RESOLVED = 1 };

// COLOR.op, once a is its place in Module.constants. What the parser left out of the tree never is.
enum { COLOR_DECODED = 1 };

// MEMBER.op: of a value, or of a namespace (aux: module, b: slot).
typedef enum MemberKind { MEMBER_VALUE, MEMBER_GLOBAL, MEMBER_BAD } MemberKind;

// FIELD.aux below a KIND: a parameter + 1, or one of these.
enum {
    FIELD_BAD = 0,
    FIELD_COMMON = 0x100, // | CommonField
    FIELD_ITEMS = 0x200,
    FIELD_OF = 0x201,
};

// --- Kinds and names known beforehand --------------------------------------------------------

typedef struct KindInfo {
    const NodeType *type;
    Symbol *fields;    // by parameter
    uint64_t required; // bits of parameters
    char *defaults;    // the parameter struct with its defaults; NULL: not made yet
    bool making;
    int shape_field; // lights: the parameter that takes a shape, or -1
} KindInfo;

typedef struct SymbolInfo {
    uint16_t kind;    // + 1
    uint16_t builtin; // + 1
    uint16_t common;  // CommonField
} SymbolInfo;

// --- Emission --------------------------------------------------------------------------------

typedef struct PrototypePart { // a light, camera or nested instance of a prototype
    const NodeValue *node;
    Affine transform;
    uint32_t material;
} PrototypePart;

// A shape or group that was instanced.
typedef struct PrototypeRecord {
    uint32_t prototype; // 0: it has no shapes of its own
    bool making;
    uint32_t part_count, part_capacity;
    PrototypePart *parts;
} PrototypeRecord;

typedef struct Emitter {
    bool collecting; // values are pushed on Eval.stack
    bool is_identity;
    Affine transform;  // to the world, or to the prototype
    uint32_t material; // for shapes without one: id or NONE_ID
    uint32_t prototype;
    PrototypeRecord *record; // while a prototype is made
} Emitter;

// --- The evaluator ---------------------------------------------------------------------------

typedef struct CallFrame {
    struct CallFrame *outer;
    Span at;
    Symbol name; // 0: anonymous
} CallFrame;

typedef struct ForceFrame { // lets being evaluated, for the diagnostic of a cycle
    struct ForceFrame *outer;
    const Env *env;
    uint32_t slot;
    AstId item;
} ForceFrame;

enum { REGION_COUNT = 64, CONS_SLOTS = 4096, STACK_BYTES = 256 << 20 };

// A limit was crossed: only unwind, out of the statement or out of the run.
typedef enum Stop { STOP_NOT, STOP_STATEMENT, STOP_RUN } Stop;

typedef struct ConsSlot {
    uint64_t hash;
    uint32_t id;
    uint16_t type; // + 1; 0: free
} ConsSlot;

typedef ARRAY(Value) ValueArray;

// See parts.c.
typedef struct NodeParts {
    uint64_t parts; // nodes that are walked through, those met again counted again
    uint32_t depth;
} NodeParts;
typedef ARRAY(NodeParts) NodePartsArray;

// A transform that a unit put first into a slot of its table (aside.c).
typedef struct FirstTransform {
    uint64_t hash;
    uint32_t slot, id;
} FirstTransform;

struct Eval {
    Lang *lang;
    Interner *names;
    DiagSink *sink;
    Scene *scene;
    Arena *arena; // regions[region]
    Arena regions[REGION_COUNT];
    ArenaFamily memory; // of the regions together
    uint32_t region;
    Stop stop;
    bool early;   // a statement was evaluated before all were read (see module_load_early)
    bool refused; // that was no good
    uint64_t serial, oldest_forced;
    uintptr_t stack_floor;
    uint64_t steps, objects, measures;
    uint32_t call_depth;
    CallFrame *calls;
    ForceFrame *forcing;
    Emitter *emitter;
    ValueArray stack; // items of lists and groups in the making
    ARRAY(Module *) modules;
    uint32_t import_depth;
    KindInfo *kinds; // by type
    SymbolInfo *symbols;
    uint32_t symbol_count;
    Interner strings; // texts kept in the scene
    ConsSlot *consed_nodes, *consed_transforms;
    NodePartsArray material_parts, texture_parts; // by scene id
    uint64_t *settings_used;                      // bits
    int texture_math;                             // type, or -1
    int group_type;                               // type of role GROUP, or -1
    Symbol symbol_items, symbol_of;
    // See aside.h.
    bool aside;              // a unit: others are evaluated beside it
    uint32_t aside_region;   // frames up to this region aren't its own
    uint32_t asides_refused; // times that units had to be evaluated anew
    struct Asides *asides;
    FirstTransform *first_transforms; // a unit's
    uint32_t first_transform_count;
    jmp_buf on_oom;
};

// Where a value was written.
typedef struct Where {
    Module *module;
    AstId node;
} Where;

static inline Span where_span(Where where)
{
    return ast_span(&where.module->ast, where.node);
}
static inline const AstNode *env_node(const Env *env, AstId id)
{
    return &env->module->ast.nodes.items[id];
}
static inline Span env_span(const Env *env, AstId id)
{
    return ast_span(&env->module->ast, id);
}
static inline const uint32_t *env_words(const Env *env, uint32_t at)
{
    return &env->module->ast.extra.items[at];
}

// Leaves the run with E0001.
_Noreturn void out_of_memory(Eval *ev);
// Ends a unit before what can only be done in order.
static inline void must_be_alone(Eval *ev)
{
    if (ev->aside) {
        longjmp(ev->on_oom, 1);
    }
}
// aside.c: gives the units' memory back.
void asides_free(Eval *ev);
// Reports with the chain of calls. Never NULL.
Diag *report(Eval *ev, DiagCode code, Span at, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
// The chain put on diagnostics that others report to the sink from number `from` on.
void attach_calls(Eval *ev, uint32_t from);
// Puts what a reported error leaves into an expression: `return fail(ev, report(…))` reads well.
static inline Value fail(Diag *diag)
{
    (void)diag;
    return value_error();
}
// True when the C stack is nearly used up; then report_deep_stack, which gives false.
static inline bool stack_is_deep(const Eval *ev)
{
    return (uintptr_t)__builtin_frame_address(0) < ev->stack_floor;
}
bool report_deep_stack(Eval *ev, Span at);
// Stops; what was begun becomes an error, silently.
void stop_evaluation(Eval *ev, Stop stop);
// After a statement: goes on with the next, unless the run is over.
bool go_on(Eval *ev);
// Counts calls, iterations, items that are emitted, and work of a like cost (below); false when the
// limit is crossed or the run is to stop.
bool count_steps(Eval *ev, uint64_t steps, Span at);
static inline bool count_step(Eval *ev, Span at)
{
    return count_steps(ev, 1, at);
}
// Of a loop over values, and one over bytes, inside of the evaluator: so that nothing that a text
// of three lines can ask for runs for hours without a step.
enum { VALUES_A_STEP = 4, BYTES_A_STEP = 32 };
static inline bool count_values(Eval *ev, uint64_t count, Span at)
{
    return count_steps(ev, count / VALUES_A_STEP + 1, at);
}
// "did you mean": the nearest of the names to `name`, kept in *best with its distance in
// *distance (begin with SIZE_MAX).
void suggest_name(Str name, Str candidate, Str *best, size_t *distance);

// lang.c
// NULL without memory. `floor` is the lowest address of the C stack. Both keep `scene`.
Eval *eval_new(Lang *lang, Scene *scene, uintptr_t floor);
void eval_free(Eval *ev);
// Reports that memory ran out, after the jump.
void report_full(Eval *ev);

// observe.c
// Keeps the value of a `let` or `param` where somebody wants to know; gives it back.
void observe_value(Eval *ev, const Env *env, AstId item, Value v);
static inline Value observe(Eval *ev, const Env *env, AstId item, Value v)
{
    if (ev->lang->observed) {
        observe_value(ev, env, item, v);
    }
    return v;
}

// loading.c
Module *module_load_text(Eval *ev, uint32_t file, bool is_library);
Module *module_new(Eval *ev, uint32_t file, bool is_library);
// Reads the imports of a module that was parsed.
void load_imports(Eval *ev, Module *module);
ParseLimits parse_limits(const Lang *lang);
void modules_free(Eval *ev);
// The slot of a name of the file itself, or -1.
int64_t module_find(const Module *module, Symbol name);
Span item_name_span(const Module *module, AstId item);
Symbol item_symbol(const Module *module, AstId item);

// early.c
// Loads the scene's own file, as module_load_text does, and evaluates on the way statements whose
// meaning doesn't depend on what follows. Sets ev->refused where that was no good: then all that
// was done is to be forgotten, and the whole file to be read before anything is evaluated.
Module *module_load_early(Eval *ev, uint32_t file);

// resolve.c: names to slots, kinds and fields to numbers; reports what can be known without
// running.
void resolve_module(Eval *ev, Module *module);

// eval.c
Value eval(Eval *ev, Env *env, AstId id);
Env *env_new(Eval *ev, Env *parent, Module *module, uint32_t slot_count);
// The value of a let, fn or param; evaluates it if need be.
Value force_slot(Eval *ev, Env *env, uint32_t slot, AstId item);
// True or false; an error for anything else.
typedef enum Truth { TRUTH_FALSE, TRUTH_TRUE, TRUTH_ERROR } Truth;
Truth eval_condition(Eval *ev, Env *env, AstId id, const char *what);
// Gives back what an evaluation left on the arena where its value is a plain number, unless a let
// that lives on was evaluated meanwhile.
typedef struct TidyMark {
    ArenaMark mark;
    uint64_t oldest_forced, first;
} TidyMark;
TidyMark tidy_begin(Eval *ev);
void tidy_end(Eval *ev, TidyMark mark, Value v);
// A list or range; an error for anything else.
Value eval_sequence(Eval *ev, Env *env, AstId id);
static inline Value sequence_item(Value sequence, uint32_t i)
{
    return sequence.type == VALUE_RANGE ? range_item(sequence, i) : sequence.items[i];
}
void push_value(Eval *ev, Value v);
// The values pushed since the stack held `base`, as a list; takes them off.
Value pop_list(Eval *ev, size_t base);
Value eval_member(Eval *ev, Env *env, AstId id);
Value eval_index(Eval *ev, Env *env, AstId id);

// operators.c
// E0412, with the number that isn't whole or what else it is.
void report_not_whole(Eval *ev, Span at, const char *rule, Value v);
Value eval_unary(Eval *ev, Env *env, AstId id);
// `a op b` for + - * / % and ^ of numbers, and the dimension of that; false where it has none.
double operator_apply(Operator op, double a, double b);
bool operator_dim(Operator op, uint8_t a, uint8_t b, uint8_t *out);
Value eval_binary(Eval *ev, Env *env, AstId id);
// E0706 where a "list" or "range" has more than `limits.list_length` items, or 2^32.
bool check_list_length(Eval *ev, const char *what, double count, Span at);
Value eval_range(Eval *ev, Env *env, AstId id);
Value eval_vector(Eval *ev, Env *env, AstId id);
Value make_vector(Eval *ev, const double *components, int count, uint8_t dim);
Value make_color(Eval *ev, double r, double g, double b);
Value make_transform(Eval *ev, const Affine *map);
Value make_string(Eval *ev, Str text, uint32_t module);
Value add_values(Eval *ev, Value a, Value b, Span at);
// -1, 0, 1; or 2 where they can't be ordered.
int compare_values(Value a, Value b);
// The steps of comparing these, where they are long strings; false as count_steps.
bool count_comparison(Eval *ev, Value a, Value b, Span at);
// `a op b` for == != < <= > >=: a bool, or an error.
Value compare_operands(Eval *ev, Operator op, Value a, Value b, Span at);
bool values_equal(Eval *ev, Value a, Value b, Span at);

// describe.c
// "a length", "a vector of 3", "the material `ggx`", … in `buffer`.
const char *describe_value(const Eval *ev, Value v, char *buffer, size_t size);
// What a parameter takes: "a length", "a power or a luminous flux", …
const char *describe_param(const Param *param, char *buffer, size_t size);
enum { DESCRIBE_SIZE = 160 };
// The value as it would be written (strings bare at the outside unless `quoted`), into a buffer.
typedef struct TextBuffer {
    char *text;
    size_t length, capacity;
    Span at; // for the report that a list is too much to be written
} TextBuffer;
void text_add(Eval *ev, TextBuffer *out, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void text_add_value(Eval *ev, TextBuffer *out, Value v, bool quoted);
// 15 digits, enough to show what was meant (0.1 + 0.2 is 0.3); whole numbers in full.
void format_number(double number, char *buffer, size_t size);

// call.c
Value eval_call(Eval *ev, Env *env, AstId id);
// The frame for a call of a closure, arguments bound; NULL after a report.
Env *bind_arguments(Eval *ev, Env *env, AstId call, const Closure *closure);
bool enter_call(Eval *ev, CallFrame *frame, const Closure *closure, Span at);
void leave_call(Eval *ev);
// Calls any function value; `at` for the chain.
Value call_value(Eval *ev, Value function, const Value *args, uint32_t count, Span at);
AstId fn_body(const Module *module, AstId fn);

// What a NAME or `namespace.name` stands for, where that is known already: VALUE_UNSET where it
// isn't.
Value peek_name(const Eval *ev, Env *env, AstId id);

// expect.c
// Runs an EXPECT: keeps in the scene whether it is met, and warns where it isn't.
void run_expect(Eval *ev, Env *env, AstId id);
// Keeps those of a file, too, that were never run.
void keep_unrun_expectations(Eval *ev, Module *module);
// measure_check.c: once the scene is made, whether what is to be measured is there.
void check_measures(Eval *ev);

// emit.c
void run_items(Eval *ev, Env *env, const uint32_t *items, uint32_t count);
void emit_expression(Eval *ev, Env *env, AstId id);
void emit_node(Eval *ev, const NodeValue *node);
Value collect_items(Eval *ev, Env *env, const uint32_t *items, uint32_t count);
typedef struct RegionMark {
    uint32_t region;
    ArenaMark mark;
    bool entered;
} RegionMark;
RegionMark region_enter(Eval *ev);
void region_leave(Eval *ev, RegionMark mark);
// The emitter for what lies in a group (or instance) with this transform (NULL: none) and material
// (NONE_ID: none).
Emitter nested_emitter(const Emitter *outer, const Affine *transform, uint32_t material);
uint32_t add_transform(Eval *ev, const Affine *transform, Span at);

// node.c
// Builds the value of a KIND node into *out; false after a report. With `keep_raw` it can be
// changed with `with` later.
bool build_node(Eval *ev, Env *env, AstId id, NodeValue *out, bool keep_raw);
Value eval_kind(Eval *ev, Env *env, AstId id);
Value eval_with(Eval *ev, Env *env, AstId id);
// The id of a material, texture, falloff, …; puts it into the scene on first need. Equal ones are
// shared.
uint32_t node_scene_id(Eval *ev, NodeValue *node);
// parts.c: measures a material or texture that was put into the scene; reports one that is too
// much.
void count_parts(Eval *ev, const NodeValue *node, uint32_t id);
// A texture made by arithmetic; op is "add", "subtract" or "multiply".
Value texture_arithmetic(Eval *ev, const char *op, Value a, Value b, Where where);
// The parameter struct with a kind's defaults.
const char *kind_defaults(Eval *ev, uint32_t type);
void kinds_init(Eval *ev);
int field_index(const Eval *ev, uint32_t type, Symbol name); // as FIELD.aux
void report_unknown_field(Eval *ev, uint32_t type, Symbol name, Span at);

// fill.c
// Stores a value as parameter `index` of a kind; false after a report at `where`.
bool fill_param(Eval *ev, NodeValue *node, int index, Value v, Where where);
bool fill_transform(Eval *ev, Value v, Where where, Affine *out);
const char *keep_string(Eval *ev, Str text);
bool check_dim(Eval *ev, const Param *param, Value v, Where where);
bool check_range(Eval *ev, const Param *param, const double *numbers, size_t count, uint8_t dim,
                 Where where);
bool wrong_type(Eval *ev, const Param *param, Value v, Where where);
// fill_list.c
bool fill_list(Eval *ev, const Param *param, void *out, Value v, Where where);

// params.c
Value eval_param(Eval *ev, Env *env, AstId item);
bool check_settings(Eval *ev, Module *module);

// builtins.c
// IEC 61966-2-1, odd about 0 so that colors outside the gamut stay what they are.
double decode_srgb(double c);
typedef struct Call {
    Eval *ev;
    Env *env; // NULL with node = 0 where no arguments stand in a source
    AstId node;
    Span at;
    const char *name;
    const Value *args;
    uint32_t count;
} Call;
typedef Value BuiltinFunction(Call *call);
typedef struct Builtin {
    const char *name;
    BuiltinFunction *function;
    uint8_t least, most;
} Builtin;
enum { ANY_COUNT = 255 };
extern const Builtin builtins[];
extern const uint32_t builtin_count;
Value call_builtin(Eval *ev, Env *env, AstId node, Span at, uint32_t builtin, const Value *args,
                   uint32_t count);
// The number of one of lang_constants, or -1.
int constant_find(Str name);
Value constant_value(const Eval *ev, uint32_t number);

#endif
