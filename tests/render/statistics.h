// Statistics for tests whose results are random. Every test states its significance; a family of K
// tests at the whole's α uses α' of Šidák.
#ifndef TEST_STATISTICS_H
#define TEST_STATISTICS_H

#include "base/statistics.h"

#include <stdbool.h>
#include <stdint.h>

#define NEAR(a, b, tolerance) (fabs((double)(a) - (double)(b)) <= (tolerance))

// A generator for tests: PCG32 (O'Neill 2014).
typedef struct TestRandom {
    uint64_t state;
} TestRandom;

static inline uint32_t test_random_u32(TestRandom *random)
{
    uint64_t old = random->state;
    random->state = old * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(((old >> 18) ^ old) >> 27), turn = (uint32_t)(old >> 59);
    return (x >> turn) | (x << (-turn & 31));
}
static inline float test_random(TestRandom *random)
{
    return (float)(test_random_u32(random) >> 8) * 0x1p-24f;
}

#endif
