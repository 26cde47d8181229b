// The schema: which kinds there are, which fields each takes, of what type, dimension, range and
// default. One table, for the evaluator's checks, did-you-mean, `explain`, the generated manual,
// the JSON dump of a scene, the exporters and the editors.
//
// A kind is a NodeType; its fields are Params. A Param says where its value lies in the kind's
// parameter struct, so that filling, dumping and comparing parameters needs no code for a kind.
#ifndef SCHEMA_SCHEMA_H
#define SCHEMA_SCHEMA_H

#include "base/diag.h"
#include "base/str.h"
#include "base/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// --- Dimensions of a quantity ---------------------------------------------------------------

// DIMENSION(id, name, SI unit) and UNIT(text, dimension, factor to SI).
#define DIMENSIONS(DIMENSION)                                                                      \
    DIMENSION(NONE, "number", "")                                                                  \
    DIMENSION(ANGLE, "angle", "rad")                                                               \
    DIMENSION(LENGTH, "length", "m")                                                               \
    DIMENSION(TIME, "time", "s")                                                                   \
    DIMENSION(TEMPERATURE, "temperature", "K")                                                     \
    DIMENSION(POWER, "power", "W")                                                                 \
    DIMENSION(LUMINOUS_FLUX, "luminous flux", "lm")                                                \
    DIMENSION(LUMINOUS_INTENSITY, "luminous intensity", "cd")                                      \
    DIMENSION(ILLUMINANCE, "illuminance", "lx")                                                    \
    DIMENSION(LUMINANCE, "luminance", "nit")

typedef enum Dim {
#define DIMENSION(id, name, unit) DIM_##id,
    DIMENSIONS(DIMENSION)
#undef DIMENSION
        DIM_COUNT
} Dim;

#define DIM_BIT(dim) (1u << (dim))

typedef struct DimInfo {
    const char *name, *si_unit;
} DimInfo;

typedef struct UnitInfo {
    const char *name;
    Dim dim;
    double factor; // value in SI = number * factor
} UnitInfo;

const DimInfo *dim_info(Dim dim);
// All units, in the order of the manual.
extern const UnitInfo schema_units[];
extern const size_t schema_unit_count;
// The unit written `name`, or NULL.
const UnitInfo *unit_find(Str name);

// --- Categories ----------------------------------------------------------------------------

// CATEGORY(id, name): what a kind's value is.
#define CATEGORIES(CATEGORY)                                                                       \
    CATEGORY(SHAPE, "shape")                                                                       \
    CATEGORY(MATERIAL, "material")                                                                 \
    CATEGORY(TEXTURE, "texture")                                                                   \
    CATEGORY(LIGHT, "light")                                                                       \
    CATEGORY(FALLOFF, "falloff")                                                                   \
    CATEGORY(ATTENUATION, "attenuation")                                                           \
    CATEGORY(CAMERA, "camera")                                                                     \
    CATEGORY(RULE, "rule")                                                                         \
    CATEGORY(SETTING, "setting")

typedef enum Category {
#define CATEGORY(id, name) CATEGORY_##id,
    CATEGORIES(CATEGORY)
#undef CATEGORY
        CATEGORY_COUNT
} Category;

const char *category_name(Category category);

// --- Parameters ----------------------------------------------------------------------------

#define NONE_ID UINT32_MAX // "no node" wherever a node's id may stand

// A number with the dimension that the author gave it (DIM_NONE for a bare one), in SI.
typedef struct Quantity {
    double value;
    uint32_t dim;
} Quantity;

// A value that may come from a texture: where texture != NONE_ID it is the texture's value times
// `value` (which is then 1), else `value` itself.
typedef struct NumberTex {
    double value;
    uint32_t texture;
} NumberTex;
typedef struct ColorTex {
    Rgb value;
    uint32_t texture;
} ColorTex;
typedef struct PairTex {
    Vec2 value;
    uint32_t texture;
} PairTex;
// Radiance or irradiance: a number (bare or photometric), to be multiplied by the light's color; or
// a color in SI; or a texture.
typedef struct Emission {
    Rgb value;        // a number is spread over the three
    uint32_t dim;     // DIM_NONE, or the photometric dimension of a number
    uint32_t texture; // or NONE_ID
    bool is_number;
} Emission;

