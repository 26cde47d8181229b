// Functions that are compiled twice, for any processor and for those with AVX2; the better one is
// chosen when the program starts. Both compute the same: nothing is contracted or reassociated.
#ifndef BASE_CLONES_H
#define BASE_CLONES_H

#include <stdint.h> // for __GLIBC__: the choice is the dynamic linker's

#ifdef __has_feature
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define CLONES_SANITIZED // the choice would run before the sanitizer is ready
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define CLONES_SANITIZED
#endif

#if defined(__x86_64__) && defined(__linux__) && defined(__GLIBC__) && !defined(CLONES_SANITIZED)
#define VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define VECTOR_CLONES
#endif

// Vectors larger than what every processor has can't be passed to functions, inlined ones included,
// but by pointers: the convention for it depends on the processor.

#endif
