// Values of the language: 16 bytes with a tag; numbers, bools and ranges unboxed, the rest a
// pointer to something immutable in an arena of the evaluator.
#ifndef LANG_VALUE_H
#define LANG_VALUE_H

#include "base/str.h"
#include "base/vec.h"
#include "lang/ast.h"
#include "schema/schema.h"

typedef enum ValueType {
    VALUE_UNSET,   // a slot whose `let` was not evaluated yet
    VALUE_FORCING, // … is being evaluated
    VALUE_ERROR,   // what an error left; every operation on it gives it again, silently
    VALUE_NOTHING, // what print and assert give
    VALUE_BOOL,
    VALUE_NUMBER,
    VALUE_STRING,
    VALUE_VECTOR,
    VALUE_COLOR,
    VALUE_LIST,
    VALUE_RANGE,
    VALUE_FUNCTION,
    VALUE_BUILTIN,
    VALUE_NODE,
    VALUE_TRANSFORM,
    VALUE_BOUNDS,
    VALUE_SIGHT,   // where something is measured
    VALUE_MEASURE, // what is measured
} ValueType;

typedef struct Closure Closure;
typedef struct MeasureNode MeasureNode;
typedef struct NodeValue NodeValue;

typedef struct Value {
    uint8_t type;   // ValueType
    uint8_t dim;    // numbers and vectors: Dim; the numbers are in SI
    uint16_t small; // vectors: components (2 to 4); measures: 1 or 3; strings: number of the module
                    // that wrote it
    uint32_t count; // lists and ranges: items; strings: bytes; builtins: which
    union {
        double number; // numbers; ranges: the first item, a whole number
        bool boolean;
        const char *string;       // NUL-terminated
        const double *components; // vectors and colors (3, linear Rec.709)
        const struct Value *items;
        Closure *function;
        NodeValue *node;
        const Affine *transform;
        const Box3 *bounds;
        const struct Sight *sight;
        const MeasureNode *measure;
    };
} Value;

_Static_assert(sizeof(Value) == 16, "a Value is 16 bytes");

// A value of a kind. Its parameter struct lies in the same arena; ids inside refer to the scene.
struct NodeValue {
    uint16_t type;           // number in the schema
    uint32_t scene_id;       // materials, textures, …: id once kept in the scene; else NONE_ID
    uint64_t set;            // bit i: the author gave params[i]
    void *params;            // as the scene keeps them
    const void *raw;         // before the kind's `finish`: what `with` starts from
    const Affine *transform; // NULL: the identity
    NodeValue *material;     // NULL: none given
    Str name;                // empty: none
    Rgb color;               // lights
    Span at;
    const Value *items; // groups: NODEs
    uint32_t item_count;
    NodeValue *of;               // instances: what is instanced; area lights: their shape
    struct PrototypeRecord *own; // as a prototype, once it was instanced
};

static inline Value value_error(void)
{
    return (Value){.type = VALUE_ERROR};
}
static inline Value value_nothing(void)
{
    return (Value){.type = VALUE_NOTHING};
}
static inline Value value_number(double number, uint8_t dim)
{
    return (Value){.type = VALUE_NUMBER, .dim = dim, .number = number};
}
static inline Value value_bool(bool boolean)
{
    return (Value){.type = VALUE_BOOL, .boolean = boolean};
}
static inline Value value_node(NodeValue *node)
{
    return (Value){.type = VALUE_NODE, .node = node};
}
static inline bool is_error(Value v)
{
    return v.type == VALUE_ERROR;
}
// True for a number without a dimension.
static inline bool is_bare(Value v)
{
    return v.type == VALUE_NUMBER && v.dim == DIM_NONE;
}
// True where the value points to nothing, so that it survives rewinding an arena.
static inline bool is_unboxed(Value v)
{
    return v.type <= VALUE_NUMBER || v.type == VALUE_RANGE || v.type == VALUE_BUILTIN;
}
static inline Value range_item(Value range, uint32_t i)
{
    return value_number(range.number + i, DIM_NONE);
}

#endif
