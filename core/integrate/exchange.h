/* What a pendulum is given by drives and loses by friction in a motion by power series: the
 * integral of a power, step by step. Leaves to others: the power's series (jets, extended), which
 * motions have one (terms). Invariant: the sum is compensated, so that a million steps add no more
 * than their own rounding. */
#ifndef PEND_EXCHANGE_H
#define PEND_EXCHANGE_H

#include "core/base/checkpoint.h"

enum { PEND_EXCHANGE_ORDERS = 80 };

/* J: up to the start of the last step, as a sum of two, and the series of the power since, over the
 * square of the unit. */
struct pend_given {
    double sum, low;
    double series[PEND_EXCHANGE_ORDERS];
};

struct pend_exchange {
    int order;   /* coefficients of both series, at most PEND_EXCHANGE_ORDERS */
    double unit; /* s, of the last step */
    struct pend_given work, heat;
};

/** Returns what the series has given x units after the start of the step, J. O(order). */
static inline double pend_given_inside(const struct pend_exchange *exchange,
                                       const struct pend_given *given, double x) {
    double sum = 0, inverse = 1 / exchange->unit;
    for (int j = exchange->order - 1; j >= 0; j--)
        sum = sum * x + given->series[j] * (1.0 / (j + 1));
    return sum * x * (inverse * inverse);
}

/** Returns all that was given x units after the start of the last step, J. O(order). */
static inline double pend_given_at(const struct pend_exchange *exchange,
                                   const struct pend_given *given, double x) {
    return given->sum + (given->low + pend_given_inside(exchange, given, x));
}

/** Adds a step that has ended after x units. */
static inline void pend_exchange_add(struct pend_exchange *exchange, double x) {
    struct pend_given *both[] = {&exchange->work, &exchange->heat};
    for (int i = 0; i < 2; i++) {
        double add = pend_given_inside(exchange, both[i], x) + both[i]->low;
        double sum = both[i]->sum + add;
        both[i]->low = add - (sum - both[i]->sum);
        both[i]->sum = sum;
    }
}

/** Shows the sums to a checkpoint; the series of the last step are computed again. */
static inline void pend_exchange_carry(struct pend_exchange *exchange,
                                       struct pend_checkpoint *checkpoint) {
    double *sums[] = {&exchange->work.sum, &exchange->work.low, &exchange->heat.sum,
                      &exchange->heat.low};
    for (int i = 0; i < 4; i++) pend_checkpoint_row(checkpoint, sums[i], 1);
}

#endif
