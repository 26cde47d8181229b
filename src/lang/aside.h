// Statements evaluated beside one another, in threads.
//
// The iterations of a loop, and statements that repeat one another, are cut into units. Each unit
// is evaluated by an evaluator of its own, which reads what the whole has, and writes into a scene
// of its own; then the scenes are joined in the order of the units. What comes out is what would
// have come out in order, to the last id.
//
// That is so because values never change, and because a unit ends, with all that it did forgotten
// (must_be_alone), where it would have to touch something that isn't its own: a diagnostic, a
// limit, a `let` outside of it that has no value yet, a material that isn't in the scene yet, a
// prototype, a name, a file, a light. Then it and the units behind it are evaluated in order, as
// ever. So diagnostics come as if no thread had been there.
#ifndef LANG_ASIDE_H
#define LANG_ASIDE_H

#include "lang/eval.h"

// Evaluates unit `unit` into `ev`; `worker` counts the threads. False where it stopped before its
// end, with all that it did whole.
typedef bool AsideWork(Eval *ev, void *context, uint32_t unit, unsigned worker);

// A loop's iterations: of items, or of a list's elements, which go on Eval.stack.
typedef struct Loop {
    Env *env;
    AstId id;
    Value sequence;
    // Does iteration i; false where the run is to stop.
    bool (*iteration)(Eval *ev, const struct Loop *loop, uint32_t i);
    struct ListMaker *list; // NULL: of items
    uint32_t next, unit;    // loop_run's: the first that wasn't done, and how many are a unit
} Loop;
typedef struct ListMaker {
    size_t base; // of Eval.stack
    bool failed;
} ListMaker;

// Runs the loop, beside one another what is worth it.
void loop_run(Eval *ev, Loop *loop);

// How many units are to be given at a time; 0 where everything has to go in order.
uint32_t aside_units(const Eval *ev);
// Evaluates units 0 to count - 1 and returns how many of them, from the first on, are in the scene
// now. A unit that stopped before its end is the last of these.
uint32_t aside_run(Eval *ev, AsideWork *work, void *context, uint32_t count);
// So much work, in steps, is worth the threads' start; and is a unit.
uint64_t aside_least(const Eval *ev);
enum { ASIDE_UNIT_STEPS = 1 << 16 };

#endif
