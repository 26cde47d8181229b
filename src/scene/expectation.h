// What a scene expects of itself: its `expect` statements, as far as the evaluator could judge
// them. `scnrender test` reports them, and measures what only light can tell.
#ifndef SCENE_EXPECTATION_H
#define SCENE_EXPECTATION_H

#include "base/array.h"
#include "base/source.h"

#include <stdint.h>

// A part of the expectation's text and what it stands for: "len(xs)", "4".
typedef struct ExpectationPart {
    const char *text, *value;
} ExpectationPart;

// One `expect`, however often it was run: in a loop, or in a function that is called again.
typedef struct SceneExpectation {
    Span at;               // from the word `expect` to its end
    uint64_t times, fails; // how often it was run, and how often it wasn't met then
    // Of the first time that it wasn't met:
    Span wrong_at;     // the part that doesn't hold
    const char *wrong; // "4 is not 3"
    ExpectationPart *parts;
    uint32_t part_count;
} SceneExpectation;

typedef ARRAY(SceneExpectation) SceneExpectationArray;

#endif
