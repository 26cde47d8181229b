// The program run on hostile input, and what that cost: time of the processor (which the load of
// the machine doesn't change much), and the most memory that it held.
#ifndef TESTS_PROGRAM_H
#define TESTS_PROGRAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { ERRORS_KEPT = 1 << 16, MOST_ARGUMENTS = 15 };

typedef struct ProgramRun {
    int status; // exit status; minus the number of the signal that ended it; -9 after `seconds`
    double cpu_seconds;
    long peak_kib;
    char errors[ERRORS_KEPT]; // the beginning of its standard error, NUL-terminated
} ProgramRun;

// Runs `program` with arguments (NULL at the end) in `folder` (NULL: here); its output is thrown
// away. It is killed after so many seconds on the clock.
void program_run(const char *program, const char *const *arguments, const char *folder,
                 unsigned seconds, ProgramRun *out);

// Writes a file of so many bytes; ends the test where that fails.
void program_write(const char *folder, const char *name, const char *bytes, size_t size);

// A number of 31 bits that seems random, always the same from the same state.
uint32_t program_random(uint64_t *state);

// What cost most of all runs.
typedef struct Worst {
    double seconds;
    long kib;
    char slowest[100], largest[100];
} Worst;
void worst_take(Worst *worst, const ProgramRun *run, const char *name);

// Of many cases only each `every`th is run: the test's third argument, 1 where there is none.
bool program_takes(int argc, char **argv, unsigned number);

// Under sanitizers everything takes longer, and memory says nothing.
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
static const double slower = 20;
static const bool counts_memory = false;
#else
static const double slower = 1;
static const bool counts_memory = true;
#endif

#endif