typedef struct NumberList {
    double *items;
    uint32_t count;
} NumberList;
typedef struct Vec3List {
    Vec3 *items;
    uint32_t count;
} Vec3List;
typedef struct Vec2List {
    Vec2 *items;
    uint32_t count;
} Vec2List;
typedef struct RgbList {
    Rgb *items;
    uint32_t count;
} RgbList;
// Faces as runs of indices: face f has sizes[f] indices, one after another in `indices`.
typedef struct FaceList {
    uint32_t *indices, *sizes;
    uint32_t index_count, count;
} FaceList;
typedef struct StringList {
    const char **items;
    uint32_t count;
} StringList;

// PARAM_TYPE(id, C type that the value is stored as, name in the manual)
#define PARAM_TYPES(PARAM_TYPE)                                                                    \
    PARAM_TYPE(BOOL, bool, "bool")                                                                 \
    PARAM_TYPE(INT, int64_t, "whole number")                                                       \
    PARAM_TYPE(NUMBER, double, "number")       /* of Param.dims[0] */                              \
    PARAM_TYPE(QUANTITY, Quantity, "quantity") /* of any of Param.dims */                          \
    PARAM_TYPE(PAIR, Vec2, "number or pair")                                                       \
    PARAM_TYPE(VEC2, Vec2, "vector of 2")                                                          \
    PARAM_TYPE(VEC3, Vec3, "vector of 3")                                                          \
    PARAM_TYPE(COLOR, Rgb, "color")                                                                \
    PARAM_TYPE(EMISSION, Emission, "quantity or color")                                            \
    PARAM_TYPE(NUMBER_TEX, NumberTex, "number or texture")                                         \
    PARAM_TYPE(PAIR_TEX, PairTex, "number, pair or texture")                                       \
    PARAM_TYPE(COLOR_TEX, ColorTex, "color or texture")                                            \
    PARAM_TYPE(STRING, const char *, "string")                                                     \
    PARAM_TYPE(CHOICE, int32_t, "one of a list") /* index into Param.choices */                    \
    PARAM_TYPE(FILE, const char *, "file")       /* path from which to open it */                  \
    PARAM_TYPE(NODE, uint32_t, "node")           /* id of Param.category, or NONE_ID */            \
    PARAM_TYPE(NUMBER_LIST, NumberList, "list of numbers")                                         \
    PARAM_TYPE(VEC2_LIST, Vec2List, "list of vectors of 2")                                        \
    PARAM_TYPE(VEC3_LIST, Vec3List, "list of vectors of 3")                                        \
    PARAM_TYPE(COLOR_LIST, RgbList, "list of colors")                                              \
    PARAM_TYPE(FACE_LIST, FaceList, "list of lists of indices")                                    \
    PARAM_TYPE(STRING_LIST, StringList, "list of strings")

typedef enum ParamType {
#define PARAM_TYPE(id, type, name) PARAM_##id,
    PARAM_TYPES(PARAM_TYPE)
#undef PARAM_TYPE
        PARAM_TYPE_COUNT
} ParamType;

size_t param_type_size(ParamType type);
const char *param_type_name(ParamType type);

typedef enum ParamFlags {
    PARAM_REQUIRED = 1,
    PARAM_NO_DEFAULT = 2,  // may be left out, and then counts as not set (see NodeFinish.set)
    PARAM_EXCLUDE_MIN = 4, // the value must be greater than min
    PARAM_EXCLUDE_MAX = 8,
    PARAM_UNIT_VECTOR = 16, // a direction: must not be zero; stored normalized
} ParamFlags;

typedef struct Param {
    const char *name;
    ParamType type;
    size_t offset; // of the value in the kind's parameter struct
    uint32_t flags;
    uint32_t dims;   // DIM_BIT()s that a number may have; a bare number is taken in the SI
                     // unit of the field (documented in `si`) unless only DIM_ANGLE is set
    const char *si;  // the unit of a bare number where it isn't the dimension's own ("W/sr")
    double min, max; // inclusive range of each component; both 0: any finite number
    // The default as it would be written in a scene: "1", "rgb(1, 1, 1)", "40deg", "(0, 1, 0)",
    // "\"perspective\"", "lambert {}". NULL with PARAM_REQUIRED or PARAM_NO_DEFAULT.
    const char *default_text;
    const char *const *choices; // PARAM_CHOICE: the strings, NULL at the end
    Category category;          // PARAM_NODE
    const char *doc;            // one line of manual
} Param;

