// Where functions lie in the program.
#ifndef BASE_HOT_H
#define BASE_HOT_H

#if defined(__GNUC__)
// What every ray or every sample goes through: the linker puts it side by side, so that it fits
// into the processor's cache of instructions, of which far apart pieces take more.
#define HOT __attribute__((hot))
// What few need stays out of the function that calls it: that one is smaller, and keeps its numbers
// in registers.
#define APART __attribute__((noinline))
#else
#define HOT
#define APART
#endif

#endif
