// What a scene expects of itself: its `expect` statements, as far as the evaluator could judge
// them. `scnrender test` reports them, and measures what only light can tell.
#ifndef SCENE_EXPECTATION_H
#define SCENE_EXPECTATION_H

#include "base/array.h"
#include "base/source.h"
#include "base/vec.h"

#include <stdint.h>

// --- Measures ------------------------------------------------------------------------------------

// Where rays for a measure come from.
typedef enum SightKind {
    SIGHT_CAMERA, // through a rectangle of a camera's picture
    SIGHT_RAY,    // one given ray
} SightKind;

typedef struct Sight {
    SightKind kind;
    double x0, y0, x1, y1;  // CAMERA: pixels from the top left corner
    const char *camera;     // its name, or NULL: the one that is used for the picture
    uint32_t camera_id;     // of that name; NONE_ID: the one that is used for the picture
    Vec3 origin, direction; // RAY: direction of length 1
    const char *object;     // only where shapes of this name are seen first; NULL: everywhere
    Span at;                // where it was written
} Sight;

// The mean of a sight's rays.
typedef struct MeasureLeaf {
    Sight sight;
    bool coverage; // 1 where the object is seen, else 0; or the radiance there, and 0 elsewhere
} MeasureLeaf;

// A value made of such means, in three channels.
typedef enum MeasureOp {
    MEASURE_LEAF,     // leaf number a
    MEASURE_CONSTANT, // `constant`
    MEASURE_ADD,      // of steps a and b
    MEASURE_SUBTRACT,
    MEASURE_MULTIPLY,
    MEASURE_DIVIDE,
    MEASURE_LUMINANCE, // of step a, in each channel
    MEASURE_CHANNEL,   // channel b of step a, in each channel
} MeasureOp;

typedef struct MeasureStep {
    MeasureOp op;
    uint32_t a, b; // steps before this one
    double constant[3];
} MeasureStep;

typedef enum MeasureRelation {
    MEASURE_WITHIN, // no farther than `allowed` from `target`
    MEASURE_BELOW,
    MEASURE_ABOVE,
} MeasureRelation;

// What is measured, and what it must be.
typedef struct SceneMeasure {
    MeasureLeaf *leaves;
    uint32_t leaf_count;
    MeasureStep *steps; // the last one is the value
    uint32_t step_count;
    uint32_t channels; // that count: 1 or 3
    MeasureRelation relation;
    double target[3], allowed; // allowed: in the target's unit
    double percentage;         // that `allowed` was written as; 0: it was written as it is
    const char *unit;          // of the value, to be shown: "" or "nit"
    // What the value is, where it isn't what stands before `within` or the comparison: "the ratio",
    // "the difference"; or NULL.
    const char *what;
} SceneMeasure;

// --- Expectations --------------------------------------------------------------------------------

// A part of the expectation's text and what it stands for: "len(xs)", "4".
typedef struct ExpectationPart {
    const char *text, *value;
} ExpectationPart;

// One `expect`, however often it was run: in a loop, or in a function that is called again. Where
// light is to be measured, each run of it is one of these.
typedef struct SceneExpectation {
    Span at;                     // from the word `expect` to its end
    uint64_t times, fails;       // how often it was run, and how often it wasn't met then
    const SceneMeasure *measure; // what is still to be found out; or NULL
    // Of the first time that it wasn't met:
    Span wrong_at;     // the part that doesn't hold
    const char *wrong; // "4 is not 3"
    // The values in it, where it wasn't met or is to be measured.
    ExpectationPart *parts;
    uint32_t part_count;
} SceneExpectation;

typedef ARRAY(SceneExpectation) SceneExpectationArray;

#endif
