/* Random numbers that are a function of a seed, a number and a place: no state, so that member i
 * of an ensemble is the same wherever and whenever it is drawn. Leaves to others: what is drawn
 * (api).
 * Invariant: the same bits on every machine: additions, products and square roots only. */
#ifndef PEND_RNG_H
#define PEND_RNG_H

#include <stdint.h>

/**
 * The block cipher Philox 4x32 with 10 rounds of Salmon, Moraes, Dror and Shaw, "Parallel random
 * numbers: as easy as 1, 2, 3" (2011).
 *
 * counter  replaced by the four words of the result.
 */
void pend_rng_philox(uint32_t counter[4], const uint32_t key[2]);

/** A number in [0, 1), a multiple of 2^-53: value `place` of member `i` under a seed. */
double pend_rng_uniform(uint64_t seed, uint64_t i, uint32_t place);

/**
 * A number of the normal distribution with mean 0 and deviation 1, by the inverse of its
 * distribution function (Wichura's algorithm AS 241): within 1e-15, from -8.3 to 8.3.
 */
double pend_rng_normal(uint64_t seed, uint64_t i, uint32_t place);

#endif