// For tables: PARAM_FIELD(Sphere, radius) gives offset; use with designated initialisers, e.g.
//     {.name = "radius", .type = PARAM_NUMBER, PARAM_AT(Sphere, radius), .dims =
//     DIM_BIT(DIM_LENGTH),
//      .min = 0, .max = INFINITY, .flags = PARAM_EXCLUDE_MIN, .default_text = "1", .doc = "…"}
#define PARAM_AT(Struct, member) .offset = offsetof(Struct, member)

// --- Kinds -----------------------------------------------------------------------------------

typedef struct NodeType NodeType;
struct Scene;

// What a kind's `finish` is given when all fields are in place.
typedef struct NodeFinish {
    const NodeType *type;
    void *params;        // the kind's parameter struct, filled; may be changed
    uint64_t set;        // bit i: the author gave type->params[i]
    struct Scene *scene; // where the node will be kept (for meshes and files)
    Rgb color;           // lights: the light's `color`
    // Reports at field `param` (an index, or -1 for the node as a whole); returns the diagnostic so
    // that a note can be added with `sink`. Reporting an error makes the node fail.
    Diag *(*report)(struct NodeFinish *self, int param, DiagCode code, const char *format, ...)
        __attribute__((format(printf, 4, 5)));
    // Where field `param` (or, for -1, the node) stands in the source; may be NULL.
    Span (*place)(struct NodeFinish *self, int param);
    DiagSink *sink;
    void *caller; // the evaluator's own
} NodeFinish;

// How the language treats a kind beyond filling its fields.
typedef enum NodeRole {
    ROLE_PLAIN,
    ROLE_GROUP,    // takes items; is flattened
    ROLE_INSTANCE, // takes `of`; shares geometry
} NodeRole;

struct NodeType {
    const char *name;
    Category category;
    NodeRole role;
    const Param *params; // at most 60, and not the common ones (below)
    size_t param_count;
    size_t size;         // of the parameter struct
    bool internal;       // can't be written in a scene (made by texture arithmetic, …)
    const char *doc;     // a sentence or two
    const char *formula; // plain text, with its source; may be NULL
    // A scene of about ten lines that can be rendered where examples/ is the folder: the manual's
    // picture is made of it. May be NULL.
    const char *example;
    // Checks what a table can't (one of two fields, no zero edge, …) and derives what the renderer
    // wants (min and max from center and size, …). May be NULL. False: the node is not to be kept,
    // which needs at least one error reported.
    bool (*finish)(NodeFinish *finish);
    // Shapes: the box around one with these parameters, in its own space; infinite where it has no
    // end. For `bounds(shape)`; NULL: unknown.
    Box3 (*bounds)(const struct Scene *scene, const void *params);
    // Shapes that are triangles: which of the scene's meshes holds them. NULL: another shape.
    uint32_t (*mesh)(const void *params);
};

// The fields that every kind of a category takes beside its own; they are stored in the SceneNode
// (scene/scene.h), not in the parameter struct.
typedef enum CommonField {
    COMMON_TRANSFORM = 1, // shape, light, camera
    COMMON_MATERIAL = 2,  // shape
    COMMON_NAME = 4,      // shape, light, camera, material
    COMMON_COLOR = 8,     // light
} CommonField;
uint32_t category_common_fields(Category category);
// "transform", "material", "name", "color" and their manual line.
const char *common_field_name(CommonField field);
const char *common_field_doc(CommonField field);

// All kinds of a program; made once by whoever links them (render/nodes.c) and passed down. Types
// are numbered by their place.
typedef struct Schema {
    const NodeType *const *types;
    size_t type_count;
} Schema;

// The number of the kind called `name`, or -1. Internal kinds are found, too: whoever reads scenes
// refuses them.
int schema_find(const Schema *schema, Str name);
// The index of the parameter called `name`, or -1.
int node_type_find_param(const NodeType *type, Str name);
// The nearest kind (of `category`, or of any if CATEGORY_COUNT) to a misspelt name, or NULL.
const char *schema_suggest_type(const Schema *schema, Str name, Category category);
// The nearest field (common ones included) of a kind, or NULL.
const char *node_type_suggest_param(const NodeType *type, Str name);
// Checks a table for the mistakes that people make in tables (names twice, offsets beyond the
// struct, values that overlap, empty ranges, missing docs, more than 60 parameters). NULL if it is
// sound, else `message`, which then says what is wrong; for tests.
const char *schema_check(const Schema *schema, char *message, size_t message_size);

#endif
