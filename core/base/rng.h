/* Random numbers as a function of a seed, a member and an index. There is no state, so that member
 * i of an ensemble is the same on every thread and in every order.
 * Leaves to others: the use of the numbers (api).
 * Invariant: the bits are the same on every machine, because only integer operations, additions,
 * products, quotients and square roots are used. */
#pragma once

#include <stdint.h>

/**
 * Applies the block cipher Philox 4x32 with 10 rounds of Salmon, Moraes, Dror and Shaw, "Parallel
 * random numbers: as easy as 1, 2, 3" (2011).
 *
 * counter  in and out: replaced by the four words of the result.
 * O(1).
 */
void pend_rng_philox(uint32_t counter[4], const uint32_t key[2]);

/** Returns random number `place` of member `i` under a seed: uniform in [0, 1), a multiple of
 * 2^-53. O(1). */
double pend_rng_uniform(uint64_t seed, uint64_t i, uint32_t place);

/** Returns random number `place` of member `i` under a seed, from the normal distribution with mean
 * 0 and standard deviation 1: the inverse of the distribution function (Wichura's algorithm AS
 * 241), to within 1e-15, from -8.3 to 8.3. O(1). */
double pend_rng_normal(uint64_t seed, uint64_t i, uint32_t place);
