// Runs of the program in which the system fails: the Nth system call of some kind, answered with an
// error by way of seccomp's user notification (Linux 5.5), or the Nth allocation (allocations.c).
#ifndef TESTS_FAULTS_H
#define TESTS_FAULTS_H

#include <stdbool.h>
#include <stdint.h>

typedef enum FaultKind {
    FAULT_NONE,
    FAULT_ALLOCATION, // of the program's own
    FAULT_PAGES,      // mmap without a file: large blocks, threads' stacks
    FAULT_THREAD,     // a new thread
    FAULT_OPEN,       // any file, once the scene has been opened: modules and their libraries, too
    FAULT_READ,       // of a regular file
    FAULT_WRITE,      // to a regular file or the standard output: no space
    FAULT_FLUSH,      // fsync and its like
    FAULT_RENAME,     // rename
    FAULT_LINK,       // a name for a file that had none
    FAULT_CLOSE,      // close of a regular file that was written
} FaultKind;

typedef struct FaultRun {
    int status;     // exit status; minus the number of the signal that ended it
    uint64_t count; // how many calls of that kind there were
    int64_t live;   // FAULT_ALLOCATION: blocks that were never given back; -1: it didn't say
    char errors[1 << 14];
} FaultRun;

// Runs the program in `folder`; the call number `at` (from 1; 0: none) of `kind` fails, and with
// `goes_on` all later ones. False where the system has no such means.
bool fault_run(const char *const *command, const char *folder, FaultKind kind, uint64_t at,
               bool goes_on, FaultRun *out);
// A shared library made from allocations.c; to be set first.
extern const char *fault_preload;

#endif
