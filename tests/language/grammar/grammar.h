// Reads grammar/scn.ebnf and writes random sentences of it.
#ifndef TESTS_GRAMMAR_H
#define TESTS_GRAMMAR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct Random {
    uint64_t state;
} Random;
uint64_t random_next(Random *random);
// 0 … count - 1.
uint32_t random_below(Random *random, uint32_t count);

typedef enum PartTag {
    PART_TEXT,   // characters
    PART_RANGE,  // one character from first to last
    PART_RULE,   // another rule
    PART_ROW,    // children, one after another
    PART_CHOICE, // one of the children
    PART_OPTION, // the child or nothing
    PART_REPEAT, // the child any number of times
    PART_BUT,    // the first child, but not what the second gives
} PartTag;

typedef struct Part {
    PartTag tag;
    char *text; // TEXT; RULE: its name
    uint32_t first, last;
    struct Part **children;
    size_t child_count;
    size_t rule;     // RULE: index
    unsigned depth;  // least depth of rules needed to finish
    uint64_t *taken; // CHOICE: how often each child was taken; OPTION, REPEAT: [0] not, [1] taken
} Part;

typedef struct Rule {
    char *name;
    Part *body;
    bool token; // upper case
    unsigned depth;
    uint64_t used;
} Rule;

typedef struct Grammar {
    Rule *rules;
    size_t count;
    size_t blank, name, number, unit, reserved; // indices of rules with a special meaning here
} Grammar;

// Reads the file; exits with a message where it isn't sound.
Grammar grammar_read(const char *path);
void grammar_free(Grammar *grammar);

// Bounds of one sentence. A production may have parts that cost more than `depth` allows; then the
// shortest way out is taken.
typedef struct Bounds {
    unsigned depth; // of rules
    size_t size;    // bytes, about
} Bounds;

// A sentence, NUL-terminated (it holds no NUL), to be freed; its length in *length.
char *grammar_sentence(Grammar *grammar, Random *random, Bounds bounds, size_t *length);

// Prints rules and alternatives that no sentence has used so far; returns how many.
size_t grammar_print_unused(const Grammar *grammar);

#endif
